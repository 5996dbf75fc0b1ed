//! What theory says of fully developed speckle behind square pixels.
//!
//! A round lens of working f-number N (1 + m) makes grains of L = lambda N (1 + m) whose intensity is correlated by
//! |mu|^2 = [2 J1(pi r / L) / (pi r / L)]^2 (Goodman 2007, 4.4). Behind a pixel of side a the contrast is
//!
//!     C^2 = (1 / a^4) int int (a - |u|) (a - |v|) |mu(u, v)|^2 du dv,
//!
//! pixels d apart have the same integral with u + d for u, and the law of one pixel is close to a gamma law of shape
//! 1 / C^2 (Goodman 2007, 4.6); exponential where the pixel is a point. For a line of standard deviation sigma [px] the centre
//! of gravity spreads by C sqrt(sigma L_c / (4 sqrt(pi))), L_c the integral of the correlation along the rows, which is the
//! limit of a line wide against a row of Dorsch, Häusler and Herrmann's (1994) uncertainty.

use std::f64::consts::PI;

use crate::optics::parameters::Bench;

/// Steps of the integrals over a pixel, and lags in a pixel and in all that are kept.
const STEPS: usize = 120;
const LAGS: usize = 20;
const REACH: usize = 8;

/// Grain L over the pixel [1].
pub fn grain_px(bench: &Bench) -> f64 {
    let camera = &bench.camera;
    let magnification = camera.focal_length_mm / (camera.distance_mm - camera.focal_length_mm);
    bench.laser.wavelength_nm * 1e-3 * camera.f_number * (1.0 + magnification) / camera.pixel_um
}

/// Correlation of the light in pixels along a row or a column.
#[derive(Debug, Clone)]
pub struct Correlation {
    /// Covariance at lag 0, C^2, for light of mean 1 [1].
    pub variance: f64,
    /// Correlation at lags of 1/20 px [1].
    lags: Vec<f64>,
}

impl Correlation {
    /// For grains of `grain` pixels.
    pub fn of(grain: f64) -> Self {
        let lags: Vec<f64> = (0..=LAGS * REACH).map(|i| covariance(grain, i as f64 / LAGS as f64)).collect();
        Self { variance: lags[0], lags: lags.iter().map(|lag| lag / lags[0]).collect() }
    }

    /// At a lag [px]; 0 beyond eight.
    pub fn at(&self, lag: f64) -> f64 {
        let place = lag.abs() * LAGS as f64;
        let (i, t) = (place as usize, place.fract());
        if i + 1 < self.lags.len() { self.lags[i] * (1.0 - t) + self.lags[i + 1] * t } else { 0.0 }
    }

    /// Contrast in one pixel (Goodman) [1].
    pub fn contrast(&self) -> f64 {
        self.variance.sqrt()
    }

    /// Its integral over all lags [px].
    pub fn length(&self) -> f64 {
        // Trapezoid; both sides.
        2.0 / LAGS as f64 * (self.lags.iter().sum::<f64>() - 0.5)
    }

    /// Closed form of the centre's spread for a line of standard deviation `sigma` [px].
    pub fn wide_line(&self, contrast: f64, sigma: f64) -> f64 {
        contrast * (sigma * self.length() / (4.0 * PI.sqrt())).sqrt()
    }
}

/// Covariance of two pixels `lag` apart along one axis [1].
fn covariance(grain: f64, lag: f64) -> f64 {
    let step = 2.0 / STEPS as f64;
    let mut sum = 0.0;
    for i in 0..STEPS {
        let u = -1.0 + (i as f64 + 0.5) * step;
        for j in 0..STEPS / 2 {
            let v = (j as f64 + 0.5) * step;
            let r = PI * libm::hypot(u + lag, v) / grain;
            let airy = if r < 1e-6 { 1.0 } else { 2.0 * libm::j1(r) / r };
            sum += 2.0 * (1.0 - u.abs()) * (1.0 - v) * airy * airy;
        }
    }
    sum * step * step
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Goodman's contrast for the eight pixels of docs/instrument.md, and the limits of points and of wide lines.
    #[test]
    fn contrast_and_length_are_goodmans() {
        let known = [(1.2, 0.867), (2.4, 0.631), (3.45, 0.487), (4.8, 0.376), (5.5, 0.335), (6.0, 0.3115), (9.0, 0.218), (12.0, 0.168)];
        for (pixel, contrast) in known {
            let found = Correlation::of(1.968 / pixel).contrast();
            assert!((found / contrast - 1.0).abs() < 4e-3, "{pixel} um: {found} against {contrast}");
        }
        // A pixel that is a point: the Airy function's own integral along a line, 1.081 L.
        let point = Correlation::of(1.0 / 0.9);
        assert!(point.length() > 1.081 / 0.9 * 0.99, "{}", point.length());
        // Behind 6 um at L = 1.968 um: correlation over one pixel of the line's point column, 0.68 um (docs/instrument.md).
        println!("{}", 6.0 * Correlation::of(0.328).length());
    }
}
