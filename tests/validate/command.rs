//! Purpose: `gen validate` as a program: its options, its JSON, the report that it keeps, its exit status.

use std::fs;

use serde_json::Value;
use test_support::program::Place;

fn json(text: &str) -> Value {
    serde_json::from_str(text).expect("JSON")
}

/// A small dataset of six boards in `set`.
fn boards() -> Place {
    let place = Place::with(&[]);
    place.make("set", "--n 6 --samples-per-shard 4");
    place
}

#[test]
fn the_report_is_printed_and_kept() {
    let place = boards();
    let run = place.done("validate set --json --save --rerender 2 --rows-seed 5");
    let printed = json(&run.out);
    assert_eq!((&printed["clean"], &printed["samples"], &printed["rerendered"]), (&true.into(), &6.into(), &2.into()));
    // A place with eight rows in each of the other samples.
    assert_eq!((&printed["rows"], &printed["rows_seed"], &printed["unexposed"]), (&32.into(), &5.into(), &0.into()));
    let mut kept = place.json("set/reports/validation.json");
    let document = kept.as_object_mut().expect("an object");
    assert_eq!(document.shift_remove("format"), Some("sheetlight-validation".into()));
    for sum in ["dataset_sha256", "manifests_sha256"] {
        let sum = document.shift_remove(sum).expect("a sum");
        assert!(sum.as_str().is_some_and(|sum| sum.len() == 64), "{sum}");
    }
    assert_eq!(kept, printed);
    // It is no file too many, is written anew, and depends on no threads.
    let before = place.tree("set");
    let again = place.done("validate set --json --save --rerender 2 --rows-seed 5 --threads 1");
    assert_eq!(again.out, run.out);
    assert!(before == place.tree("set"), "the second report is another one");
}

#[test]
fn the_seed_chooses_samples() {
    let place = boards();
    let chosen = |seed: u64| {
        let run = place.done(&format!("validate set --json --rerender 3 --rerender-seed {seed}"));
        json(&run.out)["chosen"].as_array().expect("a list").clone()
    };
    let all: Vec<Vec<Value>> = (0..4).map(chosen).collect();
    assert!(all.iter().all(|chosen| chosen.len() == 3), "{all:?}");
    assert_eq!(chosen(0), all[0]);
    // Four equal choices of 20 come once in 8000 datasets; this one is always the same.
    assert!(all.iter().any(|chosen| *chosen != all[0]), "{all:?}");
}

/// Nobody knows before which rows are exposed again, and whoever read the report can expose the same ones.
#[test]
fn rows_are_others_each_time_and_can_be_told_again() {
    let place = boards();
    let seeds: Vec<Value> =
        (0..2).map(|_| json(&place.done("validate set --json --rerender 0").out)["rows_seed"].clone()).collect();
    assert_ne!(seeds[0], seeds[1]);
    let text = place.done("validate set --rerender 0 --rows 3 --rows-seed 77").out;
    assert!(text.contains("rows exposed again (--rows-seed 77); 0 faults"), "{text}");
    let none = json(&place.done("validate set --json --rerender 0 --rows 0").out);
    assert_eq!((&none["rows"], &none["rows_seed"], &none["unexposed"]), (&0.into(), &Value::Null, &6.into()));
    let help = place.done("validate --help").out;
    for word in ["1 - (1 - s)^K", "1 - (1 - s)^(K N)", "--rows-seed", "1 % of the rows"] {
        assert!(help.contains(word), "no `{word}` in {help}");
    }
}

/// A model of transport that takes seconds for a line: no rows, unless they are asked for; that is said and counted.
#[test]
fn slow_models_are_left_out_and_counted() {
    let few = "\ntransport: {model: path, photons_per_profile: 1000}\nclasses:\n";
    let place = Place::with(&[["\nclasses:\n", few], ["\n  profiles: 48 ", "\n  profiles: 8 "]]);
    place.make("set", "--n 2");
    let run = place.done("validate set --json --rerender 0");
    let report = json(&run.out);
    assert_eq!((&report["rows"], &report["unexposed"]), (&0.into(), &2.into()));
    assert!(run.err.contains("no rows are exposed again") && run.err.contains("--rows"), "{}", run.err);
    let run = place.done("validate set --json --rerender 0 --rows 2");
    let report = json(&run.out);
    assert!(report["rows"].as_u64().is_some_and(|rows| (2..=4).contains(&rows)), "{report:#}");
    assert_eq!((&report["unexposed"], run.err.contains("no rows")), (&0.into(), false));
}

#[test]
fn faults_give_a_status() {
    let place = boards();
    let card = fs::read(place.path("set/README.md")).expect("there");
    fs::write(place.path("set/notes.txt"), "x").expect("written");
    fs::remove_file(place.path("set/README.md")).expect("there");
    let run = place.run("validate set --json --save --rerender 0");
    let report = json(&run.out);
    assert_eq!((run.code, &report["clean"]), (1, &false.into()), "{}", run.err);
    assert_eq!(report["fault_counts"], serde_json::json!({ "file-missing": 1, "file-unexpected": 1 }));
    assert!(run.err.contains("set has 2 faults"), "{}", run.err);
    assert_eq!(place.json("set/reports/validation.json")["fault_counts"], report["fault_counts"]);
    let text = place.run("validate set --rerender 0");
    assert!(text.code == 1 && text.out.contains("file-unexpected") && text.out.contains("notes.txt"), "{}", text.out);

    fs::write(place.path("set/README.md"), card).expect("written");
    fs::remove_file(place.path("set/notes.txt")).expect("there");
    assert_eq!(place.done("validate set --rerender 0").code, 0);
    assert_eq!(place.run("validate nowhere").code, 1);
    for arguments in ["validate set --threads 0", "validate set --rerender -1", "validate"] {
        assert_eq!(place.run(arguments).code, 2, "{arguments}");
    }
}

/// A report that cannot be kept: told with its place and a remedy that the command has.
#[test]
fn a_report_that_cannot_be_kept() {
    let place = boards();
    fs::create_dir_all(place.path("set/reports/validation.json")).expect("made");
    let run = place.run("validate set --save --rerender 0");
    assert!(run.code == 1 && run.err.contains("validation.json") && run.err.contains("without --save"), "{}", run.err);
    assert!(!run.err.contains("--out"), "{}", run.err);
    fs::remove_dir_all(place.path("set/reports")).expect("there");
    fs::write(place.path("set/reports"), "x").expect("written");
    let run = place.run("validate set --save --rerender 0");
    assert!(run.code == 1 && run.err.contains("reports") && run.err.contains("without --save"), "{}", run.err);
}
