//! Contrast of speckle that pixels and movement average.
//!
//! Goodman (2007, 4.4): C^2 = int int W(u, v) k(u, v) du dv with the autocorrelation W of what averages and the covariance k
//! of light of mean 1. A square pixel of side 1 has W = (1 - |u|)(1 - |v|); a movement by b pixels while the shutter is open
//! adds a box of b along the rows. Two laws:
//!
//! ```text
//! exponential    k = |mu|^2,  mu = 2 J1(pi r / L) / (pi r / L)
//! rayleigh       k = F(-1/2, -1/2; 1; |mu|^2) - 1,  C = sqrt(4 / pi - 1) = 0.523 in a point
//! ```
//!
//! The second is that of the square root of the intensity (Middleton 1960; F is Gauss' series), which the thesis took.
//! For a point and long ways b the first gives C^-2 = b / (1.081 L), close to the rule 1 + 0.9 b / L.

use std::f64::consts::PI;

use crate::settings::SpeckleLaw;

/// Steps over a pixel, and over a movement.
const STEPS: usize = 160;
const WAY_STEPS: usize = 24;
/// Terms of Gauss' series; the last adds 1e-5 to the contrast where light is most alike.
const TERMS: u32 = 40;

/// Contrast of fully developed speckle of `grain` pixels in square pixels that the image crosses by `way` pixels [1].
pub fn pixel_contrast(grain: f64, law: SpeckleLaw, way: f64) -> f64 {
    // Lags of the movement by their share: a triangle.
    let lags: Vec<(f64, f64)> = if way > 0.0 {
        let lag = |i: usize| way * ((i as f64 + 0.5) / WAY_STEPS as f64 * 2.0 - 1.0);
        let share = |lag: f64| (1.0 - lag.abs() / way) * 2.0 / WAY_STEPS as f64;
        (0..WAY_STEPS).map(lag).map(|lag| (lag, share(lag))).collect()
    } else {
        vec![(0.0, 1.0)]
    };
    let step = 1.0 / STEPS as f64;
    let mut sum = 0.0;
    for (lag, share) in lags {
        // Where the movement is on one side the other side of the pixel counts too.
        for j in 0..2 * STEPS {
            let v = (j as f64 + 0.5) * step - 1.0;
            if way == 0.0 && v < 0.0 {
                continue;
            }
            let weight = share * (1.0 - v.abs()) * if way == 0.0 { 2.0 } else { 1.0 };
            for i in 0..STEPS {
                let u = (i as f64 + 0.5) * step;
                sum += 2.0 * weight * (1.0 - u) * covariance(libm::hypot(u, v + lag) / grain, law);
            }
        }
    }
    (sum * step * step).sqrt()
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
            for n in 1..=TERMS {
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
    let step = 1.0 / STEPS as f64;
    let (mut own, mut other) = (0.0, 0.0);
    for i in 0..2 * STEPS {
        let u = (i as f64 + 0.5) * step - 1.0;
        for j in 0..STEPS {
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

    /// For a point a long way leaves 1 / (1 + 0.9 b / L) of the variance, within 15 %, a short one more; pixels have averaged
    /// part of it before.
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
