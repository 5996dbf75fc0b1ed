//! Photons, and what is observed of them.
//!
//! Absorption takes its share of the weight at each collision; below [`ROULETTE_WEIGHT`] Russian roulette decides, and what
//! it gives or takes is booked as absorbed, so energy closes exactly.

use glam::DVec3;
use rand::Rng;

use crate::transport::phase::{FibreCollision, isotropic, turned, uniform};
use crate::transport::stack::CylinderPhase;

/// Weight below which Russian roulette decides about a photon [1].
pub(super) const ROULETTE_WEIGHT: f64 = 1e-3;
/// Chance to survive it [1].
const SURVIVAL: f64 = 0.1;

/// A photon on its direction.
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
    /// Plays Russian roulette with a faint photon: returns the energy that it leaves behind, negative where it gains; its weight is
    /// 0 if it dies.
    #[inline]
    pub fn russian_roulette(&mut self, rng: &mut impl Rng) -> f64 {
        let before = self.weight;
        self.weight = if uniform(rng) > SURVIVAL { 0.0 } else { before / SURVIVAL };
        before - self.weight
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
                self.direction = turned(self.direction, fibre, phase.sample(rng)).normalize();
            }
            FibreCollision::Null => {}
        }
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
pub(super) enum Fate {
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
