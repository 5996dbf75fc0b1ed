//! Every option and argument that names a file, of every command: whatever lies under that name, the command ends, says
//! so, and touches nothing else. They are enumerated from the command line itself, so that a new option is held to it
//! as it joins.
//!
//! The kind of fault: a file opened beside the functions that guard (`files`, `dataset::enclosed`), which waits for a
//! pipe, reads a device without end, takes the memory that a sparse file claims, or writes through a link.

use std::fs::{self, File};
use std::os::unix::fs::{FileTypeExt, symlink};
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::sync::mpsc;
use std::time::Duration;

use clap::Arg;
use test_support::program::{Place, Run, pack_recipe};

/// Far longer than any of these commands takes.
const PATIENCE: Duration = Duration::from_secs(120);

/// A command that does its work: its name, and the values of its options and arguments by their identifiers.
type Order = (&'static str, &'static [(&'static str, &'static str)]);

/// One for each command that names a file; that of `export` holds for every format.
const ORDERS: [Order; 19] = [
    ("", &[("recipe", "tiny.yaml"), ("n", "1"), ("out", "made")]),
    ("preview", &[("recipe", "tiny.yaml"), ("out", "picture.png")]),
    ("rig", &[("recipe", "tiny.yaml")]),
    ("recipe show", &[("recipe", "tiny.yaml")]),
    ("validate", &[("dir", "set"), ("rerender", "0")]),
    ("report", &[("dir", "set"), ("no_timing", ""), ("out", "page.html")]),
    ("list", &[("dirs", "set")]),
    ("finish", &[("folder", "set")]),
    (
        "check",
        &[("dir", "set"), ("model", "model.onnx"), ("sidecar", "model.yaml"), ("split", "all"), ("out", "wrong")],
    ),
    (
        "compare",
        &[
            ("sim", "scan.exr"),
            ("real", "grid.csv"),
            ("mm_per_count", "1"),
            ("missing", "0"),
            ("bits", "10"),
            ("reflectance", "light.csv"),
            ("scatter", "light.csv"),
            ("out", "plots.png"),
        ],
    ),
    ("icon", &[("path", "icons/00000000.xml")]),
    ("fibres", &[("picture", "board.png"), ("pixel_mm", "0.15"), ("encoding", "linear"), ("out", "maps.exr")]),
    ("transport", &[("medium", "medium.yaml"), ("model", "kernel"), ("out", "answer.json")]),
    ("export", &[("dir", "set"), ("out", "exported")]),
    ("fit", &[("recipe", "tiny.yaml"), ("real", "scan.exr"), ("mask", "mask.png"), ("out", "fitted.yaml")]),
    ("cover", &[("recipe", "tiny.yaml"), ("real", "scan.exr"), ("out", "cover.html")]),
    ("tune", &[("recipe", "tiny.yaml")]),
    ("study profile", &[("recipe", "tiny.yaml")]),
    ("study packs", &[("recipe", "pack.yaml")]),
];

/// The values of a command that does its work.
fn values_of(name: &str) -> Option<&'static [(&'static str, &'static str)]> {
    let of = |name: &str| ORDERS.iter().find(|(known, _)| *known == name).map(|(_, values)| *values);
    of(name).or_else(|| of(name.rsplit_once(' ')?.0))
}

/// What may have a name.
const KINDS: [&str; 7] = ["pipe", "folder", "endless", "sparse", "dangling", "link", "-"];

/// The arguments of a command that name a file or a folder, with whether it is written; recipes are names of files too.
fn named(command: &clap::Command) -> Vec<(Arg, bool)> {
    let is_path = |arg: &&Arg| {
        let path = std::any::TypeId::of::<PathBuf>();
        arg.get_value_parser().type_id() == path || arg.get_id() == "recipe"
    };
    let is_out = |arg: &Arg| ["out", "matter"].contains(&arg.get_id().as_str());
    command.get_arguments().filter(is_path).map(|arg| (arg.clone(), is_out(arg))).collect()
}

