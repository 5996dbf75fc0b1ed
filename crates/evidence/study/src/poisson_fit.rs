//! Quasi-Poisson regression of counts: y ~ exp(sum of b_k x_k), the variance of y proportional to its mean (log link).
//!
//! Sparse counts are no trouble, since no logarithm of a count is taken. Solved by iteratively reweighted least squares
//! (Nelder and Wedderburn 1972). Observations may count less than whole: with such shares u and W = u mean, covariance
//! of b = dispersion (X^T W X)^-1 (X^T u W X) (X^T W X)^-1, dispersion from Pearson's residuals.

/// Terms of the model.
pub(super) const TERMS: usize = 9;

/// One observation.
#[derive(Debug, Clone, Copy)]
pub(super) struct Observation {
    /// Terms of the model.
    pub x: [f64; TERMS],
    /// What was counted.
    pub y: f64,
    /// How much it counts, in (0, 1].
    pub share: f64,
}

type Matrix = [[f64; TERMS]; TERMS];

/// Coefficients and their standard errors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PoissonFit {
    /// Coefficients.
    pub b: [f64; TERMS],
    /// Standard errors.
    pub error: [f64; TERMS],
}

/// Fits `rows` from a start; `None` where they do not determine the terms.
pub(super) fn fit(rows: &[Observation], start: [f64; TERMS]) -> Option<PoissonFit> {
    const MAX_ROUNDS: usize = 50;
    let mut b = start;
    for _ in 0..MAX_ROUNDS {
        let (matrix, right) = normal_equations(rows, &b);
        let next = Cholesky::of(&matrix)?.solve(right);
        let step = (0..TERMS).map(|k| (next[k] - b[k]).abs()).fold(0.0, f64::max);
        b = next;
        if !step.is_finite() {
            return None;
        }
        if step < 1e-10 {
            break;
        }
    }
    let root = Cholesky::of(&normal_equations(rows, &b).0)?;
    let spread = moments(rows, |row| row.share * row.share * mean(&row.x, &b));
    let pearson = |row: &Observation| {
        let m = mean(&row.x, &b);
        row.share * (row.y - m).powi(2) / m
    };
    let shares: f64 = rows.iter().map(|row| row.share).sum();
    let spare = shares * (1.0 - TERMS as f64 / rows.len() as f64);
    let dispersion = rows.iter().map(pearson).sum::<f64>() / spare.max(1e-9);
    let error = std::array::from_fn(|k| {
        let mut unit = [0.0; TERMS];
        unit[k] = 1.0;
        let c = root.solve(unit);
        let variance: f64 = (0..TERMS).map(|i| (0..TERMS).map(|j| c[i] * spread[i][j] * c[j]).sum::<f64>()).sum();
        (dispersion * variance).sqrt()
    });
    Some(PoissonFit { b, error })
}

fn mean(x: &[f64; TERMS], b: &[f64; TERMS]) -> f64 {
    // Far from the data's scale a step may overshoot; the next ones come back.
    libm::exp((0..TERMS).map(|k| x[k] * b[k]).sum::<f64>().clamp(-300.0, 300.0))
}

/// Sum of weight x x^T over all rows.
fn moments(rows: &[Observation], weight: impl Fn(&Observation) -> f64) -> Matrix {
    let mut matrix = [[0.0; TERMS]; TERMS];
    for row in rows {
        let w = weight(row);
        for i in 0..TERMS {
            for j in 0..TERMS {
                matrix[i][j] += row.x[i] * w * row.x[j];
            }
        }
    }
    matrix
}

/// X^T W X and X^T W z of one round.
fn normal_equations(rows: &[Observation], b: &[f64; TERMS]) -> (Matrix, [f64; TERMS]) {
    let mut right = [0.0; TERMS];
    for Observation { x, y, share } in rows {
        let m = mean(x, b);
        let z = (0..TERMS).map(|k| x[k] * b[k]).sum::<f64>() + (y - m) / m;
        for i in 0..TERMS {
            right[i] += share * x[i] * m * z;
        }
    }
    (moments(rows, |row| row.share * mean(&row.x, b)), right)
}

/// Lower triangle of a positive matrix's root.
struct Cholesky(Matrix);

impl Cholesky {
    /// `None` where the matrix is not positive.
    fn of(matrix: &Matrix) -> Option<Self> {
        let mut root = [[0.0; TERMS]; TERMS];
        for i in 0..TERMS {
            for j in 0..=i {
                let sum: f64 = matrix[i][j] - (0..j).map(|k| root[i][k] * root[j][k]).sum::<f64>();
                root[i][j] = if i == j {
                    if sum.is_nan() || sum <= 1e-12 * matrix[i][i] {
                        return None;
                    }
                    sum.sqrt()
                } else {
                    sum / root[j][j]
                };
            }
        }
        Some(Self(root))
    }

    fn solve(&self, mut right: [f64; TERMS]) -> [f64; TERMS] {
        for i in 0..TERMS {
            right[i] = (right[i] - (0..i).map(|k| self.0[i][k] * right[k]).sum::<f64>()) / self.0[i][i];
        }
        for i in (0..TERMS).rev() {
            right[i] = (right[i] - (i + 1..TERMS).map(|k| self.0[k][i] * right[k]).sum::<f64>()) / self.0[i][i];
        }
        right
    }
}
