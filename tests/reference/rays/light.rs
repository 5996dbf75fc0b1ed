//! The laser: rays from a virtual source over the line, and the light that each carries.
//!
//! Rays fan out along x from (0, y, height) and stay in planes of one y. A surface that faces the light at the distance
//! rho from the source, y beside the plane, gets the irradiance
//!
//! ```text
//! E = P p(theta) / rho * S(y; theta, rho),     integral p dtheta = 1,  integral S dy = 1
//! ```
//!
//! and every other one E times the cosine, which comes from drawing rays. They are drawn evenly in tan(theta) and from
//! a mixture of normal laws in y; each is weighted by E rho cos^2(theta) over the density of its draw.

use std::f64::consts::PI;

use glam::DVec3;
use optical_bench::parameters::LaserParameters;

use super::Chance;

/// A ray from the laser.
#[derive(Debug, Clone, Copy)]
pub struct Ray {
    pub from: DVec3,
    pub way: DVec3,
    tan: f64,
    y: f64,
    /// One over the density of its draw [mm].
    share: f64,
}

/// A normal law from which y is drawn.
#[derive(Debug, Clone, Copy)]
pub struct Draw {
    pub share: f64,
    pub centre: f64,
    pub sigma: f64,
}

/// p(theta), a function of tan(theta) [1/rad].
pub type Along = Box<dyn Fn(f64) -> f64>;
/// S, a function of y, tan(theta) and rho [1/mm].
pub type Across = Box<dyn Fn(f64, f64, f64) -> f64>;

/// A laser.
pub struct Light {
    watts: f64,
    height: f64,
    /// Least and greatest tan(theta) that are asked for.
    pub tans: [f64; 2],
    pub draws: Vec<Draw>,
    pub along: Along,
    pub across: Across,
}

/// Half width at 1/e^2 at `rho` from the source [mm].
pub fn half_width(laser: &LaserParameters, rho: f64) -> f64 {
    let waist = laser.waist_mm;
    let rayleigh = PI * waist * waist / (laser.m_squared * laser.wavelength_nm * 1e-6);
    let off = (rho - (laser.fan_height_mm - laser.waist_height_mm)) / rayleigh;
    waist * (1.0 + off * off).sqrt()
}

/// Tangent of half the fan's angle.
pub fn half_fan(laser: &LaserParameters) -> f64 {
    (0.5 * laser.fan_angle_deg).to_radians().tan()
}

/// A Powell lens: even on a plane, without its soft ends.
pub fn powell(laser: &LaserParameters) -> Along {
    let fan = half_fan(laser);
    Box::new(move |tan| {
        assert!(tan.abs() < 0.97 * fan, "the soft ends of the fan are not judged");
        (1.0 + tan * tan) / (2.0 * fan)
    })
}

/// A cylindrical lens: p = exp(-2 tan^2 / tan^2 (Phi / 2)) / norm, the norm by the midpoint rule.
pub fn cylindrical(laser: &LaserParameters) -> Along {
    let fan = half_fan(laser);
    let shape = move |tan: f64| (-2.0 * (tan / fan).powi(2)).exp();
    let steps = 20_000;
    let step = PI / f64::from(steps);
    let norm: f64 = (0..steps).map(|i| shape(((f64::from(i) + 0.5) * step - 0.5 * PI).tan()) * step).sum();
    Box::new(move |tan| shape(tan) / norm)
}

/// A Gaussian beam across.
pub fn gaussian(laser: &LaserParameters) -> Across {
    let laser = *laser;
    Box::new(move |y, _, rho| {
        let w = half_width(&laser, rho);
        (2.0 / PI).sqrt() / w * (-2.0 * y * y / (w * w)).exp()
    })
}

/// Even over a width that is `width` at the conveyor and grows with the distance from the source [mm].
pub fn slit(laser: &LaserParameters, width: f64) -> Across {
    let height = laser.fan_height_mm;
    Box::new(move |y, tan, rho| {
        let wide = width * rho / (1.0 + tan * tan).sqrt() / height;
        if y.abs() < 0.5 * wide { 1.0 / wide } else { 0.0 }
    })
}

/// `across` about a line that bows off the plane by `bow` at the conveyor, a function of tan over that of half the fan
/// [mm].
pub fn bowed(laser: &LaserParameters, across: Across, bow: impl Fn(f64) -> f64 + 'static) -> Across {
    let (fan, height) = (half_fan(laser), laser.fan_height_mm);
    Box::new(move |y, tan, rho| {
        let near = rho / (1.0 + tan * tan).sqrt() / height;
        across(y - bow(tan / fan) * near, tan, rho)
    })
}

impl Light {
    /// The laser's power behind a lens and through a section; rays between `tans` are drawn, as wide as a Gaussian
    /// line.
    pub fn new(laser: &LaserParameters, tans: [f64; 2], along: Along, across: Across) -> Self {
        let sigma = 0.5 * half_width(laser, laser.fan_height_mm - 10.0);
        Self {
            watts: laser.power_mw * 1e-3,
            height: laser.fan_height_mm,
            tans,
            draws: draws(0.0, sigma),
            along,
            across,
        }
    }

    /// A Gaussian sheet behind a Powell lens.
    pub fn plain(laser: &LaserParameters, tans: [f64; 2]) -> Self {
        Self::new(laser, tans, powell(laser), gaussian(laser))
    }

    /// The same with rays drawn otherwise.
    pub fn drawn(self, draws: Vec<Draw>) -> Self {
        Self { draws, ..self }
    }

    /// Draws a ray.
    pub fn shine(&self, chance: &mut Chance) -> Ray {
        let [low, high] = self.tans;
        let tan = low + (high - low) * chance.uniform();
        let mut pick = chance.uniform();
        let chosen = self.draws.iter().find(|draw| {
            pick -= draw.share;
            pick < 0.0
        });
        let chosen = chosen.or(self.draws.last()).expect("rays are drawn from some law");
        let y = chosen.centre + chosen.sigma * chance.normals()[0];
        let law =
            |d: &Draw| d.share * (-0.5 * ((y - d.centre) / d.sigma).powi(2)).exp() / (d.sigma * (2.0 * PI).sqrt());
        let density: f64 = self.draws.iter().map(law).sum();
        let way = DVec3::new(tan, 0.0, -1.0).normalize();
        Ray { from: DVec3::new(0.0, y, self.height), way, tan, y, share: (high - low) / density }
    }

    /// Power that a drawn ray stands for where it meets the surface at `at` [W].
    pub fn watts(&self, ray: &Ray, at: DVec3) -> f64 {
        let rho = at.distance(ray.from);
        let facing = self.watts * (self.along)(ray.tan) / rho * (self.across)(ray.y, ray.tan, rho);
        facing * rho / (1.0 + ray.tan * ray.tan) * ray.share
    }
}

/// Most rays as wide as a Gaussian line and some three times as wide.
pub fn draws(centre: f64, sigma: f64) -> Vec<Draw> {
    vec![Draw { share: 0.9, centre, sigma: 1.1 * sigma }, Draw { share: 0.1, centre, sigma: 3.0 * sigma }]
}
