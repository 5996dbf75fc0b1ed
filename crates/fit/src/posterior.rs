//! Posterior of the scores given the statistics of real scans: density, mode, draws.
//!
//! ln p(u | s) = -u^2 / 2 - sum over scans (n + 1) / 2 ln(1 + (s - m(u))^T V^-1 (s - m(u)) / n), where m is the mean of
//! the [`Emulator`]: what a covariance of n degrees of freedom leaves of a normal law (Sellentin and Heavens 2016).
//!
//! **Misfit.** A real scan has things that no key of the recipe makes. Its parts may differ more than those of
//! simulated scans. V is C with the excess of the squared standard errors that halves give (`rounds`) added to its
//! variances, and with more, v' = max(v, z^2 / 4), wherever the scan lies z > 3.5 deviations beyond what any scores
//! reach. That is first asked of single statistics, so that one that is far off does not spoil the directions that it
//! has a small part in, then of the principal directions that are left. Both are found by turns with the mode; before
//! the first mode, a statistic is out of reach where it lies as far beyond all scans of the kernel. This is the
//! variance adjustment of robust synthetic likelihood (Frazier and Drovandi 2021) with its greatest value in place of a
//! draw. Without it, one statistic out of reach would outvote all others.
//!
//! **Several scans.** Scores of the bench are one for all scans, scores of matter each scan's own, unless all scans are
//! of one object.

use base::{Stream, normal};
use hammer_and_sample::{DifferentialEvolution, MinChainLen, Mixture, Model, Serial, Stretch, sample};
use nalgebra::{DMatrix, DVector};

use crate::emulator::{Directions, Emulator, cholesky};
use crate::prior::MOST_SCORE;

/// Residual beyond which a direction is out of reach [standard deviations].
const OUT_OF_REACH: f64 = 3.5;
/// Turns of mode and misfit.
const TURNS: usize = 8;
/// Steps of the search of a mode.
const MODE_STEPS: usize = 60;
/// Walkers for each score, and fewest of them.
const WALKERS_PER_SCORE: usize = 6;
const FEWEST_WALKERS: usize = 64;
/// Steps of each walker that are forgotten, and those that are kept.
const FORGOTTEN_STEPS: usize = 600;
const KEPT_STEPS: usize = 900;
/// Of the kept steps one in so many is handed out.
const THINNED: usize = 15;

/// Which scores belong to which scan.
#[derive(Debug, Clone)]
pub(crate) struct ScoreLayout {
    /// For each scan, the place of each key's score in the whole vector.
    places: Vec<Vec<usize>>,
    /// Length of the whole vector.
    pub length: usize,
}

impl ScoreLayout {
    /// For so many scans; keys for which `is_shared` says so have one score for all of them.
    pub fn new(is_shared: &[bool], scans: usize) -> Self {
        let mut length = 0;
        let mut shared = Vec::new();
        for is_shared in is_shared {
            shared.push(is_shared.then(|| {
                length += 1;
                length - 1
            }));
        }
        let places = (0..scans)
            .map(|_| {
                let place = |shared: &Option<usize>| {
                    shared.unwrap_or_else(|| {
                        length += 1;
                        length - 1
                    })
                };
                shared.iter().map(place).collect()
            })
            .collect();
        Self { places, length }
    }

    /// The scores of one scan.
    pub fn of_scan(&self, scan: usize, whole: &[f64]) -> Vec<f64> {
        self.places[scan].iter().map(|&place| whole[place]).collect()
    }

    /// Scans.
    pub fn scans(&self) -> usize {
        self.places.len()
    }

    /// The whole vector in which every scan has these scores.
    pub fn repeated(&self, scores: &[f64]) -> Vec<f64> {
        let mut whole = vec![0.0; self.length];
        for places in &self.places {
            places.iter().zip(scores).for_each(|(&place, &score)| whole[place] = score);
        }
        whole
    }
}

/// Statistics of a scan in the directions in which they scatter independently.
struct Whitened {
    /// `[directions, terms]`: terms to means.
    means: DMatrix<f64>,
    /// What the scan has.
    target: DVector<f64>,
}

/// The posterior near the region of an emulator.
pub(crate) struct Posterior<'a> {
    emulator: &'a Emulator,
    layout: &'a ScoreLayout,
    scans: Vec<Whitened>,
    /// The place of greatest density that was found.
    pub mode: Vec<f64>,
}

