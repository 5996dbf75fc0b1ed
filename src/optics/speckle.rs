//! Speckle as a pattern that lies on the object.
//!
//! Generation: the squared magnitude of the Fourier transform of a disc of random phases (Duncan and Kirkpatrick 2008;
//! Bergmann 2016), which has exponential statistics and the Airy autocorrelation of a round lens of working f-number
//! N (1 + m): grain L = lambda N (1 + m). The pattern is integrated over pixels (boxes) at every fine row, so that a
//! pixel can start anywhere along the motion. The pattern moves with the object's image: m step cos(tilt) / cos(beta)
//! a profile. Contrast after integration follows Goodman, C = M^-1/2 with
//! M = [4 / a^2 int int (1 - x/a)(1 - y/a) |mu|^2]^-1. Neglected: boiling while the object moves through the beam
//! (1 to 2 % a profile, physics of a translating diffuser), and a pattern repeats after [`TILE`] pixels along the line
//! under another offset.

use std::collections::HashMap;
use std::f64::consts::{PI, TAU};
use std::sync::{Arc, Mutex, PoisonError};

use procedural::Stream;
use procedural::stream::mix;
use rand::RngExt;
use rustfft::FftPlannerScalar;
use rustfft::num_complex::Complex32;

/// Pixels along the line after which a pattern repeats.
pub const TILE: usize = 128;
/// Fine rows of the pattern in a pixel, and fine columns before integration.
pub const FINE: usize = 6;
/// Side of the square of random phases.
const SIDE: usize = TILE * FINE;
/// Patterns averaged for light that comes from below: enough for the near-normal law of many modes.
const VOLUME_PATTERNS: usize = 4;
/// Step of the grain's size between tiles that are kept, as a ratio.
const GRAIN_STEP: f64 = 1.03;

/// Pixel values of a pattern less their mean over their standard deviation, `[SIDE fine rows, TILE columns]`.
#[derive(Debug)]
pub struct Tile(Vec<f32>);

/// Patterns made so far: one pair (surface, volume) a grain size. Values depend on the key alone, not on who asked.
#[derive(Debug)]
pub struct Tiles {
    stream: Stream,
    made: Mutex<HashMap<i32, Arc<[Tile; 2]>>>,
}

impl Tiles {
    /// No patterns yet.
    pub fn new(seed: u64) -> Self {
        Self { stream: Stream::root(seed).child("speckle"), made: Mutex::new(HashMap::new()) }
    }

    /// The patterns for speckles of `grain` pixels: surface and volume.
    pub fn get(&self, grain: f64) -> Arc<[Tile; 2]> {
        let key = (libm::log(grain) / libm::log(GRAIN_STEP)).round() as i32;
        let mut made = self.made.lock().unwrap_or_else(PoisonError::into_inner);
        let tile = |patterns: usize, stream: Stream| Tile::new(GRAIN_STEP.powi(key), patterns, stream);
        made.entry(key)
            .or_insert_with(|| {
                Arc::new([tile(1, self.stream.child("surface")), tile(VOLUME_PATTERNS, self.stream.child("volume"))])
            })
            .clone()
    }
}

impl Tile {
    fn new(grain: f64, patterns: usize, stream: Stream) -> Self {
        let mut mean = vec![0.0f32; SIDE * SIDE];
        for pattern in 0..patterns {
            for (sum, value) in mean.iter_mut().zip(intensity(grain * FINE as f64, stream.index(pattern as u64))) {
                *sum += value;
            }
        }
        let mut boxes = vec![0.0f32; SIDE * TILE];
        let mut columns = vec![0.0f32; SIDE * TILE];
        for row in 0..SIDE {
            for column in 0..TILE {
                columns[row * TILE + column] = mean[row * SIDE + column * FINE..][..FINE].iter().sum();
            }
        }
        for row in 0..SIDE {
            for part in 0..FINE {
                let from = (row + part) % SIDE * TILE;
                for column in 0..TILE {
                    boxes[row * TILE + column] += columns[from + column];
                }
            }
        }
        let n = boxes.len() as f64;
        let centre = boxes.iter().map(|&v| f64::from(v)).sum::<f64>() / n;
        let spread = (boxes.iter().map(|&v| (f64::from(v) - centre).powi(2)).sum::<f64>() / n).sqrt();
        Self(boxes.iter().map(|&v| ((f64::from(v) - centre) / spread) as f32).collect())
    }

    /// Fine row `row` (any whole number) of the pattern, one value a pixel.
    #[inline(always)]
    pub fn row(&self, row: i64) -> &[f32; TILE] {
        let start = row.rem_euclid(SIDE as i64) as usize * TILE;
        self.0[start..start + TILE].try_into().expect("a row of the tile has TILE columns")
    }
}

