//! The camera's effects measured on the light of production's exposure, against closed forms.

use base::{Body, Gloss, Medium};
use optical_bench::settings::{Filter, LensModel, Scheimpflug};
use procedural::flat::Flat;
use recipe::Scene;
use scanner::optics::{Band, ROWS, Scratch, Sensor, TILE};
use test_support::target::{ceramic, expose, moments, plate, render, scene};

/// A grey plate whose light comes back from where it hits.
fn grey() -> Medium {
    Medium::opaque(Gloss { matte: 0.5, ..Gloss::NONE })
}

/// Light, middle and variance along the rows of each column of a profile [e-], [px], [px^2].
fn lines(sensor: &Sensor, band: &Band, profile: usize, columns: usize) -> Vec<[f64; 3]> {
    let mut scratch = Scratch::default();
    let mut found = Vec::new();
    for column in 0..columns {
        if column.is_multiple_of(TILE) {
            sensor.window(band, profile, column / TILE, &mut scratch);
        }
        let c = column % TILE;
        let mut sums = [0.0f64; 3];
        for k in 0..ROWS {
            let (light, row) =
                (f64::from(scratch.electrons(k, c)), f64::from(scratch.windows[0].first_row[c]) + k as f64);
            sums.iter_mut().zip([1.0, row, row * row]).for_each(|(sum, power)| *sum += light * power);
        }
        let [light, row, row2] = sums;
        found.push([light, row / light, row2 / light - (row / light).powi(2)]);
    }
    found
}

/// The line of one scene in its middle column.
fn middle(scene: &Scene, body: Body) -> [f64; 3] {
    let (sensor, band) = expose(scene, body, 100..101);
    lines(&sensor, &band, 100, scene.size.columns)[scene.size.columns / 2]
}

/// Without Scheimpflug the line is wider by c^2 / 16 with the published discs c; a pinhole is sharp; and along the line
/// the fan's end is softened by as much.
#[test]
fn discs_out_of_focus_widen_the_line() {
    let sharp = scene(1);
    let mut level = sharp.clone();
    level.bench.optics.scheimpflug = Scheimpflug::Given;
    let mut hole = level.clone();
    hole.bench.optics.lens = LensModel::Pinhole;
    for (z, disc_um) in [(5.0, 6.5), (10.0, 13.1), (20.0, 26.8)] {
        let [_, _, pinhole] = middle(&hole, plate(grey(), z, 0.0, 0.0));
        let [_, _, wide] = middle(&level, plate(grey(), z, 0.0, 0.0));
        let theory = (disc_um / 6.0f64).powi(2) / 16.0;
        println!("{z} mm: {:.4} px^2 more, theory {theory:.4}", wide - pinhole);
        // The disc is known to 0.05 um.
        assert!((wide - pinhole - theory).abs() < 0.02 * theory + 0.003, "{z} mm: {wide} - {pinhole} px^2, {theory}");
        let [_, _, solved] = middle(&sharp, plate(grey(), z, 0.0, 0.0));
        assert!((pinhole / solved - 1.0).abs() < 0.05, "the tilt changes the scale alone: {pinhole} {solved}");
    }
    // A fan that ends inside the field, seen far out of focus.
    level.bench.camera.focus_distance_mm = 330.0;
    level.bench.laser.fan_angle_deg = 2.6;
    let softness = |scene: &Scene| {
        let (sensor, band) = expose(scene, plate(grey(), 20.0, 0.0, 0.0), 100..101);
        let light: Vec<f64> = lines(&sensor, &band, 100, 256)[140..].iter().map(|line| line[0]).collect();
        let fall: Vec<f64> = light.windows(2).map(|pair| pair[0] - pair[1]).collect();
        let [sum, place, place2] = fall
            .iter()
            .enumerate()
            .fold([0.0; 3], |[s, p, q], (i, f)| [s + f, p + f * i as f64, q + f * (i * i) as f64]);
        (place2 / sum - (place / sum).powi(2), f64::from(sensor.camera().circle_of_confusion(0.0, 20.0)) / 0.006)
    };
    let mut hole = level.clone();
    hole.bench.optics.lens = LensModel::Pinhole;
    let ((soft, disc), (plain, _)) = (softness(&level), softness(&hole));
    println!("disc {disc:.2} px: the fan's end has {soft:.2} px^2, {plain:.2} through a pinhole");
    assert!(((soft - plain) / (disc * disc / 16.0) - 1.0).abs() < 0.03, "{soft} - {plain} px^2, disc {disc} px");
}

