//! What camera and laser make of blister packs: domes hide what lies behind them, clear film shows tablets and foil,
//! facets that face both saturate, walls mirror the line onto the film at their feet.

use base::{Body, Stream};
use glam::{DVec3, Vec3};
use procedural::blister::{Blister, Pack};
use recipe::Scene;
use scanner::specimen::{Hit, height_below};
use test_support::target::{expose, moments, render, scene};

/// A level pack of 3 by 3 flat round tablets under smooth film, 10 mm of the first row of pockets in the middle of 600
/// profiles.
fn blister(change: impl Fn(&mut Blister)) -> Blister {
    let mut blister = Blister::from_values(&mut |p| p.default);
    (blister.card.bow_mm, blister.card.curl_mm, blister.card.knurl_um) = (0.0, 0.0, 0.0);
    (blister.card.code_mm, blister.card.lead_in_mm) = (0.0, 2.0);
    (blister.pocket.bumps_um, blister.pocket.dome_mm) = (0.0, 0.0);
    let tablet = &mut blister.tablet;
    (tablet.thickness_mm, tablet.band_mm, tablet.deboss_mm) = (3.0, 3.0, 0.0);
    (tablet.tilt_deg, tablet.rattle, tablet.on_edge) = (0.0, 0.0, 0.0);
    change(&mut blister);
    blister
}

fn body(blister: &Blister) -> (Pack, Body) {
    let pack = Pack::form(Stream::root(7), blister);
    (pack.clone(), Body::new(pack))
}

/// The nominal bench over `columns` columns.
fn wide(columns: usize, profiles: usize) -> Scene {
    let mut scene = scene(profiles);
    scene.size.columns = columns;
    scene
}

fn normal(hit: &Hit) -> Vec3 {
    Vec3::new(-hit.surface.slope_x, -hit.surface.slope_y, 1.0).normalize()
}

/// Whether the film stands between a point and the lens over (0, y); the film raised by `by` except near the point
/// [mm].
fn barred(pack: &Pack, from: DVec3, lens: DVec3, by: f64) -> bool {
    let way = (lens - from).normalize();
    (1..1200).any(|i| {
        let at = from + way * (0.01 * f64::from(i));
        let near = 0.004 * f64::from(i);
        pack.sheet(at.x as f32, at.y as f32).is_some_and(|s| f64::from(s.surface.z) + by.clamp(-near, near) > at.z)
    })
}

/// Points are in sight exactly where straight ways through the film itself say, but for a fringe of 15 um; x and z of
/// each column lie on its line of sight.
#[test]
fn domes_hide_what_stands_behind_them() {
    let (pack, body) = body(&blister(|b| b.pocket.dome_mm = 0.5));
    let scene = wide(640, 600);
    let (sensor, band) = expose(&scene, body, 60..306);
    let rig = sensor.camera().rig;
    let (mut hidden, mut decided, mut points) = (0, 0, 0);
    for profile in [60, 120, 180, 250, 265, 275, 285, 295, 305] {
        let y = profile as f64 * scene.bench.motion.step_mm;
        let lens = DVec3::new(0.0, y - rig.distance * rig.tilt.sin(), rig.distance * rig.tilt.cos());
        for (column, hit) in band.line(profile).hits.iter().enumerate().step_by(3) {
            if hit.matter.film.is_none() {
                continue;
            }
            let off = rig.along(column as f64, f64::from(hit.surface.z)) - f64::from(hit.x);
            assert!(off.abs() < 5e-3, "profile {profile}, column {column}: {off} mm beside its line of sight");
            points += 1;
            let from = DVec3::new(f64::from(hit.x), y, f64::from(hit.surface.z));
            let facing = normal(hit).as_dvec3().dot((lens - from).normalize());
            let truth = [-0.015, 0.015].map(|by| facing < 0.0 || barred(&pack, from, lens, by));
            if truth[0] == truth[1] && facing.abs() > 0.02 {
                decided += 1;
                hidden += usize::from(truth[0]);
                assert_eq!(hit.seen, !truth[0], "profile {profile}, column {column}: {hit:?}, facing {facing}");
            }
        }
    }
    println!("{hidden} hidden of {decided} decided of {points} points");
    assert!(hidden > 60 && decided > 9 * points / 10, "{hidden} hidden of {decided} decided of {points}");
}

