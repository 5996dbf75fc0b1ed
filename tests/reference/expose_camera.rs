//! Exposure against the reference for lenses and sensors that are not ideal.

use crate::rays::eye::Eye;
use crate::rays::scenes::{Trial, matte, plane, scene};
use base::Body;
use optical_bench::settings::{LensModel, Scheimpflug};
use procedural::flat::Flat;
use recipe::Scene;
use scanner::optics::camera::rig;

/// A level plate.
fn plate<'a>(name: &'a str, scene: &'a Scene, height: f64, first_col: usize) -> Trial<'a> {
    let medium = matte(0.6);
    let flat = Flat { height_mm: height as f32, slope_x: 0.0, slope_y: 0.0, width_mm: 400.0, length_mm: 400.0, medium };
    Trial {
        name,
        scene,
        body: Body::new(flat),
        profile: 200,
        facets: plane(height, [0.0; 2], 0.6),
        heights: [height; 2],
        first_col,
        cols: 64,
        rays: 2_000_000,
    }
}

/// The plane of sharp focus of a solved sensor, found by imaging two points, is the laser plane: its tilt is the
/// rule's.
#[test]
fn the_references_sensor_is_tilted_by_scheimpflugs_rule() {
    let scene = scene(2560);
    let eye = Eye::new(&scene.bench, 2560, 832);
    let rig = rig(&scene.bench, &scene.size);
    assert!((eye.tilt() - rig.sensor_tilt).abs() < 1e-9, "{} {}", eye.tilt(), rig.sensor_tilt);
    // Marginal rays of any point of the laser plane meet the chief ray on the sensor.
    let mut bench = scene.bench;
    bench.camera.blur_um = 0.0;
    let (sharp, mut chance) = (Eye::new(&bench, 2560, 832), crate::rays::Chance::new(1));
    for (x, z) in [(0.0, 40.0), (100.0, -20.0), (-60.0, 10.0)] {
        let at = glam::DVec3::new(x, 0.0, z);
        let chief = sharp.chief(at);
        for _ in 0..20 {
            let aperture = sharp.aperture(&mut chance);
            let [col, row] = sharp.image(at, aperture, &mut chance).expect("the point lies before the lens");
            assert!((col - chief[0]).abs() < 1e-9 && (row - chief[1]).abs() < 1e-9, "{col} {row} {chief:?}");
        }
    }
}

/// No adapter: the sensor stands straight, and a plate 20 mm above the plane of focus is out of it.
#[test]
fn a_straight_sensor_out_of_focus() {
    let mut scene = scene(256);
    scene.bench.optics.scheimpflug = Scheimpflug::Given;
    plate("straight sensor, 10 mm high", &scene, 10.0, 96).compare().hold(|_| true);
    plate("straight sensor, 25 mm high", &scene, 25.0, 96).compare().hold(|_| true);
}

/// The same through a hole is sharp.
#[test]
fn a_pinhole() {
    let mut scene = scene(256);
    scene.bench.optics.scheimpflug = Scheimpflug::Given;
    scene.bench.optics.lens = LensModel::Pinhole;
    plate("straight sensor, pinhole", &scene, 25.0, 96).compare().hold(|_| true);
}

/// Barrel distortion with some of every other coefficient, at the end of the sensor; and a region off the axis.
#[test]
fn a_bent_lens() {
    let mut scene = scene(2560);
    let camera = &mut scene.bench.camera;
    (camera.distortion_k1, camera.distortion_k2, camera.distortion_k3) = (-0.2, 0.3, -0.4);
    (camera.distortion_p1, camera.distortion_p2) = (0.002, -0.003);
    (scene.bench.optics.offset_columns, scene.bench.optics.offset_rows) = (40.0, -70.0);
    plate("distortion, x = 100 mm", &scene, 15.0, 2432).compare().hold(|_| true);
    plate("distortion, x = -110 mm", &scene, 40.0, 64).compare().hold(|_| true);
}

/// Diffraction with all of Airy's rings, where production has a normal law for the core: light and line stay, and
/// bright pixels are brighter by no more than docs/theory/instrument/reference.md says.
#[test]
fn diffraction() {
    let mut scene = scene(256);
    scene.bench.optics.diffraction = true;
    let found = plate("diffraction, f/2.8", &scene, 20.0, 96).compare().find(|_| true);
    println!("{found:?}");
    assert!(found.total[0].abs() < 0.01, "all light is {:.4} off", found.total[0]);
    assert!(found.shift[2] < 1.0 / 16.0, "the line is {:.4} rows off (rms)", found.shift[2]);
    assert!((0.0..0.04).contains(&found.bright), "bright pixels are {:.4} off", found.bright);
}
