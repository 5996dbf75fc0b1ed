//! Exposure against a slow reference that follows rays: planes, steps, and a laser far out of its waist.

use crate::rays::object::Facet;
use crate::rays::scenes::{Trial, box_of, matte, plane, scene};
use base::{Body, Class};
use procedural::flat::Flat;
use procedural::strips::{Strip, Strips};
use recipe::Scene;

const GREY: f32 = 0.6;
/// Columns judged.
const COLS: usize = 64;
const RAYS: usize = 2_000_000;

/// A plate of height and slopes, cut at profile 200.
fn plate<'a>(name: &'a str, scene: &'a Scene, height_mm: f32, slope: [f32; 2], first_col: usize) -> Trial<'a> {
    let [slope_x, slope_y] = slope;
    let flat = Flat { height_mm, slope_x, slope_y, width_mm: 400.0, length_mm: 400.0, medium: matte(GREY) };
    let exact = slope.map(f64::from);
    // Heights over the columns judged, whose x is near that of a level plate.
    let x = (first_col as f64 - 0.5 * scene.size.columns as f64) * 0.09;
    let y = 200.0 * scene.bench.motion.step_mm;
    let middle = f64::from(height_mm) + exact[0] * x + exact[1] * y;
    let span = exact[0].abs() * 12.0;
    Trial {
        name,
        scene,
        body: Body::new(flat),
        profile: 200,
        facets: plane(f64::from(height_mm), exact, f64::from(GREY)),
        heights: [middle - span, middle + span],
        first_col,
        cols: COLS,
        rays: RAYS,
    }
}

/// In the middle of the sensor.
#[test]
fn a_level_plate() {
    let scene = scene(256);
    plate("level", &scene, 20.0, [0.0; 2], 96).compare().hold(|_| true);
}

/// At the end of the sensor, where fan and view are oblique.
#[test]
fn a_level_plate_aside() {
    let scene = scene(2560);
    plate("level, x = 105 mm", &scene, 20.0, [0.0; 2], 2432).compare().hold(|_| true);
}

/// Rises along the line, in the middle and at the end of the sensor.
#[test]
fn a_plate_tilted_along_the_line() {
    let near = scene(256);
    plate("tilted along x by 0.3", &near, 20.0, [0.3, 0.0], 96).compare().hold(|_| true);
    let mut far = scene(2560);
    far.bench.laser.fan_height_mm = 250.0;
    far.bench.laser.fan_angle_deg = 60.0;
    plate("tilted along x by 0.2, x = 105 mm, fan from 250 mm", &far, 0.0, [0.2, 0.0], 2432).compare().hold(|_| true);
}

/// Rises along the motion, towards the lens and away from it.
#[test]
fn a_plate_tilted_along_the_motion() {
    let scene = scene(256);
    plate("tilted along y by 0.3", &scene, 15.0, [0.0, 0.3], 96).compare().hold(|_| true);
    plate("tilted along y by -0.5", &scene, 25.0, [0.0, -0.5], 96).compare().hold(|_| true);
}

/// The laser 90 mm out of its waist, three Rayleigh lengths.
#[test]
fn a_laser_out_of_its_waist() {
    let mut scene = scene(256);
    scene.bench.laser.waist_height_mm = -80.0;
    plate("waist 100 mm below", &scene, 20.0, [0.0; 2], 96).compare().hold(|_| true);
}

/// Strips of several heights and shades with upright black walls.
#[test]
fn steps() {
    let scene = scene(256);
    let strips = [(100.0, 0.0, 0.7), (2.0, 3.0, 0.5), (2.5, 8.0, 0.9), (3.0, 1.0, 0.3), (100.5, 12.0, 0.6)];
    let strip = |&(width_mm, sunk_mm, share): &(f32, f32, f32)| Strip {
        width_mm,
        sunk_mm,
        medium: matte(share),
        class: Class::Clear,
    };
    let body = Strips { height_mm: 20.0, length_mm: 400.0, strips: strips.iter().map(strip).collect() };
    let mut facets: Vec<Facet> = Vec::new();
    let (mut x, mut walls) = (-104.0, Vec::new());
    for (width, sunk, share) in strips.map(|(w, s, m)| (f64::from(w), f64::from(s), f64::from(m))) {
        facets.extend(box_of([x, x + width], [0.0, 400.0], [0.0, 20.0 - sunk], share));
        x += width;
        walls.push(x);
    }
    let trial = Trial {
        name: "steps of 3 to 12 mm",
        scene: &scene,
        body: Body::new(body),
        profile: 200,
        facets,
        heights: [8.0, 20.0],
        first_col: 78,
        cols: 100,
        rays: 3_000_000,
    };
    let verdict = trial.compare();
    // A column at a wall sees both sides of it: light within three standard deviations of the blur counts.
    let calibration = scanner::optics::camera::rig(&scene.bench, &scene.size);
    let near = |col: usize| {
        walls.iter().any(|&x| [8.0, 20.0].iter().any(|&z| (calibration.project(x, 0.0, z).0 - col as f64).abs() < 2.0))
    };
    verdict.hold(|col| !near(col));
}
