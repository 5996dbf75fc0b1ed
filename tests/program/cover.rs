//! `gen cover` as its users run it: a key outside of the spread is named, the same bytes with one thread, what keys do
//! by class; and faults.

use serde_json::Value;
use test_support::program::{Place, recipe, sawtooth_recipe};

/// A small saw-tooth with three keys that are drawn.
fn place() -> Place {
    let place = Place::new();
    place.write("tiny.yaml", sawtooth_recipe(&[["\n  profiles: 48 ", "\n  profiles: 64 "]]));
    place
}

/// What the recipe draws.
const DRAWN: &str = "--set laser.waist_mm={\"log_uniform\":[0.08,0.12]} \
                     --set exposure.dark_noise_dn={\"uniform\":[1,2]} --set exposure.dark_level_dn={\"uniform\":[4,6]}";

fn json(out: &str) -> Value {
    serde_json::from_str(out).expect("it prints JSON")
}

/// A dark level above what the recipe draws is named first or second with its value, one thread makes the same page,
/// and a scan of the recipe itself is covered.
#[test]
#[ignore = "long"]
fn what_lies_outside_is_led_back() {
    let place = place();
    place.done(&format!("tiny.yaml --n 1 --seed 9 --out real {DRAWN} --set exposure.dark_level_dn=11"));
    place.done(&format!("tiny.yaml --n 1 --seed 9 --out clean {DRAWN}"));
    let order = format!("cover tiny.yaml {DRAWN} --simulations 400 --json");
    let run = place.done(&format!("{order} --real real --out cover.html"));
    let found = json(&run.out);
    assert_eq!(found["scans"][0]["outside"], true, "{}", found["scans"][0]["depth"]);
    let named: Vec<&str> = (0..2).filter_map(|n| found["widen"][n]["key"].as_str()).collect();
    let n = named.iter().position(|key| *key == "exposure.dark_level_dn").expect("it is named");
    let value = found["widen"][n]["values"][0].as_f64().expect("a number");
    assert!((9.0..13.0).contains(&value), "{}", found["widen"]);
    assert!(found["widen"][n]["words"].as_str().is_some_and(|words| words.contains("above 6")));
    place.done(&format!("{order} --real real --out again.html -j 1"));
    let read = |name: &str| std::fs::read(place.path(name)).expect("it is written");
    assert!(read("cover.html") == read("again.html"));
    let clean = json(&place.done(&format!("{order} --real clean --out clean.html")).out);
    assert_eq!((&clean["scans"][0]["outside"], &clean["widen"]), (&false.into(), &Value::Array(Vec::new())));
}

/// Without real scans, boards are asked by class: absorption of wood does something, a key of the sensor that is drawn
/// within nothing does not; of a dataset its recipe and seed are taken, and labels of its samples are asked too.
#[test]
#[ignore = "long"]
fn keys_are_told_by_class() {
    let place = Place::new();
    place.write("tiny.yaml", recipe(&[["\n  profiles: 48 ", "\n  profiles: 64 "]]));
    let set = "--set exposure.dsnu_dn={\"uniform\":[0,0.001]}";
    place.done(&format!("tiny.yaml --n 2 --seed 4 --out boards {set}"));
    let found = json(&place.done("cover boards --simulations 200 --json --out cover.html").out);
    assert_eq!(found["seed"], 4);
    assert!(found["classes"].as_array().is_some_and(|classes| classes.contains(&"clear".into())));
    let keys = found["keys"].as_array().expect("a list");
    let idle = |path: &str| keys.iter().find(|key| key["key"] == path).map(|key| key["idle"] == true);
    assert_eq!(idle("exposure.dsnu_dn"), Some(true), "{keys:#?}");
    assert!(keys.iter().any(|key| key["idle"] == false));
    let scans = json(&place.done("cover boards --real boards --scans 1 --simulations 200 --json --out on.html").out);
    let statistics = scans["scans"][0]["statistics"].as_array().expect("a list");
    assert!(statistics.iter().any(|statistic| statistic["key"] == "clear.range_noise_along"), "labels are asked");
}

/// What cannot serve is refused with what to do.
#[test]
fn faults_name_their_remedy() {
    let place = place();
    place.done("tiny.yaml --n 1 --out real");
    for (arguments, code, words) in [
        ("--real nowhere", 1, ["nowhere", "it is not there"]),
        ("--region 0,0,40,40", 2, ["--region", "--real"]),
        ("--bits 8", 2, ["--bits", "leave it away"]),
        ("--simulations 10", 2, ["--simulations", "200"]),
        ("--real real --set motion.step_mm=0.33", 1, ["apart", "motion.step_mm"]),
        ("--real real --set transport=path", 1, ["slow", "transport: kernel"]),
        ("--real real --out tiny.yaml", 2, ["tiny.yaml", "html"]),
    ] {
        let run = place.run(&format!("cover tiny.yaml {arguments}"));
        assert_eq!(run.code, code, "{arguments}: {}", run.err);
        words.iter().for_each(|word| assert!(run.err.contains(word), "{arguments}: no `{word}` in {}", run.err));
    }
    assert!(!place.path("sawtooth-small-cover.html").exists());
}
