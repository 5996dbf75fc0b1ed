//! Dust on the window that the fan leaves by: columns that are darker through whole scans.
//!
//! A grain near the origin of the fan throws a shadow onto the line that is magnified by the distances from there: 0.3
//! mm at 30 mm is 4 mm wide at 400 mm. It takes a share of the light, since the sheet is thicker there than the grain:
//!
//! ```text
//! factor on q(t)    product over grains of 1 - a exp(-(t - t0)^2 / (2 s^2))
//! ```
//!
//! t0 is even over the fan, a even up to the share asked for, s log-normal about the width asked for. Grains belong to
//! the instrument: samples of one rig have the same. An engineering model. Neglected: light that grains scatter,
//! diffraction, grains that come and go. A grain on the lens dims no column: it is far out of focus, and is part of its
//! veiling glare.

use base::{Stream, lognormal};
use optical_bench::parameters::LaserParameters;
use rand::RngExt;

/// Steps of the table over the fan.
const STEPS: usize = 16_384;
/// Spread of the logarithm of a shadow's width [1].
const LOG_SD: f64 = 0.4;
/// Full width at half depth of a Gaussian, in standard deviations [1].
const FWHM_SIGMAS: f64 = 2.354_82;

/// What dust leaves of the light, over tangents of the fan.
#[derive(Debug, Clone)]
pub(super) struct DustShadows {
    reach: f32,
    factor: Vec<f32>,
}

impl DustShadows {
    /// On a fan with the tangent `half` at its ends; `None` for a clean window.
    pub fn new(bench: &LaserParameters, half: f64, stream: Stream) -> Option<Self> {
        let count = bench.dust_count.round() as u64;
        let reach = 1.5 * half;
        let step = 2.0 * reach / STEPS as f64;
        let mut factor = vec![1.0; STEPS + 1];
        for grain in 0..count {
            let mut rng = stream.index(grain).rng();
            let middle = half * (2.0 * rng.random::<f64>() - 1.0);
            let share = bench.dust_shade * rng.random::<f64>();
            let sigma = lognormal(&mut rng, bench.dust_mm, LOG_SD) / (FWHM_SIGMAS * bench.fan_height_mm);
            for (i, factor) in factor.iter_mut().enumerate() {
                let off = (i as f64 * step - reach - middle) / sigma;
                *factor *= 1.0 - share * libm::exp(-0.5 * off * off);
            }
        }
        (count > 0).then(|| Self { reach: reach as f32, factor: factor.into_iter().map(|f| f as f32).collect() })
    }

    /// The factor at the tangent `t` of the fan [1].
    #[inline]
    pub fn at(&self, t: f32) -> f32 {
        let place = ((t + self.reach) * (0.5 * STEPS as f32 / self.reach)).clamp(0.0, STEPS as f32 - 0.5);
        let left = place as usize;
        self.factor[left] + (self.factor[left + 1] - self.factor[left]) * (place - left as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of 2000 windows with one grain each: the deepest point takes shares even up to the one asked for, the width at
    /// half depth is log-normal about the one asked for, places are even over the fan; within 4 standard errors.
    #[test]
    fn grains_are_as_deep_and_wide_as_asked_for() {
        let mut bench = LaserParameters::from_values(&mut |p| p.default);
        (bench.dust_count, bench.dust_shade, bench.dust_mm) = (1.0, 0.6, 4.0);
        let (half, count) = (0.4, 2000);
        let (mut depths, mut logs, mut places) = (Vec::new(), Vec::new(), Vec::new());
        for i in 0..count {
            let dust = DustShadows::new(&bench, half, Stream::root(i)).expect("dust");
            let lost: Vec<f64> = dust.factor.iter().map(|f| 1.0 - f64::from(*f)).collect();
            let deepest = lost.iter().fold(0.0f64, |a, b| a.max(*b));
            let wide = lost.iter().filter(|lost| **lost > 0.5 * deepest).count();
            let step = 2.0 * f64::from(dust.reach) / STEPS as f64 * bench.fan_height_mm;
            depths.push(deepest);
            // Depths of a few rounding steps have no width.
            if deepest > 0.01 {
                logs.push((wide as f64 * step / 4.0).ln());
            }
            let at = lost.iter().position(|lost| *lost == deepest).expect("a deepest point") as f64;
            places.push((at * step / bench.fan_height_mm - f64::from(dust.reach)) / half);
        }
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let n = f64::from(count as u32).sqrt();
        assert!((mean(&depths) - 0.3).abs() < 4.0 * 0.6 / 12f64.sqrt() / n, "{}", mean(&depths));
        assert!(mean(&logs).abs() < 4.0 * LOG_SD / n, "{}", mean(&logs));
        assert!(mean(&places).abs() < 4.0 / 3f64.sqrt() / n, "{}", mean(&places));
        bench.dust_count = 0.0;
        assert!(DustShadows::new(&bench, half, Stream::root(0)).is_none());
    }
}
