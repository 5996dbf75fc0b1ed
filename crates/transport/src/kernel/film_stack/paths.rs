//! Paths of light that films, and what lies below them, send to the lens: what the contrast of speckle in packs depends
//! on.
//!
//! Light that has gone a way s in matter is exp(-a s) of itself where the matter absorbs a more (Beer and Lambert), so
//! the kernel's own answers for more absorption are the Laplace transform of the paths in each row. Two of them
//! (`more_per_mm`) give the law whose logarithm is normal and that has this transform there. Light that the film alone
//! has turned, light that has crossed the air below it and light that foil mirrors straight have laws of their own,
//! which lie apart by twice the air. Paths are optical ones over the film's index: air counts by 1 / n, a tablet by its
//! own index over the film's.
//!
//! Neglected: that light out of sealed film and what its foil mirrors are of two kinds, that light which has crossed
//! the air once more is a third one.

use std::sync::LazyLock;

use base::{Film, Medium};
use multiversion::multiversion;

use super::adding::flow;
use super::spectrum::Spectrum;
use super::{FilmStack, FilmStackKernel, mirrored_mm};
use crate::kernel::path_law::PathLaw;
use crate::kernel::widths::{BASIS, PACK_SPREAD_MM};
use numerics::lanes::{exp, ln};

/// Absorption on top of the film's own at which the paths' transform is asked first, over foil and over a tablet, whose
/// paths are longer: of pairs from 0.05 and 0.4 to 0.8 and 6.4 those whose laws are nearest to the contrasts that the
/// Monte Carlo counts [mm^-1].
const MORE_PER_MM: [f32; 2] = [0.2, 0.15];
/// The second absorption over the first [1].
const MORE_AGAIN: f32 = 8.0;
/// Least share that more absorption leaves of light [1].
const LEAST_LEFT: f32 = 1e-6;
/// Least light over that of the line's own row that has paths of its own [1].
const DARK: f32 = 1e-6;

/// Answers about paths, one stack after the other.
#[derive(Debug, Clone)]
pub struct FilmPaths {
    /// For no more absorption and each step of it: what lies below differs.
    kernels: Box<[FilmStackKernel; 3]>,
}

impl Default for FilmPaths {
    fn default() -> Self {
        Self { kernels: Box::new(std::array::from_fn(|_| FilmStackKernel::new())) }
    }
}

impl FilmPaths {
    /// The paths of light of `stack` that is seen `away_mm` from the line on either side; line and lens blur it by
    /// `blur_mm2`. Where no light comes so far they are those of the place before.
    pub fn laws<const N: usize>(&mut self, stack: &FilmStack, blur_mm2: f32, away_mm: [f32; N]) -> [PathLaw; N] {
        let more_per_mm = MORE_PER_MM[usize::from(!stack.film.under.gloss.is_metal())];
        let least = least_deviations(stack);
        let [all, first, second] = std::array::from_fn(|step| {
            let more_per_mm = more_per_mm * [0.0, 1.0, MORE_AGAIN][step];
            seen(&mut self.kernels[step], &absorbing(stack, more_per_mm), more_per_mm, blur_mm2, away_mm)
        });
        let brightest = all.iter().map(|light| light[0]).sum::<f32>();
        let mut before = PathLaw { crowding: stack.medium.sigma_i.max(1.0), deviation: 1.0, equal: 0.0, light: 0.0 };
        std::array::from_fn(|n| {
            let light: f32 = all.iter().map(|of| of[n]).sum();
            if light > DARK * brightest {
                let parts = std::array::from_fn(|of| {
                    let left = |after: &[[f32; N]; KINDS]| (after[of][n] / all[of][n]).clamp(LEAST_LEFT, 1.0);
                    let lost = [&first, &second].map(|after| -ln(left(after)));
                    let law = match of {
                        _ if all[of][n] <= 0.0 => LogNormal { middle: 0.0, deviation: 1.0 },
                        STRAIGHT => LogNormal { middle: ln(lost[0].max(1e-6)), deviation: 0.0 },
                        _ => PathTable::get().law(lost),
                    };
                    let deviation = law.deviation.max(least[of]);
                    (all[of][n] / light, LogNormal { middle: law.middle - ln(more_per_mm), deviation })
                });
                before = mixture(&parts);
            }
            PathLaw { light, ..before }
        })
    }
}

/// `stack`, all of whose matter absorbs so much more, by paths over the film's index.
fn absorbing(stack: &FilmStack, more_per_mm: f32) -> FilmStack {
    let FilmStack { medium, film, .. } = stack;
    let under = match film.under.gloss.is_metal() {
        true => film.under,
        false => Medium { mu_a: film.under.mu_a + more_per_mm * film.under.n_eff / medium.n_eff, ..film.under },
    };
    let darker = Medium { mu_a: medium.mu_a + more_per_mm, ..*medium };
    FilmStack { medium: darker, film: Film { under, ..*film }, ..*stack }
}

