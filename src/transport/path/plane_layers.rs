//! Plane layers as photons meet them.
//!
//! Free paths are exponential in the extinction of the current direction. Fibres, whose extinction depends on the drawn
//! axis, use delta tracking (Woodcock 1965): collisions are drawn with sigma_i + sigma_c + mu_a and a share is null.
//! Absorption takes its share of the weight at each collision; below 1e-3 a photon dies or gains by chance, and
//! what that gives or takes is booked as absorbed, so energy closes exactly. At planes where the index changes,
//! Fresnel's law decides by chance between reflection and refraction.

use glam::DVec3;
use rand::Rng;

use super::tracker::{Photon, ROULETTE_WEIGHT};
use crate::transport::fresnel::fresnel_dielectric;
use crate::transport::phase::{dispersed, fibre_collision, frame, henyey_greenstein, uniform};
use crate::transport::stack::{Layer, Scattering, Stack, Substrate};

/// What happens to photons, for those who keep count.
pub trait StackObserver {
    /// A photon, still with its whole weight, is about to collide in `layer`.
    fn collide(&mut self, _photon: &Photon, _layer: &PreparedLayer, _rng: &mut impl Rng) {}
    /// `weight` stays in layer number `layer`; negative where roulette gives energy back.
    fn absorb(&mut self, layer: usize, weight: f64);
    /// A photon leaves, upwards if `photon.direction.z > 0`; `direction` is already outside's.
    fn leave(&mut self, photon: &Photon);
}

/// A layer with what its walk needs.
#[derive(Debug, Clone, Copy)]
pub struct PreparedLayer {
    /// The layer as declared.
    pub layer: Layer,
    /// Its upper plane [mm].
    pub top: f64,
    /// Its lower plane [mm].
    pub bottom: f64,
    /// Vectors across the fibres.
    pub across: (DVec3, DVec3),
}

/// Layers ready to be walked.
#[derive(Debug, Clone)]
pub struct StackGeometry {
    /// The layers, first one on top.
    pub layers: Vec<PreparedLayer>,
    /// Refractive index above [1].
    pub above: f64,
    /// What lies below.
    pub below: Substrate,
    /// Path after which a photon is given up [mm].
    longest: f64,
}

impl StackGeometry {
    /// Prepares `stack`; photons whose path exceeds `longest` [mm] stay where they are.
    pub fn new(stack: &Stack, longest: f64) -> Self {
        let mut top = 0.0;
        let layers = stack.layers.iter().map(|&layer| {
            let across = match layer.scattering {
                Scattering::Fibres { axis, .. } => frame(axis),
                _ => (DVec3::X, DVec3::Y),
            };
            let prepared = PreparedLayer { layer, top, bottom: top - layer.thickness, across };
            top = prepared.bottom;
            prepared
        });
        Self { layers: layers.collect(), above: stack.above, below: stack.below, longest }
    }

    /// Whether the index changes at any plane but the one that light to a lens above (`up`) or below leaves through.
    pub fn mirrors_inside(&self, up: bool) -> bool {
        let index = |layer: &PreparedLayer| layer.layer.n;
        let last = self
            .layers
            .last()
            .is_some_and(|last| last.bottom.is_finite() && Substrate::Index(index(last)) != self.below);
        let first = self.layers.first().is_some_and(|first| index(first) != self.above);
        (if up { last } else { first }) || self.layers.windows(2).any(|pair| index(&pair[0]) != index(&pair[1]))
    }

