//! Declared distribution of a number: the density that its recipe declares, to hold the histogram to.
//!
//! The curve is the mixture over the classes that the dataset holds, each with the number of its samples. A class that
//! gives a fixed number or a choice adds to the range and nothing to the curve: it has no density.

use super::histogram::{HistogramAxis, MAX_BINS};
use base::Parameter;
use recipe::{Distribution, Recipe};

/// Points of a curve, and cells of the sum that makes its area 1.
const INTEGRATION_POINTS: usize = 400;

/// The law of one class.
#[derive(Debug, Clone)]
struct ClassLaw {
    law: Distribution,
    min: f64,
    max: f64,
    samples: u64,
}

/// What a recipe declares of a number.
#[derive(Debug, Clone)]
pub(super) struct DeclaredDistribution {
    /// Smallest draw.
    pub min: f64,
    /// Largest draw.
    pub max: f64,
    /// Whether it varies in the logarithm.
    pub log: bool,
    /// In words: the laws that most samples follow, three at most, and how many classes follow others.
    pub words: String,
    laws: Vec<ClassLaw>,
}

impl DeclaredDistribution {
    /// Of a parameter, over classes with `samples` samples each.
    pub fn of(recipe: &Recipe, parameter: &Parameter, samples: &[u64]) -> Option<Self> {
        let path = parameter.path();
        let of_class = |(class, &samples): (&recipe::SampleClass, &u64)| {
            let law = recipe.distribution(&class.name, &path)?.clone();
            let (min, max) = law.bounds(parameter);
            Some(ClassLaw { law, min, max, samples })
        };
        let laws: Vec<ClassLaw> =
            recipe.classes().iter().zip(samples).filter(|(_, n)| **n > 0).filter_map(of_class).collect();
        laws.first()?;
        Some(Self {
            min: laws.iter().map(|law| law.min).fold(f64::INFINITY, f64::min),
            max: laws.iter().map(|law| law.max).fold(f64::NEG_INFINITY, f64::max),
            log: laws.iter().any(|law| law.law.is_log()) && laws.iter().all(|law| law.min > 0.0),
            words: describe_mixture(&laws),
            laws,
        })
    }

    /// Samples that a cell of the axis should hold at evenly spaced places; empty where no class has a density.
    pub fn curve(&self, axis: HistogramAxis) -> Vec<f64> {
        let mut curve = vec![0.0; 4 * MAX_BINS + 1];
        if matches!(axis, HistogramAxis::Whole(..)) || self.laws.iter().all(|law| law.law.values().is_some()) {
            return Vec::new();
        }
        let steps = (curve.len() - 1) as f64;
        for law in self.laws.iter().filter(|law| law.max > law.min) {
            let width = (law.max - law.min) / INTEGRATION_POINTS as f64;
            let area: f64 = (0..INTEGRATION_POINTS)
                .map(|i| unscaled_density(&law.law, law.min + (i as f64 + 0.5) * width))
                .sum::<f64>()
                * width;
            if area <= 0.0 {
                continue;
            }
            for (i, point) in curve.iter_mut().enumerate() {
                // Of the ends, what rounding takes off is given back.
                let at = axis.value(i as f64 / steps);
                let x = at.clamp(law.min, law.max);
                if (at - x).abs() <= 1e-9 * (law.max - law.min) {
                    // Length of a cell around x, which grows along a logarithmic axis.
                    let half = 0.5 / MAX_BINS as f64;
                    let (a, b) = (axis.value(i as f64 / steps - half), axis.value(i as f64 / steps + half));
                    *point += law.samples as f64 * unscaled_density(&law.law, x) / area * (b - a);
                }
            }
        }
        curve
    }
}

/// The laws in words, the commonest first.
fn describe_mixture(laws: &[ClassLaw]) -> String {
    // Each law with its samples and its classes.
    let mut kinds: Vec<(&Distribution, u64, usize)> = Vec::new();
    for law in laws {
        match kinds.iter_mut().find(|(known, ..)| **known == law.law) {
            Some((_, samples, classes)) => (*samples, *classes) = (*samples + law.samples, *classes + 1),
            None => kinds.push((&law.law, law.samples, 1)),
        }
    }
    kinds.sort_by_key(|&(_, samples, _)| std::cmp::Reverse(samples));
    let bare = |law: &Distribution| match law {
        Distribution::Fixed(value) => value.to_string(),
        law => describe(law),
    };
    match &kinds[..] {
        [] => String::new(),
        [(law, ..)] => describe(law),
        [(first, _, n), (second, ..)] => {
            format!("{} in {n} of {} classes, otherwise {}", bare(first), laws.len(), bare(second))
        }
        [(first, _, n), rest @ ..] => {
            // A third law is as short as the words for more of them.
            let named = if rest.len() == 2 { 2 } else { 1 };
            let mut told = format!("{} in {n} of {} classes", bare(first), laws.len());
            told.extend(rest[..named].iter().map(|(law, _, n)| format!(", {} in {n}", bare(law))));
            let others: usize = rest[named..].iter().map(|(.., classes)| classes).sum();
            if others > 0 { told + &format!(", other laws in {others}") } else { told }
        }
    }
}