/// Light of a film stack towards the lens by what it went through, as weights of the fixed widths times radiance
/// factors [1].
#[derive(Debug, Clone, Copy)]
struct FilmLight {
    /// Turned by the film, never below it.
    alone: [f32; BASIS],
    /// Turned by the film after it has been below, or in film that is sealed to foil.
    passed: [f32; BASIS],
    /// Of other light from what lies below, as it leaves the film.
    below: [f32; BASIS],
    /// Never turned by the film, mirrored by foil: as narrow as the laser's line [1].
    straight: f32,
    /// The film's lower side, as foil shows it [1].
    mirrored: f32,
    /// Its standard deviation [mm].
    mirrored_mm: f32,
}

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn light(kernel: &FilmStackKernel, stack: &FilmStack, air_per_mm: f32) -> FilmLight {
    let flow = flow(&kernel.tables, stack, air_per_mm);
    let passed: Spectrum = std::array::from_fn(|i| flow.towards[i] - flow.alone[i]);
    let later: Spectrum = std::array::from_fn(|i| flow.passes * (flow.below[i] - flow.straight));
    FilmLight {
        alone: kernel.back.weights(&flow.alone),
        passed: kernel.back.weights(&passed),
        below: kernel.back.weights(&later),
        straight: flow.passes * flow.straight,
        mirrored: flow.passes * flow.mirrored,
        mirrored_mm: mirrored_mm(stack, flow.mirrored_twice),
    }
}

/// Kinds of light whose paths are laws of their own: turned by the film alone, below the film before it was turned last
/// or seen, shown by foil of the film's lower side, and straight by way of foil.
const KINDS: usize = 4;
/// The last of them: all of its paths are equal.
const STRAIGHT: usize = 3;

/// Least deviations of the logarithm of the paths of each of them: where little light comes, its transforms tell of the
/// fit of widths rather than of paths [1].
fn least_deviations(stack: &FilmStack) -> [f32; KINDS] {
    let turns = stack.medium.sigma_i * stack.film.thickness_mm;
    [0.6 * turns / (1.0 + turns), 0.25, 0.1, 0.0]
}

/// Light of `stack` that is seen in places on both sides of the line, by [`KINDS`].
fn seen<const N: usize>(
    kernel: &mut FilmStackKernel,
    stack: &FilmStack,
    air_per_mm: f32,
    blur_mm2: f32,
    away_mm: [f32; N],
) -> [[f32; N]; KINDS] {
    kernel.tables.remember_stack(stack);
    let FilmLight { alone, passed, below, straight, mirrored, mirrored_mm } =
        light(kernel, stack, air_per_mm / stack.medium.n_eff);
    let (through, image) = (stack.seen_beside(), stack.mirrored_beside());
    let height = |off: f32, variance: f32| exp((-0.5 * off * off / variance).max(-80.0)) / variance.sqrt();
    let both =
        |away: f32, beside: f32, variance: f32| height(away - beside, variance) + height(-away - beside, variance);
    let mut light = [[0.0; N]; KINDS];
    for j in 0..BASIS {
        let variance = PACK_SPREAD_MM[j] * PACK_SPREAD_MM[j] + blur_mm2;
        for (n, away) in away_mm.into_iter().enumerate() {
            let level = both(away, 0.0, variance);
            light[0][n] += alone[j] * level;
            light[1][n] += passed[j] * level + below[j] * both(away, through, variance);
        }
    }
    for (n, away) in away_mm.into_iter().enumerate() {
        light[2][n] = mirrored * both(away, image, mirrored_mm * mirrored_mm + blur_mm2);
        light[STRAIGHT][n] = straight * both(away, through, blur_mm2);
    }
    light
}

/// A law of paths whose logarithm is normal.
#[derive(Debug, Clone, Copy)]
struct LogNormal {
    /// Mean logarithm [ln mm].
    middle: f32,
    /// Its standard deviation [1].
    deviation: f32,
}

