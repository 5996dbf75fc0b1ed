//! Vignetting, band-pass filter and ambient radiance: what mounts and filter take of the light, by its angle to the
//! axis.
//!
//! **Vignetting** by the mounts of the lens, beyond the cosines of geometry: 1 - V (tan / tan_edge)^2, the first term
//! of what any round mounts take.
//!
//! **Band-pass filter** before the lens: interference layers of effective index n pass, at an angle, what they would
//! pass straight at a longer wavelength (Macleod 2010, small angles),
//!
//! ```text
//! lambda' = lambda / sqrt(1 - sin^2 / n^2)
//! T(lambda') = Phi((lambda' - low) / s) - Phi((lambda' - high) / s),     s^2 = edge^2 + line^2
//! ```
//!
//! with edges smoothed by a normal law, which folds the laser's Gaussian line in exactly. **Ambient light** of the same
//! radiance from all sides meets every surface with E, whatever its slope, and a pixel collects of a Lambertian surface
//! of reflectance rho, by the constancy of radiance, in focus or not,
//!
//! ```text
//! rho E band / pi * A_pixel * pi D^2 / 4 * cos^4 cos(beta) v0 / v^3 * transmission
//! ```
//!
//! Neglected: the shift of the band for ambient light, light beyond the band (blocking 1e-4), shadows and colours of
//! the object other than the laser's.

use optical_bench::settings::{Filter, Optics};

use optical_bench::parameters::{Bench, CameraParameters};

/// Effective index of a filter's layers [M] [1].
const FILTER_INDEX: f64 = 1.9;
/// Standard deviation of a filter's edges in units of its width [M] [1].
const FILTER_EDGE: f64 = 0.04;
/// Band of wavelengths that reaches a silicon sensor without a filter [M] [nm].
const OPEN_BAND_NM: f64 = 450.0;
/// Full width at half maximum of a normal law in standard deviations.
const FWHM_SIGMAS: f64 = 2.354_820_045;
/// Steps of the table of transmission.
const FILTER_TABLE_STEPS: usize = 256;

/// Share of the light that passes mounts and filter, over the square of the tangent of its angle to the axis.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Vignetting {
    /// What mounts take by tangent^2 [1].
    loss: f32,
    /// Transmission of the filter for the laser, from tangent^2 = 0 on; empty without a filter.
    filter: Vec<f32>,
    /// Steps of it by tangent^2.
    scale: f32,
}

impl Vignetting {
    /// The field of a bench whose sensor ends at the tangents `edge` (half its width) and `corner` (its farthest
    /// corner).
    pub fn new(bench: &Bench, edge: f64, corner: f64) -> Self {
        let loss = (bench.camera.vignetting / (edge * edge)) as f32;
        let scale = FILTER_TABLE_STEPS as f64 / (1.1 * corner * corner);
        let filter = match bench.optics.filter {
            Filter::None => Vec::new(),
            Filter::BandPass => (0..=FILTER_TABLE_STEPS)
                .map(|i| {
                    passes(&bench.camera, i as f64 / scale, bench.laser.wavelength_nm, bench.laser.linewidth_nm) as f32
                })
                .collect(),
        };
        Self { loss, filter, scale: scale as f32 }
    }

    /// Whether mounts and filter let everything through.
    pub fn is_open(&self) -> bool {
        self.loss == 0.0 && self.filter.is_empty()
    }

    /// Share of light that passes the mounts [1].
    #[inline]
    pub(crate) fn mounts(&self, tangent2: f32) -> f32 {
        (1.0 - self.loss * tangent2).max(0.0)
    }

    /// Share of laser light that passes mounts and filter [1].
    #[inline]
    pub fn laser(&self, tangent2: f32) -> f32 {
        let mounts = self.mounts(tangent2);
        if self.filter.is_empty() {
            return mounts;
        }
        let place = (tangent2 * self.scale).min(FILTER_TABLE_STEPS as f32 - 1e-3);
        let i = place as usize;
        mounts * (self.filter[i] + (self.filter[i + 1] - self.filter[i]) * (place - i as f32))
    }
}

/// Share of a line of `wavelength` and full width `linewidth` [nm] that the filter passes at an angle [1].
fn passes(camera: &CameraParameters, tangent2: f64, wavelength: f64, linewidth: f64) -> f64 {
    let sin2 = tangent2 / (1.0 + tangent2);
    let straight = wavelength / (1.0 - sin2 / (FILTER_INDEX * FILTER_INDEX)).sqrt();
    let (edge, line) = (FILTER_EDGE * camera.filter_width_nm, linewidth / FWHM_SIGMAS);
    let soft = (edge * edge + line * line).sqrt() * std::f64::consts::SQRT_2;
    let half = 0.5 * camera.filter_width_nm;
    let off = straight - camera.filter_centre_nm;
    0.5 * (libm::erf((off + half) / soft) - libm::erf((off - half) / soft))
}

/// Middle and width of the band in which ambient light reaches the sensor [nm].
pub(crate) fn ambient_band(camera: &CameraParameters, optics: &Optics, wavelength: f64) -> [f64; 2] {
    match optics.filter {
        Filter::None => [wavelength, OPEN_BAND_NM],
        // The integral of T over wavelengths.
        Filter::BandPass => [camera.filter_centre_nm, camera.filter_width_nm],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// In the middle of the band all passes, at its edges half; at 12 degrees the band has moved by 0.6 % of the
    /// wavelength (physics of interference filters); and T integrates to the width.
    #[test]
    fn filter_passes_its_band_and_shifts_with_the_angle() {
        let mut camera = Bench::default().camera;
        (camera.filter_centre_nm, camera.filter_width_nm) = (660.0, 10.0);
        let pass = |nm: f64, degrees: f64| passes(&camera, degrees.to_radians().tan().powi(2), nm, 0.8);
        assert!(pass(660.0, 0.0) > 0.9999 && (pass(655.0, 0.0) - 0.5).abs() < 1e-6 && pass(650.0, 0.0) < 1e-6);
        let edge = |degrees: f64| {
            let (mut low, mut high) = (640.0, 660.0);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if pass(middle, degrees) < 0.5 { low = middle } else { high = middle }
            }
            low
        };
        let shift = 1.0 - edge(12.0) / edge(0.0);
        assert!((shift - 0.006).abs() < 2e-4, "the band moves by {shift}");
        let sum: f64 = (0..4000).map(|i| 0.01 * pass(640.0 + 0.01 * f64::from(i), 0.0)).sum();
        assert!((sum - 10.0).abs() < 1e-6, "the band is {sum} nm wide");
    }
}