/// Mirrored light of walls is seen where straight ways, followed through the film itself, say: its middle on the sensor
/// within 0.7 rows and half a column, its light within 8 %, and it is lost where its way ends out of sight.
#[test]
fn walls_mirror_the_line_onto_the_film_at_their_feet() {
    let (pack, body) = body(&blister(|b| (b.pocket.draft_deg, b.web.formed_roughness) = (20.0, 0.05)));
    let mut scene = wide(640, 600);
    // So that no light is too faint to be kept.
    scene.bench.exposure.full_well_e = 500.0;
    let (sensor, band) = expose(&scene, body, 60..151);
    let camera = sensor.camera();
    let mut compared = 0;
    for profile in [85, 90, 95, 105, 120, 150] {
        let y = profile as f64 * scene.bench.motion.step_mm;
        let lens = DVec3::new(
            0.0,
            y - camera.rig.distance * camera.rig.tilt.sin(),
            camera.rig.distance * camera.rig.tilt.cos(),
        );
        let mut sums = [0.0f64; 3];
        let line = band.line(profile);
        // What the film of this line answers to light in a column, within 0.32 mm.
        let answer = |column: usize| {
            let hit = &line.hits[column];
            let sight = camera.sight(hit.x, hit.surface.z, hit.surface.slope_y);
            let light: f32 = (0..5).map(|j| line.source[j][column] * line.exit[j][column]).sum();
            f64::from(light / (sight.electrons * normal(hit).dot(sight.view)))
        };
        for hit in band.line(profile).hits.iter().filter(|hit| hit.lit && hit.matter.film.is_some()) {
            let n = normal(hit).as_dvec3();
            let sight = camera.sight(hit.x, hit.surface.z, hit.surface.slope_y);
            let light = sight.light.as_dvec3();
            let way = light - n * (2.0 * light.dot(n));
            let from = DVec3::new(f64::from(hit.x), y, f64::from(hit.surface.z));
            // Where it goes through the film from above.
            let met = (15..2400).map(|i| from + way * (0.01 * f64::from(i))).find_map(|at| {
                let sheet = pack.sheet(at.x as f32, at.y as f32)?;
                (f64::from(sheet.surface.z) >= at.z).then_some((at, sheet.surface))
            });
            let Some((at, there)) = met else { continue };
            let up = Vec3::new(-there.slope_x, -there.slope_y, 1.0).normalize().as_dvec3();
            let facing = up.dot((lens - at).normalize());
            if facing <= 0.0 || barred(&pack, at + DVec3::Z * 0.005, lens, 0.0) {
                continue;
            }
            let cos = -light.dot(n);
            let inside = (1.0 - (1.0 - cos * cos) / (1.53 * 1.53)).sqrt();
            let (s, p) = ((cos - 1.53 * inside) / (cos + 1.53 * inside), (1.53 * cos - inside) / (1.53 * cos + inside));
            let (column, row) = camera.rig.project(at.x, at.y - y, at.z);
            let light = f64::from(sight.electrons) * 0.5 * (s * s + p * p) * facing * answer(column.round() as usize);
            sums = [sums[0] + light, sums[1] + light * column, sums[2] + light * row];
        }
        let beside = band.line(profile).secondary.as_ref().expect("a pack has mirror images");
        let seen = beside.reflections.iter().fold([0.0f64; 3], |sum, splat| {
            let light = f64::from(splat.electrons);
            [sum[0] + light, sum[1] + light * splat.column as f64, sum[2] + light * f64::from(splat.row)]
        });
        let truth = [sums[1] / sums[0], sums[2] / sums[0]];
        let image = [seen[1] / seen[0], seen[2] / seen[0]];
        println!("profile {profile}: at {image:?}, ways say {truth:?}; light {:.0} of {:.0} e-", seen[0], sums[0]);
        if sums[0] > 1000.0 {
            compared += 1;
            assert!(
                (image[0] - truth[0]).abs() < 0.5 && (image[1] - truth[1]).abs() < 0.7,
                "{image:?} against {truth:?}"
            );
            assert!((seen[0] / sums[0] - 1.0).abs() < 0.08, "light {} of {} e-", seen[0], sums[0]);
        }
    }
    assert!(compared >= 3, "only {compared} profiles have images");
}

