//! What a dataset says of itself: Croissant metadata, the card, and the version that readers look at first.

use std::fs;

use crate::scripts::{datasets, example, first, names, number, python, sum};
use parquet::record::Field;
use serde_json::json;
use sha2::{Digest, Sha256};
use test_support::program::{Place, rows};

/// Every example.
const EXAMPLES: [&str; 9] = [
    "load_datasets",
    "load_polars",
    "load_duckdb",
    "load_pandas",
    "load_openexr",
    "load_opencv",
    "train_pytorch",
    "croissant",
    "rejoin_exr",
];

/// mlcroissant accepts the metadata without a word, and its records are the samples.
#[test]
fn mlcroissant_accepts_the_metadata() {
    for (place, samples) in datasets() {
        let said = example(&place.path("."), "croissant", &place.path("set"), &[]);
        assert!(!said.err.to_lowercase().contains("warning"), "{}", said.err);
        assert!(said.line("accepted: ").starts_with("0 errors, 0 warnings, version "), "{}", said.out);
        let head = place.json("set/dataset.json");
        assert_eq!(said.line("classes: "), names(&head, "classes").join(", "));
        for split in ["train", "validation", "test"] {
            let count = samples.values().filter(|s| s.text("split") == split).count();
            let line = format!("\nsplit {split}: {count} samples\n");
            assert_eq!(said.out.contains(&line), count > 0, "{line}{}", said.out);
        }
        let (index, sample) = first(&samples, &["train"]);
        let class = &names(&head, "classes")[number(&sample.columns["class"]) as usize];
        assert_eq!(said.line("first of train: "), format!("sample {index}, class {class}"));
        for name in ["range", "reflectance", "scatter", "label", "instance"] {
            let (cols, rows, pixels) = sample.image(name);
            let depth = if ["reflectance", "label"].contains(&name) { 8 } else { 16 };
            let expected = format!("uint{depth} ({rows}, {cols}), sum {}", sum(&pixels));
            assert_eq!(said.line(&format!("train {name}: ")), expected);
        }
        if place.path("set/stacks").exists() {
            let row = rows(&place.path("set/stacks/00000.parquet")).remove(0);
            let Field::ListInternal(pixels) = &row["frame"] else { panic!("no frame") };
            let total: u64 =
                pixels.elements().iter().map(|p| if let Field::UByte(p) = p { u64::from(*p) } else { 0 }).sum();
            assert!(said.line("frame 0 of sample 0: ").ends_with(&format!("sum {total}")), "{}", said.out);
        }
    }
}

/// The document is renewed as the dataset grows, and does not grow with it.
#[test]
fn croissant_follows_the_dataset() {
    let place = Place::with(&[]);
    let read = |n: u64| {
        place.make("set", &format!("--n {n} --samples-per-shard 6"));
        let sum: String = Sha256::digest(fs::read(place.path("set/dataset.json")).expect("there"))
            .iter()
            .map(|b| format!("{b:02x}"))
            .collect();
        let document = place.json("set/croissant.json");
        assert_eq!(document["distribution"][0]["sha256"], json!(sum));
        assert!(document["version"].as_str().is_some_and(|text| text.ends_with(&format!(".n.{n}"))), "{document:#}");
        fs::metadata(place.path("set/croissant.json")).expect("there").len()
    };
    assert_eq!(read(30), read(42));
    // No clock: the date is the version's, as CHANGELOG.md has it once it is released.
    let date = place.json("set/croissant.json")["datePublished"].as_str().expect("a date").to_string();
    let heading = concat!("## [", env!("CARGO_PKG_VERSION"), "] - ");
    let said =
        include_str!("../../CHANGELOG.md").lines().find_map(|line| line.strip_prefix(heading)).expect("a heading");
    assert!(said == "unreleased" || said == date, "{said} and {date}");
    // A document that was lost is written again, by the same command.
    fs::remove_file(place.path("set/croissant.json")).expect("there");
    assert!(place.run("validate set --rerender 0").out.contains("croissant.json"));
    read(42);
}

/// A newer schema, and a package that is not there, are told in words.
#[test]
fn examples_refuse_what_they_cannot_read() {
    let place = Place::new();
    fs::create_dir(place.path("set")).expect("made");
    place.write("set/dataset.json", r#"{"format": "sheetlight-dataset", "schema_version": [2, 0], "later": 1}"#);
    let dataset = place.path("set").to_string_lossy().into_owned();
    // In one process, because most of the time goes into imports.
    let run = r#"
import runpy, sys
sys.path.insert(0, "examples")
scripts, sys.argv[2:] = sys.argv[2:], []
for script in scripts:
    try:
        runpy.run_path(script, run_name="__main__")
        print(script, "went on")
    except SystemExit as end:
        print(script, end.code)
"#;
    let scripts: Vec<String> = EXAMPLES.iter().map(|name| format!("examples/{name}.py")).collect();
    let others = ["check_readers.py", "calibrate.py"];
    let all: Vec<&str> = scripts.iter().map(String::as_str).chain(others).collect();
    let said = python(&place.path("."), &[&["-c", run, &dataset][..], &all].concat());
    for script in all {
        let told = said.line(&format!("{script} "));
        assert!(told.contains("schema 2.0, newer than 1.x"), "{script}: {told}");
    }
    for name in EXAMPLES {
        // Without the environment's packages.
        let said = python(&place.path("."), &["-S", &format!("examples/{name}.py"), &dataset]);
        assert!(said.code == 1 && said.err.contains("`make venv` installs it"), "{name}: {}", said.err);
    }
    let folder = fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/python/examples")).expect("there");
    let found =
        folder.filter(|entry| entry.as_ref().is_ok_and(|e| e.path().extension().is_some_and(|end| end == "py")));
    assert_eq!(found.count(), EXAMPLES.len() + 1, "an example is not asked here");
}
