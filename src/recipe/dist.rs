//! Distributions of one number: the forms, how they are sampled, where they can reach and how much falls in a range.
//!
//! | form | density or chance | source |
//! |---|---|---|
//! | fixed v | always v | |
//! | uniform [a, b] | 1 / (b - a) | |
//! | log_uniform [a, b] | 1 / (x ln(b / a)) | Hamming 1970: the prior of a scale |
//! | normal (m, s) | exp(-(x - m)^2 / 2 s^2) / (s sqrt(2 pi)) | Gauss; polar method of Marsaglia and Bray 1964 |
//! | lognormal (m, s) | normal of ln x about ln m | Limpert, Stahel, Abbt 2001: m is the median |
//! | choice (v, w) | w_i / sum w for v_i | |
//!
//! Every draw is made again until it lies within the bounds of [`Distribution::bounds`]. Normal and lognormal are cut at
//! eight standard deviations, beyond which one of 10^15 draws would lie, so that each distribution has bounds on which
//! the checks between parameters can rely. Counts: the continuous forms are rounded to the nearest whole number; uniform
//! and log-uniform reach half a number further first, so that a uniform count takes each of its numbers equally often.

use procedural::{Parameter, Stream, normal};
use rand::{Rng, RngExt};

use crate::chance::normal_below;

/// Cut of normal and lognormal [standard deviations].
const CUT: f64 = 8.0;
/// Least chance that a draw lies within the bounds; below it the recipe is at fault.
pub(super) const LEAST_CHANCE: f64 = 0.01;
/// Draws before the nearest bound is taken; with the least chance that happens once in 10^43 samples.
const ATTEMPTS: usize = 10_000;

/// A distribution of one number, its arguments checked.
#[derive(Debug, Clone, PartialEq)]
pub enum Distribution {
    /// Always the same number.
    Fixed(f64),
    /// Even between two numbers; for counts, every whole number with equal chance.
    Uniform {
        /// Smallest.
        min: f64,
        /// Largest.
        max: f64,
    },
    /// Even in the logarithm.
    LogUniform {
        /// Smallest, above 0.
        min: f64,
        /// Largest.
        max: f64,
    },
    /// Gaussian.
    Normal {
        /// Mean.
        mean: f64,
        /// Standard deviation, 0 or more.
        sd: f64,
    },
    /// Gaussian in the logarithm.
    Lognormal {
        /// Median, above 0.
        median: f64,
        /// Standard deviation of the natural logarithm, 0 or more.
        log_sd: f64,
    },
    /// Some numbers with their weights.
    Choice {
        /// The numbers, at least one.
        values: Vec<f64>,
        /// Their weights, 0 or more, not all 0.
        weights: Vec<f64>,
    },
    /// Another distribution, drawn again until it lies between two numbers.
    Truncated {
        /// The other distribution, not truncated itself.
        of: Box<Distribution>,
        /// Smallest.
        min: f64,
        /// Largest.
        max: f64,
    },
}

impl Distribution {
    /// A draw for `parameter` from the start of `stream`, within [`Self::bounds`].
    pub fn draw(&self, parameter: &Parameter, stream: Stream) -> f64 {
        let (min, max) = self.bounds(parameter);
        let mut rng = stream.rng();
        for _ in 0..ATTEMPTS {
            let value = self.sample(parameter.integer, &mut rng);
            if (min..=max).contains(&value) {
                return value;
            }
        }
        min
    }

    /// Smallest and largest draw for `parameter`.
    pub fn bounds(&self, parameter: &Parameter) -> (f64, f64) {
        let (min, max) = self.reach();
        let whole = |x: f64| if parameter.integer { x.round() } else { x };
        (whole(min).max(parameter.min), whole(max).min(parameter.max))
    }

    /// Chance that a sample for `parameter` lies in its range, and between the bounds where truncated.
    pub fn chance_inside(&self, parameter: &Parameter) -> f64 {
        let half = if parameter.integer { 0.5 } else { 0.0 };
        match self {
            Self::Truncated { of, min, max } => {
                of.mass(min.max(parameter.min) - half, max.min(parameter.max) + half, half)
            }
            other => other.mass(parameter.min - half, parameter.max + half, half),
        }
    }

