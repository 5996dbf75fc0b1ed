//! Fit of counts: y ~ exp(sum of b_k x_k), the variance of y proportional to its mean (quasi-Poisson, log link).
//!
//! Sparse counts are no trouble, since no logarithm of a count is taken. Solved by iteratively reweighted least squares
//! (Nelder and Wedderburn 1972); covariance of b = dispersion (X^T W X)^-1, dispersion from Pearson's residuals.

/// Terms of the model.
pub(super) const TERMS: usize = 9;

/// One observation: its terms and its count.
pub(super) type Row = ([f64; TERMS], f64);

/// Coefficients and their standard errors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Fit {
    /// Coefficients.
    pub b: [f64; TERMS],
    /// Standard errors.
    pub error: [f64; TERMS],
}

/// Fits `rows` from a start; `None` where they do not determine the terms.
pub(super) fn fit(rows: &[Row], start: [f64; TERMS]) -> Option<Fit> {
    const ROUNDS: usize = 50;
    let mut b = start;
    for _ in 0..ROUNDS {
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
    let (matrix, _) = normal_equations(rows, &b);
    let root = Cholesky::of(&matrix)?;
    let pearson: f64 = rows.iter().map(|(x, y)| (mean(x, &b), y)).map(|(m, y)| (y - m).powi(2) / m).sum();
    let dispersion = pearson / (rows.len() as f64 - TERMS as f64).max(1.0);
    let error = std::array::from_fn(|k| {
        let mut unit = [0.0; TERMS];
        unit[k] = 1.0;
        (dispersion * root.solve(unit)[k]).sqrt()
    });
    Some(Fit { b, error })
}

fn mean(x: &[f64; TERMS], b: &[f64; TERMS]) -> f64 {
    // Far from the data's scale a step may overshoot; the next ones come back.
    libm::exp((0..TERMS).map(|k| x[k] * b[k]).sum::<f64>().clamp(-300.0, 300.0))
}

/// X^T W X and X^T W z of one round.
fn normal_equations(rows: &[Row], b: &[f64; TERMS]) -> ([[f64; TERMS]; TERMS], [f64; TERMS]) {
    let (mut matrix, mut right) = ([[0.0; TERMS]; TERMS], [0.0; TERMS]);
    for (x, y) in rows {
        let m = mean(x, b);
        let line: f64 = (0..TERMS).map(|k| x[k] * b[k]).sum();
        let z = line + (y - m) / m;
        for i in 0..TERMS {
            right[i] += x[i] * m * z;
            for j in 0..=i {
                matrix[i][j] += x[i] * m * x[j];
            }
        }
    }
    (matrix, right)
}

/// Lower triangle of a positive matrix's root.
struct Cholesky([[f64; TERMS]; TERMS]);

impl Cholesky {
    /// `None` where the matrix is not positive.
    fn of(matrix: &[[f64; TERMS]; TERMS]) -> Option<Self> {
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
