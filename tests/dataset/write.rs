//! Shards are whole or absent, and the same bytes however they came to be.

use std::fs;

use dataset::{Claim, Dataset, ShardWriter, estimated_bytes_per_sample, samples_per_shard};
use optical_bench::settings::{Output, SensorStack, Size};
use recipe::Recipe;
use test_support::records::{SIZE, claimed, encoded, head, output, tree, write_dataset, write_shard};

fn names(tree: &[(String, Vec<u8>)]) -> Vec<&str> {
    tree.iter().map(|(name, _)| name.as_str()).collect()
}

#[test]
fn the_same_samples_are_the_same_bytes_in_any_order_of_shards() {
    let (one, two) = (tempfile::tempdir().expect("a folder"), tempfile::tempdir().expect("a folder"));
    let output = output();
    write_dataset(one.path(), 10, &output);
    // The other one begins small, is extended, and its shards are written backwards.
    write_dataset(two.path(), 3, &output);
    let folder =
        Dataset::open_or_create(two.path(), head(&output, &SIZE, 10), false, &|| ()).expect("it can be extended");
    assert_eq!(
        folder.remaining(0..3).expect("they can be read"),
        [0, 1, 2],
        "the first shard held 3 samples and is to hold 4"
    );
    for shard in [2, 0, 1] {
        write_shard(&folder, shard, &output);
    }
    folder.complete(&|| ()).expect("the card can be written");
    let (one, two) = (tree(one.path()), tree(two.path()));
    assert_eq!(names(&one), names(&two));
    for (a, b) in one.iter().zip(&two) {
        assert!(a == b, "{} differs", a.0);
    }
    assert!(one.iter().all(|(name, _)| !name.contains("/.") && !name.starts_with('.')), "{:?}", names(&one));
}

#[test]
fn a_writer_that_ends_midway_leaves_nothing() {
    let place = tempfile::tempdir().expect("a folder");
    let output = output();
    let folder = Dataset::open_or_create(place.path(), head(&output, &SIZE, 8), false, &|| ()).expect("it opens");
    let before = tree(place.path());
    let mut writer = claimed(&folder, 1);
    writer.push(encoded(4, &output)).expect("it can be written");
    writer.push(encoded(5, &output)).expect("it can be written");
    assert!(tree(place.path()).len() > before.len());
    drop(writer);
    assert_eq!(names(&tree(place.path())), names(&before));
    assert!(!folder.is_done(1).expect("it can be read"));
    write_shard(&folder, 1, &output);
    assert!(folder.is_done(1).expect("it can be read") && !folder.is_done(0).expect("it can be read"));
}

#[test]
fn what_a_killed_process_left_is_removed_unless_somebody_holds_it() {
    let place = tempfile::tempdir().expect("a folder");
    let output = output();
    let folder = Dataset::open_or_create(place.path(), head(&output, &SIZE, 8), false, &|| ()).expect("it opens");
    let mut held = claimed(&folder, 0);
    held.push(encoded(0, &output)).expect("it can be written");
    for left in
        ["data/.tmp-train-00001.parquet", "stacks/.tmp-00001.parquet", "shards/.lock-00001", ".tmp-dataset.json"]
    {
        fs::write(place.path().join(left), "half").expect("it can be written");
    }
    fs::create_dir_all(place.path().join("exr/.tmp-00001")).expect("it can be made");
    fs::write(place.path().join("exr/.tmp-00001/a.exr"), "half").expect("it can be written");
    // Final names without a manifest count for nothing.
    fs::write(place.path().join("data/test-00001.parquet"), "half").expect("it can be written");
    let again = Dataset::open_or_create(place.path(), head(&output, &SIZE, 8), false, &|| ()).expect("it opens again");
    let left = tree(place.path());
    assert!(names(&left).iter().all(|name| !name.contains("00001")), "{:?}", names(&left));
    assert!(!names(&left).contains(&".tmp-dataset.json"), "{:?}", names(&left));
    assert!(names(&left).contains(&"data/.tmp-train-00000.parquet"), "the held shard must stay: {:?}", names(&left));
    assert!(matches!(ShardWriter::claim(&again, 0), Ok(Claim::Busy)));
    for index in 1..4 {
        held.push(encoded(index, &output)).expect("it can be written");
    }
    held.finish().expect("it can be finished");
    assert!(matches!(ShardWriter::claim(&again, 0), Ok(Claim::Done)));
}

