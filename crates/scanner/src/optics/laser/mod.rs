//! Laser: power and direction of the light sheet at a point, and its profile across the line.
//!
//! A sheet of light from one virtual source at height H over the conveyor, in the plane y = 0. At (x, z) its tangent is
//! t = x / h, h = H - z, and the distance to the source rho = sqrt(x^2 + h^2). Irradiance of a surface element with the
//! normal N (docs/theory/instrument/laser.md):
//!
//! ```text
//! E = P p(theta) / rho * S(y; rho) * |N.s|,    integral p dtheta = 1,    integral S dy = 1
//! ```
//!
//! so a strip of the width dx along the line and any length along the motion gets P q(t) / h (1 + t dz/dx) dx, with q =
//! p cos^2(theta), whatever the slope along the motion ([`Beam::per_mm`] and `Laser::slope_factor`). Across the sheet
//! stands a Gaussian beam (Siegman 1986), w(rho) = w0 sqrt(1 + ((rho - rho0) / zR)^2), zR = pi w0^2 / (M^2 lambda), its
//! waist at rho0 below the source; or what `LineProfile` makes of the other shapes.
//!
//! Valid for thin sheets under the paraxial law of beams. Neglected: diffraction at the edges of slits and in textures,
//! the beam's curvature, polarisation, what the window of a laser adds.

mod dust;
mod fan;
mod line_profile;
mod point_laser;
pub(crate) mod segment_process;
mod texture;
mod width_jitter;

use base::Stream;
use glam::Vec3;

use self::dust::DustShadows;
use self::fan::FanProfile;
use self::texture::LineTexture;
use self::width_jitter::WidthJitter;
use optical_bench::parameters::LaserParameters;
use optical_bench::settings::{LaserLine, LineShape};

pub(crate) use self::line_profile::{LineProfile, SKIRT_COMPONENTS};
pub(crate) use self::point_laser::PointLaser;

/// Gaussian beam across the sheet.
#[derive(Debug, Clone, Copy)]
struct Waist {
    /// Half width at 1/e^2 in the waist [mm].
    radius: f32,
    /// From the source to the waist [mm].
    distance: f32,
    /// Rayleigh length [mm].
    rayleigh: f32,
}

/// The laser of one sample.
#[derive(Debug, Clone)]
pub struct Laser {
    /// Height of the source over the conveyor [mm].
    height: f32,
    /// Tangent of half the fan's angle [1].
    half: f32,
    fan: FanProfile,
    shape: LineShape,
    waist: Waist,
    /// Width of a slit at the conveyor [mm].
    slit: f32,
    /// Quadratic bow of the line at the ends of the fan, at the conveyor [mm].
    smile: f32,
    /// Cubic bow of the line, likewise [mm].
    cubic_smile: f32,
    dust: Option<DustShadows>,
    jitter: Option<WidthJitter>,
    line_profile: Option<LineProfile>,
    point: Option<PointLaser>,
}

/// The light sheet at one point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Beam {
    /// Share of the laser's power on a mm of a surface that is level along the line [1/mm]; 1 for a point laser, whose
    /// light `Laser::spot_light` gives.
    pub per_mm: f32,
    /// Unit vector of the light.
    pub light: Vec3,
    /// Unit of the line profile: the standard deviation of a Gaussian, the width of a slit, a mm of a texture [mm].
    pub unit: f32,
    /// Standard deviation across the line, lobes and skirt let aside [mm].
    pub sigma: f32,
    /// Distance of the line's centre from the plane y = 0 [mm].
    pub bow: f32,
}

/// Light of a point laser in one column.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SpotLight {
    /// Share of the laser's power [1].
    pub share: f32,
    /// Distance along the line of the column's middle from the spot's [mm].
    pub off: f32,
}