/// Every command with its name, those of commands included.
fn commands(command: &clap::Command, name: &str, found: &mut Vec<(String, clap::Command)>) {
    found.push((name.to_owned(), command.clone()));
    for inner in command.get_subcommands() {
        commands(inner, format!("{name} {}", inner.get_name()).trim_start(), found);
    }
}

/// Whether a command works for long once all of its inputs can be read: what it reads, others read too.
fn is_long(name: &str) -> bool {
    name.starts_with("study") || ["fit", "cover", "tune"].contains(&name)
}

/// The command line with these values.
fn line(name: &str, command: &clap::Command, values: &[(&str, String)]) -> String {
    let mut words = vec![name.to_owned()];
    for (id, value) in values {
        let arg = command.get_arguments().find(|arg| arg.get_id() == *id).expect("the command has it");
        if let Some(long) = arg.get_long() {
            words.push(format!("--{long}"));
        }
        words.push(value.clone());
    }
    words.join(" ")
}

fn ends(place: &Place, arguments: &str) -> Run {
    finished(place.command(arguments), arguments)
}

/// Runs the program, which must end by itself.
fn finished(mut command: Command, arguments: &str) -> Run {
    let child = command.spawn().expect("the program starts");
    let (id, (tell, told)) = (child.id().to_string(), mpsc::channel());
    std::thread::spawn(move || tell.send(child.wait_with_output()));
    let Ok(output) = told.recv_timeout(PATIENCE) else {
        let _ = Command::new("kill").args(["-KILL", &id]).status();
        panic!("gen {arguments} does not end");
    };
    let output = output.expect("it ends");
    let text = |bytes: Vec<u8>| String::from_utf8_lossy(&bytes).into_owned();
    let run = Run { code: output.status.code().unwrap_or(-1), out: text(output.stdout), err: text(output.stderr) };
    assert!(!run.err.contains("panicked") && (0..=3).contains(&run.code), "gen {arguments}: {}: {}", run.code, run.err);
    run
}

/// A dataset, and a file for each argument.
fn place() -> Place {
    let place = Place::with(&[]);
    place.make("set", "--n 1");
    place.done("export icon set --out icons");
    let exr = place.tree("set/exr").into_keys().next().expect("an EXR file");
    fs::copy(place.path(&format!("set/exr/{exr}")), place.path("scan.exr")).expect("copied");
    let row = |of: fn(usize) -> usize| (1..=16).map(|i| of(i).to_string()).collect::<Vec<_>>().join(",") + "\n";
    place.write("grid.csv", (0..12).map(|_| row(|i| 7 + i % 3)).collect::<String>());
    place.write("light.csv", (0..12).map(|_| row(|i| 300 + 5 * i)).collect::<String>());
    let models = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/models");
    fs::copy(models.join("mean_sign.onnx"), place.path("model.onnx")).expect("copied");
    place.write(
        "model.yaml",
        "task: classify_pixels\nchannels: [{name: range, mean: 0, sd: 1}]\nwindow_px: [8, 8]\nclasses: [clear, rot]\n",
    );
    fs::copy(models.join("../../recipes/media/clear-wood.yaml"), place.path("medium.yaml")).expect("copied");
    image::GrayImage::from_fn(160, 240, |x, y| image::Luma([(90 + (7 * x + y / 9) % 80) as u8]))
        .save(place.path("board.png"))
        .expect("written");
    image::GrayImage::from_pixel(64, 48, image::Luma([255])).save(place.path("mask.png")).expect("written");
    place.write("pack.yaml", pack_recipe(&[]));
    place.write("victim", "years");
    place
}

