//! Keys in the words of data sheets: what they stand for, and what is refused.

use crate::support::{GOOD, only};
use recipe::{Distribution, Recipe};

fn drawn(line: &str, path: &str) -> Distribution {
    let recipe = Recipe::parse("good.yaml", &format!("{GOOD}{line}\n")).unwrap_or_else(|error| panic!("{error}"));
    recipe.distribution("clear", path).expect("declared").clone()
}

/// The same recipe as by the keys that were stood for.
#[test]
fn words_of_data_sheets_stand_for_keys() {
    let fixed = |line: &str, path: &str, wanted: f64| {
        let Distribution::Fixed(found) = drawn(line, path) else { panic!("{line}") };
        assert!((found / wanted - 1.0).abs() < 1e-12, "{line}: {found}, not {wanted}");
    };
    // A beam of half width w at 1/e^2 has half of its peak w sqrt(ln 2 / 2) from its middle.
    fixed("laser: {waist_fwhm_mm: 0.2}", "laser.waist_mm", 0.1 / (0.5 * 2f64.ln()).sqrt());
    fixed("motion: {speed_mm_per_s: 350, line_rate_hz: 7000}", "motion.step_mm", 0.05);
    let legs = "camera: {working_distance_mm: 300, baseline_mm: 400}";
    fixed(legs, "camera.distance_mm", 500.0);
    fixed(legs, "camera.tilt_deg", (4.0f64 / 3.0).atan().to_degrees());
    let Distribution::Uniform { min, max } = drawn("laser: {waist_fwhm_mm: {uniform: [0.2, 0.4]}}", "laser.waist_mm")
    else {
        panic!("no uniform")
    };
    assert!((max / min - 2.0).abs() < 1e-12);
    // The canonical form knows what was stood for alone, and is the recipe.
    let recipe = Recipe::parse("good.yaml", &format!("{GOOD}{legs}\n")).expect("good");
    let again = Recipe::parse("again.yaml", &recipe.canonical_json()).expect("good");
    assert_eq!(recipe.hash(), again.hash());
    assert!(recipe.canonical()["camera"]["baseline_mm"].is_null());
    // In a class too.
    let text = "name: a\nsubject: wood\nunstated: fixed\nclasses: {a: {share: 1, laser: {waist_fwhm_mm: 0.2}}}\n";
    let recipe = Recipe::parse("good.yaml", text).expect("good");
    assert!(
        matches!(recipe.distribution("a", "laser.waist_mm"), Some(Distribution::Fixed(w)) if *w > 0.16 && *w < 0.18)
    );
}

#[test]
fn what_does_not_go_together_is_refused() {
    only(
        "laser: {waist_mm: 0.1, waist_fwhm_mm: 0.2}",
        (1, 24),
        "laser.waist_fwhm_mm",
        &["stands for `waist_mm`, which is given too", "remove one"],
    );
    only("motion: {speed_mm_per_s: 350}", (1, 26), "motion.speed_mm_per_s", &["`line_rate_hz` beside it"]);
    only("camera: {baseline_mm: 200}", (1, 23), "camera.baseline_mm", &["one leg", "`working_distance_mm`"]);
    only("laser: {waist_fwhm_mm: 9}", (1, 24), "laser.waist_fwhm_mm", &["9 is out of range", "2.35"]);
    let flat = "camera: {working_distance_mm: 1000, baseline_mm: 20}";
    only(flat, (1, 31), "camera.working_distance_mm", &["makes `tilt_deg` 1.15", "5 to 75"]);
    // Checks of keys together name the line of the key that stands for one of them.
    let near = "camera: {focal_length_mm: 200, working_distance_mm: 300, baseline_mm: 150}";
    only(near, (1, 10), "camera.focal_length_mm", &["half the distance"]);
}
