//! What a fit has found: keys, statistics before and after, pairs that cannot be told apart, and what stays out of
//! reach.

use base::{Parameter, words};
use recipe::{Distribution, NewValue};
use serde_json::{Map, Value, json};
use tools::compare::ScanMaps;

use crate::prior::is_of_bench;

/// Width from which a posterior says no more than its prior.
const NO_NARROWER: f64 = 0.95;
/// Length of an interval over that of the prior's, up to which a key is told.
const TOLD: f64 = 1.0 / 3.0;
/// Deviations of what fitted recipes make from which a real statistic is out of reach.
const OUT_OF_REACH: f64 = 3.0;

words! {
    /// What the scans say of a key.
    KeyState {
        /// They narrow it to less than half of its prior.
        Determined = "determined",
        /// It moves statistics, but others can make up for it; the recipe keeps its prior where the posterior is no
        /// narrower.
        Weak = "weak",
        /// Over its whole prior it moves no statistic beyond its scatter: it keeps its prior.
        Undetermined = "undetermined",
    }
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
    /// Spearman's rank correlation of keys that go together by a half or more, and of all pairs among these; of keys
    /// that the scans share.
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

/// A number with four digits.
pub(crate) fn short(number: f64) -> String {
    if number == 0.0 || !number.is_finite() {
        return "0".into();
    }
    let digits = (3 - libm::floor(libm::log10(number.abs())) as i32).clamp(0, 12) as usize;
    let text = format!("{number:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
}

/// What a fit found of matter.
#[derive(Debug, Clone, PartialEq)]
pub struct FittedMatter {
    /// What a recipe gets.
    pub values: Vec<NewValue>,
    /// Keys that the scans tell nothing of.
    pub untold: Vec<String>,
    /// Rank correlations of pairs of keys [1].
    pub correlations: Vec<([String; 2], f64)>,
}

impl FittedKey {
    /// Length of the 90 % interval over that of the prior, in the scale of its distribution [1].
    pub fn length(&self) -> f64 {
        let length = |[low, _, high]: [f64; 3]| if self.is_log { libm::log(high / low) } else { high - low };
        length(self.after) / length(self.before)
    }

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
            let [low, _, high] = key.after.map(short);
            let told = if key.length() <= TOLD { ": told" } else { "" };
            let mut comment =
                format!("fitted to {of}, 90 % within {low} to {high}, {:.2} of before{told}", key.length());
            if key.state == KeyState::Weak {
                comment.push_str("; weak");
            }
            if let Some(([a, b], _)) = pair {
                let other = if *a == key.path { b } else { a };
                comment.push_str(&format!("; not told apart from {other}"));
            }
            NewValue {
                key: key.path.clone(),
                value: key.distribution.clone(),
                comment: Some(dataset::one_line(comment)),
            }
        })
        .collect()
    }

    /// The part of this that is of matter, not of the bench.
    pub fn of_matter(&self) -> FittedMatter {
        let is_of_matter = |path: &str| !is_of_bench(path.split('.').next().unwrap_or_default());
        let values = self.new_values().into_iter().filter(|new| is_of_matter(&new.key)).collect();
        let others = self.keys.iter().filter(|key| is_of_matter(&key.path) && !key.is_written());
        let pairs = self.correlations.iter().filter(|(keys, _)| keys.iter().all(|key| is_of_matter(key)));
        FittedMatter {
            values,
            untold: others.map(|key| key.path.clone()).collect(),
            correlations: pairs.cloned().collect(),
        }
    }

    /// All of it but maps and draws, as JSON.
    pub fn json(&self) -> Value {
        let three = |numbers: [f64; 3]| json!({ "p05": numbers[0], "p50": numbers[1], "p95": numbers[2] });
        let keys: Map<String, Value> = self
            .keys
            .iter()
            .map(|key| {
                let value = json!({
                    "state": key.state.name(),
                    "prior": three(key.before),
                    "posterior": three(key.after),
                    "of_scans": key.of_scans.iter().map(|scan| three(*scan)).collect::<Vec<_>>(),
                    "width": key.width,
                    "length": key.length(),
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
            "correlations": self.correlations.iter().map(|(keys, r)| json!({ "keys": keys,
                "spearman": r })).collect::<Vec<_>>(),
            "scans": self.scans.iter().map(scan).collect::<Vec<_>>(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers keep four digits and no more.
    #[test]
    fn numbers_are_short() {
        for (number, text) in
            [(0.061234, "0.06123"), (1234.56, "1235"), (0.0, "0"), (-2.5, "-2.5"), (50.0, "50"), (1e-7, "0.0000001")]
        {
            assert_eq!(short(number), text);
        }
    }
}
