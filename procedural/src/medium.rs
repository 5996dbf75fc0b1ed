//! The optical medium at a point: what light meets below the surface.
//!
//! Coefficients of the reciprocal transport equation with cylinder scattering (Kienle et al. 2008 for the picture):
//! isotropic absorption, an isotropic background, and scattering by parallel cylinders whose extinction goes with the
//! sine of the angle between light and fibre.

use glam::Vec3;

/// Transport coefficients and fibre direction at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Medium {
    /// Absorption [mm^-1].
    pub mu_a: f32,
    /// Reduced scattering of the isotropic background [mm^-1].
    pub sigma_i: f32,
    /// Reduced cylinder scattering for light across the fibre, sigma_c (1 - g2) [mm^-1].
    pub k: f32,
    /// Effective refractive index of the matter below the surface [1].
    pub n_eff: f32,
    /// Unit vector along the fibre; its sign has no meaning [1].
    pub fibre: Vec3,
    /// Share of the surface that reflects like a dielectric facet of that matter [1].
    pub gloss: f32,
}

impl Medium {
    /// A surface through which nothing passes: it only reflects at first contact.
    pub fn opaque(gloss: f32) -> Self {
        Self { mu_a: 1.0e3, sigma_i: 1.0, k: 0.0, n_eff: 1.5, fibre: Vec3::Y, gloss }
    }
}
