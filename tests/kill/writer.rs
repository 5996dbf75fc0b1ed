//! A process that is killed in the middle of a shard leaves a dataset that the next one completes to the same bytes.

use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use dataset::{Claim, Dataset, ShardWriter, encode};
use optical_bench::settings::{Channel, Output, SensorStack, Size};
use parquet::file::reader::{FileReader, SerializedFileReader};
use test_support::program::until;
use test_support::records::{SIZE, claimed, encoded, head, output, record, tree, write_dataset};

/// Where the child of the test below writes.
const CHILD: &str = "SHEETLIGHT_TEST_CHILD";

#[test]
fn child_that_is_killed() {
    // Only at work when the test below has started it.
    let Some(place) = std::env::var_os(CHILD).map(PathBuf::from) else { return };
    let folder = Dataset::open_or_create(&place, head(&output(), &SIZE, 12), false, &|| ()).expect("it opens");
    let mut writer = claimed(&folder, 1);
    (4..7).for_each(|index| writer.push(encoded(index, &output())).expect("it is written"));
    std::fs::write(place.with_extension("ready"), "").expect("it can be written");
    // Until it is killed, or whoever started it has ended.
    std::io::stdin().read_to_end(&mut Vec::new()).expect("a pipe");
}

#[test]
fn the_next_process_completes_what_a_killed_one_began() {
    let _machine = crate::alone();
    let place = tempfile::tempdir().expect("a folder");
    let root = place.path().join("set");
    let program = std::env::current_exe().expect("this program has a path");
    let mut child = Command::new(program)
        .args(["--exact", "writer::child_that_is_killed"])
        .env(CHILD, &root)
        .stdin(Stdio::piped())
        .spawn()
        .expect("the child starts");
    assert!(until(&mut child, || root.with_extension("ready").exists()), "the child does not write");
    let folder = Dataset::open(&root).expect("it is a dataset");
    assert!(matches!(ShardWriter::claim(&folder, 1), Ok(Claim::Busy)), "the child holds it");
    child.kill().expect("it can be killed");
    child.wait().expect("it ends");
    assert!(has_leftovers(&root));

    write_dataset(&root, 12, &output());
    assert!(!has_leftovers(&root));
    let alone = tempfile::tempdir().expect("a folder");
    write_dataset(alone.path(), 12, &output());
    assert!(tree(&root) == tree(alone.path()), "the dataset differs from one that was never interrupted");
}

fn has_leftovers(root: &Path) -> bool {
    tree(root).iter().any(|(name, _)| name.contains(".tmp-") || name.contains(".lock-"))
}

#[test]
fn a_large_shard_goes_to_disk_in_row_groups() {
    let _machine = crate::alone();
    let place = tempfile::tempdir().expect("a folder");
    let size = Size { columns: 2048, rows: 8, profiles: 512 };
    let png = vec![Channel::Range, Channel::Reflectance, Channel::Scatter];
    let output = Output { png, exr: vec![], sensor_stack: SensorStack::None, samples_per_shard: Some(32), ..output() };
    let folder = Dataset::open_or_create(place.path(), head(&output, &size, 32), false, &|| ()).expect("it opens");
    let mut writer = claimed(&folder, 0);
    let sample = encode(record(0, &size, &output), &output);
    for index in 0..32 {
        let mut sample = sample.clone();
        (sample.index, sample.id) = (index, format!("{index:036}"));
        writer.push(sample).expect("it is written");
    }
    writer.finish().expect("it is finished");
    let file = std::fs::File::open(place.path().join("data/train-00000.parquet")).expect("it is there");
    let file = SerializedFileReader::new(file).expect("it is Parquet");
    let groups: Vec<i64> = file.metadata().row_groups().iter().map(|group| group.compressed_size()).collect();
    assert!(groups.len() >= 2 && groups.iter().all(|&bytes| bytes < 48 << 20), "{groups:?} bytes");
}
