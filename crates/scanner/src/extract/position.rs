//! Subpixel position of the line between the rows of the sensor.
//!
//! Model: the distance d of the line from the peak's row [px], from the light I less the dark level about it:
//!
//! ```text
//! centre of gravity  d = sum d I / sum I                                     over the window
//! parabola           d = (I- - I+) / (2 (I- - 2 I0 + I+))                    vertex through three rows
//! gaussian           the same of ln I                                        exact for a Gaussian without boxes
//! Blais-Rioux, 2 K   g = sum over k = 1 .. K of I(i + k) - I(i - k)          zero of g, linear between rows
//! fir, L             g = s(i + 1) - s(i - 1), s = I smoothed by L binomials  zero of g, linear between rows
//! ```
//!
//! Sources: Blais and Rioux 1986 (real-time peak detector); Naidu and Fisher 1991 (comparison of the five); the thesis
//! uses the centre of gravity. The zero is the crossing from light that rises to light that falls nearest to the peak,
//! searched in the window; over a stretch of zeros, as a saturated plateau has it, its middle.
//!
//! A saturated plateau has its peak at its first row. The centre of gravity about that row loses light on the far side
//! once the window ends there. Parabola and Gaussian see two equal rows and say half a row behind the first, wherever
//! the middle is; a zero of the derivative finds the middle as long as the window reaches it.
//!
//! Neglected: interpolation of higher order, weights by noise.
//!
//! A new method is a variant of `PeakMethod` and its word in `optical_bench/src/settings/extraction.rs`, its arm here,
//! its keys in `recipe/src/keys/settings.rs`, and a row with bias and spread in docs/theory/instrument/extraction.md.

use super::block::{ColumnBlock, LANES};
use super::scatter::{row_span, side_weights, weighted_level};
use optical_bench::settings::{Extraction, PeakMethod};

/// Least level over dark of which a logarithm is taken [DN].
const MIN_LOG_LEVEL_DN: f32 = 0.5;

/// Centre of gravity less the peak [px], NaN where there is none, and Scatter [DN], in one pass.
#[inline(always)]
pub(super) fn centre_of_gravity(
    block: ColumnBlock<'_>,
    at: &[u16; LANES],
    dark: f32,
    settings: &Extraction,
) -> ([f32; LANES], [f32; LANES]) {
    let window = settings.window_rows as i32;
    let (side_weights, row_span) = (side_weights(settings.scatter_mode), row_span(settings));
    let (mut sum, mut moment, mut scatter) = ([0.0f32; LANES], [0.0f32; LANES], [0.0f32; LANES]);
    for k in 0..block.frame.rows {
        let dn = block.row(k);
        for c in 0..LANES {
            let d = k as i32 - i32::from(at[c]);
            let level = f32::from(dn[c]);
            let inside = if d.abs() <= window { level - dark } else { 0.0 };
            sum[c] += inside;
            moment[c] += inside * d as f32;
            scatter[c] += weighted_level(d, level, row_span, side_weights);
        }
    }
    let mut shift = [f32::NAN; LANES];
    for c in 0..LANES {
        // What lies outside of its own window is noise over noise.
        let found = sum[c] > 0.0 && moment[c].abs() <= window as f32 * sum[c];
        shift[c] = if found { moment[c] / sum[c] } else { f32::NAN };
    }
    (shift, scatter)
}

/// Position of the line less the peak by any other method [px]; NaN where there is none.
#[inline(always)]
pub(super) fn by_neighbouring_rows(
    block: ColumnBlock<'_>,
    at: &[u16; LANES],
    dark: f32,
    method: PeakMethod,
    window: usize,
) -> [f32; LANES] {
    let ColumnBlock { frame, first, columns } = block;
    let mut shift = [f32::NAN; LANES];
    for c in 0..columns {
        // What lies outside of the frame counts as dark.
        let light = |d: i32| {
            let k = i32::from(at[c]) + d;
            let inside = (0..frame.rows as i32).contains(&k);
            if inside { f32::from(frame.dn[k as usize * frame.cols + first + c]) - dark } else { 0.0 }
        };
        shift[c] = match method {
            PeakMethod::Parabola => parabola_vertex([-1, 0, 1].map(light)),
            PeakMethod::Gaussian => parabola_vertex([-1, 0, 1].map(|d| libm::logf(light(d).max(MIN_LOG_LEVEL_DN)))),
            PeakMethod::BlaisRioux { order } => {
                let half = order as i32 / 2;
                zero_crossing(window, |i| (1..=half).map(|k| light(i + k) - light(i - k)).sum())
            }
            PeakMethod::Fir { length } => {
                let smooth = BinomialFilter::new(length);
                zero_crossing(window, |i| smooth.at(i + 1, light) - smooth.at(i - 1, light))
            }
            // Done by [`centre_of_gravity`].
            PeakMethod::CentreOfGravity => f32::NAN,
        };
    }
    shift
}

/// Vertex of the parabola through three numbers one apart, the middle one the greatest.
fn parabola_vertex([before, at, behind]: [f32; 3]) -> f32 {
    let bend = before - 2.0 * at + behind;
    if bend < 0.0 { (0.5 * (before - behind) / bend).clamp(-0.5, 0.5) } else { f32::NAN }
}

/// The position nearest to 0 where `slope` passes from above to below 0, within `window` on either side.
fn zero_crossing(window: usize, slope: impl Fn(i32) -> f32) -> f32 {
    let reach = window as i32;
    // Up to the last row on the rising side: from there to the first on the falling side it crosses.
    let rising = |i: i32| slope(i) > 0.0;
    let start = if rising(0) { (0..reach).find(|&i| !rising(i + 1)) } else { (-reach..0).rev().find(|&i| rising(i)) };
    let Some(before) = start else { return f32::NAN };
    let Some(behind) = (before + 1..=reach + 1).find(|&i| slope(i) < 0.0) else { return f32::NAN };
    if behind > before + 1 {
        // A stretch of zeros between the two.
        return 0.5 * (before + behind) as f32;
    }
    let (high, low) = (slope(before), slope(behind));
    before as f32 + high / (high - low)
}

/// Binomial smoothing filter.
struct BinomialFilter {
    weights: [f32; 9],
    half: i32,
}

impl BinomialFilter {
    /// Weights of a row of Pascal's triangle; `length` is odd and at most 9.
    fn new(length: usize) -> Self {
        let mut weights = [0.0f32; 9];
        weights[0] = 1.0;
        for n in 1..length.min(9) {
            for k in (1..=n).rev() {
                weights[k] += weights[k - 1];
            }
        }
        Self { weights, half: length.min(9) as i32 / 2 }
    }

    fn at(&self, i: i32, light: impl Fn(i32) -> f32) -> f32 {
        (-self.half..=self.half).map(|k| self.weights[(k + self.half) as usize] * light(i + k)).sum()
    }
}
