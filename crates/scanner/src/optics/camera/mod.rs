//! Camera: where a point of the lit line is imaged, how sharp and how bright.
//!
//! Radiometry: a mm of the line carries what `Laser` says; a Lambertian patch sends the share Omega cos(theta) / pi
//! of it into the lens, Omega = pi (D / 2)^2 cos(phi) / distance^2. Photon energy h c / lambda.
//! docs/theory/instrument.md holds the derivation. A point's spread adds variances: of the lens's aberrations, of
//! diffraction (Airy's core as a Gaussian of 0.42 lambda N', N' = N v0 / f, Zhang, Zerubia and Olivo-Marin 2007).
//! Others are those of crosstalk (2 x in either direction for a share x to each neighbour), of the pixel's box, and of
//! defocus (`defocus`). Neglected: the rings of Airy's disc, 16 % of its light, none brighter than 1.8 % of its middle.

pub(crate) mod circle_of_confusion;
mod defocus;
mod projection;
mod slant;
mod vignetting;

use base::Stream;
use glam::Vec3;

use self::defocus::Defocus;
pub(crate) use self::projection::PIXEL_VARIANCE;
use self::projection::Projection;
use self::slant::Slant;
use self::vignetting::Vignetting;
use crate::frame::Rig;
use crate::optics::laser::Laser;
use optical_bench::lens::{DistortedDirection, Distortion, image_distance, scheimpflug};
use optical_bench::parameters::Bench;
use optical_bench::settings::{LaserLine, LensModel, Scheimpflug, Size};

/// Planck's constant times the speed of light [J m].
const PLANCK_TIMES_LIGHT_SPEED: f64 = 1.986_445_86e-25;
/// Standard deviation of the Gaussian that stands for the core of Airy's disc, in units of lambda N' [1].
const AIRY_SIGMA: f64 = 0.42;

/// The camera over the laser plane, with everything that does not change during a scan.
#[derive(Debug, Clone)]
pub struct Camera {
    /// Its geometry.
    pub rig: Rig,
    /// The laser.
    pub laser: Laser,
    /// Electrons of all light of the laser's first line on a white Lambertian surface, seen at right angles from 1 mm
    /// [e-].
    electrons: f32,
    /// Position of the lens [mm].
    lens: Vec3,
    /// Unit vector along the optical axis, away from the lens.
    axis: Vec3,
    /// Variance of the lens's point spread along rows or columns [px^2].
    pub blur_variance: f32,
    projection: Projection,
    /// Distortion of the lens; `None` without.
    distortion: Option<Distortion>,
    defocus: Defocus,
    /// Whether points of the laser plane can be out of focus.
    blurs: bool,
    /// Whether the lens is a thin lens, and not a pinhole.
    thin: bool,
    /// Loss by the lens's mounts and by the filter; `None` where there is none.
    field: Option<Vignetting>,
    /// Electrons of ambient light that a pixel on the axis sees of a white surface [e-].
    ambient: f32,
}

/// Image of a point, and the local scale of the image.
struct PointImage {
    /// Row [px].
    row: f32,
    /// Rows per mm along the motion [px/mm].
    rows_per_mm: f32,
    /// Width of a column along the line [mm].
    pixel_mm: f32,
}

