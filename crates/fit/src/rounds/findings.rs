//! Findings at the end of a fit: quantiles, widths and correlations of the posterior's draws, each real scan beside
//! simulated ones, and the distributions that the recipe gets.

use nalgebra::DVector;
use recipe::Recipe;

use super::{Fitter, InferenceOutcome};
use crate::emulator::{Emulator, ScoreRegion, Simulation, varies};
use crate::observation::RealScan;
use crate::prior::FitKey;
use crate::result::{Fit, FittedKey, KeyState, MapsOfScan, ScanFit, StatisticFit, short};

/// Scores of the 5 and 95 % quantiles of the standard normal law.
const TAIL: f64 = 1.644_853_626_951_472_2;
/// Width of a posterior over that of its prior, as scores, below which a key is determined.
const DETERMINED: f64 = 0.5;
/// Change of a statistic over a prior's inner 90 %, in deviations of its scatter from scan to scan, below which a key
/// moves nothing.
const MOVES: f64 = 1.0;
/// Places at which that change is looked for.
const MOVED_STEPS: usize = 9;
/// Correlation of two scores from which they cannot be told apart.
const ALIKE: f64 = 0.8;
/// Correlation of two scores from which the recipe says it.
const TOGETHER: f64 = 0.5;
/// Rank correlation of two such keys below which it goes without saying.
const SAID: f64 = 0.1;
/// Draws of a key that are kept for its histogram.
const KEPT_DRAWS: usize = 1000;