impl<'a> Posterior<'a> {
    /// Given the statistics `observed` `[scans][statistics]`, from the best of some whole vectors of scores to start
    /// at. `excess` `[scans][statistics]` is the variance, in squares of a statistic's scale, that real scans have
    /// beyond the scatter. It is `None` for simulated ones, which have nothing that no key makes: no misfit is looked
    /// for.
    pub fn new(
        emulator: &'a Emulator,
        layout: &'a ScoreLayout,
        observed: &[Vec<Option<f64>>],
        excess: Option<&[Vec<f64>]>,
        starts: &[Vec<f64>],
    ) -> Self {
        let own = |scan: usize| -> Vec<f64> {
            let scatter = emulator.covariance.diagonal();
            let more = |j: usize| excess.map_or(0.0, |excess| excess[scan][j]);
            scatter.iter().enumerate().map(|(j, variance)| variance + more(j)).collect()
        };
        let begin = |(scan, statistics): (usize, &Vec<Option<f64>>)| {
            let beyond = excess.map(|_| emulator.beyond(statistics));
            Whitened::new(emulator, statistics, &own(scan), beyond.as_deref())
        };
        let scans = observed.iter().enumerate().map(begin).collect();
        let mut posterior = Self { emulator, layout, scans, mode: vec![0.0; layout.length] };
        let best = |posterior: &Self, starts: &[Vec<f64>]| {
            let modes = starts.iter().map(|start| posterior.climb(start));
            let ranked = modes.map(|mode| (posterior.log_density(&mode), mode));
            ranked
                .max_by(|a, b| a.0.total_cmp(&b.0))
                .map_or_else(|| vec![0.0; posterior.layout.length], |(_, mode)| mode)
        };
        posterior.mode = best(&posterior, starts);
        for _ in 0..if excess.is_some() { TURNS } else { 0 } {
            for (scan, statistics) in observed.iter().enumerate() {
                let scores = layout.of_scan(scan, &posterior.mode);
                let off = emulator.off(&scores, statistics);
                let mut whitened = Whitened::new(emulator, statistics, &own(scan), Some(&off));
                whitened.widen(&emulator.features(&scores));
                posterior.scans[scan] = whitened;
            }
            let mut again: Vec<Vec<f64>> = starts.iter().take(2).cloned().collect();
            again.push(posterior.mode.clone());
            posterior.mode = best(&posterior, &again);
        }
        posterior
    }

    fn log_density(&self, whole: &[f64]) -> f64 {
        if whole.iter().any(|score| score.abs() > MOST_SCORE || !score.is_finite()) {
            return f64::NEG_INFINITY;
        }
        let mut sum = -0.5 * whole.iter().map(|score| score * score).sum::<f64>();
        let n = self.emulator.freedom;
        for (scan, whitened) in self.scans.iter().enumerate() {
            let f = self.emulator.features(&self.layout.of_scan(scan, whole));
            let q = (&whitened.target - &whitened.means * &f).norm_squared();
            sum -= 0.5 * (n + 1.0) * libm::log1p(q / n);
        }
        sum
    }

    /// Gradient of the density's negative logarithm at a place, and what Gauss and Newton have for its curvature.
    fn slope_and_curvature(&self, whole: &[f64]) -> (DVector<f64>, DMatrix<f64>) {
        let mut gradient = DVector::from_column_slice(whole);
        let mut normal = DMatrix::identity(whole.len(), whole.len());
        for (scan, whitened) in self.scans.iter().enumerate() {
            let scores = self.layout.of_scan(scan, whole);
            let f = self.emulator.features(&scores);
            let rest = &whitened.means * &f - &whitened.target;
            let slopes = &whitened.means * self.emulator.slopes(&scores);
            let n = self.emulator.freedom;
            let weight = (n + 1.0) / (n + rest.norm_squared());
            let (g, m) = (slopes.tr_mul(&rest) * weight, slopes.tr_mul(&slopes) * weight);
            let places = &self.layout.places[scan];
            for (i, &a) in places.iter().enumerate() {
                gradient[a] += g[i];
                for (j, &b) in places.iter().enumerate() {
                    normal[(a, b)] += m[(i, j)];
                }
            }
        }
        (gradient, normal)
    }

    /// A place of greatest density near `start` (Levenberg and Marquardt).
    fn climb(&self, start: &[f64]) -> Vec<f64> {
        let limit = MOST_SCORE - 0.01;
        let mut here: Vec<f64> = start.iter().map(|score| score.clamp(-limit, limit)).collect();
        let mut value = self.log_density(&here);
        let mut damping = 1e-2;
        for _ in 0..MODE_STEPS {
            let (gradient, normal) = self.slope_and_curvature(&here);
            let damped = &normal + DMatrix::from_diagonal(&normal.diagonal()) * damping;
            let step = cholesky(&damped).solve(&gradient);
            let next: Vec<f64> = here.iter().zip(step.iter()).map(|(u, s)| (u - s).clamp(-limit, limit)).collect();
            let found = self.log_density(&next);
            if found > value {
                let gain = found - value;
                (here, value, damping) = (next, found, damping * 0.3);
                if gain < 1e-9 {
                    break;
                }
            } else {
                damping *= 4.0;
                if damping > 1e8 {
                    break;
                }
            }
        }
        here
    }

