//! The laser: rays from a virtual source over the line, and the light that each carries.
//!
//! Rays fan out along x from (0, ., height) and stay in planes of one y; the irradiance on a surface that faces the light
//! at distance rho from the source is what [`Light::irradiance`] says, for a Gaussian sheet behind a Powell lens
//! P p(theta) / rho sqrt(2 / pi) / w(rho) exp(-2 y^2 / w(rho)^2), p = 1 / (2 tan(Phi / 2) cos^2 theta).
//! Rays are drawn evenly in tan(theta) and from a mixture of two normal laws in y; each is weighted by irradiance x
//! rho cos^2(theta) over the density of its draw.

use glam::DVec3;
use sheetlight::optics::parameters::Laser;

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

/// Irradiance of a surface that faces the light, of tan(theta), y and the distance to the source [W/mm^2].
pub type Irradiance = Box<dyn Fn(f64, f64, f64) -> f64>;

/// A laser.
pub struct Light {
    height: f64,
    /// Least and greatest tan(theta) that are asked for.
    pub tans: [f64; 2],
    /// Where rays are drawn about y = 0: standard deviations of the two laws [mm].
    pub spread: [f64; 2],
    /// Where the middle of the line lies, of tan(theta), and how the lines of more than one lie about it [mm].
    pub middle: fn(f64) -> f64,
    pub irradiance: Irradiance,
}

/// Share of rays from the wider law.
const WIDE: f64 = 0.1;

/// Half width at 1/e^2 at `rho` from the source [mm].
pub fn half_width(laser: &Laser, rho: f64) -> f64 {
    let waist = laser.waist_mm;
    let rayleigh = std::f64::consts::PI * waist * waist / (laser.m_squared * laser.wavelength_nm * 1e-6);
    let off = (rho - (laser.fan_height_mm - laser.waist_height_mm)) / rayleigh;
    waist * (1.0 + off * off).sqrt()
}

impl Light {
    /// A Gaussian sheet behind a Powell lens, of which rays between `tans` are drawn.
    pub fn powell(laser: &Laser, tans: [f64; 2]) -> Self {
        let fan = (0.5 * laser.fan_angle_deg).to_radians().tan();
        assert!(tans.iter().all(|t| t.abs() < 0.97 * fan), "the soft ends of the fan are not judged");
        Self::sheet(laser, tans, move |tan| (1.0 + tan * tan) / (2.0 * fan))
    }

    /// A Gaussian sheet whose light goes `per_angle` along the fan [1/rad], a function of tan(theta).
    pub fn sheet(laser: &Laser, tans: [f64; 2], per_angle: impl Fn(f64) -> f64 + 'static) -> Self {
        let nominal = 0.5 * half_width(laser, laser.fan_height_mm - 10.0);
        let laser = *laser;
        let irradiance = move |tan: f64, y: f64, rho: f64| {
            let w = half_width(&laser, rho);
            let across = (2.0 / std::f64::consts::PI).sqrt() / w * (-2.0 * y * y / (w * w)).exp();
            laser.power_mw * 1e-3 * per_angle(tan) / rho * across
        };
        Self {
            height: laser.fan_height_mm,
            tans,
            spread: [1.1 * nominal, 3.0 * nominal],
            middle: |_| 0.0,
            irradiance: Box::new(irradiance),
        }
    }

    /// Draws a ray.
    pub fn shine(&self, chance: &mut Chance) -> Option<Ray> {
        let [low, high] = self.tans;
        let tan = low + (high - low) * chance.uniform();
        let sigma = self.spread[usize::from(chance.uniform() < WIDE)];
        let off = sigma * chance.normals()[0];
        let law = |s: f64| (-0.5 * (off / s).powi(2)).exp() / (s * std::f64::consts::TAU.sqrt());
        let density = (1.0 - WIDE) * law(self.spread[0]) + WIDE * law(self.spread[1]);
        let y = (self.middle)(tan) + off;
        let way = DVec3::new(tan, 0.0, -1.0).normalize();
        Some(Ray { from: DVec3::new(0.0, y, self.height), way, tan, y, share: (high - low) / density })
    }

    /// Power that a drawn ray stands for where it meets the surface at `at` [W].
    pub fn watts(&self, ray: &Ray, at: DVec3) -> f64 {
        let rho = at.distance(ray.from);
        (self.irradiance)(ray.tan, ray.y, rho) * rho / (1.0 + ray.tan * ray.tan) * ray.share
    }
}
