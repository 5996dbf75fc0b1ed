//! Part of the glare about one line: one round Gaussian of the halo.

use numerics::lanes::exp;

/// Glare about one line by one Gaussian, columns padded to whole tiles.
#[derive(Debug, Clone)]
pub(crate) struct GlarePart {
    /// Light [e-].
    pub light: Vec<f32>,
    /// Mean row that it comes from [px].
    pub row: Vec<f32>,
    /// Variance along the rows [px^2].
    pub variance: f32,
}

impl GlarePart {
    /// Light in a row of a column [e-].
    #[inline(always)]
    pub fn at(&self, column: usize, row: f32) -> f32 {
        let off = row - self.row[column];
        self.light[column] * 0.398_942_3 / self.variance.sqrt() * exp(-0.5 * off * off / self.variance)
    }
}
