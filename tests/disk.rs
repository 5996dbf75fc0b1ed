//! A disk that is too small or fills up: refused before the work, or stopped with finished shards whole and continued.

use std::fs::{self, File};
use std::io::Write;

use serde_json::Value;
use test_support::disk::Disk;
use test_support::program::{Place, assert_same, until};
use tools::export::EXPORTS;

/// A disk of so many MB in the folder `disk` of a place.
fn disk(place: &Place, megabytes: u32) -> Option<Disk> {
    let path = place.path("disk");
    fs::create_dir(&path).expect("a folder");
    Disk::mount(&path, &format!("size={megabytes}m"))
}

/// Fills a disk until so many bytes are left.
fn fill(disk: &Disk, left: usize) {
    let mut file = File::create(disk.path().join("filler")).expect("a file");
    while file.write(&[7; 4096]).is_ok_and(|written| written > 0) {}
    let length = file.metadata().expect("its size").len();
    file.set_len(length.saturating_sub(left as u64)).expect("it can be cut");
}

#[test]
fn a_disk_that_is_too_small_is_refused_before_the_work() {
    let place = Place::with(&[]);
    let Some(disk) = disk(&place, 3) else { return };
    let order = "--recipe tiny.yaml --n 200 --out disk/set";
    let words = ["200 samples", "MB free", "disk/set", "make room", "--out", "output.bin"];
    let run = place.run(order);
    assert_eq!(run.code, 1, "{}", run.err);
    words.iter().for_each(|word| assert!(run.err.contains(word), "no `{word}` in {}", run.err));
    let estimate = place.run(&format!("{order} --estimate"));
    assert_eq!(estimate.code, 1, "{}", estimate.err);
    words.iter().for_each(|word| assert!(estimate.out.contains(word), "no `{word}` in {}", estimate.out));
    assert_eq!(fs::read_dir(disk.path()).expect("it lists").count(), 0, "nothing was begun");
    // Part of the dataset needs a part of the space, and what is there needs none.
    place.done("--recipe tiny.yaml --n 12 --out disk/set");
    fill(&disk, 200_000);
    let again = place.done("--recipe tiny.yaml --n 12 --out disk/set");
    assert!(again.err.contains("nothing to do"), "{}", again.err);
    assert_eq!(place.run("--recipe tiny.yaml --n 24 --out disk/set").code, 1);
}

#[test]
fn a_disk_that_fills_up_stops_the_work_and_loses_nothing() {
    let place = Place::with(&[["sensor_stack: none", "sensor_stack: {every: 8}"]]);
    let Some(disk) = disk(&place, 12) else { return };
    let order = "--recipe tiny.yaml --n 24 --samples-per-shard 3 --threads 1 --out";
    place.done(&format!("{order} whole"));

    let mut child = place.command(&format!("{order} disk/set")).spawn().expect("the program starts");
    let second = disk.path().join("set/shards/00001.json");
    assert!(until(&mut child, || second.exists()), "it ended before its second shard");
    // Somebody else takes the rest of the disk: the early look at the free space has passed.
    fill(&disk, 100_000);
    let output = child.wait_with_output().expect("it ends");
    let text = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{text}");
    for word in ["disk is full", "free", "needed", "finished shards are intact", "make room", "same command"] {
        assert!(text.contains(word), "no `{word}` in {text}");
    }
    assert!(!text.contains("panicked"), "{text}");

    let report: Value =
        serde_json::from_str(&place.run("validate disk/set --json --rerender 2").out).expect("it is JSON");
    let counts = report["fault_counts"].as_object().expect("counts");
    assert!(counts.keys().eq(["manifest-missing"]), "{report:#}");
    let finished = report["shards"].as_u64().expect("a number");
    assert!((2..8).contains(&finished) && report["samples"] == 3 * finished, "{report:#}");
    assert_eq!(counts["manifest-missing"], 8 - finished);

    // The disk is still full: refused at once, or stopped again; the finished shards stay.
    let full = place.run(&format!("{order} disk/set"));
    assert_eq!(full.code, 1, "{}", full.err);
    assert!(full.err.contains("free") && full.err.contains("make room"), "{}", full.err);

    disk.grow(40);
    place.done(&format!("{order} disk/set"));
    assert_same(&place.tree("whole"), &place.tree("disk/set"), "continued on a larger disk");
}