/// Puts what the kind says under a name with this ending; `whole` is what a link leads to.
fn put(place: &Place, kind: &str, whole: &str) -> String {
    if kind == "-" {
        return kind.to_owned();
    }
    let ending = whole.rsplit_once('.').map_or(String::new(), |(_, ending)| format!(".{ending}"));
    let name = format!("{kind}{ending}");
    let path = place.path(&name);
    // There may be one of the command before.
    let _ = if path.is_dir() && !path.is_symlink() { fs::remove_dir_all(&path) } else { fs::remove_file(&path) };
    match kind {
        "pipe" => assert!(Command::new("mkfifo").arg(&path).status().is_ok_and(|status| status.success())),
        "folder" => fs::create_dir(&path).expect("made"),
        "endless" => symlink("/dev/zero", &path).expect("linked"),
        "sparse" => File::create(&path).and_then(|file| file.set_len(20_000_000_000)).expect("it takes no room"),
        "dangling" => symlink("nothing", &path).expect("linked"),
        _ => symlink(place.path(whole), &path).expect("linked"),
    }
    // The files of a camera are two.
    if ending == ".xml" && kind == "link" {
        let _ = fs::remove_file(path.with_extension("dat"));
        symlink(place.path(whole).with_extension("dat"), path.with_extension("dat")).expect("linked");
    }
    name
}

/// Whatever has the name of an input, no command waits, takes memory for it or panics: it is refused and named. A link
/// to what is meant serves as that itself.
#[test]
#[ignore = "long"]
fn no_input_hangs_a_command() {
    let place = place();
    let mut all = Vec::new();
    commands(&sheetlight::cli::command(), "", &mut all);
    for (name, command) in all {
        let inputs: Vec<Arg> = named(&command).into_iter().filter(|(_, is_out)| !is_out).map(|(arg, _)| arg).collect();
        if inputs.is_empty() {
            continue;
        }
        let base = values_of(&name).unwrap_or_else(|| {
            panic!("`gen {name}` names files: give an order of it that works, so that each of them is tried");
        });
        for arg in inputs {
            let id = arg.get_id().as_str();
            let whole = base.iter().find(|(known, _)| *known == id).map_or("victim", |(_, value)| value);
            for kind in KINDS.into_iter().filter(|kind| *kind != "link" || !is_long(&name)) {
                let mut values: Vec<(&str, String)> = base.iter().map(|(id, value)| (*id, value.to_string())).collect();
                let value = put(&place, kind, whole);
                match values.iter_mut().find(|(known, _)| *known == id) {
                    Some((_, own)) => own.clone_from(&value),
                    None => values.push((id, value.clone())),
                }
                let order = line(&name, &command, &values);
                let run = ends(&place, &order);
                let told = format!("{order}: {}: {}", run.code, run.err);
                assert_eq!(fs::read(place.path("victim")).expect("it is there"), b"years", "{told}");
                match kind {
                    // An option that the order does not have may need another one.
                    "link" if base.iter().any(|(known, _)| *known == id) => {
                        let values: Vec<_> = base.iter().map(|(id, value)| (*id, value.to_string())).collect();
                        let plain = ends(&place, &line(&name, &command, &values));
                        assert_eq!(run.code, plain.code, "{told}\nwithout a link: {}", plain.err);
                    }
                    "link" | "-" => {}
                    // An empty folder holds no dataset, and that is what `gen list` says.
                    "folder" if name == "list" => assert_eq!(run.code, 0, "{told}"),
                    _ => {
                        let is_named = run.err.contains(&value) || run.out.contains(&value);
                        assert!(run.code == 2 || run.code == 1 && is_named, "{told}");
                    }
                }
            }
        }
    }
}

/// Whatever has the name of a result, nothing is written through it, and no command waits for it.
#[test]
fn no_output_goes_through_what_is_there() {
    let place = place();
    let mut all = Vec::new();
    commands(&sheetlight::cli::command(), "", &mut all);
    for (name, command) in all {
        for (arg, is_out) in named(&command) {
            if !is_out {
                continue;
            }
            let base = values_of(&name).unwrap_or_default();
            let whole = base.iter().find(|(known, _)| *known == "out").map_or("picture.png", |(_, value)| value);
            let kinds: &[&str] = if is_long(&name) { &["pipe"] } else { &["pipe", "link", "dangling"] };
            for kind in kinds {
                let value = put(&place, kind, "victim");
                let value = match whole.rsplit_once('.') {
                    Some((_, ending)) => {
                        let renamed = format!("{value}.{ending}");
                        let _ = fs::remove_file(place.path(&renamed));
                        fs::rename(place.path(&value), place.path(&renamed)).expect("renamed");
                        renamed
                    }
                    None => value,
                };
                let mut values: Vec<(&str, String)> = base.iter().map(|(id, value)| (*id, value.to_string())).collect();
                match values.iter_mut().find(|(known, _)| known == arg.get_id()) {
                    Some((_, own)) => own.clone_from(&value),
                    None => values.push((arg.get_id().as_str(), value.clone())),
                }
                let order = line(&name, &command, &values);
                let run = ends(&place, &order);
                let told = format!("{order}: {}: {}", run.code, run.err);
                assert_eq!(fs::read(place.path("victim")).expect("it is there"), b"years", "{told}");
                assert!(!place.path("nothing").exists(), "{told}");
                if *kind == "pipe" {
                    let found = fs::symlink_metadata(place.path(&value)).expect("it is there");
                    assert!(run.code != 0 && found.file_type().is_fifo(), "{told}");
                }
            }
        }
    }
}

