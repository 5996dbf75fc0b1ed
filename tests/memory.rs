//! Purpose: validation takes as much memory for many samples, and for many in one shard, as for a few.

use std::path::Path;
use std::process::Command;

use bench::settings::{Output, SensorStack, Size};
use dataset::validate::{ValidationOptions, validate};
use dataset::{Dataset, ShardWriter};
use test_support::records::{self, head, output};

/// Names the folder that [`validates`] is to read in a process of its own.
const FOLDER: &str = "SHEETLIGHT_TEST_FOLDER";
/// Large enough that a sample weighs more than what else varies: about 15 MB of decoded maps.
const LARGE: Size = Size { columns: 640, rows: 20, profiles: 512 };

/// Samples of one kind in one shard.
fn write(path: &Path, samples: u64) {
    let output = Output { sensor_stack: SensorStack::None, samples_per_shard: Some(samples as usize), ..output() };
    let folder = Dataset::open_or_create(path, head(&output, &LARGE, samples)).expect("it opens");
    let mut writer =
        ShardWriter::claim(&folder, 0).expect("the folder can be written").granted().expect("the shard is free");
    for index in 0..samples {
        let record = records::record(index, &LARGE, &output);
        writer.push(dataset::encode(record, &output)).expect("it is written");
    }
    writer.finish().expect("it is finished");
    folder.complete().expect("the card is written");
}

/// Largest memory of a process of its own that validates the folder [MB].
fn peak(folder: &Path) -> f64 {
    let mut own = Command::new(std::env::current_exe().expect("this test"));
    own.args(["--exact", "memory_is_flat", "--nocapture"]).env(FOLDER, folder);
    let output = own.output().expect("it runs");
    let text = String::from_utf8_lossy(&output.stdout);
    let line = text.lines().find_map(|line| line.split("VmHWM:").nth(1)).unwrap_or_else(|| panic!("no peak in {text}"));
    line.trim().trim_end_matches("kB").trim().parse::<f64>().expect("a number") / 1000.0
}

/// What the process of its own does.
fn validates(folder: &Path) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("a pool");
    let report = pool.install(|| validate(folder, &ValidationOptions::default()));
    // Synthetic records look more alike than scans do; what counts is that all of them were decoded.
    assert!(report.samples >= 6 && report.images == 14 * report.samples, "{report}");
    let status = std::fs::read_to_string("/proc/self/status").expect("Linux");
    println!("{}", status.lines().find(|line| line.starts_with("VmHWM:")).expect("a peak"));
}

#[test]
fn memory_is_flat() {
    if let Some(folder) = std::env::var_os(FOLDER) {
        return validates(Path::new(&folder));
    }
    let peaks = [6, 36].map(|samples| {
        let place = tempfile::tempdir().expect("a folder");
        write(place.path(), samples);
        peak(place.path())
    });
    // 30 samples more would be 450 MB decoded and 60 MB as files. What may grow is what the allocator leaves unused.
    println!("peak of 6 and of 36 samples: {peaks:?} MB");
    assert!(peaks[1] < peaks[0] + 30.0, "{peaks:?} MB");
}
