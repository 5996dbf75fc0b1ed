//! A dataset opens in pyarrow, Hugging Face datasets, polars, pandas, DuckDB, OpenEXR and OpenCV, and they agree.

use std::path::Path;

use crate::scripts::interpreter;
use test_support::program::Place;
use test_support::records::{output, write_dataset};

#[test]
fn every_reader_opens_a_dataset() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let dataset = folder.path().join("knots");
    write_dataset(&dataset, 10, &output());
    opens(&dataset, folder.path());
}

#[test]
fn every_reader_opens_a_dataset_of_packs() {
    let [_, place, ..] = Place::of_each_subject(&[["sensor_stack: none", "sensor_stack: {every: 48}"]]);
    place.make("packs", "--n 10 --samples-per-shard 6");
    opens(&place.path("packs"), &place.path("."));
}

/// The camera that is written with every sample turns its sensor rows into the heights of the calibrated dataset of the
/// same recipe, by the example that ships, within a micrometre; a lens with distortion is in it.
#[test]
fn sensor_rows_become_heights() {
    let bent = ["camera:\n", "camera:\n  distortion_k1: -0.06\n  distortion_p1: 0.0005\n"];
    let [heights, rows] =
        [None, Some(["\n  window_rows: 7", "\n  range: uncalibrated\n  window_rows: 7"])].map(|change| {
            let changes: Vec<_> = [bent].into_iter().chain(change).collect();
            let place = Place::with(&changes);
            place.make("planks", "--n 3");
            place
        });
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let run = interpreter()
        .arg(root.join("python/calibrate.py"))
        .args([rows.path("planks"), heights.path("planks")])
        .output()
        .expect("python starts");
    let text = format!("{}{}", String::from_utf8_lossy(&run.stdout), String::from_utf8_lossy(&run.stderr));
    assert!(run.status.success() && text.contains("differ by at most"), "{text}");
    println!("{text}");
}

fn opens(dataset: &Path, home: &Path) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let run = interpreter()
        .arg(root.join("python/check_readers.py"))
        .arg(dataset)
        .env("HF_HUB_OFFLINE", "1")
        .env("HF_DATASETS_OFFLINE", "1")
        .env("HF_HOME", home.join("hf"))
        .output()
        .expect("python starts");
    let text = format!("{}{}", String::from_utf8_lossy(&run.stdout), String::from_utf8_lossy(&run.stderr));
    assert!(run.status.success(), "{text}\nif a package is missing: make venv");
    for reader in ["pyarrow:", "tensors:", "datasets:", "tables:", "EXR:"] {
        assert!(text.contains(reader), "{text}");
    }
}
