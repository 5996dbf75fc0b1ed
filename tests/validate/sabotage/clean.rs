//! Datasets of every subject, depth, form and choice of files as the program makes them have no fault.

use super::place::{ESTIMATES, inspect, inspect_rows};
use dataset::validate::{Code, ValidationOptions, validate};
use rand::RngExt;
use recipe::Recipe;
use test_support::program::{FRAMES, Place, SPECKLE, mesh_recipe, recipe, sawtooth_recipe};

/// Choices of rows that are exposed again.
const SEEDS: u64 = 2;

/// Makes a dataset of a recipe, which must be clean.
fn is_clean(name: &str, text: String, samples: u64) {
    let place = Place::new();
    place.write("tiny.yaml", text);
    place.make("set", &format!("--n {samples} --samples-per-shard 5"));
    for report in inspect_rows(&place.path("set"), 0..SEEDS) {
        assert!(report.is_clean() && report.samples == samples, "{name}:\n{report}");
        assert!(report.rows >= samples && report.unexposed == 0, "{name}:\n{report}");
    }
}

/// Every distribution becomes its lower end.
fn fixed(mut text: String) -> String {
    for words in ["{uniform: [", "{log_uniform: ["] {
        while let Some(at) = text.find(words) {
            let rest = &text[at + words.len()..];
            let (lower, end) = (rest.split(',').next().unwrap_or_default(), rest.find("]}").expect("an end") + 2);
            text = format!("{}{lower}{}", &text[..at], &rest[end..]);
        }
    }
    text
}

#[test]
#[ignore = "long"]
fn clean_datasets_of_every_subject() {
    for place in Place::of_each_subject(&[FRAMES, SPECKLE]) {
        place.make("set", "--n 8 --samples-per-shard 3");
        let profiles = place.json("set/dataset.json")["images"]["rows"].as_u64().expect("a number");
        for report in inspect_rows(&place.path("set"), 0..SEEDS) {
            assert!(report.is_clean() && report.samples == 8, "{report}");
            // A row for each sample and up to seven neighbours, and every frame.
            assert!((8..=8 * 8).contains(&report.rows) && report.frames == 8 * profiles.div_ceil(16), "{report}");
        }
    }
}

#[test]
#[ignore = "long"]
fn clean_datasets_of_other_files_and_forms() {
    let png = "png: [range, reflectance, scatter, label]";
    let exr = "exr: [range, reflectance, scatter, label, instance]";
    let window = "\n  window_rows: 7";
    let cases: [(&str, &[[&str; 2]]); 12] = [
        ("EXR files alone", &[[png, "png: []"]]),
        ("PNG files alone", &[[exr, "exr: []"], ["truth_maps: true", "truth_maps: false"]]),
        ("Range alone", &[[png, "png: [range]"], [exr, "exr: []"], ["truth_maps: true", "truth_maps: false"]]),
        ("no truth maps", &[["truth_maps: true", "truth_maps: false"]]),
        ("every frame", &[["sensor_stack: none", "sensor_stack: all"]]),
        ("binned", &[["bin: {columns: 1, profiles: 1}", "bin: {columns: 2, profiles: 3}"]]),
        ("10 bits", &[["\nexposure:", "\nexposure:\n  bits: 10"], FRAMES]),
        ("12 bits", &[["\nexposure:", "\nexposure:\n  bits: 12"]]),
        ("sensor rows", &[[window, "\n  range: uncalibrated\n  window_rows: 7"]]),
        ("an even grid", &[[window, "\n  range: rectified\n  window_rows: 7"]]),
        ("one pixel", &[["\n  columns: 64 ", "\n  columns: 8 "], ["\n  profiles: 48 ", "\n  profiles: 1 "]]),
        ("half the light", &[["power_mw: 50", "power_mw: 25"]]),
    ];
    for (name, changes) in cases {
        is_clean(name, changed(recipe(&[]), changes), 6);
    }
    is_clean(
        "a turntable",
        changed(mesh_recipe(&[]), &[["\nlaser:", "\nmotion: {kind: turntable, turn_radius_mm: 8}\n\nlaser:"]]),
        4,
    );
}

/// Pieces of a recipe whose numbers are all fixed differ in their noise alone, and are no copies: those are looked for
/// where no row is exposed again.
#[test]
fn pieces_that_look_alike_are_no_copies() {
    let place = Place::new();
    place.write("tiny.yaml", fixed(sawtooth_recipe(&[])));
    place.make("set", "--n 40");
    let report = inspect(&place.path("set"));
    let is_told = report.warnings.iter().any(|found| ESTIMATES.contains(&found.code));
    assert!(report.is_clean() && !is_told && report.samples == 40, "{report}");
}

