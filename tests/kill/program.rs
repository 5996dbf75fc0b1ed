//! `kill -9` at any moment: what has a final name is whole, and the same command completes the same bytes.

use std::collections::BTreeSet;
use std::path::Path;
use std::process::Child;
use std::thread::sleep;
use std::time::{Duration, Instant};

use serde_json::Value;
use test_support::program::{Place, assert_same, row_count, tree};

const ORDER: &str = "--recipe tiny.yaml --n 12 --samples-per-shard 2 --out";
/// Kills that must have hit a process at work, on boards and on packs, which take the same way.
const KILLS: [u32; 2] = [12, 3];

/// Numbers without pattern, the same in every run.
struct Dice(u64);

impl Dice {
    /// Even in [0, 1).
    fn roll(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f64 / (1u64 << 24) as f64
    }
}

#[test]
fn killed_runs_end_in_the_dataset_of_an_undisturbed_one() {
    let _machine = crate::alone();
    // Every sensor frame is kept, so that a good part of the time goes into writing.
    let places = Place::of_each_subject(&[["sensor_stack: none", "sensor_stack: all"]]);
    for (place, kills) in places.iter().zip(KILLS) {
        kill_and_complete(place, kills);
    }
}

fn kill_and_complete(place: &Place, most: u32) {
    let start = Instant::now();
    place.done(&format!("{ORDER} whole"));
    let whole_run = start.elapsed();
    let whole = place.tree("whole");

    let mut dice = Dice(7);
    let (mut kills, mut writing, mut partial, mut rounds) = (0, 0, 0, 0);
    while kills < most {
        rounds += 1;
        assert!(rounds < 60, "{kills} kills of {most} hit a process at work in {rounds} datasets");
        let out = format!("set{rounds}");
        loop {
            let mut child = place.command(&format!("{ORDER} {out}")).spawn().expect("the program starts");
            if dice.roll() < 0.5 {
                // At any time, most of it spent with light.
                sleep(whole_run.mul_f64(dice.roll() * 0.6));
            } else {
                // While a file is being written, or just after.
                let seen = until_writing(&mut child, &place.path(&out), (dice.roll() * 4.0) as u32);
                sleep(Duration::from_micros((dice.roll() * 20_000.0) as u64));
                writing += u32::from(seen);
            }
            if let Some(status) = child.try_wait().expect("the child can be asked") {
                assert!(status.success());
                break;
            }
            child.kill().expect("it can be killed");
            if child.wait().expect("it ends").success() {
                break;
            }
            kills += 1;
            let finished = check_what_is_there(place, &out);
            partial += u32::from((1..6).contains(&finished));
        }
        place.done(&format!("{ORDER} {out}"));
        assert_same(&whole, &place.tree(&out), &format!("round {rounds}"));
        std::fs::remove_dir_all(place.path(&out)).expect("it can be removed");
    }
    // The moments were spread: some at work on a file, some between finished shards.
    println!("{kills} kills in {rounds} datasets, {writing} while writing, {partial} between finished shards");
    assert!(
        6 * writing >= most && 6 * partial >= most,
        "{kills} kills, {writing} while writing, {partial} between shards"
    );
}

/// Waits until a temporary name stands in the folder that was not there when the process started, `skip` times over.
fn until_writing(child: &mut Child, root: &Path, skip: u32) -> bool {
    let mut known: BTreeSet<String> = temporary(root).collect();
    let mut left = skip;
    while child.try_wait().expect("the child can be asked").is_none() {
        let now: BTreeSet<String> = temporary(root).collect();
        if now.iter().any(|name| !known.contains(name)) {
            if left == 0 {
                return true;
            }
            left -= 1;
        }
        known = now;
        sleep(Duration::from_micros(300));
    }
    false
}

fn temporary(root: &Path) -> impl Iterator<Item = String> {
    let folders = ["", "data", "exr", "stacks", "shards"].map(|folder| root.join(folder));
    let names = folders.into_iter().filter_map(|folder| std::fs::read_dir(folder).ok()).flatten();
    names.filter_map(|entry| Some(entry.ok()?.file_name().to_string_lossy().into_owned())).filter(|n| is_temporary(n))
}

fn is_temporary(name: &str) -> bool {
    name.starts_with(".tmp-")
}

/// Looks at a dataset whose maker was killed; the number of its finished shards.
fn check_what_is_there(place: &Place, out: &str) -> usize {
    if !place.path(out).join("dataset.json").exists() {
        return 0;
    }
    let report: Value =
        serde_json::from_str(&place.run(&format!("validate {out} --json --rerender 0")).out).expect("it is JSON");
    let faults = report["faults"].as_array().expect("a list").iter();
    let codes: BTreeSet<&str> = faults.filter_map(|fault| fault["code"].as_str()).collect();
    // Missing manifests, and what shards without one have left behind; no finished shard has a fault.
    let allowed = BTreeSet::from(["manifest-missing", "file-unexpected", "file-missing", "card-differs"]);
    assert!(codes.is_subset(&allowed), "{report:#}");
    for fault in report["faults"].as_array().expect("a list") {
        let (code, at) = (fault["code"].as_str().unwrap_or(""), fault["place"].as_str().unwrap_or(""));
        // Card and metadata are written after the head, and once more after the last shard.
        let is_card = ["README.md", "croissant.json"].contains(&at);
        assert!(!["file-missing", "card-differs"].contains(&code) || is_card, "{fault}");
    }
    // What has a final name is whole, with or without a manifest.
    for (name, bytes) in tree(&place.path(out)) {
        let last = name.rsplit('/').next().unwrap_or_default();
        if name.split('/').any(|part| is_temporary(part) || part.starts_with(".lock-")) {
            continue;
        }
        match last.rsplit('.').next() {
            Some("json") => _ = serde_json::from_slice::<Value>(&bytes).unwrap_or_else(|e| panic!("{name}: {e}")),
            Some("parquet") => assert!(row_count(&place.path(out).join(&name)) > 0, "{name}"),
            Some("exr") => {
                let read = exr::prelude::read_all_data_from_file(place.path(out).join(&name));
                assert!(read.is_ok(), "{name}: {:?}", read.err());
            }
            _ => assert!(bytes.ends_with(b"\n"), "{name}"),
        }
    }
    report["shards"].as_u64().expect("a number") as usize
}
