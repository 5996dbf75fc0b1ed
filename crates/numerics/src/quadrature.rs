//! Gauss-Legendre quadrature: nodes and weights; and normalised Legendre functions.
//!
//! The rule with n nodes is exact for polynomials of degree 2 n - 1 (Gauss 1814); nodes by Newton's method from
//! Tricomi's first guess. Where an integrand has a kink or a square root (Fresnel's law at the critical angle), the
//! interval is to be cut there: across it the error only falls as n^(-3/2).

use std::f64::consts::PI;

/// Nodes and weights on [-1, 1] for `count` nodes, rising.
pub(crate) fn gauss_legendre(count: usize) -> Vec<(f64, f64)> {
    let n = count as f64;
    let mut rule = vec![(0.0, 0.0); count];
    for i in 0..count.div_ceil(2) {
        let mut x = libm::cos(PI * (i as f64 + 0.75) / (n + 0.5));
        let mut slope = 1.0;
        for _ in 0..100 {
            let (mut last, mut value) = (1.0, x);
            for l in 2..=count {
                let l = l as f64;
                (last, value) = (value, ((2.0 * l - 1.0) * x * value - (l - 1.0) * last) / l);
            }
            slope = n * (x * value - last) / (x * x - 1.0);
            let change = value / slope;
            x -= change;
            if change.abs() < 1e-15 {
                break;
            }
        }
        let weight = 2.0 / ((1.0 - x * x) * slope * slope);
        rule[i] = (-x, weight);
        rule[count - 1 - i] = (x, weight);
    }
    rule
}

/// The rule on each interval between rising `edges`, one after the other.
pub fn composite(edges: &[f64], count: usize) -> Vec<(f64, f64)> {
    let rule = gauss_legendre(count);
    edges
        .windows(2)
        .flat_map(|edge| {
            let (middle, half) = (0.5 * (edge[0] + edge[1]), 0.5 * (edge[1] - edge[0]));
            rule.iter().map(move |&(x, w)| (middle + half * x, half * w))
        })
        .collect()
}

/// Legendre functions of order `m` and degrees `m..=degree` at `x`, so normalised that times sqrt(2) cos(m phi), or 1
/// for m = 0, their square over the sphere is 1.
pub fn legendre(m: usize, degree: usize, x: f64) -> Vec<f64> {
    let sine = (1.0 - x * x).max(0.0).sqrt();
    let mut first = (0.25 / PI).sqrt();
    for k in 1..=m {
        let k = k as f64;
        first *= sine * ((2.0 * k + 1.0) / (2.0 * k)).sqrt();
    }
    let mut values = vec![first];
    let m = m as f64;
    let step = |l: f64| ((4.0 * l * l - 1.0) / (l * l - m * m)).sqrt();
    for i in 1..=degree.saturating_sub(m as usize) {
        let l = m + i as f64;
        let before = if i > 1 { values[i - 2] / step(l - 1.0) } else { 0.0 };
        values.push(step(l) * (x * values[i - 1] - before));
    }
    values
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Purpose: the rule is exact up to its degree and the harmonics are orthonormal.
    #[test]
    fn polynomials_are_exact_and_harmonics_orthonormal() {
        for count in [1, 2, 5, 8, 64] {
            let sum: f64 = gauss_legendre(count).iter().map(|&(x, w)| w * x.powi(2 * count as i32 - 2)).sum();
            let exact = 2.0 / (2 * count - 1) as f64;
            assert!((sum - exact).abs() < 1e-13, "{count} nodes: {sum} against {exact}");
        }
        let rule = gauss_legendre(40);
        for m in [0, 1, 4] {
            for (a, b) in [(0, 0), (0, 1), (2, 2), (3, 5), (11, 11)] {
                let product = |x: f64| {
                    let values = legendre(m, m + 11, x);
                    values[a] * values[b]
                };
                let sum: f64 = rule.iter().map(|&(x, w)| 2.0 * PI * w * product(x)).sum();
                let exact = if a == b { 1.0 } else { 0.0 };
                assert!((sum - exact).abs() < 1e-12, "order {m}, degrees {a}, {b}: {sum}");
            }
        }
    }
}
