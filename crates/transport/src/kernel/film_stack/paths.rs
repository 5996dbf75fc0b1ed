//! Paths of light that films, and what lies below them, send to the lens: what the contrast of speckle in packs depends on.
//!
//! Light that has gone a way s in matter is exp(-a s) of itself where the matter absorbs a more (Beer and Lambert), so the kernel's own answers for
//! more absorption are the Laplace transform of the paths in each row. Two of them (`MORE_PER_MM`) give the law whose logarithm is normal and
//! that has this transform there. Paths are optical ones over the film's index: air counts by 1 / n, a tablet by its own index over the film's.
//!
//! Neglected: that light out of film alone and light that has crossed a gap may lie apart by twice the gap, two laws rather than one.

use std::sync::LazyLock;

use procedural::{Film, Medium};

use super::{FilmStack, FilmStackKernel, FilmStackSpread, spread};
use crate::kernel::path_law::PathLaw;
use crate::kernel::widths::{BASIS, PACK_SPREAD_MM};
use numerics::lanes::{exp, ln};

/// Absorption on top of the film's own at which the paths' transform is asked: of pairs from 0.05 and 0.4 to 0.8 and 6.4 the
/// one whose law is nearest to the contrasts that the Monte Carlo counts [mm^-1].
const MORE_PER_MM: [f32; 2] = [0.15, 1.2];
/// Least light over that of the line's own row that has paths of its own [1].
const DARK: f32 = 1e-6;

/// Answers about paths, one stack after the other.
#[derive(Debug, Clone)]
pub struct FilmPaths {
    /// For each step of more absorption: what lies below differs.
    kernels: Box<[FilmStackKernel; 2]>,
}

impl Default for FilmPaths {
    fn default() -> Self {
        Self { kernels: Box::new(std::array::from_fn(|_| FilmStackKernel::new())) }
    }
}

impl FilmPaths {
    /// The paths of light of `stack`, which spreads it like `spread`, that is seen `away_mm` from the line on either side; line and lens blur it by
    /// `blur_mm2`. Where no light comes so far they are those of the place before.
    pub fn laws<const N: usize>(
        &mut self,
        stack: &FilmStack,
        spread: &FilmStackSpread,
        blur_mm2: f32,
        away_mm: [f32; N],
    ) -> [PathLaw; N] {
        let all = seen(stack, spread, blur_mm2, away_mm);
        let [first, second] =
            std::array::from_fn(|step| absorbed(&mut self.kernels[step], stack, MORE_PER_MM[step], blur_mm2, away_mm));
        let mut before = PathLaw { crowding: stack.medium.sigma_i.max(1.0), deviation: 1.0 };
        std::array::from_fn(|n| {
            if all[n] > DARK * all[0] && second[n] > 0.0 {
                let lost = [first[n], second[n]].map(|light| -ln((light / all[n]).min(1.0)));
                before = PathTable::get().law(lost);
            }
            before
        })
    }
}

/// Light that is seen in places on both sides of the line, where matter absorbs so much `more_per_mm`.
fn absorbed<const N: usize>(
    kernel: &mut FilmStackKernel,
    stack: &FilmStack,
    more_per_mm: f32,
    blur_mm2: f32,
    away_mm: [f32; N],
) -> [f32; N] {
    let FilmStack { medium, film, .. } = stack;
    let n = medium.n_eff;
    let under = Medium { mu_a: film.under.mu_a + more_per_mm * film.under.n_eff / n, ..film.under };
    let under = if film.under.gloss.is_metal() { film.under } else { under };
    let darker = Medium { mu_a: medium.mu_a + more_per_mm, ..*medium };
    let stack = FilmStack { medium: darker, film: Film { under, ..*film }, ..*stack };
    kernel.remember(&stack);
    seen(&stack, &spread(kernel, &stack, more_per_mm / n), blur_mm2, away_mm)
}

/// Light of `stack` that is seen in places on both sides of the line.
fn seen<const N: usize>(stack: &FilmStack, answer: &FilmStackSpread, blur_mm2: f32, away_mm: [f32; N]) -> [f32; N] {
    let through = stack.seen_beside();
    let mut light = [0.0; N];
    for j in 0..BASIS {
        let variance = PACK_SPREAD_MM[j] * PACK_SPREAD_MM[j] + blur_mm2;
        let height = |off: f32| exp((-0.5 * off * off / variance).max(-80.0)) / variance.sqrt();
        let [film, below] = [answer.enter[j] * answer.exit[j], answer.passes * answer.below[j]];
        for (light, away) in light.iter_mut().zip(away_mm) {
            *light += film * 2.0 * height(away) + below * (height(away - through) + height(-away - through));
        }
    }
    light
}

/// Nodes of the table: of the logarithm of what is lost first, and of that of [`spread_of`].
const NODES: [usize; 2] = [64, 96];
/// Range of the logarithm of what is lost first.
const LOST: [f32; 2] = [-6.0, 2.5];
/// Range of the logarithm of [`spread_of`].
const SPREAD: [f32; 2] = [-3.0, 7.0];
/// Range of the standard deviation of the paths' logarithm.
const DEVIATION: [f64; 2] = [0.05, 3.0];

/// Laws of paths by what is lost of them.
struct PathTable(Vec<[f32; 2]>);

