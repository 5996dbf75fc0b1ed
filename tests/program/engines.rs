//! What engines and file systems that make datasets ask for: events for programs, parts that leave other parts alone,
//! card and metadata without data files, folders for each thousand shards, and no locks.

use std::fs;
use std::process::Command;

use serde_json::Value;
use test_support::program::{FRAMES, Place, Run};

/// The events that a run has told; every line is one.
fn events(run: &Run) -> Vec<Value> {
    let event = |line: &str| serde_json::from_str(line).unwrap_or_else(|e| panic!("{e}: {line}"));
    run.err.lines().map(event).collect()
}

fn named<'a>(events: &'a [Value], name: &str) -> Vec<&'a Value> {
    events.iter().filter(|event| event["event"] == name).collect()
}

/// With `--events` a program reads all: what begins, each sample and shard, notes, faults with their status.
#[test]
fn events_tell_a_program_what_goes_on() {
    let place = Place::with(&[]);
    let order = "--recipe tiny.yaml --samples-per-shard 2 --out set --events";
    let run = place.done(&format!("{order} --n 5 --json"));
    let told = events(&run);
    let begin = named(&told, "begin");
    assert!(begin.len() == 1 && begin[0]["samples"] == 5 && begin[0]["finished"] == 0, "{}", run.err);
    let shards: Vec<u64> = named(&told, "shard").iter().filter_map(|event| event["shard"].as_u64()).collect();
    assert_eq!(shards, [0, 1, 2]);
    let bytes: Vec<u64> = named(&told, "sample").iter().filter_map(|event| event["bytes"].as_u64()).collect();
    assert!(bytes.len() == 5 && bytes.iter().all(|&bytes| bytes > 1000), "{bytes:?}");
    assert!(!named(&told, "note").is_empty(), "{}", run.err);
    let result: Value = serde_json::from_str(&run.out).expect("standard output is the result");
    assert_eq!(result["made_shards"], 3);
    // Continued: what is there counts as finished.
    let told = events(&place.done(&format!("{order} --n 7")));
    let begin = named(&told, "begin");
    assert!(begin[0]["samples"] == 3 && begin[0]["finished"] == 4, "{begin:?}");

    for (arguments, status) in [("--n 4 --seed 9", 1), ("--n 0", 2)] {
        let run = place.run(&format!("{order} {arguments}"));
        let told = events(&run);
        let fault = named(&told, "fault");
        assert!(run.code == status && fault.len() == 1 && fault[0]["status"] == status, "{arguments}: {}", run.err);
        assert!(fault[0]["text"].as_str().is_some_and(|text| text.len() > 20 && !text.starts_with("gen")));
    }
    let estimate: Value =
        serde_json::from_str(&place.done(&format!("{order} --n 11 --estimate --json")).out).expect("JSON");
    assert_eq!([&estimate["shards"], &estimate["samples_per_shard"], &estimate["shards_to_make"]], [6, 2, 3]);
}

/// One part of many does not open what the other parts made: with ten thousand of them that would be the most of its
/// work.
#[test]
fn a_part_leaves_the_others_alone() {
    let place = Place::with(&[]);
    let order = "--recipe tiny.yaml --n 4 --samples-per-shard 1 --out set";
    place.done(&format!("{order} --part 1/4"));
    let manifest = place.path("set/shards/00001.json");
    let text = fs::read(&manifest).expect("it is there");
    fs::write(&manifest, "no JSON").expect("written");
    place.done(&format!("{order} --part 0/4"));
    place.done(&format!("{order} --part 2/4"));
    // The last one sees that all are there, and looks.
    place.run(&format!("{order} --part 3/4")).refused(&["00001.json"]);
    fs::write(&manifest, text).expect("written");
    place.done(&format!("{order} --part 3/4"));
    place.done("validate set");
}

