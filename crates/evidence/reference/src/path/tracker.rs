//! Photon tracking: the random walk of weighted photons through a geometry.
//!
//! A photon flies to a collision or a surface, whichever comes first. At a collision the lens is shown what would be
//! sent to it (next-event estimation), absorption takes its share of the weight, and what is left is scattered. At a
//! smooth surface Fresnel's law decides by chance between reflection and refraction (`transmitted`). Below a weight of
//! 1e-3 Russian roulette decides about a photon; what it gives or takes is booked as absorbed, so energy closes
//! exactly.
//!
//! Three geometries are tracked in (`Geometry`): plane layers, a body under a height field, a pack. Each says how free
//! paths are drawn in it, what its surfaces do, and in which order it draws; the walk itself stands here once.
//!
//! Source: Woodcock et al. 1965 for free paths where the extinction changes. Neglected: polarisation, interference.

use glam::DVec3;
use rand::Rng;

use crate::phase::{FibreCollision, isotropic, sample_turn, turned, uniform};
use transport::fresnel::fresnel_dielectric;
use transport::stack::CylinderPhase;

/// Weight below which Russian roulette decides about a photon [1].
pub(super) const ROULETTE_WEIGHT: f64 = 1e-3;
/// Chance to survive it [1].
const SURVIVAL: f64 = 0.1;

/// A photon in flight.
#[derive(Debug, Clone, Copy)]
pub struct Photon {
    /// Where it is [mm].
    pub position: DVec3,
    /// Unit vector of travel.
    pub direction: DVec3,
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
    /// Plays Russian roulette with a faint photon: returns the energy that it leaves behind, negative where it gains;
    /// its weight is 0 if it dies.
    #[inline]
    pub(crate) fn russian_roulette(&mut self, rng: &mut impl Rng) -> f64 {
        let before = self.weight;
        self.weight = if uniform(rng) > SURVIVAL { 0.0 } else { before / SURVIVAL };
        before - self.weight
    }

    /// Throws the photon back at a surface with normal `ahead` on the far side, which it meets under cosine `mu`.
    #[inline(always)]
    pub fn reflect(&mut self, ahead: DVec3, mu: f64) {
        self.direction = (self.direction - ahead * (2.0 * mu)).normalize();
    }

    /// Scatters the photon as the collision says; `phase` is the cylinders' law.
    #[inline(always)]
    pub fn scatter_by(&mut self, collision: FibreCollision, phase: CylinderPhase, rng: &mut impl Rng) {
        match collision {
            FibreCollision::Background => {
                self.turned += 1;
                self.direction = isotropic(rng);
            }
            FibreCollision::Cylinder(fibre) => {
                self.guided += 1;
                // Rounding would grow over many turns.
                self.direction = turned(self.direction, fibre, sample_turn(phase, rng)).normalize();
            }
            FibreCollision::Null => {}
        }
    }
}

/// Draws whether light under cosine `mu` passes a smooth surface from index `n` to index `other`: the cosine beyond it,
/// or `None` where it is reflected.
#[inline(always)]
pub(super) fn transmitted(n: f64, other: f64, mu: f64, rng: &mut impl Rng) -> Option<f64> {
    let (reflectance, cosine) = fresnel_dielectric(n, other, mu);
    (uniform(rng) > reflectance).then_some(cosine)
}

/// Direction beyond a surface with normal `ahead` on the far side by Snell's law: `scaled` is the direction before it
/// times the ratio of the indices before and beyond, `scaled_mu` its cosine times the same, `cosine` that beyond.
#[inline(always)]
pub(super) fn refracted(scaled: DVec3, ahead: DVec3, scaled_mu: f64, cosine: f64) -> DVec3 {
    (scaled + ahead * (cosine - scaled_mu)).normalize()
}

/// What ends a flight.
#[derive(Debug, Clone, Copy)]
pub enum FlightEnd<M, S> {
    /// A collision in this medium.
    Collision(M),
    /// A surface.
    Surface(S),
    /// The photon is followed no farther.
    End(Fate),
}

/// When Russian roulette is played at a collision.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RouletteOrder {
    /// With the scattered photon.
    AfterScattering,
    /// Before the photon is scattered, unless absorption has left nothing of it.
    BeforeScattering,
}

