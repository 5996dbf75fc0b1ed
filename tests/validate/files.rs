//! Damage to documents, files and tables is reported as that kind, and nothing panics.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use crate::damaged::{DATA, EXR, MANIFEST, after, agree, check, edit_json, rewrite};
use arrow_array::RecordBatch;
use dataset::Dataset;
use dataset::validate::Code;
use output_schema::file::asset_path;
use output_schema::{AssetHead, DatasetHead};
use recipe::asset::Asset;
use serde_json::Value;
use test_support::records::{SIZE, head, output, write_dataset};

#[test]
fn documents() {
    use Code::*;
    assert_eq!(after(|root| fs::remove_file(root.join("dataset.json")).expect("there")), [DatasetMissing]);
    assert_eq!(after(|root| fs::write(root.join("dataset.json"), "[").expect("written")), [DatasetUnreadable]);
    assert_eq!(
        after(|root| edit_json(&root.join("dataset.json"), |v| v["format"] = "tiff".into())),
        [DatasetUnreadable]
    );
    assert_eq!(after(|root| edit_json(&root.join("dataset.json"), |v| v["shards"] = 7.into())), [DatasetUnreadable]);
    let newer = |v: &mut Value| v["schema_version"] = serde_json::json!([2, 0]);
    assert_eq!(after(|root| edit_json(&root.join("dataset.json"), newer)), [VersionUnknown]);
    assert!(after(|root| fs::remove_file(root.join(MANIFEST)).expect("there")).contains(&ManifestMissing));
    assert!(after(|root| fs::write(root.join(MANIFEST), "{}").expect("written")).contains(&ManifestUnreadable));
    assert_eq!(after(|root| edit_json(&root.join(MANIFEST), |v| v["seed"] = 5.into())), [ManifestDiffers]);
    assert_eq!(after(|root| edit_json(&root.join(MANIFEST), |v| v["count"] = 3.into())), [ManifestDiffers]);
    assert_eq!(after(|root| edit_json(&root.join(MANIFEST), newer)), [VersionUnknown]);
    // A newer manifest may have other keys: still its version is what is told.
    let other = |v: &mut Value| *v = serde_json::json!({ "format": v["format"], "schema_version": [2, 0] });
    assert!(after(|root| edit_json(&root.join(MANIFEST), other)).contains(&VersionUnknown));
    let outside = |v: &mut Value| v["files"][0]["path"] = "../../etc/passwd".into();
    assert!(after(|root| edit_json(&root.join(MANIFEST), outside)).contains(&ManifestDiffers));
}

#[test]
fn files() {
    use Code::*;
    for path in [DATA, EXR, "stacks/00000.parquet"] {
        assert!(after(|root| fs::remove_file(root.join(path)).expect("there")).contains(&FileMissing), "{path}");
        let cut = |root: &Path| {
            let bytes = fs::read(root.join(path)).expect("there");
            fs::write(root.join(path), &bytes[..bytes.len() / 2]).expect("written");
        };
        assert_eq!(after(cut), [FileSize], "{path}");
        for place in [10, 1000, 4000] {
            let flip = |root: &Path| {
                let mut bytes = fs::read(root.join(path)).expect("there");
                let at = place.min(bytes.len() - 5);
                bytes[at] ^= 4;
                fs::write(root.join(path), bytes).expect("written");
            };
            assert_eq!(after(flip), [FileChecksum], "{path}");
        }
    }
    for path in ["README.md", "croissant.json"] {
        assert_eq!(after(|root| fs::remove_file(root.join(path)).expect("there")), [FileMissing], "{path}");
    }
    let kept = |root: &Path| {
        fs::create_dir(root.join("reports")).expect("made");
        fs::write(root.join("reports/validation.json"), "{}").expect("written");
    };
    assert_eq!(after(kept), []);
    assert_eq!(after(|root| fs::write(root.join("reports"), "x").expect("written")), [FileUnexpected]);
    for path in ["notes.txt", "data/train-00009.parquet", "shards/.tmp-00000.json", "exr/00000/x.exr"] {
        assert_eq!(after(|root| fs::write(root.join(path), "x").expect("written")), [FileUnexpected], "{path}");
    }
}

