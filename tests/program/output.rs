//! Results on standard output: a disk that takes no more is a fault, a reader that has gone away is none; and files
//! that are none of a command's own are not written over.

use std::fs::{self, OpenOptions};
use std::process::Stdio;

use test_support::program::{Place, assert_same};

/// A dataset, a scan of the camera, and a medium.
fn place() -> Place {
    let place = Place::with(&[]);
    place.make("set", "--n 2");
    place.done("export icon set --index 0 --out scan");
    let medium = concat!(env!("CARGO_MANIFEST_DIR"), "/recipes/media/clear-wood.yaml");
    place.write("medium.yaml", fs::read(medium).expect("it is there"));
    place
}

const PRINTING: [&str; 12] = [
    "--help",
    "--version",
    "validate --help",
    "validate set --json",
    "validate set",
    "schema recipe",
    "schema recipe-reference",
    "--recipe tiny.yaml --n 1 --out other --estimate",
    "icon scan/00000000.xml",
    "icon scan/00000000.xml --json",
    "compare set set",
    "transport --medium medium.yaml --model kernel",
];

#[test]
fn a_full_disk_is_a_fault() {
    let place = place();
    for arguments in PRINTING {
        let full = OpenOptions::new().write(true).open("/dev/full").expect("Linux has it");
        let run = place.command(arguments).stdout(full).output().expect("the program starts");
        let told = String::from_utf8_lossy(&run.stderr);
        assert_eq!(run.status.code(), Some(1), "gen {arguments}: {told}");
        assert!(
            told.contains("cannot write to standard output") && !told.contains("panicked"),
            "gen {arguments}: {told}"
        );
    }
}

#[test]
fn a_reader_that_has_gone_away_is_no_fault() {
    let place = place();
    for arguments in PRINTING {
        let mut child = place.command(arguments).stdout(Stdio::piped()).spawn().expect("the program starts");
        drop(child.stdout.take());
        let run = child.wait_with_output().expect("it ends");
        let told = String::from_utf8_lossy(&run.stderr);
        assert_eq!(run.status.code(), Some(0), "gen {arguments}: {told}");
        assert!(!told.contains("standard output"), "gen {arguments}: {told}");
    }
}

#[test]
fn nothing_is_written_over_what_is_none_of_its_own() {
    let place = place();
    place.write("notes.png", "no picture");
    place.write("notes.json", "no answer");
    let before = place.tree("set");
    for (arguments, told) in [
        ("preview --recipe tiny.yaml --out set/dataset.json", "ends in .png"),
        ("preview --recipe tiny.yaml --out set/picture.png", "lies in the dataset"),
        ("preview --recipe tiny.yaml --out notes.png", "choose another name, or remove it"),
        ("preview --recipe tiny.yaml --out tiny.yaml", "ends in .png"),
        ("compare set set --out set/README.md", "ends in .png"),
        ("transport --medium medium.yaml --model kernel --out set/dataset.json", "lies in the dataset"),
        ("transport --medium medium.yaml --model kernel --out notes.json", "choose another name, or remove it"),
        ("report set --no-timing --frames 0 --out tiny.yaml", "ends in .html"),
    ] {
        let run = place.run(arguments);
        assert!(run.code == 2 && run.err.contains(told), "gen {arguments}: {} {}", run.code, run.err);
    }
    assert_same(&before, &place.tree("set"), "nothing was written");
    assert_eq!(fs::read(place.path("notes.png")).expect("there"), b"no picture");
    place.done("preview --recipe tiny.yaml --out new.png");
    place.done("preview --recipe tiny.yaml --out new.png");
    place.done("preview --recipe tiny.yaml --out new.png --index 1");
}

