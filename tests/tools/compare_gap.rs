//! Faults of `gen compare --gap` that need no Python: windows that are too few, programs that are no Python or fail,
//! and what is left behind. tests/python/compare_gap.rs trains.

use std::fs;

use test_support::program::{Place, recipe, until};

/// A folder with a dataset `planks` of four scans with twelve windows each, and one `tiny` of scans that have two.
fn planks() -> Place {
    let place = Place::new();
    let size = [["columns: 64 ", "columns: 128 "], ["profiles: 48 ", "profiles: 128 "]];
    let lean =
        [["exr: [range, reflectance, scatter, label, instance]", "exr: []"], ["truth_maps: true", "truth_maps: false"]];
    place.write("tiny.yaml", recipe(&[size.as_slice(), lean.as_slice()].concat()));
    place.make("planks", "--n 4");
    place.write("tiny.yaml", recipe(&lean));
    place.make("tiny", "--n 3");
    place
}

/// An executable in the folder.
#[cfg(unix)]
fn stub(place: &Place, name: &str, text: &str) {
    use std::os::unix::fs::PermissionsExt;
    place.write(name, format!("#!/bin/sh\n{text}\n"));
    fs::set_permissions(place.path(name), fs::Permissions::from_mode(0o755)).expect("the file is ours");
}

/// Runs `gen compare planks planks --gap` with a folder `tmp` for temporary files, which is empty afterwards.
fn refused(place: &Place, arguments: &str, words: &[&str]) {
    let temporary = place.path("tmp");
    fs::create_dir_all(&temporary).expect("the folder is ours");
    let output = place
        .command(&format!("compare {arguments}"))
        .env("TMPDIR", &temporary)
        .env_remove("SHEETLIGHT_PYTHON")
        .output()
        .expect("the program starts");
    let said = String::from_utf8(output.stderr).expect("the program writes UTF-8");
    assert_eq!((output.status.code(), output.stdout.as_slice()), (Some(1), b"".as_slice()), "{arguments}: {said}");
    for word in words {
        assert!(said.contains(word), "{arguments}: no `{word}` in {said}");
    }
    assert_eq!(fs::read_dir(&temporary).expect("it is there").count(), 0, "{arguments}: something is left behind");
}

/// What is too small is told before Python is looked for, with the number that is needed.
#[test]
fn too_few_windows_are_refused() {
    let place = planks();
    refused(
        &place,
        "planks tiny --gap --python nowhere/python",
        &["tiny: it has", "windows of 32 x 32 px", "--gap needs 40; give more or larger scans"],
    );
    refused(&place, "planks planks --gap --scans 1 --python nowhere/python", &["--gap needs 40"]);
}

/// `--python` alone has no effect, so it is refused.
#[test]
fn python_without_gap_is_refused() {
    let place = Place::new();
    let run = place.run("compare a b --python python3");
    assert_eq!(run.code, 2, "{}", run.err);
    assert!(run.err.contains("--gap"), "{}", run.err);
}

/// No Python, no packages, a script that fails, is killed, says nothing or says nonsense: each is told as what it is.
#[cfg(unix)]
#[test]
fn programs_that_do_not_train_are_told() {
    let place = planks();
    stub(&place, "bare", "echo \"No module named 'torch'\" >&2; exit 3");
    stub(&place, "broken", "echo first >&2; echo 'RuntimeError: it is broken' >&2; exit 1");
    stub(&place, "killed", "kill -9 $$");
    stub(&place, "short", "echo '{\"scores\": [[0.5]], \"torch\": \"2\"}' > \"$2/scores.json\"");
    stub(&place, "odd", "echo 'yes' > \"$2/scores.json\"");
    let doubtful = "import json, sys; from pathlib import Path; folder = Path(sys.argv[1]); \
                    asked = json.loads((folder / 'job.json').read_text())['experiments']; \
                    found = [[1.5] * len(one['window']) for one in asked]; \
                    (folder / 'scores.json').write_text(json.dumps({'scores': found, 'torch': '2'}))";
    stub(&place, "beyond", &format!("exec python3 -c \"{doubtful}\" \"$2\""));
    let install = "-m pip install numpy torch";
    for (program, words) in [
        ("nowhere/python", ["it cannot be started", "--gap needs Python 3 with numpy and torch", "SHEETLIGHT_PYTHON"]),
        ("tiny.yaml", ["it cannot be started", "tiny.yaml", "--python"]),
        ("./bare", ["it lacks a package: No module named 'torch'", install, "--python"]),
        ("./broken", ["it failed", "RuntimeError: it is broken", "Python 3.9"]),
        ("./killed", ["it was killed", "memory was short", "fewer --scans"]),
        ("/bin/true", ["it ended without an answer", "as if it were no Python", "give Python 3 itself"]),
        ("./short", ["it answered for [1] windows", "asked were", "./short"]),
        ("./odd", ["its answer cannot be read", "give Python 3 itself", "./odd"]),
        ("./beyond", ["numbers that are no probabilities", "give Python 3 itself", "./beyond"]),
    ] {
        refused(&place, &format!("planks planks --gap --python {program}"), &words);
    }
}

/// A variable names the Python too, and an option stands above it.
#[cfg(unix)]
#[test]
fn the_variable_names_python() {
    let place = planks();
    let said = |arguments: &str| {
        let mut command = place.command(&format!("compare planks planks --gap {arguments}"));
        let output = command.env("SHEETLIGHT_PYTHON", "nowhere/variable").output().expect("the program starts");
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    assert!(said("").contains("nowhere/variable: it cannot be started"));
    assert!(said("--python nowhere/option").contains("nowhere/option: it cannot be started"));
}

/// Ctrl-C, sent to the program alone, ends what it started, and leaves nothing behind.
#[cfg(unix)]
#[test]
fn an_interrupt_ends_python_too() {
    use std::process::Command;

    let place = planks();
    // It notes its number, then sleeps without reading its input.
    stub(&place, "sleeper", "echo $$ > number.tmp; mv number.tmp number; exec sleep 600");
    fs::create_dir(place.path("tmp")).expect("the folder is ours");
    let mut command = place.command("compare planks planks --gap --python ./sleeper");
    let mut program = command.env("TMPDIR", place.path("tmp")).spawn().expect("the program starts");
    let note = place.path("number");
    assert!(until(&mut program, || note.exists()), "it ended before the stub noted its number");
    let number = fs::read_to_string(note).expect("it is there").trim().to_string();
    let is_there =
        |number: &str| Command::new("kill").args(["-0", number]).output().is_ok_and(|run| run.status.success());
    assert!(is_there(&number));
    let sent = Command::new("kill").args(["-INT", &program.id().to_string()]).status().expect("kill is there");
    assert!(sent.success());
    let output = program.wait_with_output().expect("it ends");
    assert_eq!(output.status.code(), Some(130), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(!is_there(&number), "the process {number} goes on");
    assert_eq!(fs::read_dir(place.path("tmp")).expect("it is there").count(), 0, "something is left behind");
}
