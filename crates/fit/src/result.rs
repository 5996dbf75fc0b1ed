//! What a fit has found: keys, statistics before and after, pairs that cannot be told apart, and what stays out of reach.

use nalgebra::DVector;
use procedural::Parameter;
use recipe::{Distribution, Recipe};
use serde_json::{Map, Value, json};
use tools::compare::ScanMaps;
use tools::compare::summary::SummaryStatistic;

use crate::emulator::{Emulator, ScoreRegion, varies};
use crate::observation::RealScan;
use crate::prior::FitKey;
use crate::recipe_text::NewValue;
use crate::rounds::{Fitter, InferenceOutcome};

/// Scores of the 5 and 95 % quantiles of the standard normal law.
const TAIL: f64 = 1.644_853_626_951_472_2;
/// Width of a posterior over that of its prior, as scores, below which a key is determined.
const DETERMINED: f64 = 0.5;
/// Width from which a posterior says no more than its prior.
const NO_NARROWER: f64 = 0.95;
/// Change of a statistic over a prior's inner 90 %, in deviations of its scatter from scan to scan, below which a key moves nothing.
const MOVES: f64 = 1.0;
/// Places at which that change is looked for.
const MOVED_STEPS: usize = 9;
/// Correlation of two scores from which they cannot be told apart.
const ALIKE: f64 = 0.8;
/// Correlation of two scores from which the recipe says it.
const TOGETHER: f64 = 0.5;
/// Rank correlation of two such keys below which it goes without saying.
const SAID: f64 = 0.1;
/// Deviations of what fitted recipes make from which a real statistic is out of reach.
const OUT_OF_REACH: f64 = 3.0;
/// Draws of a key that are kept for its histogram.
const KEPT_DRAWS: usize = 1000;

/// A scan that a fitted recipe made.
#[derive(Debug, Clone)]
pub(crate) struct Prediction {
    /// The real scan that it stands beside.
    pub scan: usize,
    /// Its statistics.
    pub statistics: Vec<Option<f64>>,
}

/// What the scans say of a key.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum KeyState {
    /// They narrow it to less than half of its prior.
    Determined,
    /// It moves statistics, but others can make up for it; the recipe keeps its prior where the posterior is no narrower.
    Weak,
    /// Over its whole prior it moves no statistic beyond its scatter: it keeps its prior.
    Undetermined,
}

/// A key after the fit.
#[derive(Debug, Clone)]
pub struct FittedKey {
    /// Its path.
    pub path: String,
    /// Its declaration.
    pub parameter: &'static Parameter,
    /// What the recipe drew it from.
    pub prior: Distribution,
    /// What is known of it.
    pub state: KeyState,
    /// 5, 50 and 95 % of the prior.
    pub before: [f64; 3],
    /// 5, 50 and 95 % of the posterior, over all scans.
    pub after: [f64; 3],
    /// The same for each scan, where each has its own.
    pub of_scans: Vec<[f64; 3]>,
    /// Width of the posterior over that of the prior, as scores [1].
    pub width: f64,
    /// By how much the check on simulated scans has widened it [1].
    pub widening: f64,
    /// The statistic that it moves most over the prior's inner 90 %, and by how many deviations of its scatter.
    pub moves: (String, f64),
    /// Some draws.
    pub draws: Vec<f64>,
    /// Whether it is best drawn in a logarithmic scale.
    pub is_log: bool,
    /// The posterior as a recipe writes it.
    pub distribution: String,
}

/// A statistic of one real scan beside simulated ones, as numbers in its unit.
#[derive(Debug, Clone)]
pub struct StatisticFit {
    /// Its key.
    pub key: String,
    /// What it is.
    pub name: String,
    /// Its unit.
    pub unit: &'static str,
    /// 5, 50 and 95 % over scans of the recipe as it was.
    pub before: Option<[f64; 3]>,
    /// The same over scans of the fitted recipe.
    pub after: Option<[f64; 3]>,
    /// What the real scan has.
    pub real: Option<f64>,
    /// One standard error either side of it, from its halves.
    pub real_ends: Option<[f64; 2]>,
    /// Distance of the real scan from the mean of fitted ones, in the deviations of these.
    pub from_scatter: Option<f64>,
    /// Distance of the real scan from the median of fitted ones, in the standard errors that its halves give.
    pub from_halves: Option<f64>,
}

/// One real scan beside simulated ones.
#[derive(Debug, Clone)]
pub struct ScanFit {
    /// What it is called.
    pub name: String,
    /// Its statistics.
    pub statistics: Vec<StatisticFit>,
    /// Its maps, one of the recipe as it was, one of the fitted recipe.
    pub maps: MapsOfScan,
}

