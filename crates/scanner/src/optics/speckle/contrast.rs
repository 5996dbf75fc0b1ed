//! Speckle contrast after averaging by pixels and movement.
//!
//! Goodman (2007, 4.4): C^2 = int int W(u, v) k(u, v) du dv with the autocorrelation W of what averages and the
//! covariance k of light of mean 1. A square pixel of side 1 has W = (1 - |u|)(1 - |v|); a movement by b pixels while
//! the shutter is open adds a box of b along the rows. Two laws:
//!
//! ```text
//! exponential    k = |mu|^2,  mu = 2 J1(pi r / L) / (pi r / L)
//! rayleigh       k = F(-1/2, -1/2; 1; |mu|^2) - 1,  C = sqrt(4 / pi - 1) = 0.523 in a point
//! ```
//!
//! The second is that of the square root of the intensity (Middleton 1960; F is Gauss' series), which the thesis took.
//! For a point and long travel b the first gives C^-2 = b / (1.081 L), close to the rule 1 + 0.9 b / L.

use std::f64::consts::PI;

use numerics::quadrature::composite;
use optical_bench::settings::SpeckleLaw;

/// Nodes in each interval of lags.
const NODES_PER_INTERVAL: usize = 8;
/// Terms of Gauss' series; the last one adds 1e-5 to the contrast where light is most alike.
const SERIES_TERMS: u32 = 40;

/// Contrast of fully developed speckle of `grain` pixels in square pixels that the image crosses by `travel` pixels
/// [1].
///
/// Within 4e-4 of itself for any grain above 0.004 pixels, within 1e-6 from a third of a pixel on for travel up to a
/// pixel.
pub(crate) fn pixel_contrast(grain: f64, law: SpeckleLaw, travel: f64) -> f64 {
    // All is even in both lags: a quarter of the plane, four times.
    let along = intervals(&[1.0], grain);
    let mut kinks = vec![1.0, 1.0 + travel];
    kinks.extend([travel, (1.0 - travel).abs()].into_iter().filter(|_| travel > 0.0));
    let down = intervals(&kinks, grain);
    let mut sum = 0.0;
    for &(v, share_v) in &down {
        let weight = 4.0 * share_v * overlap(v, travel);
        for &(u, share_u) in &along {
            sum += weight * share_u * (1.0 - u) * covariance(libm::hypot(u, v) / grain, law);
        }
    }
    sum.sqrt()
}

/// Autocorrelation over rows of a pixel that moves by `travel` [1/px]: half the second difference of a rounded |v|.
fn overlap(v: f64, travel: f64) -> f64 {
    let rounded = |v: f64| {
        let v = v.abs();
        if v >= travel { v } else { travel / 3.0 + v * v / travel - v * v * v / (3.0 * travel * travel) }
    };
    0.5 * (rounded(v + 1.0) - 2.0 * rounded(v) + rounded(v - 1.0))
}

/// Nodes and weights from 0 to the last of `kinks`, in intervals that end at each of them and are as long as a grain or
/// as their distance from 0, whichever is more: the covariance falls with the third power of the lag.
fn intervals(kinks: &[f64], grain: f64) -> Vec<(f64, f64)> {
    let mut kinks = kinks.to_vec();
    kinks.sort_by(f64::total_cmp);
    let mut edges = vec![0.0];
    let mut last: f64 = 0.0;
    for kink in kinks {
        while last + last.max(grain) < kink {
            last += last.max(grain);
            edges.push(last);
        }
        if kink > last {
            edges.push(kink);
            last = kink;
        }
    }
    composite(&edges, NODES_PER_INTERVAL)
}

/// Covariance of two points `lags` grains L apart in light of mean 1 [1].
fn covariance(lags: f64, law: SpeckleLaw) -> f64 {
    let r = PI * lags;
    let mu = if r < 1e-6 { 1.0 } else { 2.0 * libm::j1(r) / r };
    let alike = mu * mu;
    match law {
        SpeckleLaw::Exponential => alike,
        SpeckleLaw::Rayleigh => {
            let (mut term, mut sum) = (1.0, 0.0);
            for n in 1..=SERIES_TERMS {
                let factor = (f64::from(n) - 1.5) / f64::from(n);
                term *= factor * factor * alike;
                sum += term;
            }
            sum
        }
    }
}

