//! How much light of which point arrives where on the sensor: radiometry of line and lens, and the local scale.
//!
//! Radiometry: a mm of the line carries what [`Laser`] says; a Lambertian patch sends the share Omega cos(theta) / pi of
//! it into the lens, Omega = pi (D / 2)^2 cos(phi) / distance^2. Photon energy h c / lambda. docs/instrument.md holds the
//! derivation. Neglected: vignetting inside the lens, the filter's change with angle.

use glam::Vec3;
use procedural::Stream;

use super::laser::Laser;
use super::parameters::Bench;
use crate::frame::Rig;
use crate::settings::{Line, Size};

/// Planck's constant times the speed of light [J m].
const HC: f64 = 1.986_445_86e-25;
/// Variance of a box of one pixel [px^2].
const PIXEL_VARIANCE: f32 = 1.0 / 12.0;
/// A surface that rises away from the lens is never seen more stretched along the line than this [1].
const LEAST_SEEN: f32 = 0.1;

/// The camera over the laser plane, with everything that does not change during a scan.
#[derive(Debug, Clone)]
pub struct Camera {
    /// Its geometry.
    pub rig: Rig,
    /// The laser.
    pub laser: Laser,
    /// Electrons of all light of the laser's first line, 1 mm from the lens, for a white Lambertian surface seen straight.
    electrons: f32,
    /// Lens [mm].
    lens: Vec3,
    /// Unit vector from the lens along the axis.
    axis: Vec3,
    /// Variance of the lens's point spread along rows or columns [px^2].
    pub blur_variance: f32,
    /// v0 / (cos(beta) pixel), sin and cos of the tilt, tan(beta), distance: the row as a function of (y, z).
    row: [f32; 5],
    /// cos(beta) [1].
    upright: f32,
}

/// Geometry of rig and sensor for a bench.
pub fn rig(bench: &Bench, size: &Size) -> Rig {
    Rig {
        distance: bench.camera.distance_mm,
        tilt: bench.camera.tilt_deg.to_radians(),
        focal_length: bench.camera.focal_length_mm,
        pixel: bench.camera.pixel_um * 1e-3,
        centre_col: 0.5 * (size.columns as f64 - 1.0),
        centre_row: 0.5 * (size.rows as f64 - 1.0),
    }
}

/// What the camera makes of one lit point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sight {
    /// Row of the line's centre [px].
    pub row: f32,
    /// Rows per mm of surface along the motion; positive, rows fall with y [px/mm].
    pub rows_per_mm: f32,
    /// Variance that laser, lens and pixel give the line [px^2].
    pub variance: f32,
    /// The laser's part of it, without lobes and skirt [px^2].
    pub laser_variance: f32,
    /// Unit of the laser's [`super::laser::Section`] along the rows [px].
    pub unit: f32,
    /// Electrons of the whole line in this column for a white Lambertian surface, level along the line [e-].
    pub electrons: f32,
    /// Width of the column on a level surface [mm].
    pub column_mm: f32,
    /// Unit vector to the lens.
    pub view: Vec3,
    /// Unit vector of the laser light.
    pub light: Vec3,
}

