//! `gen export` of a dataset that is not finished or has no samples for a folder, and exports that go on.

use std::fs;
use std::os::unix::fs::MetadataExt;

use test_support::program::{Place, SPECKLE, assert_same, recipe};

/// The recipe's only light is too weak to be seen.
const DARK: [[&str; 2]; 2] = [["power_mw: 50", "power_mw: 0.1"], ["time_us: {uniform: [34, 46]}", "time_us: 1"]];

/// A dataset of tiny boards in `set`, split so.
fn dataset(samples: u32, splits: &str, changes: &[[&str; 2]]) -> Place {
    let splits = ["{train: 0.8, validation: 0.1, test: 0.1}", splits];
    let place = Place::new();
    place.write("tiny.yaml", recipe(&[&[splits][..], changes].concat()));
    place.make("set", &format!("--n {samples} --samples-per-shard 4"));
    place
}

/// Makes an export look as a run leaves it that is stopped before its last file: marked, without `export.json`.
fn stop(place: &Place, out: &str) {
    let order = place.json(&format!("{out}/export.json"))["order"].to_string();
    fs::remove_file(place.path(out).join("export.json")).expect("it was finished");
    place.write(&format!("{out}/.unfinished-export.json"), order);
}

/// Where no pixel shows the object no ends are made up: it is told which to give, and the folder is free for that.
#[test]
fn ends_are_never_made_up() {
    let place = dataset(2, "{train: 1, validation: 0, test: 0}", &DARK);
    for format in ["coco", "mvtec"] {
        let order = format!("export {format} set --out {format} --split train --image rgb --range-ends 10,30");
        let run = place.run(&order);
        let told =
            ["no pixel", "scatter", "give them with --scatter-ends LOW,HIGH"].iter().all(|w| run.err.contains(w));
        assert!(run.code == 1 && told, "{format}: {}", run.err);
        place.done(&format!("{order} --scatter-ends 10,300"));
    }
}

/// An export is of one state of its dataset: after shards were added neither a stopped nor a finished one goes on, and
/// it is told why and what to do.
#[test]
fn a_dataset_that_grew_is_exported_anew() {
    let place = dataset(8, "{train: 1, validation: 0, test: 0}", &[]);
    let (later, hidden) = (place.path("set/shards/00001.json"), place.path("later.json"));
    fs::rename(&later, &hidden).expect("it is there");
    let order = "export coco set --out o --image range";
    place.done(order);
    let before = place.tree("o");
    fs::rename(&hidden, &later).expect("it is there");
    let finished = place.run(order);
    assert!(finished.code == 1 && finished.err.contains("another state of the dataset"), "{}", finished.err);
    assert_same(&before, &place.tree("o"), "a finished export");
    stop(&place, "o");
    let run = place.run(order);
    let told = ["shards were added since", "remove the folder, or choose another"].iter().all(|w| run.err.contains(w));
    assert!(run.code == 1 && told, "{}", run.err);
    // Another order is another one, whatever became of the dataset.
    let run = place.run("export coco set --out o --image scatter");
    assert!(run.code == 1 && run.err.contains("repeat the command"), "{}", run.err);
    for marker in ["[]", "", "{\"source\": 3}"] {
        place.write("o/.unfinished-export.json", marker);
        assert_eq!(place.run(order).code, 1, "{marker}");
    }
    fs::rename(&later, &hidden).expect("it is there");
    place.write("o/.unfinished-export.json", {
        let text = String::from_utf8(before["export.json"].clone()).expect("it is JSON");
        serde_json::from_str::<serde_json::Value>(&text).expect("it is JSON")["order"].to_string()
    });
    place.done(order);
    assert_same(&before, &place.tree("o"), "a stopped export of the old state");
}

