//! `gen export` where something is wrong: stopped, damaged, misused; never a panic, always a place and a remedy.

use std::fs;
use std::path::Path;

use test_support::program::{Place, assert_same, recipe, sawtooth_recipe, until};
use tools::export::{EXPORTS, ExportSource, Selection};

/// A dataset of eight samples in shards of four, in `set`.
fn dataset(text: String) -> Place {
    let place = Place::new();
    place.write("tiny.yaml", text);
    place.make("set", "--n 8 --samples-per-shard 4");
    place
}

/// The first file of a folder whose name ends so.
fn first(place: &Place, folder: &str, end: &str) -> String {
    let name = place.tree(folder).into_keys().find(|name| name.ends_with(end)).expect("there is one");
    format!("{folder}/{name}")
}

/// Files in a folder that is being written.
fn files(folder: &Path) -> usize {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    entries.map(|entry| if entry.path().is_dir() { files(&entry.path()) } else { 1 }).sum()
}

/// Killed wherever it stands, an export says that it is unfinished, takes no other order, and the same command finishes
/// it with the bytes of one that was never stopped.
#[test]
fn a_stopped_export_is_finished() {
    let place =
        dataset(recipe(&[["\n  columns: 64 ", "\n  columns: 256 "], ["\n  profiles: 48 ", "\n  profiles: 256 "]]));
    for order in [
        "png set --colour",
        "coco set --image rgb",
        "yolo set",
        "mvtec3d set --split train --patch-px 32",
        "webdataset set --tar-mb 1",
        "icon set",
    ] {
        let format = order.split(' ').next().unwrap_or_default();
        place.done(&format!("export {order} --out {format}-whole"));
        let mut stopped = 0;
        for attempt in 0..20 {
            let out = format!("{format}-{attempt}");
            let mut child =
                place.command(&format!("export {order} --out {out} --threads 1")).spawn().expect("it starts");
            let marker = place.path(&out).join(".unfinished-export.json");
            // With another number of files each time, or as it ends where there are never so many.
            until(&mut child, || marker.exists() && files(&place.path(&out)) > attempt % 5);
            child.kill().expect("it is ours");
            child.wait().expect("it is ours");
            let unfinished = !place.path(&out).join("export.json").exists();
            // Between the last file and the end both are there.
            assert!(!unfinished || marker.exists(), "{out}: nothing says that it is unfinished");
            if unfinished && attempt == 0 {
                let other = place.run(&format!("export mvtec set --out {out} --split train"));
                assert!(other.code == 1 && other.err.contains("repeat the command"), "{}", other.err);
            }
            stopped += u32::from(unfinished);
            place.done(&format!("export {order} --out {out}"));
            assert_same(&place.tree(&format!("{format}-whole")), &place.tree(&out), &out);
            if stopped == 3 {
                break;
            }
        }
        assert!(stopped > 0, "{format}: no run was stopped in time");
    }
}

/// Stopped after its last file and before the marker was removed, an export is finished; another order still is
/// another.
#[test]
fn a_marker_that_was_left_is_removed() {
    let place = dataset(recipe(&[]));
    place.done("export png set --out o");
    let whole = place.tree("o");
    let order = place.json("o/export.json")["order"].to_string();
    place.write("o/.unfinished-export.json", &order);
    let other = place.run("export png set --out o --colour");
    assert!(other.code == 1 && other.err.contains("another export"), "{}", other.err);
    let marker = place.path("o/.unfinished-export.json");
    let held = fs::File::open(&marker).expect("it was written");
    held.lock().expect("nobody holds it");
    let busy = place.run("export png set --out o");
    assert!(busy.code == 1 && busy.err.contains("another process") && marker.exists(), "{}", busy.err);
    drop(held);
    assert!(place.done("export png set --out o").err.contains("nothing to do"));
    assert_same(&whole, &place.tree("o"), "the marker is gone, and nothing else changed");
}