    /// Standard deviation of each score by the curvature at the mode.
    pub fn deviations(&self) -> Vec<f64> {
        let (_, normal) = self.slope_and_curvature(&self.mode);
        cholesky(&normal).inverse().diagonal().iter().map(|variance| variance.sqrt()).collect()
    }

    /// Draws, by an ensemble of walkers that starts about the mode.
    pub fn draws(&self, stream: Stream) -> Vec<Vec<f64>> {
        let walkers = (WALKERS_PER_SCORE * self.layout.length).max(FEWEST_WALKERS) / 2 * 2;
        let (_, curvature) = self.slope_and_curvature(&self.mode);
        let spread = cholesky(&cholesky(&curvature).inverse());
        let start = |w: usize| {
            let mut rng = stream.child("walker").index(w as u64).rng();
            let z = DVector::from_fn(self.layout.length, |_, _| normal(&mut rng));
            let limit = MOST_SCORE - 0.05;
            let place = spread.l() * z;
            let place = self.mode.iter().zip(place.iter()).map(|(mode, d)| (mode + d).clamp(-limit, limit)).collect();
            (place, rng)
        };
        let gamma = 2.38 / (2.0 * self.layout.length as f64).sqrt();
        let moves = Mixture::from(((DifferentialEvolution::new(gamma, 1e-3), 2), (Stretch::default(), 1)));
        let steps = FORGOTTEN_STEPS + KEPT_STEPS;
        let (chain, _) = sample(self, &moves, (0..walkers).map(start), MinChainLen(steps * walkers), Serial);
        chain.chunks(walkers).skip(FORGOTTEN_STEPS).step_by(THINNED).flatten().cloned().collect()
    }
}

impl Model for Posterior<'_> {
    type Params = Vec<f64>;

    fn log_prob(&self, whole: &Self::Params) -> f64 {
        self.log_density(whole)
    }
}

impl Whitened {
    /// Of a scan whose statistics have these variances of their own, and lie so far off what scores reach.
    fn new(emulator: &Emulator, statistics: &[Option<f64>], variances: &[f64], off: Option<&[f64]>) -> Self {
        let which: Vec<usize> =
            (0..statistics.len()).filter(|&j| statistics[j].is_some() && emulator.known[j]).collect();
        let n = which.len();
        let mut covariance = emulator.covariance.select_rows(&which).select_columns(&which);
        for (a, &j) in which.iter().enumerate() {
            let off = off.map_or(0.0, |off| off[j] / variances[j].sqrt());
            covariance[(a, a)] = variances[j] * variance_of_misfit(off);
        }
        let directions = Directions::new(&covariance, &emulator.parts_of(&which)).to;
        let observed = DVector::from_fn(n, |a, _| statistics[which[a]].unwrap_or(0.0));
        let coefficients =
            DMatrix::from_fn(n, emulator.coefficients.nrows(), |a, t| emulator.coefficients[(t, which[a])]);
        let (means, target) = (&directions * coefficients, &directions * observed);
        Self { means, target }
    }

    /// Gives each direction in which the residual at terms `f` is out of reach the variance that it needs.
    fn widen(&mut self, f: &DVector<f64>) {
        let rest = &self.target - &self.means * f;
        for e in 0..rest.len() {
            let factor = variance_of_misfit(rest[e]).sqrt();
            self.target[e] /= factor;
            self.means.row_mut(e).unscale_mut(factor);
        }
    }
}