/// Image of the laser line at one lit point.
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
    /// Unit of the laser's `laser::LineProfile` along the rows [px].
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
    /// The camera of a bench under a laser of the kind `line`; `stream` belongs to the sample, `own` to the instrument.
    pub fn new(bench: &Bench, size: &Size, line: &LaserLine, stream: Stream, own: Stream) -> Self {
        let rig = rig(bench, size);
        let (camera, laser, exposure) = (&bench.camera, &bench.laser, &bench.exposure);
        let photon = PLANCK_TIMES_LIGHT_SPEED / (laser.wavelength_nm * 1e-9);
        let pupil = 0.5 * camera.focal_length_mm / camera.f_number;
        let first = if laser.second_line_mm == 0.0 { 1.0 } else { 1.0 - laser.second_line_share };
        let electrons = first * laser.power_mw * 1e-3 * exposure.time_us * 1e-6 / photon
            * exposure.quantum_efficiency
            * camera.transmission
            * pupil
            * pupil
            * (1.0 - camera.glare_share);
        let v0 = rig.image_distance;
        let beta = rig.sensor_tilt;
        let (sin, cos) = libm::sincos(rig.tilt);
        let airy = AIRY_SIGMA * laser.wavelength_nm * 1e-3 * camera.f_number * v0 / rig.focal_length;
        let blur_um2 = camera.blur_um.powi(2) + if bench.optics.diffraction { airy * airy } else { 0.0 };
        let blur = blur_um2 / camera.pixel_um.powi(2) + 2.0 * camera.crosstalk;
        let row_mm = rig.distance * libm::cos(beta) * rig.pixel / (v0 * cos);
        let lens_mm = (blur + f64::from(PIXEL_VARIANCE)).sqrt() * row_mm;
        let defocus = Defocus {
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
            / (PLANCK_TIMES_LIGHT_SPEED / (middle * 1e-9))
            * exposure.quantum_efficiency
            * camera.transmission;
        Self {
            rig,
            laser: Laser::new(laser, line, lens_mm, stream, own),
            electrons: electrons as f32,
            lens: Vec3::new(0.0, (-rig.distance * sin) as f32, (rig.distance * cos) as f32),
            axis: Vec3::new(0.0, sin as f32, -cos as f32),
            blur_variance: blur as f32,
            projection: Projection {
                scale: (v0 / (libm::cos(beta) * rig.pixel)) as f32,
                sin: sin as f32,
                cos: cos as f32,
                tan_beta: libm::tan(beta) as f32,
                distance: rig.distance as f32,
            },
            distortion: (!rig.distortion.is_none()).then_some(rig.distortion),
            defocus,
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

    /// Variance along the line of light spread by a standard deviation of `mm` at the origin, with the sharp lens's
    /// [px^2].
    pub(crate) fn along_variance(&self, mm: f32) -> f32 {
        let rig = &self.rig;
        let sigma = f64::from(mm) * rig.image_distance / (rig.pixel * rig.distance);
        (sigma * sigma) as f32 + self.blur_variance
    }

    /// Image of the line at `x`, `z` of the laser plane, on a surface that rises by `slope_y` along the motion.
    #[inline]
    pub fn sight(&self, x: f32, z: f32, slope_y: f32) -> Sight {
        self.sight_on(x, z, [0.0, slope_y])
    }

    /// The same on a surface that rises by the `slope` along the line and along the motion.
    #[inline]
    pub(crate) fn sight_on(&self, x: f32, z: f32, slope: [f32; 2]) -> Sight {
        let slope_y = slope[1];
        let Projection { sin, cos, tan_beta, distance, .. } = self.projection;
        let (yc, zc) = (z * sin, distance - z * cos);
        let PointImage { row, rows_per_mm, pixel_mm } =
            self.point_image(x, [yc, zc], [cos + slope_y * sin, sin - slope_y * cos]);
        let rows_per_mm = rows_per_mm.max(1e-3);
        let slant = Slant::new(&self.projection, &self.laser, [x, z], slope, pixel_mm);
        let rows_per_mm = rows_per_mm * (1.0 + slant.rate / rows_per_mm).clamp(0.5, 2.0);
        let [defocus, defocus_rows] =
            if self.blurs { self.defocus.variances(zc, zc / (zc - tan_beta * yc)) } else { [0.0; 2] };

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

    /// Whether points of the laser plane can be out of focus.
    pub fn blurs(&self) -> bool {
        self.blurs
    }

    /// Diameter of the circle of confusion of a thin lens for a point at `y` from the laser plane and height `z` [mm].
    pub fn circle_of_confusion(&self, y: f32, z: f32) -> f32 {
        let [zc, bottom] = self.projection.depth(y, z);
        self.defocus.circle_of_confusion(zc, zc / bottom)
    }

    /// Variances of defocus along columns and along rows at `y` from the laser plane and height `z` [px^2].
    pub(crate) fn defocus(&self, y: f32, z: f32) -> [f32; 2] {
        let [zc, bottom] = self.projection.depth(y, z);
        if self.blurs { self.defocus.variances(zc, zc / bottom) } else { [0.0; 2] }
    }

    /// Variance of a thin lens's defocus along rows at `y` from the laser plane and height `z`, whatever the tilt of
    /// the sensor [px^2].
    pub(crate) fn off_plane_defocus(&self, y: f32, z: f32) -> f32 {
        let [zc, bottom] = self.projection.depth(y, z);
        if self.thin { self.defocus.variances(zc, zc / bottom)[1] } else { 0.0 }
    }

    /// How far a column's line of sight leans along the line over a level surface, dx/dy [1].
    pub(crate) fn sightline_lean(&self, x: f32, z: f32) -> f32 {
        let Projection { sin, cos, tan_beta, .. } = self.projection;
        x * (sin - tan_beta * cos) / self.projection.depth(0.0, z)[1]
    }

    /// Electrons of ambient light in a pixel that sees a white surface at `x`, `z` of the laser plane [e-].
    pub fn ambient(&self, x: f32, z: f32) -> f32 {
        if self.ambient == 0.0 {
            return 0.0;
        }
        let [zc, bottom] = self.projection.depth(0.0, z);
        let yc = z * self.projection.sin;
        let (tangent2, squeeze) = ((x * x + yc * yc) / (zc * zc), bottom / zc);
        let cos2 = 1.0 / (1.0 + tangent2);
        let mounts = self.field.as_ref().map_or(1.0, |field| field.mounts(tangent2));
        self.ambient * mounts * cos2 * cos2 * squeeze * squeeze * squeeze
    }

    /// Whether there is ambient light.
    pub(crate) fn has_ambient(&self) -> bool {
        self.ambient > 0.0
    }

    /// Sensor column and row of a point in space, y from the laser plane [px].
    #[inline]
    pub fn project(&self, x: f32, y: f32, z: f32) -> [f32; 2] {
        if self.distortion.is_some() {
            let (col, row) = self.rig.project(f64::from(x), f64::from(y), f64::from(z));
            return [col as f32, row as f32];
        }
        let Projection { scale, sin, cos, tan_beta, distance } = self.projection;
        let (yc, zc) = (y * cos + z * sin, distance + y * sin - z * cos);
        let bottom = zc - tan_beta * yc;
        let along = scale * self.defocus.upright * x / bottom;
        [self.rig.centre_col as f32 + along, self.rig.centre_row as f32 - scale * yc / bottom]
    }

    /// Image of a point whose coordinates in the lens's frame change by `dyc`, `dzc` with the motion.
    #[inline]
    fn point_image(&self, x: f32, [yc, zc]: [f32; 2], [dyc, dzc]: [f32; 2]) -> PointImage {
        let Projection { scale, tan_beta, .. } = self.projection;
        let bottom = zc - tan_beta * yc;
        let Some(distortion) = &self.distortion else {
            let rate = scale * (dyc * bottom - yc * (dzc - tan_beta * dyc)) / (bottom * bottom);
            return PointImage {
                row: self.rig.centre_row as f32 - scale * yc / bottom,
                rows_per_mm: rate,
                pixel_mm: self.rig.pixel as f32 * bottom / self.rig.image_distance as f32,
            };
        };
        let [x, yc, zc, dyc, dzc] = [x, yc, zc, dyc, dzc].map(f64::from);
        let (xn, yn) = (x / zc, yc / zc);
        let DistortedDirection { direction: [xd, yd], slopes: [a, b, c] } = distortion.distort(xn, yn);
        let rate = b * (-xn * dzc / zc) + c * (dyc - yn * dzc) / zc;
        let (scale, lean) = (f64::from(scale), f64::from(tan_beta));
        let flat = 1.0 - lean * yd;
        let column = self.rig.image_distance / self.rig.pixel * (a * flat + xd * lean * b) / (flat * flat);
        PointImage {
            row: (self.rig.centre_row - scale * yd / flat) as f32,
            rows_per_mm: (scale * rate / (flat * flat)) as f32,
            pixel_mm: (zc / column) as f32,
        }
    }
}

/// Geometry of rig and sensor for a bench.
pub fn rig(bench: &Bench, size: &Size) -> Rig {
    let camera = &bench.camera;
    let (f, tilt) = (camera.focal_length_mm, camera.tilt_deg.to_radians());
    let (sharp, sensor_tilt) = match bench.optics.scheimpflug {
        Scheimpflug::Solved => (camera.distance_mm, scheimpflug(f, camera.distance_mm, tilt)),
        Scheimpflug::Given => (camera.focus_distance_mm, camera.sensor_tilt_deg.to_radians()),
    };
    Rig {
        distance: camera.distance_mm,
        tilt,
        focal_length: f,
        image_distance: image_distance(f, sharp),
        sensor_tilt,
        distortion: Distortion {
            radial: [camera.distortion_k1, camera.distortion_k2, camera.distortion_k3],
            tangential: [camera.distortion_p1, camera.distortion_p2],
        },
        pixel: camera.pixel_um * 1e-3,
        centre_col: 0.5 * (size.columns as f64 - 1.0) - bench.optics.offset_columns,
        centre_row: 0.5 * (size.rows as f64 - 1.0) - bench.optics.offset_rows,
    }
}

#[cfg(test)]
mod tests;