/// Guards every command that writes a folder or a file: nothing lands in the folder of a dataset, whatever path leads
/// there, where it would be a fault of that dataset. `reports/` takes results, and no datasets.
#[test]
fn nothing_lands_in_a_dataset() {
    let place = place();
    place.make("other", "--n 1");
    std::os::unix::fs::symlink("set/exr", place.path("link")).expect("linked");
    let before = place.tree("set");
    let orders = [
        "--recipe tiny.yaml --n 1 --out OUT",
        "--recipe tiny.yaml --n 1 --estimate --out OUT",
        "--recipe other --n 1 --out OUT",
        "export png other --out OUT",
        "export coco set --out OUT",
        "check other --model none.onnx --out OUT",
        "study point --photons 100 --out OUT",
        "preview --recipe tiny.yaml --out OUT.png",
        "compare other other --out OUT.png",
        "report other --no-timing --frames 0 --out OUT.html",
        "transport --medium medium.yaml --model kernel --out OUT.json",
        "fit --recipe tiny.yaml --real other --keys laser.waist_mm --out OUT.yaml",
    ];
    for order in orders {
        for out in ["set/new", "set/exr/new", "link/new", "other/../set/data/../exr/new"] {
            let order = order.replace("OUT", out);
            let run = place.run(&order);
            let is_told = run.err.contains("lies in the dataset") && run.err.contains("choose");
            assert!(run.code == 2 && is_told, "gen {order}: {} {}", run.code, run.err);
        }
    }
    for order in ["--recipe tiny.yaml --n 1", "export png other"] {
        for out in ["set/reports/new", "other/../set/no/where/../new"] {
            assert!(
                place.run(&format!("{order} --out {out}")).err.contains("lies in the dataset"),
                "gen {order}, {out}"
            );
        }
    }
    assert_same(&before, &place.tree("set"), "nothing was written");
    place.done("validate set --rerender 0");
    // A document of that name that is another program's makes no dataset of a folder.
    fs::create_dir(place.path("mine")).expect("made");
    place.write("mine/dataset.json", "{\"format\": \"another\"}");
    place.done("--recipe tiny.yaml --n 1 --out mine/new");
}

#[test]
fn names_do_not_reach_the_terminal_as_they_are() {
    let place = place();
    place.write("set/evil\u{1b}[31m\nname.txt", "");
    let run = place.run("validate set --rerender 0");
    assert!(run.code == 1 && !run.out.contains('\u{1b}'), "{:?}", run.out);
    assert!(run.out.contains("evil\\u{1b}[31m\\nname.txt"), "{:?}", run.out);
    let run = place.run("preview --recipe evil\u{1b}[31m.yaml");
    run.refused(&["evil\\u{1b}"]);
    assert!(!run.err.contains('\u{1b}'), "{:?}", run.err);
}

#[test]
fn a_head_with_fewer_classes_than_rows_is_told() {
    let place = Place::with(&[]);
    place.make("set", "--n 8");
    let path = place.path("set/dataset.json");
    let mut head = place.json("set/dataset.json");
    let classes = head["classes"].as_array_mut().expect("classes");
    assert!(classes.len() > 1, "the recipe has several");
    classes.truncate(1);
    fs::write(&path, format!("{head:#}\n")).expect("written");
    let run = place.run("report set --no-timing --frames 0");
    assert!(run.code == 1 && run.err.contains("fault"), "{}", run.err);
    let page = fs::read_to_string(place.path("set/reports/report.html")).expect("the page");
    assert!(page.contains("dataset.json names 1 classes"), "the fault is on the page");
}

#[test]
fn keys_without_effect_are_noted_or_refused() {
    let clear = Place::with(&[]);
    let text = fs::read_to_string(clear.path("tiny.yaml")).expect("there");
    let start = text.find("\nclasses:").expect("classes");
    clear.write("tiny.yaml", format!("{}\nclasses:\n  clear: {{share: 1}}\n", &text[..start]));
    let run = clear.done("--recipe tiny.yaml --n 1 --out set");
    for key in ["knots.width_mm", "rot.severity"] {
        assert!(run.err.contains(&format!("note: {key} has no effect")), "{key}: {}", run.err);
    }
    // Where a class has them nothing is noted.
    let whole = Place::with(&[]);
    let run = whole.make("set", "--n 1");
    assert!(!run.err.contains("has no effect"), "{}", run.err);
}
