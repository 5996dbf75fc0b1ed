//! Progress where standard error is no terminal, and what is said when Ctrl-C stops the work.

use std::io::{BufRead, BufReader, Read};
use std::process::Command;

use test_support::program::{FRAMES, Place, assert_same, until};

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
    assert!(until(&mut child, || place.path("set/shards/00001.json").exists()), "no shard is made");
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

/// What a stop loses is said: by progress, which tells what is kept of what is done, and at the stop. Guards counts
/// that take for done what may be lost. Nothing is kept, so the shards may have another size.
#[test]
fn stopping_says_what_is_lost() {
    let place = Place::with(&[]);
    let order = "--recipe tiny.yaml --n 4000 --samples-per-shard 2000 --progress 0 --out set";
    let mut child = place.command(order).spawn().expect("it starts");
    let mut lines = BufReader::new(child.stderr.take().expect("a pipe"));
    let mut told = String::new();
    while !told.contains("/4000 samples (0 kept)") {
        assert!(lines.read_line(&mut told).expect("it is text") > 0, "nothing is said to be unkept: {told}");
    }
    let interrupt = Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("kill runs");
    assert!(interrupt.success());
    lines.read_to_string(&mut told).expect("it is text");
    assert_eq!(child.wait().expect("it ends").code(), Some(130), "{told}");
    let last = told.lines().last().expect("the last words");
    let words = ["stopped: 0 of 2 shards", "finished sample", "of an unfinished shard are lost", "can still be given"];
    for word in words {
        assert!(last.contains(word), "no `{word}` in {last}");
    }
    let again = place.done("--recipe tiny.yaml --n 4 --samples-per-shard 2 --out set");
    assert!(again.err.contains("begun with 4000 samples in shards of 2000"), "{}", again.err);
    place.make("whole", "--n 4 --samples-per-shard 2");
    assert_same(&place.tree("set"), &place.tree("whole"), "begun anew after a stop");
}
