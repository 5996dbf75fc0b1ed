//! Reference Monte Carlo of the transport equation.
//!
//! Model: radiance in plane layers ([`Stack`]) with the three laws of [`Scattering`](transport::stack::Scattering) and
//! Fresnel's law at every plane where the index changes. No approximation but chance: every number comes with its
//! standard error, from batches of photons. Batch b draws from stream (seed, b) and results are added in the order of
//! batches, so an answer is the same for any number of threads.
//!
//! Towards the lens a next-event estimate is taken at each collision: the density with which light would be scattered
//! straight to the lens, times what gets through. It needs dispersed fibres; parallel ones (dispersion 0) send light
//! to a point with probability zero.

mod bilinear_patch;
mod body;
mod foil;
mod height_cells;
pub mod line_response;
pub mod next_event;
mod pack;
pub mod plane_layers;
mod stack_observer;
pub mod tracker;

use base::Stream;
use glam::DVec3;
use rand::Rng;
use rayon::prelude::*;

pub use self::line_response::line_response;
use self::plane_layers::{StackGeometry, StackObserver};
use self::stack_observer::StackCounts;
pub use self::stack_observer::{PATH_STEPS, step_path_mm};
use self::tracker::{Geometry, Photon};
use crate::phase::disc;
use transport::answer::{Answer, Question};
use transport::fresnel::fresnel_dielectric;
use transport::stack::Stack;

/// Independent batches that standard errors are taken from.
const BATCHES: u64 = 128;
/// Photons of a batch after which progress is told.
const WATCHED: u64 = 20_000;
/// Path after which a photon is given up where absorption cannot end it [mm].
const LONGEST_MM: f64 = 1e6;

/// How long to walk.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Effort {
    /// Photons, rounded up to whole batches.
    pub photons: u64,
    /// Seed of all chance.
    pub seed: u64,
}

impl Default for Effort {
    fn default() -> Self {
        Self { photons: 1_000_000, seed: 0 }
    }
}

impl Effort {
    /// Photons that are really walked.
    pub fn walked(self) -> u64 {
        self.each() * BATCHES
    }

    /// Photons of a batch.
    fn each(self) -> u64 {
        self.photons.div_ceil(BATCHES).max(1)
    }
}

/// Monte Carlo's answer about `stack`.
pub fn solve(stack: &Stack, question: &Question, effort: Effort) -> Answer {
    solve_watched(stack, question, effort, &|_| ())
}

/// As [`solve`]; tells `watch` now and then how many photons more were walked.
pub(crate) fn solve_watched(
    stack: &Stack,
    question: &Question,
    effort: Effort,
    watch: &(dyn Fn(u64) + Sync),
) -> Answer {
    let counts = counted(stack, question, effort, watch, |counts| counts);
    stack_observer::answer(&counts, effort.each(), stack, question)
}

/// Light that the lens sees in each row of `question`, by length of path ([`step_path_mm`]), in no particular unit:
/// what the contrast of speckle depends on. Paths are optical ones over the first layer's index, in all layers, gaps of
/// air included. Where light is not estimated towards the lens but counted, all within `half_angle` of it counts [rad]:
/// what foil mirrors far below a film is seen smeared by so much.
pub fn seen_paths(stack: &Stack, question: &Question, effort: Effort, half_angle: f64) -> Vec<[f64; PATH_STEPS]> {
    let with_paths = |counts: StackCounts| counts.with_paths(stack, question, half_angle);
    let counts = counted(stack, question, effort, &|_| (), with_paths);
    let mut sum = vec![[0.0; PATH_STEPS]; 2 * question.rows + 1];
    for rows in counts.into_iter().map(StackCounts::into_paths) {
        for (row, part) in sum.iter_mut().zip(rows) {
            row.iter_mut().zip(part).for_each(|(sum, part)| *sum += part);
        }
    }
    sum
}

/// What each batch counts, with counters that `asked` may ask for more.
fn counted(
    stack: &Stack,
    question: &Question,
    effort: Effort,
    watch: &(dyn Fn(u64) + Sync),
    asked: impl Fn(StackCounts) -> StackCounts + Sync,
) -> Vec<StackCounts> {
    let geometry = StackGeometry::new(stack, LONGEST_MM);
    let each = effort.each();
    (0..BATCHES)
        .into_par_iter()
        .map(|batch| {
            let stream = Stream::root(effort.seed).child("transport").child("path").index(batch);
            // Streams of their own: the width of the line changes no walk.
            let (mut rng, mut line) = (stream.rng(), stream.child("line").rng());
            let mut count = asked(StackCounts::new(&geometry, stack, question));
            for walked in 1..=each {
                let (photon, thrown) = enter(stack, question, &mut rng);
                count.begin(thrown, &mut line);
                let photon = coated(photon, stack.layers[0].coat, &mut count);
                geometry.track(photon, &mut count, &mut rng);
                if walked % WATCHED == 0 {
                    watch(WATCHED);
                }
            }
            watch(each % WATCHED);
            count
        })
        .collect()
}

/// A photon that has passed the first layer's coat.
fn coated(photon: Photon, coat: f64, count: &mut StackCounts) -> Photon {
    count.absorb(0, photon.weight * (1.0 - coat));
    Photon { weight: photon.weight * coat, ..photon }
}

/// A photon below the surface at the origin, and the share that the first surface threw back.
fn enter(stack: &Stack, question: &Question, rng: &mut impl Rng) -> (Photon, f64) {
    let direction = match question.incidence {
        Some(angle) => {
            let (sin, cos) = libm::sincos(angle);
            let (up, along) = libm::sincos(question.incidence_azimuth);
            DVec3::new(sin * along, sin * up, -cos)
        }
        None => {
            let (x, y, s) = disc(rng);
            DVec3::new(x, y, -(1.0 - s).sqrt())
        }
    };
    let n = stack.layers[0].n;
    let (thrown, cosine) = fresnel_dielectric(stack.above, n, -direction.z);
    let ratio = stack.above / n;
    let direction = DVec3::new(direction.x * ratio, direction.y * ratio, -cosine);
    let position = DVec3::ZERO;
    (Photon { position, direction, weight: 1.0 - thrown, layer: 0, path: 0.0, turned: 0, guided: 0 }, thrown)
}
