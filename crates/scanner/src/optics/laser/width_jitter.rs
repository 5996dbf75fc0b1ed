//! Width jitter along the line: a factor 1 + n(x), n normal with a standard deviation and a correlation length.
//!
//! The noise is that of [`crate::optics::correlated_noise`] on a grid along the line, its length given at the
//! conveyor's height. It belongs to the laser and stays while the object moves. An engineering model of imperfect line
//! optics. Neglected: that width changes over height by itself.

use base::Stream;
use numerics::lanes::normals;

use crate::optics::correlated_noise::{NODES_PER_LENGTH, NoiseFilter};
use optical_bench::parameters::LaserParameters;

/// Most grid steps along a line; a longer line has longer steps.
const MAX_STEPS: f64 = 131_072.0;
/// Least width of the line over its mean width [1].
const MIN_WIDTH: f32 = 0.2;

/// The width over its mean, on an even grid along the line.
#[derive(Debug, Clone)]
pub(super) struct WidthJitter {
    /// First position of the grid [mm], and steps per mm [1/mm].
    start: f32,
    per_mm: f32,
    factor: Vec<f32>,
}

impl WidthJitter {
    /// Along a line that is 2 `half` long [mm]; `None` for an even one.
    pub fn new(bench: &LaserParameters, half: f64, stream: Stream) -> Option<Self> {
        if bench.width_jitter == 0.0 {
            return None;
        }
        // A little beyond the ends of the fan.
        let length = 2.4 * half;
        let step = (bench.width_jitter_mm / NODES_PER_LENGTH).max(length / MAX_STEPS);
        let filter = NoiseFilter::new(step, bench.width_jitter_mm);
        let count = (length / step).ceil() as usize + 2;
        let key = stream.key();
        let white: Vec<f64> = (0..count + 2 * filter.reach())
            .map(|i| f64::from(normals(i as u32, [key as u32, (key >> 32) as u32]).0))
            .collect();
        let factor =
            (0..count).map(|i| (1.0 + filter.filtered(bench.width_jitter, |k| white[i + k]) as f32).max(MIN_WIDTH));
        Some(Self { start: (-0.5 * length) as f32, per_mm: (1.0 / step) as f32, factor: factor.collect() })
    }

    /// The factor at a position along the line at the conveyor's height [1].
    #[inline]
    pub fn at(&self, mm: f32) -> f32 {
        let position = ((mm - self.start) * self.per_mm).clamp(0.0, (self.factor.len() - 2) as f32);
        let left = position as usize;
        self.factor[left] + (self.factor[left + 1] - self.factor[left]) * (position - left as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Spread and correlation along a line of 2500 correlation lengths, within 3.5 standard errors.
    #[test]
    fn width_varies_as_asked_for() {
        let mut bench = LaserParameters::from_values(&mut |p| p.default);
        (bench.width_jitter, bench.width_jitter_mm) = (0.05, 4.0);
        let jitter = WidthJitter::new(&bench, 5000.0, Stream::root(1)).expect("an uneven line");
        let at = |mm: f64| f64::from(jitter.at(mm as f32)) - 1.0;
        let positions = || (-5000..5000).map(f64::from);
        let mean_product = |lag: f64| positions().map(|mm| at(mm) * at(mm + lag)).sum::<f64>() / 1e4;
        let variance = mean_product(0.0);
        // The squared correlation's integral is sqrt(pi) 4 mm: about 1400 independent positions.
        let error = (2.0f64 / 1400.0).sqrt();
        assert!((variance / 0.0025 - 1.0).abs() < 3.5 * error, "variance {variance}");
        for lag in [2.0, 4.0, 8.0, 16.0] {
            let law = (-0.5 * (lag / 4.0f64).powi(2)).exp();
            assert!((mean_product(lag) / 0.0025 - law).abs() < 3.5 * error, "{lag} mm: {}", mean_product(lag));
        }
        bench.width_jitter = 0.0;
        assert!(WidthJitter::new(&bench, 5000.0, Stream::root(1)).is_none());
    }
}