impl Fitter<'_> {
    /// Puts together what was found.
    pub(super) fn result(
        &self,
        recipe: &Recipe,
        real: &[RealScan],
        region: &ScoreRegion,
        outcome: InferenceOutcome,
    ) -> Fit {
        let weights = region.weights(&self.simulations, Emulator::wanted(self.keys.len()));
        let emulator = self.emulator(&weights);
        let parts = self.simulator.parts();
        let of_class = |(part, scan): (usize, &RealScan)| -> Vec<String> {
            let class = outcome.options.classes.get(part).map_or_else(String::new, |class| format!(" ({class})"));
            scan.statistics.iter().map(|statistic| format!("{}{class}", statistic.name)).collect()
        };
        let names: Vec<String> = real.iter().take(parts).enumerate().flat_map(of_class).collect();
        let scores = self.scores(&outcome.draws);
        let fitted = |(k, key): (usize, &FitKey)| {
            let moves = most_moved(&emulator, region.mean.as_slice(), k, &self.observed);
            let moved = names.get(moves.0).cloned().unwrap_or_default();
            let scores: Vec<&[f64]> = scores.iter().map(|of_scan| of_scan[k].as_slice()).collect();
            fitted_key(key, &scores, outcome.widening[k], (moved, moves.1))
        };
        let keys: Vec<FittedKey> = self.keys.iter().enumerate().map(fitted).collect();
        let middle = |scan: usize| -> Vec<f64> {
            scores[scan].iter().map(|draws| three(draws).map_or(0.0, |[_, middle, _]| middle)).collect()
        };
        let before_maps: Vec<_> =
            (0..parts).map(|part| self.simulator.scan(part, &vec![0.0; self.keys.len()], 1).0).collect();
        let scans = real
            .iter()
            .enumerate()
            .map(|(i, scan)| ScanFit {
                name: scan.maps.name.clone(),
                statistics: self.statistics(scan, i, &outcome.predictions),
                maps: MapsOfScan {
                    real: scan.maps.clone(),
                    before: before_maps[i % parts].clone(),
                    after: self.simulator.scan(i % parts, &middle(i / parts), 1).0,
                },
            })
            .collect();
        Fit {
            recipe: recipe.name().to_owned(),
            seed: outcome.options.seed,
            simulations: self.simulations.len(),
            rounds: [outcome.rounds, outcome.options.rounds],
            pairs: self.pairs(&scores),
            correlations: self.correlations(&keys, &scores),
            keys,
            scans,
        }
    }

    /// Draws `[scans][keys][draws]` of whole vectors of scores.
    fn scores(&self, draws: &[Vec<f64>]) -> Vec<Vec<Vec<f64>>> {
        let of_scan = |scan| {
            let draws: Vec<Vec<f64>> = draws.iter().map(|draw| self.layout.of_scan(scan, draw)).collect();
            (0..self.keys.len()).map(|key| draws.iter().map(|draw| draw[key]).collect()).collect()
        };
        (0..self.layout.scans()).map(of_scan).collect()
    }

    fn statistics(&self, real: &RealScan, scan: usize, predictions: &[Simulation]) -> Vec<StatisticFit> {
        let (parts, length) = (self.simulator.parts(), real.statistics.len());
        let own = |made: &Simulation| made.statistics[scan % parts * length..][..length].to_vec();
        let before: Vec<Vec<Option<f64>>> = self.simulations.iter().take(predictions.len()).map(own).collect();
        let beside = predictions.iter().skip(scan / parts).step_by(self.layout.scans());
        let after: Vec<Vec<Option<f64>>> = beside.map(own).collect();
        real.statistics
            .iter()
            .enumerate()
            .map(|(j, statistic)| {
                let told =
                    |scans: &[Vec<Option<f64>>]| -> Vec<f64> { scans.iter().filter_map(|scan| scan[j]).collect() };
                let numbers =
                    |scaled: &[f64]| three(scaled).map(|three| three.map(|scaled| statistic.law.number(scaled)));
                let (old, new) = (told(&before), told(&after));
                let n = new.len() as f64;
                let mean = new.iter().sum::<f64>() / n.max(1.0);
                let variance = new.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / (n - 1.0).max(1.0);
                let spread = real.spreads[j];
                // What is the same in all scans has no scatter to measure by.
                let from_scatter = statistic.scaled.filter(|_| n > 3.0 && varies(variance, mean));
                let from_scatter = from_scatter.map(|real| (real - mean) / variance.sqrt());
                let from_halves = match (statistic.scaled, three(&new), spread) {
                    (Some(real), Some([_, median, _]), Some(spread)) if spread > 0.0 => Some((real - median) / spread),
                    _ => None,
                };
                StatisticFit {
                    key: statistic.key.clone(),
                    name: statistic.name.clone(),
                    unit: statistic.unit,
                    before: numbers(&old),
                    after: numbers(&new),
                    real: statistic.number(),
                    real_ends: statistic.scaled.zip(spread).map(|(scaled, spread)| {
                        [scaled - spread, scaled + spread].map(|scaled| statistic.law.number(scaled))
                    }),
                    from_scatter,
                    from_halves,
                }
            })
            .collect()
    }

    /// Rank correlations that the recipe is written with: of keys that are written, have a scale and one score for all
    /// scans.
    fn correlations(&self, keys: &[FittedKey], scores: &[Vec<Vec<f64>>]) -> Vec<([String; 2], f64)> {
        let can = |k: usize| {
            let (key, is_own) = (&self.keys[k], !keys[k].of_scans.is_empty());
            keys[k].is_written() && !is_own && key.prior.is_on_a_scale(key.parameter)
        };
        let r = |a: usize, b: usize| correlation(&scores[0][a], &scores[0][b]);
        let could: Vec<usize> = (0..keys.len()).filter(|&k| can(k)).collect();
        let goes_along = |a: usize| could.iter().any(|&b| b != a && r(a, b).abs() >= TOGETHER);
        let together: Vec<usize> = could.iter().copied().filter(|&a| goes_along(a)).collect();
        let mut found = Vec::new();
        for (i, &a) in together.iter().enumerate() {
            for &b in &together[i + 1..] {
                // Of normal scores (Pearson 1907).
                let spearman = 6.0 / std::f64::consts::PI * libm::asin(0.5 * r(a, b));
                if spearman.abs() >= SAID {
                    found.push(([keys[a].path.clone(), keys[b].path.clone()], (1000.0 * spearman).round() / 1000.0));
                }
            }
        }
        found
    }

    /// Pairs of keys whose scores go together.
    fn pairs(&self, scores: &[Vec<Vec<f64>>]) -> Vec<([String; 2], f64)> {
        let keys = self.keys.len();
        let mut found = Vec::new();
        for a in 0..keys {
            for b in a + 1..keys {
                let all = scores.iter().map(|of_scan| correlation(&of_scan[a], &of_scan[b]));
                let most = all.max_by(|x, y| x.abs().total_cmp(&y.abs()));
                if let Some(r) = most.filter(|r| r.abs() >= ALIKE) {
                    found.push(([self.keys[a].path.clone(), self.keys[b].path.clone()], r));
                }
            }
        }
        found
    }
}

