//! Purpose: what a recipe says of the camera has an effect or is refused, and what cannot be together is told.

use crate::support::{GOOD, only};
use optical_bench::settings::{Filter, LensModel, Scheimpflug};
use recipe::Recipe;

#[test]
fn settings_of_the_camera_arrive() {
    let text = format!(
        "{GOOD}camera: {{scheimpflug: given, lens: pinhole, filter: band_pass, diffraction: false, offset_rows: -20, \
         offset_columns: 8.5, sensor_tilt_deg: 3, focus_distance_mm: 1e9, filter_width_nm: 12}}"
    );
    let scene = Recipe::parse("camera.yaml", &text).expect("it is good").draw(0, 0);
    let optics = scene.bench.optics;
    assert_eq!(
        (optics.scheimpflug, optics.lens, optics.filter),
        (Scheimpflug::Given, LensModel::Pinhole, Filter::BandPass)
    );
    assert!(!optics.diffraction && optics.offset_rows == -20.0 && optics.offset_columns == 8.5);
    assert_eq!((scene.bench.camera.focus_distance_mm, scene.bench.camera.filter_width_nm), (1e9, 12.0));
    // What a recipe means is a recipe that means the same.
    let recipe = Recipe::parse("camera.yaml", &text).expect("it is good");
    let again = Recipe::parse("canonical.json", &recipe.canonical_json()).expect("its canonical form is good too");
    assert_eq!(again.hash(), recipe.hash());
}

#[test]
fn numbers_without_effect_say_what_they_need() {
    for (line, key, words) in [
        (
            "camera: {sensor_tilt_deg: 5}",
            "camera.sensor_tilt_deg",
            ["`camera.scheimpflug` is `solved`", "give `given`"],
        ),
        ("camera: {focus_distance_mm: 400}", "camera.focus_distance_mm", ["no effect", "remove it"]),
        (
            "camera: {filter_centre_nm: 655}",
            "camera.filter_centre_nm",
            ["`camera.filter` is `none`", "give `band_pass`"],
        ),
        ("camera: {filter_width_nm: {uniform: [10, 20]}}", "camera.filter_width_nm", ["no effect", "remove it"]),
        ("camera: {lens: pinhole}", "camera.lens", ["no effect", "give `given`"]),
    ] {
        at_key(line, key, &words);
    }
}

/// The only fault of `line`, at its key.
fn at_key(line: &str, key: &str, words: &[&str]) {
    let name = key.split('.').next_back().unwrap_or(key);
    only(line, (1, line.find(name).expect("the line has the key") + 1), key, words);
}

#[test]
fn camera_exposure_and_movement_fit_together() {
    for (line, key, words) in [
        ("motion: {line_rate_hz: 25000}", "motion.line_rate_hz", ["40.0 us", "3 us to be read"]),
        ("camera: {distortion_k1: 0.5, focal_length_mm: 8}", "camera.distortion_k1", ["directions meet", "smaller"]),
        (
            "camera: {scheimpflug: given, focus_distance_mm: 45}",
            "camera.focus_distance_mm",
            ["sharp at 45 mm", "twice"],
        ),
    ] {
        at_key(line, key, &words);
    }
    let good = format!("{GOOD}motion: {{line_rate_hz: 20000}}\nexposure: {{time_us: 46}}\n");
    assert!(Recipe::parse("fast.yaml", &good).is_ok());
    only("motion: {line_rate_hz: -1}", (1, 24), "motion.line_rate_hz", &["0 to 100000 Hz"]);
}
