//! What diffusion needs of a medium: its tensor, where entering light begins to diffuse, and the boundary.
//!
//! | law | D | mean displacement h of light in direction s |
//! |---|---|---|
//! | `Isotropic` | 1 / (3 mu_s (1 - g)) | s / (mu_s (1 - g)) |
//! | `Fibres` | D_par f f + D_perp (1 - f f), theory/physics.md | across f over sigma_i + k sin, along f over sigma_i |
//! | `Tensor` | `Generalized` | `Generalized` |
//!
//! The boundary is the extrapolated one, fluence zero at z_e = 2 A D_zz above the surface (Contini, Martelli and
//! Zaccanti 1997), or the generalised equation's. Valid where scattering, after reduction by its mean cosine, outweighs
//! absorption, some mean free paths from the source and from borders. Neglected: absorption on the way to the first
//! scattering and in D; the dispersion of fibres, which lowers D_par of wood by about 5 %.

use glam::{DMat2, DMat3, DVec2, DVec3};

use super::generalized::Generalized;
use transport::fresnel::{boundary_factor, internal_reflectance};
use transport::kernel::diffusion;
use transport::stack::{Layer, Scattering};

/// How light moves on average in a medium.
#[derive(Debug, Clone, PartialEq)]
enum DiffusiveLaw {
    Isotropic { reduced: f64 },
    Fibres { sigma_i: f64, k: f64, axis: DVec3 },
    Tensor(Box<Generalized>),
}

/// A medium as diffusion sees it.
#[derive(Debug, Clone, PartialEq)]
pub struct Diffusive {
    /// Absorption [mm^-1].
    pub mu_a: f64,
    /// Refractive index [1].
    pub n: f64,
    /// Diffusion tensor; the flux is -D grad Phi [mm].
    pub d: DMat3,
    law: DiffusiveLaw,
}

impl Diffusive {
    /// The medium of layer number `index` of a stack.
    ///
    /// # Errors
    /// In words with a remedy, where light does not lose its direction in some way: clear layers, gaps, cylinders
    /// without background.
    pub fn new(layer: &Layer, index: usize) -> Result<Self, String> {
        let clear = || {
            format!(
                "layer {index} does not scatter: light crosses it in straight lines, which diffusion cannot say; use \
                 the path model"
            )
        };
        let (law, d) = match layer.scattering {
            Scattering::Isotropic { mu_s, g } => {
                let reduced = mu_s * (1.0 - g);
                if reduced <= 0.0 {
                    return Err(clear());
                }
                (DiffusiveLaw::Isotropic { reduced }, DMat3::from_diagonal(DVec3::splat(1.0 / (3.0 * reduced))))
            }
            Scattering::Fibres { sigma_i, sigma_c, turn, axis, .. } => {
                let k = sigma_c * (1.0 - turn.mean_cosine());
                if sigma_i <= 0.0 && k > 0.0 {
                    return Err(format!(
                        "layer {index} has cylinders without background: light runs along them without end; give it \
                         a sigma_i above 0, or use the path model"
                    ));
                }
                if sigma_i <= 0.0 {
                    return Err(clear());
                }
                let (along, across) = diffusion(sigma_i, k);
                (DiffusiveLaw::Fibres { sigma_i, k, axis }, uniaxial(along, across, axis))
            }
            Scattering::Tensor { mu_s, g } => {
                if mu_s.min_element() <= 0.0 {
                    return Err(clear());
                }
                let medium = Generalized::new(mu_s, g);
                let d = DMat3::from_diagonal(medium.d);
                (DiffusiveLaw::Tensor(Box::new(medium)), d)
            }
        };
        Ok(Self { mu_a: layer.mu_a, n: layer.n, d, law })
    }

    /// Mean displacement of light that enters in direction `s`: where it begins to diffuse [mm].
    pub fn persistence(&self, s: DVec3) -> DVec3 {
        match &self.law {
            DiffusiveLaw::Isotropic { reduced } => s / *reduced,
            DiffusiveLaw::Fibres { sigma_i, k, axis } => {
                let along = s.dot(*axis);
                let across = s - along * *axis;
                across / (sigma_i + k * across.length()) + along / sigma_i * *axis
            }
            DiffusiveLaw::Tensor(medium) => medium.persistence(s),
        }
    }

    /// Height above a surface across z at which the fluence vanishes, with the index `outside` beyond it [mm].
    pub(crate) fn extrapolation(&self, outside: f64) -> f64 {
        let n = self.n / outside;
        match &self.law {
            DiffusiveLaw::Tensor(medium) => medium.extrapolation(n),
            _ => 2.0 * boundary_factor(n) * self.d.z_axis.z,
        }
    }

    /// Sideways drift for each mm towards +z, of a wave whose cross terms are sheared away [1].
    pub fn drift(&self) -> DVec2 {
        self.d.z_axis.truncate() / self.d.z_axis.z
    }

    /// What remains of the tensor in the plane after that [mm].
    pub fn sheared(&self) -> DMat2 {
        let cross = self.d.z_axis.truncate();
        let plane = DMat2::from_cols(self.d.x_axis.truncate(), self.d.y_axis.truncate());
        plane - DMat2::from_cols(cross * cross.x, cross * cross.y) * (1.0 / self.d.z_axis.z)
    }
}

/// A tensor with one value along `axis` and another across it.
pub fn uniaxial(along: f64, across: f64, axis: DVec3) -> DMat3 {
    let outer = DMat3::from_cols(axis * axis.x, axis * axis.y, axis * axis.z);
    DMat3::from_diagonal(DVec3::splat(across)) + outer * (along - across)
}

/// First and second moment of the reflectance for light inside index `n` that meets index 1: int mu R, int mu^2 R [1].
pub fn moments(n: f64) -> (f64, f64) {
    const QUADRATURE_STEPS: usize = 4000;
    (0..QUADRATURE_STEPS).fold((0.0, 0.0), |(first, second), i| {
        let mu = (i as f64 + 0.5) / QUADRATURE_STEPS as f64;
        let r = mu * internal_reflectance(n, mu) / QUADRATURE_STEPS as f64;
        (first + r, second + mu * r)
    })
}

/// Direction of light after a plane surface with unit normal `normal` towards the incoming side, index ratio `n` of the
/// far side over the near one; `None` beyond the critical angle.
pub fn refracted(s: DVec3, normal: DVec3, n: f64) -> Option<DVec3> {
    let cos = -s.dot(normal);
    let across = (s + cos * normal) / n;
    let rest = 1.0 - across.length_squared();
    (rest > 0.0).then(|| across - rest.sqrt() * normal)
}
