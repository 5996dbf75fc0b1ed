//! Where light of each kind of laser stands: bowed lines, second lines, stepped points, hairs beside the line.

use base::{Body, Gloss, Medium};
use optical_bench::settings::LineShape;
use recipe::{Plan, Scene};
use scanner::optics::{Band, ROWS, Scratch, Sensor, TILE, TileOfProfile};
use test_support::target::{ceramic, expose, moments, plate, render, scene};

/// A surface that throws all light back evenly.
fn white() -> Medium {
    Medium::opaque(Gloss { matte: 1.0, ..Gloss::NONE })
}

/// Nothing but light.
fn quiet(scene: &mut Scene) {
    scene.bench.speckle.strength = 0.0;
    let exposure = &mut scene.bench.exposure;
    exposure.shot_noise = 0.0;
    (exposure.dark_noise_dn, exposure.row_noise_dn, exposure.row_pattern_dn) = (0.3, 0.0, 0.0);
    scene.extraction.subpixel_steps = 0;
}

/// Light of a profile, of both windows: column, row, electrons.
fn light(sensor: &Sensor, band: &Band, profile: usize, columns: usize) -> Vec<(usize, i32, f64)> {
    let (mut scratch, mut light) = (Scratch::default(), Vec::new());
    for tile in 0..columns / TILE {
        sensor.window(band, profile, tile, &mut scratch);
        for c in 0..TILE {
            if scratch.used == 2 {
                let apart = scratch.windows[0].first_row[c] - scratch.windows[1].first_row[c];
                assert!(apart.unsigned_abs() as usize >= ROWS, "windows of column {c} lie {apart} rows apart");
            }
            for window in &scratch.windows[..scratch.used] {
                light.extend((0..ROWS).map(|k| {
                    let electrons = f64::from(window.surface[k][c] + window.volume[k][c]);
                    (tile * TILE + c, window.first_row[c] + k as i32, electrons)
                }));
            }
        }
    }
    light
}

/// Sum and mean row of some light [e-, px].
fn centre(light: impl Iterator<Item = (i32, f64)> + Clone) -> (f64, f64) {
    let sum: f64 = light.clone().map(|(_, e)| e).sum();
    (sum, light.map(|(row, e)| f64::from(row) * e).sum::<f64>() / sum)
}

/// Range on a level plate bends by what the calibration does not know.
#[test]
fn smile_bends_range() {
    let mut scene = scene(60);
    quiet(&mut scene);
    scene.size.columns = 2560;
    scene.bench.laser.power_mw = 25.0;
    let body = || plate(ceramic(), 12.0, 0.0, 0.0);
    let straight = render(&scene, body()).maps.range;
    (scene.bench.laser.smile_um, scene.bench.laser.smile_cubic_um) = (40.0, 25.0);
    let bent = render(&scene, body()).maps.range;
    let rig = expose(&scene, body(), 0..1).0.camera().rig;
    let mut most = 0.0f64;
    let laser = &scene.bench.laser;
    let half = (laser.fan_angle_deg / 2.0).to_radians().tan();
    for column in (0..2560).step_by(97) {
        let x = rig.along(column as f64, 12.0);
        let depth = laser.fan_height_mm - 12.0;
        let side = x / depth / half;
        let bow = (0.040 + 0.025 * side) * side * side * depth / laser.fan_height_mm;
        let (_, row) = rig.project(x, bow, 12.0);
        let expected = rig.height(row) - 12.0;
        most = most.max(expected);
        let off = (0..60).map(|p| f64::from(bent[p * 2560 + column] - straight[p * 2560 + column]));
        let mean = off.sum::<f64>() / 60.0;
        // Digital numbers place the line within 5 um (tests/optics/flat_target.rs).
        assert!((mean - expected).abs() < 0.005, "column {column}: {mean}, {expected} mm");
    }
    assert!(most > 0.05, "the line bows by {most} mm at most");
}

