//! A dataset opens in pyarrow, Hugging Face datasets, polars, pandas, DuckDB, OpenEXR and OpenCV, and they agree.

mod shard_support;

use std::path::Path;
use std::process::Command;

use shard_support::{output, write_dataset};

#[test]
fn every_reader_opens_a_dataset() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let python = root.join(".venv/bin/python");
    assert!(
        python.exists(),
        "{} is missing: `make venv` makes it (python3 -m venv .venv; .venv/bin/pip install -r python/requirements.txt)",
        python.display()
    );
    let folder = tempfile::tempdir().expect("a temporary folder");
    let dataset = folder.path().join("knots");
    write_dataset(&dataset, 10, &output());
    let run = Command::new(&python)
        .arg(root.join("python/check_readers.py"))
        .arg(&dataset)
        .env("HF_HUB_OFFLINE", "1")
        .env("HF_DATASETS_OFFLINE", "1")
        .env("HF_HOME", folder.path().join("hf"))
        .output()
        .expect("python starts");
    let text = format!("{}{}", String::from_utf8_lossy(&run.stdout), String::from_utf8_lossy(&run.stderr));
    assert!(run.status.success(), "{text}\nif a package is missing: make venv");
    for reader in ["pyarrow:", "tensors:", "datasets:", "tables:", "EXR:"] {
        assert!(text.contains(reader), "{text}");
    }
}
