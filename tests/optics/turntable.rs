//! An object on a turntable: slopes, heights, shadows, areas and speckle of the turned body.

use base::{Body, Gloss, Medium, Mesh};
use glam::Vec3;
use optical_bench::settings::Movement;
use pipeline::set_up;
use procedural::flat::Flat;
use procedural::solid::{Material, Part, Piece, Placing, Sawtooth};
use recipe::Scene;
use scanner::frame::Frame;
use scanner::optics::{Scratch, TileOfProfile};
use scanner::specimen::Hit;
use test_support::target::{ceramic, moments, patterns, plate, render, scene};

/// A turntable whose profiles are `step` apart at `radius` [mm].
fn table(profiles: usize, axis: [f64; 2], radius: f64, step: f64) -> Scene {
    let mut scene = scene(profiles);
    scene.movement = Movement::Turntable;
    let motion = &mut scene.bench.motion;
    (motion.turn_axis_x_mm, motion.turn_axis_y_mm) = (axis[0], axis[1]);
    (motion.turn_radius_mm, motion.step_mm) = (radius, step);
    scene
}

fn block(size_mm: f32, height_mm: f32, slope_x: f32) -> Body {
    let medium = Medium::opaque(Gloss::wood(1.0));
    Body::new(Flat { height_mm, slope_x, slope_y: 0.0, width_mm: size_mm, length_mm: size_mm, medium })
}

/// What the columns see in profile `profile`.
fn hits(scene: &Scene, body: Body, profile: usize) -> Vec<Hit> {
    let (sensor, specimen) = set_up(scene, body, patterns());
    sensor.band(&specimen, profile..profile + 1).line(profile).hits.clone()
}

/// A slope along x becomes one along the motion after a quarter turn, and heights are those of the turned place.
#[test]
fn slopes_turn_with_the_body() {
    let quarter = std::f64::consts::FRAC_PI_2;
    let scene = table(4, [0.0, 30.0], 1.0, quarter);
    for (profile, slope) in [(0, [0.1, 0.0]), (1, [0.0, 0.1]), (2, [-0.1, 0.0]), (3, [0.0, -0.1])] {
        let hit = hits(&scene, block(60.0, 5.0, 0.1), profile)[200];
        let found = [hit.surface.slope_x, hit.surface.slope_y];
        assert!(found.iter().zip(slope).all(|(a, b)| (a - b).abs() < 1e-5), "profile {profile}: {found:?}");
        let height = 5.0 + hit.x * slope[0];
        assert!((hit.surface.z - height).abs() < 5e-3, "profile {profile}: {} for {height}", hit.surface.z);
    }
}

/// A block throws its shadow away from the lens, whichever way it stands: 4.7 mm of table behind a block of 10 mm.
#[test]
fn shadows_turn_with_the_body() {
    let hidden = |axis_y: f64, profile: usize| {
        let scene = table(2, [0.0, axis_y], 1.0, std::f64::consts::PI);
        hits(&scene, block(8.0, 10.0, 0.0), profile).iter().filter(|hit| !hit.seen).count()
    };
    assert!(hidden(10.0, 0) > 60, "{} columns hidden 2 mm behind the block", hidden(10.0, 0));
    assert_eq!(hidden(-2.0, 0), 0, "before the block nothing is hidden");
    assert_eq!(hidden(10.0, 1), 0, "half a turn later the line passes before it");
    assert!(hidden(-2.0, 1) > 60, "and here behind it");
}

/// Range of a whole turn of a tilted plate is the tilted plate, a cosine of the angle in each column.
#[test]
fn a_turned_plate_is_measured_where_it_is() {
    let profiles = 120;
    let radius = 10.0;
    let mut scene = table(profiles, [0.0, 100.0], radius, radius * std::f64::consts::TAU / profiles as f64);
    scene.bench.exposure.time_us = 22.0;
    scene.bench.speckle.strength = 0.0;
    let record = render(&scene, plate(ceramic(), 8.0, 0.05, 0.0));
    let truth = &record.truth.as_ref().expect("the recipe keeps truth maps").height;
    let column = 230;
    for profile in 0..profiles {
        let at = profile * record.cols + column;
        let angle = std::f64::consts::TAU * profile as f64 / profiles as f64;
        let x = (230.0 - 127.5) * 0.0905;
        let height = 8.0 + 0.05 * x * angle.cos();
        assert!((f64::from(truth[at]) - height).abs() < 0.02, "profile {profile}: {} for {height}", truth[at]);
    }
    let (mean, sd) = moments(record.maps.range.iter().zip(truth).map(|(z, t)| 1000.0 * f64::from(z - t)));
    assert!(mean.abs() < 8.0 && sd < 30.0, "Range is {mean} um off, spread {sd} um");
}

/// Range of a body that has turned on the table by an angle is that of the body laid down turned by it.
fn turned_as_laid(body: &dyn Fn(f64) -> Body) {
    let radius = 10.0;
    // Profile 1 has turned by the whole angle.
    let scene = |start: f64| {
        let mut scene = table(2, [0.0, 20.0], radius, start);
        scene.bench.speckle.strength = 0.0;
        scene
    };
    // At 90 degrees the line runs along a valley, exactly.
    for degrees in [90.0, 37.0, -60.0f64] {
        let record = render(&scene(radius * degrees.to_radians().rem_euclid(std::f64::consts::TAU)), body(0.0));
        let laid = render(&scene(1.0), body(degrees));
        let cols = record.cols;
        let mut errors = Vec::new();
        for (turned, laid) in record.maps.range[cols..2 * cols].iter().zip(&laid.maps.range[..cols]) {
            if turned.is_finite() && laid.is_finite() {
                errors.push(1000.0 * f64::from(turned - laid));
            }
        }
        errors.sort_by(f64::total_cmp);
        // Steps may fall into the next column, and noise rounds to 1/16 of a row, 14 um.
        let (median, most) = (errors[errors.len() / 2], errors[errors.len() * 9 / 10] - errors[errors.len() / 10]);
        assert!(errors.len() > 150, "{degrees} deg: {} columns", errors.len());
        assert!(median.abs() < 8.0 && most < 60.0, "{degrees} deg: {median} um apart, spread {most} um");
    }
}

