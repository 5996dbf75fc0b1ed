//! Datasets and models for the tests of `gen check`, and onnxruntime, without which they fail and say so.

use std::path::{Path, PathBuf};

use serde_json::Value;

use test_support::program::{Place, Run};

/// Scatter, 600 DN as 0 and 900 DN as 1.
pub const CHANNEL: &str = "channels: [{name: scatter, mean: 600, sd: 300}]";

/// The environment in which `make` keeps onnxruntime.
fn environment() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(".venv")
}

/// onnxruntime is there, or the tests fail with what to do: never is a check skipped in silence.
pub fn needs_onnxruntime() {
    let packages = std::fs::read_dir(environment().join("lib")).into_iter().flatten().flatten();
    let found = packages.map(|python| python.path().join("site-packages/onnxruntime/capi")).any(|capi| capi.is_dir());
    assert!(
        found || std::env::var_os("ORT_DYLIB_PATH").is_some(),
        "onnxruntime is missing: `make venv` makes {} (python3 -m venv .venv; .venv/bin/pip install -r \
         python/requirements.txt), or set ORT_DYLIB_PATH",
        environment().display()
    );
}

pub fn model(name: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/models").join(name).display().to_string()
}

/// A sidecar for mean_sign and fixed.
pub fn patches() -> String {
    format!("task: classify_pixels\n{CHANNEL}\nwindow_px: 8\npatches_per_class: 20\nclasses: [clear, rot]")
}

/// Six boards of 64 x 48 pixels.
pub fn planks() -> Place {
    needs_onnxruntime();
    let place = Place::with(&[[
        "splits: {train: 0.8, validation: 0.1, test: 0.1}",
        "splits: {train: 0.5, validation: 0, test: 0.5}",
    ]]);
    place.make("planks", "--n 6 --samples-per-shard 4");
    place
}

/// Runs `gen check` on all of `planks` with a model of ours and a sidecar.
pub fn run(place: &Place, name: &str, sidecar: &str, arguments: &str) -> Run {
    place.write("side.yaml", sidecar);
    let split = if arguments.contains("--split") { "" } else { "--split all" };
    place.run(&format!("check planks --model {} --sidecar side.yaml {split} {arguments}", model(name)))
}

pub fn json(place: &Place, name: &str, sidecar: &str, arguments: &str) -> Value {
    let run = run(place, name, sidecar, &format!("--json {arguments}"));
    assert_eq!((run.code, run.err.as_str()), (0, ""), "{name} {arguments}");
    serde_json::from_str(&run.out).expect("it prints JSON")
}
