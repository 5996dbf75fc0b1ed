//! A flat target under the nominal bench: Range is right on average, spreads as noise theory says, dark and bright as set.

use dataset::record::Record;
use procedural::{Gloss, Medium};
use recipe::Scene;
use scanner::optics::{ROWS, Scratch};
use test_support::target::{ceramic, expose, moments, plate, render, scene};

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

/// Without speckle the centre of gravity spreads by sqrt(sum d^2 (read + shot I + row)) / sum I and the rounding.
#[test]
fn range_spreads_as_sensor_noise_says() {
    let mut scene = bright(200);
    scene.bench.speckle.strength = 0.0;
    for time_us in [5.0, 15.0] {
        scene.bench.exposure.time_us = time_us;
        let body = plate(ceramic(), 20.0, 0.0, 0.0);
        let (sensor, band) = expose(&scene, body.clone(), 100..101);
        let mut scratch = Scratch::default();
        sensor.window(&band, 100, 0, &mut scratch);
        let exposure = &scene.bench.exposure;
        let gain = (255.0 - exposure.dark_level_dn) / exposure.full_well_e;
        let light: Vec<f64> = (0..ROWS).map(|k| gain * f64::from(scratch.electrons(k, 0))).collect();
        let peak = (0..ROWS).max_by(|&a, &b| light[a].total_cmp(&light[b])).expect("the window has rows");
        let reach = scene.extraction.window_rows;
        let sum: f64 = light[peak - reach..=peak + reach].iter().sum();
        let centre: f64 = (peak - reach..=peak + reach).map(|k| k as f64 * light[k]).sum::<f64>() / sum;
        // The fixed row pattern moves the whole plate alike and is no spread.
        let still = exposure.dark_noise_dn.powi(2) - exposure.row_pattern_dn.powi(2);
        let noise = |k: usize| (k as f64 - centre).powi(2) * (still + gain * light[k]);
        let variance = (peak - reach..=peak + reach).map(noise).sum::<f64>() / (sum * sum)
            + 1.0 / 12.0 / f64::from(scene.extraction.subpixel_steps).powi(2);
        let rig = sensor.camera().rig;
        let row = rig.centre_row - 90.0;
        let um_per_row = 1000.0 * (rig.height(row) - rig.height(row + 1.0));
        let theory = variance.sqrt() * um_per_row;

        let (_, sd) = moments(errors(&render(&scene, body)).into_iter());
        println!("{time_us} us: spread {sd:.2} um, theory {theory:.2} um");
        // 40960 pixels, of which those of a profile share its row noise: 1 % standard error, three of them.
        assert!((sd / theory - 1.0).abs() < 0.03, "{time_us} us: spread {sd} um, noise theory {theory} um");
    }
}

/// Fully developed speckle on a mirror-like target without sensor noise: sd = C sqrt(sigma Lc / (4 sqrt(pi))).
#[test]
fn range_spreads_as_speckle_says() {
    let mut scene = scene(600);
    let exposure = &mut scene.bench.exposure;
    (exposure.time_us, exposure.shot_noise) = (250.0, 0.0);
    (exposure.dark_noise_dn, exposure.row_noise_dn, exposure.row_pattern_dn) = (0.3, 0.0, 0.0);
    scene.extraction.subpixel_steps = 0;
    let mirror = Medium::opaque(Gloss::wood(1.0));
    let record = render(&scene, plate(mirror, 20.0, 0.0, 0.0));
    let number = |name: &str| record.physics.iter().find(|(n, _)| *n == name).expect(name).1;
    // Correlation length behind a pixel of 6 um, docs/theory/instrument.md: Lc = 1.081 grain for a point, 0.68 um
    // behind 6 um.
    let sigma_um = 6.0 * number("line_sigma_px");
    let theory_px = (sigma_um * 0.68 / (4.0 * std::f64::consts::PI.sqrt())).sqrt() / 6.0;
    let (_, sd) = moments(errors(&record).into_iter());
    let sd_px = sd / 1000.0 / number("height_per_row_mm");
    println!("speckle: {sd_px:.4} px, theory {theory_px:.4} px");
    assert!((sd_px / theory_px - 1.0).abs() < 0.12, "speckle spread {sd_px} px against {theory_px} px");
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

/// A dark sensor: mean, spread, and rows that stand out by as much as the recipe says.
#[test]
fn dark_frames_are_as_configured() {
    let mut scene = scene(30);
    scene.bench.laser.power_mw = 0.01;
    let (sensor, band) = expose(&scene, plate(ceramic(), 20.0, 0.0, 0.0), 0..30);
    let exposure = &scene.bench.exposure;
    let columns = scene.size.columns;
    let frames: Vec<Vec<f64>> =
        (0..30).map(|p| sensor.full_frame(&band, p).into_iter().map(f64::from).collect()).collect();
    let (mean, sd) = moments(frames.iter().flatten().copied());
    // 832 rows of fixed pattern: the mean stands to sd 0.2 / sqrt(832) = 0.007 DN, the spread to 0.3 %.
    assert!((mean - exposure.dark_level_dn).abs() < 0.03, "dark mean {mean}");
    assert!((sd / exposure.dark_noise_dn - 1.0).abs() < 0.015, "dark spread {sd}");
    let rows =
        frames.iter().flat_map(|frame| frame.chunks(columns).map(|row| row.iter().sum::<f64>() / columns as f64));
    let (_, rows_sd) = moments(rows.collect::<Vec<_>>().into_iter());
    let pixel = exposure.dark_noise_dn.powi(2) - exposure.row_noise_dn.powi(2) - exposure.row_pattern_dn.powi(2);
    let theory = (exposure.row_noise_dn.powi(2) + exposure.row_pattern_dn.powi(2) + pixel / columns as f64).sqrt();
    assert!((rows_sd / theory - 1.0).abs() < 0.06, "row spread {rows_sd}, configured {theory}");
}
