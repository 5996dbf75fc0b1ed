//! Circle of confusion: the disc that a point out of focus is blurred to, as Gaussian components of a line.
//!
//! An even disc of radius R projected on the rows is a semicircle, 2 / (pi R^2) sqrt(R^2 - x^2). Its mean over a smooth
//! function is Gauss's quadrature of Chebyshev's second kind, exact for polynomials of degree 2 n - 1:
//!
//! ```text
//! x_k = R cos(k pi / (n + 1)),     w_k = 2 / (n + 1) sin^2(k pi / (n + 1)),     k = 1 .. n
//! ```
//!
//! so n Gaussians of what else blurs the line stand for the blurred line, as many as keep them nearer together than 1.6
//! standard deviations (2 exp(-2 pi^2 / 1.6^2) = 1e-3 of the sum), and one wider Gaussian where the disc is small.

use std::sync::LazyLock;

use crate::optics::light::MIN_VARIANCE;
use crate::optics::speckle::TILE;

/// Radius in standard deviations of the rest below which the disc is taken by its variance: its peak is off by 0.2 %.
const MIN_RADIUS_SIGMAS: f32 = 0.7;
/// Most components; discs wider than a window are torn apart.
const MAX_COMPONENTS: usize = 33;

/// Nodes in units of the radius, and weights, for each odd number of them.
static QUADRATURES: LazyLock<Vec<Vec<[f32; 2]>>> = LazyLock::new(|| {
    let law = |n: usize| {
        let part = std::f64::consts::PI / (n as f64 + 1.0);
        let point = |k: usize| {
            let (sin, cos) = libm::sincos(k as f64 * part);
            [cos as f32, (2.0 / (n as f64 + 1.0) * sin * sin) as f32]
        };
        (1..=n).map(point).collect()
    };
    (0..=MAX_COMPONENTS / 2).map(|half| law(2 * half + 1)).collect()
});

/// Nodes in units of the radius, and weights, for lines of the variance `wide` with the disc's in it, out of focus by
/// discs of the radius `disc`; empty where they are Gaussian enough.
pub fn components(disc: &[f32; TILE], wide: &[f32; TILE]) -> &'static [[f32; 2]] {
    let mut most = 0.0f32;
    for c in 0..TILE {
        let rest = (wide[c] - 0.25 * disc[c] * disc[c]).max(MIN_VARIANCE);
        most = most.max(disc[c] * disc[c] / rest);
    }
    let ratio = most.sqrt();
    if ratio < MIN_RADIUS_SIGMAS {
        return &[];
    }
    // pi R / (n + 1) <= 1.6 sigma.
    let half = (0.5 * (std::f32::consts::PI / 1.6 * ratio - 1.0)).ceil().max(1.0) as usize;
    &QUADRATURES[half.min(MAX_COMPONENTS / 2)]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Moments of the semicircle: 1, 0, 1/4, 0, 1/8; and a blurred one against the integral.
    #[test]
    fn components_stand_for_a_disc() {
        for law in QUADRATURES.iter().skip(1) {
            let moment = |power: i32| law.iter().map(|[x, w]| f64::from(*w) * f64::from(*x).powi(power)).sum::<f64>();
            for (power, truth) in [(0, 1.0), (1, 0.0), (2, 0.25), (3, 0.0), (4, 0.125)] {
                assert!(
                    (moment(power) - truth).abs() < 1e-6,
                    "{} components, moment {power}: {}",
                    law.len(),
                    moment(power)
                );
            }
        }
        for radius in [0.8f64, 2.0, 6.0, 10.0] {
            let law = components(&[radius as f32; TILE], &[(0.5 + 0.25 * radius * radius) as f32; TILE]);
            let gauss = |x: f64| (-x * x).exp() / std::f64::consts::PI.sqrt();
            let steps = 20_000;
            let peak = 2.0 / std::f64::consts::PI / radius;
            for x in [0.0, 0.5 * radius, radius, radius + 1.0] {
                let got: f64 = law.iter().map(|[n, w]| f64::from(*w) * gauss(x - radius * f64::from(*n))).sum();
                let cut = |i: i32| {
                    let t = (f64::from(i) + 0.5) / f64::from(steps) * 2.0 - 1.0;
                    2.0 * peak * (1.0 - t * t).sqrt() * gauss(x - radius * t) * radius / f64::from(steps)
                };
                let truth: f64 = (0..steps).map(cut).sum();
                assert!((got - truth).abs() < 4e-3 * peak.min(0.5), "radius {radius} at {x}: {got}, truth {truth}");
            }
        }
    }
}
