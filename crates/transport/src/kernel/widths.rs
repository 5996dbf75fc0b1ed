//! Eight fixed widths, onto which the Gaussians of all media are put so that unlike media can be blended term by term.
//!
//! A Gaussian of any variance is written as a sum of the fixed ones by cubic Lagrange interpolation in
//! u = ln(variance + 0.05^2 mm^2), the laser's own width included. Weights sum to 1; single ones may be a little
//! negative, sums over the many paths of a medium are not. The widths were chosen by least squares so that rows 0 to 11
//! of the 15 media of docs/theory/physics.md come out like the sum of the Gaussians themselves: rows 1 to 8 within
//! 0.3 %, rows 7 to 11 within 0.7 %. Gaussians wider than the last one count as it does, with the height that they have
//! at their centre: what they send beyond is outside of every window.
//!
//! Packs have widths of their own ([`PACK_SPREAD_MM`]), up to 5 mm: light fills a pocket, and the line of the film and
//! that on foil 3 mm below stand 30 rows apart in it.

/// Number of fixed widths.
pub const BASIS: usize = 8;
/// Standard deviation of each fixed Gaussian along the motion, before laser and lens [mm].
pub const SPREAD_MM: [f32; BASIS] = [0.0, 0.054, 0.1, 0.205, 0.32, 0.535, 0.93, 1.84];

/// The same on packs, each at least as wide.
pub const PACK_SPREAD_MM: [f32; BASIS] = [0.0, 0.068, 0.132, 0.256, 0.461, 0.713, 1.264, 4.89];

/// Variance of the laser line for which the widths were chosen [mm^2].
const LINE_MM2: f64 = 0.05 * 0.05;
/// Rows of the table of shares, a power of two so that an index can be masked.
const TABLE_ROWS: usize = 512;

/// Shares of the fixed widths as a function of u.
#[derive(Debug, Clone)]
pub struct WidthShares {
    /// Standard deviations of the widths [mm].
    pub spread_mm: [f32; BASIS],
    rows: Box<[[f32; BASIS]; TABLE_ROWS]>,
    low: f32,
    per_step: f32,
}

impl WidthShares {
    /// The table for widths of these standard deviations [mm].
    pub fn new(spread_mm: [f32; BASIS]) -> Self {
        let nodes = spread_mm.map(|s| libm::log(f64::from(s) * f64::from(s) + LINE_MM2));
        let (low, high) = (nodes[0], nodes[BASIS - 1]);
        let steps = (TABLE_ROWS - 1) as f64;
        let row = |i: usize| cubic(&nodes, low + (high - low) * i as f64 / steps);
        Self {
            spread_mm,
            rows: Box::new(std::array::from_fn(row)),
            low: low as f32,
            per_step: (steps / (high - low)) as f32,
        }
    }

    /// Place in the table of a Gaussian with u = ln(variance + line).
    #[inline(always)]
    pub fn place(&self, u: f32) -> f32 {
        (u - self.low) * self.per_step + 0.5
    }

    /// Shares at the nearest place of the table.
    #[inline(always)]
    pub fn at(&self, place: f32) -> &[f32; BASIS] {
        &self.rows[place as usize % TABLE_ROWS]
    }
}

/// Variance of the laser line for which the widths were chosen [mm^2].
#[inline(always)]
pub(crate) fn line_mm2() -> f32 {
    LINE_MM2 as f32
}

/// Cubic Lagrange weights of `nodes` at `u`, from the two nodes on either side.
fn cubic(nodes: &[f64; BASIS], u: f64) -> [f32; BASIS] {
    let above = nodes.iter().position(|&node| node >= u).unwrap_or(BASIS - 1).max(1);
    let first = above.saturating_sub(2).min(BASIS - 4);
    let mut weights = [0.0; BASIS];
    for i in first..first + 4 {
        let others = (first..first + 4).filter(|&j| j != i);
        weights[i] = others.map(|j| (u - nodes[j]) / (nodes[i] - nodes[j])).product::<f64>() as f32;
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A single Gaussian, rows of 0.101 mm under the line: each row's share within 3 % of the centre's, and within 10 %
    /// between the two widest widths. The sum over a medium's paths is far nearer: tests/reference/table.rs.
    #[test]
    fn gaussians_are_sums_of_the_fixed_ones() {
        let shares = WidthShares::new(SPREAD_MM);
        let cell = |variance: f64, row: f64| {
            let z = |y: f64| libm::erf(y / (2.0 * (variance + LINE_MM2)).sqrt());
            0.5 * (z((row + 0.5) * 0.101) - z((row - 0.5) * 0.101))
        };
        for i in 0..60 {
            let sigma = 0.02 * libm::pow(1.8 / 0.02, f64::from(i) / 59.0);
            let weights = shares.at(shares.place(libm::log(sigma * sigma + LINE_MM2) as f32));
            let sum: f32 = weights.iter().sum();
            assert!((sum - 1.0).abs() < 1e-5, "weights of {sigma} sum to {sum}");
            for row in 0..12 {
                let truth = cell(sigma * sigma, f64::from(row));
                let model: f64 = weights
                    .iter()
                    .zip(SPREAD_MM)
                    .map(|(w, s)| f64::from(*w) * cell(f64::from(s * s), f64::from(row)))
                    .sum();
                let off = (model - truth).abs() / cell(sigma * sigma, 0.0);
                let bar = if sigma < 0.93 { 0.03 } else { 0.10 };
                assert!(off < bar, "sigma {sigma}, row {row}: {model} against {truth}, {off}");
            }
        }
    }
}