/// `gen finish` needs documents alone, and writes the same card and metadata as the run.
#[test]
fn a_dataset_is_finished_without_its_data() {
    let place = Place::with(&[FRAMES]);
    place.done("--recipe tiny.yaml --n 6 --samples-per-shard 2 --out set");
    let documents =
        ["README.md", "croissant.json"].map(|name| fs::read(place.path(&format!("set/{name}"))).expect("it is there"));
    fs::create_dir_all(place.path("bare/shards")).expect("made");
    let copy =
        |name: &str| fs::copy(place.path(&format!("set/{name}")), place.path(&format!("bare/{name}"))).expect("copied");
    for name in ["dataset.json", "shards/00000.json", "shards/00002.json"] {
        copy(name);
    }
    place.run("finish bare").refused(&["1 of 3 shards", "manifest", ": 1;", "make them"]);
    assert!(!place.path("bare/README.md").exists());
    copy("shards/00001.json");
    let run = place.done("finish bare --json");
    let result: Value = serde_json::from_str(&run.out).expect("JSON");
    assert_eq!([&result["samples"], &result["shards"]], [6, 3]);
    let written =
        ["README.md", "croissant.json"].map(|name| fs::read(place.path(&format!("bare/{name}"))).expect("written"));
    assert!(documents == written);
    // A manifest of another dataset is none of this one.
    place.done("--recipe tiny.yaml --n 6 --samples-per-shard 2 --seed 1 --out other --part 1/3");
    fs::copy(place.path("other/shards/00001.json"), place.path("bare/shards/00001.json")).expect("copied");
    place.run("finish bare").refused(&["1 of 3 shards"]);
    place.run("finish nothing").refused(&["nothing", "dataset.json"]);
}

/// Each thousand shards after the first have folders of their own, which a run makes, continues, reads and validates.
#[test]
fn thousands_of_shards_have_folders_of_their_own() {
    let place = Place::with(&[FRAMES]);
    let order = "--recipe tiny.yaml --n 1003 --samples-per-shard 1 --out set";
    for part in [7, 999, 1000, 1002] {
        place.done(&format!("{order} --part {part}/1003"));
    }
    let names = |folder: &str| {
        let entries = fs::read_dir(place.path(&format!("set/{folder}"))).expect("it is there");
        let mut names: Vec<String> =
            entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    };
    assert_eq!(names("shards"), ["00007.json", "001", "00999.json"]);
    assert_eq!(names("shards/001"), ["01000.json", "01002.json"]);
    assert_eq!(names("stacks/001"), ["01000.parquet", "01002.parquet"]);
    assert_eq!(names("exr"), ["00007", "001", "00999"]);
    assert_eq!(names("exr/001"), ["01000", "01002"]);
    assert_eq!(names("data/001").len(), 2);
    // What a killed process left there goes, and a finished shard is made no second time.
    place.write("set/data/001/.tmp-train-01001.parquet", "half");
    place.write("set/data/001/.tmp-foreign", "mine");
    let again = place.done(&format!("{order} --part 1000/1003"));
    assert!(again.err.contains("nothing to do"), "{}", again.err);
    assert!(!place.path("set/data/001/.tmp-train-01001.parquet").exists(), "a half file stays");
    fs::remove_file(place.path("set/data/001/.tmp-foreign")).expect("what is not ours stays");

    let report: Value = serde_json::from_str(&place.run("validate set --json").out).expect("JSON");
    let codes = |fault: &Value| fault["code"].as_str().unwrap_or("").to_owned();
    let codes: std::collections::BTreeSet<String> =
        report["faults"].as_array().expect("a list").iter().map(codes).collect();
    assert_eq!(codes.into_iter().collect::<Vec<_>>(), ["manifest-missing"], "only what was not made is missing");
    // What the card shows leads there, in the oldest Python that reads it.
    let card = fs::read_to_string(place.path("set/README.md")).expect("it is there");
    let code: Vec<&str> =
        card.lines().filter(|line| line.starts_with("shard = ") || line.starts_with("thousand = ")).collect();
    let file = card
        .lines()
        .find_map(|line| line.strip_prefix("maps = OpenEXR.File(")?.split(", ").next())
        .expect("an example");
    for (index, folder) in [(7, "exr/00007"), (1002, "exr/001/01002")] {
        let exr = &names(folder)[0];
        let id = exr.strip_suffix(".exr").expect("an EXR file");
        let script = format!("row = {{'index': {index}, 'id': '{id}'}}\n{}\nprint({file})", code.join("\n"));
        let run = Command::new("python3").args(["-c", &script]).output().expect("python3 starts");
        let told = String::from_utf8_lossy(&run.stdout).trim().to_owned();
        assert_eq!(told, format!("PATH/{folder}/{exr}"), "{script}\n{}", String::from_utf8_lossy(&run.stderr));
    }
    let metadata = place.json("set/croissant.json").to_string();
    for pattern in ["data/*/train-*.parquet", "exr/*/*/*.exr", "stacks/*/*.parquet", "shards/*/*.json"] {
        assert!(metadata.contains(pattern), "no {pattern}");
    }
    // A dataset of before has them all in one folder: it is refused in place of found empty.
    let head = fs::read_to_string(place.path("set/dataset.json")).expect("it is there");
    let [major, minor] = output_schema::SCHEMA_VERSION;
    let told = format!("    {major},\n    {minor}\n");
    assert_eq!(head.matches(&told).count(), 1);
    place.write("set/dataset.json", head.replace(&told, "    1,\n    5\n"));
    place.run("export png set --out pngs").refused(&[
        "1003 shards",
        "schema 1.5",
        "folders of their own",
        "older program",
    ]);
    place.write("set/dataset.json", head);
    let exported = place.done("export png set --out pngs --maps label");
    assert!(exported.err.contains("999 shards") && exported.err.contains("4 samples"), "{}", exported.err);
}

