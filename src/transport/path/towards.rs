//! Next-event estimation: the light that a collision would send straight to the lens.
//!
//! A lens far away in direction v sees radiance L = sum of w p(way -> v') exp(-depth) T dOmega'/dOmega / cos(v) per
//! photon, with v' the direction inside that refraction turns into v, depth the optical depth on the way up, T the
//! transmittance of the planes passed and dOmega'/dOmega = n^2 cos(v) / (n'^2 cos(v')) (n outside, n' at the collision).
//! The radiance factor is pi L / E.

use std::f64::consts::PI;

use glam::DVec3;
use rand::Rng;

use super::walk::{Photon, Prepared, Walk};
use crate::transport::fresnel::interface;
use crate::transport::phase::{cylinder_towards, henyey_greenstein_density};
use crate::transport::stack::Scattering;

/// Steps of the mean over fibre dispersion, in tilt and around.
const TILTS: usize = 64;
const TURNS: usize = 32;

/// The way to the lens from each layer.
#[derive(Debug, Clone)]
pub(super) struct Lens(Vec<Up>);

/// The way to the lens from inside one layer; `None` where total reflection bars it.
#[derive(Debug, Clone, Copy)]
struct Up {
    /// Unit vector inside towards the lens.
    way: DVec3,
    /// Mean extinction along it, null collisions left out [mm^-1].
    extinction: f64,
    /// pi T dOmega'/dOmega / cos(v), through all layers above with their extinction; 0 if barred [1].
    factor: f64,
}

impl Lens {
    /// `None` where planes inside reflect: they send light to the lens along ways that no collision looks along.
    pub(super) fn new(walk: &Walk, view: DVec3) -> Option<Self> {
        if walk.mirrors_inside() {
            return None;
        }
        let mut ups: Vec<Up> = Vec::new();
        let mut index = walk.above;
        // Transmittance from the current layer to the outside.
        let mut through = 1.0;
        for (i, layer) in walk.layers.iter().enumerate() {
            let n = layer.layer.n;
            let sine = walk.above / n;
            let (x, y) = (view.x * sine, view.y * sine);
            let cosine = (1.0 - x * x - y * y).max(0.0).sqrt();
            if let Some(up) = i.checked_sub(1).and_then(|above| ups.get(above)) {
                let above = &walk.layers[i - 1];
                through *= libm::exp(-up.extinction * (above.top - above.bottom) / up.way.z.max(1e-12));
            }
            through *= 1.0 - interface(n, index, cosine).0;
            index = n;
            let way = DVec3::new(x, y, cosine);
            let factor = if cosine > 0.0 { PI * through * sine * sine / cosine } else { 0.0 };
            ups.push(Up { way, extinction: extinction(layer, way), factor });
        }
        Some(Self(ups))
    }

    /// Radiance factor that a collision adds, per photon [1].
    #[inline]
    pub(super) fn estimate(&self, photon: &Photon, layer: &Prepared, rng: &mut impl Rng) -> f64 {
        let up = &self.0[photon.layer];
        let depth = (layer.top - photon.place.z) / up.way.z * up.extinction;
        if up.factor == 0.0 || depth > 40.0 {
            return 0.0;
        }
        let share = match layer.layer.scattering {
            Scattering::Isotropic { mu_s, g } => mu_s * henyey_greenstein_density(photon.way.dot(up.way), g),
            Scattering::Tensor { mu_s, g } => {
                mu_s.dot(photon.way * photon.way) * henyey_greenstein_density(photon.way.dot(up.way), g)
            }
            Scattering::Fibres { sigma_i, sigma_c, turn, axis, dispersion } => {
                sigma_i / (4.0 * PI) + sigma_c * cylinder_towards(photon.way, up.way, axis, turn, dispersion, rng)
            }
        };
        photon.weight * share / layer.extinction(photon.way) * libm::exp(-depth) * up.factor
    }
}

/// Mean extinction of a layer in direction `way`, without null collisions [mm^-1].
fn extinction(layer: &Prepared, way: DVec3) -> f64 {
    match layer.layer.scattering {
        Scattering::Fibres { sigma_i, sigma_c, axis, dispersion, .. } => {
            layer.layer.mu_a + sigma_i + sigma_c * mean_sine(way.dot(axis), dispersion)
        }
        _ => layer.extinction(way),
    }
}

/// Mean sine between a direction and fibres dispersed about an axis that it meets under cosine `along` [1].
pub(super) fn mean_sine(along: f64, dispersion: f64) -> f64 {
    let across = (1.0 - along * along).max(0.0).sqrt();
    let mut sum = 0.0;
    for i in 0..TILTS {
        // Even steps in the chance of Rayleigh's law.
        let chance = (i as f64 + 0.5) / TILTS as f64;
        let (sin, cos) = libm::sincos(dispersion * (-2.0 * libm::log(chance)).sqrt());
        for j in 0..TURNS {
            // Half a turn holds all cosines.
            let turn = libm::cos(PI * (j as f64 + 0.5) / TURNS as f64);
            let fibre = along * cos + across * sin * turn;
            sum += (1.0 - fibre * fibre).max(0.0).sqrt();
        }
    }
    sum / (TILTS * TURNS) as f64
}
