//! One photon's way through plane layers.
//!
//! Free paths are exponential in the extinction of the current direction. Fibres, whose extinction depends on the drawn
//! axis, use delta tracking (Woodcock 1965): collisions are drawn with sigma_i + sigma_c + mu_a and a share is null.
//! Absorption takes its share of the weight at each collision; below 1e-3 a photon dies or gains by chance, and
//! what that gives or takes is booked as absorbed, so energy closes exactly. At planes where the index changes,
//! Fresnel's law decides by chance between reflection and refraction.

use glam::DVec3;
use rand::Rng;

use crate::transport::fresnel::fresnel_dielectric;
use crate::transport::phase::{dispersed, frame, henyey_greenstein, isotropic, turned, uniform};
use crate::transport::stack::{CylinderPhase, Layer, Scattering, Stack, Substrate};

/// Weight under which chance decides about a photon [1].
pub(super) const ROULETTE: f64 = 1e-3;
/// Chance to survive then [1].
const SURVIVES: f64 = 0.1;

/// A photon on its way.
#[derive(Debug, Clone, Copy)]
pub struct Photon {
    /// Where it is [mm].
    pub place: DVec3,
    /// Unit vector of travel.
    pub way: DVec3,
    /// Energy left [1].
    pub weight: f64,
    /// Layer that it is in.
    pub layer: usize,
    /// Length of its path inside [mm].
    pub path: f64,
    /// Scattering by the background, or by what is not a cylinder.
    pub turned: u32,
    /// Scattering by cylinders.
    pub guided: u32,
}

impl Photon {
    /// Lets chance decide about a faint photon: the energy that it leaves behind, negative where it gains; its weight is
    /// 0 if it dies.
    #[inline]
    pub fn gamble(&mut self, rng: &mut impl Rng) -> f64 {
        let before = self.weight;
        self.weight = if uniform(rng) > SURVIVES { 0.0 } else { before / SURVIVES };
        before - self.weight
    }
}

/// What happens to photons, for those who keep count.
pub trait Tally {
    /// A photon, still with its whole weight, is about to collide in `layer`.
    fn collide(&mut self, _photon: &Photon, _layer: &Prepared, _rng: &mut impl Rng) {}
    /// `weight` stays in layer number `layer`; negative where roulette gives energy back.
    fn absorb(&mut self, layer: usize, weight: f64);
    /// A photon leaves, upwards if `photon.way.z > 0`; `way` is already outside's.
    fn leave(&mut self, photon: &Photon);
}

/// A layer with what its walk needs.
#[derive(Debug, Clone, Copy)]
pub struct Prepared {
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
pub struct Walk {
    /// The layers, first one on top.
    pub layers: Vec<Prepared>,
    /// Refractive index above [1].
    pub above: f64,
    /// What lies below.
    pub below: Substrate,
    /// Path after which a photon is given up [mm].
    longest: f64,
}

impl Walk {
    /// Prepares `stack`; photons whose path exceeds `longest` [mm] stay where they are.
    pub fn new(stack: &Stack, longest: f64) -> Self {
        let mut top = 0.0;
        let layers = stack.layers.iter().map(|&layer| {
            let across = match layer.scattering {
                Scattering::Fibres { axis, .. } => frame(axis),
                _ => (DVec3::X, DVec3::Y),
            };
            let prepared = Prepared { layer, top, bottom: top - layer.thickness, across };
            top = prepared.bottom;
            prepared
        });
        Self { layers: layers.collect(), above: stack.above, below: stack.below, longest }
    }

    /// Whether the index changes at any plane but the one that light to a lens above (`up`) or below leaves through.
    pub fn mirrors_inside(&self, up: bool) -> bool {
        let index = |layer: &Prepared| layer.layer.n;
        let last = self
            .layers
            .last()
            .is_some_and(|last| last.bottom.is_finite() && Substrate::Index(index(last)) != self.below);
        let first = self.layers.first().is_some_and(|first| index(first) != self.above);
        (if up { last } else { first }) || self.layers.windows(2).any(|pair| index(&pair[0]) != index(&pair[1]))
    }

    /// Follows a photon from where it is until it leaves, dies or has gone too far.
    pub fn follow(&self, mut photon: Photon, tally: &mut impl Tally, rng: &mut impl Rng) {
        loop {
            let here = &self.layers[photon.layer];
            let extinction = here.extinction(photon.way);
            let free = if extinction > 0.0 { -libm::log(uniform(rng)) / extinction } else { f64::INFINITY };
            let edge = if photon.way.z > 0.0 { here.top } else { here.bottom };
            let wall = if photon.way.z == 0.0 { f64::INFINITY } else { (edge - photon.place.z) / photon.way.z };
            let step = free.min(wall.max(0.0));
            photon.path += step;
            if photon.path > self.longest || step.is_infinite() {
                tally.absorb(photon.layer, photon.weight);
                return;
            }
            photon.place += photon.way * step;
            if free < wall {
                tally.collide(&photon, here, rng);
                let lost = photon.weight * here.layer.mu_a / extinction;
                tally.absorb(photon.layer, lost);
                photon.weight -= lost;
                here.scatter(&mut photon, rng);
                if photon.weight < ROULETTE {
                    tally.absorb(photon.layer, photon.gamble(rng));
                    if photon.weight == 0.0 {
                        return;
                    }
                }
            } else {
                photon.place.z = edge;
                if self.cross(&mut photon, tally, rng) {
                    tally.leave(&photon);
                    return;
                }
                if photon.weight < ROULETTE {
                    tally.absorb(photon.layer, photon.gamble(rng));
                    if photon.weight == 0.0 {
                        return;
                    }
                }
            }
        }
    }