    /// Follows a photon from where it is until it leaves, dies or has gone too far.
    pub fn follow(&self, mut photon: Photon, observer: &mut impl StackObserver, rng: &mut impl Rng) {
        loop {
            let here = &self.layers[photon.layer];
            let extinction = here.extinction(photon.direction);
            let free = if extinction > 0.0 { -libm::log(uniform(rng)) / extinction } else { f64::INFINITY };
            let edge = if photon.direction.z > 0.0 { here.top } else { here.bottom };
            let wall =
                if photon.direction.z == 0.0 { f64::INFINITY } else { (edge - photon.position.z) / photon.direction.z };
            let step = free.min(wall.max(0.0));
            photon.path += step;
            if photon.path > self.longest || step.is_infinite() {
                observer.absorb(photon.layer, photon.weight);
                return;
            }
            photon.position += photon.direction * step;
            if free < wall {
                observer.collide(&photon, here, rng);
                let lost = photon.weight * here.layer.mu_a / extinction;
                observer.absorb(photon.layer, lost);
                photon.weight -= lost;
                here.scatter(&mut photon, rng);
                if photon.weight < ROULETTE_WEIGHT {
                    observer.absorb(photon.layer, photon.russian_roulette(rng));
                    if photon.weight == 0.0 {
                        return;
                    }
                }
            } else {
                photon.position.z = edge;
                if self.cross(&mut photon, observer, rng) {
                    observer.leave(&photon);
                    return;
                }
                if photon.weight < ROULETTE_WEIGHT {
                    observer.absorb(photon.layer, photon.russian_roulette(rng));
                    if photon.weight == 0.0 {
                        return;
                    }
                }
            }
        }
    }

    /// Takes a photon on a plane through it or back; whether it has left all layers.
    #[inline]
    fn cross(&self, photon: &mut Photon, observer: &mut impl StackObserver, rng: &mut impl Rng) -> bool {
        let up = photon.direction.z > 0.0;
        let beyond = if up { photon.layer.checked_sub(1) } else { Some(photon.layer + 1) };
        let beyond = beyond.filter(|&layer| layer < self.layers.len());
        let n = self.layers[photon.layer].layer.n;
        let outside = match self.below {
            _ if up => self.above,
            Substrate::Index(below) => below,
            // Never reached but by light on the last layer's lower plane.
            Substrate::Foil(foil) if beyond.is_none() => {
                observer.absorb(photon.layer, photon.weight * (1.0 - foil.reflectance));
                photon.weight *= foil.reflectance;
                photon.turned += 1;
                photon.direction = foil.mirror(photon.direction, rng);
                return false;
            }
            Substrate::Foil(_) => n,
        };
        let other = beyond.map_or(outside, |layer| self.layers[layer].layer.n);
        if n != other {
            let (reflectance, cosine) = fresnel_dielectric(n, other, photon.direction.z.abs());
            if uniform(rng) <= reflectance {
                photon.direction.z = -photon.direction.z;
                return false;
            }
            let ratio = n / other;
            photon.direction =
                DVec3::new(photon.direction.x * ratio, photon.direction.y * ratio, cosine.copysign(photon.direction.z));
        }
        // The coat of the layer whose upper plane this is.
        let coated = if up { photon.layer } else { photon.layer + 1 };
        if let Some(Layer { coat, .. }) = self.layers.get(coated).map(|coated| coated.layer) {
            observer.absorb(coated, photon.weight * (1.0 - coat));
            photon.weight *= coat;
        }
        match beyond {
            Some(layer) => photon.layer = layer,
            None => return true,
        }
        false
    }
}

impl PreparedLayer {
    /// Extinction along `direction`, null collisions included [mm^-1].
    #[inline(always)]
    pub fn extinction(&self, direction: DVec3) -> f64 {
        let scattering = match self.layer.scattering {
            Scattering::Isotropic { mu_s, .. } => mu_s,
            Scattering::Fibres { sigma_i, sigma_c, .. } => sigma_i + sigma_c,
            Scattering::Tensor { mu_s, .. } => mu_s.dot(direction * direction),
        };
        scattering + self.layer.mu_a
    }

    #[inline(always)]
    fn scatter(&self, photon: &mut Photon, rng: &mut impl Rng) {
        match self.layer.scattering {
            Scattering::Isotropic { g, .. } | Scattering::Tensor { g, .. } => {
                photon.turned += 1;
                photon.direction = henyey_greenstein(photon.direction, g, rng);
            }
            Scattering::Fibres { sigma_i, sigma_c, turn, axis, dispersion } => {
                let fibre = |rng: &mut _| dispersed(axis, self.across, dispersion, rng);
                let collision = fibre_collision(photon.direction, sigma_i, sigma_c, rng, fibre);
                photon.scatter_by(collision, turn, rng);
            }
        }
    }
}