#[test]
#[ignore = "long"]
fn damage_that_the_manifest_agrees_with_never_panics() {
    let place = tempfile::tempdir().expect("a folder");
    write_dataset(place.path(), 4, &output());
    for path in [DATA, EXR, "stacks/00000.parquet"] {
        let good = fs::read(place.path().join(path)).expect("there");
        for step in 0..60 {
            let mut bytes = good.clone();
            let at = (step * 7919 + 4) % bytes.len();
            bytes[at] = bytes[at].wrapping_add(1 + step as u8);
            if step % 7 == 0 {
                bytes.truncate(at);
            }
            fs::write(place.path().join(path), bytes).expect("written");
            agree(place.path());
            check(&place);
        }
        fs::write(place.path().join(path), good).expect("written");
    }
    agree(place.path());
    assert!(check(&place).is_clean());
}

#[test]
fn tables() {
    use Code::*;
    let garbage = |path: &'static str| {
        after(move |root| {
            fs::write(root.join(path), "PAR1 and no more").expect("written");
            agree(root);
        })
    };
    assert_eq!(garbage(DATA), [TableUnreadable]);
    assert_eq!(garbage("stacks/00000.parquet"), [TableUnreadable]);
    assert_eq!(garbage(EXR), [ExrUnreadable, SampleChecksum]);
    let fewer = |rows: Vec<RecordBatch>| rows[..1].to_vec();
    assert_eq!(after(|root| rewrite(root, fewer)), [RowCount]);
    let swapped = |rows: Vec<RecordBatch>| vec![rows[1].clone(), rows[0].clone()];
    assert_eq!(after(|root| rewrite(root, swapped)), [IndexOrder]);
    let longer = |rows: Vec<RecordBatch>| vec![rows[0].clone(), rows[1].clone(), rows[1].clone()];
    assert_eq!(after(|root| rewrite(root, longer)), [RowCount, IndexOrder]);
    let narrow = |rows: Vec<RecordBatch>| {
        let all: Vec<usize> = (0..rows[0].num_columns() - 1).collect();
        rows.iter().map(|batch| batch.project(&all).expect("columns")).collect()
    };
    assert_eq!(after(|root| rewrite(root, narrow)), [SchemaDiffers]);
    let bare = |rows: Vec<RecordBatch>| {
        let schema = Arc::new(rows[0].schema().as_ref().clone().with_metadata([("a", "b")]));
        rows.into_iter().map(|b| RecordBatch::try_new(schema.clone(), b.columns().to_vec()).expect("same")).collect()
    };
    assert_eq!(after(|root| rewrite(root, bare)), [SchemaDiffers], "without the metadata, images do not decode");
    let empty = |rows: Vec<RecordBatch>| {
        let mut columns = rows[0].columns().to_vec();
        let place = rows[0].schema().index_of("row_mm").expect("a column");
        columns[place] = arrow_array::new_null_array(columns[place].data_type(), 1);
        vec![RecordBatch::try_new(rows[0].schema(), columns).expect("same"), rows[1].clone()]
    };
    assert_eq!(after(|root| rewrite(root, empty)), [NumberMissing]);
    let strange = |rows: Vec<RecordBatch>| {
        let mut columns = rows[0].columns().to_vec();
        let place = rows[0].schema().index_of("class").expect("a column");
        columns[place] = Arc::new(arrow_array::Int64Array::from(vec![9]));
        vec![RecordBatch::try_new(rows[0].schema(), columns).expect("same"), rows[1].clone()]
    };
    assert_eq!(after(|root| rewrite(root, strange)), [ClassUnknown, ExrDiffers]);
}