#[cfg(target_os = "linux")]
mod without_locks {
    use std::fs;
    use std::path::{Path, PathBuf};
    use std::process::Command;

    use test_support::program::{Place, assert_same};

    /// A library that makes `flock` fail as it does where a file system has none.
    fn without_locks(place: &Place) -> PathBuf {
        place.write("no_flock.c", "#include <errno.h>\nint flock(int file, int how) { errno = ENOSYS; return -1; }\n");
        let library = place.path("no_flock.so");
        let made =
            Command::new("cc").args(["-shared", "-fPIC", "-o"]).arg(&library).arg(place.path("no_flock.c")).status();
        assert!(made.expect("there is a C compiler").success());
        library
    }

    fn whole(folder: &Path) -> bool {
        folder.join("croissant.json").exists()
            && !fs::read_dir(folder)
                .expect("it is there")
                .any(|e| e.expect("an entry").file_name().to_string_lossy().starts_with('.'))
    }

    /// Without locks a run says so and goes on; parts that begin at once make the dataset that one process makes.
    #[test]
    fn a_file_system_without_locks_will_do() {
        let place = Place::with(&[]);
        let order = "--recipe tiny.yaml --n 12 --samples-per-shard 1 -j 1 --out";
        place.done(&format!("{order} whole"));
        let library = without_locks(&place);
        let begin = |part: usize| {
            let mut command = place.command(&format!("{order} set --part {part}/4 --events"));
            command.env("LD_PRELOAD", &library).spawn().expect("it starts")
        };
        let parts: Vec<_> = (0..4).map(begin).collect();
        for part in parts {
            let output = part.wait_with_output().expect("it ends");
            let told = String::from_utf8_lossy(&output.stderr).into_owned();
            assert!(output.status.success() && told.contains("\"event\":\"no-locks\""), "{told}");
        }
        let last = place.command(&format!("{order} set")).env("LD_PRELOAD", &library).output().expect("it starts");
        let told = String::from_utf8_lossy(&last.stderr).into_owned();
        assert!(
            last.status.success() && told.contains("no locks between processes") && told.contains("--part"),
            "{told}"
        );
        assert!(whole(&place.path("set")), "a temporary name or a lock is left");
        assert_same(&place.tree("whole"), &place.tree("set"), "with and without locks");
    }
}