/// Through clear film Range is the tablet's height, and the foil's where the tablet is missing, raised as refraction in
/// the film raises it (Snell's law); both to 10 um.
#[test]
#[ignore = "long"]
fn clear_film_shows_tablet_and_foil() {
    for missing in [0.0, 9.0] {
        let blister = blister(|b| {
            (b.web.sigma_per_mm, b.web.mu_a_per_mm) = (0.01, 0.0005);
            // The film's own line is faint, and further from the other than the reading's window.
            (b.web.roughness, b.web.formed_roughness, b.pocket.headroom_mm) = (0.03, 0.03, 3.0);
            b.tablet.gloss = 0.0;
            b.defects.missing = missing;
            // Rolled so that the foil's gloss reaches the lens.
            (b.foil.roughness_along, b.foil.roughness_across) = (0.5, 0.5);
        });
        let mut scene = wide(256, 260);
        scene.bench.speckle.strength = 0.0;
        scene.bench.exposure.time_us = 25.0;
        let (_, body) = body(&blister);
        let record = render(&scene, body.clone());
        // The middle of the middle pocket of the first row.
        let (card, half) = (&blister.card, 0.5 * blister.card.length_mm);
        let middle = ((card.lead_in_mm + half - card.pitch_y_mm) / scene.bench.motion.step_mm) as usize;
        let mut errors = Vec::new();
        let (sensor, band) = expose(&scene, body, middle - 8..middle + 8);
        for profile in middle - 8..middle + 8 {
            for column in 112..144 {
                let hit = &band.line(profile).hits[column];
                let film = hit.matter.film.expect("the pocket is closed");
                let outside = sensor.camera().sight(hit.x, hit.surface.z, 0.0).view.z.acos();
                let inside = (outside.sin() / blister.web.n as f32).asin();
                let raised = film.thickness_mm * (1.0 - inside.tan() / outside.tan());
                let below = height_below(&hit.surface, &film) + raised;
                errors.push(1000.0 * f64::from(record.maps.range[profile * 256 + column] - below));
            }
        }
        let found = errors.iter().filter(|e| e.abs() < 200.0).count();
        let (mean, sd) = moments(errors.iter().copied().filter(|e| e.abs() < 200.0));
        println!("missing {missing}: {mean:.1} um mean error, {sd:.1} um spread, {found} of {}", errors.len());
        assert!(found * 20 > 19 * errors.len(), "only {found} of {} read the surface below", errors.len());
        assert!(mean.abs() < 10.0, "missing {missing}: mean error {mean} um");
    }
}

/// On a smooth dome the film saturates where its normal halves the angle of laser and lens, and stays below elsewhere.
#[test]
fn facets_that_face_laser_and_lens_saturate() {
    let blister = blister(|b| {
        (b.pocket.dome_mm, b.web.roughness, b.web.formed_roughness) = (1.0, 0.05, 0.05);
    });
    let mut scene = wide(256, 260);
    scene.bench.exposure.time_us = 12.0;
    let (_, body) = body(&blister);
    let record = render(&scene, body.clone());
    let (mut glints, mut dull) = (Vec::new(), Vec::new());
    let (sensor, band) = expose(&scene, body, 40..260);
    for profile in 40..260 {
        for (column, hit) in
            band.line(profile).hits.iter().enumerate().filter(|(_, h)| h.seen && h.matter.film.is_some())
        {
            let sight = sensor.camera().sight(hit.x, hit.surface.z, hit.surface.slope_y);
            let off = normal(hit).dot((sight.view - sight.light).normalize()).min(1.0).acos().to_degrees();
            let dn = f64::from(record.maps.reflectance[profile * 256 + column]);
            match off {
                off if off < 1.0 => glints.push(dn),
                off if off > 10.0 && hit.surface.slope_x.hypot(hit.surface.slope_y) < 0.3 => dull.push(dn),
                _ => (),
            }
        }
    }
    let full = glints.iter().filter(|&&dn| dn == 255.0).count();
    let (mean, _) = moments(dull.iter().copied());
    println!("{full} of {} glints saturate; {} dull places at {mean:.0} DN", glints.len(), dull.len());
    assert!(glints.len() > 12 && full * 10 > 9 * glints.len(), "{full} of {} glints", glints.len());
    assert!(dull.len() > 4000 && mean < 150.0, "{} dull places at {mean} DN", dull.len());
}