/// Where photons are tracked; `O` observes them.
pub trait Geometry<O> {
    /// A photon, and what is known about it from one flight to the next.
    type State: AsMut<Photon>;
    /// Matter in which a photon collides.
    type Medium<'g>: Copy
    where
        Self: 'g;
    /// A surface that a photon meets.
    type Surface: Copy;
    /// When roulette is played at collisions: part of the order of draws, on which results depend to the bit.
    const ROULETTE_ORDER: RouletteOrder;

    /// Draws a free path and takes the photon along it.
    fn fly(&self, state: &mut Self::State, rng: &mut impl Rng) -> FlightEnd<Self::Medium<'_>, Self::Surface>;

    /// Next-event estimation: shows the observer what the coming collision sends to the lens.
    fn next_event(&self, state: &Self::State, medium: Self::Medium<'_>, observer: &mut O, rng: &mut impl Rng);

    /// Weight that the collision absorbs.
    fn absorbed(&self, photon: &Photon, medium: Self::Medium<'_>) -> f64;

    /// Turns the photon by the medium's phase function.
    fn scatter(&self, photon: &mut Photon, medium: Self::Medium<'_>, rng: &mut impl Rng);

    /// Takes the photon through a surface or back; what became of it if that was its end.
    fn cross(
        &self,
        state: &mut Self::State,
        surface: Self::Surface,
        observer: &mut O,
        rng: &mut impl Rng,
    ) -> Option<Fate>;

    /// Books `weight` of the photon.
    fn book(&self, photon: &Photon, fate: Fate, weight: f64, observer: &mut O);

    /// Plays Russian roulette if the photon is faint.
    #[inline(always)]
    fn roulette(&self, photon: &mut Photon, observer: &mut O, rng: &mut impl Rng) {
        if photon.weight < ROULETTE_WEIGHT {
            let left_behind = photon.russian_roulette(rng);
            self.book(photon, Fate::Absorbed, left_behind, observer);
        }
    }

    /// Follows a photon to its end.
    fn track(&self, mut state: Self::State, observer: &mut O, rng: &mut impl Rng) {
        loop {
            match self.fly(&mut state, rng) {
                FlightEnd::Collision(medium) => {
                    self.next_event(&state, medium, observer, rng);
                    let photon = state.as_mut();
                    let lost = self.absorbed(photon, medium);
                    self.book(photon, Fate::Absorbed, lost, observer);
                    photon.weight -= lost;
                    match Self::ROULETTE_ORDER {
                        RouletteOrder::AfterScattering => {
                            self.scatter(photon, medium, rng);
                            self.roulette(photon, observer, rng);
                        }
                        RouletteOrder::BeforeScattering => {
                            if photon.weight > 0.0 {
                                self.roulette(photon, observer, rng);
                            }
                            self.scatter(photon, medium, rng);
                        }
                    }
                }
                FlightEnd::Surface(surface) => {
                    if let Some(fate) = self.cross(&mut state, surface, observer, rng) {
                        let photon = state.as_mut();
                        return self.book(photon, fate, photon.weight, observer);
                    }
                }
                FlightEnd::End(fate) => {
                    let photon = state.as_mut();
                    return self.book(photon, fate, photon.weight, observer);
                }
            }
            if state.as_mut().weight == 0.0 {
                return;
            }
        }
    }
}

impl AsMut<Photon> for Photon {
    #[inline(always)]
    fn as_mut(&mut self) -> &mut Photon {
        self
    }
}

/// What is observed of photons below a line of light.
pub(super) trait LineObserver {
    /// Light [1] that the lens sees at a point of the surface.
    fn see(&mut self, position: DVec3, light: f64);
    /// Weight that ended so; negative where roulette gives energy back.
    fn book(&mut self, fate: Fate, weight: f64);
}

/// What becomes of light.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fate {
    /// Absorbed inside.
    Absorbed,
    /// Into the sky.
    Left,
    /// Onto the conveyor, through the bottom or from the sides.
    Dropped,
    /// Beyond the region that is followed.
    Lost,
}

/// What a line of light falls on.
pub(super) trait Target: Sync {
    /// Sends a photon in at (x, y) [mm] from above, and follows it to its end.
    fn illuminate(&self, x: f64, y: f64, observer: &mut impl LineObserver, rng: &mut impl Rng);
}
