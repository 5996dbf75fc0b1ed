//! Bad command lines and bad recipes: refused with a status, a reason and a remedy, before anything is made.

use std::fs;
use std::process::Command;

use test_support::program::{Place, assert_same, program, recipe};

/// Runs a command that must be refused with all of `words`, and must leave no file behind.
fn refused(place: &Place, code: i32, arguments: &str, words: &[&str]) {
    let before = place.tree("");
    let run = place.run(arguments);
    assert_eq!(run.code, code, "gen {arguments}:\n{}{}", run.out, run.err);
    for word in words {
        assert!(run.err.contains(word), "gen {arguments}: no `{word}` in\n{}", run.err);
    }
    assert_same(&before, &place.tree(""), arguments);
    assert!(!place.path("set").exists(), "gen {arguments} leaves a folder");
}

#[test]
fn numbers_that_cannot_be() {
    let place = Place::with(&[]);
    let cases: [(&str, &[&str]); 16] = [
        ("", &["--n is missing", "--n 100"]),
        ("--n 0", &["--n 0", "1 sample or more"]),
        ("--n 100000001", &["100000001", "at most 100000000"]),
        ("--n 99999999999999999999", &["99999999999999999999"]),
        ("--n -3", &["-3"]),
        ("--n many", &["many", "--n"]),
        ("--n 4 --threads 0", &["--threads 0", "1 or more"]),
        ("--n 4 --threads 1000000", &["--threads 1000000", "at most", "core"]),
        ("--n 4 --part 4/4", &["4/4", "K < M"]),
        ("--n 4 --part x", &["'x'", "K/M", "0/4"]),
        ("--n 4 --part 0/0", &["0/0"]),
        ("--n 4 --part -1/2", &["-1/2", "K/M", "0/4"]),
        ("--n 4 --progress -1", &["-1", "--progress", "not negative"]),
        ("--n 4 --samples-per-shard 0", &["--samples-per-shard 0", "1 to 100000"]),
        ("--n 4 --samples-per-shard 100001", &["100001", "1 to 100000"]),
        ("--n 2000000 --samples-per-shard 1", &["2000000 shards", "at most 100000", "--samples-per-shard"]),
    ];
    for (arguments, words) in cases {
        refused(&place, 2, &format!("--recipe tiny.yaml --out set {arguments}"), words);
    }
    refused(&place, 2, "--n 4 --out set", &["which recipe?", "--recipe wood.yaml", "gen recipe list"]);
    refused(&place, 2, "--recipe tiny.yaml --n 4 --out set --seed 1.5", &["1.5", "--seed"]);
    refused(&place, 2, "tiny.yaml --recipe tiny.yaml --n 4 --out set", &["--recipe", "[RECIPE]", "--help"]);
    refused(&place, 2, "preview --recipe tiny.yaml --index x", &["'x'", "--index"]);
    refused(&place, 2, "preview --recipe tiny.yaml --index -1", &["-1"]);
    refused(&place, 2, "schema recipes", &["recipes", "recipe, dataset"]);
}

#[test]
fn recipes_that_cannot_be() {
    let place = Place::new();
    let long = |columns: &str| recipe(&[["\n  columns: 64 ", columns]]);
    place.write("tiny.yaml", "");
    place.write("empty.yaml", "");
    place.write("huge.yaml", long("\n  columns: 1000000000 "));
    place.write("pixels.yaml", recipe(&[["\n  columns: 64 ", "\n  columns: 16384 "], ["s: 48 ", "s: 16383 "]]));
    place.write("bomb.yaml", include_str!("../../fuzz/seeds/recipe/bomb.yaml"));
    let mut nested = String::from("a0: &a0 [x, x, x, x, x, x, x, x, x, x]\n");
    for i in 1..12 {
        let p = i - 1;
        nested += &format!("a{i}: &a{i} [*a{p}, *a{p}, *a{p}, *a{p}, *a{p}, *a{p}, *a{p}, *a{p}, *a{p}, *a{p}]\n");
    }
    place.write("laughs.yaml", nested);
    place.write("binary.yaml", [0xff, 0xfe, 0x00, 0x80]);
    fs::create_dir(place.path("folder.yaml")).expect("a folder");
    let cases: [(&str, &[&str]); 9] = [
        ("wod.yaml", &["wod.yaml", "did you mean `wood`", "wood-small"]),
        ("recipes/wood-smal", &["did you mean `wood-small`"]),
        ("empty.yaml", &["empty.yaml:1:1", "empty", "`subject`"]),
        ("huge.yaml", &["huge.yaml:13:", "scan.columns", "1e9", "8 to 16384"]),
        ("pixels.yaml", &["268419072 pixels", "scan.profiles", "134217728"]),
        ("bomb.yaml", &["bomb.yaml:1:1", "no key of a recipe"]),
        ("laughs.yaml", &["laughs.yaml"]),
        ("binary.yaml", &["binary.yaml:1:1", "UTF-8"]),
        ("folder.yaml", &["folder.yaml is a folder that holds no dataset.json"]),
    ];
    for (name, words) in cases {
        refused(&place, 1, &format!("--recipe {name} --n 4 --out set"), words);
        refused(&place, 1, &format!("preview --recipe {name} --out set"), words);
    }
}