/// The line's shape is the semicircle of the disc's projection, smoothed by the rest: slightly and far out of focus.
#[test]
fn lines_out_of_focus_have_the_shape_of_discs() {
    let mut level = scene(1);
    level.bench.optics.scheimpflug = Scheimpflug::Given;
    for (focus_mm, radius_px) in [(410.0, 2.2..2.3), (380.0, 1.4..1.6), (340.0, 6.0..9.0)] {
        level.bench.camera.focus_distance_mm = focus_mm;
        let mut hole = level.clone();
        hole.bench.optics.lens = LensModel::Pinhole;
        let body = || plate(grey(), 20.0, 0.0, 0.0);
        let [light, centre, rest] = middle(&hole, body());
        let (sensor, band) = expose(&level, body(), 100..101);
        let line = band.line(100);
        let radius = f64::from(line.defocus_radius[128]);
        assert!(radius_px.contains(&radius), "sharp at {focus_mm} mm: a disc of {radius} px");
        let mut scratch = Scratch::default();
        sensor.window(&band, 100, 1, &mut scratch);
        let shape = |row: f64| {
            let steps = 4000;
            let sum = (0..steps).map(|i| {
                let t = (f64::from(i) + 0.5) / f64::from(steps) * 2.0 - 1.0;
                let off = row - centre - radius * t;
                (1.0 - t * t).sqrt() * (-0.5 * off * off / rest).exp()
            });
            light * 4.0 / std::f64::consts::PI / f64::from(steps) * sum.sum::<f64>()
                / (2.0 * std::f64::consts::PI * rest).sqrt()
        };
        let peak = shape(centre);
        let worst = (0..ROWS).map(|k| {
            let row = f64::from(scratch.windows[0].first_row[0]) + k as f64;
            (f64::from(scratch.electrons(k, 0)) - shape(row)).abs() / peak
        });
        let worst = worst.fold(0.0, f64::max);
        println!("disc of {radius:.2} px: off by {worst:.4} of the peak");
        assert!(worst < 0.01, "disc of {radius} px: off by {worst} of the peak");
    }
}

/// Aberrations, Airy's core and crosstalk add their variances; diffraction goes by wavelength and working f-number.
#[test]
fn blurs_of_lens_and_pixel_add_up() {
    let variance = |change: &dyn Fn(&mut Scene)| {
        let mut scene = scene(1);
        change(&mut scene);
        middle(&scene, plate(grey(), 20.0, 0.0, 0.0))[2]
    };
    let plain = variance(&|s| s.bench.optics.diffraction = false);
    let airy = |f_number: f64| (0.42 * 0.66 * f_number * 410.0 / 385.0 / 6.0f64).powi(2);
    for f_number in [2.8, 8.0, 16.0] {
        let own = variance(&|s| s.bench.camera.f_number = f_number) - plain;
        assert!((own / airy(f_number) - 1.0).abs() < 0.01, "f/{f_number}: {own} px^2, theory {}", airy(f_number));
    }
    let spilt = variance(&|s| (s.bench.camera.crosstalk, s.bench.optics.diffraction) = (0.02, false)) - plain;
    assert!((spilt - 0.04).abs() < 4e-4, "crosstalk adds {spilt} px^2");
}

