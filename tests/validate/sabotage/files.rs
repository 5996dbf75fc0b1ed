//! Damage to files: gone, cut, more, of another kind, flipped, or tables with other rows.

use std::fs::{self, File};
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use arrow_array::{Array, ArrayRef, Float64Array, RecordBatch, StructArray};
use dataset::validate::Code::{self, *};

use super::place::{MANIFEST, after, agree, boards};
use crate::damage::{self, DATA};

const STACK: &str = "stacks/00000.parquet";

fn exr() -> String {
    format!("exr/00000/{}.exr", boards().samples[0].id)
}

fn other_file() -> String {
    format!("exr/00000/{}.exr", boards().samples[1].id)
}

#[test]
#[ignore = "long"]
fn gone_cut_or_more() {
    let exr = exr();
    for path in [DATA, STACK, &exr] {
        let gone = |root: &Path| fs::remove_file(root.join(path)).expect("there");
        after(gone, &[FileMissing], path, "a missing file");
        after(|root| fs::write(root.join(path), "").expect("written"), &[FileSize], path, "an empty file");
        let cut = |root: &Path| {
            let bytes = fs::read(root.join(path)).expect("there");
            fs::write(root.join(path), &bytes[..bytes.len() * 2 / 3]).expect("written");
        };
        after(cut, &[FileSize], path, "a file that was cut");
        let flip = |root: &Path| {
            let mut bytes = fs::read(root.join(path)).expect("there");
            let middle = bytes.len() / 2;
            bytes[middle] ^= 16;
            fs::write(root.join(path), bytes).expect("written");
        };
        after(flip, &[FileChecksum], path, "a flipped bit");
        let folder = |root: &Path| {
            fs::remove_file(root.join(path)).expect("there");
            fs::create_dir(root.join(path)).expect("made");
        };
        after(folder, &[FileMissing], path, "a folder in place of a file");
        let link = |root: &Path| {
            let beside: PathBuf = root.with_extension("moved");
            fs::rename(root.join(path), &beside).expect("moved");
            symlink(&beside, root.join(path)).expect("linked");
        };
        after(link, &[FileMissing], path, "a link in place of a file");
    }
    for path in ["notes.txt", "data/train-00009.parquet", "shards/.tmp-00000.json", "exr/00000/x.exr", "exr/00007"] {
        let more = |root: &Path| fs::write(root.join(path), "x").expect("written");
        after(more, &[FileUnexpected], path, "a file too many");
    }
    let shard = |root: &Path| {
        fs::remove_file(root.join(MANIFEST)).expect("there");
        for path in ["data", "exr/00000", "stacks"] {
            for entry in fs::read_dir(root.join(path)).expect("there").flatten() {
                if path == "exr/00000" || entry.file_name().to_string_lossy().contains("00000") {
                    fs::remove_file(entry.path()).expect("there");
                }
            }
        }
    };
    after(shard, &[ManifestMissing], MANIFEST, "a missing shard");
}

#[test]
#[ignore = "long"]
fn files_that_manifests_agree_with() {
    let put = |path: String, bytes: Vec<u8>| {
        move |root: &Path| {
            fs::write(root.join(&path), &bytes).expect("written");
            agree(root);
        }
    };
    let half = |path: &str| {
        let folder = super::place::whole();
        let bytes = fs::read(folder.path().join(path)).expect("there");
        bytes[..bytes.len() / 2].to_vec()
    };
    after(put(exr(), half(&exr())), &[ExrUnreadable, SampleChecksum], &exr(), "half an EXR file");
    after(put(DATA.into(), half(DATA)), &[TableUnreadable], DATA, "half a table");
    after(put(STACK.into(), half(STACK)), &[TableUnreadable], STACK, "half a table of frames");
    let swap = |root: &Path| {
        let [a, b] = [exr(), other_file()].map(|path| root.join(path));
        let beside = root.with_extension("beside");
        fs::rename(&a, &beside).expect("moved");
        fs::rename(&b, &a).expect("moved");
        fs::rename(&beside, &b).expect("moved");
        agree(root);
    };
    // The maps of either are compared with the images of the other; instances are in EXR files alone.
    let codes = [ExrDiffers, SampleChecksum, TruthDiffers, LabelDiffers, ObjectDiffers, InstanceClass];
    after(swap, &codes, &exr(), "EXR files of two samples swapped");
}

