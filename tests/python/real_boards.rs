//! What holds simulated boards to photographs (python/likeness.py, python/transfer.py): definitions against kept
//! figures, scores against hand-worked ones, planted differences that are found, and both programs on made-up
//! photographs.

use serde_json::Value;
use test_support::program::Place;

use crate::scripts::{Said, python};

/// The test of that name in real_boards.py holds.
fn holds(place: &Place, name: &str, arguments: &[&str]) {
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/python/real_boards.py");
    let said = python(&place.path(""), &[&[script, name][..], arguments].concat());
    println!("{name}: {}", said.out);
    assert_eq!(said.code, 0, "{name}:\n{}{}", said.out, said.err);
}

#[test]
fn figures_are_those_of_the_definitions() {
    for name in
        ["figures_are_those_that_were_kept", "pixels_that_are_missing_count_for_nothing", "looseness_is_what_was_drawn"]
    {
        holds(&Place::new(), name, &[]);
    }
}

#[test]
fn what_differs_is_told_apart_and_only_that() {
    holds(&Place::new(), "a_ring_tells_where_it_differs_and_only_there", &[]);
    holds(&Place::new(), "planted_waves_are_told_apart", &[]);
    holds(&Place::new(), "what_tells_windows_apart_is_found", &[]);
}

#[test]
fn scores_are_those_of_the_hand() {
    holds(&Place::new(), "precision_is_that_of_the_hand", &[]);
    holds(&Place::new(), "intervals_hold_the_share", &[]);
}

/// Made-up photographs in `real`, and boards with knots in `boards`.
fn both() -> Place {
    let place = Place::new();
    place.write("boards.yaml", include_str!("../../recipes/wood-train.yaml"));
    let lamps = "--set lamps.number=two --set output.png=[reflectance,grey,label]";
    place.done(&format!("--recipe boards.yaml --n 16 --seed 3 --out boards {lamps}"));
    let real = place.path("real").display().to_string();
    holds(&place, "write_photographs", &[&real]);
    place
}

fn run(place: &Place, script: &str, more: &[&str]) -> Said {
    let [real, boards, out] = ["real", "boards", "out"].map(|name| place.path(name).display().to_string());
    python(&place.path(""), &[&[script, "--real", &real, "--simulated", &boards, "--out", &out][..], more].concat())
}

fn done(said: &Said) {
    assert_eq!(said.code, 0, "{}{}", said.out, said.err);
}

fn written(place: &Place, name: &str) -> Value {
    let text = std::fs::read_to_string(place.path("out").join(name)).expect("it was written");
    serde_json::from_str(&text).expect("JSON")
}

#[test]
fn finders_learn_and_datasets_become_windows() {
    let place = both();
    let [real, boards] = ["real", "boards"].map(|name| place.path(name).display().to_string());
    holds(&place, "samples_become_windows", &[&boards]);
    holds(&place, "a_finder_learns_what_knots_are", &[&real]);
}

/// Both programs say what they were asked, leave sealed pictures alone unless these are asked for, and refuse with a
/// remedy.
#[test]
fn programs_compare_boards_with_photographs() {
    let place = both();
    let said = run(&place, "likeness.py", &["--only", "table", "ring"]);
    done(&said);
    for name in ["simulated, grey", "simulated, reflectance"] {
        assert!(said.out.contains(&format!("| {name} |")), "{}", said.out);
    }
    assert!(!said.out.contains("scatter"), "no images of it");
    assert!(said.out.contains("| rings |") && said.out.contains("| photographs |"), "{}", said.out);
    let told = written(&place, "likeness.json");
    assert_eq!(told["pictures"], 8, "sealed pictures are not looked at");
    let widened: Vec<f64> = serde_json::from_value(told["looseness"]["widened"].clone()).expect("two numbers");
    assert!(
        widened.iter().all(|factor| (1.0..1.2).contains(factor)),
        "tight boxes, half a rim around each: {widened:?}"
    );

    let few = ["--steps", "4", "--real-boards", "2", "9"];
    let said = run(&place, "transfer.py", &few);
    done(&said);
    let told = written(&place, "transfer.json");
    let finders = told["finders"].as_object().expect("finders");
    let asked = ["simulated", "2 real", "simulated and 2 real"];
    let names: Vec<_> = ["network", "forest"].iter().flat_map(|f| asked.map(|of| format!("{f}, {of}"))).collect();
    assert!(
        names.len() == finders.len() && names.iter().all(|name| finders.contains_key(name)),
        "{:?}",
        finders.keys()
    );
    assert_eq!(finders["network, 2 real"]["found"].as_object().expect("boards").len(), 8);
    let differences = told["differences"].as_object().expect("differences");
    let both = &differences["forest, simulated and 2 real less forest, 2 real"]["knots 0.5"];
    let [low, value, high] = ["low", "value", "high"].map(|key| both[key].as_f64().expect("a number"));
    assert!(differences.len() == 5 && low <= value && value <= high, "{differences:?}");
    assert!(place.path("out/worst.png").exists());
    done(&run(&place, "transfer.py", &["--steps", "2", "--real-boards", "2", "--part", "sealed"]));
    assert_eq!(
        written(&place, "transfer.json")["finders"]["network, 2 real"]["found"].as_object().expect("boards").len(),
        4
    );

    let refused = |said: Said, words: &[&str]| {
        assert!(said.code != 0 && !said.err.contains("Traceback"), "{}", said.err);
        assert!(words.iter().all(|word| said.err.contains(word)), "{}", said.err);
    };
    refused(run(&place, "transfer.py", &["--real-boards", "9"]), &["--real-boards [9]", "4 to learn from"]);
    refused(run(&place, "likeness.py", &["--map", "scatter"]), &["no images scatter", "output.png"]);
    refused(run(&place, "likeness.py", &["--boards", "0"]), &["at least 1"]);
    std::fs::remove_file(place.path("real/truth.json")).expect("it was there");
    refused(run(&place, "likeness.py", &[]), &["truth.json", "docs/real.md"]);
}
