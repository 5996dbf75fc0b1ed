//! Sensor rows as heights and on an even grid: tables against the camera, planes, gaps and steps.

use crate::columns::{SENSOR, rig};
use optical_bench::lens::{Distortion, image_distance, scheimpflug};
use scanner::extract::{MeasuredProfile, RectifiedGrid, rectify};
use scanner::frame::{Calibration, Locator, Rig};

/// The default bench and rigs near the ends of what is built, in focus on the laser plane, with and without distortion.
fn rigs() -> Vec<(String, Rig)> {
    let mut rigs = Vec::new();
    for (distance, tilt, focal_length) in
        [(410.0, 25.0f64, 25.0), (250.0, 20.0, 16.0), (300.0, 60.0, 25.0), (1000.0, 40.0, 50.0)]
    {
        for k1 in [0.0, -0.1, 0.05] {
            let tangential = if k1 == 0.0 { [0.0; 2] } else { [5e-4, -5e-4] };
            let rig = Rig {
                distance,
                tilt: tilt.to_radians(),
                focal_length,
                image_distance: image_distance(focal_length, distance),
                sensor_tilt: scheimpflug(focal_length, distance, tilt.to_radians()),
                distortion: Distortion { radial: [k1, 0.5 * k1, 0.0], tangential },
                ..rig(2560)
            };
            rigs.push((format!("{distance} mm, {tilt} deg, {focal_length} mm, k1 {k1}"), rig));
        }
    }
    rigs
}

/// The table of the camera is within 0.1 um of the camera at every place of the sensor.
#[test]
fn locator_is_exact_to_a_tenth_of_a_micrometre() {
    const ROWS: usize = 832;
    for (name, rig) in rigs() {
        let rig = Rig { centre_row: 0.5 * (ROWS as f64 - 1.0), ..rig };
        let back = rig.back_projection();
        let locator = Locator::new(2560, ROWS, |col, row| back.locate(col, row));
        let mut worst = 0.0f64;
        for step in 0..=160 {
            let row = 5.1875 * f64::from(step);
            for first in [0, 700, 1279, 2432] {
                let mut heights = [row as f32; 128];
                let mut alongs = heights;
                locator.heights(first, &mut heights);
                locator.alongs(first, &mut alongs);
                for c in 0..128 {
                    let [x, z] = back.locate((first + c) as f64, row);
                    worst = worst.max((f64::from(alongs[c]) - x).abs()).max((f64::from(heights[c]) - z).abs());
                }
            }
        }
        println!("{name}: {:.4} um", 1000.0 * worst);
        assert!(worst < 1e-4, "{name}: {} um", 1000.0 * worst);
    }
}

/// A profile of heights over the default bench, as sensor rows, with light that tells the columns apart.
fn profile(calibration: &Calibration, surface: impl Fn(f64) -> Option<f64>) -> [Vec<f32>; 3] {
    let columns = 256;
    // The height that a column sees: where the surface meets its line of sight.
    let row = |col: usize| {
        let mut z = 0.0;
        for _ in 0..50 {
            z = surface(calibration.rig.along(col as f64, z))?;
        }
        Some(calibration.rig.project(calibration.rig.along(col as f64, z), 0.0, z).1 as f32)
    };
    let rows: Vec<f32> = (0..columns).map(|col| row(col).unwrap_or(f32::NAN)).collect();
    let light = |scale: f32| -> Vec<f32> {
        rows.iter().enumerate().map(|(c, row)| if row.is_nan() { 0.0 } else { scale * (c as f32 + 1.0) }).collect()
    };
    let lights = [light(0.5), light(10.0)];
    let [reflectance, scatter] = lights;
    [rows, reflectance, scatter]
}

fn rectified(calibration: &Calibration, grid: &RectifiedGrid, mut maps: [Vec<f32>; 3]) -> [Vec<f32>; 3] {
    let [range, reflectance, scatter] = &mut maps;
    rectify(calibration, grid, MeasuredProfile { range, reflectance, scatter });
    maps
}

/// A plane that rises along the line comes out as itself at every place of the grid, whatever its pitch; light between
/// two columns is what lies between theirs; what is missing leaves a gap of its own width.
#[test]
fn planes_and_gaps_are_resampled() {
    let calibration = Calibration::new(rig(256), [256, SENSOR], 0.0);
    for pitch_mm in [None, Some(0.05), Some(0.2)] {
        let grid = RectifiedGrid::new(&calibration.rig, 256, pitch_mm);
        let plane = |x: f64| 3.0 + 0.2 * x;
        let hole = |x: f64| (!(2.0..=3.0).contains(&x)).then(|| plane(x));
        let [range, reflectance, scatter] = rectified(&calibration, &grid, profile(&calibration, hole));
        let ends = [0.0, 255.0].map(|col| calibration.rig.along(col, if col == 0.0 { 0.6 } else { 5.4 }));
        for (j, z) in range.iter().enumerate() {
            let x = grid.first_mm + j as f64 * grid.pitch_mm;
            let col = calibration.rig.project(x, 0.0, plane(x)).0;
            let inside = x > ends[0] + 0.1 && x < ends[1] - 0.1 && !(1.9..3.1).contains(&x);
            let outside = x < ends[0] - 0.1 || x > ends[1] + 0.1 || (2.1..2.9).contains(&x);
            assert!(!inside || (f64::from(*z) - plane(x)).abs() < 5e-4, "{x}: {z}, not {}", plane(x));
            assert!(!outside || z.is_nan(), "{x}: {z}");
            assert_eq!(z.is_nan(), reflectance[j] == 0.0 && scatter[j] == 0.0);
            assert!(!inside || (f64::from(reflectance[j]) - 0.5 * (col + 1.0)).abs() < 0.01, "{x}: {}", reflectance[j]);
            assert!(!inside || (f64::from(scatter[j]) - 10.0 * (col + 1.0)).abs() < 0.1);
        }
    }
}

/// A step of 2 mm has no height between its two levels, and its edges stand where they are within a column.
#[test]
fn edges_stay_sharp_and_in_place() {
    let calibration = Calibration::new(rig(256), [256, SENSOR], 0.0);
    let grid = RectifiedGrid::new(&calibration.rig, 256, None);
    let step = |x: f64| Some(if (-4.0..4.0).contains(&x) { 3.0 } else { 1.0 });
    let [range, ..] = rectified(&calibration, &grid, profile(&calibration, step));
    for (j, z) in range.iter().enumerate().filter(|(_, z)| z.is_finite()) {
        let x = grid.first_mm + j as f64 * grid.pitch_mm;
        let near = (x.abs() - 4.0).abs() < 1.1 * grid.pitch_mm;
        let level = if x.abs() < 4.0 { 3.0 } else { 1.0 };
        assert!([1.0, 3.0].iter().any(|level| (z - level).abs() < 1e-3), "{x}: {z}");
        assert!(near || (z - level).abs() < 1e-3, "{x}: {z}");
    }
    assert!(range.iter().filter(|z| z.is_nan()).count() < 12);
}
