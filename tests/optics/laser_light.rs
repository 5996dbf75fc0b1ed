//! Light of each kind of laser, without noise, against closed forms on level and tilted matte plates.

use std::f64::consts::PI;

use base::{Body, Gloss, Medium};
use optical_bench::settings::{Fan, LineShape};
use recipe::Scene;
use scanner::optics::{ROWS, Scratch, Sensor, TILE};
use test_support::target::{patterns, plate, scene};

/// Columns of the whole sensor.
const COLUMNS: usize = 2560;

/// A surface that throws all light back evenly.
fn white() -> Medium {
    Medium::opaque(Gloss { matte: 1.0, ..Gloss::NONE })
}

/// The whole sensor over one profile.
fn wide() -> Scene {
    let mut scene = scene(1);
    scene.size.columns = COLUMNS;
    scene.bench.laser.fan_angle_deg = 20.0;
    scene
}

/// Light of one profile: sensor and, a column, rows and their electrons.
fn light(scene: &Scene, body: Body, profile: usize) -> (Sensor, Vec<Vec<(i32, f64)>>) {
    let (sensor, specimen) = pipeline::set_up(scene, body, patterns());
    let band = sensor.band(&specimen, profile..profile + 1);
    let mut columns = vec![Vec::new(); scene.size.columns];
    let mut scratch = Scratch::default();
    for tile in 0..scene.size.columns / TILE {
        sensor.window(&band, profile, tile, &mut scratch);
        for window in &scratch.windows[..scratch.used] {
            for c in 0..TILE {
                columns[tile * TILE + c].extend(
                    (0..ROWS).map(|k| {
                        (window.first_row[c] + k as i32, f64::from(window.surface[k][c] + window.volume[k][c]))
                    }),
                );
            }
        }
    }
    (sensor, columns)
}

fn sum(rows: &[(i32, f64)]) -> f64 {
    rows.iter().map(|(_, e)| e).sum()
}

/// Electrons of all light of the laser on a white Lambertian patch at (x, z) with the normal's z part and cosine
/// towards the lens as on a surface with the slopes `s` [e-].
fn whole(scene: &Scene, x: f64, z: f64, s: [f64; 2]) -> f64 {
    let (laser, camera, exposure) = (&scene.bench.laser, &scene.bench.camera, &scene.bench.exposure);
    let photons = laser.power_mw * 1e-3 * exposure.time_us * 1e-6 * laser.wavelength_nm * 1e-9 / 1.986_445_86e-25;
    let (sin, cos) = camera.tilt_deg.to_radians().sin_cos();
    let to = [-x, -camera.distance_mm * sin, camera.distance_mm * cos - z];
    let r2: f64 = to.iter().map(|v| v * v).sum();
    let upright = (to[2] - s[0] * to[0] - s[1] * to[1]) / (1.0 + s[0] * s[0] + s[1] * s[1]).sqrt() / r2.sqrt();
    let axial = (cos * to[2] - sin * to[1]) / r2.sqrt();
    let pupil = 0.5 * camera.focal_length_mm / camera.f_number;
    photons * exposure.quantum_efficiency * camera.transmission * pupil * pupil * axial * upright / r2
}

/// Share of the laser's power that a level plate at height `z` shows in all columns [1].
fn shown(scene: &Scene, z: f64) -> f64 {
    let (sensor, columns) = light(scene, plate(white(), z as f32, 0.0, 0.0), 0);
    let rig = sensor.camera().rig;
    let share = |(c, rows): (usize, &Vec<(i32, f64)>)| sum(rows) / whole(scene, rig.along(c as f64, z), z, [0.0; 2]);
    columns.iter().enumerate().map(share).sum()
}

