//! Power spectral density of heights along rows and columns, by Welch's method.
//!
//! Welch (1967): segments of [`SEGMENT`] pixels that overlap by half, a straight line taken out of each, Hann window,
//! mean of the squared transforms. One-sided and scaled so that the area below the curve is the variance: white noise
//! of deviation s lies at 2 s^2 [um^2 per cycle/px], a sine of amplitude a adds an area of a^2 / 2. Segments with a
//! missing pixel or an edge are left out: one step of a millimetre would cover the noise of thousands of segments. The
//! line takes 28 % of the first frequency.

use std::f64::consts::TAU;
use std::sync::Arc;

use rustfft::num_complex::Complex64;
use rustfft::{Fft, FftPlannerScalar};

use super::ScanMaps;
use super::noise::{ScanDirection, SecondDifferences};

/// Pixels of a segment.
pub(crate) const SEGMENT: usize = 32;
/// Frequencies: 1 to 15 of [`SEGMENT`] cycles; the line that is taken out leaves nothing at 0.
pub(crate) const FREQUENCIES: usize = SEGMENT / 2 - 1;
/// Most segments of a frame; lines are left out evenly beyond that.
const MAX_SEGMENTS: usize = 20_000;

/// A point of a power spectrum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpectrumPoint {
    /// Frequency [cycles/px].
    pub frequency: f64,
    /// Power [um^2 or mpx^2, per cycle/px].
    pub power: f64,
}

/// Welch estimate: sum of the periodograms of segments.
#[derive(Clone)]
pub(crate) struct PowerSpectrum {
    transform: Arc<dyn Fft<f64>>,
    window: [f64; SEGMENT],
    power: [f64; FREQUENCIES],
    segments: u64,
}

impl Default for PowerSpectrum {
    fn default() -> Self {
        let window = std::array::from_fn(|i| 0.5 - 0.5 * libm::cos(TAU * i as f64 / SEGMENT as f64));
        let transform = FftPlannerScalar::new().plan_fft_forward(SEGMENT);
        Self { transform, window, power: [0.0; FREQUENCIES], segments: 0 }
    }
}

impl PowerSpectrum {
    /// Adds the lines of a frame in one direction, of which `second` holds the second differences.
    pub fn add(&mut self, frame: &ScanMaps, direction: ScanDirection, second: &SecondDifferences) {
        let (lines, length, start) = direction.lines(frame);
        let each = length / (SEGMENT / 2);
        let keep = (lines * each).div_ceil(MAX_SEGMENTS).max(1);
        for line in (0..lines).step_by(keep) {
            for from in (0..(length + 1).saturating_sub(SEGMENT)).step_by(SEGMENT / 2) {
                let at = |i: usize| line * start + (from + i) * direction.step(frame.cols);
                // A missing pixel leaves no second difference beside it.
                if (1..SEGMENT - 1).all(|i| second.is_noise(second.map[at(i)])) {
                    self.add_segment(&std::array::from_fn(|i| 1000.0 * frame.range[at(i)]));
                }
            }
        }
    }

    fn add_segment(&mut self, segment: &[f64; SEGMENT]) {
        let n = SEGMENT as f64;
        let mean = segment.iter().sum::<f64>() / n;
        let middle = (n - 1.0) / 2.0;
        let place = |i: usize| i as f64 - middle;
        let slope = segment.iter().enumerate().map(|(i, z)| place(i) * z).sum::<f64>() * 12.0 / (n * (n * n - 1.0));
        let mut line: Vec<Complex64> = segment
            .iter()
            .enumerate()
            .map(|(i, z)| Complex64::new((z - mean - slope * place(i)) * self.window[i], 0.0))
            .collect();
        self.transform.process(&mut line);
        let weight: f64 = self.window.iter().map(|w| w * w).sum();
        for (power, value) in self.power.iter_mut().zip(&line[1..]) {
            *power += 2.0 * value.norm_sqr() / weight;
        }
        self.segments += 1;
    }

    /// The estimate, by frequency; empty where no segment was whole.
    pub fn points(&self) -> Vec<SpectrumPoint> {
        if self.segments == 0 {
            return Vec::new();
        }
        let point = |(i, power): (usize, &f64)| SpectrumPoint {
            frequency: (i + 1) as f64 / SEGMENT as f64,
            power: power / self.segments as f64,
        };
        self.power.iter().enumerate().map(point).collect()
    }
}

#[cfg(test)]
mod tests {
    use base::{Stream, normal};

    use super::*;

    fn frame(cols: usize, rows: usize, mut height: impl FnMut(usize, usize) -> f64) -> ScanMaps {
        let range = (0..cols * rows).map(|i| height(i % cols, i / cols)).collect();
        ScanMaps { cols, rows, range, ..ScanMaps::default() }
    }

    fn points(frame: &ScanMaps, direction: ScanDirection) -> Vec<SpectrumPoint> {
        let mut spectrum = PowerSpectrum::default();
        spectrum.add(frame, direction, &SecondDifferences::new(frame, direction));
        spectrum.points()
    }

    /// White noise of deviation s is 2 s^2 everywhere, in both directions.
    #[test]
    fn white_noise_is_flat() {
        let mut rng = Stream::root(2).child("white").rng();
        let frame = frame(256, 256, |_, _| 0.01 * normal(&mut rng));
        for direction in ScanDirection::BOTH {
            for SpectrumPoint { frequency: f, power } in points(&frame, direction) {
                // 256 lines of 15 segments, 1 in 500 left out; those that overlap by half under a Hann window are alike
                // by 1/36, so a standard error of 1.03 / sqrt(3800); alpha 1e-4 for 30 numbers: 4.7. What the line
                // leaves of the first two frequencies is |(1 - line) window exp(i w n)|^2 / |window|^2.
                let left = [0.7187, 0.9944].get((f * SEGMENT as f64) as usize - 1).unwrap_or(&1.0);
                let error = 4.7 * 1.03 / 3800_f64.sqrt() + 1e-3;
                assert!((power / 200.0 / left - 1.0).abs() < error, "{direction:?} {f}: {power}");
            }
        }
    }

    /// A sine along the line has the area a^2 / 2 at its frequency, and none across, where it is constant.
    #[test]
    fn sines_stand_at_their_frequency() {
        let frame = frame(256, 64, |x, _| 0.02 * libm::sin(TAU / 4.0 * x as f64 + 0.5));
        let along = points(&frame, ScanDirection::Along);
        let area: f64 = along.iter().map(|point| point.power / SEGMENT as f64).sum();
        assert!((area / 200.0 - 1.0).abs() < 0.005, "{area}");
        let peak = along.iter().max_by(|a, b| a.power.total_cmp(&b.power)).expect("there are points");
        assert_eq!(peak.frequency, 0.25);
        assert!(points(&frame, ScanDirection::Across).iter().all(|point| point.power < 1e-6));
    }

    /// Slopes are no unevenness, and segments with a gap are left out.
    #[test]
    fn slopes_and_gaps_are_left_out() {
        let slope = frame(128, 64, |x, y| 0.25 * x as f64 - 0.5 * y as f64);
        assert!(
            ScanDirection::BOTH
                .iter()
                .all(|direction| points(&slope, *direction).iter().all(|point| point.power < 1e-6))
        );
        let gaps = frame(128, 64, |x, _| if x % 30 == 0 { f64::NAN } else { 0.0 });
        assert!(points(&gaps, ScanDirection::Along).is_empty());
    }
}
