//! Projected texture: a picture in place of the laser line, as in Kihl and Källberg 2021, section 3.2.1.
//!
//! Rows of the image lie across the line, columns along it. The preset is theirs: a line three pixels wide, blurred by
//! a Gaussian with a radius of five pixels, which is taken as the standard deviation. They do not give the size of its
//! pixels; the extents are keys of the recipe. A picture's grey is proportional to light. Neglected: that a projector's
//! picture is sharp at one distance only.

use optical_bench::settings::TextureImage;

/// Rows of the preset of the thesis [px].
const PROJECTOR_ROWS: usize = 61;
/// Width of its line across [px].
const PROJECTOR_LINE_ROWS: f64 = 3.0;
/// Standard deviation of its blur [px].
const PROJECTOR_BLUR_ROWS: f64 = 5.0;

/// Light of a picture, `[rows, columns]`, row-major.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct LineTexture {
    pub rows: usize,
    pub columns: usize,
    light: Vec<f64>,
}

impl LineTexture {
    /// The line of the thesis, uniform along its length.
    pub(crate) fn thesis_projector() -> Self {
        let per = std::f64::consts::FRAC_1_SQRT_2 / PROJECTOR_BLUR_ROWS;
        let row = |i: usize| {
            let d = i as f64 - 0.5 * (PROJECTOR_ROWS as f64 - 1.0);
            libm::erf((d + 0.5 * PROJECTOR_LINE_ROWS) * per) - libm::erf((d - 0.5 * PROJECTOR_LINE_ROWS) * per)
        };
        Self { rows: PROJECTOR_ROWS, columns: 1, light: (0..PROJECTOR_ROWS).map(row).collect() }
    }

    /// The texture of a picture.
    pub fn new(picture: &TextureImage) -> Self {
        let light = picture.light.iter().map(|&light| f64::from(light)).collect();
        Self { rows: picture.rows, columns: picture.columns, light }
    }

    /// Sum of the column at `position`, 0 at the first column's edge and 1 at the last one's; linear between columns.
    pub(crate) fn column_sum(&self, position: f64) -> f64 {
        (0..self.rows).map(|row| self.at(row, position)).sum()
    }

    /// Mean and variance of the light between two heights of the picture, summed over all columns; `None` where it is
    /// dark [rows, rows^2].
    pub fn moments(&self, low: f64, high: f64) -> Option<[f64; 2]> {
        let mut sums = [0.0; 3];
        for (row, light) in self.light.chunks_exact(self.columns).enumerate() {
            let (start, end) = (low.max(row as f64), high.min(row as f64 + 1.0));
            if end > start {
                let (light, part) = (light.iter().sum::<f64>(), end - start);
                let middle = 0.5 * (start + end);
                sums[0] += light * part;
                sums[1] += light * part * middle;
                sums[2] += light * part * (middle * middle + part * part / 12.0);
            }
        }
        let mean = sums[1] / sums[0];
        (sums[0] > 0.0).then(|| [mean, (sums[2] / sums[0] - mean * mean).max(0.0)])
    }

    /// Light of a row at `position` along the line.
    pub fn at(&self, row: usize, position: f64) -> f64 {
        let column = (position * self.columns as f64 - 0.5).clamp(0.0, (self.columns - 1) as f64);
        let (left, part) = (column as usize, column - column.floor());
        let right = (left + 1).min(self.columns - 1);
        let at = |column: usize| self.light[row * self.columns + column];
        at(left) + (at(right) - at(left)) * part
    }
}