/// The integral of the irradiance over a plane is the laser's power, whatever the line looks like.
#[test]
#[ignore = "long"]
fn power_is_kept() {
    type Change = fn(&mut Scene);
    // A hard end of the line lies somewhere in a column, 5e-4 of it.
    let changes: [(&str, Change, f64); 11] = [
        ("powell", |_| (), 2e-4),
        ("narrow", |s| s.bench.laser.waist_mm = 0.02, 2e-4),
        ("ripple", |s| (s.bench.laser.fan_ripple, s.bench.laser.fan_soft_ends) = (0.2, 0.1), 2e-4),
        ("cylindrical", |s| (s.line.fan, s.bench.laser.fan_angle_deg) = (Fan::Cylindrical, 14.0), 2e-4),
        ("slit", |s| (s.line.shape, s.bench.laser.line_width_mm) = (LineShape::Slit, 1.0), 2e-4),
        ("texture", |s| (s.line.shape, s.bench.laser.texture_length_mm) = (LineShape::Texture, 180.0), 8e-4),
        ("point", |s| (s.line.shape, s.bench.laser.point_x_mm) = (LineShape::Point, 31.0), 5e-4),
        ("small point", |s| (s.line.shape, s.bench.laser.waist_mm) = (LineShape::Point, 0.02), 5e-4),
        ("lobes", |s| (s.bench.laser.lobe_share, s.bench.laser.lobe_pairs) = (0.1, 3.0), 2e-4),
        // 4e-3 of a halo lie beyond the window.
        ("skirt", |s| (s.bench.laser.skirt_share, s.bench.laser.skirt_width) = (0.1, 3.0), 6e-4),
        ("jitter", |s| s.bench.laser.width_jitter = 0.2, 2e-4),
    ];
    for (name, change, slack) in changes {
        for z in [0.0, 30.0] {
            let mut scene = wide();
            change(&mut scene);
            let share = shown(&scene, z);
            assert!((share - 1.0).abs() < slack, "{name} at {z} mm: {share}");
        }
    }
}

/// On a plate that is steep along the line and along the motion a column gets the angle of the fan between the places
/// that its edges look at, far from the axis too.
#[test]
fn grazing_facets_get_what_the_fan_sends_them() {
    for (across, along) in [(1.5, 0.0), (-0.8, 0.4), (0.5, -0.3)] {
        let mut scene = wide();
        scene.bench.laser.waist_mm = 0.03;
        let half = (scene.bench.laser.fan_angle_deg / 2.0).to_radians().tan();
        let (sensor, columns) = light(&scene, plate(white(), 10.0, across as f32, along as f32), 0);
        let rig = sensor.camera().rig;
        // Profile 0 stands at y = 0.
        let height = |x: f64| 10.0 + across * x;
        let place = |column: f64| {
            let (mut low, mut high) = (-150.0f64, 150.0f64);
            for _ in 0..60 {
                let x = 0.5 * (low + high);
                if rig.along(column, height(x)) > x { low = x } else { high = x }
            }
            low
        };
        for c in (1000..1560).step_by(7) {
            let [low, x, high] = [-0.5, 0.0, 0.5].map(|off| place(c as f64 + off));
            let tangent = |x: f64| x / (scene.bench.laser.fan_height_mm - height(x));
            if x.abs() > 45.0 / across.abs().max(1.0) {
                continue;
            }
            let share = (tangent(high) - tangent(low)) / (2.0 * half);
            let expected = share * whole(&scene, x, height(x), [across, along]);
            let got = sum(&columns[c]);
            assert!((got / expected - 1.0).abs() < 2e-3, "slopes {across} {along}, column {c}: {got}, {expected}");
        }
    }
}

/// Light along the line of a cylindrical lens is a Gaussian in the tangent, over 1 + t^2.
#[test]
fn cylindrical_lenses_have_a_hot_spot() {
    let mut scene = wide();
    scene.line.fan = Fan::Cylindrical;
    let half = (scene.bench.laser.fan_angle_deg / 2.0).to_radians().tan();
    let (sensor, columns) = light(&scene, plate(white(), 0.0, 0.0, 0.0), 0);
    let rig = sensor.camera().rig;
    let share = |c: usize| sum(&columns[c]) / whole(&scene, rig.along(c as f64, 0.0), 0.0, [0.0; 2]);
    let middle = share(COLUMNS / 2);
    for c in (100..COLUMNS - 100).step_by(50) {
        let t = rig.along(c as f64, 0.0) / scene.bench.laser.fan_height_mm;
        let law = (-2.0 * (t / half).powi(2)).exp() / (1.0 + t * t);
        assert!((share(c) / middle - law).abs() < 1e-3, "column {c}: {} and {law}", share(c) / middle);
    }
}

