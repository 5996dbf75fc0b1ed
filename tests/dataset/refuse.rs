//! What a dataset folder refuses, and how it says so: other datasets, other files, a full disk.

use std::fs;
use std::path::Path;
use std::thread;

use dataset::{Claim, Dataset, ShardWriter};
use output_schema::DatasetHead;
use test_support::disk::Disk;
use test_support::records::{SIZE, claimed, encoded, granted, head, output, tree, write_dataset, write_shard};

fn refusal(path: &Path, change: impl Fn(&mut DatasetHead)) -> String {
    let mut other = head(&output(), &SIZE, 6);
    change(&mut other);
    match Dataset::open_or_create(path, other, false, &|| ()) {
        Err(fault) if fault.tried == Some("use") => fault.to_string(),
        other => panic!("not refused: {other:?}"),
    }
}

#[test]
fn another_dataset_is_refused_with_the_difference() {
    let place = tempfile::tempdir().expect("a folder");
    write_dataset(place.path(), 6, &output());
    let before = tree(place.path());
    let text = refusal(place.path(), |h| {
        h.recipe.hash = "00".repeat(32);
        h.recipe.canonical["laser"]["power_mw"] = 60.0.into();
    });
    assert!(text.contains("recipe.laser.power_mw: 50.0 -> 60.0"), "{text}");
    assert!(refusal(place.path(), |h| h.seed = 3).contains("seed: 18446744073709551614 -> 3"));
    assert!(refusal(place.path(), |h| h.generator.version = "9.0.0".into()).contains("generator.version"));
    assert!(refusal(place.path(), |h| h.samples_per_shard = 5).contains("samples_per_shard: 4 -> 5"));
    assert!(refusal(place.path(), |h| h.target = "aarch64".into()).contains("target"));
    assert!(refusal(place.path(), |h| h.schema_version = [1, 8]).contains("schema_version"));
    assert_eq!(tree(place.path()), before, "a refusal changes nothing");
}

#[test]
fn a_newer_schema_is_refused_clearly() {
    let place = tempfile::tempdir().expect("a folder");
    write_dataset(place.path(), 2, &output());
    let manifest = place.path().join("shards/00000.json");
    let text = fs::read_to_string(&manifest).expect("it is there");
    let folder = Dataset::open(place.path()).expect("it is a dataset");
    assert!(folder.manifest(0).is_ok_and(|found| found.is_some()));
    let newer = text.replacen("\"schema_version\": [\n    1", "\"schema_version\": [\n    2", 1);
    fs::write(&manifest, newer).expect("it can be written");
    assert!(folder.manifest(0).is_err_and(|e| e.to_string().contains("newer")));

    let path = place.path().join("dataset.json");
    let mut document: DatasetHead =
        serde_json::from_slice(&fs::read(&path).expect("it is there")).expect("it is a head");
    document.schema_version = [2, 0];
    fs::write(&path, serde_json::to_vec(&document).expect("plain data")).expect("it can be written");
    assert!(refusal(place.path(), |_| ()).contains("newer"));
    fs::write(&path, "{").expect("it can be written");
    assert!(refusal(place.path(), |_| ()).contains("cannot be read"));
}

#[test]
fn a_folder_with_other_files_is_refused() {
    let place = tempfile::tempdir().expect("a folder");
    fs::write(place.path().join("thesis.tex"), "years").expect("it can be written");
    assert!(refusal(place.path(), |_| ()).contains("not empty"));
    assert_eq!(tree(place.path()).len(), 1);
}

#[test]
fn fewer_samples_remove_nothing() {
    let place = tempfile::tempdir().expect("a folder");
    write_dataset(place.path(), 10, &output());
    let before = tree(place.path());
    let folder = Dataset::open_or_create(place.path(), head(&output(), &SIZE, 2), false, &|| ()).expect("it opens");
    assert_eq!((folder.head().samples, folder.remaining(0..9).expect("they can be read")), (10, vec![]));
    assert_eq!(tree(place.path()), before);
}

/// A dataset is begun anew where nothing of it is made and nobody holds a shard, and where that may be: guards what
/// others have made, or are making.
#[test]
fn nothing_that_is_made_is_begun_anew() {
    let place = tempfile::tempdir().expect("a folder");
    let begin = |samples, anew| {
        let folder = Dataset::open_or_create(place.path(), head(&output(), &SIZE, samples), anew, &|| ());
        folder.expect("it opens").head().samples
    };
    assert_eq!(begin(10, true), 10);
    assert_eq!(begin(2, false), 10, "others may have made parts elsewhere");
    let folder = Dataset::open(place.path()).expect("it is a dataset");
    let writer = claimed(&folder, 2);
    assert_eq!(begin(2, true), 10, "somebody is at work");
    drop(writer);
    // What a killed process leaves is nothing.
    fs::write(place.path().join("shards/.lock-00002"), "").expect("written");
    fs::write(place.path().join("data/.tmp-train-00002.parquet"), "").expect("written");
    assert_eq!(begin(6, true), 6);
    assert!(!place.path().join("data/.tmp-train-00002.parquet").exists());
    let folder = Dataset::open(place.path()).expect("it is a dataset");
    write_shard(&folder, 1, &output());
    assert_eq!(begin(2, true), 6, "a shard is made");
    assert_eq!(begin(7, true), 7, "more samples extend it");
}

