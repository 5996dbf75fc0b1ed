//! Scatter: light beside the peak, summed as the camera sums it.
//!
//! Model: the plain sum of digital numbers over rows `offset ..= offset + width - 1` from the peak, on both sides, on
//! the side of smaller row numbers (front) or of greater ones (back); offset 0 includes the peak, once. The dark level
//! stays in it unless the recipe takes it out. The camera's window has 31 rows, of which at most 29 are summed, so that
//! sums of 8 bits fit in 16; sums of more bits end at 65535, as 16-bit output does.

use super::block::{ColumnBlock, LANES};
use optical_bench::settings::{Extraction, ScatterDark, ScatterMode};

/// Largest number of 16-bit output [DN].
const MAX_OUTPUT_DN: f32 = 65535.0;

/// Number of pixels that Scatter scatter_sums.
pub fn scatter_pixels(settings: &Extraction) -> usize {
    let side = settings.scatter_width_rows;
    match settings.scatter_mode {
        ScatterMode::Symmetric if settings.scatter_offset_rows == 0 => 2 * side - 1,
        ScatterMode::Symmetric => 2 * side,
        ScatterMode::Front | ScatterMode::Back => side,
    }
}

/// Sum of the dark level over the rows that Scatter sums; one of the two is 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DarkSum {
    /// What stays in Scatter [DN].
    pub kept: f32,
    /// What is subtracted from it [DN].
    pub subtracted: f32,
}

/// What becomes of the dark level `dark` [DN] in Scatter.
pub fn scatter_dark(settings: &Extraction, dark: f32) -> DarkSum {
    let all = scatter_pixels(settings) as f32 * dark;
    match settings.scatter_dark {
        ScatterDark::Kept => DarkSum { kept: all, subtracted: 0.0 },
        ScatterDark::Subtracted => DarkSum { kept: 0.0, subtracted: all },
    }
}

/// A sum as it is written [DN].
#[inline(always)]
pub(super) fn as_written(sum: f32, dark: DarkSum) -> f32 {
    (sum - dark.subtracted).clamp(0.0, MAX_OUTPUT_DN)
}

/// Weight of a row before the peak, and of one behind it.
#[inline(always)]
pub(super) fn side_weights(mode: ScatterMode) -> [f32; 2] {
    match mode {
        ScatterMode::Symmetric => [1.0, 1.0],
        ScatterMode::Front => [1.0, 0.0],
        ScatterMode::Back => [0.0, 1.0],
    }
}

/// Contribution of a row `d` from the peak to the sum [DN].
#[inline(always)]
pub(super) fn weighted_level(d: i32, level: f32, [near, end]: [i32; 2], [front, back]: [f32; 2]) -> f32 {
    let side = if d < 0 {
        front
    } else if d > 0 {
        back
    } else {
        1.0
    };
    let aside = d.abs();
    if aside >= near && aside < end { level * side } else { 0.0 }
}

/// Distance from the peak of the first row that is summed, and of the first beyond [px].
#[inline(always)]
pub(super) fn row_span(settings: &Extraction) -> [i32; 2] {
    [settings.scatter_offset_rows, settings.scatter_offset_rows + settings.scatter_width_rows].map(|rows| rows as i32)
}

/// Sums around the peaks `at` [DN].
#[inline(always)]
pub(super) fn scatter_sums(block: ColumnBlock<'_>, at: &[u16; LANES], settings: &Extraction) -> [f32; LANES] {
    let (side_weights, row_span) = (side_weights(settings.scatter_mode), row_span(settings));
    let mut sums = [0.0f32; LANES];
    for k in 0..block.frame.rows {
        let dn = block.row(k);
        for c in 0..LANES {
            sums[c] += weighted_level(k as i32 - i32::from(at[c]), f32::from(dn[c]), row_span, side_weights);
        }
    }
    sums
}