/// The statistic that a key moves most within 5 to 95 % of its prior, of those that some real scan has: its number, and
/// by how many deviations.
fn most_moved(emulator: &Emulator, place: &[f64], key: usize, observed: &[Vec<Option<f64>>]) -> (usize, f64) {
    let step = |n: usize| TAIL * (2.0 * n as f64 / (MOVED_STEPS - 1) as f64 - 1.0);
    let means: Vec<DVector<f64>> = (0..MOVED_STEPS).map(|n| emulator.mean_along(place, key, step(n))).collect();
    let change = |j: usize| {
        let of = means.iter().map(|mean| mean[j]);
        of.clone().fold(f64::NEG_INFINITY, f64::max) - of.fold(f64::INFINITY, f64::min)
    };
    let told = |j: usize| emulator.known[j] && observed.iter().any(|real| real[j].is_some());
    (0..emulator.known.len())
        .filter(|&j| told(j))
        .map(|j| (j, change(j) / emulator.covariance[(j, j)].sqrt()))
        .max_by(|a, b| a.1.total_cmp(&b.1))
        .unwrap_or((0, 0.0))
}

/// A key from its scores in each scan.
fn fitted_key(key: &FitKey, scores: &[&[f64]], widening: f64, moves: (String, f64)) -> FittedKey {
    let widths: Vec<f64> =
        scores.iter().filter_map(|scores| three(scores)).map(|[low, _, high]| (high - low) / (2.0 * TAIL)).collect();
    let width = widths.iter().sum::<f64>() / widths.len().max(1) as f64;
    let state = match () {
        () if width < DETERMINED => KeyState::Determined,
        () if moves.1 >= MOVES => KeyState::Weak,
        () => KeyState::Undetermined,
    };
    let values: Vec<Vec<f64>> = scores.iter().map(|scores| scores.iter().map(|&u| key.value(u)).collect()).collect();
    let all: Vec<f64> = values.concat();
    let of_scans: Vec<[f64; 3]> = values.iter().filter_map(|values| three(values)).collect();
    let is_own = of_scans.windows(2).any(|pair| pair[0] != pair[1]);
    let step = all.len().div_ceil(KEPT_DRAWS).max(1);
    FittedKey {
        path: key.path.clone(),
        parameter: key.parameter,
        prior: key.prior.clone(),
        state,
        before: [-TAIL, 0.0, TAIL].map(|score| key.value(score)),
        after: three(&all).unwrap_or([f64::NAN; 3]),
        of_scans: if is_own { of_scans } else { Vec::new() },
        width,
        widening,
        moves,
        draws: all.iter().copied().step_by(step).collect(),
        is_log: key.prior.is_log(),
        distribution: written(key, &all),
    }
}

