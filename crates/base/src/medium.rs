//! The optical medium at a point: what light meets at and below the surface.
//!
//! Coefficients of the reciprocal transport equation with cylinder scattering (Kienle et al. 2008 for the picture):
//! isotropic absorption, an isotropic background, and scattering by parallel cylinders whose extinction goes with the
//! sine of the angle between light and fibre. Matter is a half space of one medium, or a film over something else.

use glam::Vec3;

use crate::Need;

/// How the surface itself throws light back: microfacets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gloss {
    /// Share of the surface that reflects like facets; the rest throws nothing back itself [1].
    pub share: f32,
    /// Reflectance of a facet at normal incidence [1].
    pub reflectance: f32,
    /// Roughness alpha of the GGX law along x and along y [1].
    pub roughness: [f32; 2],
    /// Light that the surface throws back evenly to all sides, before any of it enters: oxide, paint, blasted metal
    /// [1].
    pub matte: f32,
}

impl Gloss {
    /// No gloss at all.
    pub const NONE: Self = Self { share: 0.0, reflectance: 0.0, roughness: [1.0; 2], matte: 0.0 };

    /// Facets of cell wall, n = 1.55, on a share of sawn wood.
    pub const fn wood(share: f32) -> Self {
        Self { share, reflectance: 0.046_520_57, roughness: [0.45; 2], matte: 0.0 }
    }

    /// Whether these are facets of metal: what is not thrown back is absorbed.
    pub fn is_metal(&self) -> bool {
        self.reflectance > 0.5
    }
}

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
    /// Standard deviation of single fibres' tilt against it in each of two directions [deg].
    pub dispersion_deg: f32,
    /// Light that the surface itself throws back.
    pub gloss: Gloss,
    /// Share of light that a thin coat lets through, each way [1].
    pub coat: f32,
}

/// Dispersion of the fibres of clear wood, estimated [deg].
pub const WOOD_DISPERSION_DEG: f32 = 5.0;
/// The models of light that know how fibres are dispersed; to the others all run alike.
pub const TANGLED: Need = Need::While("transport.model", &["kernel", "path"]);
/// Indices of refraction that the kernel's tables span [1].
pub const KERNEL_INDICES: [f32; 2] = [1.0, 1.55];
/// Least share of the isotropic part in the scattering of matter with fibres that they span [1].
pub const KERNEL_LEAST_SHARE: f32 = 0.03;

impl Medium {
    /// Clear wood by the class table of docs/theory/wood.md, earlywood with its fibres along the motion, without gloss.
    pub const CLEAR_WOOD: Self = Self {
        mu_a: 0.08,
        sigma_i: 2.0,
        k: 10.0,
        n_eff: 1.18,
        fibre: Vec3::Y,
        dispersion_deg: WOOD_DISPERSION_DEG,
        gloss: Gloss::NONE,
        coat: 1.0,
    };

    /// A surface through which nothing passes: it only reflects at first contact.
    pub fn opaque(gloss: Gloss) -> Self {
        Self::isotropic(1.0e3, 1.0, 1.5, gloss)
    }

    /// Matter that scatters alike in all directions.
    pub fn isotropic(mu_a: f32, sigma_i: f32, n_eff: f32, gloss: Gloss) -> Self {
        let (fibre, dispersion_deg) = (Vec3::Y, WOOD_DISPERSION_DEG);
        Self { mu_a, sigma_i, k: 0.0, n_eff, fibre, dispersion_deg, gloss, coat: 1.0 }
    }
}

/// A film over something else. The film's own coefficients are those of the [`Medium`] beside it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Film {
    /// Thickness across the film [mm].
    pub thickness_mm: f32,
    /// Height of the air below it; `None` where it is sealed to what lies below [mm].
    pub gap_mm: Option<f32>,
    /// Distances along the motion to the walls that end that air, against the motion and with it; infinite where there
    /// are none [mm].
    pub room_mm: [f32; 2],
    /// What lies below: tablet or foil.
    pub under: Medium,
    /// dz/dx and dz/dy of the surface of what lies below [1].
    pub under_slope: [f32; 2],
}

impl Film {
    /// Whether it stands over the air of a pocket.
    #[inline]
    pub fn is_over_room(&self) -> bool {
        self.gap_mm.is_some() && self.room_mm.iter().all(|end| end.is_finite())
    }
}