/// Tars that were finished before a stop stay as they are, and what is no finished tar of this export is written anew.
#[test]
fn finished_tars_are_kept() {
    let large = [SPECKLE, ["\n  columns: 64 ", "\n  columns: 256 "], ["\n  profiles: 48 ", "\n  profiles: 256 "]];
    let place = dataset(16, "{train: 0.8, validation: 0, test: 0.2}", &large);
    let order = "export webdataset set --out o --tar-mb 1 --maps range,reflectance,scatter";
    place.done(order);
    let whole = place.tree("o");
    let tars: Vec<&String> = whole.keys().filter(|name| name.ends_with(".tar")).collect();
    let train = tars.iter().filter(|name| name.starts_with("train")).count();
    assert!(train >= 3 && tars.len() > train, "{tars:?}");
    let file = |name: &str| place.path("o").join(name);
    let files = |names: &[&String]| -> Vec<u64> {
        names.iter().map(|name| fs::metadata(file(name)).expect("it is there").ino()).collect()
    };
    // A number of a file is given again where it was freed: each tar that must be written anew is held open.
    let goes_on = |kept: &[&String], damaged: &[&String], what: &str| {
        let held: Vec<fs::File> = damaged.iter().filter_map(|name| fs::File::open(file(name)).ok()).collect();
        let (before, old) = (files(kept), files(&damaged[..held.len()]));
        let run = place.done(order);
        assert!(run.err.contains("of 16 samples"), "{}", run.err);
        assert_same(&whole, &place.tree("o"), what);
        assert_eq!(files(kept), before, "{what}: these were whole");
        assert!(files(&damaged[..held.len()]).iter().zip(&old).all(|(new, old)| new != old), "{what}");
    };
    // Tars by name: those to test come before those to train.
    let tests = tars.len() - train;
    stop(&place, "o");
    goes_on(&tars, &[], "all were there");
    stop(&place, "o");
    fs::remove_file(file(tars[tests + 1])).expect("it is there");
    goes_on(&tars[..=tests], &tars[tests + 2..], "the second is missing");
    let bytes = &whole[tars[tests]];
    for (what, damaged) in [
        ("cut short", bytes[..bytes.len() - 512].to_vec()),
        ("too long", [bytes.as_slice(), &[0; 512]].concat()),
        ("empty", Vec::new()),
        ("without its end", bytes[..bytes.len() - 1024].to_vec()),
        ("without its last file", {
            let end = whole_files(bytes);
            [&bytes[..end], &[0; 1024]].concat()
        }),
        ("of other samples", whole[tars[tests + 1]].clone()),
        ("no tar", b"tar".repeat(1000)),
    ] {
        stop(&place, "o");
        fs::write(file(tars[tests]), damaged).expect("it is ours");
        goes_on(&tars[..tests], &tars[tests..], what);
    }
    // Tars of other maps are another export.
    stop(&place, "o");
    let run = place.run(&order.replace(",scatter", ""));
    assert!(run.code == 1 && run.err.contains("repeat the command"), "{}", run.err);
}

/// Where the last file of a tar begins [bytes].
fn whole_files(tar: &[u8]) -> usize {
    let mut archive = tar::Archive::new(tar);
    let entries = archive.entries().expect("it is a tar");
    let last = entries.map(|entry| entry.expect("it is whole").raw_header_position()).last();
    last.expect("it has files") as usize
}

/// Folders that stay empty are told where they were asked for, with the reason; samples without a place are counted.
#[test]
fn notes_are_of_what_was_asked() {
    let place = dataset(12, "{train: 0.4, validation: 0.3, test: 0.3}", &[]);
    let splits: Vec<String> = place.samples("set").values().map(|sample| sample.text("split").to_owned()).collect();
    let count = |name: &str| splits.iter().filter(|split| *split == name).count();
    assert!(["train", "validation", "test"].iter().all(|split| count(split) > 0), "{splits:?}");
    // Clear wood is no good sample here: nothing is good, and pictures to train are left out.
    let notes = |place: &Place, options: &str, out: &str| {
        let run = place.done(&format!("export mvtec set --out {out} --good rot {options}"));
        assert_eq!(
            place.json(&format!("{out}/export.json"))["notes"].as_array().map(Vec::len),
            Some(run.err.matches("note: ").count())
        );
        run.err
    };
    let all = notes(&place, "", "all");
    let left = format!("{} sample", count("validation"));
    for words in ["train/good is empty: no picture", "test/good is empty: no picture", &left, "no place for them"] {
        assert!(all.contains(words), "'{words}' is not in: {all}");
    }
    assert!(all.contains(&format!("of {} samples", count("train") + count("test"))), "{all}");
    let test = notes(&place, "--split test", "test");
    assert!(test.contains("test/good is empty") && !test.contains("train") && !test.contains("validation"), "{test}");
    let good = place.done("export mvtec set --out train --split train --patch-px 16").err;
    assert!(!good.contains("test") && !good.contains("validation") && !good.contains("is empty"), "{good}");
}