/// Maps side by side.
#[derive(Debug, Clone)]
pub struct MapsOfScan {
    /// The real scan, or its part that was fitted.
    pub real: ScanMaps,
    /// A scan at the middle of the prior.
    pub before: ScanMaps,
    /// A scan at the middle of the posterior.
    pub after: ScanMaps,
}

/// What a fit has found.
#[derive(Debug, Clone)]
pub struct Fit {
    /// Name of the recipe.
    pub recipe: String,
    /// Seed.
    pub seed: u64,
    /// Simulated scans that were used.
    pub simulations: usize,
    /// Rounds that were done, and asked for.
    pub rounds: [usize; 2],
    /// The keys, in the order of the recipe.
    pub keys: Vec<FittedKey>,
    /// Pairs of keys that cannot be told apart, with the correlation of their scores.
    pub pairs: Vec<([String; 2], f64)>,
    /// Spearman's rank correlation of keys that go together by a half or more, and of all pairs among these; of keys that the scans share.
    pub correlations: Vec<([String; 2], f64)>,
    /// The real scans.
    pub scans: Vec<ScanFit>,
}

impl StatisticFit {
    /// Whether no recipe within the prior makes what the real scan has.
    pub fn is_out_of_reach(&self) -> bool {
        self.from_scatter.is_some_and(|z| z.abs() > OUT_OF_REACH)
            && self.from_halves.is_none_or(|z| z.abs() > OUT_OF_REACH)
    }
}

impl KeyState {
    /// In a word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Determined => "determined",
            Self::Weak => "weak",
            Self::Undetermined => "undetermined",
        }
    }
}

