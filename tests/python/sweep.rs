//! `gen check --sweep` as its users run it: a key that costs the model is ranked first, one that does nothing is not
//! named, a killed sweep ends in the same bytes; and faults.

use std::fs;

use crate::models::{CHANNEL, model, needs_onnxruntime};
use serde_json::Value;
use test_support::program::{Place, until};

/// What is drawn: light that hides the board where it is least, and a dark current that nothing shows.
const DRAWN: &str = "--set exposure.time_us={\"log_uniform\":[8,40]} \
                     --set exposure.dark_current_e_per_s={\"uniform\":[20,120]}";
const KEYS: &str = "exposure.dark_current_e_per_s,exposure.time_us,camera.blur_um";

/// The small recipe, and a sidecar by which mean_sign tells board and conveyor by Scatter: 350 DN lie between both.
fn place() -> Place {
    needs_onnxruntime();
    let place = Place::with(&[]);
    let channel = CHANNEL.replace("mean: 600", "mean: 350");
    let classes = "[{name: board, of: [clear, sound_knot]}, background]";
    let task = format!("task: classify_pixels\n{channel}\nwindow_px: 8\npatches_per_class: 40\nclasses: {classes}\n");
    place.write("side.yaml", task);
    place
}

fn order(arguments: &str) -> String {
    let model = model("mean_sign.onnx");
    format!("check --model {model} --sidecar side.yaml --recipe tiny.yaml --sweep {arguments}")
}

/// Least light costs half of the answers and is named with what to do; the dark current's interval holds zero; blur,
/// which the recipe draws, is asked over its natural range too; a killed sweep goes on and ends in the same bytes.
#[test]
#[ignore = "long"]
fn a_key_that_costs_is_ranked_first() {
    let place = place();
    let asked = format!("--samples 12 --keys {KEYS} {DRAWN}");
    let run = place.done(&order(&format!("{asked} --out swept --json")));
    let found: Value = serde_json::from_str(&run.out).expect("it prints JSON");
    let keys = found["keys"].as_array().expect("a list");
    let key = |path: &str| keys.iter().find(|key| key["key"] == path).expect("it is asked");
    println!("{keys:#?}");
    let light = &keys[0];
    assert_eq!((&light["key"], &light["verdict"]), (&"exposure.time_us".into(), &"costs".into()));
    // Of 8 to 40 us, even in the logarithm, 5 % are 8.67 us: the board is taken for the conveyor.
    let worse = |what: &str| light["worse"][what].as_f64().expect("a number");
    assert!((worse("value") - 8.0 * 5_f64.powf(0.05)).abs() < 1e-9, "{light}");
    assert!((0.3..=0.6).contains(&worse("cost")) && worse("joint_low") > 0.0, "{light}");
    assert!(worse("low") < worse("cost") && worse("cost") < worse("high") && worse("joint_low") <= worse("low"));
    let advice = light["advice"].as_str().expect("it is told what to do");
    assert!(advice.starts_with("exposure.time_us: ") && advice.contains("hold it near 17.89 on the rig"), "{advice}");
    let idle = key("exposure.dark_current_e_per_s");
    assert!(idle["worse"]["low"].as_f64().is_some_and(|low| low < 0.0), "{idle}");
    assert_eq!((&idle["verdict"], &idle["advice"]), (&"not seen".into(), &Value::Null));
    // The recipe draws 1.5 to 4 um, lenses have up to 6.
    let blur = key("camera.blur_um")["values"].as_array().expect("values");
    assert!(blur.len() == 3 && blur[2].as_f64().is_some_and(|um| um > 4.0), "{blur:?}");
    assert_eq!(run.out.as_bytes(), fs::read(place.path("swept/sweep.json")).expect("it is written"));
    assert_eq!(place.tree("swept").into_keys().collect::<Vec<_>>(), ["sweep.json"]);
    a_killed_sweep_goes_on(&place, &asked);
}