impl Camera {
    /// The camera of a bench under a laser of the kind `line`; `stream` belongs to the sample.
    pub fn new(bench: &Bench, size: &Size, line: Line, stream: Stream) -> Self {
        let rig = rig(bench, size);
        let (camera, laser, exposure) = (&bench.camera, &bench.laser, &bench.exposure);
        let photon = HC / (laser.wavelength_nm * 1e-9);
        let pupil = 0.5 * camera.focal_length_mm / camera.f_number;
        let first = if laser.second_line_mm == 0.0 { 1.0 } else { 1.0 - laser.second_line_share };
        let electrons = first * laser.power_mw * 1e-3 * exposure.time_us * 1e-6 / photon
            * exposure.quantum_efficiency
            * camera.transmission
            * pupil
            * pupil;
        let v0 = rig.focal_length * rig.distance / (rig.distance - rig.focal_length);
        let beta = rig.scheimpflug();
        let (sin, cos) = libm::sincos(rig.tilt);
        let blur_variance = (camera.blur_um / camera.pixel_um).powi(2);
        let row_mm = rig.distance * libm::cos(beta) * rig.pixel / (v0 * cos);
        let lens_mm = (blur_variance + f64::from(PIXEL_VARIANCE)).sqrt() * row_mm;
        Self {
            rig,
            laser: Laser::new(laser, line, lens_mm, stream),
            electrons: electrons as f32,
            lens: Vec3::new(0.0, (-rig.distance * sin) as f32, (rig.distance * cos) as f32),
            axis: Vec3::new(0.0, sin as f32, -cos as f32),
            blur_variance: blur_variance as f32,
            row: [
                (v0 / (libm::cos(beta) * rig.pixel)) as f32,
                sin as f32,
                cos as f32,
                libm::tan(beta) as f32,
                rig.distance as f32,
            ],
            upright: libm::cos(beta) as f32,
        }
    }

    /// Variance that lens and pixel give a point along the rows [px^2].
    pub fn lens_variance(&self) -> f32 {
        self.blur_variance + PIXEL_VARIANCE
    }

    /// Variance along the line of light spread by a standard deviation of `mm`, with the lens's, at the origin [px^2].
    pub fn along_variance(&self, mm: f32) -> f32 {
        let rig = &self.rig;
        let pixel_mm = rig.pixel * (rig.distance - rig.focal_length) / rig.focal_length;
        let sigma = f64::from(mm) / pixel_mm;
        (sigma * sigma) as f32 + self.blur_variance
    }

    /// Sensor column and row of a point in space, y from the laser plane [px].
    #[inline]
    pub fn place(&self, x: f32, y: f32, z: f32) -> [f32; 2] {
        let [scale, sin, cos, tan_beta, distance] = self.row;
        let (yc, zc) = (y * cos + z * sin, distance + y * sin - z * cos);
        let bottom = zc - tan_beta * yc;
        let along = scale * self.upright * x / bottom;
        [self.rig.centre_col as f32 + along, self.rig.centre_row as f32 - scale * yc / bottom]
    }

    /// What becomes of the light at `x`, `z` of the laser plane, on a surface that rises by `slope_y` along the motion.
    #[inline]
    pub fn sight(&self, x: f32, z: f32, slope_y: f32) -> Sight {
        let [scale, sin, cos, tan_beta, distance] = self.row;
        let (yc, zc) = (z * sin, distance - z * cos);
        let (dyc, dzc) = (cos + slope_y * sin, sin - slope_y * cos);
        let bottom = zc - tan_beta * yc;
        let rows_per_mm = (scale * (dyc * bottom - yc * (dzc - tan_beta * dyc)) / (bottom * bottom)).max(1e-3);

        let beam = self.laser.at(x, z);
        let row = self.rig.centre_row as f32 - scale * yc / bottom - beam.bow * rows_per_mm;
        let sigma = beam.sigma * rows_per_mm;
        let laser_variance = sigma * sigma;
        let variance = laser_variance + self.lens_variance();

        let to_lens = self.lens - Vec3::new(x, 0.0, z);
        let far2 = to_lens.length_squared();
        let view = to_lens / far2.sqrt();
        let column_mm =
            self.rig.pixel as f32 * (distance - self.rig.focal_length as f32 - z * cos) / self.rig.focal_length as f32;
        let electrons = self.electrons * beam.per_mm * column_mm * -view.dot(self.axis) / far2;
        let unit = beam.unit * rows_per_mm;
        Sight { row, rows_per_mm, variance, laser_variance, unit, electrons, column_mm, view, light: beam.light }
    }

