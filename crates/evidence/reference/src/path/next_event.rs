//! Next-event estimation: the light that a collision would send straight to the lens.
//!
//! A lens far away in direction v sees radiance L = sum of w p(w -> v') exp(-depth) T dOmega'/dOmega / cos(v) per
//! photon. Here v' is the direction inside that refraction turns into v, depth the optical depth on the way up, T the
//! transmittance of the planes passed and dOmega'/dOmega = n^2 cos(v) / (n'^2 cos(v')) (n outside, n' at the
//! collision). The radiance factor is pi L / E.

use std::f64::consts::PI;

use glam::DVec3;
use rand::Rng;

use super::plane_layers::{PreparedLayer, StackGeometry};
use super::tracker::Photon;
use crate::phase::{cylinder_towards, henyey_greenstein_density};
use transport::fresnel::fresnel_dielectric;
use transport::stack::{Scattering, Substrate};

/// Steps of the mean over fibre dispersion, in tilt and around.
const TILT_NODES: usize = 64;
const TURN_NODES: usize = 32;

/// The path to the lens from each layer.
#[derive(Debug, Clone)]
pub struct LensEstimator(Vec<LensPath>);

/// The path to the lens from inside one layer.
#[derive(Debug, Clone, Copy)]
struct LensPath {
    /// Unit vector inside towards the lens.
    direction: DVec3,
    /// The layer's plane that it leaves through [mm].
    edge: f64,
    /// Mean extinction along it, null collisions left out [mm^-1].
    extinction: f64,
    /// pi T dOmega'/dOmega / cos(v), through all layers passed with their extinction; 0 if barred [1].
    factor: f64,
    /// From where it leaves this layer to where it leaves the last one [mm].
    beyond: DVec3,
}

impl LensEstimator {
    /// A lens far away in direction `view`: above, or below the last layer where `view.z < 0`.
    ///
    /// `None` where planes inside reflect: they send light to the lens along paths that no collision looks along.
    pub fn new(geometry: &StackGeometry, view: DVec3) -> Option<Self> {
        let up = view.z > 0.0;
        if geometry.mirrors_inside(up) {
            return None;
        }
        let outside = match geometry.below {
            _ if up => geometry.above,
            Substrate::Index(below) => below,
            Substrate::Foil(_) => return None,
        };
        let (mut index, mut through, mut beyond) = (outside, 1.0, DVec3::ZERO);
        let mut outs: Vec<LensPath> = Vec::new();
        let count = geometry.layers.len();
        for passed in 0..count {
            let layer = &geometry.layers[if up { passed } else { count - 1 - passed }];
            let n = layer.layer.n;
            let ratio = outside / n;
            let (x, y) = (view.x * ratio, view.y * ratio);
            let cosine = (1.0 - x * x - y * y).max(0.0).sqrt();
            through *= 1.0 - fresnel_dielectric(n, index, cosine).0;
            if up {
                through *= layer.layer.coat;
            }
            index = n;
            let direction = DVec3::new(x, y, cosine.copysign(view.z));
            let factor = if cosine > 0.0 { PI * through * ratio * ratio / cosine } else { 0.0 };
            let extinction = extinction(layer, direction);
            outs.push(LensPath {
                direction,
                edge: if up { layer.top } else { layer.bottom },
                extinction,
                factor,
                beyond,
            });
            through *= libm::exp(-extinction * (layer.top - layer.bottom) / cosine.max(1e-12));
            if layer.layer.thickness.is_finite() {
                beyond += direction * (layer.layer.thickness / cosine.max(1e-12));
            }
            if !up {
                through *= layer.layer.coat;
            }
        }
        if !up {
            outs.reverse();
        }
        Some(Self(outs))
    }

    /// Where light that the photon sends to the lens leaves the stack, and its way there inside the photon's layer
    /// [mm].
    #[inline]
    pub fn exit(&self, photon: &Photon) -> (DVec3, f64) {
        let out = &self.0[photon.layer];
        let way = (out.edge - photon.position.z) / out.direction.z;
        (photon.position + out.direction * way + out.beyond, way)
    }

    /// Radiance factor that a collision adds, per photon [1].
    #[inline]
    pub(super) fn estimate(&self, photon: &Photon, layer: &PreparedLayer, rng: &mut impl Rng) -> f64 {
        let [turned, guided] = self.estimates(photon, layer, rng);
        turned + guided
    }

    /// The same, by light that the collision turns anywhere and by light that a cylinder turns [1].
    #[inline]
    pub fn estimates(&self, photon: &Photon, layer: &PreparedLayer, rng: &mut impl Rng) -> [f64; 2] {
        let out = &self.0[photon.layer];
        if out.factor == 0.0 {
            return [0.0; 2];
        }
        let depth = (out.edge - photon.position.z) / out.direction.z * out.extinction;
        if depth > 40.0 {
            return [0.0; 2];
        }
        let scale = photon.weight / layer.extinction(photon.direction) * libm::exp(-depth) * out.factor;
        match layer.layer.scattering {
            Scattering::Isotropic { mu_s, g } => {
                [scale * mu_s * henyey_greenstein_density(photon.direction.dot(out.direction), g), 0.0]
            }
            Scattering::Tensor { mu_s, g } => {
                let mu_s = mu_s.dot(photon.direction * photon.direction);
                [scale * mu_s * henyey_greenstein_density(photon.direction.dot(out.direction), g), 0.0]
            }
            Scattering::Fibres { sigma_i, sigma_c, turn, axis, dispersion } => {
                let cylinders = cylinder_towards(photon.direction, out.direction, axis, turn, dispersion, rng);
                [scale * sigma_i / (4.0 * PI), scale * sigma_c * cylinders]
            }
        }
    }
}

/// Mean extinction of a layer along `direction`, without null collisions [mm^-1].
fn extinction(layer: &PreparedLayer, direction: DVec3) -> f64 {
    match layer.layer.scattering {
        Scattering::Fibres { sigma_i, sigma_c, axis, dispersion, .. } => {
            layer.layer.mu_a + sigma_i + sigma_c * mean_sine(direction.dot(axis), dispersion)
        }
        _ => layer.extinction(direction),
    }
}

/// Mean sine between a direction and fibres dispersed about an axis that it meets under cosine `along` [1].
pub(super) fn mean_sine(along: f64, dispersion: f64) -> f64 {
    let across = (1.0 - along * along).max(0.0).sqrt();
    let mut sum = 0.0;
    for i in 0..TILT_NODES {
        // Even steps in the chance of Rayleigh's law.
        let chance = (i as f64 + 0.5) / TILT_NODES as f64;
        let (sin, cos) = libm::sincos(dispersion * (-2.0 * libm::log(chance)).sqrt());
        for j in 0..TURN_NODES {
            // Half a turn holds all cosines.
            let turn = libm::cos(PI * (j as f64 + 0.5) / TURN_NODES as f64);
            let fibre = along * cos + across * sin * turn;
            sum += (1.0 - fibre * fibre).max(0.0).sqrt();
        }
    }
    sum / (TILT_NODES * TURN_NODES) as f64
}