#[test]
fn a_shard_counts_only_while_every_file_has_its_size() {
    let place = tempfile::tempdir().expect("a folder");
    let output = output();
    let folder = write_dataset(place.path(), 4, &output);
    assert!(folder.is_done(0).expect("it can be read"));
    let file = place.path().join("data/train-00000.parquet");
    let bytes = fs::read(&file).expect("it is there");
    fs::write(&file, &bytes[..bytes.len() - 1]).expect("it can be cut");
    assert!(!folder.is_done(0).expect("it can be read"));
    write_shard(&folder, 0, &output);
    assert!(folder.is_done(0).expect("it can be read"));
    assert_eq!(fs::read(&file).expect("it is there"), bytes);
}

#[test]
fn samples_come_in_order_and_as_promised() {
    let place = tempfile::tempdir().expect("a folder");
    let output = output();
    let folder = Dataset::open_or_create(place.path(), head(&output, &SIZE, 8), false, &|| ()).expect("it opens");
    let mut writer = claimed(&folder, 1);
    assert_eq!(writer.push(encoded(5, &output)).expect_err("4 is next").place, "sample 5 does not fit shard 1");
    let mut other = encoded(4, &output);
    other.class = "granite".into();
    let text = writer.push(other).expect_err("an unknown class").to_string();
    assert!(text.contains("granite") && text.contains("sample 4"), "{text}");
    let mut other = encoded(4, &output);
    other.draws.pop();
    assert!(writer.push(other).expect_err("a missing draw").to_string().contains("board.width_mm"));
    assert_eq!(writer.finish().expect_err("4 is missing").place, "sample 4 does not fit shard 1");
}

#[test]
fn shards_are_cut_by_size() {
    let large = Size { columns: 2560, rows: 1024, profiles: 2000 };
    let full = Output { samples_per_shard: None, sensor_stack: SensorStack::None, ..output() };
    let bytes = estimated_bytes_per_sample(&full, &large);
    let count = samples_per_shard(&full, &large, 1.0);
    assert!(count as u64 * bytes <= 500_000_000 && (count + 1) as u64 * bytes > 500_000_000, "{count} x {bytes}");
    assert_eq!(samples_per_shard(&full, &SIZE, 0.1), 1000);
    assert_eq!(samples_per_shard(&output(), &large, 1.0), 4);
    let stacked = Output { sensor_stack: SensorStack::All, ..full.clone() };
    assert_eq!(samples_per_shard(&stacked, &large, 1.0), 1);
    // No more than a minute's work of two cores, however long a sample takes.
    for (seconds, count) in [(1.3, 92), (12.0, 10), (61.0, 1), (1e9, 1)] {
        assert_eq!(samples_per_shard(&full, &SIZE, seconds), count, "{seconds} s a sample");
    }
    // What ships: small boards by their number or bytes, others by their work.
    let boards =
        [("wood-train", 1000), ("wood-small", 928), ("wood", 6), ("wood-grading", 14), ("wood-grading-train", 500)];
    let packs = [("blister-train", 90), ("blister-small", 90), ("blister", 11), ("thesis/blister", 1)];
    for (name, count) in boards.into_iter().chain(packs) {
        let recipe = Recipe::load(name).unwrap_or_else(|faults| panic!("{faults}"));
        let found = samples_per_shard(&recipe.output(), &recipe.size(), recipe.sample_seconds());
        assert_eq!(found, count, "{name}");
    }
}
