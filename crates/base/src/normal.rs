//! Normal random numbers that are the same bits on every CPU.
//!
//! Models: exp(-x^2 / 2) / sqrt(2 pi). Source: the polar method of Marsaglia and Bray (1964). The tails of the usual
//! ziggurat ask the system's exp and ln, which differ in the last bit from one CPU to the next.

use rand::{Rng, RngExt};

/// One standard normal number.
pub fn normal(rng: &mut impl Rng) -> f64 {
    loop {
        let (u, v) = (2.0 * rng.random::<f64>() - 1.0, 2.0 * rng.random::<f64>() - 1.0);
        let square = u * u + v * v;
        if 0.0 < square && square < 1.0 {
            return u * (-2.0 * libm::log(square) / square).sqrt();
        }
    }
}

/// One number whose logarithm is normal, about a median and with a standard deviation of the logarithm [1].
pub fn lognormal(rng: &mut impl Rng, median: f64, log_sd: f64) -> f64 {
    median * libm::exp(log_sd * normal(rng))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Stream;

    #[test]
    fn moments_and_tails_are_normal() {
        let mut rng = Stream::root(1).child("normal").rng();
        let n = 400_000;
        let draws: Vec<f64> = (0..n).map(|_| normal(&mut rng)).collect();
        let mean = |f: &dyn Fn(f64) -> f64| draws.iter().map(|&x| f(x)).sum::<f64>() / f64::from(n);
        // Value, expected mean and standard deviation of one draw of it; 6 tests, alpha 0.001 in all: 3.8 errors.
        let below = |p: f64| (p * (1.0 - p)).sqrt();
        let tests: [(f64, f64, f64); 6] = [
            (mean(&|x| x), 0.0, 1.0),
            (mean(&|x| x * x), 1.0, 2.0_f64.sqrt()),
            (mean(&|x| x.powi(3)), 0.0, 15.0_f64.sqrt()),
            (mean(&|x| x.powi(4)), 3.0, 96.0_f64.sqrt()),
            (mean(&|x| f64::from(x.abs() < 0.674_489_75)), 0.5, 0.5),
            (mean(&|x| f64::from(x > 3.0)), 1.349_898e-3, below(1.349_898e-3)),
        ];
        for (value, expected, sd) in tests {
            assert!((value - expected).abs() < 3.8 * sd / f64::from(n).sqrt(), "{value} for {expected}");
        }
    }
}
