//! Datasets that somebody else made, and processes that get in each other's way: nothing outside of a folder is
//! touched, nothing hangs, and status 0 means that all is there.

use std::fs::{self, File};
use std::io::{BufRead, BufReader, Read};
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::{Child, Command};
use std::thread::sleep;
use std::time::{Duration, Instant};

use test_support::program::{Place, Run, assert_same, until};
use tools::export::EXPORTS;

/// What takes that long hangs: far longer than any of these commands takes on the slowest machine.
const PATIENCE: Duration = Duration::from_secs(600);

/// Runs the program, which must end by itself.
fn ends(place: &Place, arguments: &str) -> Run {
    let mut child = place.command(arguments).spawn().expect("the program starts");
    let start = Instant::now();
    while child.try_wait().expect("the child can be asked").is_none() {
        if start.elapsed() > PATIENCE {
            child.kill().expect("it can be killed");
            panic!("gen {arguments} does not end");
        }
        sleep(Duration::from_millis(5));
    }
    finished(child, arguments)
}

fn finished(child: Child, arguments: &str) -> Run {
    let output = child.wait_with_output().expect("it ends");
    let text = |bytes: Vec<u8>| String::from_utf8_lossy(&bytes).into_owned();
    let run = Run { code: output.status.code().unwrap_or(-1), out: text(output.stdout), err: text(output.stderr) };
    assert!(!run.err.contains("panicked") && (0..=3).contains(&run.code), "gen {arguments}: {}", run.err);
    run
}

/// A dataset `set` of two shards of one sample, and `photos` and `victim` beside it.
fn place() -> Place {
    let place = Place::with(&[["sensor_stack: none", "sensor_stack: {every: 16}"]]);
    place.make("set", "--n 2 --samples-per-shard 1");
    fs::create_dir_all(place.path("photos/20240101")).expect("made");
    place.write("photos/20240101/a.jpg", "years");
    place.write("victim", "years");
    place
}

fn is_untouched(place: &Place, what: &str) {
    let photos = place.tree("photos");
    let is_kept = photos.keys().eq(["20240101/a.jpg"]) && photos["20240101/a.jpg"] == b"years";
    let is_kept = is_kept && fs::read(place.path("victim")).is_ok_and(|text| text == b"years");
    assert!(is_kept, "{what}: something outside of the dataset was changed: {:?}", photos.keys());
}

fn replace(path: &Path, by: impl FnOnce(&Path)) {
    // There may be nothing yet.
    let _ = if path.is_dir() { fs::remove_dir_all(path) } else { fs::remove_file(path) };
    by(path);
}

fn pipe(path: &Path) {
    assert!(Command::new("mkfifo").arg(path).status().expect("mkfifo runs").success());
}

/// The only EXR file of the first shard.
fn exr(place: &Place) -> String {
    let name = place.tree("set/exr/00000").into_keys().next().expect("an EXR file");
    format!("set/exr/00000/{name}")
}

#[test]
fn continuing_sweeps_no_folder_of_others() {
    let place = place();
    replace(&place.path("set/exr"), |path| symlink(place.path("photos"), path).expect("linked"));
    place.write("set/shards/.lock-20240101", "");
    let run = ends(&place, "--recipe set --n 2");
    is_untouched(&place, "a linked exr");
    assert!(run.code == 1 && run.err.contains("`exr` is a link") && run.err.contains("move it away"), "{}", run.err);
}

#[test]
fn continuing_writes_through_no_link() {
    for name in
        [".tmp-dataset.json", ".tmp-README.md", ".tmp-croissant.json", ".lock-dataset", "shards/.tmp-00002.json"]
    {
        let place = place();
        replace(&place.path(&format!("set/{name}")), |path| symlink(place.path("victim"), path).expect("linked"));
        let run = ends(&place, "--recipe set --n 3");
        is_untouched(&place, name);
        assert!(run.code == 1 && run.err.contains(name) && run.err.contains("is a link"), "{name}: {}", run.err);
        assert!(run.err.contains("move it away"), "{name}: {}", run.err);
    }
}