/// The second line is seen where the camera's projection puts it, on level and tilted plates, and holds its share.
#[test]
fn a_second_line_stands_beside_the_first() {
    for (offset, slope_y) in [(5.03, 0.0), (-4.41, 0.0), (3.2, 0.2), (12.0, -0.1), (1.53, 0.0)] {
        let mut scene = scene(4);
        scene.size.columns = 2560;
        (scene.bench.laser.second_line_mm, scene.bench.laser.second_line_share) = (offset, 0.3);
        let (sensor, band) = expose(&scene, plate(white(), 15.0, 0.05, slope_y as f32), 200..201);
        let light = light(&sensor, &band, 200, 2560);
        let rig = sensor.camera().rig;
        let y = sensor.position(200);
        for column in [40usize, 700, 1279, 1930, 2520] {
            // Of whole columns: where the second plane and the plate are seen.
            let (mut x, mut z) = (rig.along(column as f64, 15.0), 15.0);
            for _ in 0..30 {
                z = 15.0 + 0.05 * x + slope_y * (y + offset);
                x += (column as f64 - rig.project(x, offset, z).0) * 0.09;
            }
            let expected = rig.project(x, offset, z).1;
            let near = |row: i32| (f64::from(row) - expected).abs() < 6.5;
            let own = light.iter().filter(|l| l.0 == column);
            let (second, row) = centre(own.clone().filter(|l| near(l.1)).map(|l| (l.1, l.2)));
            let (first, _) = centre(own.filter(|l| !near(l.1)).map(|l| (l.1, l.2)));
            assert!((row - expected).abs() < 0.02, "{offset} mm, column {column}: row {row}, {expected}");
            let share = second / (first + second);
            assert!((share - 0.3).abs() < 0.01, "{offset} mm, column {column}: {share}");
        }
    }
}

/// A point laser stands at its place in each profile, goes round within its span and is as wide along as across the
/// line.
#[test]
fn a_point_steps_along_the_line() {
    let mut scene = scene(40);
    scene.size.columns = 256;
    scene.line.shape = LineShape::Point;
    let laser = &mut scene.bench.laser;
    (laser.point_x_mm, laser.point_step_mm, laser.point_span_mm) = (1.5, 0.83, 12.0);
    let (sensor, band) = expose(&scene, plate(white(), 20.0, 0.0, 0.0), 0..40);
    let rig = sensor.camera().rig;
    for profile in 0..40usize {
        let light = light(&sensor, &band, profile, 256);
        let sum: f64 = light.iter().map(|l| l.2).sum();
        let mean = |of: &dyn Fn(&(usize, i32, f64)) -> f64| light.iter().map(|l| of(l) * l.2).sum::<f64>() / sum;
        let (column, row) = (mean(&|l| l.0 as f64), mean(&|l| f64::from(l.1)));
        let steps = 0.83 * profile as f64;
        // From the middle of the span, round after 12 mm.
        let x = 1.5 + steps - 12.0 * ((steps + 6.0) / 12.0).floor();
        let (expected, _) = rig.project(x * (1.0 - 20.0 / scene.bench.laser.fan_height_mm), 0.0, 20.0);
        assert!((column - expected).abs() < 0.01, "profile {profile}: column {column}, {expected}");
        let along = mean(&|l| (l.0 as f64 - column).powi(2));
        let across = mean(&|l| (f64::from(l.1) - row).powi(2));
        let sight = sensor.camera().sight(0.0, 20.0, 0.0);
        let round = f64::from(sight.laser_variance) / f64::from(sight.rows_per_mm * sight.column_mm).powi(2);
        let lens = f64::from(sensor.camera().lens_variance());
        assert!((across / f64::from(sight.variance) - 1.0).abs() < 0.01, "across {across}");
        assert!((along / (round + lens) - 1.0).abs() < 0.03, "along {along}, {}", round + lens);
    }
}

/// The first mechanism of hairs: where a skirt lies, speckle of the surface makes spikes of it; without one it is dark.
#[test]
fn speckle_makes_hairs_of_a_skirt() {
    let mut scene = scene(2);
    quiet(&mut scene);
    scene.bench.speckle.strength = 1.0;
    scene.size.columns = 2560;
    (scene.bench.exposure.time_us, scene.bench.exposure.dark_level_dn) = (1600.0, 12.0);
    let spikes = |scene: &Scene| {
        let (sensor, band) = expose(scene, plate(white(), 0.0, 0.0, 0.0), 0..1);
        let mut frames = Default::default();
        let (mut offsets, mut dn) = (Vec::new(), Vec::new());
        sensor.row_offsets(0, &mut offsets);
        for tile in 0..20 {
            sensor.expose(
                &TileOfProfile { band: &band, profile: 0, tile, offsets: &offsets },
                &mut Scratch::default(),
                &mut frames,
            );
            // Eight rows beside the line.
            let row = (scanner::optics::CENTRE + 8) * frames[0].cols;
            dn.extend(frames[0].dn[row..row + TILE].iter().map(|&dn| f64::from(dn) - 12.0));
        }
        let (mean, sd) = moments(dn.iter().copied());
        (mean, sd / mean, dn.into_iter().fold(0.0, f64::max) / mean, f64::from(sensor.speckle_contrast()[0]))
    };
    let (dark, ..) = spikes(&scene);
    assert!(dark.abs() < 0.1, "{dark} DN without a skirt");
    (scene.bench.laser.skirt_share, scene.bench.laser.skirt_width) = (0.03, 12.0);
    let (mean, contrast, highest, expected) = spikes(&scene);
    assert!(mean > 20.0, "{mean} DN");
    // 2560 columns, neighbours not quite independent.
    assert!((contrast / expected - 1.0).abs() < 0.1, "contrast {contrast}, {expected}");
    assert!(highest > 2.0, "the highest spike is {highest} times the mean");
}