/// Rows per mm on a level surface in the middle of the sensor, and the row of the line there [px/mm, px].
fn rows(sensor: &Sensor, z: f64) -> (f64, f64) {
    let row = |y: f64| sensor.camera().rig.project(0.0, y, z).1;
    ((row(-1e-3) - row(1e-3)) / 2e-3, row(0.0))
}

fn below(x: f64) -> f64 {
    0.5 * (1.0 + libm::erf(x / 2f64.sqrt()))
}

/// Light in the rows of the middle column against `law` of the distance along the motion, in light per mm.
fn profile(scene: &Scene, z: f64, slack: f64, law: &dyn Fn(f64, f64) -> f64) {
    let (sensor, columns) = light(scene, plate(white(), z as f32, 0.0, 0.0), 0);
    let (rate, centre) = rows(&sensor, z);
    let lens = f64::from(sensor.camera().lens_variance()).sqrt() / rate;
    let middle = &columns[scene.size.columns / 2];
    let all = sum(middle);
    let most = middle.iter().map(|(_, e)| *e).fold(0.0, f64::max) / all;
    for (row, electrons) in middle {
        let y = (centre - f64::from(*row)) / rate;
        let expected = law(y, lens) / rate;
        let off = electrons / all - expected;
        assert!(off.abs() < slack * most, "row {row}, {y:.3} mm: {} for {expected}", electrons / all);
    }
}

#[test]
fn a_slit_is_even_with_edges_as_the_lens_blurs_them() {
    for width in [0.1, 0.5, 2.0] {
        let mut scene = scene(1);
        (scene.line.shape, scene.bench.laser.line_width_mm) = (LineShape::Slit, width);
        for z in [0.0, 40.0] {
            // The shadow of its edges grows with the distance from the source.
            let own = width * (1.0 - z / scene.bench.laser.fan_height_mm);
            let law = |y: f64, s: f64| (below((y + 0.5 * own) / s) - below((y - 0.5 * own) / s)) / own;
            profile(&scene, z, 4e-3, &law);
        }
    }
}

#[test]
fn the_projector_throws_the_line_of_the_thesis() {
    let mut scene = scene(1);
    scene.line.shape = LineShape::Texture;
    scene.bench.laser.texture_width_mm = 6.1 / 4.0;
    let pixel = scene.bench.laser.texture_width_mm / 61.0;
    // A box of three pixels under a Gaussian of five; the picture's own pixels are boxes too.
    let law = |y: f64, s: f64| {
        let sigma = (25.0 * pixel * pixel + s * s + pixel * pixel / 12.0).sqrt();
        (below((y + 1.5 * pixel) / sigma) - below((y - 1.5 * pixel) / sigma)) / (3.0 * pixel)
    };
    profile(&scene, 0.0, 4e-3, &law);
}

/// Lobes stand where they are asked for and hold their share; the halo follows its law as the lens blurs it.
#[test]
fn lobes_and_skirt_stand_beside_the_line() {
    let mut scene = scene(1);
    let laser = &mut scene.bench.laser;
    (laser.waist_height_mm, laser.lobe_share, laser.lobe_pairs, laser.lobe_distance) = (0.0, 0.1, 2.0, 4.0);
    (laser.skirt_share, laser.skirt_width) = (0.1, 6.0);
    let w = laser.waist_mm;
    let gauss = |d: f64, v: f64| (-0.5 * d * d / v).exp() / (2.0 * PI * v).sqrt();
    let law = |y: f64, s: f64| {
        let v = 0.25 * w * w + s * s;
        let pair = |i: f64| gauss(y - 4.0 * w * i, v) + gauss(y + 4.0 * w * i, v);
        let a = 6.0 * w / 1.532_841_9;
        let step = 0.1 * s;
        let halo: f64 = (-60..=60)
            .map(|i| {
                let d = f64::from(i) * step;
                step * gauss(d, s * s) * 0.5 / a * (1.0 + ((y - d) / a).powi(2)).powf(-1.5)
            })
            .sum();
        0.8 * gauss(y, v) + 0.04 * pair(1.0) + 0.01 * pair(2.0) + 0.1 * halo
    };
    profile(&scene, 0.0, 2e-3, &law);
}