#[test]
fn kept_results_land_in_the_dataset_alone() {
    let place = place();
    symlink(place.path("photos"), place.path("set/reports")).expect("linked");
    let orders = ["validate set --rerender 0 --save", "report set --no-timing", "report set --out set/reports/a.html"];
    for order in orders {
        let run = ends(&place, order);
        is_untouched(&place, order);
        assert!(run.code == 1 && run.err.contains("`reports` is a link"), "{order}: {}", run.err);
    }
    fs::remove_file(place.path("set/reports")).expect("it is there");
    place.done("validate set --rerender 0 --save");
    replace(&place.path("set/reports/validation.json"), |path| symlink(place.path("victim"), path).expect("linked"));
    // The report takes the place of the link, as it would of a file.
    place.done("validate set --rerender 0 --save");
    is_untouched(&place, "a linked report");
    assert!(fs::symlink_metadata(place.path("set/reports/validation.json")).is_ok_and(|found| found.is_file()));
}

#[test]
#[ignore = "long"]
fn pipes_hang_no_command() {
    let files = ["set/README.md", "set/dataset.json", "set/shards/00000.json", "set/data/train-00000.parquet", "EXR"];
    for name in files {
        let place = place();
        let exr = exr(&place);
        let name = match name {
            "EXR" => exr.as_str(),
            "set/data/train-00000.parquet" if !place.path(name).exists() => "set/stacks/00000.parquet",
            name => name,
        };
        replace(&place.path(name), pipe);
        let relative = name.strip_prefix("set/").expect("it lies in the dataset");
        let orders = [
            ("--recipe tiny.yaml --out set --n 3 --samples-per-shard 1", true),
            ("validate set --rerender 0", true),
            ("validate set --rerender 0 --save", true),
            ("report set --no-timing --out page.html", false),
            ("compare set set", false),
        ];
        let exports = EXPORTS.iter().map(|format| format!("export {0} set --out exported-{0}", format.name));
        let orders = orders.map(|(order, tells)| (order.to_owned(), tells)).into_iter();
        for (order, tells) in orders.chain(exports.map(|order| (order, false))) {
            let run = ends(&place, &order);
            let told = format!("{}{}", run.out, run.err);
            assert!(!tells || run.code == 1 && told.contains(relative), "{order} of {relative}: {told}");
        }
    }
}

/// Files of 8 GiB that take no room on the disk; whoever reads them needs that much memory.
#[test]
fn no_file_is_read_beyond_its_bound() {
    let place = place();
    let exr = exr(&place);
    for name in [exr.as_str(), "set/shards/00000.json", "set/dataset.json"] {
        let whole = fs::read(place.path(name)).expect("there");
        let file = File::options().write(true).open(place.path(name)).expect("there");
        file.set_len(8 << 30).expect("it grows");
        let words = if name == exr { "8589934592" } else { "8589934592 bytes, more than" };
        let orders = if name == exr {
            vec!["compare set set", "validate set --rerender 0"]
        } else {
            vec!["--recipe tiny.yaml --out set --n 2 --samples-per-shard 1", "compare set set", "validate set"]
        };
        for order in orders {
            let run = ends(&place, order);
            let told = format!("{}{}", run.out, run.err);
            assert!(run.code == 1 && told.contains(words), "{order} of {name}: {told}");
        }
        fs::write(place.path(name), whole).expect("written");
    }
    place.done("validate set --rerender 0");
}

#[test]
fn a_manifest_that_cannot_be_read_keeps_its_shard() {
    let place = place();
    replace(&place.path("set/shards/00000.json"), |path| fs::create_dir(path).expect("made"));
    place.write("set/shards/00000.json/kept", "years");
    let before = place.tree("set");
    for order in ["--recipe set --n 2", "--recipe set --n 2 --part 0/2", "--recipe set --n 2 --part 1/2"] {
        let run = ends(&place, order);
        assert!(run.code == 1 && run.err.contains("shards/00000.json"), "{order}: {}", run.err);
        assert_same(&before, &place.tree("set"), order);
    }
}