impl Fitter<'_> {
    /// Puts together what was found.
    pub(crate) fn result(
        &self,
        recipe: &Recipe,
        real: &[RealScan],
        region: &ScoreRegion,
        outcome: InferenceOutcome,
    ) -> Fit {
        let weights = region.weights(&self.simulations, Emulator::wanted(self.keys.len()));
        let emulator = Emulator::new(&self.simulations, &weights);
        let names: Vec<&SummaryStatistic> = real.first().map_or_else(Vec::new, |scan| scan.statistics.iter().collect());
        let of_scan: Vec<Vec<Vec<f64>>> = (0..real.len())
            .map(|scan| outcome.draws.iter().map(|draw| self.layout.of_scan(scan, draw)).collect())
            .collect();
        let keys: Vec<FittedKey> = self
            .keys
            .iter()
            .enumerate()
            .map(|(k, key)| {
                let scores: Vec<Vec<f64>> =
                    of_scan.iter().map(|draws| draws.iter().map(|draw| draw[k]).collect()).collect();
                let moves = most_moved(&emulator, region.mean.as_slice(), k, &self.observed);
                let moved = names.get(moves.0).map_or_else(String::new, |name| name.name.clone());
                fitted_key(key, &scores, outcome.widening[k], (moved, moves.1))
            })
            .collect();
        let middle = |scan: usize| -> Vec<f64> {
            (0..self.keys.len())
                .map(|k| {
                    three(&of_scan[scan].iter().map(|draw| draw[k]).collect::<Vec<_>>()).map_or(0.0, |[_, m, _]| m)
                })
                .collect()
        };
        let before_maps = self.simulator.scan(&vec![0.0; self.keys.len()], 1).0;
        let scans = real
            .iter()
            .enumerate()
            .map(|(i, scan)| ScanFit {
                name: scan.maps.name.clone(),
                statistics: self.statistics(scan, i, &outcome.predictions),
                maps: MapsOfScan {
                    real: scan.maps.clone(),
                    before: before_maps.clone(),
                    after: self.simulator.scan(&middle(i), 1).0,
                },
            })
            .collect();
        Fit {
            recipe: recipe.name().to_owned(),
            seed: outcome.options.seed,
            simulations: self.simulations.len(),
            rounds: [outcome.rounds, outcome.options.rounds],
            pairs: self.pairs(&outcome.draws),
            correlations: self.correlations(&keys, &outcome.draws),
            keys,
            scans,
        }
    }

    fn statistics(&self, real: &RealScan, scan: usize, predictions: &[Prediction]) -> Vec<StatisticFit> {
        let first = self.simulations.iter().take(predictions.len());
        let before: Vec<&[Option<f64>]> = first.map(|simulation| simulation.statistics.as_slice()).collect();
        let after: Vec<&[Option<f64>]> =
            predictions.iter().filter(|made| made.scan == scan).map(|made| made.statistics.as_slice()).collect();
        real.statistics
            .iter()
            .enumerate()
            .map(|(j, statistic)| {
                let told = |scans: &[&[Option<f64>]]| -> Vec<f64> { scans.iter().filter_map(|scan| scan[j]).collect() };
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

    /// Rank correlations that the recipe is written with: of keys that are written, have a scale and one score for all scans.
    fn correlations(&self, keys: &[FittedKey], draws: &[Vec<f64>]) -> Vec<([String; 2], f64)> {
        let can = |k: usize| {
            let (key, is_own) = (&self.keys[k], !keys[k].of_scans.is_empty());
            keys[k].is_written() && !is_own && !key.parameter.integer && key.prior.values().is_none()
        };
        let scores = |k: usize| -> Vec<f64> { draws.iter().map(|draw| self.layout.of_scan(0, draw)[k]).collect() };
        let all: Vec<Vec<f64>> = (0..keys.len()).map(scores).collect();
        let r = |a: usize, b: usize| {
            let pairs: Vec<[f64; 2]> = all[a].iter().zip(&all[b]).map(|(x, y)| [*x, *y]).collect();
            correlation(&pairs)
        };
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
    fn pairs(&self, draws: &[Vec<f64>]) -> Vec<([String; 2], f64)> {
        let keys = self.keys.len();
        let mut found = Vec::new();
        for a in 0..keys {
            for b in a + 1..keys {
                let most = (0..self.layout.scans())
                    .map(|scan| {
                        let pairs: Vec<[f64; 2]> = draws
                            .iter()
                            .map(|draw| {
                                let scores = self.layout.of_scan(scan, draw);
                                [scores[a], scores[b]]
                            })
                            .collect();
                        correlation(&pairs)
                    })
                    .max_by(|x, y| x.abs().total_cmp(&y.abs()));
                if let Some(r) = most.filter(|r| r.abs() >= ALIKE) {
                    found.push(([self.keys[a].path.clone(), self.keys[b].path.clone()], r));
                }
            }
        }
        found
    }
}

/// The statistic that a key moves most within 5 to 95 % of its prior, of those that some real scan has: its number, and by how many deviations.
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
fn fitted_key(key: &FitKey, scores: &[Vec<f64>], widening: f64, moves: (String, f64)) -> FittedKey {
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
        is_log: key.is_log(),
        distribution: written(key, &all),
    }
}

/// Draws as a distribution that a recipe holds, within the bounds of the prior.
fn written(key: &FitKey, values: &[f64]) -> String {
    let (min, max) = key.prior.bounds(key.parameter);
    let mut kinds: Vec<f64> = values.to_vec();
    kinds.sort_by(f64::total_cmp);
    kinds.dedup();
    if key.prior.values().is_some() || key.parameter.integer {
        let share = |value: f64| values.iter().filter(|x| **x == value).count() as f64 / values.len().max(1) as f64;
        let list = |numbers: Vec<String>| numbers.join(", ");
        let weights = kinds.iter().map(|&value| format!("{:.3}", share(value).max(0.001))).collect();
        let kinds = kinds.iter().map(|value| short(*value)).collect();
        return format!("{{choice: {{values: [{}], weights: [{}]}}}}", list(kinds), list(weights));
    }
    let scale = |x: f64| if key.is_log() { libm::log(x) } else { x };
    let n = values.len().max(1) as f64;
    let mean = values.iter().map(|&x| scale(x)).sum::<f64>() / n;
    let sd = (values.iter().map(|&x| (scale(x) - mean) * (scale(x) - mean)).sum::<f64>() / n).sqrt();
    let of = if key.is_log() {
        format!("lognormal: {{median: {}, log_sd: {}}}", short(libm::exp(mean)), short(sd))
    } else {
        format!("normal: {{mean: {}, sd: {}}}", short(mean), short(sd))
    };
    format!("{{truncated: {{of: {{{of}}}, min: {}, max: {}}}}}", short(min), short(max))
}

/// A number with four digits.
fn short(number: f64) -> String {
    if number == 0.0 || !number.is_finite() {
        return "0".into();
    }
    let digits = (3 - libm::floor(libm::log10(number.abs())) as i32).clamp(0, 12) as usize;
    let text = format!("{number:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
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
fn correlation(pairs: &[[f64; 2]]) -> f64 {
    let n = pairs.len() as f64;
    let [x, y] = [0, 1].map(|k| pairs.iter().map(|pair| pair[k]).sum::<f64>() / n);
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for pair in pairs {
        let (a, b) = (pair[0] - x, pair[1] - y);
        (xx, xy, yy) = (xx + a * a, xy + a * b, yy + b * b);
    }
    if xx > 0.0 && yy > 0.0 { xy / (xx * yy).sqrt() } else { 0.0 }
}

impl FittedKey {
    /// Whether the recipe gets the posterior in the place of the prior.
    pub fn is_written(&self) -> bool {
        self.state != KeyState::Undetermined && self.width < NO_NARROWER
    }
}

impl Fit {
    /// What a recipe writes in place of the keys' values: those of which the scans tell something.
    pub fn new_values(&self) -> Vec<NewValue> {
        let names: Vec<&str> = self.scans.iter().map(|scan| scan.name.as_str()).collect();
        let of = names.join(", ");
        let told = self.keys.iter().filter(|key| key.is_written());
        told.map(|key| {
            let pair = self.pairs.iter().find(|(pair, _)| pair.contains(&key.path));
            let mut comment = format!("fitted to {of}, 90 % within {} to {}", short(key.after[0]), short(key.after[2]));
            if key.state == KeyState::Weak {
                comment.push_str("; weak");
            }
            if let Some(([a, b], _)) = pair {
                let other = if *a == key.path { b } else { a };
                comment.push_str(&format!("; not told apart from {other}"));
            }
            NewValue { key: key.path.clone(), value: key.distribution.clone(), comment: dataset::one_line(comment) }
        })
        .collect()
    }

    /// All of it but maps and draws, as JSON.
    pub fn json(&self) -> Value {
        let three = |numbers: [f64; 3]| json!({ "p05": numbers[0], "p50": numbers[1], "p95": numbers[2] });
        let keys: Map<String, Value> = self
            .keys
            .iter()
            .map(|key| {
                let value = json!({
                    "state": key.state.word(),
                    "prior": three(key.before),
                    "posterior": three(key.after),
                    "of_scans": key.of_scans.iter().map(|scan| three(*scan)).collect::<Vec<_>>(),
                    "width": key.width,
                    "widening": key.widening,
                    "moves_most": { "statistic": key.moves.0, "deviations": key.moves.1 },
                    "distribution": key.is_written().then_some(&key.distribution),
                });
                (key.path.clone(), value)
            })
            .collect();
        let scan = |scan: &ScanFit| {
            let statistics: Map<String, Value> = scan
                .statistics
                .iter()
                .map(|statistic| {
                    let value = json!({
                        "unit": statistic.unit,
                        "before": statistic.before.map(three),
                        "after": statistic.after.map(three),
                        "real": statistic.real,
                        "real_ends": statistic.real_ends,
                        "from_scatter": statistic.from_scatter,
                        "from_halves": statistic.from_halves,
                        "out_of_reach": statistic.is_out_of_reach(),
                    });
                    (statistic.key.clone(), value)
                })
                .collect();
            json!({ "name": scan.name, "statistics": statistics })
        };
        json!({
            "program": format!("gen {}", env!("CARGO_PKG_VERSION")),
            "recipe": self.recipe,
            "seed": self.seed,
            "simulations": self.simulations,
            "rounds": self.rounds[0],
            "rounds_asked": self.rounds[1],
            "keys": keys,
            "pairs": self.pairs.iter().map(|(keys, r)| json!({ "keys": keys, "correlation": r })).collect::<Vec<_>>(),
            "correlations": self.correlations.iter().map(|(keys, r)| json!({ "keys": keys, "spearman": r })).collect::<Vec<_>>(),
            "scans": self.scans.iter().map(scan).collect::<Vec<_>>(),
        })
    }
}

#[cfg(test)]
mod tests {
    use procedural::{Stream, normal};

    use super::*;
    use crate::emulator::Simulation;

    /// A key that a statistic follows evenly moves it as much as one that it follows oddly, and what a narrow kernel saw of a key goes on straight.
    #[test]
    fn even_effects_count_and_narrow_ones_go_straight() {
        let mut rng = Stream::root(5).rng();
        let scan = |narrow: f64, rng: &mut _| {
            let u = [normal(rng), normal(rng), narrow * normal(rng)];
            let of = [u[0] * u[0], 2.0 * u[1], 30.0 * u[2]].map(|mean| Some(mean + 0.5 * normal(rng)));
            Simulation { scores: u.to_vec(), statistics: of.to_vec() }
        };
        let scans: Vec<Simulation> = (0..2000).map(|_| scan(0.02, &mut rng)).collect();
        let emulator = Emulator::new(&scans, &vec![1.0; scans.len()]);
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

    /// Numbers keep four digits and no more.
    #[test]
    fn numbers_are_short() {
        for (number, text) in
            [(0.061234, "0.06123"), (1234.56, "1235"), (0.0, "0"), (-2.5, "-2.5"), (50.0, "50"), (1e-7, "0.0000001")]
        {
            assert_eq!(short(number), text);
        }
    }

    /// The middle of numbers, and their tails.
    #[test]
    fn quantiles_by_hand() {
        let numbers: Vec<f64> = (0..=100).rev().map(f64::from).collect();
        assert_eq!(three(&numbers), Some([5.0, 50.0, 95.0]));
        assert_eq!(three(&[]), None);
    }
}
