//! Uneven width along the line: a factor 1 + n(x), n normal with a standard deviation and a correlation length.
//!
//! White normals on a grid along the line are drawn through a Gaussian, which gives the correlation exp(-d^2 / (2 l^2)),
//! l at the conveyor's height. The laser's, not the object's: it stays while the object moves. An engineering model of lenses
//! that are not quite even. Neglected: that width changes over height by itself.

use procedural::Stream;

use crate::lanes::normals;
use crate::optics::parameters::Laser;

/// Steps in a correlation length.
const FINE: f64 = 8.0;
/// Most steps along a line; a longer one has longer steps.
const MOST: f64 = 131_072.0;
/// Correlation lengths after which the Gaussian is left out.
const REACH: f64 = 3.5;
/// Narrowest line, over its mean width [1].
const LEAST: f32 = 0.2;

/// The factor at even steps along the line.
#[derive(Debug, Clone)]
pub(super) struct Jitter {
    /// Where it starts [mm] and steps in a mm.
    start: f32,
    per_mm: f32,
    factor: Vec<f32>,
}

impl Jitter {
    /// Along a line that is 2 `half` long [mm]; `None` for an even one.
    pub fn new(bench: &Laser, half: f64, stream: Stream) -> Option<Self> {
        if bench.width_jitter == 0.0 {
            return None;
        }
        // A little beyond the ends of the fan.
        let length = 2.4 * half;
        let step = (bench.width_jitter_mm / FINE).max(length / MOST);
        let reach = (REACH * bench.width_jitter_mm / step).ceil() as usize;
        let tap = |i: usize| {
            let d = i as f64 * step / bench.width_jitter_mm;
            libm::exp(-d * d)
        };
        let half_taps: Vec<f64> = (0..=reach).map(tap).collect();
        let norm = (half_taps.iter().map(|t| t * t).sum::<f64>() * 2.0 - 1.0).sqrt();
        let count = (length / step).ceil() as usize + 2;
        let key = stream.key();
        let white: Vec<f64> =
            (0..count + 2 * reach).map(|i| f64::from(normals(i as u32, [key as u32, (key >> 32) as u32]).0)).collect();
        let factor = (0..count).map(|i| {
            let sum: f64 = (0..=2 * reach).map(|k| half_taps[k.abs_diff(reach)] * white[i + k]).sum();
            (1.0 + (bench.width_jitter * sum / norm) as f32).max(LEAST)
        });
        Some(Self { start: (-0.5 * length) as f32, per_mm: (1.0 / step) as f32, factor: factor.collect() })
    }

    /// The factor at a place along the line at the conveyor's height [1].
    #[inline]
    pub fn at(&self, mm: f32) -> f32 {
        let place = ((mm - self.start) * self.per_mm).clamp(0.0, (self.factor.len() - 2) as f32);
        let left = place as usize;
        self.factor[left] + (self.factor[left + 1] - self.factor[left]) * (place - left as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Spread and correlation along a line of 2500 correlation lengths, within 3.5 standard errors.
    #[test]
    fn width_varies_as_asked_for() {
        let mut bench = Laser::from_values(&mut |p| p.default);
        (bench.width_jitter, bench.width_jitter_mm) = (0.05, 4.0);
        let jitter = Jitter::new(&bench, 5000.0, Stream::root(1)).expect("an uneven line");
        let at = |mm: f64| f64::from(jitter.at(mm as f32)) - 1.0;
        let places = || (-5000..5000).map(f64::from);
        let mean_product = |lag: f64| places().map(|mm| at(mm) * at(mm + lag)).sum::<f64>() / 1e4;
        let variance = mean_product(0.0);
        // The squared correlation's integral is sqrt(pi) 4 mm: about 1400 independent places.
        let error = (2.0f64 / 1400.0).sqrt();
        assert!((variance / 0.0025 - 1.0).abs() < 3.5 * error, "variance {variance}");
        for lag in [2.0, 4.0, 8.0, 16.0] {
            let law = (-0.5 * (lag / 4.0f64).powi(2)).exp();
            assert!((mean_product(lag) / 0.0025 - law).abs() < 3.5 * error, "{lag} mm: {}", mean_product(lag));
        }
        bench.width_jitter = 0.0;
        assert!(Jitter::new(&bench, 5000.0, Stream::root(1)).is_none());
    }
}