impl PathTable {
    fn get() -> &'static Self {
        static TABLE: LazyLock<PathTable> = LazyLock::new(PathTable::make);
        &TABLE
    }

    /// For each share lost, deviations are tried from the least on: the greater one is, the less does more absorption take.
    fn make() -> Self {
        let step = f64::from(MORE_PER_MM[1] / MORE_PER_MM[0]);
        let mut laws = Vec::with_capacity(NODES[0] * NODES[1]);
        for i in 0..NODES[0] {
            let lost = libm::exp(f64::from(node(LOST, i, NODES[0])));
            let tried: Vec<[f64; 3]> = (0..64)
                .map(|k| {
                    let deviation = DEVIATION[0] + (DEVIATION[1] - DEVIATION[0]) * f64::from(k) / 63.0;
                    let middle = middle_that_loses(lost, deviation);
                    let more = lost_by(middle + libm::log(step), deviation);
                    [deviation, middle, libm::log(((step - more / lost) / lost).max(1e-9))]
                })
                .collect();
            for k in 0..NODES[1] {
                let spread = f64::from(node(SPREAD, k, NODES[1]));
                let at = tried.partition_point(|law| law[2] < spread).clamp(1, tried.len() - 1);
                let [a, b] = [tried[at - 1], tried[at]];
                let part = ((spread - a[2]) / (b[2] - a[2]).max(1e-12)).clamp(0.0, 1.0);
                let mix = |of: usize| (a[of] + (b[of] - a[of]) * part) as f32;
                laws.push([mix(0), mix(1)]);
            }
        }
        Self(laws)
    }

    /// The law of paths of which so much is `lost`, as a negative logarithm, at each of [`MORE_PER_MM`].
    fn law(&self, lost: [f32; 2]) -> PathLaw {
        let [first, second] = lost.map(|lost| lost.max(1e-6));
        let place = |value: f32, [low, high]: [f32; 2], nodes: usize| {
            let at = ((value - low) / (high - low)).clamp(0.0, 1.0) * (nodes - 1) as f32;
            let below = (at as usize).min(nodes - 2);
            (below, at - below as f32)
        };
        let spread = ln(spread_of([first, second]).max(1e-6));
        let ((i, across), (k, along)) = (place(ln(first), LOST, NODES[0]), place(spread, SPREAD, NODES[1]));
        let read = |of: usize| {
            let at = |i: usize, k: usize| self.0[i * NODES[1] + k][of];
            let row = |i: usize| at(i, k) + (at(i, k + 1) - at(i, k)) * along;
            row(i) + (row(i + 1) - row(i)) * across
        };
        let (deviation, middle) = (read(0), read(1) - ln(MORE_PER_MM[0]));
        // Of a law whose logarithm is normal.
        let crowding = exp(0.25 * deviation * deviation - middle) / (2.0 * deviation * std::f32::consts::PI.sqrt());
        PathLaw { crowding, deviation }
    }
}

/// What more absorption takes less than it would of paths that are all as long, over what the first takes: about 28 of the paths' variance over
/// their mean squared [1].
fn spread_of([first, second]: [f32; 2]) -> f32 {
    (MORE_PER_MM[1] / MORE_PER_MM[0] - second / first) / first
}

/// A node of a range.
fn node([low, high]: [f32; 2], i: usize, nodes: usize) -> f32 {
    low + (high - low) * i as f32 / (nodes - 1) as f32
}

/// Negative logarithm of what is left of paths whose logarithm is normal, after absorption by which a path of the logarithm `middle`, which is the
/// mean, loses a factor of e.
fn lost_by(middle: f64, deviation: f64) -> f64 {
    let steps = 32;
    let (mut left, mut all) = (0.0, 0.0);
    for i in 0..steps {
        let z = -5.0 + 10.0 * (f64::from(i) + 0.5) / f64::from(steps);
        let weight = libm::exp(-0.5 * z * z);
        left += weight * libm::exp(-libm::exp(middle + deviation * z));
        all += weight;
    }
    -libm::log(left / all)
}

/// The mean logarithm of paths of which so much is `lost`.
fn middle_that_loses(lost: f64, deviation: f64) -> f64 {
    let (mut low, mut high) = (-25.0, 25.0);
    for _ in 0..30 {
        let middle = 0.5 * (low + high);
        if lost_by(middle, deviation) < lost { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use rand::RngExt;

    use super::*;

    /// Laws drawn over what light in packs may be come back from what absorption takes of them.
    #[test]
    fn laws_come_back_from_what_is_lost() {
        let mut rng = procedural::Stream::root(53).rng();
        for _ in 0..200 {
            let (middle, deviation) = (rng.random_range(-2.5..1.5f64), rng.random_range(0.2..1.4f64));
            let lost = MORE_PER_MM.map(|more| lost_by(middle + libm::log(f64::from(more)), deviation) as f32);
            let law = PathTable::get().law(lost);
            let crowding =
                libm::exp(0.25 * deviation * deviation - middle) / (2.0 * deviation * std::f64::consts::PI.sqrt());
            let off = f64::from(law.crowding) / crowding - 1.0;
            assert!(off.abs() < 0.05, "{middle} {deviation}: {} for {crowding}", law.crowding);
            assert!((f64::from(law.deviation) - deviation).abs() < 0.05, "{middle} {deviation}: {}", law.deviation);
        }
    }
}
