//! Significance tests that compare measured with expected numbers: Student's t, and the distance of Kolmogorov and
//! Smirnov.
//!
//! Student's law through the incomplete beta function (continued fraction of Abramowitz and Stegun 1964, 26.5),
//! Kolmogorov's law with Stephens' (1970) correction for samples of finite size. Tested against table values.

/// Terms of a fraction; it needs some ten.
const FRACTION_TERMS: usize = 500;

/// Chance that Student's t with `freedom` degrees of freedom lies farther from 0 than `t` [1].
pub(crate) fn student(t: f64, freedom: f64) -> f64 {
    if !t.is_finite() {
        return 0.0;
    }
    incomplete_beta(freedom / (freedom + t * t), 0.5 * freedom, 0.5)
}

/// Greatest distance between the distribution of `sample`, which is sorted for it, and `below` [1].
pub fn distance(sample: &mut [f64], below: impl Fn(f64) -> f64) -> f64 {
    sample.sort_by(f64::total_cmp);
    let n = sample.len() as f64;
    let apart = |(i, &x): (usize, &f64)| {
        let law = below(x);
        (law - i as f64 / n).max((i as f64 + 1.0) / n - law)
    };
    sample.iter().enumerate().map(apart).fold(0.0, f64::max)
}

/// Chance of a [`distance`] above this for `n` independent draws of the law itself (Kolmogorov, Smirnov) [1].
pub fn kolmogorov(distance: f64, n: f64) -> f64 {
    let l = (n.sqrt() + 0.12 + 0.11 / n.sqrt()) * distance;
    if l < 0.2 {
        return 1.0;
    }
    let term = |k: i32| f64::from(1 - 2 * ((k - 1) % 2)) * libm::exp(-2.0 * f64::from(k * k) * l * l);
    (2.0 * (1..=100).map(term).sum::<f64>()).clamp(0.0, 1.0)
}

/// I_x(a, b).
fn incomplete_beta(x: f64, a: f64, b: f64) -> f64 {
    if x <= 0.0 || x >= 1.0 {
        return x.clamp(0.0, 1.0);
    }
    if x > (a + 1.0) / (a + b + 2.0) {
        return 1.0 - incomplete_beta(1.0 - x, b, a);
    }
    let front =
        libm::exp(libm::lgamma(a + b) - libm::lgamma(a) - libm::lgamma(b) + a * libm::log(x) + b * libm::log(1.0 - x));
    let fraction = |i: usize| {
        let m = (i / 2) as f64;
        let over = if i.is_multiple_of(2) {
            m * (b - m) / ((a + 2.0 * m - 1.0) * (a + 2.0 * m))
        } else {
            -(a + m) * (a + b + m) / ((a + 2.0 * m) * (a + 2.0 * m + 1.0))
        };
        (over * x, 1.0)
    };
    front / a / (1.0 + tail(fraction))
}

/// a1 / (b1 + a2 / (b2 + ...)) from its end.
fn tail(fraction: impl Fn(usize) -> (f64, f64)) -> f64 {
    (1..FRACTION_TERMS).rev().fold(0.0, |rest, i| {
        let (a, b) = fraction(i);
        a / (b + rest)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: f64, b: f64, bar: f64) {
        assert!((a - b).abs() < bar, "{a} {b}");
    }

    /// Tables of Student's and of Kolmogorov's law.
    #[test]
    fn laws_match_tables() {
        near(student(2.131_449_5, 15.0), 0.05, 1e-7);
        near(student(-63.656_741, 1.0), 0.01, 1e-7);
        near(student(0.0, 7.0), 1.0, 1e-12);
        near(kolmogorov(1.627_62 / 1e3, 1e6), 0.01, 2e-5);
        near(kolmogorov(1.358_1 / 1e3, 1e6), 0.05, 5e-5);
    }

    /// A sample on the law's own quantiles is half a step away; a law moved by a tenth is a tenth away.
    #[test]
    fn distances_are_as_drawn() {
        let mut even: Vec<f64> = (0..1000).rev().map(|i| (f64::from(i) + 0.5) / 1000.0).collect();
        near(distance(&mut even, |x| x), 5e-4, 1e-12);
        near(distance(&mut even, |x| (x - 0.1).max(0.0)), 0.1005, 1e-12);
    }
}