/// Scales come from the shards that were finished when the dataset was opened, as its checksum says.
#[test]
fn shards_that_are_finished_later_change_no_scale() {
    let place = dataset(recipe(&[]));
    let (later, hidden) = (place.path("set/shards/00001.json"), place.path("later.json"));
    let coco = EXPORTS.iter().find(|format| format.name == "coco").expect("it is there");
    let options = (coco.add_options)(clap::Command::new("coco")).get_matches_from(["coco", "--image", "range"]);
    let coco = (coco.read)(&options).expect("they are its own");
    let export = |out: &str, while_it_runs: &dyn Fn()| {
        let source = ExportSource::open(&place.path("set"), Selection::default()).expect("a shard is finished");
        while_it_runs();
        coco.write(&source, &place.path(out), &|_, _| ()).expect("it is whole");
        place.json(&format!("{out}/export.json"))
    };
    let whole = export("whole", &|| ());
    fs::rename(&later, &hidden).expect("it is there");
    let half = export("half", &|| ());
    let then = export("then", &|| fs::rename(&hidden, &later).expect("it is there"));
    assert_ne!(half["result"]["scaling"], whole["result"]["scaling"], "the later shard has other heights");
    assert_eq!(half, then);
}

/// What is done to the bytes of a file.
type Damage<'a> = &'a dyn Fn(&mut Vec<u8>);

/// Damage anywhere is told with the file and `gen validate`; nothing panics, and what is there stays unfinished.
#[test]
fn damage_is_told() {
    let rows = dataset(recipe(&[]));
    let exr = dataset(recipe(&[["png: [range, reflectance, scatter, label]", "png: []"]]));
    let table = first(&rows, "set/data", ".parquet");
    let image = first(&exr, "set/exr", ".exr");
    let manifest = "set/shards/00000.json".to_owned();
    let change = |place: &Place, path: &str, change: &dyn Fn(&mut Vec<u8>)| {
        let mut bytes = fs::read(place.path(path)).expect("it is there");
        change(&mut bytes);
        place.write(path, bytes);
    };
    let find =
        |bytes: &[u8], word: &[u8]| bytes.windows(word.len()).position(|part| part == word).expect("it is in it");
    let cases: [(&Place, &str, &str, Damage); 8] = [
        (&rows, &table, "sample", &|bytes| {
            let at = find(bytes, b"IDAT") + 30;
            bytes[at] ^= 1;
        }),
        (&rows, &table, "", &|bytes| bytes.truncate(bytes.len() - 9)),
        (&rows, &table, "", &|bytes| bytes.clear()),
        (&rows, &manifest, "cannot be read", &|bytes| bytes[0] = b'['),
        (&rows, &manifest, "newer", &|bytes| {
            let at = find(bytes, b"schema_version\": [\n    1") + 23;
            bytes[at] = b'2';
        }),
        (&exr, &image, "", &|bytes| bytes.truncate(bytes.len() / 2)),
        (&exr, &image, "", &|bytes| bytes[0] = 0),
        (&exr, &image, "EXR", &|bytes| {
            // A channel of another name is a channel less.
            let at = find(bytes, b"Instance");
            bytes[at] = b'J';
        }),
    ];
    for (i, (place, path, words, damage)) in cases.into_iter().enumerate() {
        let good = fs::read(place.path(path)).expect("it is there");
        change(place, path, damage);
        for format in ["png", "coco", "yolo", "webdataset"] {
            let out = format!("{format}-{i}");
            let run = place.run(&format!("export {format} set --out {out}"));
            // Without the map that is damaged there is nothing to see.
            if ["coco", "yolo"].contains(&format) && run.code == 0 {
                continue;
            }
            let name = if i == 7 { "set/data" } else { path };
            let told = [name, "gen validate", words].iter().all(|word| run.err.contains(word));
            assert!(run.code == 1 && told, "case {i}, {format}: {}", run.err);
            assert!(!place.path(&out).join("export.json").exists(), "case {i}: it is not finished");
        }
        place.write(path, good);
    }
    fs::remove_file(exr.path(&image)).expect("it is there");
    let run = exr.run("export coco set --out gone");
    assert!(run.code == 1 && run.err.contains(&image) && run.err.contains("gen validate"), "{}", run.err);
}

