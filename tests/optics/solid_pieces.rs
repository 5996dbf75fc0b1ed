//! Saw-teeth and parts under the bench: heights, teeth, and what is hidden from laser and lens, against closed forms.

use base::{Body, Class, Mesh};
use glam::Vec3;
use procedural::solid::{Material, Part, Piece, Placing, Sawtooth};
use recipe::{Plan, Recipe, Scene};
use test_support::target::{expose, moments, render, scene};

/// Metal that throws half of the light back evenly and lets nothing in that returns.
fn metal() -> Material {
    Material { gloss: 0.0, matte: 0.5, ..Material::from_values(&mut |p| p.default) }
}

/// No noise, no speckle, no rounding.
fn quiet(mut scene: Scene) -> Scene {
    scene.bench.speckle.strength = 0.0;
    let exposure = &mut scene.bench.exposure;
    exposure.shot_noise = 0.0;
    (exposure.dark_noise_dn, exposure.row_noise_dn, exposure.row_pattern_dn) = (0.3, 0.0, 0.0);
    scene.extraction.subpixel_steps = 0;
    scene
}

fn part(mesh: &Mesh, placing: impl Fn(Placing) -> Placing) -> Body {
    Body::new(Part::new(mesh, &placing(Placing::from_values(&mut |p| p.default)), &metal()))
}

fn cuboid(size: Vec3) -> Mesh {
    let corner = |i: u32| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) * size;
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    Mesh { positions: (0..8).map(corner).collect(), triangles }
}

/// RCAL-300 as the recipe lays it: Range is right to 15 um, a twentieth of a row, away from edges, and shows fifteen
/// teeth.
#[test]
fn range_of_the_saw_tooth_is_right() {
    let mut scene = quiet(Recipe::load("sawtooth").expect("embedded").draw(0, 0));
    let Plan::Sawtooth(piece, material) = &mut scene.plan else { panic!("no saw-tooth") };
    (piece.lead_in_mm, *material) = (1.0, metal());
    let slope = piece.depth_mm / (0.5 * piece.length_mm / piece.teeth);
    let middle = (piece.base_mm + 0.5 * piece.depth_mm) as f32;
    scene.size.profiles = 120;
    let body = pipeline::body(&scene);
    let record = render(&scene, body);
    let truth = &record.truth.as_ref().expect("the recipe keeps truth maps").height;
    let cols = record.cols;
    let rig = scanner::optics::camera::rig(&scene.bench, &scene.size);
    assert_eq!(cols, scene.size.columns);
    let mut errors = Vec::new();
    for row in 80..record.rows {
        let (range, truth) = (&record.maps.range[row * cols..][..cols], &truth[row * cols..][..cols]);
        for c in 4..cols - 4 {
            // A flank of one slope over nine columns, by where each of them looks.
            let [a, b] = [c - 4, c + 4].map(|c| [rig.along(c as f64, f64::from(truth[c])), f64::from(truth[c])]);
            if (((b[1] - a[1]) / (b[0] - a[0])).abs() / slope - 1.0).abs() < 0.01 {
                errors.push(1000.0 * f64::from(range[c] - truth[c]));
            }
        }
        let above: Vec<bool> = range.iter().map(|&z| z > middle).collect();
        let teeth = above.windows(2).filter(|pair| !pair[0] && pair[1]).count();
        assert_eq!(teeth, 15, "profile {row}");
    }
    let (mean, sd) = moments(errors.iter().copied());
    let rms = (mean * mean + sd * sd).sqrt();
    println!("{} places: {mean:.2} um mean error, {rms:.2} um rms", errors.len());
    assert!(errors.len() > 60_000 && errors.iter().all(|e| e.is_finite()), "{} places", errors.len());
    assert!(rms < 15.0, "{rms} um rms");
    let numbers: Vec<u16> = record.objects.iter().map(|object| object.instance.id).collect();
    assert_eq!(numbers, (1..=15).collect::<Vec<_>>());
}

/// Whether the place (x, z) of a saw-tooth that lies along the line from -half to half is free towards (0, eye): each
/// peak throws a shadow that falls as the line from the eye over it does.
fn free(piece: &Piece, x: f64, z: f64, eye: f64) -> (bool, f64) {
    let (pitch, half) = (piece.length_mm / piece.teeth, 0.5 * piece.length_mm);
    let top = piece.base_mm + piece.depth_mm;
    let peaks = (0..piece.teeth as usize).map(|t| (t as f64 + piece.rise_share) * pitch - half);
    let between = peaks.filter(|peak| peak * x > 0.0 && peak.abs() < x.abs());
    let shadow = between.map(|peak| top - (x - peak) / peak * (eye - top)).fold(f64::MIN, f64::max);
    (z > shadow, z - shadow)
}

