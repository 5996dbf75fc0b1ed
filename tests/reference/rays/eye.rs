//! The camera: a thin lens over a tilted sensor.
//!
//! A ray from a point of the object through any point of the aperture goes on through the point's image at 1/f = 1/g +
//! 1/b, on the line through the lens's middle. The sensor is a plane through the image of the origin; with nothing else
//! said it goes through the image of another point of the laser plane too (Scheimpflug). The image is taken upright.
//! Distortion (Brown 1971) moves the direction under which a point is seen. Diffraction, where it is on, moves a ray by
//! Airy's law with all of its rings: 1 - J0(v)^2 - J1(v)^2 of the light falls within v = pi r / (lambda N').

use glam::{DVec2, DVec3};
use optical_bench::parameters::Bench;
use optical_bench::settings::{LensModel, Scheimpflug};

use super::Chance;

/// Planck's constant [J s] and the speed of light [m/s].
const PLANCK: f64 = 6.626_070_15e-34;
const LIGHT: f64 = 299_792_458.0;

/// Shares of a point's light whose radii are known.
const AIRY: u32 = 4096;

/// A camera.
#[derive(Debug, Clone)]
pub struct Eye {
    centre: DVec3,
    right: DVec3,
    up: DVec3,
    /// From the lens along the axis.
    pub axis: DVec3,
    focal: f64,
    /// Radius of the aperture [mm].
    pub radius: f64,
    /// Whether every point is imaged where its chief ray goes.
    sharp: bool,
    /// Where the sensor cuts the axis behind the lens [mm].
    depth: f64,
    /// Unit vector on the sensor, towards the image of what lies higher: across (up) and along the axis.
    rise: DVec2,
    pixel: f64,
    middle: [f64; 2],
    /// Standard deviation of the blur on the sensor [mm].
    blur: f64,
    /// k1, k2, k3, p1, p2 [1].
    distortion: [f64; 5],
    /// Radii within which even shares of a point's light fall [mm]; empty without diffraction.
    airy: Vec<f64>,
    pub electrons_per_watt: f64,
}

impl Eye {
    /// The camera of a bench with a sensor of `cols` x `rows` pixels.
    pub fn new(bench: &Bench, cols: usize, rows: usize) -> Self {
        let (camera, exposure) = (&bench.camera, &bench.exposure);
        let (sin, cos) = camera.tilt_deg.to_radians().sin_cos();
        let photon = PLANCK * LIGHT / (bench.laser.wavelength_nm * 1e-9);
        let mut eye = Self {
            centre: camera.distance_mm * DVec3::new(0.0, -sin, cos),
            right: DVec3::X,
            up: DVec3::new(0.0, cos, sin),
            axis: DVec3::new(0.0, sin, -cos),
            focal: camera.focal_length_mm,
            radius: 0.5 * camera.focal_length_mm / camera.f_number,
            sharp: bench.optics.lens == LensModel::Pinhole,
            depth: 0.0,
            rise: DVec2::X,
            pixel: camera.pixel_um * 1e-3,
            middle: [0.5 * (cols as f64 - 1.0), 0.5 * (rows as f64 - 1.0)],
            blur: camera.blur_um * 1e-3,
            distortion: [0.0; 5],
            airy: Vec::new(),
            electrons_per_watt: exposure.time_us * 1e-6 / photon * exposure.quantum_efficiency * camera.transmission,
        };
        let [origin, higher] = [0.0, 10.0].map(|z| eye.behind(DVec3::new(0.0, 0.0, z)));
        eye.depth = origin.z;
        eye.rise = DVec2::new(higher.y - origin.y, higher.z - origin.z).normalize();
        if bench.optics.scheimpflug == Scheimpflug::Given {
            eye.depth = eye.focal * camera.focus_distance_mm / (camera.focus_distance_mm - eye.focal);
            let (sin, cos) = camera.sensor_tilt_deg.to_radians().sin_cos();
            eye.rise = DVec2::new(cos, sin);
        }
        eye.middle[0] -= bench.optics.offset_columns;
        eye.middle[1] -= bench.optics.offset_rows;
        eye.distortion = [
            camera.distortion_k1,
            camera.distortion_k2,
            camera.distortion_k3,
            camera.distortion_p1,
            camera.distortion_p2,
        ];
        if bench.optics.diffraction {
            let scale =
                bench.laser.wavelength_nm * 1e-6 * camera.f_number * eye.depth / eye.focal / std::f64::consts::PI;
            let outside = |v: f64| libm::j0(v).powi(2) + libm::j1(v).powi(2);
            let mut v = 0.0;
            for share in 0..AIRY {
                while 1.0 - outside(v) < f64::from(share) / f64::from(AIRY) {
                    v += 0.002;
                }
                eye.airy.push(scale * v);
            }
        }
        eye
    }