/// Correlation of neighbouring pixels for grains of `grain` pixels, law of physics [1].
#[cfg(test)]
pub(super) fn neighbours(grain: f64) -> f64 {
    const STEPS_PER_PIXEL: usize = 160;
    let step = 1.0 / STEPS_PER_PIXEL as f64;
    let (mut own, mut other) = (0.0, 0.0);
    for i in 0..2 * STEPS_PER_PIXEL {
        let u = (i as f64 + 0.5) * step - 1.0;
        for j in 0..STEPS_PER_PIXEL {
            let v = (j as f64 + 0.5) * step;
            let weight = (1.0 - u.abs()) * (1.0 - v);
            own += weight * covariance(libm::hypot(u, v) / grain, SpeckleLaw::Exponential);
            other += weight * covariance(libm::hypot(u + 1.0, v) / grain, SpeckleLaw::Exponential);
        }
    }
    other / own
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pixel 6 um, grain 1.968 um: C = 0.3115; 3.45 um: 0.487; a point has 1, and 0.523 under the thesis' law.
    #[test]
    fn contrast_matches_goodman() {
        let contrast = |grain: f64, law| pixel_contrast(grain, law, 0.0);
        assert!((contrast(1.968 / 6.0, SpeckleLaw::Exponential) - 0.3115).abs() < 1e-3);
        assert!((contrast(1.968 / 3.45, SpeckleLaw::Exponential) - 0.487).abs() < 1e-3);
        assert!((contrast(100.0, SpeckleLaw::Exponential) - 1.0).abs() < 1e-3);
        assert!(
            (contrast(100.0, SpeckleLaw::Rayleigh) - 0.5227).abs() < 1e-3,
            "{}",
            contrast(100.0, SpeckleLaw::Rayleigh)
        );
    }

    /// The integral on a fine even grid, with the movement's triangle summed by itself: eight grains by five lengths of
    /// travel, both laws.
    #[test]
    fn few_nodes_are_enough() {
        for grain in [0.05, 0.1, 0.2, 0.328, 0.57, 1.0, 3.0, 100.0] {
            for travel in [0.0, 0.05, 0.4, 1.0, 2.5] {
                for law in [SpeckleLaw::Exponential, SpeckleLaw::Rayleigh] {
                    let (found, dense) = (pixel_contrast(grain, law, travel), on_a_grid(grain, law, travel));
                    assert!((found / dense - 1.0).abs() < 8e-4, "{grain} {travel}: {found} against {dense}");
                }
            }
        }
    }

    fn on_a_grid(grain: f64, law: SpeckleLaw, travel: f64) -> f64 {
        const STEPS_PER_PIXEL: usize = 60;
        let lags = if travel > 0.0 { 40 } else { 1 };
        let step = 1.0 / STEPS_PER_PIXEL as f64;
        let mut sum = 0.0;
        for k in 0..lags {
            let lag = 1.0 - 2.0 * (f64::from(k) + 0.5) / f64::from(lags);
            let share = if travel > 0.0 { (1.0 - lag.abs()) * 2.0 / f64::from(lags) } else { 1.0 };
            for j in 0..2 * STEPS_PER_PIXEL {
                let v = (j as f64 + 0.5) * step - 1.0;
                for i in 0..STEPS_PER_PIXEL {
                    let u = (i as f64 + 0.5) * step;
                    let alike = covariance(libm::hypot(u, v + travel * lag) / grain, law);
                    sum += 2.0 * share * (1.0 - v.abs()) * (1.0 - u) * alike;
                }
            }
        }
        (sum * step * step).sqrt()
    }

    /// For a point long travel leaves 1 / (1 + 0.9 b / L) of the variance, within 15 %, a short one more; pixels have
    /// averaged part of it before.
    #[test]
    fn movement_averages_as_the_rule_says() {
        let grain = 20.0;
        for grains in [0.5, 1.0, 2.0, 4.0, 8.0] {
            let variance = pixel_contrast(grain, SpeckleLaw::Exponential, grains * grain).powi(2);
            let rule = 1.0 / (1.0 + 0.9 * grains);
            let most = if grains < 4.0 { 0.4 } else { 0.15 };
            assert!((0.0..most).contains(&(variance / rule - 1.0)), "{grains} grains: {variance} against {rule}");
        }
        let still = pixel_contrast(0.328, SpeckleLaw::Exponential, 0.0);
        let moved = pixel_contrast(0.328, SpeckleLaw::Exponential, 1.0);
        assert!(moved / still > (1.0f64 / (1.0 + 0.9 / 0.328)).sqrt() && moved < still, "{moved} {still}");
    }
}