/// Draws as a distribution that a recipe holds, within the bounds of the prior.
fn written(key: &FitKey, values: &[f64]) -> String {
    if !key.prior.is_on_a_scale(key.parameter) {
        let mut kinds: Vec<f64> = values.to_vec();
        kinds.sort_by(f64::total_cmp);
        kinds.dedup();
        let share = |value: f64| values.iter().filter(|x| **x == value).count() as f64 / values.len().max(1) as f64;
        let list = |numbers: Vec<String>| numbers.join(", ");
        let weights = kinds.iter().map(|&value| format!("{:.3}", share(value).max(0.001))).collect();
        let kinds = kinds.iter().map(|value| short(*value)).collect();
        return format!("{{choice: {{values: [{}], weights: [{}]}}}}", list(kinds), list(weights));
    }
    let (min, max) = key.prior.bounds(key.parameter);
    let scale = |x: f64| if key.prior.is_log() { libm::log(x) } else { x };
    let n = values.len().max(1) as f64;
    let mean = values.iter().map(|&x| scale(x)).sum::<f64>() / n;
    let sd = (values.iter().map(|&x| (scale(x) - mean) * (scale(x) - mean)).sum::<f64>() / n).sqrt();
    let of = if key.prior.is_log() {
        format!("lognormal: {{median: {}, log_sd: {}}}", short(libm::exp(mean)), short(sd))
    } else {
        format!("normal: {{mean: {}, sd: {}}}", short(mean), short(sd))
    };
    format!("{{truncated: {{of: {{{of}}}, min: {}, max: {}}}}}", short(min), short(max))
}

/// 5, 50 and 95 % of numbers.
fn three(numbers: &[f64]) -> Option<[f64; 3]> {
    let mut sorted = numbers.to_vec();
    sorted.sort_by(f64::total_cmp);
    let last = sorted.len().checked_sub(1)?;
    Some([0.05, 0.5, 0.95].map(|share| {
        let place = share * last as f64;
        let (i, part) = (place as usize, place.fract());
        sorted[i] + part * (sorted[(i + 1).min(last)] - sorted[i])
    }))
}

/// Pearson's correlation.
fn correlation(x: &[f64], y: &[f64]) -> f64 {
    let [mean_x, mean_y] = [x, y].map(|all| all.iter().sum::<f64>() / all.len() as f64);
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for (x, y) in x.iter().zip(y) {
        let (a, b) = (x - mean_x, y - mean_y);
        (xx, xy, yy) = (xx + a * a, xy + a * b, yy + b * b);
    }
    if xx > 0.0 && yy > 0.0 { xy / (xx * yy).sqrt() } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use base::{Stream, normal};

    use super::*;
    use crate::emulator::Simulation;

    /// A key that a statistic follows evenly moves it as much as one that it follows oddly, and what a narrow kernel
    /// saw of a key goes on straight.
    #[test]
    fn even_effects_count_and_narrow_ones_go_straight() {
        let mut rng = Stream::root(5).rng();
        let scan = |narrow: f64, rng: &mut _| {
            let u = [normal(rng), normal(rng), narrow * normal(rng)];
            let of = [u[0] * u[0], 2.0 * u[1], 30.0 * u[2]].map(|mean| Some(mean + 0.5 * normal(rng)));
            Simulation { scores: u.to_vec(), statistics: of.to_vec() }
        };
        let scans: Vec<Simulation> = (0..2000).map(|_| scan(0.02, &mut rng)).collect();
        let emulator = Emulator::new(&scans, &vec![1.0; scans.len()], 1);
        let observed = [vec![Some(0.0); 3]];
        // Changes over the inner 90 %, in deviations of 0.5: the square's 2.7, twice 3.29, thirty times 3.29.
        for (key, (expected, within)) in [(5.41, 0.4), (13.16, 0.4), (197.4, 20.0)].into_iter().enumerate() {
            let (moved, by) = most_moved(&emulator, &[0.0; 3], key, &observed);
            assert_eq!(moved, key);
            assert!((by - expected).abs() < within, "key {key} moves by {by}");
        }
        let nothing = [vec![None; 3]];
        assert_eq!(most_moved(&emulator, &[0.0; 3], 0, &nothing), (0, 0.0));
    }

    /// The middle of numbers, and their tails.
    #[test]
    fn quantiles_by_hand() {
        let numbers: Vec<f64> = (0..=100).rev().map(f64::from).collect();
        assert_eq!(three(&numbers), Some([5.0, 50.0, 95.0]));
        assert_eq!(three(&[]), None);
    }
}