impl Laser {
    /// The laser of a bench whose lens and pixel blur light by `lens_mm` on the object; `stream` belongs to the sample,
    /// `own` to the instrument.
    pub fn new(bench: &LaserParameters, line: &LaserLine, lens_mm: f64, stream: Stream, own: Stream) -> Self {
        let stream = stream.child("laser");
        let height = bench.fan_height_mm;
        let rayleigh = std::f64::consts::PI * bench.waist_mm.powi(2) / (bench.m_squared * bench.wavelength_nm * 1e-6);
        let image = || line.picture.as_ref().map_or_else(LineTexture::thesis_projector, LineTexture::new);
        let image = (line.shape == LineShape::Texture).then(image);
        let half = match &image {
            Some(_) => 0.5 * bench.texture_length_mm / height,
            None => libm::tan((0.5 * bench.fan_angle_deg).to_radians()),
        };
        Self {
            height: height as f32,
            half: half as f32,
            fan: FanProfile::new(bench, line, half, image.as_ref(), stream.child("ripple")),
            shape: line.shape,
            waist: Waist {
                radius: bench.waist_mm as f32,
                distance: (height - bench.waist_height_mm) as f32,
                rayleigh: rayleigh as f32,
            },
            slit: bench.line_width_mm as f32,
            smile: bench.smile_um as f32 * 1e-3,
            cubic_smile: bench.smile_cubic_um as f32 * 1e-3,
            dust: DustShadows::new(bench, half, own.child("dust")),
            jitter: WidthJitter::new(bench, half * height, stream.child("width_jitter")),
            line_profile: LineProfile::new(bench, line.shape, image.as_ref(), lens_mm),
            point: (line.shape == LineShape::Point).then(|| PointLaser::new(bench)),
        }
    }

    /// The sheet at `x`, `z` [mm].
    #[inline]
    pub fn at(&self, x: f32, z: f32) -> Beam {
        let depth = (self.height - z).max(1.0);
        let t = x / depth;
        let ray = Vec3::new(x, 0.0, -depth);
        let rho = ray.length();
        let near = depth / self.height;
        let mut unit = match self.shape {
            LineShape::Gaussian | LineShape::Point => {
                let defocus = (rho - self.waist.distance) / self.waist.rayleigh;
                0.5 * self.waist.radius * (1.0 + defocus * defocus).sqrt()
            }
            LineShape::Slit => self.slit * near,
            LineShape::Texture => near,
        };
        if let Some(jitter) = &self.jitter {
            unit *= jitter.at(t * self.height);
        }
        let sigma = unit * self.line_profile.as_ref().map_or(1.0, |line_profile| line_profile.core.sqrt());
        let side = t / self.half;
        let bow = (self.smile + self.cubic_smile * side) * side * side * near;
        let mut per_mm = if self.point.is_some() { 1.0 } else { self.fan.at(t) / depth };
        if let Some(dust) = &self.dust {
            per_mm *= dust.at(t);
        }
        Beam { per_mm, light: ray / rho, unit, sigma, bow }
    }

    /// Light on a surface that rises by `slope_x` along the line over that on a level one; 0 where it turns away [1].
    #[inline]
    pub(crate) fn slope_factor(&self, x: f32, z: f32, slope_x: f32) -> f32 {
        (1.0 + slope_x * x / (self.height - z).max(1.0)).max(0.0)
    }

    /// Profile across the line where it is more than one Gaussian.
    pub(crate) fn line_profile(&self) -> Option<&LineProfile> {
        self.line_profile.as_ref()
    }

    /// Whether `x`, `z` lies between the ends of the fan: half of the even light of a Powell lens, 1/e^2 behind a
    /// cylindrical one, the edges of a texture. A point laser has no fan [mm].
    pub fn fan_reaches(&self, x: f32, z: f32) -> bool {
        self.is_point() || x.abs() <= self.half * (self.height - z).max(1.0)
    }

    /// Whether it is a point laser.
    pub(crate) fn is_point(&self) -> bool {
        self.point.is_some()
    }

    /// Light of a point laser in a column `width` wide that looks at `x`, `z` in a profile; `None` for a line.
    pub(crate) fn spot_light(&self, profile: isize, x: f32, z: f32, width: f32) -> Option<SpotLight> {
        let spot = self.point.as_ref()?;
        let near = (self.height - z).max(1.0) / self.height;
        let off = x - spot.x(profile) as f32 * near;
        let beam = self.at(x, z);
        // A pencil that comes in at a slant lights more of the line.
        Some(SpotLight { share: spot.share(off, beam.sigma / -beam.light.z, width), off })
    }

    /// Position along the nodes of the line profile [1].
    #[inline]
    pub(crate) fn profile_node(&self, x: f32, z: f32) -> f32 {
        let side = x / (self.height - z).max(1.0) / self.half;
        (0.5 + 0.5 * side) * self.line_profile.as_ref().map_or(1.0, |line_profile| line_profile.nodes as f32) - 0.5
    }
}