/// The paths of light of some kinds, shares of it, together.
///
/// Densities of two such laws, multiplied and added up over all paths, are in closed form: with the logarithms' means m
/// and m' and variances v and v', exp(-(m - m')^2 / (2 (v + v'))) / sqrt(2 pi (v + v')) exp(-(m v' + m' v) / (v + v') +
/// v v' / (2 (v + v'))).
fn mixture(parts: &[(f32, LogNormal); KINDS]) -> PathLaw {
    let (mut crowding, mut equal, mut mean, mut square) = (0.0, 0.0, 0.0, 0.0);
    for (share, a) in parts {
        mean += share * a.middle;
        square += share * (a.middle * a.middle + a.deviation * a.deviation);
        for (other, b) in parts {
            let (v, w) = (a.deviation * a.deviation, b.deviation * b.deviation);
            if v + w <= 0.0 {
                equal += share * other;
                continue;
            }
            let (apart, both) = (a.middle - b.middle, v + w);
            let exponent = -0.5 * apart * apart / both - (a.middle * w + b.middle * v - 0.5 * v * w) / both;
            crowding += share * other * exp(exponent.clamp(-80.0, 80.0)) / (std::f32::consts::TAU * both).sqrt();
        }
    }
    PathLaw { crowding, deviation: (square - mean * mean).max(0.0).sqrt(), equal, light: 1.0 }
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

    /// For each share lost, deviations are tried from the least on: the greater one is, the less does more absorption
    /// take.
    fn make() -> Self {
        let step = f64::from(MORE_AGAIN);
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

    /// The law of paths of which so much is `lost`, as a negative logarithm, by the first absorption and by the second;
    /// over 1 / the first absorption.
    fn law(&self, lost: [f32; 2]) -> LogNormal {
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
        LogNormal { middle: read(1), deviation: read(0) }
    }
}

/// What more absorption takes less than it would of paths that are all as long, over what the first takes: about 28 of
/// the paths' variance over their mean squared [1].
fn spread_of([first, second]: [f32; 2]) -> f32 {
    (MORE_AGAIN - second / first) / first
}

/// A node of a range.
fn node([low, high]: [f32; 2], i: usize, nodes: usize) -> f32 {
    low + (high - low) * i as f32 / (nodes - 1) as f32
}

/// Negative logarithm of what is left of paths whose logarithm is normal, after absorption by which a path of the
/// logarithm `middle`, which is the mean, loses a factor of e.
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

    /// Of kinds drawn at random, the closed form against the sum over paths in small steps; light of equal paths counts
    /// by itself.
    #[test]
    fn mixtures_are_as_crowded_as_their_densities() {
        let mut rng = base::Stream::root(55).rng();
        for _ in 0..100 {
            let mut parts = [(); KINDS].map(|()| {
                let law = LogNormal { middle: rng.random_range(-2.0..2.0), deviation: rng.random_range(0.1..1.2) };
                (rng.random_range(0.05..1.0f32), law)
            });
            parts[STRAIGHT].1.deviation = 0.0;
            let all: f32 = parts.iter().map(|part| part.0).sum();
            parts.iter_mut().for_each(|part| part.0 /= all);
            let density = |of: usize, logarithm: f64| {
                let (share, LogNormal { middle, deviation }) = parts[of];
                let z = (logarithm - f64::from(middle)) / f64::from(deviation);
                let width = f64::from(deviation) * std::f64::consts::TAU.sqrt();
                f64::from(share) * libm::exp(-0.5 * z * z - logarithm) / width
            };
            let spread_out = |logarithm: f64| (0..STRAIGHT).map(|of| density(of, logarithm)).sum::<f64>();
            let steps = 4000;
            let step = 24.0 / f64::from(steps);
            let sum: f64 = (0..steps)
                .map(|i| -12.0 + step * (f64::from(i) + 0.5))
                .map(|logarithm| spread_out(logarithm).powi(2) * libm::exp(logarithm) * step)
                .sum();
            let (share, LogNormal { middle, .. }) = parts[STRAIGHT];
            let expected = sum + 2.0 * f64::from(share) * spread_out(middle.into());
            let law = mixture(&parts);
            assert!((f64::from(law.crowding) / expected - 1.0).abs() < 1e-3, "{parts:?}: {law:?} for {expected}");
            assert!((law.equal - share * share).abs() < 1e-6, "{parts:?}: {law:?}");
        }
    }

    /// Laws drawn over what light in packs may be come back from what absorption takes of them.
    #[test]
    fn laws_come_back_from_what_is_lost() {
        let mut rng = base::Stream::root(53).rng();
        for _ in 0..200 {
            let (middle, deviation) = (rng.random_range(-4.4..-0.4f64), rng.random_range(0.2..1.4f64));
            let lost = [1.0, MORE_AGAIN].map(|more| lost_by(middle + libm::log(f64::from(more)), deviation) as f32);
            let law = PathTable::get().law(lost);
            assert!((f64::from(law.middle) - middle).abs() < 0.06, "{middle} {deviation}: {}", law.middle);
            assert!((f64::from(law.deviation) - deviation).abs() < 0.05, "{middle} {deviation}: {}", law.deviation);
        }
    }
}