    /// The only numbers that can come out, where they are few.
    pub fn values(&self) -> Option<Vec<f64>> {
        match self {
            Self::Fixed(value) => Some(vec![*value]),
            Self::Choice { values, .. } => Some(values.clone()),
            Self::Truncated { of, min, max } => {
                of.values().map(|all| all.into_iter().filter(|value| (min..=max).contains(&value)).collect())
            }
            _ => None,
        }
    }

    /// One sample before any bound is asked.
    fn sample(&self, count: bool, rng: &mut impl Rng) -> f64 {
        let half = if count { 0.5 } else { 0.0 };
        let value = match self {
            Self::Fixed(value) => *value,
            Self::Uniform { min, max } => between(min - half, max + half, rng),
            Self::LogUniform { min, max } => libm::exp(between(libm::log(min - half), libm::log(max + half), rng)),
            Self::Normal { mean, sd } => mean + sd * normal(rng),
            Self::Lognormal { median, log_sd } => median * libm::exp(log_sd * normal(rng)),
            Self::Choice { values, weights } => values[pick(weights, rng.random())],
            Self::Truncated { of, .. } => of.sample(count, rng),
        };
        if count { value.round() } else { value }
    }

    /// Smallest and largest sample that counts.
    fn reach(&self) -> (f64, f64) {
        match self {
            Self::Fixed(value) => (*value, *value),
            Self::Uniform { min, max } | Self::LogUniform { min, max } => (*min, *max),
            Self::Normal { mean, sd } => (mean - CUT * sd, mean + CUT * sd),
            Self::Lognormal { median, log_sd } => (median * libm::exp(-CUT * log_sd), median * libm::exp(CUT * log_sd)),
            Self::Choice { values, weights } => {
                let possible = values.iter().zip(weights).filter(|(_, weight)| **weight > 0.0);
                possible.fold((f64::MAX, f64::MIN), |(min, max), (value, _)| (min.min(*value), max.max(*value)))
            }
            Self::Truncated { of, min, max } => {
                let (low, high) = of.reach();
                (low.max(*min), high.min(*max))
            }
        }
    }

    /// Share of the samples from `low` to `high`; `half` is how far uniform and log-uniform reach beyond their ends.
    pub(super) fn mass(&self, low: f64, high: f64, half: f64) -> f64 {
        let inside = |x: f64| if (low..=high).contains(&x) { 1.0 } else { 0.0 };
        match self {
            Self::Fixed(value) => inside(*value),
            Self::Uniform { min, max } => overlap(min - half, max + half, low, high),
            Self::LogUniform { min, max } => {
                let ln = |x: f64| libm::log(x.max(f64::MIN_POSITIVE));
                overlap(ln(min - half), ln(max + half), ln(low), ln(high))
            }
            Self::Normal { mean, sd: 0.0 } => inside(*mean),
            Self::Normal { mean, sd } => normal_below((high - mean) / sd) - normal_below((low - mean) / sd),
            Self::Lognormal { median, log_sd: 0.0 } => inside(*median),
            Self::Lognormal { median, log_sd } => {
                let below = |x: f64| if x > 0.0 { normal_below(libm::log(x / median) / log_sd) } else { 0.0 };
                below(high) - below(low)
            }
            Self::Choice { values, weights } => {
                let total: f64 = weights.iter().sum();
                values.iter().zip(weights).map(|(value, weight)| inside(*value) * weight).sum::<f64>() / total
            }
            Self::Truncated { of, min, max } => of.mass(low.max(*min), high.min(*max), half),
        }
    }
}

/// Even between `min` and `max`.
fn between(min: f64, max: f64, rng: &mut impl Rng) -> f64 {
    min + (max - min) * rng.random::<f64>()
}

/// Index into `weights` at the share `u` in [0, 1) of their sum; never one of weight 0.
pub(super) fn pick(weights: &[f64], u: f64) -> usize {
    let mut rest = u * weights.iter().sum::<f64>();
    for (i, weight) in weights.iter().enumerate() {
        rest -= weight;
        if rest < 0.0 {
            return i;
        }
    }
    // Rounding can leave a last crumb of the sum, which belongs to the last weight that is not 0.
    weights.iter().rposition(|weight| *weight > 0.0).unwrap_or(0)
}

/// Share of [min, max] that [low, high] covers; a single point counts as a whole.
fn overlap(min: f64, max: f64, low: f64, high: f64) -> f64 {
    let (from, to) = (min.max(low), max.min(high));
    match (from <= to, max > min) {
        (false, _) => 0.0,
        (true, false) => 1.0,
        (true, true) => (to - from) / (max - min),
    }
}