/// Flanks of nine shares: lit and seen by rays exactly where the angles of fan and lens say, and missing in Range
/// exactly where they are not both, or so steep that their light is too faint.
#[test]
#[ignore = "long"]
fn flanks_are_hidden_where_their_angles_say() {
    let mut scene = quiet(scene(52));
    scene.size.columns = 2560;
    scene.bench.laser.fan_angle_deg = 60.0;
    scene.bench.laser.power_mw = 150.0;
    // Numbers of 8 bits.
    let gain = 255.0 / scene.bench.exposure.full_well_e;
    let (mut hidden, mut unread) = ([0usize; 4], 0);
    for (i, rise_share) in [0.0, 0.05, 0.1, 0.15, 0.5, 0.88, 0.92, 0.96, 1.0].into_iter().enumerate() {
        // The fan comes from below the lens and from above it.
        scene.bench.laser.fan_height_mm = if i % 2 == 0 { 300.0 } else { 600.0 };
        let sizes = Piece { length_mm: 200.0, teeth: 20.0, depth_mm: 4.0, ..piece() };
        let piece = Piece { rise_share, lead_in_mm: 0.5, base_mm: 5.0, ..sizes };
        let body = || Body::new(Sawtooth::new(&piece, &metal()));
        let (sensor, band) = expose(&scene, body(), 46..52);
        let rig = &sensor.camera().rig;
        let lens = rig.distance * libm::cos(rig.tilt);
        let record = render(&scene, body());
        for profile in 46..52 {
            let line = band.line(profile);
            let range = &record.maps.range[profile * record.cols..][..record.cols];
            let places = line.hits.iter().zip(range).enumerate();
            for (column, (hit, range)) in places.filter(|(_, (hit, _))| hit.matter.class == Class::Tooth) {
                let (x, z) = (f64::from(hit.x), f64::from(hit.surface.z));
                let (lit, over) = free(&piece, x, z, scene.bench.laser.fan_height_mm);
                let (seen, above) = free(&piece, x, z, lens);
                let edge = |over: f64| over.abs() < 0.02;
                // Where a shadow ends, or an upright flank, which columns meet at any height.
                let upright = hit.surface.slope_x.abs() > 40.0;
                if edge(over) || edge(above) || upright {
                    continue;
                }
                assert_eq!((hit.lit, hit.seen), (lit, seen), "{rise_share}: {hit:?}");
                // Light of a grazing flank stands in many rows: too faint to be read.
                let peak = f64::from(line.surface_light[column])
                    / (std::f64::consts::TAU * f64::from(line.variance[column])).sqrt();
                let faint = peak * gain < 1.2 * scene.extraction.threshold_dn;
                if lit && seen && faint {
                    unread += 1;
                    assert!(hit.surface.slope_x.abs() > 2.0, "{rise_share}: {peak} e- of {hit:?}");
                } else if line.mixed.iter().all(|mixed| mixed.column != column) {
                    // Columns that see past an edge have light of what is not hidden.
                    assert_eq!(range.is_nan(), !(lit && seen), "{rise_share}: Range {range} of {hit:?}");
                }
                hidden[usize::from(lit) + 2 * usize::from(seen)] += 1;
            }
        }
    }
    println!("places neither lit nor seen, lit alone, seen alone, both: {hidden:?}; {unread} too faint");
    assert!(hidden.iter().all(|&places| places > 20) && 100 * unread < hidden[3], "{hidden:?}, {unread} too faint");
}

fn piece() -> Piece {
    Piece::from_values(&mut |p| p.default)
}