    /// How far the sensor is turned against the lens [rad].
    pub fn tilt(&self) -> f64 {
        self.rise.y.atan2(self.rise.x)
    }

    /// Area of the aperture [mm^2].
    pub fn area(&self) -> f64 {
        std::f64::consts::PI * self.radius * self.radius
    }

    /// A point of the aperture, all alike.
    pub fn aperture(&self, chance: &mut Chance) -> DVec3 {
        let radius = self.radius * chance.uniform().sqrt();
        let (sin, cos) = (std::f64::consts::TAU * chance.uniform()).sin_cos();
        self.centre + radius * (cos * self.right + sin * self.up)
    }

    /// The sharp image behind the lens: across and along the axis, upright [mm].
    fn behind(&self, at: DVec3) -> DVec3 {
        let way = at - self.centre;
        let (x, y, g) = (way.dot(self.right), way.dot(self.up), way.dot(self.axis));
        let b = self.focal * g / (g - self.focal);
        let [x, y] = self.distorted(x / g, y / g);
        DVec3::new(x * b, y * b, b)
    }

    fn distorted(&self, x: f64, y: f64) -> [f64; 2] {
        let [k1, k2, k3, p1, p2] = self.distortion;
        let r2 = x * x + y * y;
        let radial = 1.0 + k1 * r2 + k2 * r2 * r2 + k3 * r2 * r2 * r2;
        [
            x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
            y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y,
        ]
    }

    /// Where light from `at` through the point `aperture` of the lens meets the sensor [px]: column and row.
    pub fn image(&self, at: DVec3, aperture: DVec3, chance: &mut Chance) -> Option<[f64; 2]> {
        let image = self.behind(at);
        let off = if self.sharp { DVec3::ZERO } else { aperture - self.centre };
        // Upright pictures turn the side of the aperture too.
        let start = DVec3::new(-off.dot(self.right), -off.dot(self.up), 0.0);
        let way = image - start;
        // The sensor: (across, along) = (0, depth) + s rise; its normal (-rise.y, rise.x).
        let along = self.rise.x * way.z - self.rise.y * way.y;
        let t = (self.rise.x * (self.depth - start.z) + self.rise.y * start.y) / along;
        if t.is_nan() || t <= 0.0 {
            return None;
        }
        let met = start + way * t;
        let s = met.y * self.rise.x + (met.z - self.depth) * self.rise.y;
        let mut moved = DVec2::from(chance.normals()) * self.blur;
        if !self.airy.is_empty() {
            let share = chance.uniform() * f64::from(AIRY);
            let (ring, part) = (share as usize, share.fract());
            let radius =
                self.airy[ring] + part * (self.airy.get(ring + 1).unwrap_or(&self.airy[ring]) - self.airy[ring]);
            let (sin, cos) = (std::f64::consts::TAU * chance.uniform()).sin_cos();
            moved += radius * DVec2::new(cos, sin);
        }
        let DVec2 { x: dx, y: ds } = moved;
        Some([self.middle[0] + (met.x + dx) / self.pixel, self.middle[1] - (s + ds) / self.pixel])
    }

    /// Where the chief ray from `at` meets the sensor [px].
    pub fn chief(&self, at: DVec3) -> [f64; 2] {
        let sharp = Self { blur: 0.0, airy: Vec::new(), ..self.clone() };
        sharp.image(at, self.centre, &mut Chance::new(0)).expect("the point lies before the lens")
    }
}
