//! Datasets of earlier versions: docs/guide/older-datasets.md says what each command does with them, and each line of
//! its table is tried here.
//!
//! tests/data/older holds datasets as programs of schema 1.7 (commit 68a0c405) and 1.8 (commit a57bb0b9) wrote them,
//! version 0.2.0 before its release: four boards of 48 x 32 pixels in two shards, with EXR files and sensor frames, of
//! wood-small with a coarser field and without speckle. A new minor number of the schema brings a dataset of the one
//! before it.

use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;
use std::process::Command;
use std::sync::Arc;

use crate::models::{CHANNEL, model, needs_onnxruntime};
use crate::scripts::interpreter;
use serde_json::{Value, json};
use sheetlight::api::{Grey, StoredDataset};
use test_support::program::{Place, Run};

/// The last two schemas before this one, of which a dataset is kept each.
const LAST_TWO: [&str; 2] = ["1.8", "1.7"];

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// A folder with the dataset as `old`, under the number of a schema, the recipe that it keeps as `text.yaml`, and a
/// model.
fn place(schema: &str) -> Place {
    let place = Place::new();
    let kept = LAST_TWO.into_iter().find(|last| *last == schema).unwrap_or(LAST_TWO[1]);
    let tar = root().join(format!("tests/data/older/{kept}.tar.gz"));
    let run = Command::new("tar").arg("-xzf").arg(tar).arg("-C").arg(place.path(".")).status().expect("tar starts");
    assert!(run.success(), "{kept} is not unpacked");
    let head = place.json("old/dataset.json");
    place.write("text.yaml", head["recipe"]["text"].as_str().expect("a recipe"));
    let numbers: Vec<u32> = schema.split('.').map(|number| number.parse().expect("a number")).collect();
    for name in ["old/dataset.json", "old/shards/00000.json", "old/shards/00001.json"] {
        let mut document = place.json(name);
        if schema != kept {
            document["schema_version"] = json!(numbers);
            place.write(name, format!("{document:#}\n"));
        }
    }
    fs::copy(model("pixel_sign.onnx"), place.path("knots.onnx")).expect("copied");
    let classes = "[clear, {name: knot, of: [sound_knot, dead_knot]}]";
    place.write("knots.yaml", format!("task: segment\n{CHANNEL}\nclasses: {classes}\n"));
    place
}

/// Runs a command of the page.
fn obey(place: &Place, command: &str) -> Run {
    if let Some(arguments) = command.strip_prefix("gen ") {
        return place.run(arguments);
    }
    let words: Vec<&str> = command.split(' ').collect();
    let ["python", script, dataset] = words[..] else { panic!("{command}") };
    let home = place.path("home");
    let run = interpreter()
        .arg(root().join(script))
        .arg(place.path(dataset))
        .envs([("HF_HUB_OFFLINE", "1"), ("HF_DATASETS_OFFLINE", "1")])
        .env("HF_HOME", home)
        .output()
        .expect("python starts");
    let text = |bytes| String::from_utf8(bytes).expect("it writes UTF-8");
    Run { code: run.status.code().unwrap_or(-1), out: text(run.stdout), err: text(run.stderr) }
}

