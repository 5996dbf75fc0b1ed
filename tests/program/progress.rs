//! Progress where standard error is no terminal, and what is said when Ctrl-C stops the work.

use std::io::Read;
use std::process::Command;
use std::thread::sleep;
use std::time::{Duration, Instant};

use test_support::program::{FRAMES, Place};

/// Long work tells how far it is: with no time between its lines, each command has some.
#[test]
fn pipes_see_progress() {
    let place = Place::with(&[FRAMES]);
    let always = "--progress 0";
    let lines = |arguments: &str, words: &[&str]| {
        let told = place.done(&format!("{arguments} {always}")).err;
        let line = told.lines().find(|line| !line.starts_with("warning: ") && line.contains(" %, "));
        let line = line.unwrap_or_else(|| panic!("gen {arguments} shows no progress: {told}"));
        words.iter().for_each(|word| assert!(line.contains(word), "gen {arguments}: no `{word}` in {line}"));
        let ends = |line: &str| line.contains("100 %") && line.contains("left");
        assert!(!told.lines().any(ends), "gen {arguments}: something is left in the end: {told}");
    };
    lines("--recipe tiny.yaml --n 4 --out set", &["/4 samples", "profiles/s"]);
    lines("--recipe tiny.yaml --n 4 --estimate", &["profiles/s"]);
    lines("preview --recipe tiny.yaml", &["profiles/s"]);
    lines("validate set", &["/4 samples"]);
    lines("report set", &["steps"]);
    lines("export png set --out pngs", &["/4 samples"]);
    lines("compare set set", &["scans"]);
    lines("transport --medium clear-wood --model path --photons 20000", &["photons/s"]);
    lines("study transport --photons 1000", &["path about"]);
    // Where nothing shall be said, nothing is.
    assert_eq!(place.done(&format!("validate set --quiet {always}")).err, "");
}

/// Ctrl-C: what is kept, how to go on, status 130; and the same command goes on.
#[test]
fn stopping_says_what_is_kept() {
    let place = Place::with(&[]);
    let order = "--recipe tiny.yaml --n 4000 --samples-per-shard 1 --out set";
    let mut child = place.command(order).spawn().expect("it starts");
    let started = Instant::now();
    while !place.path("set/shards/00001.json").exists() {
        assert!(started.elapsed() < Duration::from_secs(120), "no shard is made");
        sleep(Duration::from_millis(10));
    }
    let interrupt = Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("kill runs");
    assert!(interrupt.success());
    let status = child.wait().expect("it ends");
    let mut told = String::new();
    child.stderr.take().expect("a pipe").read_to_string(&mut told).expect("it is text");
    assert_eq!(status.code(), Some(130), "{told}");
    for word in ["stopped", "of 4000 shards in set are finished and kept", "the same command goes on"] {
        assert!(told.contains(word), "no `{word}` in {told}");
    }
    let going_on = place.done("--recipe tiny.yaml --n 4 --out set --part 0/2000");
    assert!(going_on.err.contains("set: "), "{}", going_on.err);
}
