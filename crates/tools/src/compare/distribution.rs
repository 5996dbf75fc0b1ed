//! Empirical distributions: quantiles and distances of two samples, exact with ties.
//!
//! Digitised numbers repeat. Quantiles are those of the mid-distribution F(x) - p(x)/2, linear between the values that
//! occur (Ma, Genton and Parzen 2011, "Asymptotic properties of sample quantiles of discrete distributions"): a step of
//! the instrument then does not show as a step of the quantile, and without ties they are the usual ones.
//!
//! The two-sample Kolmogorov-Smirnov distance is the largest difference of the two distribution functions, taken after
//! all numbers of a tie. Its significance follows the asymptotic law with the correction of Stephens (1970); with ties
//! that law errs on the safe side (Noether 1963), and it holds for independent numbers, so neighbours that share pixels
//! or noise make it too small. Wasserstein-1 is the area between the two functions, in the unit of the numbers.

/// Distance of the quartiles of the standard normal law.
pub(super) const QUARTILES: f64 = 1.348_979_500_392_163_5;

/// A sample of numbers in order of size.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct EmpiricalDistribution(Vec<f32>);

/// Distances between two samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DistributionDistance {
    /// Numbers in each sample.
    pub counts: [usize; 2],
    /// Kolmogorov-Smirnov distance [1].
    pub ks: f64,
    /// Chance of that distance or more between samples of one law, were their numbers independent [1].
    pub p: f64,
    /// Wasserstein-1 distance, in the unit of the numbers.
    pub wasserstein: f64,
}

impl EmpiricalDistribution {
    /// Puts numbers in order; NaN and infinities are left out.
    pub fn new(mut numbers: Vec<f32>) -> Self {
        numbers.retain(|x| x.is_finite());
        numbers.sort_unstable_by(f32::total_cmp);
        Self(numbers)
    }

    /// The numbers in order.
    pub fn numbers(&self) -> &[f32] {
        &self.0
    }

    /// Quantile of the mid-distribution, `share` in [0, 1]; `None` where there are no numbers.
    pub fn quantile(&self, share: f64) -> Option<f64> {
        let n = self.0.len() as f64;
        // The place in the middle of a tie.
        let (mut last, mut from): (Option<(f64, f64)>, usize) = (None, 0);
        while from < self.0.len() {
            let value = self.0[from];
            let to = from + self.0[from..].partition_point(|x| *x <= value);
            let here = ((from + to) as f64 / 2.0 / n, f64::from(value));
            if here.0 >= share {
                let Some(before) = last else { return Some(here.1) };
                let t = (share - before.0) / (here.0 - before.0);
                return Some(before.1 + t * (here.1 - before.1));
            }
            (last, from) = (Some(here), to);
        }
        last.map(|(_, value)| value)
    }

    /// Quantiles at 10, 50 and 90 %; `None` where there are no numbers.
    pub fn deciles(&self) -> Option<[f64; 3]> {
        Some([self.quantile(0.1)?, self.quantile(0.5)?, self.quantile(0.9)?])
    }

    /// Share of the mid-distribution below a number, the inverse of [`EmpiricalDistribution::quantile`]; 0 where there
    /// are no numbers.
    pub fn share(&self, number: f64) -> f64 {
        let numbers = &self.0;
        let n = numbers.len() as f64;
        // The value next to `number` on either side, and the place in the middle of its tie.
        let middle = |i: usize| {
            let value = numbers[i];
            let from = numbers.partition_point(|x| *x < value);
            let to = numbers.partition_point(|x| *x <= value);
            ((from + to) as f64 / 2.0 / n, f64::from(value))
        };
        let after = numbers.partition_point(|x| f64::from(*x) <= number);
        if after == 0 || after == numbers.len() {
            return if after == 0 { 0.0 } else { 1.0 };
        }
        let (low, high) = (middle(after - 1), middle(after));
        low.0 + (high.0 - low.0) * (number - low.1) / (high.1 - low.1)
    }

    /// Standard deviation of the normal law with the same quartiles; `None` where there are no numbers.
    pub(crate) fn robust_deviation(&self) -> Option<f64> {
        Some((self.quantile(0.75)? - self.quantile(0.25)?) / QUARTILES)
    }