/// Bytes flipped anywhere in a table end in an export or in a fault, never in a panic.
#[test]
fn flipped_bytes_never_panic() {
    let place = dataset(recipe(&[]));
    let table = first(&place, "set/data", ".parquet");
    let good = fs::read(place.path(&table)).expect("it is there");
    let mut told = 0;
    for i in 0..40_usize {
        let mut bytes = good.clone();
        let n = bytes.len();
        // Half of them in the last kilobytes, where columns and places are described.
        let at = if i % 2 == 0 { i * 7919 * 31 % n } else { n - 1 - i * 131 % 6000 };
        bytes[at] ^= 1 << (i % 8);
        place.write(&table, bytes);
        let run = place.run(&format!("export png set --out out-{i}"));
        assert!(run.code == 0 || run.err.contains("gen validate"), "byte {at}: {}", run.err);
        told += u32::from(run.code == 1);
    }
    assert!(told > 10, "{told} of 40 were told");
}

/// Names of a damaged dataset lead out of no folder.
#[test]
fn names_stay_in_the_folder() {
    let place = dataset(recipe(&[["{train: 0.8, validation: 0.1, test: 0.1}", "{train: 0, validation: 0, test: 1}"]]));
    let text = fs::read_to_string(place.path("set/dataset.json")).expect("it is there");
    place.done("export mvtec set --out good --patch-px 16 --split test");
    let folders = fs::read_dir(place.path("good/ground_truth")).expect("there are defects");
    let names = folders.map(|folder| folder.expect("it can be listed").file_name().into_string().expect("it is ASCII"));
    let names: Vec<String> = names.filter(|name| name != "combined").collect();
    assert!(!names.is_empty(), "no patch shows one defect alone");
    for name in names {
        let bad = text.replace(&format!("\"{name}\""), "\"../../evil\"");
        place.write("set/dataset.json", bad);
        let run = place.run(&format!("export mvtec set --out deep/{name} --patch-px 16 --split test"));
        assert!(run.code == 1 && run.err.contains("no name for a folder"), "{name}: {} {}", run.code, run.err);
        assert!(!place.path("evil").exists() && !place.path("deep/evil").exists());
    }
    let all = text.replace("\"sound_knot\"", "\"../../evil\"").replace("\"dead_knot\"", "\"../../evil\"");
    place.write("set/dataset.json", all.replace("\"rot\"", "\"../../evil\""));
    let run = place.run("export mvtec set --out deep/all --patch-px 16 --split test");
    assert!(run.code == 1 && run.err.contains("gen validate"), "{}", run.err);
}

