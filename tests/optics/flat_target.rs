//! A flat target under the nominal bench: Range is right on average, Reflectance linear up to saturation. How far Range
//! spreads, and what dark frames hold, are figures of `gen study` (crates/evidence/study/tests/figures.rs).

use dataset::record::Record;
use recipe::Scene;
use test_support::target::{ceramic, moments, plate, render, scene};

const TILTS: [(f32, f32); 3] = [(0.0, 0.0), (0.08, 0.0), (0.0, 0.05)];
/// Profiles at either end of the plate whose light reaches its edge.
const EDGE: usize = 40;

/// Measured less true height away from the plate's edges [um].
fn errors(record: &Record) -> Vec<f64> {
    let truth = record.truth.as_ref().expect("the recipe keeps truth maps");
    let inner = EDGE * record.cols..record.maps.range.len();
    let pairs = record.maps.range[inner.clone()].iter().zip(&truth.height[inner]);
    pairs.map(|(z, h)| 1000.0 * f64::from(z - h)).collect()
}

/// Exposure that brings the ceramic to about 200 DN.
fn bright(profiles: usize) -> Scene {
    let mut scene = scene(profiles);
    scene.bench.exposure.time_us = 22.0;
    scene
}

/// What error is left comes from the fixed pattern of the rows, which all pixels of a level plate share: without it the
/// greatest of the 30 is 0.5 um.
#[test]
fn range_is_right_at_ten_heights_and_three_tilts() {
    let scene = bright(120);
    for (slope_x, slope_y) in TILTS {
        for step in 0..10 {
            let height = 2.0 + 5.37 * step as f32;
            let record = render(&scene, plate(ceramic(), height, slope_x, slope_y));
            let (bright, _) = moments(record.maps.reflectance[EDGE * record.cols..].iter().map(|&v| f64::from(v)));
            let errors = errors(&record);
            assert!(errors.iter().all(|e| e.is_finite()), "missing pixels on a flat plate at {height}");
            let (mean, sd) = moments(errors.iter().copied());
            println!(
                "DN {:.0} height {height} tilt {slope_x} {slope_y}: {mean:.2} um mean error, {sd:.1} um spread",
                bright
            );
            assert!(mean.abs() < 5.0, "height {height}, tilt {slope_x} {slope_y}: mean error {mean} um");
        }
    }
}

/// Reflectance follows the exposure time in a straight line from the dark level, and stops at 255.
#[test]
fn reflectance_is_linear_to_saturation() {
    let mut scene = scene(80);
    let exposure = &mut scene.bench.exposure;
    exposure.shot_noise = 0.0;
    (exposure.dark_noise_dn, exposure.row_noise_dn, exposure.row_pattern_dn) = (0.3, 0.0, 0.0);
    scene.bench.speckle.strength = 0.0;
    let read = |time_us: f64| {
        let mut scene = scene.clone();
        scene.bench.exposure.time_us = time_us;
        let record = render(&scene, plate(ceramic(), 20.0, 0.0, 0.0));
        moments(record.maps.reflectance[EDGE * record.cols..].iter().map(|&v| f64::from(v))).0
    };
    let dark = scene.bench.exposure.dark_level_dn;
    let slope = (read(12.0) - dark) / 12.0;
    for time_us in [3.0, 6.0, 9.0] {
        let (got, line) = (read(time_us), dark + slope * time_us);
        assert!((got - line).abs() < 0.5, "{time_us} us: {got} DN, on the line {line} DN");
    }
    assert!((read(60.0) - 255.0).abs() < 1e-9, "an overexposed target is not saturated");
}