/// The second: facets of metal add their mean light to columns, and stay where they are on the object.
#[test]
fn glints_of_metal_add_their_light() {
    let metal = Medium::opaque(Gloss { share: 1.0, reflectance: 0.9, roughness: [0.45; 2], matte: 0.0 });
    let mut scene = scene(400);
    scene.size.columns = 2560;
    let plain = expose(&scene, plate(metal, 0.0, 0.0, 0.0), 0..1).1.line(0).surface_light.clone();
    let laser = &mut scene.bench.laser;
    (laser.glints_per_mm, laser.glint_gain, laser.glint_length_mm) = (0.5, 6.0, 0.1);
    let (sensor, band) = expose(&scene, plate(metal, 0.0, 0.0, 0.0), 0..400);
    // A mean length is 1.5 profiles: 20 profiles apart nothing is met twice.
    let more = (0..400).step_by(20).map(|p| {
        let glare = &band.line(p).surface_light;
        (0..2560).map(|c| f64::from(glare[c] / plain[c]) - 1.0).sum::<f64>() / 2560.0
    });
    let (mean, sd) = moments(more.collect::<Vec<_>>().into_iter());
    let expected = 0.5 * 6.0 * (sensor.camera().rig.along(1.0, 0.0) - sensor.camera().rig.along(0.0, 0.0));
    assert!((mean - expected).abs() < 4.0 * sd / 20f64.sqrt(), "{mean} +- {sd}, {expected}");
    assert!(sd / 20f64.sqrt() < 0.1 * expected, "spread {sd}");
}

/// The third: fibres of a board that the line stands on shine beside it with the light that they are said to have, and
/// keep their place on the board.
#[test]
fn streaks_lie_on_the_board() {
    let mut scene = scene(20);
    scene.size.columns = 1024;
    if let Plan::Wood(wood) = &mut scene.plan {
        wood.board.lead_in_mm = -5.0_f64.min(wood.board.lead_in_mm);
        (wood.board.lead_in_mm, wood.board.width_mm) = (0.5, 90.0);
    }
    let body: Body = pipeline::body(&scene);
    let (sensor, plain) = expose(&scene, body.clone(), 14..18);
    let dark = light(&sensor, &plain, 16, 1024);
    (scene.bench.laser.streaks_per_mm, scene.bench.laser.streak_length_mm) = (1.0, 0.3);
    let (sensor, band) = expose(&scene, body, 14..18);
    let lit = light(&sensor, &band, 16, 1024);
    let streaks = &band.line(16).streaks;
    let count = streaks.len() as f64;
    assert!((count - 88.0).abs() < 3.5 * 88f64.sqrt(), "{count} streaks");
    let added: f64 = lit.iter().zip(&dark).map(|(lit, dark)| lit.2 - dark.2).sum();
    let told: f64 = streaks.iter().map(|s| f64::from(s.electrons * (s.last_row - s.first_row))).sum();
    assert!(added > 0.0 && (added / told - 1.0).abs() < 0.03, "{added} of {told} electrons");
    // A step of the scan further, those that still reach the line have moved by a step.
    let rate = f64::from(band.line(16).rows_per_mm[512]);
    let step = (sensor.position(17) - sensor.position(16)) * rate;
    let mut stay = 0;
    for streak in streaks {
        let next = band.line(17).streaks.iter().find(|next| {
            (next.column - streak.column).abs() < 0.3
                && (f64::from((next.last_row - next.first_row) - (streak.last_row - streak.first_row))).abs() < 0.05
        });
        if let Some(next) = next {
            let moved = f64::from((next.first_row - next.centre) - (streak.first_row - streak.centre));
            assert!((moved - step).abs() < 0.05, "{moved} rows, {step}");
            stay += 1;
        }
    }
    assert!(stay > 50, "{stay} of {count} stay");
}