/// Whatever cannot be used is told with its place and a remedy, before anything is written.
#[test]
fn misuse_is_told() {
    let place = dataset(recipe(&[]));
    fs::create_dir(place.path("full")).expect("the folder is ours");
    place.write("full/note.txt", "mine");
    place.write("file", "mine");
    for (arguments, code, words) in [
        ("coco nowhere --out o", 1, "name the folder of a dataset"),
        ("coco set", 2, "--out"),
        ("cooc set --out o", 2, "coco"),
        ("coco set --out full", 1, "choose an empty folder"),
        ("coco set --out file", 1, "file"),
        ("coco set --out set/inside", 2, "choose a folder elsewhere"),
        ("coco set --out o --index 9", 1, "give --index 0 to 7"),
        ("coco set --out o --index 5-2", 2, "0-99"),
        ("coco set --out o --index 5 --split train --threads 0", 2, "1 or more"),
        ("coco set --out o --image rgb --bits 16", 2, "choose one map"),
        ("coco set --out o --bits 16", 2, "give another --image"),
        ("coco set --out o --image range --bits 16 --range-ends 5,9", 2, "leave them or --bits away"),
        ("coco set --out o --image range --range-ends 5,5", 2, "LOW,HIGH"),
        ("coco set --out o --image range --range-ends 10,x,30", 2, "LOW,HIGH"),
        ("coco set --out o --image range --range-ends 5,inf", 2, "LOW,HIGH"),
        ("coco set --out o --image scatter --scatter-ends 5,,9,", 2, "LOW,HIGH"),
        ("coco set --out o --range-ends 5,9", 2, "--image range or rgb"),
        ("mvtec set --out o --image range --scatter-ends 5,9", 2, "--image scatter or rgb"),
        ("yolo set --out o --image scatter --range-ends 5,9", 2, "--image range or rgb"),
        ("mvtec3d set --out o --image range --scatter-ends 5,9", 2, "--image scatter or rgb"),
        ("coco set --out o --polygons --plain-rle", 2, "cannot be used with"),
        ("icon set --out o --sensor --rate 500", 2, "leave one of them away"),
        ("icon set --out o --sensor --words", 2, "leave one of them away"),
        ("coco set --out set/../set/inside", 2, "choose a folder elsewhere"),
        ("coco set --out gone/../set/inside", 2, "choose a folder elsewhere"),
        ("mvtec set --out o --split validation", 2, "no folder for validation"),
        ("mvtec set --out o --good knot", 1, "sound_knot"),
        ("mvtec set --out o --patch-px 65", 1, "give up to 48"),
        ("png set --out o --maps colour", 2, "reflectance"),
        ("icon set --out o --sensor", 1, "sensor_stack"),
        ("webdataset set --out o --tar-mb 0", 2, "0 is not in"),
    ] {
        let run = place.run(&format!("export {arguments}"));
        assert!(run.code == code && run.err.contains(words), "{arguments}: {} '{words}': {}", run.code, run.err);
        assert!(!place.path("o").exists() && run.out.is_empty(), "{arguments}: {}", run.out);
        let clauses: Vec<&str> = run.err.split("; ").map(str::trim).collect();
        assert!(clauses.windows(2).all(|pair| pair[0] != pair[1]), "{arguments}: said twice: {}", run.err);
    }
    assert_eq!(place.tree("full").len(), 1);
    let rows = dataset(recipe(&[["\n  window_rows: 7", "\n  range: uncalibrated\n  window_rows: 7"]]));
    let run = rows.run("export icon set --out o --words");
    let told = run.err.contains("--words has no effect") && run.err.contains("leave it away");
    assert!(run.code == 2 && told && !rows.path("o").exists(), "{} {}", run.code, run.err);
    rows.run("export mvtec3d set --out o").refused(&["its Range is sensor rows", "or export it as mvtec"]);
    let saw = dataset(sawtooth_recipe(&[]));
    for (format, words) in
        [("mvtec", "has no defects"), ("coco", "no classes to tell apart"), ("yolo", "no classes to tell apart")]
    {
        let run = saw.run(&format!("export {format} set --out o"));
        assert!(run.code == 1 && run.err.contains(words) && !saw.path("o").exists(), "{}", run.err);
        assert!(run.err.contains("export it as png or webdataset"), "{}", run.err);
    }
    saw.done("export mvtec set --out teeth --good tooth --image range --split train");
    saw.done("export png set --out o --colour");
    // From within the dataset, a folder beside it is no part of it.
    let beside = saw.command("export png . --out ../beside").current_dir(saw.path("set")).output().expect("it starts");
    assert!(beside.status.success(), "{}", String::from_utf8_lossy(&beside.stderr));
    let none = saw.run("export mvtec set --out none --split train --good background");
    assert!(none.code == 1 && none.err.contains("nothing to write"), "{}", none.err);
    saw.done("export png set --out none");
    let bare = dataset(recipe(&[
        ["exr: [range, reflectance, scatter, label, instance]", "exr: []"],
        ["truth_maps: true", "truth_maps: false"],
    ]));
    let run = bare.run("export coco set --out o");
    assert!(run.code == 1 && run.err.contains("add instance to `output: {png: [..]}`"), "{}", run.err);
    // A dataset that is not finished is exported as far as it goes, and says so.
    fs::remove_file(bare.path("set/shards/00001.json")).expect("it is there");
    let run = bare.done("export png set --out o");
    assert!(run.err.contains("left out: 1 shard of the dataset"), "{}", run.err);
}
