//! How much light of which point arrives where on the sensor: radiometry of line and lens, and the local scale.
//!
//! Radiometry: a mm of the line carries what [`Laser`] says; a Lambertian patch sends the share Omega cos(theta) / pi of
//! it into the lens, Omega = pi (D / 2)^2 cos(phi) / distance^2. Photon energy h c / lambda. docs/instrument.md holds the
//! derivation. A point's spread has the variances of the lens's aberrations, of diffraction (Airy's core as a normal law
//! of 0.42 lambda N', N' = N v0 / f, Zhang, Zerubia and Olivo-Marin 2007), of crosstalk (2 x in either direction for a
//! share x to each neighbour), of the pixel's box, and of the disc that lies out of focus (`super::focus`). Neglected:
//! the rings of Airy's disc, 16 % of its light, none brighter than 1.8 % of its middle.

mod image;
mod rig;
mod slant;

use glam::Vec3;
use procedural::Stream;

use self::image::Image;
use super::focus::Focus;
use super::laser::Laser;
use super::parameters::Bench;
use super::vignetting::{self, Vignetting};
use crate::frame::{Distortion, Rig};
use crate::settings::{LensModel, Line, Scheimpflug, Size};

pub use self::rig::rig;

/// Planck's constant times the speed of light [J m].
const HC: f64 = 1.986_445_86e-25;
/// Standard deviation of a normal law that stands for the core of Airy's disc, in units of lambda N' [1].
const AIRY: f64 = 0.42;
/// Variance of a box of one pixel [px^2].
const PIXEL_VARIANCE: f32 = 1.0 / 12.0;

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
    /// Distortion of the lens; `None` without.
    bent: Option<Distortion>,
    focus: Focus,
    /// Whether what is out of focus is blurred, and something can be.
    blurs: bool,
    /// Whether the lens is a thin one.
    thin: bool,
    /// What mounts and filter take; `None` where they take nothing.
    field: Option<Vignetting>,
    /// Electrons of ambient light that a pixel on the axis sees of a white surface [e-].
    ambient: f32,
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
    /// Unit of the laser's [`super::laser::LineProfile`] along the rows [px].
    pub unit: f32,
    /// Variance along the line of a point that is out of focus [px^2].
    pub defocus: f32,
    /// Radius along the rows of the disc that it is blurred to [px].
    pub disc: f32,
    /// Electrons of the whole line in this column for a white Lambertian surface [e-].
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
    pub fn new(bench: &Bench, size: &Size, line: &Line, stream: Stream) -> Self {
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
        let v0 = rig.image_distance;
        let beta = rig.sensor_tilt;
        let (sin, cos) = libm::sincos(rig.tilt);
        let airy = AIRY * laser.wavelength_nm * 1e-3 * camera.f_number * v0 / rig.focal_length;
        let blur_um2 = camera.blur_um.powi(2) + if bench.optics.diffraction { airy * airy } else { 0.0 };
        let blur = blur_um2 / camera.pixel_um.powi(2) + 2.0 * camera.crosstalk;
        let row_mm = rig.distance * libm::cos(beta) * rig.pixel / (v0 * cos);
        let lens_mm = (blur + f64::from(PIXEL_VARIANCE)).sqrt() * row_mm;
        let focus = Focus {
            pupil: (2.0 * pupil) as f32,
            focal_length: rig.focal_length as f32,
            image_distance: v0 as f32,
            upright: libm::cos(beta) as f32,
            pixel: rig.pixel as f32,
        };
        let far = |offset: f64, pixels: usize| (offset.abs() + 0.5 * pixels as f64) * rig.pixel / v0;
        let (across, along) =
            (far(bench.optics.offset_columns, size.columns), far(bench.optics.offset_rows, size.rows));
        let edge = 0.5 * size.columns as f64 * rig.pixel / v0;
        let field = Vignetting::new(bench, edge, (across * across + along * along).sqrt());
        let [middle, band] = vignetting::ambient_band(camera, &bench.optics, laser.wavelength_nm);
        // [W/m^2] of the object times pixel [m^2] times the lens's solid angle over pi.
        let ambient = camera.ambient_w_per_m2_nm
            * band
            * (camera.pixel_um * 1e-6).powi(2)
            * (pupil / v0).powi(2)
            * libm::cos(beta)
            * exposure.time_us
            * 1e-6
            / (HC / (middle * 1e-9))
            * exposure.quantum_efficiency
            * camera.transmission;
        Self {
            rig,
            laser: Laser::new(laser, line, lens_mm, stream),
            electrons: electrons as f32,
            lens: Vec3::new(0.0, (-rig.distance * sin) as f32, (rig.distance * cos) as f32),
            axis: Vec3::new(0.0, sin as f32, -cos as f32),
            blur_variance: blur as f32,
            row: [
                (v0 / (libm::cos(beta) * rig.pixel)) as f32,
                sin as f32,
                cos as f32,
                libm::tan(beta) as f32,
                rig.distance as f32,
            ],
            upright: libm::cos(beta) as f32,
            bent: (!rig.distortion.is_none()).then_some(rig.distortion),
            focus,
            thin: bench.optics.lens == LensModel::ThinLens,
            blurs: bench.optics.lens == LensModel::ThinLens && bench.optics.scheimpflug == Scheimpflug::Given,
            field: (!field.is_open()).then_some(field),
            ambient: ambient as f32,
        }
    }

    /// Variance that lens and pixel give a sharp point along the rows [px^2].
    pub fn lens_variance(&self) -> f32 {
        self.blur_variance + PIXEL_VARIANCE
    }

    /// Variance along the line of light spread by a standard deviation of `mm` at the origin, with the sharp lens's [px^2].
    pub fn along_variance(&self, mm: f32) -> f32 {
        let rig = &self.rig;
        let sigma = f64::from(mm) * rig.image_distance / (rig.pixel * rig.distance);
        (sigma * sigma) as f32 + self.blur_variance
    }

    /// What becomes of the light at `x`, `z` of the laser plane, on a surface that rises by `slope_y` along the motion.
    #[inline]
    pub fn sight(&self, x: f32, z: f32, slope_y: f32) -> Sight {
        self.sight_on(x, z, [0.0, slope_y])
    }

    /// The same on a surface that rises by the `slope` along the line and along the motion.
    #[inline]
    pub fn sight_on(&self, x: f32, z: f32, slope: [f32; 2]) -> Sight {
        let slope_y = slope[1];
        let [_, sin, cos, tan_beta, distance] = self.row;
        let (yc, zc) = (z * sin, distance - z * cos);
        let Image { row, rows_per_mm, pixel_mm } = self.image(x, [yc, zc], [cos + slope_y * sin, sin - slope_y * cos]);
        let rows_per_mm = rows_per_mm.max(1e-3);
        let slant = self.slant(x, z, slope, pixel_mm);
        let rows_per_mm = rows_per_mm * (1.0 + slant.rate / rows_per_mm).clamp(0.5, 2.0);
        let [defocus, defocus_rows] =
            if self.blurs { self.focus.variances(zc, zc / (zc - tan_beta * yc)) } else { [0.0; 2] };

        let beam = self.laser.at(x, z);
        let row = row - beam.bow * rows_per_mm;
        let sigma = beam.sigma * rows_per_mm;
        let laser_variance = sigma * sigma;
        let variance =
            laser_variance + self.lens_variance() + defocus_rows + slant.variance(self.blur_variance + defocus);

        let to_lens = self.lens - Vec3::new(x, 0.0, z);
        let far2 = to_lens.length_squared();
        let view = to_lens / far2.sqrt();
        let passed = self.field.as_ref().map_or(1.0, |field| field.laser((x * x + yc * yc) / (zc * zc)));
        let electrons = self.electrons * beam.per_mm * pixel_mm * -view.dot(self.axis) / far2 * passed * slant.light;
        let unit = beam.unit * rows_per_mm;
        Sight {
            row,
            rows_per_mm,
            variance,
            laser_variance,
            unit,
            defocus,
            disc: 2.0 * defocus_rows.sqrt(),
            electrons,
            column_mm: pixel_mm,
            view,
            light: beam.light,
        }
    }
}

#[cfg(test)]
pub(super) mod tests;
