//! What a thin film does to light from above and from below: the measurements behind the table of
//! [`kernel::layers`](crate::transport::kernel::layers).
//!
//! A plane slab of thickness 1 in air, index n, whose pigment scatters by Henyey and Greenstein's law with mean cosine
//! [`PIGMENT_G`], is walked without absorption in three ways: light from straight above that has entered, Lambert light,
//! and light from straight above with foil below. Absorption takes exp(-mu_a path) of what leaves after a path, so all
//! absorptions come from the same walk. Light that pigment turned is counted apart from light that it did not.
//!
//! Where light leaves is kept as a transform, the mean of cos(k x), for a grid of frequencies k in units of 1 / thickness;
//! x and y serve alike. Valid and neglected as in [`super::walk`].

use glam::DVec3;
use procedural::Stream;
use rayon::prelude::*;

use super::walk::{Photon, Prepared, Tally, Walk};
use crate::transport::fresnel::fresnel_dielectric;
use crate::transport::phase::disc;
use crate::transport::stack::{Foil, Scattering, Stack, Substrate};

/// Mean cosine of the pigment: rutile of 0.23 um in PVC at 660 nm by Mie's theory [1].
pub const PIGMENT_G: f64 = 0.557;
/// Foil below a sealed film.
pub const SEALED: Foil = Foil { reflectance: 0.9, roughness: [0.2, 0.2] };
/// Frequencies of the transforms.
pub const FREQUENCIES: usize = 20;
/// Bins of directions of exit, even in the square of the sine.
pub const DIRECTIONS: usize = 8;
/// Independent batches.
const BATCHES: u64 = 32;

/// A film in units of its thickness.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slab {
    /// Refractive index [1].
    pub n: f64,
    /// Reduced scattering times thickness [1].
    pub turns: f64,
}

/// Light that leaves one side of a film after it was turned.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Side {
    /// Transform of where it leaves; the total where the frequency is 0 [1].
    pub spread: [f64; FREQUENCIES],
    /// Total [1].
    pub total: f64,
    /// Part of it in each bin of directions [1].
    pub directions: [f64; DIRECTIONS],
    /// Transform of the slope of its direction along one axis, horizontal over vertical [1].
    pub slopes: [f64; FREQUENCIES],
}

impl Default for Side {
    fn default() -> Self {
        let none = [0.0; FREQUENCIES];
        Self { spread: none, total: 0.0, directions: [0.0; DIRECTIONS], slopes: none }
    }
}

/// What becomes of light, per photon, for one absorption.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Fate {
    /// Leaves upwards, turned.
    pub up: Side,
    /// Leaves downwards, turned.
    pub down: Side,
    /// Leaves upwards without having been turned, the first surface's share included [1].
    pub straight_up: f64,
    /// Leaves downwards without having been turned [1].
    pub straight_down: f64,
}

/// How light comes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Light {
    /// From straight above, per photon that entered.
    Straight,
    /// From everywhere above by Lambert's law, per photon that arrived.
    Lambert,
    /// As `Straight`, foil below.
    Sealed,
}

struct Sums<'a> {
    frequencies: &'a [f64; FREQUENCIES],
    absorptions: &'a [f64],
    turned: bool,
    fates: Vec<Fate>,
}

impl Tally for Sums<'_> {
    fn collide(&mut self, _: &Photon, _: &Prepared, _: &mut impl rand::Rng) {
        self.turned = true;
    }

    fn absorb(&mut self, _: usize, _: f64) {}

    fn leave(&mut self, photon: &Photon) {
        let up = photon.way.z > 0.0;
        let kept = |absorption: f64| photon.weight * libm::exp(-absorption * photon.path);
        if !self.turned {
            for (fate, &absorption) in self.fates.iter_mut().zip(self.absorptions) {
                *(if up { &mut fate.straight_up } else { &mut fate.straight_down }) += kept(absorption);
            }
            return;
        }
        let mean = |k: f64, a: f64, b: f64| 0.5 * (libm::cos(k * a) + libm::cos(k * b));
        let (place, way) = (photon.place, photon.way);
        let spread = self.frequencies.map(|k| mean(k, place.x, place.y));
        let (along, across) = (way.x / way.z, way.y / way.z);
        let slopes = if up { [0.0; FREQUENCIES] } else { self.frequencies.map(|k| mean(k, along, across)) };
        let bin = ((1.0 - way.z * way.z) * DIRECTIONS as f64) as usize;
        for (fate, &absorption) in self.fates.iter_mut().zip(self.absorptions) {
            let weight = kept(absorption);
            let side = if up { &mut fate.up } else { &mut fate.down };
            side.total += weight;
            side.directions[bin.min(DIRECTIONS - 1)] += weight;
            for i in 0..FREQUENCIES {
                side.spread[i] += weight * spread[i];
                side.slopes[i] += weight * slopes[i];
            }
        }
    }
}

/// Walks `photons` for each of `absorptions` [1 / thickness] at once.
pub fn measure(
    slab: Slab,
    light: Light,
    frequencies: &[f64; FREQUENCIES],
    absorptions: &[f64],
    photons: u64,
    seed: u64,
) -> Vec<Fate> {
    let pigment = Scattering::Isotropic { mu_s: slab.turns / (1.0 - PIGMENT_G), g: PIGMENT_G };
    let mut stack = Stack::slab(1.0, slab.n, 0.0, pigment);
    if light == Light::Sealed {
        stack.below = Substrate::Foil(SEALED);
    }
    let walk = Walk::new(&stack, f64::INFINITY);
    let each = photons.div_ceil(BATCHES);
    let batches: Vec<Vec<Fate>> = (0..BATCHES)
        .into_par_iter()
        .map(|batch| {
            let mut rng = Stream::root(seed).child("transport").child("film").index(batch).rng();
            let fates = vec![Fate::default(); absorptions.len()];
            let mut sums = Sums { frequencies, absorptions, turned: false, fates };
            for _ in 0..each {
                let (mut way, mut weight) = (DVec3::NEG_Z, 1.0);
                if light == Light::Lambert {
                    let (x, y, s) = disc(&mut rng);
                    let (thrown, cosine) = fresnel_dielectric(1.0, slab.n, (1.0 - s).sqrt());
                    sums.fates.iter_mut().for_each(|fate| fate.straight_up += thrown);
                    (way, weight) = (DVec3::new(x / slab.n, y / slab.n, -cosine), 1.0 - thrown);
                }
                sums.turned = false;
                let place = DVec3::ZERO;
                let photon = Photon { place, way, weight, layer: 0, path: 0.0, turned: 0, guided: 0 };
                walk.follow(photon, &mut sums, &mut rng);
            }
            sums.fates
        })
        .collect();
    let share = 1.0 / (each * BATCHES) as f64;
    (0..absorptions.len()).map(|a| mean(batches.iter().map(|fates| &fates[a]), share)).collect()
}

/// Sum of batches times `share`.
fn mean<'a>(batches: impl Iterator<Item = &'a Fate>, share: f64) -> Fate {
    let mut sum = Fate::default();
    let add = |sum: &mut Side, side: &Side| {
        sum.total += share * side.total;
        for i in 0..FREQUENCIES {
            sum.spread[i] += share * side.spread[i];
            sum.slopes[i] += share * side.slopes[i];
        }
        for i in 0..DIRECTIONS {
            sum.directions[i] += share * side.directions[i];
        }
    };
    for fate in batches {
        add(&mut sum.up, &fate.up);
        add(&mut sum.down, &fate.down);
        sum.straight_up += share * fate.straight_up;
        sum.straight_down += share * fate.straight_down;
    }
    sum
}