#[test]
fn many_may_begin_and_write_one_dataset() {
    let place = tempfile::tempdir().expect("a folder");
    let output = output();
    thread::scope(|scope| {
        for _ in 0..4 {
            scope.spawn(|| {
                let folder =
                    Dataset::open_or_create(place.path(), head(&output, &SIZE, 24), false, &|| ()).expect("it opens");
                for shard in folder.remaining(0..folder.head().shards).expect("they can be read") {
                    match ShardWriter::claim(&folder, shard) {
                        Err(fault) => panic!("{fault}"),
                        Ok(Claim::Busy | Claim::Done) => continue,
                        Ok(Claim::Granted(mut writer)) => {
                            let (first, count) = writer.span();
                            (first..first + count)
                                .for_each(|i| writer.push(encoded(i, &output)).expect("it is written"));
                            writer.finish().expect("it is finished");
                        }
                    }
                }
            });
        }
    });
    let alone = tempfile::tempdir().expect("a folder");
    write_dataset(alone.path(), 24, &output);
    Dataset::open_or_create(place.path(), head(&output, &SIZE, 24), false, &|| ())
        .expect("it opens")
        .complete(&|| ())
        .expect("a card");
    assert_eq!(tree(place.path()), tree(alone.path()));
}

#[test]
fn a_missing_parent_and_a_file_in_the_way_are_named() {
    let place = tempfile::tempdir().expect("a folder");
    let file = place.path().join("file");
    fs::write(&file, "").expect("it can be written");
    let error =
        Dataset::open_or_create(&file.join("data"), head(&output(), &SIZE, 2), false, &|| ()).expect_err("no folder");
    assert!(error.to_string().contains("check the path"), "{error}");
}

/// A small disk of these options, and the folder that it is mounted in.
fn disk(options: &str) -> Option<(Disk, tempfile::TempDir)> {
    let place = tempfile::tempdir().expect("a temporary folder");
    Disk::mount(place.path(), options).map(|disk| (disk, place))
}

#[test]
fn a_full_disk_keeps_finished_shards_and_says_what_to_do() {
    let Some((disk, _place)) = disk("size=2m") else { return };
    let output = output();
    let root = disk.path().join("set");
    let folder = Dataset::open_or_create(&root, head(&output, &SIZE, 8), false, &|| ()).expect("it opens");
    write_shard(&folder, 0, &output);
    let before = tree(&root);
    fs::write(disk.path().join("ballast"), vec![1; 1_900_000]).ok();
    let _ = fs::write(disk.path().join("rest"), vec![1; 70_000]);
    let written = ShardWriter::claim(&folder, 1).and_then(|claim| {
        let mut writer = granted(claim);
        (4..8).try_for_each(|index| writer.push(encoded(index, &output)))?;
        writer.finish()
    });
    let error = written.expect_err("the disk is full");
    assert!(error.what.starts_with("the disk is full") && error.what.contains(" free, about "), "{error:?}");
    let text = error.to_string();
    assert!(!text.contains(" 0.0 "), "sizes come in units that fit: {text}");
    for word in ["disk is full", " kB needed", "finished shards are intact", "same command to continue"] {
        assert!(text.contains(word), "{text}");
    }
    assert_eq!(tree(&root), before, "nothing of the shard is left, and the finished one is as it was");
    fs::remove_file(disk.path().join("ballast")).expect("it is there");
    let _ = fs::remove_file(disk.path().join("rest"));
    write_shard(&folder, 1, &output);
    assert!(folder.remaining(0..2).expect("they can be read").is_empty());
}

/// A disk that has room for bytes and none for files is not called full.
#[test]
fn a_disk_without_inodes_says_so() {
    let Some((disk, _place)) = disk("size=20m,nr_inodes=24") else { return };
    let output = output();
    let root = disk.path().join("set");
    let written = Dataset::open_or_create(&root, head(&output, &SIZE, 64), false, &|| ()).and_then(|folder| {
        for shard in 0..16 {
            let mut writer = granted(ShardWriter::claim(&folder, shard)?);
            (4 * shard..4 * shard + 4).try_for_each(|index| writer.push(encoded(index, &output)))?;
            writer.finish()?;
        }
        Ok(())
    });
    let text = written.expect_err("there are too many files").to_string();
    assert!(!text.contains("disk is full"), "{text}");
    for word in ["no more files", "inodes", "MB free", "finished shards are intact", "same command to continue"] {
        assert!(text.contains(word), "no `{word}` in {text}");
    }
}
