//! The page of `gen tune` in Chromium: knobs, pictures, faults, texts, tabs, and memory.

use std::process::Stdio;

use serde_json::{Value, json};
use test_support::program::{Place, program};

use crate::scripts::interpreter;

/// What the script of this name finds.
fn found(place: &Place, what: &str) -> Value {
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/python/tune_browser.py");
    let output = interpreter()
        .arg(script)
        .arg(program())
        .arg(place.path(""))
        .arg(what)
        .stdin(Stdio::null())
        .output()
        .expect("python starts");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{what}: {said}");
    serde_json::from_slice(&output.stdout).unwrap_or_else(|_| panic!("{what} tells nothing: {said}"))
}

/// Knobs, pictures and texts go together: each picture on the page is that of `gen preview`, pixel for pixel.
#[test]
#[ignore = "long"]
fn the_page_of_tune_works() {
    let place = Place::with(&[]);
    let told = found(&place, "works");
    let sections: Vec<&str> = told["sections"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
    assert_eq!(sections[..3], ["scan", "motion", "laser"], "{told:#}");
    assert_eq!(told["at first"], json!([3, 3]), "pictures are those of preview: {told:#}");
    assert_eq!(told["moved"], json!([3, 3]), "those of the knob's new value, too: {told:#}");
    assert!(told["fault"].as_str().is_some_and(|text| text.contains("500")), "the fault names the range: {told:#}");
    assert_eq!(told["fault in the list"], 1);
    assert_eq!((&told["comments kept"], &told["lines changed"]), (&json!(true), &json!(1)), "{told:#}");
    assert_eq!(told["idle"], json!(["has no effect while `camera.filter` is `none`", true]));
    assert!(told["rig"].as_u64() > Some(10), "{told:#}");
    let values = told["values"].as_str().unwrap_or_default();
    assert!(["mm", "DN", "Picked: column", "class"].iter().all(|word| values.contains(word)), "{values}");
    assert_eq!(told["region"], json!([64, 48]));
    for (what, is_so) in [("two tabs", true), ("saved", true), ("file untouched", true)] {
        assert_eq!(told[what], is_so, "{what}: {told:#}");
    }
    assert_eq!(told["faults"], json!([]), "the console is empty");
    assert_eq!(told["interrupt"], 130, "Ctrl-C ends it");
}

/// Edits at random, 80 or `TUNE_EDITS`, leave the console empty and the page at work.
#[test]
#[ignore = "long"]
fn random_edits_leave_no_error() {
    let told = found(&Place::with(&[]), "many");
    assert_eq!(told["faults"], json!([]), "{told:#}");
    let [edits, knobs, turn] = ["edits", "knobs", "turn"].map(|what| told[what].as_u64().expect("a count"));
    assert!(5 * knobs > 2 * edits && 10 * turn > 3 * edits, "{told:#}");
}

/// A phone shows it without scrolling sideways, dark and light have their colours, and each control has a name.
#[test]
#[ignore = "long"]
fn the_page_fits_its_reader() {
    let told = found(&Place::with(&[]), "looks");
    assert!(told["phone"]["wide"].as_u64() <= Some(390), "{told:#}");
    assert_ne!(told["dark"]["paper"], told["light"]["paper"], "{told:#}");
    for look in ["phone", "dark", "light"] {
        assert_eq!((&told[look]["maps"], &told[look]["unnamed"]), (&json!(3), &json!([])), "{look}: {told:#}");
        assert_eq!(told[look]["faults"], json!([]), "{look}");
        assert_eq!(told[look]["hindrances"], json!([]), "{look}: axe-core");
    }
}

/// Moves, 250 or `TUNE_MOVES`, take no more memory than the first two fifths of them, but for what the allocator keeps.
#[cfg(target_os = "linux")]
#[test]
#[ignore = "long"]
fn moves_take_no_memory() {
    let told = found(&Place::with(&[]), "memory");
    let held: Vec<f64> = told["mb"].as_array().into_iter().flatten().filter_map(Value::as_f64).collect();
    println!("memory after each fifth of the moves: {held:?} MB");
    assert!(held.len() == 5 && held[4] < 1.1 * held[1] + 10.0, "{held:?}");
}
