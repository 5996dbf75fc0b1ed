//! Plane-parallel stack of scattering layers: what the models of transport are asked about.
//!
//! Surface at z = 0, matter below, z upwards; x along the laser line, y along the motion. Three laws of scattering:
//!
//! | law | extinction in direction w | after it |
//! |---|---|---|
//! | `Isotropic` | mu_a + mu_s | Henyey and Greenstein (1941) |
//! | `Fibres` | mu_a + sigma_i + sigma_c sin(w, f) | background isotropic, cylinders turn w about the fibre f |
//! | `Tensor` | mu_a + sum mu_i w_i^2 | Henyey and Greenstein about w (Pini, Giusfredi and Pattelli 2026); not reciprocal |
//!
//! Below the last layer lies another index or foil: metal that throws back the share `reflectance` of whatever meets
//! it, mirrored about normals of the GGX law (Walter et al. 2007), and lets nothing through. A layer may have a coat,
//! which takes its share of all light that passes its upper surface, either way.
//!
//! Valid for planes and for indices that change only between layers. Neglected: polarisation, interference in thin
//! layers, roughness of interfaces other than foil, thickness of coats, a facet's reflectance by angle.
//!
//! A new law is a variant of [`Scattering`]; its sampling and density in `phase.rs` and its keys in `medium/reader.rs`
//! of the crate `reference`.

use base::{Medium, WOOD_DISPERSION_DEG};
use glam::DVec3;

/// Dispersion of wood's fibres about their mean axis, [`WOOD_DISPERSION_DEG`] [rad].
pub const WOOD_DISPERSION: f64 = WOOD_DISPERSION_DEG as f64 * std::f64::consts::PI / 180.0;
/// Mean cosine of the pigment of films: rutile of 0.23 um in PVC at 660 nm by Mie's theory [1].
pub const PIGMENT_G: f64 = 0.557;

/// How a cylinder turns light about its axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CylinderPhase {
    /// Wrapped Cauchy law with this mean cosine, in (-1, 1) [1].
    Cauchy(f64),
    /// A mirror-like cylinder: density sin(turn / 2) / 4, mean cosine -1/3.
    Mirror,
}

impl CylinderPhase {
    /// Mean cosine g2 of the turn [1].
    pub fn mean_cosine(self) -> f64 {
        match self {
            Self::Cauchy(g2) => g2,
            Self::Mirror => -1.0 / 3.0,
        }
    }
}

/// How a layer scatters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Scattering {
    /// The same in all directions of travel.
    Isotropic {
        /// Scattering [mm^-1].
        mu_s: f64,
        /// Mean cosine, in (-1, 1) [1].
        g: f64,
    },
    /// Parallel cylinders in an isotropic background.
    Fibres {
        /// Reduced scattering of the background [mm^-1].
        sigma_i: f64,
        /// Scattering by cylinders for light across them [mm^-1].
        sigma_c: f64,
        /// How they turn light.
        turn: CylinderPhase,
        /// Unit vector along the fibres.
        axis: DVec3,
        /// Standard deviation of their tilt in each of two directions [rad].
        dispersion: f64,
    },
    /// Scattering along each axis of the frame.
    Tensor {
        /// Scattering of light along x, y, z [mm^-1].
        mu_s: DVec3,
        /// Mean cosine, in (-1, 1) [1].
        g: f64,
    },
}

/// One layer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Layer {
    /// Thickness; infinite for a half space [mm].
    pub thickness: f64,
    /// Refractive index [1].
    pub n: f64,
    /// Absorption [mm^-1].
    pub mu_a: f64,
    /// Scattering.
    pub scattering: Scattering,
    /// Share of light that passes its upper surface and is not absorbed there, each way [1].
    pub coat: f64,
}

/// Metal below the last layer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Foil {
    /// Share of light that it throws back, the same for all directions [1].
    pub reflectance: f64,
    /// Roughness alpha of the GGX law along x and along y [1].
    pub roughness: [f64; 2],
}

/// What the last layer lies on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Substrate {
    /// Clear matter without end of this refractive index [1].
    Index(f64),
    /// Metal.
    Foil(Foil),
}

/// Layers from the surface downwards, and what lies above and below.
#[derive(Debug, Clone, PartialEq)]
pub struct Stack {
    /// Refractive index above [1].
    pub above: f64,
    /// The layers, first one on top; at least one.
    pub layers: Vec<Layer>,
    /// What lies below.
    pub below: Substrate,
}

impl Layer {
    /// A layer without coat.
    pub fn new(thickness: f64, n: f64, mu_a: f64, scattering: Scattering) -> Self {
        Self { thickness, n, mu_a, scattering, coat: 1.0 }
    }

    /// A layer of air.
    pub fn air(thickness: f64) -> Self {
        Self::new(thickness, 1.0, 0.0, Scattering::Isotropic { mu_s: 0.0, g: 0.0 })
    }
}

impl Stack {
    /// One medium without end, below air.
    pub fn half_space(n: f64, mu_a: f64, scattering: Scattering) -> Self {
        Self::slab(f64::INFINITY, n, mu_a, scattering)
    }

    /// One slab of `thickness` [mm] in air.
    pub fn slab(thickness: f64, n: f64, mu_a: f64, scattering: Scattering) -> Self {
        Self { above: 1.0, layers: vec![Layer::new(thickness, n, mu_a, scattering)], below: Substrate::Index(1.0) }
    }
}

impl Stack {
    /// Whether it is the same at all azimuths.
    pub fn is_round(&self) -> bool {
        let round = |layer: &Layer| matches!(layer.scattering, Scattering::Isotropic { .. });
        let foil = matches!(self.below, Substrate::Foil(foil) if foil.roughness[0] != foil.roughness[1]);
        self.layers.iter().all(round) && !foil
    }
}

impl From<&Medium> for Stack {
    /// A half space of a body's medium, whose cylinders scatter evenly about their axis (g2 = 0).
    fn from(medium: &Medium) -> Self {
        Self::half_space(f64::from(medium.n_eff), f64::from(medium.mu_a), Scattering::from(medium))
    }
}

impl From<&Medium> for Scattering {
    fn from(medium: &Medium) -> Self {
        Self::Fibres {
            sigma_i: f64::from(medium.sigma_i),
            sigma_c: f64::from(medium.k),
            turn: CylinderPhase::Cauchy(0.0),
            axis: medium.fibre.as_dvec3(),
            dispersion: f64::from(medium.dispersion_deg).to_radians(),
        }
    }
}