    /// Distances to another sample; `None` where one has no numbers.
    pub fn distance(&self, other: &Self) -> Option<DistributionDistance> {
        let (a, b) = (&self.0, &other.0);
        let (n, m) = (a.len(), b.len());
        if n == 0 || m == 0 {
            return None;
        }
        let (mut i, mut j, mut ks, mut wasserstein) = (0, 0, 0.0_f64, 0.0);
        let mut before: Option<(f32, f64)> = None;
        while i < n || j < m {
            let value = match (a.get(i), b.get(j)) {
                (Some(x), Some(y)) => x.min(*y),
                (Some(x), None) | (None, Some(x)) => *x,
                (None, None) => break,
            };
            if let Some((place, apart)) = before {
                wasserstein += apart * (f64::from(value) - f64::from(place));
            }
            i += a[i..].iter().take_while(|x| **x <= value).count();
            j += b[j..].iter().take_while(|x| **x <= value).count();
            let apart = (i as f64 / n as f64 - j as f64 / m as f64).abs();
            ks = ks.max(apart);
            before = Some((value, apart));
        }
        Some(DistributionDistance { counts: [n, m], ks, p: significance(ks, n, m), wasserstein })
    }
}

/// Chance that two samples of one continuous law lie `ks` or more apart.
pub fn significance(ks: f64, n: usize, m: usize) -> f64 {
    let effective = (n as f64 * m as f64 / (n as f64 + m as f64)).sqrt();
    let lambda = (effective + 0.12 + 0.11 / effective) * ks;
    // Below this the alternating sum is 1 to eight digits and no longer converges well.
    if lambda < 0.3 {
        return 1.0;
    }
    let term = |k: i32| {
        let k = f64::from(k);
        let sign = if k as i32 % 2 == 1 { 2.0 } else { -2.0 };
        sign * libm::exp(-2.0 * k * k * lambda * lambda)
    };
    (1..=50).map(term).sum::<f64>().clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use base::{Stream, normal};
    use rand::RngExt;

    use super::*;

    /// Chance of a false alarm that each test of a random sample allows.
    const ALPHA: f64 = 1e-4;

    fn sample(
        name: &str,
        n: usize,
        mut draw: impl FnMut(&mut dyn FnMut() -> f64, &mut dyn FnMut() -> f64) -> f64,
    ) -> EmpiricalDistribution {
        let stream = Stream::root(7).child(name);
        let (mut even, mut bell) = (stream.child("even").rng(), stream.child("bell").rng());
        let mut numbers = Vec::new();
        for _ in 0..n {
            numbers.push(draw(&mut || even.random::<f64>(), &mut || normal(&mut bell)) as f32);
        }
        EmpiricalDistribution::new(numbers)
    }

    /// Quantiles by hand: the middle of ties, between them on a line, and beyond the ends the ends.
    #[test]
    fn quantiles_stand_in_the_middle_of_ties() {
        let s = EmpiricalDistribution::new(vec![3.0, 1.0, 1.0, f32::NAN, 2.0]);
        // Mid-distribution: 1 at 1/4, 2 at 5/8, 3 at 7/8.
        for (share, value) in [(0.0, 1.0), (0.25, 1.0), (0.4375, 1.5), (0.625, 2.0), (0.875, 3.0), (1.0, 3.0)] {
            assert!((s.quantile(share).expect("there are numbers") - value).abs() < 1e-12, "{share}");
        }
        for (value, share) in [(0.9, 0.0), (1.0, 0.25), (1.5, 0.4375), (2.0, 0.625), (2.5, 0.75), (3.0, 1.0)] {
            assert!((s.share(value) - share).abs() < 1e-12, "{value}");
        }
        assert_eq!(
            (EmpiricalDistribution::new(vec![]).quantile(0.5), EmpiricalDistribution::default().robust_deviation()),
            (None, None)
        );
    }

    /// The robust deviation of a rounded normal law is what the mid-distribution of that law makes it, near 1 for
    /// steps up to half of the deviation, where plain quartiles jump by whole steps.
    #[test]
    fn rounding_hardly_moves_the_deviation() {
        let below = |x: f64| 0.5 * (1.0 + libm::erf(x / std::f64::consts::SQRT_2));
        let n = 100_000;
        for step in [0.01, 0.25, 0.5] {
            // The middle of the tie at k steps is the mean of the law at its two ends; between them a chord.
            let middle = |k: i32| (below((f64::from(k) - 0.5) * step) + below((f64::from(k) + 0.5) * step)) / 2.0;
            let k = (0..1000).find(|&k| middle(k) >= 0.75).expect("the law passes its quartile");
            let quartile = f64::from(k) - (middle(k) - 0.75) / (middle(k) - middle(k - 1));
            let expected = quartile * step / 0.674_489_75;
            let found = sample("rounded", n, |_, bell| (bell() / step).round() * step).robust_deviation();
            let found = found.expect("there are numbers");
            // The interquartile range has a relative standard error of 1.167 / sqrt(n), on a chord half as much again.
            let error = 3.9 * 1.5 * 1.167 / (n as f64).sqrt();
            assert!((found - expected).abs() < error, "step {step}: {found}, not {expected} +- {error}");
            assert!((expected - 1.0).abs() < 0.07, "step {step}: {expected}");
        }
    }

    /// Distances by hand, with ties within and between the samples.
    #[test]
    fn distances_by_hand() {
        let of = |a: &[f32], b: &[f32]| {
            let d = EmpiricalDistribution::new(a.to_vec())
                .distance(&EmpiricalDistribution::new(b.to_vec()))
                .expect("there are numbers");
            (d.ks, d.wasserstein)
        };
        assert_eq!(of(&[1.0, 1.0, 2.0], &[1.0, 2.0, 1.0]), (0.0, 0.0), "a tie is no distance");
        assert_eq!(of(&[0.0, 0.0], &[3.0]), (1.0, 3.0));
        assert_eq!(of(&[0.0, 1.0], &[0.0, 2.0]), (0.5, 0.5));
        // F - G: 1/2 - 1/4 on [1, 2), 1/2 - 3/4 on [2, 3).
        assert_eq!(of(&[1.0, 3.0], &[1.0, 2.0, 2.0, 3.0]), (0.25, 0.5));
        assert_eq!(EmpiricalDistribution::default().distance(&EmpiricalDistribution::new(vec![1.0])), None);
    }

    /// A shift moves Wasserstein-1 by itself and the distance of uniform laws by its share; a scale, half of it times
    /// the mean distance from the middle.
    #[test]
    fn distances_of_known_laws() {
        let n = 40_000;
        let even = sample("a", n, |even, _| even());
        let shifted = sample("b", n, |even, _| even() + 0.25);
        let d = even.distance(&shifted).expect("there are numbers");
        // Dvoretzky, Kiefer and Wolfowitz: each function strays by e with chance 2 exp(-2 n e^2) at most.
        let stray = 2.0 * (libm::log(4.0 / ALPHA) / (2.0 * n as f64)).sqrt();
        assert!((d.ks - 0.25).abs() < stray && (d.wasserstein - 0.25).abs() < stray, "{d:?}, +- {stray}");
        assert!(d.p < ALPHA);
        let narrow = sample("c", n, |_, bell| bell());
        let wide = sample("d", n, |_, bell| 1.5 * bell());
        let d = narrow.distance(&wide).expect("there are numbers");
        // Half of the mean of |x| is sqrt(2 / pi) per unit of deviation: W1 = 0.5 sqrt(2 / pi).
        let expected = 0.5 * (2.0 / std::f64::consts::PI).sqrt();
        let error = 3.9 * (1.0 + 1.5) / (n as f64).sqrt();
        assert!((d.wasserstein - expected).abs() < error, "{d:?}, not {expected} +- {error}");
    }

    /// Known values of the law of Kolmogorov, and the rate of false alarms on samples of one law: right without ties,
    /// on the safe side with them.
    #[test]
    fn significance_keeps_its_promise() {
        // Smirnov (1948): the limit law passes 0.05 at 1.3581 and 0.01 at 1.6276.
        for (lambda, p) in [(1.3581, 0.05), (1.6276, 0.01)] {
            let n = 2_000_000;
            assert!((significance(lambda / (n as f64 / 2.0).sqrt(), n, n) - p).abs() < 2e-4);
        }
        let (trials, n) = (1000, 200);
        let alarms = |step: f64, name: &str| {
            let mut rng = Stream::root(3).child(name).rng();
            let draw = |rng: &mut dyn FnMut() -> f64| {
                EmpiricalDistribution::new(
                    (0..n).map(|_| if step > 0.0 { (rng() / step).round() * step } else { rng() } as f32).collect(),
                )
            };
            let mut one = || normal(&mut rng);
            (0..trials).filter(|_| draw(&mut one).distance(&draw(&mut one)).is_some_and(|d| d.p < 0.05)).count() as f64
        };
        // Binomial: 50 of 1000 with a deviation of 6.9.
        let (free, tied) = (alarms(0.0, "free"), alarms(0.7, "tied"));
        assert!((free - 50.0).abs() < 3.9 * 6.9, "{free} alarms");
        assert!(tied < free, "{tied} alarms with ties, {free} without");
    }
}