    /// Light of a column on a surface that rises by `slope_x` along the line over that on a level one: the fan meets it
    /// more or less straight, and the column sees more or less of it. Nearly 1 where laser and lens are equally high [1].
    #[inline]
    pub fn slant(&self, x: f32, z: f32, slope_x: f32) -> f32 {
        let [_, _, cos, _, distance] = self.row;
        let seen = 1.0 + slope_x * x * cos / (distance - self.rig.focal_length as f32 - z * cos);
        self.laser.slant(x, z, slope_x) / seen.max(LEAST_SEEN)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::parameters::{Camera as CameraNumbers, Exposure, Laser, Motion, Speckle};

    fn bench() -> Bench {
        let d = &mut |p: &'static procedural::Parameter| p.default;
        Bench {
            motion: Motion::from_values(d),
            laser: Laser::from_values(d),
            camera: CameraNumbers::from_values(d),
            exposure: Exposure::from_values(d),
            speckle: Speckle::from_values(d),
        }
    }

    fn camera(bench: &Bench) -> Camera {
        Camera::new(bench, &SIZE, Line::PLAIN, Stream::root(0))
    }

    const SIZE: Size = Size { columns: 2560, rows: 832, profiles: 1 };

    /// The numbers of docs/instrument.md for d = 410 mm.
    #[test]
    fn geometry_matches_published_numbers() {
        let rig = rig(&bench(), &SIZE);
        assert!((rig.magnification() - 0.06494).abs() < 1e-5);
        assert!((rig.scheimpflug().to_degrees() - 7.93).abs() < 0.01);
        assert!((rig.along(1280.5, 0.0) - rig.along(1279.5, 0.0) - 0.0924).abs() < 1e-4);
        let centre = rig.centre_row;
        assert!(((rig.height(centre - 0.5) - rig.height(centre + 0.5)) - 0.2166).abs() < 2e-4);
        let sight = camera(&bench()).sight(0.0, 0.0, 0.0);
        assert!((1.0 / sight.rows_per_mm - 0.1010).abs() < 2e-4, "row pitch {}", 1.0 / sight.rows_per_mm);
        // 50 mW over 236 mm, R = 0.7, QE 0.5: 1.83e9 electrons a second and column.
        let mut b = bench();
        b.exposure.quantum_efficiency = 0.5;
        b.exposure.time_us = 50.0;
        b.laser.fan_angle_deg = 2.0 * (118.2f64 / 400.0).atan().to_degrees();
        let sight = camera(&b).sight(0.0, 0.0, 0.0);
        let electrons = sight.electrons * sight.view.z * 0.7;
        assert!((electrons / 91.0e3 - 1.0).abs() < 0.02, "electrons a column {electrons}");
    }

    /// Projection and back-projection undo each other, and `sight` agrees with the exact projection off the plane.
    #[test]
    fn projection_inverts() {
        let camera = camera(&bench());
        for z in [-50.0, -3.0, 0.0, 22.0, 60.0] {
            let (col, row) = camera.rig.project(31.0, 0.0, z);
            assert!((camera.rig.height(row) - z).abs() < 1e-9);
            assert!((camera.rig.along(col, z) - 31.0).abs() < 1e-9);
            let exact = camera.rig.project(31.0, -2.5, z);
            let [along, across] = camera.place(31.0, -2.5, z as f32).map(f64::from);
            assert!((along - exact.0).abs() < 1e-3 && (across - exact.1).abs() < 1e-3, "{along} {across} {exact:?}");
            for slope in [0.0, 0.2] {
                let sight = camera.sight(31.0, z as f32, slope as f32);
                assert!((f64::from(sight.row) - row).abs() < 1e-3);
                let step = 1e-4;
                let (_, ahead) = camera.rig.project(31.0, step, z + slope * step);
                let rate = (row - ahead) / step;
                assert!((f64::from(sight.rows_per_mm) / rate - 1.0).abs() < 1e-3, "{} {rate}", sight.rows_per_mm);
            }
        }
    }
}