#[test]
fn an_unfinished_dataset_says_which_shards_are_missing() {
    let place = tempfile::tempdir().expect("a folder");
    write_dataset(place.path(), 4, &output());
    Dataset::open_or_create(place.path(), head(&output(), &SIZE, 12), false, &|| ()).expect("it opens");
    let report = check(&place);
    assert_eq!(report.codes(), [Code::ManifestMissing]);
    assert_eq!(report.faults.len(), 2);
    let head: DatasetHead =
        serde_json::from_slice(&fs::read(place.path().join("dataset.json")).expect("there")).expect("a head");
    assert_eq!(head.shards, 3);
}

/// Parts of several machines: each has a card without counts, and nobody writes another one.
#[test]
fn parts_that_were_put_together() {
    let [place, part] = [0, 1].map(|_| tempfile::tempdir().expect("a folder"));
    write_dataset(place.path(), 12, &output());
    Dataset::open_or_create(part.path(), head(&output(), &SIZE, 12), false, &|| ()).expect("it opens");
    for name in ["README.md", "croissant.json"] {
        fs::copy(part.path().join(name), place.path().join(name)).expect("copied");
    }
    let report = check(&place);
    assert!(report.is_clean(), "{report}");
    let card = place.path().join("README.md");
    let text = fs::read_to_string(&card).expect("there");
    fs::write(card, text.replacen("|  |  |  |", "| 1 |  |  |", 1)).expect("written");
    assert_eq!(check(&place).codes(), [Code::CardDiffers]);
}

/// A copy of a file that the recipe names: changed, gone, of another recipe, or outside of the folder.
#[test]
fn files_that_the_recipe_names() {
    let damaged = |damage: &dyn Fn(&Path, &str)| {
        let place = tempfile::tempdir().expect("a folder");
        let folder = write_dataset(place.path(), 4, &output());
        let file = Asset::new("hook.obj", b"v 0 0 0".to_vec());
        let path = asset_path(file.sha256(), &file.plain_name());
        folder.keep(&path, file.bytes(), &|| ()).expect("it is kept");
        let mut head = folder.head().clone();
        head.recipe.canonical["mesh"] = serde_json::json!({ "file": { "sha256": file.sha256() } });
        let (key, name, sha256) = ("mesh.file".into(), "hook.obj".into(), file.sha256().into());
        head.assets = vec![AssetHead { key, name, path: path.clone(), bytes: 7, sha256 }];
        let text = serde_json::to_string_pretty(&head).expect("plain data") + "\n";
        fs::write(place.path().join("dataset.json"), text).expect("written");
        damage(place.path(), &path);
        check(&place).codes()
    };
    // The metadata names the sum of dataset.json, which was written anew.
    assert_eq!(damaged(&|_, _| ()), [Code::CardDiffers]);
    assert_eq!(
        damaged(&|root, path| fs::write(root.join(path), "v 0 0 1").expect("written")),
        [Code::FileChecksum, Code::CardDiffers]
    );
    assert_eq!(
        damaged(&|root, path| fs::write(root.join(path), "v 0 0").expect("written")),
        [Code::FileSize, Code::CardDiffers]
    );
    assert_eq!(
        damaged(&|root, path| fs::remove_file(root.join(path)).expect("removed")),
        [Code::FileMissing, Code::CardDiffers]
    );
    let edited = |edit: &dyn Fn(&mut Value)| damaged(&|root, _| edit_json(&root.join("dataset.json"), edit));
    assert_eq!(
        edited(&|v| _ = v.as_object_mut().map(|v| v.shift_remove("assets"))),
        [Code::FileUnexpected, Code::CardDiffers]
    );
    for (key, value) in [("path", "../hook.obj"), ("key", "laser.texture")] {
        let codes = edited(&|v| v["assets"][0][key] = value.into());
        assert_eq!(codes, [Code::DatasetUnreadable, Code::FileUnexpected, Code::CardDiffers], "{key}");
    }
}