fn a_killed_sweep_goes_on(place: &Place, asked: &str) {
    let mut child = place.command(&order(&format!("{asked} --out killed"))).spawn().expect("it starts");
    let kept = place.path("killed/sweep.jsonl");
    let lines = || fs::read(&kept).map_or(0, |bytes| bytes.iter().filter(|byte| **byte == b'\n').count());
    assert!(until(&mut child, || lines() >= 3), "it ended before it was killed");
    child.kill().expect("it runs");
    child.wait().expect("it ends");
    assert!(!place.path("killed/sweep.json").exists());
    let other = place.run(&order(&format!("{asked} --out killed --seed 5")));
    other.refused(&["sweep.jsonl", "another sweep", "remove that file"]);
    place.done(&order(&format!("{asked} --out killed -j 1")));
    let read = |name: &str| fs::read(place.path(name)).expect("it is written");
    assert!(read("swept/sweep.json") == read("killed/sweep.json"));
}

/// Before it starts it can be asked what it takes: nothing is written then.
#[test]
fn what_it_takes_is_told() {
    let place = place();
    let run = place.done(&order(&format!("--samples 100 --keys {KEYS} {DRAWN} --estimate")));
    assert!(run.out.contains("3 keys, 9 values x 100 samples: 900 samples, about "), "{}", run.out);
    assert!(run.out.contains("exposure.time_us") && run.out.contains("17.9"), "{}", run.out);
    let json = place.done(&order(&format!("--samples 100 --keys {KEYS} {DRAWN} --estimate --json"))).out;
    let found: Value = serde_json::from_str(&json).expect("it prints JSON");
    assert!(found["samples"] == 900 && found["seconds"].as_f64().is_some_and(|seconds| seconds > 0.0), "{json}");
    assert!(!place.path("mean_sign-sweep").exists());
}

/// What cannot serve is refused with what to do, before anything is rendered.
#[test]
fn faults_name_their_remedy() {
    let place = place();
    fs::create_dir(place.path("mine")).expect("the folder is ours");
    place.write("mine/thesis.tex", "years");
    let model = model("mean_sign.onnx");
    for (arguments, code, words) in [
        (order("--keys exposure.tim_us"), 2, "did you mean `exposure.time_us`?"),
        (order("--keys camera.blur_um,camera.blur_um"), 2, "it is named twice"),
        (order("--keys knots.sound_count"), 2, "it is what samples are told by; leave it out"),
        (order("--keys scan.columns"), 2, "no key of a recipe about wood that is drawn has this name"),
        (order("--keys camera.focal_length_mm"), 2, "--set 'camera.focal_length_mm={uniform: [a, b]}'"),
        (order("--samples 9"), 2, "10"),
        (order("--set laser.power_mw=x"), 1, "laser.power_mw"),
        (order("--out mine"), 2, "it holds other things"),
        (order("--split all"), 2, "--sweep"),
        (format!("check --model {model} --sweep"), 2, "--recipe"),
        (format!("check --model {model} --recipe tiny.yaml"), 2, "--sweep"),
        (format!("check planks --model {model} --keys camera.blur_um"), 2, "--sweep"),
        (format!("check --model {model} --recipe tiny.yaml --sweep"), 1, "there is no sidecar beside it"),
        (format!("check --model {model} --recipe tiny.yaml --sweep --sidecar -"), 2, "give a file"),
        (order("").replace("mean_sign", "nothing"), 1, "there is no such model"),
        (order("").replace("tiny.yaml", "nowhere.yaml"), 1, "nowhere.yaml"),
        (order("").replace("mean_sign", "two_outputs"), 1, "channels"),
    ] {
        let run = place.run(&arguments);
        assert!(
            run.code == code && run.err.contains(words),
            "gen {arguments}: {}: no '{words}' in {}",
            run.code,
            run.err
        );
        assert_eq!(run.out, "", "{arguments}");
    }
    assert_eq!(place.tree("mine").len(), 1);
    assert!(!place.path("mean_sign-sweep").exists());
}
