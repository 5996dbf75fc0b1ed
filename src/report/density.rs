//! What a recipe declares of a number, as a curve to hold its histogram to.
//!
//! The curve is the mixture over the classes that the dataset holds, each with the number of its samples. A class that
//! gives a fixed number or a choice adds to the range and nothing to the curve: it has no density.

use procedural::Parameter;

use super::cells::{Axis, CELLS};
use crate::recipe::{Distribution, Recipe};

/// Points of a curve, and cells of the sum that makes its area 1.
const POINTS: usize = 400;

/// The law of one class.
#[derive(Debug, Clone)]
struct Law {
    law: Distribution,
    min: f64,
    max: f64,
    samples: u64,
}

/// What a recipe declares of a number.
#[derive(Debug, Clone)]
pub(super) struct Declared {
    /// Smallest draw.
    pub min: f64,
    /// Largest draw.
    pub max: f64,
    /// Whether it varies in the logarithm.
    pub log: bool,
    /// In words, those of the first class, and how many classes differ from it.
    pub words: String,
    laws: Vec<Law>,
}

impl Declared {
    /// Of a parameter, over classes with so many samples each.
    pub fn of(recipe: &Recipe, parameter: &Parameter, samples: &[u64]) -> Option<Self> {
        let path = parameter.path();
        let of_class = |(class, &samples): (&crate::recipe::Class, &u64)| {
            let law = recipe.distribution(&class.name, &path)?.clone();
            let (min, max) = law.bounds(parameter);
            Some(Law { law, min, max, samples })
        };
        let laws: Vec<Law> =
            recipe.classes().iter().zip(samples).filter(|(_, n)| **n > 0).filter_map(of_class).collect();
        let first = laws.first()?;
        let others = laws.iter().filter(|law| law.law != first.law).count();
        let more =
            if others > 0 { format!("; otherwise in {others} of {} classes", laws.len()) } else { String::new() };
        Some(Self {
            min: laws.iter().map(|law| law.min).fold(f64::INFINITY, f64::min),
            max: laws.iter().map(|law| law.max).fold(f64::NEG_INFINITY, f64::max),
            log: laws.iter().any(|law| is_log(&law.law)) && laws.iter().all(|law| law.min > 0.0),
            words: words(&first.law) + &more,
            laws,
        })
    }

    /// Samples that a cell of the axis should hold at evenly spaced places; empty where no class has a density.
    pub fn curve(&self, axis: Axis) -> Vec<f64> {
        let mut curve = vec![0.0; 4 * CELLS + 1];
        if matches!(axis, Axis::Whole(..)) || self.laws.iter().all(|law| law.law.values().is_some()) {
            return Vec::new();
        }
        let steps = (curve.len() - 1) as f64;
        for law in self.laws.iter().filter(|law| law.max > law.min) {
            let width = (law.max - law.min) / POINTS as f64;
            let area: f64 =
                (0..POINTS).map(|i| weight(&law.law, law.min + (i as f64 + 0.5) * width)).sum::<f64>() * width;
            if area <= 0.0 {
                continue;
            }
            for (i, point) in curve.iter_mut().enumerate() {
                let x = axis.value(i as f64 / steps);
                if (law.min..=law.max).contains(&x) {
                    // Length of a cell around x, which grows along a logarithmic axis.
                    let half = 0.5 / CELLS as f64;
                    let (a, b) = (axis.value(i as f64 / steps - half), axis.value(i as f64 / steps + half));
                    *point += law.samples as f64 * weight(&law.law, x) / area * (b - a);
                }
            }
        }
        curve
    }
}

fn is_log(law: &Distribution) -> bool {
    match law {
        Distribution::LogUniform { .. } | Distribution::Lognormal { .. } => true,
        Distribution::Truncated { of, .. } => is_log(of),
        _ => false,
    }
}

/// The density up to a factor.
fn weight(law: &Distribution, x: f64) -> f64 {
    match law {
        Distribution::Fixed(_) | Distribution::Choice { .. } => 0.0,
        Distribution::Uniform { .. } => 1.0,
        Distribution::LogUniform { .. } => 1.0 / x,
        Distribution::Normal { mean, sd } => libm::exp(-0.5 * ((x - mean) / sd).powi(2)),
        Distribution::Lognormal { median, log_sd } => libm::exp(-0.5 * (libm::log(x / median) / log_sd).powi(2)) / x,
        Distribution::Truncated { of, .. } => weight(of, x),
    }
}

fn words(law: &Distribution) -> String {
    match law {
        Distribution::Fixed(value) => format!("always {value}"),
        Distribution::Uniform { min, max } => format!("uniform {min} to {max}"),
        Distribution::LogUniform { min, max } => format!("log-uniform {min} to {max}"),
        Distribution::Normal { mean, sd } => format!("normal, mean {mean}, sd {sd}"),
        Distribution::Lognormal { median, log_sd } => format!("lognormal, median {median}, log sd {log_sd}"),
        Distribution::Choice { values, .. } => {
            format!("one of {}", values.iter().map(f64::to_string).collect::<Vec<_>>().join(", "))
        }
        Distribution::Truncated { of, min, max } => format!("{}, cut to {min} to {max}", words(of)),
    }
}
