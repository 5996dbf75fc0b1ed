//! Closed forms of laser and camera, after docs/theory/instrument.md.
//!
//! They are written out once more and share no code with `optics` but the projection of a point. Sources: Siegman 1986
//! for the Gaussian beam; the radiometry is derived in docs/theory/instrument.md. Neglected: what the instrument
//! neglects.

use std::f64::consts::PI;

use glam::DVec3;

use numerics::chance::normal_below;
use optical_bench::parameters::Bench;
use optical_bench::settings::Size;
use scanner::optics::camera::rig;

/// Planck's constant times the speed of light [J m].
const HC: f64 = 1.986_445_86e-25;

/// Electrons a column gets from a white Lambertian plane at height `z`, `x` from the middle [e-].
pub fn electrons(bench: &Bench, x: f64, z: f64) -> f64 {
    let (laser, camera, exposure) = (&bench.laser, &bench.camera, &bench.exposure);
    let half = libm::tan(0.5 * laser.fan_angle_deg.to_radians());
    let below = laser.fan_height_mm - z;
    let per_mm = laser.power_mw * 1e-3 / (2.0 * below * half);
    // Even up to soft ends of 2 % of the half fan on either side.
    let end = (0.5 - 0.5 * (x.abs() / (below * half) - 1.0) / 0.02).clamp(0.0, 1.0);
    let (sin, cos) = libm::sincos(camera.tilt_deg.to_radians());
    let lens = camera.distance_mm * DVec3::new(0.0, -sin, cos);
    let way = lens - DVec3::new(x, 0.0, z);
    let (upright, axial) = (way.z / way.length(), way.dot(lens) / (way.length() * lens.length()));
    let width =
        camera.pixel_um * 1e-3 * (camera.distance_mm - camera.focal_length_mm - z * cos) / camera.focal_length_mm;
    let pupil = 0.5 * camera.focal_length_mm / camera.f_number;
    let photons = per_mm * end * width * exposure.time_us * 1e-6 * laser.wavelength_nm * 1e-9 / HC;
    photons * pupil * pupil * axial * upright / way.length_squared() * camera.transmission * exposure.quantum_efficiency
}

/// Half width of the laser at 1/e^2 at height `z` [mm].
pub fn half_width(bench: &Bench, z: f64) -> f64 {
    let laser = &bench.laser;
    let rayleigh = PI * laser.waist_mm * laser.waist_mm / (laser.m_squared * laser.wavelength_nm * 1e-6);
    laser.waist_mm * (1.0 + ((z - laser.waist_height_mm) / rayleigh).powi(2)).sqrt()
}

/// Rows per mm along the motion on a level surface at height `z`, from the exact projection [px/mm].
pub fn rows_per_mm(bench: &Bench, size: &Size, z: f64) -> f64 {
    let rig = rig(bench, size);
    let row = |y: f64| rig.project(0.0, y, z).1;
    (row(-1e-3) - row(1e-3)) / 2e-3
}

/// Variance of the lens's spread of a sharp point, aberrations and the core of Airy's disc (0.42 lambda N') [px^2].
pub fn lens_variance(bench: &Bench, size: &Size) -> f64 {
    let (camera, rig) = (&bench.camera, rig(bench, size));
    let airy = 0.42 * bench.laser.wavelength_nm * 1e-3 * camera.f_number * rig.image_distance / rig.focal_length;
    (camera.blur_um.powi(2) + airy * airy) / camera.pixel_um.powi(2)
}

/// Greatest difference between a Gaussian with the pixel's variance in it and one gathered over the pixel's box, over
/// the peak, in the waist [1].
pub(crate) fn box_error(bench: &Bench) -> f64 {
    let size = Size { columns: 1, rows: 832, profiles: 1 };
    let bare = (0.5 * bench.laser.waist_mm * rows_per_mm(bench, &size, bench.laser.waist_height_mm)).powi(2)
        + lens_variance(bench, &size);
    let below = |x: f64| normal_below(x / bare.sqrt());
    let whole = bare + 1.0 / 12.0;
    let drawn = |x: f64| libm::exp(-0.5 * x * x / whole) / (2.0 * PI * whole).sqrt();
    let off = |i: i32| {
        let x = f64::from(i) * 0.01;
        (drawn(x) - (below(x + 0.5) - below(x - 0.5))).abs()
    };
    (0..500).map(off).fold(0.0, f64::max) / drawn(0.0)
}

/// Height of the laser plane's point seen in a row that lies `up` rows above the middle [mm].
fn height(bench: &Bench, up: f64) -> f64 {
    let CameraGeometry { f, d, sin, cos, beta, pixel } = camera_geometry(bench);
    // Solved from row = c - v Yc / Zc / cos(beta) / pixel with y = 0.
    let s = up * pixel * libm::cos(beta);
    s * (d - f) / (f * sin + s * cos)
}

/// Rows above the sensor's middle in which the laser plane's height `z` is seen [px].
pub(crate) fn row_up(bench: &Bench, z: f64) -> f64 {
    let CameraGeometry { f, d, sin, cos, beta, pixel } = camera_geometry(bench);
    let (yc, zc) = (z * sin, d - z * cos);
    let v = f * d / (d - f) / (1.0 - libm::tan(beta) * yc / zc);
    v * yc / zc / libm::cos(beta) / pixel
}

/// Height that a row stands for at height `z` [mm].
pub(crate) fn height_per_row(bench: &Bench, z: f64) -> f64 {
    let up = row_up(bench, z);
    (height(bench, up + 0.01) - height(bench, up - 0.01)) / 0.02
}

/// Width of a column at height `z` [mm].
pub(crate) fn column_width(bench: &Bench, z: f64) -> f64 {
    let CameraGeometry { f, d, cos, pixel, .. } = camera_geometry(bench);
    pixel * (d - f - z * cos) / f
}

struct CameraGeometry {
    f: f64,
    d: f64,
    sin: f64,
    cos: f64,
    beta: f64,
    pixel: f64,
}

fn camera_geometry(bench: &Bench) -> CameraGeometry {
    let camera = &bench.camera;
    let (f, d) = (camera.focal_length_mm, camera.distance_mm);
    let (sin, cos) = libm::sincos(camera.tilt_deg.to_radians());
    CameraGeometry { f, d, sin, cos, beta: libm::atan(f / (d - f) * cos / sin), pixel: camera.pixel_um * 1e-3 }
}