/// Each line of the page's table, on each dataset; files of the dataset itself stay as they are.
#[test]
#[ignore = "long"]
fn commands_do_what_the_page_says() {
    needs_onnxruntime();
    let text = fs::read_to_string(root().join("docs/guide/older-datasets.md")).expect("the page is there");
    let table = text.split("| command |").nth(1).expect("a table").split("\n\n").next().expect("its rows");
    let schemas: Vec<&str> = table.lines().next().expect("a head").split("schema ").skip(1).collect();
    let schemas: Vec<&str> = schemas.iter().map(|rest| rest.trim_end_matches([' ', '|'])).collect();
    assert!(LAST_TWO.iter().all(|last| schemas.contains(last)), "{schemas:?}");
    let mut faults = Vec::new();
    for (column, schema) in schemas.iter().enumerate() {
        let place = place(schema);
        let before = samples_of(&place);
        for row in table.lines().skip(2) {
            let cells: Vec<&str> = row.trim_matches('|').split(" | ").map(str::trim).collect();
            let command = cells[0].trim_matches('`');
            let run = obey(&place, command);
            let said = format!("{}{}", run.out, run.err);
            let is_so = match cells[1 + column].strip_prefix("refused: ") {
                None => cells[1 + column] == "works" && run.code == 0,
                Some(words) => run.code != 0 && said.contains(words.trim_matches('`')),
            };
            if !is_so {
                faults.push(format!("{schema}: {command}: not {}: {} {said}", cells[1 + column], run.code));
            }
        }
        assert!(samples_of(&place) == before, "{schema}: files of samples changed");
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// The files of samples and the head.
fn samples_of(place: &Place) -> BTreeMap<String, Vec<u8>> {
    let mut files = place.tree("old");
    files.retain(|name, _| !name.starts_with("reports/") && !["README.md", "croissant.json"].contains(&name.as_str()));
    files
}

/// What the program, Python and exports read is what the earlier program wrote: every sample with its images; a check
/// counts every labelled pixel; PNG files have the pixels of the tables.
#[test]
#[ignore = "long"]
fn samples_are_what_was_written() {
    needs_onnxruntime();
    for schema in LAST_TWO {
        let place = place(schema);
        let stored = Arc::new(StoredDataset::open(&place.path("old")).expect("it opens"));
        assert_eq!(stored.samples().count(), 4, "{schema}");
        let samples = place.samples("old");
        place.done("export png old --out png");
        let pictures = place.tree("png");
        let mut labelled = 0;
        for (index, sample) in &samples {
            let read = stored.sample(*index as u64).expect("it is read");
            for name in ["range", "reflectance", "scatter", "label"] {
                let (_, _, numbers) = sample.image(name);
                let found = match read.image(name).expect("it is whole").expect("it is there") {
                    Grey::Eight(pixels) => pixels.into_iter().map(u16::from).collect(),
                    Grey::Sixteen(pixels) => pixels,
                };
                assert!(found == numbers, "{schema}: {name} of {index}");
                if name == "label" {
                    labelled += numbers.iter().filter(|label| [1, 2, 3].contains(*label)).count();
                }
            }
            assert!(read.channel("Scatter").expect("it is whole").is_some(), "{schema}: EXR of {index}");
            let numbers = read.numbers().expect("they are known");
            assert_eq!(numbers["id"], sample.text("id"));
            let (cols, rows, scatter) = sample.image("scatter");
            let own = pictures.iter().find(|(path, _)| path.ends_with(&format!("scatter/{index:08}.png")));
            let picture = image::load_from_memory(own.expect("it is exported").1).expect("a PNG").into_luma16();
            assert!((picture.width(), picture.height()) == (cols, rows) && picture.into_raw() == scatter, "{schema}");
        }
        let run = place.done("check old --model knots.onnx --split all --json");
        let found: Value = serde_json::from_str(&run.out).expect("it prints JSON");
        assert_eq!(found["accuracy"]["of"], labelled, "{schema}");
    }
}

/// Files that differ from what their manifest says are told of older datasets too, and nothing is to be removed.
#[test]
fn damage_of_older_datasets_is_told() {
    for schema in LAST_TWO {
        let place = place(schema);
        let clean = place.run("validate old");
        assert!(clean.code == 1 && clean.err.contains("1 fault"), "{schema}: {}{}", clean.out, clean.err);
        let path = place.tree("old").into_keys().find(|path| path.starts_with("data/")).expect("a table");
        let mut bytes = fs::read(place.path("old").join(&path)).expect("it is there");
        bytes[1000] ^= 1;
        fs::write(place.path("old").join(&path), bytes).expect("written");
        let told = place.run("validate old").out;
        assert!(told.contains("file-checksum") && !told.contains("remove the shard"), "{schema}: {told}");
    }
}

/// The page's words on versions are the program's.
#[test]
fn the_page_names_the_schemas() {
    let text = fs::read_to_string(root().join("docs/guide/older-datasets.md")).expect("the page is there");
    let [major, minor] = output_schema::SCHEMA_VERSION;
    let oldest = output_schema::OLDEST_MINOR;
    let words = format!("writes schema {major}.{minor}, reads {major}.{oldest} to {major}.{minor}");
    assert!(text.contains(&words), "the page does not say: {words}");
    assert_eq!(LAST_TWO.map(String::from), [1, 2].map(|back| format!("{major}.{}", minor - back)));
}
