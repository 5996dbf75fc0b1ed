//! Correlation of fully developed speckle behind square pixels (Goodman 2007, 4.4).
//!
//! A round lens of working f-number N (1 + m) makes grains of L = lambda N (1 + m) whose intensity is correlated by
//! |mu|^2 = [2 J1(pi r / L) / (pi r / L)]^2. Behind a pixel of side a the contrast is
//!
//! ```text
//! C^2 = (1 / a^4) int int (a - |u|) (a - |v|) |mu(u, v)|^2 du dv,
//! ```
//!
//! and pixels d apart have the same integral with u + d for u. It shares no code with the simulator.

use std::f64::consts::PI;

use optical_bench::parameters::Bench;

/// Steps of the integrals over a pixel, and lags in a pixel and in all that are kept.
const PIXEL_STEPS: usize = 120;
const LAGS_PER_PIXEL: usize = 20;
const MAX_LAG_PX: usize = 8;
/// Width of a step, two pixels being integrated [px], and steps from a lag to the next.
const STRIP_PX: f64 = 2.0 / PIXEL_STEPS as f64;
const STEPS_PER_LAG: usize = PIXEL_STEPS / (2 * LAGS_PER_PIXEL);

/// Grain L over the pixel [1].
pub fn grain_px(bench: &Bench) -> f64 {
    let camera = &bench.camera;
    let magnification = camera.focal_length_mm / (camera.distance_mm - camera.focal_length_mm);
    bench.laser.wavelength_nm * 1e-3 * camera.f_number * (1.0 + magnification) / camera.pixel_um
}

/// Correlation of the light in pixels along a row or a column.
#[derive(Debug, Clone)]
pub struct PixelCorrelation {
    /// Covariance at lag 0, C^2, for light of mean 1 [1].
    pub variance: f64,
    /// Correlation at lags of 1/20 px [1].
    lags: Vec<f64>,
}

impl PixelCorrelation {
    /// For grains of `grain` pixels.
    pub fn of(grain: f64) -> Self {
        // The light of a strip of a pixel is the same for all lags that bring it there.
        let strips: Vec<f64> = (0..PIXEL_STEPS + STEPS_PER_LAG * LAGS_PER_PIXEL * MAX_LAG_PX)
            .map(|i| strip(grain, strip_place(i)))
            .collect();
        let covariance = |lag: usize| -> f64 {
            let weight = |i: usize| (1.0 - strip_place(i).abs()) * STRIP_PX;
            (0..PIXEL_STEPS).map(|i| weight(i) * strips[i + STEPS_PER_LAG * lag]).sum()
        };
        let lags: Vec<f64> = (0..=LAGS_PER_PIXEL * MAX_LAG_PX).map(covariance).collect();
        Self { variance: lags[0], lags: lags.iter().map(|lag| lag / lags[0]).collect() }
    }

    /// At a lag [px]; 0 beyond eight.
    pub fn at(&self, lag: f64) -> f64 {
        let place = lag.abs() * LAGS_PER_PIXEL as f64;
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
        2.0 / LAGS_PER_PIXEL as f64 * (self.lags.iter().sum::<f64>() - 0.5)
    }

    /// Closed form of the centre's spread for a line of standard deviation `sigma` [px].
    pub fn wide_line(&self, contrast: f64, sigma: f64) -> f64 {
        contrast * (sigma * self.length() / (4.0 * PI.sqrt())).sqrt()
    }
}

/// Middle of strip `i` along one axis, from a pixel before the first lag on [px].
fn strip_place(i: usize) -> f64 {
    -1.0 + (i as f64 + 0.5) * STRIP_PX
}

/// Integral of (1 - |v|) |mu(u, v)|^2 over v, across the axis of the lags [px].
fn strip(grain: f64, u: f64) -> f64 {
    let at = |j: usize| {
        let v = (j as f64 + 0.5) * STRIP_PX;
        let r = PI * libm::hypot(u, v) / grain;
        let airy = if r < 1e-6 { 1.0 } else { 2.0 * libm::j1(r) / r };
        2.0 * (1.0 - v) * airy * airy * STRIP_PX
    };
    (0..PIXEL_STEPS / 2).map(at).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Goodman's contrast for the eight pixels of docs/theory/instrument/speckle.md; the correlation length that it
    /// gives for 6 um.
    #[test]
    fn contrast_and_length_are_goodmans() {
        let pixels = [1.2, 2.4, 3.45, 4.8, 5.5, 6.0, 9.0, 12.0];
        let known = [0.867, 0.631, 0.487, 0.376, 0.335, 0.3115, 0.218, 0.168];
        for (pixel, contrast) in pixels.into_iter().zip(known) {
            let found = PixelCorrelation::of(1.968 / pixel).contrast();
            assert!((found / contrast - 1.0).abs() < 4e-3, "{pixel} um: {found} against {contrast}");
        }
    }
}