/// What `gen fit` keeps beside its result is its own file: one of that name that is none stays, and is not written
/// through.
#[test]
fn what_a_fit_keeps_replaces_nothing() {
    let place = place();
    let order = "fit --recipe tiny.yaml --real scan.exr --keys camera.tilt_deg --set \
        camera.tilt_deg={\"uniform\":[25,35]} \
        --simulations 400 --rounds 2 --out h.yaml -q";
    for kind in ["link", "dangling", "pipe", "folder", "endless", "sparse", "foreign", "empty"] {
        let path = place.path("h.fit.jsonl");
        let _ = if path.is_dir() { fs::remove_dir_all(&path) } else { fs::remove_file(&path) };
        match kind {
            "foreign" => place.write("h.fit.jsonl", "no line of ours, and no end of it"),
            "empty" => place.write("h.fit.jsonl", ""),
            _ => _ = fs::rename(place.path(&put(&place, kind, "victim")), &path),
        }
        let before = fs::symlink_metadata(&path).expect("it is there");
        let run = ends(&place, order);
        assert!(run.code == 1 && run.err.contains("h.fit.jsonl: it "), "{kind}: {}: {}", run.code, run.err);
        let after = fs::symlink_metadata(&path).expect("it is still there");
        assert_eq!((before.file_type(), before.len()), (after.file_type(), after.len()), "{kind}");
        assert!(fs::read(place.path("victim")).is_ok_and(|text| text == b"years"), "{kind}");
        assert!(!place.path("nothing").exists() && !place.path("h.yaml").exists(), "{kind}");
    }
}

/// `-` is standard input where a command takes the content of one file, up to the bound of such a file.
#[test]
fn standard_input_is_a_file_too() {
    let place = place();
    let piped = |arguments: &str, from: &str| {
        let mut command = place.command(arguments);
        command.stdin(Stdio::from(File::open(place.path(from)).expect("it is there")));
        finished(command, arguments)
    };
    let wanted = place.done("transport --medium medium.yaml --model kernel").out;
    let found = piped("transport --medium - --model kernel", "medium.yaml");
    assert!(found.code == 0 && found.out == wanted, "{}", found.err);
    let run = piped("transport --medium - --model kernel", "tiny.yaml");
    assert!(run.code == 1 && run.err.contains("standard input"), "{}", run.err);
    place.write("none", "");
    for (order, words) in [
        ("check set --split all --model model.onnx --sidecar -", "standard input"),
        ("fibres - --pixel-mm 0.15 --encoding linear", "--out"),
        ("fibres - --pixel-mm 0.15 --encoding linear --out maps.exr", "standard input"),
    ] {
        let run = piped(order, "none");
        assert!(run.code != 0 && run.err.contains(words), "{order}: {}", run.err);
    }
    symlink("/dev/zero", place.path("endless")).expect("linked");
    for order in [
        "--recipe - --n 1 --out made",
        "transport --medium - --model kernel",
        "check set --split all --model model.onnx --sidecar -",
    ] {
        let run = piped(order, "endless");
        assert!(run.code == 1 && run.err.contains("longer than"), "{order}: {}: {}", run.code, run.err);
    }
}
