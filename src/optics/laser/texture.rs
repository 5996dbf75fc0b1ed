//! A picture thrown on the object as a projector does: what a line laser is in Kihl and Källberg 2021, section 3.2.1.
//!
//! Rows of the image lie across the line, columns along it. The preset is theirs: a line three pixels wide, blurred by a
//! Gaussian with a radius of five pixels, which is taken as the standard deviation. How large its pixels were is not told
//! there; the extents are keys of the recipe. A picture's grey is proportional to light. Neglected: that a projector's
//! picture is sharp at one distance only.

use crate::settings::Picture;

/// Rows of the preset [px].
const ROWS: usize = 61;
/// Width of its line and standard deviation of its blur [px].
const LINE: f64 = 3.0;
const BLUR: f64 = 5.0;

/// Light of a picture, `[rows, columns]`, row-major.
#[derive(Debug, Clone, PartialEq)]
pub struct Texture {
    rows: usize,
    columns: usize,
    light: Vec<f64>,
}

impl Texture {
    /// The line of the thesis, as even along as can be.
    pub fn thesis_projector() -> Self {
        let per = std::f64::consts::FRAC_1_SQRT_2 / BLUR;
        let row = |i: usize| {
            let d = i as f64 - 0.5 * (ROWS as f64 - 1.0);
            libm::erf((d + 0.5 * LINE) * per) - libm::erf((d - 0.5 * LINE) * per)
        };
        Self { rows: ROWS, columns: 1, light: (0..ROWS).map(row).collect() }
    }

    /// What a picture shows.
    pub fn new(picture: &Picture) -> Self {
        let light = picture.light.iter().map(|&light| f64::from(light)).collect();
        Self { rows: picture.rows, columns: picture.columns, light }
    }

    /// Light of the column at `place`, 0 at the first column's edge and 1 at the last one's; linear between columns.
    pub fn along(&self, place: f64) -> f64 {
        (0..self.rows).map(|row| self.at(row, place)).sum()
    }

    /// Middle and variance across the line of a picture that is `width` wide, in units of `width` and its square.
    pub fn moments(&self, width: f64) -> [f64; 2] {
        let sums = self.light.chunks_exact(self.columns).enumerate().fold([0.0; 3], |sums, (row, light)| {
            let (place, light) = (0.5 - (row as f64 + 0.5) / self.rows as f64, light.iter().sum::<f64>());
            [sums[0] + light, sums[1] + light * place, sums[2] + light * place * place]
        });
        let mean = sums[1] / sums[0];
        let variance = sums[2] / sums[0] - mean * mean + 1.0 / (12.0 * (self.rows * self.rows) as f64);
        [mean * width, variance * width * width]
    }

    /// Rows of the picture.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Columns of the picture.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Light of a row at `place` along the line.
    pub fn at(&self, row: usize, place: f64) -> f64 {
        let column = (place * self.columns as f64 - 0.5).clamp(0.0, (self.columns - 1) as f64);
        let (left, part) = (column as usize, column - column.floor());
        let right = (left + 1).min(self.columns - 1);
        let at = |column: usize| self.light[row * self.columns + column];
        at(left) + (at(right) - at(left)) * part
    }
}