/// Fully developed speckle of mean 1, grain L of `grain` fine pixels (at least 2: the intensity's Nyquist limit).
fn intensity(grain: f64, stream: Stream) -> Vec<f32> {
    let diameter = SIDE as f64 / grain.max(2.0);
    let mut rng = stream.rng();
    let mut field = vec![Complex32::default(); SIDE * SIDE];
    let centre = 0.5 * SIDE as f64;
    for row in 0..SIDE {
        for column in 0..SIDE {
            let phase = rng.random::<f64>() * TAU;
            if libm::hypot(row as f64 - centre, column as f64 - centre) <= 0.5 * diameter {
                let (sin, cos) = libm::sincos(phase);
                field[row * SIDE + column] = Complex32::new(cos as f32, sin as f32);
            }
        }
    }
    // The other planners pick instructions by the CPU, and with them the last bits.
    let transform = FftPlannerScalar::new().plan_fft_forward(SIDE);
    for _ in 0..2 {
        transform.process(&mut field);
        // Transpose in place: the second pass transforms the columns.
        for row in 0..SIDE {
            for column in row + 1..SIDE {
                field.swap(row * SIDE + column, column * SIDE + row);
            }
        }
    }
    let mean = field.iter().map(|v| f64::from(v.norm_sqr())).sum::<f64>() / field.len() as f64;
    field.iter().map(|v| (f64::from(v.norm_sqr()) / mean) as f32).collect()
}

/// Contrast of fully developed speckle of `grain` pixels in square pixels (Goodman) [1].
pub fn pixel_contrast(grain: f64) -> f64 {
    const STEPS: usize = 400;
    let mut sum = 0.0;
    for i in 0..STEPS {
        for j in 0..STEPS {
            let (x, y) = ((i as f64 + 0.5) / STEPS as f64, (j as f64 + 0.5) / STEPS as f64);
            let r = PI * libm::hypot(x, y) / grain;
            let airy = 2.0 * libm::j1(r) / r;
            sum += (1.0 - x) * (1.0 - y) * airy * airy;
        }
    }
    (4.0 * sum / (STEPS * STEPS) as f64).sqrt()
}

/// Where a column tile reads its pattern: another offset for each tile and each time around.
#[inline(always)]
pub fn offset(key: u64, tile: usize, turn: i64) -> i64 {
    (mix(key ^ mix((tile as u64) << 32 ^ turn as u64)) % SIDE as u64) as i64
}

/// Fine rows after which the pattern is entered at another offset.
pub const TURN: i64 = SIDE as i64;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contrast_matches_goodman() {
        // Pixel 6 um, grain 1.968 um: C = 0.3115; 3.45 um: 0.487 (docs/instrument.md).
        assert!((pixel_contrast(1.968 / 6.0) - 0.3115).abs() < 1e-3, "{}", pixel_contrast(1.968 / 6.0));
        assert!((pixel_contrast(1.968 / 3.45) - 0.487).abs() < 1e-3);
    }

    #[test]
    fn field_is_exponential_with_airy_correlation() {
        let grain = 4.0;
        let field = intensity(grain, Stream::root(1));
        let n = field.len() as f64;
        let mean = field.iter().map(|&v| f64::from(v)).sum::<f64>() / n;
        let variance = field.iter().map(|&v| (f64::from(v) - 1.0).powi(2)).sum::<f64>() / n;
        assert!((mean - 1.0).abs() < 1e-6);
        // Grains are (4 / pi) L^2 pixels: so many independent values; contrast 1 within three standard errors of 2 / sqrt.
        let cells = n / (1.273 * grain * grain);
        assert!((variance - 1.0).abs() < 3.0 * (8.0 / cells).sqrt(), "variance {variance}");
        for lag in 1..8usize {
            let covariance = (0..SIDE)
                .map(|row| {
                    let line = &field[row * SIDE..][..SIDE];
                    (0..SIDE).map(|c| f64::from(line[c] - 1.0) * f64::from(line[(c + lag) % SIDE] - 1.0)).sum::<f64>()
                })
                .sum::<f64>()
                / n;
            let r = PI * lag as f64 / grain;
            let theory = (2.0 * libm::j1(r) / r).powi(2);
            assert!((covariance / variance - theory).abs() < 4.0 / cells.sqrt(), "lag {lag}: {covariance} {theory}");
        }
    }

    #[test]
    fn pixels_have_goodmans_contrast_before_scaling() {
        let grain = 1.968 / 6.0;
        let field = intensity(grain * FINE as f64, Stream::root(5));
        let mut sums = Vec::new();
        for row in (0..SIDE).step_by(FINE) {
            for column in (0..SIDE).step_by(FINE) {
                let sum: f64 =
                    (0..FINE * FINE).map(|i| f64::from(field[(row + i / FINE) * SIDE + column + i % FINE])).sum();
                sums.push(sum / (FINE * FINE) as f64);
            }
        }
        let variance = sums.iter().map(|v| (v - 1.0).powi(2)).sum::<f64>() / sums.len() as f64;
        let contrast = variance.sqrt();
        // 16384 pixels: standard error of the contrast about 0.6 %, and the pattern's own grain is clamped at 2 px of 1.97.
        assert!((contrast / pixel_contrast(2.0 / FINE as f64) - 1.0).abs() < 0.025, "contrast {contrast}");
    }
}