/// A bent lens moves Range by mm at the field's edge; read with its calibration Range is right to 5 um everywhere.
#[test]
fn range_behind_a_bent_lens_is_right() {
    let mut scene = scene(60);
    scene.size.columns = 2560;
    let camera = &mut scene.bench.camera;
    (camera.distortion_k1, camera.distortion_k2) = (-0.06, 0.05);
    (camera.distortion_p1, camera.distortion_p2) = (5e-4, -5e-4);
    (scene.bench.exposure.time_us, scene.bench.exposure.row_pattern_dn) = (30.0, 0.0);
    (scene.bench.laser.fan_height_mm, scene.bench.laser.fan_angle_deg) = (600.0, 30.0);
    for (slope_x, slope_y) in [(0.0, 0.0), (0.1, 0.05)] {
        let record = render(&scene, plate(ceramic(), 20.0, slope_x, slope_y));
        let truth = record.truth.as_ref().expect("the recipe keeps truth maps");
        for block in (0..2560).step_by(320) {
            let pixels = (40..60).flat_map(|row| (block..block + 320).map(move |col| row * 2560 + col));
            let errors = pixels.map(|i| 1000.0 * f64::from(record.maps.range[i] - truth.height[i]));
            let (mean, sd) = moments(errors);
            // Of 6400 pixels.
            println!("slopes {slope_x} {slope_y}, columns {block}: {mean:.2} um, spread {sd:.1} um");
            assert!(mean.abs() < 5.0, "columns from {block}: mean error {mean} um");
        }
    }
    // The same places of the sensor, read as if the lens were straight.
    let rig = scanner::optics::camera::rig(&scene.bench, &scene.size);
    let straight = scanner::frame::Rig { distortion: Default::default(), ..rig };
    let (col, row) = rig.project(100.0, 0.0, 20.0);
    let [x, z] = straight.locate(col, row);
    assert!((x - 100.0).abs() > 0.2 && (z - 20.0).abs() > 0.04, "read straight: {x} {z}");
}

/// The sensor's region moved against the axis shows the line elsewhere and measures the same.
#[test]
fn a_region_elsewhere_reads_the_same() {
    let plain = scene(1);
    let mut moved = plain.clone();
    (moved.bench.optics.offset_rows, moved.bench.optics.offset_columns) = (-100.0, 64.0);
    let body = || plate(grey(), 20.0, 0.0, 0.0);
    let ([_, row, _], [_, other, _]) = (middle(&plain, body()), middle(&moved, body()));
    assert!((other - row - 100.0).abs() < 1e-3, "the line stands in row {row} and {other}");
    let rigs = [&plain, &moved].map(|s| scanner::optics::camera::rig(&s.bench, &s.size));
    assert!((rigs[0].height(row) - rigs[1].height(other)).abs() < 1e-3);
    let x = rigs.map(|rig| rig.locate(100.0, row)[0]);
    assert!((rigs[0].along(164.0, 20.0) - rigs[1].along(100.0, 20.0)).abs() < 1e-9, "{x:?}");
}

/// Light of each column against the same without filter and mounts: the band's edge shifted by the angle, the laser's
/// line folded in; and the square law of mounts.
#[test]
fn filter_and_mounts_dim_the_field() {
    let mut plain = scene(1);
    plain.size.columns = 2560;
    let mut dim = plain.clone();
    dim.bench.optics.filter = Filter::BandPass;
    // The band reaches from 642 to 662 nm.
    let camera = &mut dim.bench.camera;
    (camera.filter_centre_nm, camera.filter_width_nm, camera.vignetting) = (652.0, 20.0, 0.3);
    let light = |scene: &Scene| {
        let (sensor, band) = expose(scene, plate(grey(), 0.1, 0.0, 0.0), 100..101);
        lines(&sensor, &band, 100, 2560)
    };
    let (plain_light, dim_light) = (light(&plain), light(&dim));
    let rig = scanner::optics::camera::rig(&plain.bench, &plain.size);
    for column in [60, 400, 900, 1280, 2500] {
        let passed = dim_light[column][0] / plain_light[column][0];
        let x = rig.along(column as f64, 0.1);
        let (yc, zc) = (0.1 * rig.tilt.sin(), rig.distance - 0.1 * rig.tilt.cos());
        let tangent2 = (x * x + yc * yc) / (zc * zc);
        let sin2 = tangent2 / (1.0 + tangent2);
        let nm = 660.0 / (1.0 - sin2 / 1.9f64.powi(2)).sqrt();
        let soft = ((0.04 * 20.0f64).powi(2) + (0.8 / 2.3548f64).powi(2)).sqrt() * 2.0f64.sqrt();
        let band = 0.5 * (libm::erf((nm - 642.0) / soft) - libm::erf((nm - 662.0) / soft));
        let edge = 0.5 * 2560.0 * rig.pixel / rig.image_distance;
        let theory = band * (1.0 - 0.3 * tangent2 / (edge * edge));
        println!("column {column}: {passed:.4}, theory {theory:.4}");
        assert!((passed - theory).abs() < 2e-3, "column {column}: {passed} passes, theory {theory}");
    }
    assert!(dim_light[60][0] / plain_light[60][0] < 0.05 && dim_light[1280][0] / plain_light[1280][0] > 0.9);
}