/// Rewrites the rows of `DATA`.
fn rewrite(change: impl Fn(Vec<RecordBatch>) -> Vec<RecordBatch>, codes: &[Code], what: &str) {
    after(|root: &Path| damage::rewrite(root, &change), codes, DATA, what);
}

#[test]
#[ignore = "long"]
fn rows() {
    rewrite(|rows| rows[1..].to_vec(), &[RowCount, IndexOrder], "a row that was left out");
    rewrite(|rows| rows[..1].to_vec(), &[RowCount], "a table that ends early");
    rewrite(|rows| rows.into_iter().rev().collect(), &[IndexOrder], "rows in another order");
    rewrite(|rows| [rows.clone(), vec![rows[0].clone()]].concat(), &[RowCount, IndexOrder], "a row too many");
    let narrow = |rows: Vec<RecordBatch>| {
        let all: Vec<usize> = (0..rows[0].num_columns() - 1).collect();
        rows.iter().map(|batch| batch.project(&all).expect("columns")).collect()
    };
    rewrite(narrow, &[SchemaDiffers], "a column that was left out");
    let bare = |rows: Vec<RecordBatch>| {
        let schema = Arc::new(rows[0].schema().as_ref().clone().with_metadata([("a", "b")]));
        rows.into_iter().map(|b| RecordBatch::try_new(schema.clone(), b.columns().to_vec()).expect("same")).collect()
    };
    rewrite(bare, &[SchemaDiffers], "other metadata");
    let replaced = |rows: Vec<RecordBatch>, name: &str, column: ArrayRef| {
        let mut columns = rows[0].columns().to_vec();
        columns[rows[0].schema().index_of(name).expect("the column")] = column;
        let first = RecordBatch::try_new(rows[0].schema(), columns).expect("same");
        std::iter::once(first).chain(rows[1..].iter().cloned()).collect()
    };
    let unknown = |rows| replaced(rows, "class", Arc::new(arrow_array::Int64Array::from(vec![99])));
    rewrite(unknown, &[ClassUnknown, ExrDiffers], "a class of no recipe");
    let named = |rows: Vec<RecordBatch>| {
        let image = rows[0].column_by_name("label").expect("an image");
        let image = image.as_any().downcast_ref::<StructArray>().expect("a struct");
        let mut children = image.columns().to_vec();
        children[1] = Arc::new(arrow_array::StringArray::from(vec!["same.png"]));
        let image = StructArray::new(image.fields().clone(), children, None);
        replaced(rows, "label", Arc::new(image))
    };
    rewrite(named, &[RowDiffers], "another name of an image");
    let other = |rows| replaced(rows, "seed", Arc::new(arrow_array::UInt64Array::from(vec![7])));
    rewrite(other, &[RowDiffers], "another seed");
    for number in [f64::NAN, f64::INFINITY] {
        let laser = |rows: Vec<RecordBatch>| {
            let group = rows[0].column_by_name("laser").expect("a group");
            let group = group.as_any().downcast_ref::<StructArray>().expect("a struct");
            let mut children = group.columns().to_vec();
            children[0] = Arc::new(Float64Array::from(vec![number]));
            let group = StructArray::new(group.fields().clone(), children, None);
            replaced(rows, "laser", Arc::new(group))
        };
        rewrite(laser, &[ValueRange, DrawDiffers], "a drawn number that is none");
    }
}

/// A pipe is never read: that would not end.
#[test]
fn pipes_are_no_files() {
    for (path, code) in [(MANIFEST, ManifestUnreadable), ("dataset.json", DatasetMissing), (DATA, FileMissing)] {
        let pipe = |root: &Path| {
            fs::remove_file(root.join(path)).expect("there");
            let made = std::process::Command::new("mkfifo").arg(root.join(path)).status().expect("mkfifo runs");
            assert!(made.success());
        };
        after(pipe, &[code], path, "a pipe in place of a file");
    }
}

/// Root may read everything; others are told which file they may not.
#[test]
fn files_that_may_not_be_read() {
    use std::os::unix::fs::PermissionsExt;
    let folder = super::place::whole();
    let path = folder.path().join(DATA);
    fs::set_permissions(&path, fs::Permissions::from_mode(0o0)).expect("set");
    if File::open(&path).is_err() {
        super::place::says(folder.path(), &[FileUnreadable], DATA, "a file that may not be read");
    }
    fs::set_permissions(&path, fs::Permissions::from_mode(0o644)).expect("set");
}