/// Tells a process to stop, or to go on.
fn signal(child: &Child, name: &str) {
    let sent = Command::new("kill").args([name, &child.id().to_string()]).status().expect("kill runs");
    assert!(sent.success());
}

/// Waits until a line of standard error holds these words; the lines until then.
fn until_said(lines: &mut impl BufRead, words: &str) -> String {
    let mut told = String::new();
    while !told.contains(words) {
        assert!(lines.read_line(&mut told).expect("it is text") > 0, "no `{words}` in {told}");
    }
    told
}

/// A run that is stopped with a shard in its hands, while the dataset is extended.
#[test]
fn a_smaller_run_that_ends_last_changes_nothing_of_the_larger_one() {
    let place = Place::with(&[["\n  profiles: 48 ", "\n  profiles: 600 "]]);
    place.make("whole", "--n 4 --samples-per-shard 1");
    let order = "--recipe tiny.yaml --samples-per-shard 1 --threads 1 --out";
    let small = (0..20).find_map(|round| {
        let mut small = place.command(&format!("{order} set{round} --n 2")).spawn().expect("the program starts");
        let shards = place.path(&format!("set{round}/shards"));
        // The first shard may still be written while the second is begun.
        let is_alone = || shards.join(".lock-00001").exists() && shards.join("00000.json").exists();
        if !until(&mut small, is_alone) {
            return None;
        }
        signal(&small, "-STOP");
        let is_held = shards.join(".lock-00001").exists() && !shards.join("00001.json").exists();
        if !is_held {
            signal(&small, "-CONT");
        }
        is_held.then_some((round, small))
    });
    let (round, small) = small.expect("one run is stopped at work");
    let mut large = place.command(&format!("{order} set{round} --n 4")).spawn().expect("the program starts");
    let mut lines = BufReader::new(large.stderr.take().expect("a pipe"));
    // Where the larger run ends without the shard of the smaller one, it never says so.
    until_said(&mut lines, "waiting for shard 1, which another process is making");
    assert!(large.try_wait().expect("it can be asked").is_none(), "it waits");
    signal(&small, "-CONT");
    let small = finished(small, "--n 2");
    let large = large.wait().expect("it ends");
    let mut told = String::new();
    lines.read_to_string(&mut told).expect("it is text");
    assert_eq!((small.code, large.code()), (0, Some(0)), "{}{told}", small.err);
    assert_same(&place.tree("whole"), &place.tree(&format!("set{round}")), "after the smaller run");
}

#[test]
fn whoever_waits_for_a_lock_says_so() {
    let place = place();
    let lock = place.path("set/.lock-dataset");
    let held = File::create(&lock).expect("made");
    held.lock().expect("locked");
    let mut child = place.command("--recipe set --n 3").spawn().expect("the program starts");
    let mut lines = BufReader::new(child.stderr.take().expect("a pipe"));
    let told = until_said(&mut lines, "waiting for another process");
    assert!(told.contains("set/.lock-dataset"), "{told}");
    fs::remove_file(&lock).expect("it is there");
    drop(held);
    assert!(child.wait().expect("it ends").success());
    place.done("validate set --rerender 0");

    // A shard of a part, whose holder ends without it.
    let lock = place.path("set/shards/.lock-00004");
    let held = File::create(&lock).expect("made");
    held.lock().expect("locked");
    let mut child = place.command("--recipe set --n 6 --part 0/2").spawn().expect("the program starts");
    let mut lines = BufReader::new(child.stderr.take().expect("a pipe"));
    until_said(&mut lines, "waiting for shard 4");
    assert!(child.try_wait().expect("it can be asked").is_none());
    fs::remove_file(&lock).expect("it is there");
    drop(held);
    assert!(child.wait().expect("it ends").success());
    assert!(place.path("set/shards/00004.json").exists(), "the part is not complete");
    let help = place.run("--help").out;
    assert!(help.contains("waited for") && help.contains("Exit status"), "{help}");
}