/// Ambient light on a grey plate and on the conveyor, in full frames far from the line and under it: the closed form
/// with its photon noise; ceramic throws back of it what it throws back of the laser.
#[test]
fn ambient_light_follows_the_reflectance() {
    let mut scene = scene(70);
    scene.bench.laser.power_mw = 0.01;
    scene.bench.camera.ambient_w_per_m2_nm = 0.05;
    scene.bench.exposure.time_us = 200.0;
    (scene.bench.exposure.row_noise_dn, scene.bench.exposure.row_pattern_dn) = (0.0, 0.0);
    let low = |medium: Medium| {
        let flat = Flat { height_mm: 0.1, slope_x: 0.0, slope_y: 0.0, width_mm: 400.0, length_mm: 400.0, medium };
        Body::new(flat)
    };
    let (sensor, band) = expose(&scene, low(grey()), 60..61);
    let (e, dark) = (&scene.bench.exposure, scene.bench.exposure.dark_level_dn);
    let gain = (255.0 - dark) / e.full_well_e;
    let pupil = 0.5 * 25.0 / 2.8e0;
    let v0 = 25.0 * 410.0 / 385.0f64;
    let beta = (25.0f64 / 385.0 / 25.0f64.to_radians().tan()).atan();
    let watts = 0.5 * 0.05 * 450.0 * 6e-6f64.powi(2) * (pupil / v0).powi(2) * beta.cos();
    let electrons = watts * 200e-6 / (1.986_445_86e-25 / 660e-9) * 0.55 * 0.75;
    let frame: Vec<f64> = sensor.full_frame(&band, 60).into_iter().map(f64::from).collect();
    // The middle of the frame looks at the plate about the line; behind it the plate goes on.
    let near = (380..450).flat_map(|row| (60..196).map(move |col| row * 256 + col));
    let (mean, sd) = moments(near.map(|i| frame[i] - dark));
    let noise = (e.dark_noise_dn.powi(2) + gain * gain * electrons).sqrt();
    println!("ambient {mean:.3} DN, theory {:.3} DN; noise {sd:.3} DN, theory {noise:.3} DN", gain * electrons);
    assert!(gain * electrons > 10.0, "{} DN are too few to tell", gain * electrons);
    assert!((mean / (gain * electrons) - 1.0).abs() < 0.005, "{mean} DN of ambient light");
    assert!((sd / noise - 1.0).abs() < 0.03, "noise {sd} DN, theory {noise} DN");

    // Before the plate begins there is the conveyor.
    let (sensor, band) = expose(&scene, low(grey()), 0..1);
    let mut scratch = Scratch::default();
    sensor.window(&band, 0, 0, &mut scratch);
    let at = |k: usize| f64::from(scratch.windows[0].ambient[k][64]);
    // Small row numbers look ahead, at the plate.
    assert!((at(2) / electrons - 1.0).abs() < 0.01, "ahead: {} of {electrons}", at(2));
    let black = electrons / 0.5 * scene.bench.motion.conveyor_reflectance;
    assert!((at(40) / black - 1.0).abs() < 0.01, "behind: {} of {black}", at(40));

    let (sensor, band) = expose(&scene, low(ceramic()), 60..61);
    sensor.window(&band, 60, 1, &mut scratch);
    let (column, hit) = (TILE, band.line(60).hits[TILE]);
    let sight = sensor.camera().sight(hit.x, hit.surface.z, 0.0);
    let laser: f32 = (0..ROWS).map(|k| scratch.electrons(k, 0)).sum::<f32>() / (sight.electrons * sight.view.z);
    let lamps = band.line(60).ambient[column] / sensor.camera().ambient(hit.x, hit.surface.z);
    assert!((lamps / laser - 1.0).abs() < 0.02, "of the lamps {lamps} comes back, of the laser {laser}");
}
