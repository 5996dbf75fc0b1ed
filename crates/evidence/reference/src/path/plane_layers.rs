//! Geometry of plane layers for the photon tracker.
//!
//! Free paths are exponential in the extinction of the current direction. Fibres, whose extinction depends on the drawn
//! axis, use delta tracking (Woodcock 1965): collisions are drawn with sigma_i + sigma_c + mu_a and a share is null. At
//! planes where the index changes Fresnel's law decides, at foil its facets. Whoever asks what the lens sees observes
//! the collisions ([`StackObserver::collide`]).

use glam::DVec3;
use rand::Rng;

use super::foil::mirror;
use super::tracker::{Fate, FlightEnd, Geometry, Photon, RouletteOrder, transmitted};
use crate::phase::{dispersed, fibre_collision, frame, henyey_greenstein, uniform};
use transport::stack::{Layer, Scattering, Stack, Substrate};

/// What happens to photons, for those who keep count.
pub trait StackObserver {
    /// A photon, still with its whole weight, is about to collide in `layer`.
    fn collide(&mut self, _photon: &Photon, _layer: &PreparedLayer, _rng: &mut impl Rng) {}
    /// `weight` stays in layer number `layer`; negative where roulette gives energy back.
    fn absorb(&mut self, layer: usize, weight: f64);
    /// A photon leaves, upwards if `photon.direction.z > 0`; `direction` is already outside's.
    fn leave(&mut self, photon: &Photon);
}

/// A layer with what photons need of it.
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
    /// Its index over the first layer's: by what ways in it count as paths [1].
    pub optical: f64,
}

/// Plane layers, prepared for photons.
#[derive(Debug, Clone)]
pub struct StackGeometry {
    /// The layers, first one on top.
    pub layers: Vec<PreparedLayer>,
    /// Refractive index above [1].
    pub above: f64,
    /// What lies below.
    pub below: Substrate,
    /// Optical path over the first layer's index after which a photon is given up [mm].
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
            let prepared = PreparedLayer {
                layer,
                top,
                bottom: top - layer.thickness,
                across,
                optical: layer.n / stack.layers[0].n,
            };
            top = prepared.bottom;
            prepared
        });
        Self { layers: layers.collect(), above: stack.above, below: stack.below, longest }
    }

    /// Whether the index changes at any plane but the one that light to a lens above (`up`) or below leaves through.
    pub(crate) fn mirrors_inside(&self, up: bool) -> bool {
        let index = |layer: &PreparedLayer| layer.layer.n;
        let last = self
            .layers
            .last()
            .is_some_and(|last| last.bottom.is_finite() && Substrate::Index(index(last)) != self.below);
        let first = self.layers.first().is_some_and(|first| index(first) != self.above);
        (if up { last } else { first }) || self.layers.windows(2).any(|pair| index(&pair[0]) != index(&pair[1]))
    }
}

impl<O: StackObserver> Geometry<O> for StackGeometry {
    type State = Photon;
    /// A layer, and its extinction in the photon's direction.
    type Medium<'g> = (&'g PreparedLayer, f64);
    type Surface = ();
    const ROULETTE_ORDER: RouletteOrder = RouletteOrder::AfterScattering;

    #[inline(always)]
    fn fly(&self, photon: &mut Photon, rng: &mut impl Rng) -> FlightEnd<(&PreparedLayer, f64), ()> {
        let here = &self.layers[photon.layer];
        let extinction = here.extinction(photon.direction);
        let free = if extinction > 0.0 { -libm::log(uniform(rng)) / extinction } else { f64::INFINITY };
        let edge = if photon.direction.z > 0.0 { here.top } else { here.bottom };
        let wall =
            if photon.direction.z == 0.0 { f64::INFINITY } else { (edge - photon.position.z) / photon.direction.z };
        let step = free.min(wall.max(0.0));
        photon.path += step * here.optical;
        if photon.path > self.longest || step.is_infinite() {
            return FlightEnd::End(Fate::Absorbed);
        }
        photon.position += photon.direction * step;
        if free < wall {
            return FlightEnd::Collision((here, extinction));
        }
        photon.position.z = edge;
        FlightEnd::Surface(())
    }

    #[inline(always)]
    fn next_event(&self, photon: &Photon, (layer, _): (&PreparedLayer, f64), observer: &mut O, rng: &mut impl Rng) {
        observer.collide(photon, layer, rng);
    }

    #[inline(always)]
    fn absorbed(&self, photon: &Photon, (here, extinction): (&PreparedLayer, f64)) -> f64 {
        photon.weight * here.layer.mu_a / extinction
    }

    #[inline(always)]
    fn scatter(&self, photon: &mut Photon, (here, _): (&PreparedLayer, f64), rng: &mut impl Rng) {
        match here.layer.scattering {
            Scattering::Isotropic { g, .. } | Scattering::Tensor { g, .. } => {
                photon.turned += 1;
                photon.direction = henyey_greenstein(photon.direction, g, rng);
            }
            Scattering::Fibres { sigma_i, sigma_c, turn, axis, dispersion } => {
                let fibre = |rng: &mut _| dispersed(axis, here.across, dispersion, rng);
                let collision = fibre_collision(photon.direction, sigma_i, sigma_c, rng, fibre);
                photon.scatter_by(collision, turn, rng);
            }
        }
    }

    #[inline(always)]
    fn cross(&self, photon: &mut Photon, (): (), observer: &mut O, rng: &mut impl Rng) -> Option<Fate> {
        if self.cross_plane(photon, observer, rng) {
            return Some(Fate::Left);
        }
        self.roulette(photon, observer, rng);
        None
    }

    #[inline(always)]
    fn book(&self, photon: &Photon, fate: Fate, weight: f64, observer: &mut O) {
        match fate {
            Fate::Absorbed | Fate::Lost => observer.absorb(photon.layer, weight),
            Fate::Left | Fate::Dropped => observer.leave(photon),
        }
    }
}

impl StackGeometry {
    /// Takes a photon on a plane through it or back; whether it has left all layers.
    #[inline]
    fn cross_plane(&self, photon: &mut Photon, observer: &mut impl StackObserver, rng: &mut impl Rng) -> bool {
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
                photon.direction = mirror(&foil, photon.direction, rng);
                return false;
            }
            Substrate::Foil(_) => n,
        };
        let other = beyond.map_or(outside, |layer| self.layers[layer].layer.n);
        if n != other {
            let Some(cosine) = transmitted(n, other, photon.direction.z.abs(), rng) else {
                photon.direction.z = -photon.direction.z;
                return false;
            };
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
}