/// Folders of anomaly detection without `train` or without `test` are refused before anything is written, with what is
/// missing and what to do, unless one of them alone is asked for; where `test` shows no defect, or nothing good, a note
/// says so.
#[test]
fn a_split_without_samples_is_refused() {
    for (splits, missing, other) in [
        ("{train: 0, validation: 0, test: 1}", "train", "test"),
        ("{train: 1, validation: 0, test: 0}", "test", "train"),
        ("{train: 0.5, validation: 0.5, test: 0}", "test", "train"),
    ] {
        let few = dataset(4, splits, &[]);
        let refused = |options: &str, remedy: &str| {
            let run = few.run(&format!("export mvtec set --out o --patch-px 16 {options}"));
            let lacks = format!("the split {missing} has no samples, and the export would have no folder `{missing}`");
            let alone = format!("--split {other} exports `{other}` alone");
            run.refused(&[&lacks, remedy, &alone]);
            assert!(run.out.is_empty() && !few.path("o").exists(), "{splits} {options}: {}", run.out);
        };
        refused("", "make more samples");
        refused("--index 0-2", "give another --index");
        few.done(&format!("export mvtec set --out o --patch-px 16 --split {other}"));
        assert!(few.path("o").join(other).is_dir() && !few.path("o").join(missing).exists());
    }
    let whole = dataset(8, "{train: 0.5, validation: 0, test: 0.5}", &[]);
    let run = whole.done("export mvtec set --out all --good clear,sound_knot,dead_knot,rot");
    assert!(run.err.contains("test has no defects"), "{}", run.err);
}

/// Labels of YOLO are boxes or polygons of the classes that `data.yaml` names; a picture without objects has an empty
/// text, and what Ultralytics would refuse is told.
#[test]
fn labels_are_lines_of_named_classes() {
    let large = [SPECKLE, ["\n  columns: 64 ", "\n  columns: 256 "], ["\n  profiles: 48 ", "\n  profiles: 256 "]];
    let place = dataset(12, "{train: 0.4, validation: 0.3, test: 0.3}", &large);
    place.done("export yolo set --out boxes --task detect");
    let files = place.tree("boxes");
    let text = |name: &str| String::from_utf8(files[name].clone()).expect("it is text");
    let document = text("data.yaml");
    let head = "train: images/train\nval: images/validation\ntest: images/test\nnames:\n  0: \"";
    assert!(document.starts_with(head), "{document}");
    let names: Vec<&str> = document.lines().filter_map(|line| line.split('"').nth(1)).collect();
    let numbers = |line: &str| -> Vec<f64> { line.split(' ').map(|n| n.parse().expect("a number")).collect() };
    let (mut lines, mut empty) = (0, 0);
    place.done("export png set --out rows --maps label");
    let tables = ["train", "validation", "test"].map(|split| place.tree("rows")[&format!("{split}.jsonl")].clone());
    for line in String::from_utf8(tables.concat()).expect("it is text").lines() {
        let row: serde_json::Value = serde_json::from_str(line).expect("it is JSON");
        let index = row["index"].as_u64().expect("a number");
        let labels = text(&format!("labels/{}/{index:08}.txt", row["split"].as_str().expect("a word")));
        let objects = row["objects"].as_array().expect("a list");
        assert_eq!(labels.lines().count(), objects.len(), "{index}");
        empty += usize::from(labels.is_empty());
        for (line, object) in labels.lines().zip(objects) {
            let [class, x, y, width, height] = numbers(line)[..] else { panic!("{line}") };
            assert_eq!(object["class_name"], names[class as usize]);
            let found = [x - width / 2.0, y - height / 2.0, width, height].map(|share| share * 256.0);
            let bbox = object["bbox"].as_array().expect("a box").iter().map(|side| side.as_f64().expect("a number"));
            assert!(bbox.zip(found).all(|(side, found)| (side - found).abs() < 1e-4), "{line} {object}");
            lines += 1;
        }
    }
    assert!(lines > 3 && empty > 0, "{lines} {empty}");
    let part = place.done("export yolo set --out part --split test");
    for missing in ["no `train`", "no `val`"] {
        assert!(part.err.contains(missing), "{}", part.err);
    }
    let polygons = place.tree("part");
    let longest = polygons.iter().filter(|(name, _)| name.ends_with(".txt")).map(|(_, text)| text.len()).max();
    assert!(longest > Some(60), "polygons have more than four numbers: {longest:?}");
}