/// A ball of many facets: Range and slopes are those of the sphere, to what facets leave.
#[test]
fn a_ball_is_round() {
    let (radius, steps) = (8.0f32, 240usize);
    let mut mesh = Mesh::default();
    for i in 0..=steps / 2 {
        for j in 0..steps {
            let (rise, turn) = (i as f64 / steps as f64, j as f64 / steps as f64);
            let (up, around) = (libm::sincos(std::f64::consts::TAU * rise), libm::sincos(std::f64::consts::TAU * turn));
            mesh.positions.push(radius * Vec3::new((up.0 * around.1) as f32, (up.0 * around.0) as f32, -up.1 as f32));
            let at = |i: usize, j: usize| (i * steps + j % steps) as u32;
            if i < steps / 2 {
                mesh.triangles.push([at(i, j), at(i, j + 1), at(i + 1, j + 1)]);
                mesh.triangles.push([at(i, j), at(i + 1, j + 1), at(i + 1, j)]);
            }
        }
    }
    let scene = quiet(scene(260));
    let body = || part(&mesh, |p| Placing { lead_in_mm: 0.5, ..p });
    let (_, band) = expose(&scene, body(), 0..260);
    let record = render(&scene, body());
    let centre = Vec3::new(0.0, 8.5, 8.0);
    let (mut errors, mut tilts) = (Vec::new(), Vec::new());
    for profile in 0..260 {
        let y = (profile as f64 * scene.bench.motion.step_mm) as f32;
        let row = &record.maps.range[profile * record.cols..][..record.cols];
        for (hit, range) in band.line(profile).hits.iter().zip(row) {
            let from = Vec3::new(hit.x, y, hit.surface.z) - centre;
            if hit.matter.class != Class::Object || !hit.seen {
                continue;
            }
            let normal = Vec3::new(-hit.surface.slope_x, -hit.surface.slope_y, 1.0).normalize();
            if normal.z > 0.3 {
                tilts.push(normal.dot(from.normalize()).min(1.0).acos().to_degrees());
            }
            // A slope of the line makes its rows unlike over its width: level places are asked alone.
            if normal.z > 0.9 {
                let height = centre.z + (radius * radius - from.x * from.x - from.y * from.y).sqrt();
                errors.push(1000.0 * f64::from(range - height));
            }
        }
    }
    let most = tilts.iter().copied().fold(0.0, f32::max);
    // Half a facet's angle along and across.
    assert!(tilts.len() > 15_000 && most < 1.1, "{} normals, {most} deg off", tilts.len());
    let (mean, sd) = moments(errors.iter().copied());
    println!("{} places: {mean:.2} um mean error, {sd:.2} um spread; normals within {most:.2} deg", errors.len());
    // Facets of 1.5 deg lie up to r (1 - cos 0.75 deg) = 0.7 um inside.
    assert!(errors.len() > 3_000 && mean.abs() < 2.0 && sd < 6.0, "{mean} um mean error, {sd} um spread");
}

/// A slab that hovers: the lens looks under it, which no height field shows, and over it, and past neither between.
#[test]
fn the_lens_looks_under_an_overhang() {
    let scene = quiet(scene(140));
    // 2 mm along the scan, its lower side 10 mm above the conveyor.
    let body = part(&cuboid(Vec3::new(40.0, 2.0, 1.0)), |p| Placing { lift_mm: 10.0, lead_in_mm: 0.5, ..p });
    let (sensor, band) = expose(&scene, body, 0..140);
    let rise = libm::tan(sensor.camera().rig.tilt);
    for profile in 0..140 {
        let y = profile as f64 * scene.bench.motion.step_mm;
        for hit in &band.line(profile).hits[100..156] {
            let slab = (0.5..=2.5).contains(&y);
            assert_eq!(hit.matter.class == Class::Object, slab, "{y}");
            // The way to the lens rises by 1 / tan(tilt) all along: it meets the slab's height there.
            let [low, high] = [0.5 + 10.0 * rise, 2.5 + 11.0 * rise];
            let hidden = !slab && y > low && y < high;
            if [low, high].iter().all(|edge| (y - edge).abs() > 0.07) {
                assert_eq!((hit.lit, hit.seen), (true, !hidden), "{y}");
            }
        }
    }
}

/// A plate with a hole: columns look through it to the conveyor, and two boxes, one above the other, hide as one.
#[test]
fn holes_and_pieces_are_what_they_are() {
    let scene = quiet(scene(120));
    // Two bars along the scan, 4 mm apart, and one that hovers over the gap.
    let mut mesh = Mesh::default();
    for (at, size) in [
        (Vec3::new(-8.0, 0.0, 0.0), Vec3::new(6.0, 20.0, 2.0)),
        (Vec3::new(2.0, 0.0, 0.0), Vec3::new(6.0, 20.0, 2.0)),
        (Vec3::new(-1.0, 0.0, 5.0), Vec3::new(1.0, 20.0, 0.5)),
    ] {
        let first = mesh.positions.len() as u32;
        let bar = cuboid(size);
        mesh.positions.extend(bar.positions.iter().map(|&p| p + at));
        mesh.triangles.extend(bar.triangles.iter().map(|t| t.map(|corner| corner + first)));
    }
    let (_, band) = expose(&scene, part(&mesh, |p| Placing { lead_in_mm: 0.0, ..p }), 110..115);
    for hit in &band.line(112).hits {
        let (x, z) = (f64::from(hit.x), hit.surface.z);
        let near = |edge: f64| (x.abs() - edge).abs() < 0.3;
        if [8.0, 2.0, 1.0, 0.0].into_iter().any(near) {
            continue;
        }
        let expected = match x {
            x if (-1.0..0.0).contains(&x) => 5.5,
            x if (2.0..8.0).contains(&x.abs()) => 2.0,
            _ => 0.0,
        };
        assert!((z - expected).abs() < 1e-3 && hit.lit, "{hit:?}");
        assert_eq!(hit.matter.class == Class::Background, expected == 0.0, "{hit:?}");
    }
    let dark = band.line(112).hits.iter().filter(|hit| !hit.lit || !hit.seen).count();
    assert!(dark < 30, "{dark} columns are dark");
}