#[test]
fn every_fault_of_a_recipe_is_told_at_once() {
    let changes = [["power_mw: 50", "power_w: 50"], ["  rows: 832", "  rows: 3"], ["window_rows: 7", "window_rows: 8"]];
    let place = Place::with(&changes);
    let text = recipe(&changes);
    let line = |words: &str| 1 + text.lines().position(|line| line.contains(words)).expect("it is there");
    let places =
        [("power_w:", "laser.power_w"), ("rows: 3", "camera.rows"), ("window_rows: 8", "extraction.window_rows")];
    let told = places.map(|(words, key)| format!("tiny.yaml:{}:", line(words)) + "|" + key);
    let words: Vec<&str> = told.iter().flat_map(|told| told.split('|')).collect();
    refused(&place, 1, "--recipe tiny.yaml --n 4 --out set", &words);
    refused(&place, 1, "--recipe tiny.yaml --n 4 --out set", &["3 faults", "did you mean `power_mw`", "3, 7, 15"]);
}

#[test]
fn folders_that_cannot_be() {
    let place = Place::with(&[]);
    place.write("file", "text");
    fs::create_dir(place.path("foreign")).expect("a folder");
    place.write("foreign/thesis.tex", "text");
    fs::create_dir(place.path("damaged")).expect("a folder");
    place.write("damaged/dataset.json", "{");
    let cases: [(&str, &[&str]); 6] = [
        ("file", &["file", "no folder"]),
        ("file/below", &["file/below", "no folder"]),
        ("/proc/sheetlight", &["/proc/sheetlight"]),
        ("foreign", &["foreign", "not empty", "dataset.json", "choose an empty folder"]),
        ("damaged", &["damaged", "cannot be read", "another folder"]),
        (".", &["not empty"]),
    ];
    for (out, words) in cases {
        refused(&place, 1, &format!("--recipe tiny.yaml --n 4 --out {out}"), words);
    }
    refused(&place, 1, "preview --recipe tiny.yaml --out file/a.png", &["file/a.png", "--out"]);
    refused(&place, 1, "preview --recipe tiny.yaml --out foreign", &["foreign", "--out"]);
}

#[test]
fn another_dataset_in_the_folder() {
    let place = Place::with(&[]);
    place.write("strong.yaml", recipe(&[["power_mw: 50", "power_mw: 60"]]));
    place.write("said.yaml", recipe(&[["# The bench.", "# The workbench."]]));
    place.make("made", "--n 4 --samples-per-shard 2");
    let order = "--n 4 --samples-per-shard 2 --out made --recipe";
    refused(&place, 1, &format!("{order} strong.yaml"), &["laser.power_mw: 50", "60", "choose another folder"]);
    refused(&place, 1, &format!("{order} tiny.yaml --seed 9"), &["seed: 0 -> 9"]);
    refused(&place, 1, &order.replace("shard 2", "shard 3").replace("recipe", "recipe tiny.yaml"), &["2 -> 3"]);
    // A comment is no difference.
    place.done(&format!("{order} said.yaml"));
}

/// A limit of this process is called what it is. Guards refusals of the system that are no fault of a disk, a folder or
/// a dataset: whoever looks for one there looks in vain.
#[cfg(unix)]
#[test]
fn a_limit_of_open_files_is_called_so() {
    let place = Place::with(&[]);
    place.make("set", "--n 1");
    let orders =
        ["--recipe tiny.yaml --n 1 --out new", "report set --no-timing --frames 0", "export png set --out png"];
    for order in orders {
        let mut refusals = 0;
        for limit in 4..8 {
            let limited = format!("ulimit -n {limit}; exec \"$0\" \"$@\"");
            let mut shell = Command::new("sh");
            shell.args(["-c", &limited]).arg(program()).args(order.split_whitespace()).current_dir(place.path(""));
            let output = shell.output().expect("sh starts");
            let told = String::from_utf8_lossy(&output.stderr).into_owned();
            // A reader of tables that runs out of files midway has no reason of the system any more.
            if output.status.success() || told.contains("External") || !told.contains("gen: ") {
                continue;
            }
            refusals += 1;
            assert!(told.contains("Too many open files") && told.contains("`ulimit -n"), "{order}, {limit}: {told}");
            for wrong in ["check the disk", "another place", "damaged", "made again"] {
                assert!(!told.contains(wrong), "`{wrong}` of {order}, {limit}: {told}");
            }
        }
        assert!(refusals > 0, "{order} needs fewer files than the lowest limit");
    }
}