/// The density up to a factor.
fn unscaled_density(law: &Distribution, x: f64) -> f64 {
    match law {
        Distribution::Fixed(_) | Distribution::Choice { .. } => 0.0,
        Distribution::Uniform { .. } => 1.0,
        Distribution::LogUniform { .. } => 1.0 / x,
        Distribution::Normal { mean, sd } => libm::exp(-0.5 * ((x - mean) / sd).powi(2)),
        Distribution::Lognormal { median, log_sd } => libm::exp(-0.5 * (libm::log(x / median) / log_sd).powi(2)) / x,
        Distribution::Truncated { of, .. } => unscaled_density(of, x),
    }
}

fn describe(law: &Distribution) -> String {
    match law {
        Distribution::Fixed(value) => format!("always {value}"),
        Distribution::Uniform { min, max } => format!("uniform {min} to {max}"),
        Distribution::LogUniform { min, max } => format!("log-uniform {min} to {max}"),
        Distribution::Normal { mean, sd } => format!("normal, mean {mean}, sd {sd}"),
        Distribution::Lognormal { median, log_sd } => format!("lognormal, median {median}, log sd {log_sd}"),
        Distribution::Choice { values, .. } => {
            format!("one of {}", values.iter().map(f64::to_string).collect::<Vec<_>>().join(", "))
        }
        Distribution::Truncated { of, min, max } => format!("{}, cut to {min} to {max}", describe(of)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn law(law: Distribution, [min, max]: [f64; 2], samples: u64) -> ClassLaw {
        ClassLaw { law, min, max, samples }
    }

    /// The law of most samples comes first, and "always" is said of all classes alone.
    #[test]
    fn the_commonest_law_leads() {
        let zero = |samples| law(Distribution::Fixed(0.0), [0.0, 0.0], samples);
        let uniform = |max, samples| law(Distribution::Uniform { min: 1.0, max }, [1.0, max], samples);
        assert_eq!(describe_mixture(&[zero(3), zero(5)]), "always 0");
        assert_eq!(describe_mixture(&[uniform(2.0, 3)]), "uniform 1 to 2");
        assert_eq!(
            describe_mixture(&[zero(3), uniform(2.0, 2), zero(1)]),
            "0 in 2 of 3 classes, otherwise uniform 1 to 2"
        );
        assert_eq!(
            describe_mixture(&[zero(3), uniform(2.0, 2), uniform(2.0, 2)]),
            "uniform 1 to 2 in 2 of 3 classes, otherwise 0"
        );
        let many = [zero(3), uniform(2.0, 2), uniform(3.0, 1), uniform(4.0, 1), zero(1)];
        assert_eq!(describe_mixture(&many), "0 in 2 of 5 classes, uniform 1 to 2 in 1, other laws in 2");
        assert_eq!(describe_mixture(&many[..3]), "0 in 1 of 3 classes, uniform 1 to 2 in 1, uniform 1 to 3 in 1");
    }

    /// A curve goes to both ends of what is declared, whatever rounding makes of the ends of the axis.
    #[test]
    fn curves_reach_their_ends() {
        for i in 1..200_u32 {
            let (min, max) = (f64::from(i) / 30.0, f64::from(i) / 30.0 + f64::from(i % 7 + 1) / 70.0);
            for (of, axis) in [
                (Distribution::Uniform { min, max }, HistogramAxis::Linear(min, max)),
                (Distribution::LogUniform { min, max }, HistogramAxis::Log(min, max)),
            ] {
                let declared = DeclaredDistribution {
                    min,
                    max,
                    log: false,
                    words: String::new(),
                    laws: vec![law(of, [min, max], 24)],
                };
                let curve = declared.curve(axis);
                assert!(curve.iter().all(|count| (count - 1.0).abs() < 0.01), "{axis:?}: {curve:?}");
            }
        }
        let narrow = Distribution::Uniform { min: 1.0, max: 2.0 };
        let declared = DeclaredDistribution {
            min: 1.0,
            max: 2.0,
            log: false,
            words: String::new(),
            laws: vec![law(narrow, [1.0, 2.0], 24)],
        };
        let curve = declared.curve(HistogramAxis::Linear(0.0, 3.0));
        assert_eq!((curve[0], curve[curve.len() - 1], curve[curve.len() / 2] > 0.0), (0.0, 0.0, true));
    }
}