#[test]
fn an_estimate_counts_what_is_left() {
    let place = Place::with(&[]);
    let order = "--recipe tiny.yaml --n 10 --samples-per-shard 4 --out set --estimate";
    let before = place.done(order);
    assert!(before.out.starts_with("10 of 10 samples to make in set\n"), "{}", before.out);
    assert!(!place.path("set").exists(), "an estimate makes nothing");
    for line in ["  time ", "  disk ", " a sample", " free"] {
        assert!(before.out.contains(line), "no `{line}` in {}", before.out);
    }
    assert!(!before.out.contains("unknown"), "{}", before.out);
    let classes = |text: &str| -> Vec<(String, u64)> {
        let of =
            |line: &str| line.strip_prefix("  class  ")?.split_once(": ").map(|(a, b)| (a.to_owned(), b.to_owned()));
        // 4, of these 3 to train, 1 to validate, 0 to test.
        let all = |counts: &str| {
            let numbers = counts.split(|c: char| !c.is_ascii_digit()).filter(|word| !word.is_empty());
            let numbers: Vec<u64> = numbers.map(|word| word.parse().expect("a number")).collect();
            let [all, splits @ ..] = &numbers[..] else { panic!("no number in {counts}") };
            assert!(splits.len() == 3 && splits.iter().sum::<u64>() == *all, "{counts}");
            *all
        };
        text.lines().filter_map(of).map(|(name, counts)| (name, all(&counts))).collect()
    };
    let counted = classes(&before.out);
    assert_eq!(counted.iter().map(|(_, n)| n).sum::<u64>(), 10, "{counted:?}");

    place.make("set", "--n 8 --samples-per-shard 4");
    let after = place.done(order);
    assert!(after.out.starts_with("2 of 10 samples to make in set\n"), "{}", after.out);
    place.make("set", "--n 10 --samples-per-shard 4");
    assert!(place.done(order).out.starts_with("0 of 10 samples to make in set\n"));

    // What was counted is what was made.
    let names = place.json("set/dataset.json")["classes"].clone();
    let samples = place.samples("set");
    for (name, count) in counted {
        let number = names.as_array().expect("names").iter().position(|n| *n == *name).expect("the class is known");
        let made = samples.values().filter(|s| format!("{}", s.columns["class"]) == number.to_string()).count();
        assert_eq!(made as u64, count, "{name}");
    }
}

#[test]
fn an_estimate_is_near_what_is_written() {
    let place = Place::with(&[]);
    let estimate = place.done("--recipe wood-small.yaml --n 6 --out set --estimate");
    let disk = estimate.out.lines().find_map(|line| line.strip_prefix("  disk   ")).expect("a line about the disk");
    let megabytes: f64 = disk.split_once(" MB").expect("a size").0.parse().expect("a number");
    place.done("--recipe wood-small.yaml --n 6 --out set");
    let written = place.tree("set").values().map(Vec::len).sum::<usize>() as f64 / 1e6;
    assert!((0.95..1.2).contains(&(megabytes / written)), "{megabytes} MB estimated, {written} MB written");
}

/// An export that fills a disk ends with the reason and the remedy, and the same command goes on where there is room.
#[test]
fn an_export_that_fills_a_disk_goes_on() {
    let place = Place::with(&[]);
    place.make("set", "--n 24");
    let Some(disk) = disk(&place, 1) else { return };
    fill(&disk, 60_000);
    // MVTec's folders leave pictures out, and may fit.
    for format in EXPORTS.iter().map(|format| format.name).filter(|name| !name.starts_with("mvtec")) {
        let order = format!("export {format} set --out disk/{format}");
        let run = place.run(&order);
        assert_eq!(run.code, 1, "{format}: {}", run.err);
        assert!(run.err.contains("the disk is full") && run.err.contains("make room"), "{format}: {}", run.err);
        fs::remove_dir_all(disk.path().join(format)).expect("it is ours");
    }
    let order = "export png set --out disk/png";
    assert_eq!(place.run(order).code, 1);
    disk.grow(8);
    place.done(order);
    place.done("export png set --out whole");
    assert_same(&place.tree("whole"), &place.tree("disk/png"), "after a full disk");
}