/// A saw-tooth that has turned is measured as one that was laid down turned.
#[test]
fn a_turned_saw_tooth_is_measured_where_it_is() {
    turned_as_laid(&|degrees| {
        let sizes = Piece { length_mm: 40.0, teeth: 4.0, depth_mm: 3.0, width_mm: 40.0, base_mm: 5.0, ..piece() };
        // The middle of the piece stays on the axis: the room that it takes along the scan grows as it turns.
        let (sin, cos) = libm::sincos(degrees.to_radians());
        let lead_in_mm = 20.0 - 20.0 * (sin.abs() + cos.abs());
        let piece = Piece { turn_deg: degrees, lead_in_mm, ..sizes };
        Body::new(Sawtooth::new(&piece, &material()))
    });
}

/// A wedge from a file of triangles that has turned is measured as one that was laid down turned.
#[test]
fn a_turned_part_is_measured_where_it_is() {
    turned_as_laid(&|degrees| {
        // 36 by 36 mm, 5 mm high on one side, 11 mm on the other.
        let corner = |i: u32| {
            let (x, y) = ((i & 1) as f32, (i >> 1 & 1) as f32);
            Vec3::new(36.0 * x, 36.0 * y, (i >> 2) as f32 * (5.0 + 6.0 * x))
        };
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        let mesh = Mesh { positions: (0..8).map(corner).collect(), triangles };
        let (sin, cos) = libm::sincos(degrees.to_radians());
        let lead_in_mm = 20.0 - 18.0 * (sin.abs() + cos.abs());
        let placing = Placing { rotate_z_deg: degrees, lead_in_mm, ..Placing::from_values(&mut |p| p.default) };
        Body::new(Part::new(&mesh, &placing, &material()))
    });
}

fn piece() -> Piece {
    Piece::from_values(&mut |p| p.default)
}

/// Metal that throws half of the light back evenly.
fn material() -> Material {
    Material { gloss: 0.0, matte: 0.5, ..Material::from_values(&mut |p| p.default) }
}

/// Speckle turns too: at twice the distance it moves twice as fast, and the other way on the other side.
#[test]
fn speckle_moves_as_fast_as_the_table_does() {
    let mut scene = table(64, [0.0, 100.0], 10.0, 0.068);
    scene.size.columns = 640;
    let exposure = &mut scene.bench.exposure;
    (exposure.shot_noise, exposure.dark_noise_dn, exposure.row_noise_dn, exposure.row_pattern_dn) =
        (0.0, 0.3, 0.0, 0.0);
    exposure.time_us = 200.0;
    scene.bench.laser.waist_mm = 2.0;
    let (sensor, specimen) = set_up(&scene, plate(Medium::opaque(Gloss::wood(1.0)), 20.0, 0.0, 0.0), patterns());
    let band = sensor.band(&specimen, 0..64);
    let (mut scratch, mut offsets) = (Scratch::default(), Vec::new());
    let mut frame = |profile: usize, tile: usize| -> Frame {
        let mut frames = <[Frame; 2]>::default();
        sensor.row_offsets(profile, &mut offsets);
        sensor.expose(&TileOfProfile { band: &band, profile, tile, offsets: &offsets }, &mut scratch, &mut frames);
        let [frame, _] = frames;
        frame
    };
    // Middle of tile t at (128 t + 64 - 319.5) 0.0877 mm. A point of the object at x lies at y = x sin(way / radius)
    // after the way, and rows fall with y: 0.70 rows a profile at 10 mm, towards smaller rows on the right.
    for tile in [0, 1, 3, 4] {
        let x = (128.0 * tile as f64 + 64.0 - 319.5) * 0.0877;
        let (apart, expected) = (3, -3.0 * 0.70 * x / 10.0);
        let shades: Vec<Vec<f64>> = (0..64).map(|profile| shades(&frame(profile, tile))).collect();
        let alike = |lag: i64| -> f64 {
            let pairs = shades.iter().zip(&shades[apart..]);
            let row = |k: i64| k as usize * 128..(k as usize + 1) * 128;
            let product = |(a, b): (&Vec<f64>, &Vec<f64>)| {
                (17..28).map(|k| a[row(k)].iter().zip(&b[row(k + lag)]).map(|(a, b)| a * b).sum::<f64>()).sum::<f64>()
            };
            pairs.map(product).sum()
        };
        let best = (-8..=8).max_by(|a, b| alike(*a).total_cmp(&alike(*b))).map_or(0.0, |lag| lag as f64);
        assert!((best - expected).abs() < 1.0, "tile {tile}: moved {best} rows for {expected}");
    }
}

/// Light of each pixel over its row's mean, less 1.
fn shades(frame: &Frame) -> Vec<f64> {
    let row = |row: &[u16]| {
        let light = |dn: u16| f64::from(dn) - 11.6;
        let mean = row.iter().map(|dn| light(*dn)).sum::<f64>() / row.len() as f64;
        row.iter().map(|dn| light(*dn) / mean - 1.0).collect::<Vec<_>>()
    };
    frame.dn.chunks_exact(frame.cols).flat_map(row).collect()
}