    /// Takes a photon on a plane through it or back; whether it has left all layers.
    #[inline]
    fn cross(&self, photon: &mut Photon, tally: &mut impl Tally, rng: &mut impl Rng) -> bool {
        let up = photon.way.z > 0.0;
        let beyond = if up { photon.layer.checked_sub(1) } else { Some(photon.layer + 1) };
        let beyond = beyond.filter(|&layer| layer < self.layers.len());
        let n = self.layers[photon.layer].layer.n;
        let outside = match self.below {
            _ if up => self.above,
            Substrate::Index(below) => below,
            // Never reached but by light on the last layer's lower plane.
            Substrate::Foil(foil) if beyond.is_none() => {
                tally.absorb(photon.layer, photon.weight * (1.0 - foil.reflectance));
                photon.weight *= foil.reflectance;
                photon.turned += 1;
                photon.way = foil.mirror(photon.way, rng);
                return false;
            }
            Substrate::Foil(_) => n,
        };
        let other = beyond.map_or(outside, |layer| self.layers[layer].layer.n);
        if n != other {
            let (reflectance, cosine) = fresnel_dielectric(n, other, photon.way.z.abs());
            if uniform(rng) <= reflectance {
                photon.way.z = -photon.way.z;
                return false;
            }
            let ratio = n / other;
            photon.way = DVec3::new(photon.way.x * ratio, photon.way.y * ratio, cosine.copysign(photon.way.z));
        }
        // The coat of the layer whose upper plane this is.
        let coated = if up { photon.layer } else { photon.layer + 1 };
        if let Some(Layer { coat, .. }) = self.layers.get(coated).map(|coated| coated.layer) {
            tally.absorb(coated, photon.weight * (1.0 - coat));
            photon.weight *= coat;
        }
        match beyond {
            Some(layer) => photon.layer = layer,
            None => return true,
        }
        false
    }
}

impl Prepared {
    /// Extinction in direction `way`, null collisions included [mm^-1].
    #[inline(always)]
    pub fn extinction(&self, way: DVec3) -> f64 {
        let scattering = match self.layer.scattering {
            Scattering::Isotropic { mu_s, .. } => mu_s,
            Scattering::Fibres { sigma_i, sigma_c, .. } => sigma_i + sigma_c,
            Scattering::Tensor { mu_s, .. } => mu_s.dot(way * way),
        };
        scattering + self.layer.mu_a
    }

    #[inline(always)]
    fn scatter(&self, photon: &mut Photon, rng: &mut impl Rng) {
        match self.layer.scattering {
            Scattering::Isotropic { g, .. } | Scattering::Tensor { g, .. } => {
                photon.turned += 1;
                photon.way = henyey_greenstein(photon.way, g, rng);
            }
            Scattering::Fibres { sigma_i, sigma_c, turn, axis, dispersion } => {
                let event =
                    meet(photon.way, sigma_i, sigma_c, rng, |rng| dispersed(axis, self.across, dispersion, rng));
                event.apply(photon, turn, rng);
            }
        }
    }
}

/// What a collision in a medium of fibres was.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Event {
    /// The isotropic background.
    Background,
    /// A cylinder with this axis.
    Cylinder(DVec3),
    /// Nothing: the cylinder shows light less than its whole width.
    Null,
}

/// Draws what light in direction `way` meets; `fibre` draws a cylinder's axis.
#[inline(always)]
pub fn meet<R: Rng>(way: DVec3, sigma_i: f64, sigma_c: f64, rng: &mut R, fibre: impl FnOnce(&mut R) -> DVec3) -> Event {
    let choice = uniform(rng) * (sigma_i + sigma_c);
    if choice < sigma_i {
        return Event::Background;
    }
    let fibre = fibre(rng);
    let along = way.dot(fibre);
    let hit = (choice - sigma_i) / sigma_c;
    if hit * hit < 1.0 - along * along { Event::Cylinder(fibre) } else { Event::Null }
}

impl Event {
    /// Turns the photon as the event says.
    #[inline(always)]
    pub fn apply(self, photon: &mut Photon, turn: CylinderPhase, rng: &mut impl Rng) {
        match self {
            Self::Background => {
                photon.turned += 1;
                photon.way = isotropic(rng);
            }
            Self::Cylinder(fibre) => {
                photon.guided += 1;
                // Rounding would grow over many turns.
                photon.way = turned(photon.way, fibre, turn.sample(rng)).normalize();
            }
            Self::Null => {}
        }
    }
}
