//! Tests of counts against their chances: exact binomial, likelihood ratio.

use libm::{exp, lgamma, log, log1p};

/// Chance that a count of `samples` with the chance `share` each is as far off as `count`, or farther, on either side:
/// twice the exact binomial tail on its side (Clopper and Pearson 1934), at most 1.
pub fn binomial(samples: u64, count: u64, share: f64) -> f64 {
    let (n, x) = (samples as f64, count as f64);
    if count > samples {
        return 0.0;
    }
    if share <= 0.0 || share >= 1.0 {
        return if x == n * share.clamp(0.0, 1.0) { 1.0 } else { 0.0 };
    }
    let log_binomial = lgamma(n + 1.0) - lgamma(x + 1.0) - lgamma(n - x + 1.0);
    let first = exp(log_binomial + x * log(share) + (n - x) * log1p(-share));
    // Outwards from the count the terms only fall.
    let odds = share / (1.0 - share);
    let (mut term, mut tail, mut k) = (first, first, x);
    let upwards = x >= n * share;
    while term > tail * f64::EPSILON {
        if upwards {
            term *= (n - k) / (k + 1.0) * odds;
            k += 1.0;
        } else {
            term *= k / (n - k + 1.0) / odds;
            k -= 1.0;
        }
        tail += term;
    }
    (2.0 * tail).min(1.0)
}

/// Likelihood-ratio chi-square G = 2 sum count ln(count / expected) of counts against their chances (Wilks 1938);
/// infinite where something was counted that has no chance.
pub fn likelihood_ratio(counts: &[u64], chances: &[f64]) -> f64 {
    let n = counts.iter().sum::<u64>() as f64;
    let seen = counts.iter().zip(chances).filter(|(count, _)| **count > 0);
    2.0 * seen.map(|(&count, chance)| count as f64 * log(count as f64 / (n * chance))).sum::<f64>().max(0.0)
}

/// Upper bound of the chance that G of `cells` cells is `statistic` or more, at any number of samples (Agrawal 2020,
/// theorem 1.2): e^-x (e x / k)^k with x = G / 2 and k = cells - 1, for x > k.
pub fn likelihood_ratio_chance(statistic: f64, cells: usize) -> f64 {
    let (x, k) = (statistic / 2.0, cells.saturating_sub(1) as f64);
    if x <= k || k == 0.0 {
        return 1.0;
    }
    if x.is_infinite() { 0.0 } else { exp(k - x + k * log(x / k)) }
}
