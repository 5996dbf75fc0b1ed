//! What an end of a key's range costs a model: the mean over samples of differences of shares of right answers.
//!
//! With d_i the share of right answers of sample i at the middle of the key less that at the end, and n samples, the
//! cost is the mean of d. Its interval is that of Bonett and Price (2012, *J. Educ. Behav. Stat.* 37, 479), which adds
//! two samples, one with the difference 1 and one with -1:
//!
//! ```text
//! m = sum d / (n + 2),    s^2 = ((sum d^2 + 2) / (n + 2) - m^2) / (n + 2),    m -+ z s
//! ```
//!
//! It was made for one answer a sample, where d is -1, 0 or 1, and is used here for shares too, which spread less.
//! Where nothing changes it is not empty: it is as wide as n samples can tell. A key has two ends, so z is that of
//! 97.5 % for the 95 % of a key, and of 1 - 0.05/2k for those of k keys together.

use numerics::chance::normal_quantile;

use super::SampleAnswers;

/// Chance that an interval misses.
const MISS: f64 = 0.05;

/// Whether a key costs a model something.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CostVerdict {
    /// It does, also where all keys are looked at together.
    Costs,
    /// The key's own interval is above zero; of twenty keys that do nothing one is there.
    MayCost,
    /// The interval holds zero.
    NotSeen,
}

impl CostVerdict {
    /// In reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Costs => "costs",
            Self::MayCost => "may cost",
            Self::NotSeen => "not seen",
        }
    }
}

/// What an end of a key costs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EndCost {
    /// Value of the key there.
    pub value: f64,
    /// Share of right answers that is lost [1].
    pub cost: f64,
    /// Interval at 95 % for the key [1].
    pub interval: [f64; 2],
    /// Lower end of the interval at 95 % for all keys together [1].
    pub joint_low: f64,
    /// Samples with answers at the end and in the middle.
    pub samples: usize,
}

impl EndCost {
    /// Of answers in the middle and at the end, of `keys` keys.
    pub(super) fn new(value: f64, middle: &[SampleAnswers], end: &[SampleAnswers], keys: usize) -> Self {
        let pairs = middle.iter().zip(end);
        let lost: Vec<f64> = pairs.filter_map(|(middle, end)| Some(share(middle)? - share(end)?)).collect();
        let n = lost.len() as f64;
        let cost = if lost.is_empty() { 0.0 } else { lost.iter().sum::<f64>() / n };
        let interval = paired_interval(&lost, 2);
        Self { value, cost, interval, joint_low: paired_interval(&lost, 2 * keys)[0], samples: lost.len() }
    }

    /// Whether it costs something.
    pub fn verdict(&self) -> CostVerdict {
        match () {
            () if self.joint_low > 0.0 => CostVerdict::Costs,
            () if self.interval[0] > 0.0 => CostVerdict::MayCost,
            () => CostVerdict::NotSeen,
        }
    }
}

/// Share of right answers of a sample; `None` without answers.
pub(super) fn share(answers: &SampleAnswers) -> Option<f64> {
    (answers[1] > 0).then(|| answers[0] as f64 / answers[1] as f64)
}

/// The interval of a mean difference that holds it together with others, `intervals` in all, with 95 %.
fn paired_interval(differences: &[f64], intervals: usize) -> [f64; 2] {
    let z = normal_quantile(1.0 - MISS / (2.0 * intervals as f64));
    let n = differences.len() as f64 + 2.0;
    let mean = differences.iter().sum::<f64>() / n;
    let squares = differences.iter().map(|d| d * d).sum::<f64>() + 2.0;
    let half = z * ((squares / n - mean * mean) / n).sqrt();
    [mean - half, mean + half].map(|end| end.clamp(-1.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Chance that `gain` samples win, `lose` lose and the rest stay, of `n`.
    fn chance(n: usize, gain: usize, lose: usize, p: [f64; 2]) -> f64 {
        let log = |count: usize| libm::lgamma(count as f64 + 1.0);
        let rest = n - gain - lose;
        let ways = log(n) - log(gain) - log(lose) - log(rest);
        let of = |count: usize, p: f64| if count == 0 { 0.0 } else { count as f64 * libm::log(p) };
        libm::exp(ways + of(gain, p[0]) + of(lose, p[1]) + of(rest, 1.0 - p[0] - p[1]))
    }

    /// Exact coverage of the interval of one answer a sample, added up over all that 40 samples can show: never below
    /// 93 %, where 95 % are told, whether the key costs nothing, a little or much.
    #[test]
    fn intervals_cover() {
        let n = 40;
        for p in [[0.0, 0.0], [0.02, 0.02], [0.1, 0.1], [0.3, 0.3], [0.1, 0.0], [0.3, 0.1], [0.6, 0.05], [0.9, 0.02]] {
            let mut covered = 0.0;
            for gain in 0..=n {
                for lose in 0..=n - gain {
                    let all: Vec<f64> = (0..n)
                        .map(|i| {
                            if i < gain {
                                1.0
                            } else if i < gain + lose {
                                -1.0
                            } else {
                                0.0
                            }
                        })
                        .collect();
                    let [low, high] = paired_interval(&all, 1);
                    if (low..=high).contains(&(p[0] - p[1])) {
                        covered += chance(n, gain, lose, p);
                    }
                }
            }
            assert!(covered >= 0.93, "{p:?}: {covered}");
        }
    }

    /// By hand: of four samples of two answers two lose one; samples without answers count nowhere; an interval over
    /// more keys is wider, and that of no change holds zero.
    #[test]
    fn costs_are_paired() {
        let middle = [[2, 2], [2, 2], [1, 2], [0, 2], [0, 0]];
        let end = [[1, 2], [1, 2], [1, 2], [0, 2], [2, 2]];
        let found = EndCost::new(7.0, &middle, &end, 1);
        assert_eq!((found.cost, found.samples, found.value), (0.25, 4, 7.0));
        // m = 1/6; s^2 = (2.5/6 - 1/36) / 6; z of 97.5 %.
        let half = 2.241_402_727_604_947 * ((2.5 / 6.0 - 1.0 / 36.0) / 6.0_f64).sqrt();
        assert!((found.interval[0] - (1.0 / 6.0 - half)).abs() < 1e-9 && found.joint_low == found.interval[0]);
        assert!(EndCost::new(7.0, &middle, &end, 9).joint_low < found.joint_low);
        let same = EndCost::new(7.0, &[[1, 1]; 50], &[[1, 1]; 50], 3);
        assert!(same.cost == 0.0 && same.interval[0] < 0.0 && same.interval[1] > 0.0);
        assert_eq!(same.verdict(), CostVerdict::NotSeen);
        let lost = EndCost::new(7.0, &[[1, 1]; 50], &[[0, 1]; 50], 40);
        assert_eq!((lost.cost, lost.verdict()), (1.0, CostVerdict::Costs));
        let few: Vec<SampleAnswers> = (0..50).map(|i| [u64::from(i >= 9), 1]).collect();
        assert_eq!(EndCost::new(7.0, &[[1, 1]; 50], &few, 500).verdict(), CostVerdict::MayCost);
        let none = EndCost::new(7.0, &[[0, 0]; 3], &[[0, 0]; 3], 1);
        assert_eq!((none.samples, none.interval, none.verdict()), (0, [-1.0, 1.0], CostVerdict::NotSeen));
    }
}