/// Variance, over that of the scatter, of what lies `off` deviations away.
fn variance_of_misfit(off: f64) -> f64 {
    if off.abs() > OUT_OF_REACH { 0.25 * off * off } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::emulator::ScoreRegion;
    use crate::emulator::tests::Polynomials;

    /// Changes a hidden scan's statistics and the variance that they have beyond the scatter.
    type Change<'a> = &'a dyn Fn(&mut [Option<f64>], &mut [f64]);

    /// How many of 250 scores of 50 hidden scans lie within their intervals of 90 %, and the mean variance of the
    /// posterior.
    fn held(seed: u64, curvature: f64, changed: Change) -> (f64, f64) {
        let law = Polynomials::new(seed, curvature);
        let scans = law.scans(700, seed);
        let region = ScoreRegion::prior(Polynomials::KEYS);
        let emulator = Emulator::new(&scans, &region.weights(&scans, Emulator::wanted(Polynomials::KEYS)), 1);
        let layout = ScoreLayout::new(&[true; Polynomials::KEYS], 1);
        let (mut held, mut variance) = (0.0, 0.0);
        for (n, scan) in law.scans(50, seed + 100).iter().enumerate() {
            let starts = [vec![0.0; Polynomials::KEYS], scans[0].scores.clone()];
            let (mut observed, mut excess) = (scan.statistics.clone(), vec![0.0; Polynomials::STATISTICS]);
            changed(&mut observed, &mut excess);
            let posterior = Posterior::new(&emulator, &layout, &[observed], Some(&[excess]), &starts);
            let draws = posterior.draws(Stream::root(seed).index(n as u64));
            for (key, score) in scan.scores.iter().enumerate() {
                let below = draws.iter().filter(|draw| draw[key] < *score).count() as f64 / draws.len() as f64;
                held += f64::from(u8::from((0.05..=0.95).contains(&below)));
                let mean = draws.iter().map(|draw| draw[key]).sum::<f64>() / draws.len() as f64;
                variance += draws.iter().map(|draw| (draw[key] - mean) * (draw[key] - mean)).sum::<f64>()
                    / (draws.len() as f64 * 250.0);
            }
        }
        (held, variance)
    }

    /// Least of 250 that hold by chance where 90 % do (alpha 1e-4 were they independent; the five scores of a scan go
    /// together somewhat, and seeds are fixed).
    const LEAST: f64 = 250.0 * 0.9 - 3.9 * 4.74;

    /// The gradient is that of the density, wherever its misfit puts it: by differences, at random places.
    #[test]
    fn the_gradient_is_that_of_the_density() {
        let law = Polynomials::new(15, 0.3);
        let scans = law.scans(300, 15);
        let emulator = Emulator::new(&scans, &vec![1.0; scans.len()], 1);
        let layout = ScoreLayout::new(&[true, true, true, false, false], 2);
        let observed: Vec<_> = law.scans(2, 16).into_iter().map(|scan| scan.statistics).collect();
        let excess = vec![vec![0.0; Polynomials::STATISTICS]; 2];
        let posterior = Posterior::new(&emulator, &layout, &observed, Some(&excess), &[vec![0.0; 7]]);
        let mut rng = Stream::root(17).rng();
        for _ in 0..20 {
            let place: Vec<f64> = (0..7).map(|_| normal(&mut rng)).collect();
            let (gradient, _) = posterior.slope_and_curvature(&place);
            for score in 0..7 {
                let moved = |by: f64| {
                    let mut moved = place.clone();
                    moved[score] += by;
                    posterior.log_density(&moved)
                };
                let difference = (moved(-1e-5) - moved(1e-5)) / 2e-5;
                assert!(
                    (difference - gradient[score]).abs() < 1e-5 * (1.0 + gradient.amax()),
                    "{difference} {gradient}"
                );
            }
        }
        let (gradient, _) = posterior.slope_and_curvature(&posterior.mode);
        assert!(gradient.amax() < 0.01, "the mode has a gradient of {gradient}");
    }

    /// Intervals of 90 % hold scores that were drawn from the prior in 90 % of all cases (alpha 1e-4 on either side),
    /// for laws that are straight and for curved ones, in which valleys bend.
    #[test]
    fn intervals_hold_the_truth() {
        for (seed, curvature) in [(11, 0.0), (12, 0.3)] {
            let (held, variance) = held(seed, curvature, &|_, _| ());
            assert!((LEAST..450.0 - LEAST).contains(&held), "{held} of 250, curvature {curvature}");
            assert!(variance < 0.5, "the scans tell the scores: {variance}");
        }
    }

    /// A statistic that no scores reach tells nothing, and takes nothing along of the others, by whose scatter it goes;
    /// nor does one that varies much within the scan.
    #[test]
    #[ignore = "long"]
    fn what_is_out_of_reach_spoils_nothing() {
        for (seed, curvature) in [(13, 0.0), (14, 0.3)] {
            let without = held(seed, curvature, &|statistics, _| statistics[4] = None);
            for far in [200.0, -20.0] {
                let (held, variance) = held(seed, curvature, &|statistics, _| {
                    statistics[4] = statistics[4].map(|value| value + far);
                });
                assert!(held >= LEAST, "{held} of 250, {far} off");
                assert!((variance / without.1 - 1.0).abs() < 0.25, "{variance} without it {}", without.1);
            }
            let (held, variance) = held(seed, curvature, &|_, excess| excess[4] = 1e4);
            assert!(held >= LEAST, "{held} of 250, of no certainty");
            assert!((variance / without.1 - 1.0).abs() < 0.1, "{variance} without it {}", without.1);
        }
    }
}