/// The orders of the thesis, without speckle and noise of this program's own.
#[test]
#[ignore = "long"]
fn clean_datasets_of_the_thesis() {
    for (name, text) in [
        ("wood", include_str!("../../../recipes/thesis/wood.yaml")),
        ("sawtooth", include_str!("../../../recipes/thesis/sawtooth.yaml")),
        ("blister", include_str!("../../../recipes/thesis/blister.yaml")),
    ] {
        let start = text.find("profiles: ").expect("a number of profiles");
        let end = start + text[start..].find('}').expect("its end");
        let text = format!("{}profiles: 24{}", &text[..start], &text[end..]);
        is_clean(name, text.replacen("columns: 2560", "columns: 96", 1), 5);
    }
}

/// Every recipe that ships, cut to a small size, with some frames.
#[test]
#[ignore = "long"]
fn clean_datasets_of_every_recipe() {
    for name in Recipe::embedded().map(|built_in| built_in.name) {
        // Whole frames go through the scripts of the thesis.
        let [columns, profiles] = if name.contains("thesis") { [96, 16] } else { [192, 80] };
        let place = Place::new();
        let size = format!("--set scan.columns={columns} --set scan.profiles={profiles}");
        let frames = "--set output.sensor_stack={\"every\":20}";
        place.done(&format!("--recipe {name} {size} {frames} --out set --n 1"));
        for report in inspect_rows(&place.path("set"), 0..1) {
            assert!(report.is_clean() && report.unexposed == 0, "{name}:\n{report}");
            assert_eq!((report.samples, report.frames), (1, u64::div_ceil(profiles, 20)), "{name}:\n{report}");
        }
    }
}

/// Where hardly any light comes and the dark level is 0, sensor frames of nothing are what the recipe makes: exposed
/// again they are blank too, and where they cannot be they are looked at.
#[test]
fn clean_datasets_of_the_dark() {
    let dark = [
        FRAMES,
        ["power_mw: 50", "power_mw: 0.01"],
        ["dark_level_dn: {truncated: {of: {normal: {mean: 11.6, sd: 0.6}}, min: 9, max: 14}}", "dark_level_dn: 0"],
        ["dark_noise_dn: {uniform: [1.0, 1.2]}", "dark_noise_dn: 0.3"],
        ["row_noise_dn: {uniform: [0.15, 0.45]}", "row_noise_dn: 0"],
        ["row_pattern_dn: {uniform: [0.1, 0.3]}", "row_pattern_dn: 0"],
        ["column_pattern_dn: 0.1", "column_pattern_dn: 0"],
        ["dsnu_dn: {uniform: [0.2, 0.3]}", "dsnu_dn: 0"],
    ];
    let place = Place::with(&dark);
    place.make("set", "--n 3");
    let report = inspect(&place.path("set"));
    assert!(report.is_clean(), "{report}");
    let report = validate(&place.path("set"), &ValidationOptions::default());
    let blank = report.warnings.iter().filter(|found| found.code == Code::StackBlank).count();
    assert!(report.is_clean() && blank > 0, "{blank} blank frames:\n{report}");
}

/// Overexposed packs: heights of saturated pixels at the card's edge lie as far off as the card is thick, and are no
/// fault of the label's.
#[test]
#[ignore = "long"]
fn clean_datasets_of_overexposed_packs() {
    let mut rng = base::Stream::root(400).rng();
    for files in [
        "",
        "--set output.bin={\"columns\":2,\"profiles\":2}",
        "--set output.png=[\"range\",\"label\"] --set output.exr=[]",
    ] {
        let time_us = 200.0 * 5.0_f64.powf(rng.random());
        let place = Place::new();
        place.done(&format!(
            "--recipe blister-small --seed 3 --n 5 --out set --set exposure.time_us={time_us:.0} \
             --set output.truth_maps=false {files}"
        ));
        let report = &inspect_rows(&place.path("set"), 0..1)[0];
        assert!(report.faults.is_empty() && report.samples == 5, "{time_us} us {files}:\n{report}");
    }
}

fn changed(text: String, changes: &[[&str; 2]]) -> String {
    changes.iter().fold(text, |text, [old, new]| {
        assert_eq!(text.matches(old).count(), 1, "`{old}` is not once in the recipe");
        text.replacen(old, new, 1)
    })
}
