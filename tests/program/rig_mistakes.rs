//! Guards against values that are legal alone and absurd together: each usual mistake in copying a data sheet is named
//! with the number that was likely to be meant, and neither shipped recipes nor ordinary benches are suspected of one.

use recipe::Recipe;
use rig::mistakes::{MISTAKES, mistakes};
use test_support::program::Place;

/// A built-in recipe with changes, one a `KEY=VALUE`.
fn changed(name: &str, changes: &[&str]) -> Recipe {
    let changes: Vec<_> = changes.iter().map(|change| change.parse().expect("a change")).collect();
    Recipe::load_changed(name, &changes).unwrap_or_else(|fault| panic!("{name} {changes:?}: {fault}"))
}

#[test]
fn each_mistake_is_named_with_what_was_meant() {
    for mistake in MISTAKES {
        let [name, changes] = mistake.example;
        let told = mistakes(&changed(name, &changes.split(' ').collect::<Vec<_>>()), 0);
        let words = format!("which looks like {}", mistake.looks_like);
        let own = told.iter().find(|told| told.what.starts_with(mistake.key) && told.what.ends_with(&words));
        assert!(own.is_some_and(|own| own.remedy.starts_with("did you mean ")), "{changes}: {told:?}");
    }
    for (name, change, meant) in [
        ("wood-small", "board.length_mm=4.2", "4200"),
        ("wood-small", "laser.waist_height_mm=400", "0"),
        ("wood-small", "laser.waist_height_mm=385", "15"),
        ("wood-small", "laser.power_mw=0.05", "50"),
        ("wood-small", "camera.distance_mm=60", "600"),
        ("wood", "laser.fan_angle_deg=10", "20"),
    ] {
        let told = mistakes(&changed(name, &[change]), 1);
        assert!(told.iter().any(|told| told.remedy == format!("did you mean {meant}?")), "{change}: {told:?}");
    }
}

#[test]
fn no_shipped_recipe_is_suspected() {
    for known in Recipe::embedded() {
        let recipe = Recipe::load(known.name).expect("it is built in");
        for seed in 0..3 {
            assert_eq!(mistakes(&recipe, seed), [], "{} with seed {seed}", known.name);
        }
    }
}

/// Numbers that data sheets of lasers, cameras and sensors have, drawn each on its own.
#[test]
#[ignore = "long"]
fn no_ordinary_bench_is_suspected() {
    const ORDINARY: [&str; 21] = [
        "motion.step_mm={log_uniform: [0.02, 0.3]}",
        "motion.line_rate_hz={log_uniform: [30, 2000]}",
        "laser.wavelength_nm={choice: {values: [405, 450, 525, 640, 660, 785, 850]}}",
        "laser.power_mw={log_uniform: [5, 200]}",
        "laser.waist_mm={log_uniform: [0.03, 0.3]}",
        "laser.waist_height_mm={uniform: [-50, 100]}",
        "laser.m_squared={uniform: [1, 2]}",
        "laser.fan_height_mm={uniform: [200, 800]}",
        "laser.fan_angle_deg={uniform: [20, 90]}",
        "laser.smile_um={uniform: [2, 50]}",
        "camera.distance_mm={uniform: [250, 800]}",
        "camera.tilt_deg={uniform: [20, 45]}",
        "camera.focal_length_mm={choice: {values: [16, 25, 35, 50]}}",
        "camera.f_number={choice: {values: [1.4, 2, 2.8, 4, 5.6, 8, 11, 16]}}",
        "camera.pixel_um={choice: {values: [2.5, 3.45, 4.5, 5.5, 6, 9]}}",
        "camera.blur_um={uniform: [0.5, 6]}",
        "exposure.time_us={log_uniform: [5, 450]}",
        "exposure.full_well_e={log_uniform: [4750, 100000]}",
        "exposure.dark_level_dn={uniform: [2, 14]}",
        "exposure.dark_noise_dn={uniform: [1, 2]}",
        "exposure.bits=12",
    ];
    for name in ["wood-small", "blister-small", "sawtooth-small", "mesh-small"] {
        let recipe = changed(name, &ORDINARY);
        for seed in 0..200 {
            assert_eq!(mistakes(&recipe, seed), [], "{name} with seed {seed}");
        }
    }
}

/// A run, a preview and `gen rig` ask the question, `--strict` refuses, and no document of the dataset has the guess.
#[test]
fn a_likely_mistake_is_asked_about() {
    let place = Place::new();
    let change = "--set board.length_mm=4.2 --set scan.profiles=64 --set scan.columns=64";
    let question = "board.length_mm is 4.2, which looks like metres in place of millimetres; did you mean 4200?";
    for command in
        ["rig wood-small", "preview --recipe wood-small --out board.png", "--recipe wood-small --n 1 --out set"]
    {
        let asked = place.done(&format!("{command} {change}"));
        assert!(asked.err.contains(&format!("warning: {question}")), "{command}: {}", asked.err);
    }
    assert!(!String::from_utf8_lossy(&std::fs::read(place.path("set/dataset.json")).expect("a head")).contains("4200"));
    for command in ["rig wood-small", "--recipe wood-small --n 1 --out other", "--recipe wood-small --n 2 --out set"] {
        let strict = place.run(&format!("{command} {change} --strict"));
        assert!(strict.code == 1 && strict.err.contains(question), "{command}: {}", strict.err);
    }
    assert!(!place.path("other").exists());

    // A window that is wide enough is not to be had, and not advised.
    let far = place.done("rig wood-small --set laser.waist_height_mm=400");
    assert!(far.err.contains("in place of its height") && far.err.contains("narrow it on the object"), "{}", far.err);
    assert!(!far.err.contains("raise extraction.window_rows"), "{}", far.err);
}
