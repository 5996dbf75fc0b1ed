//! Calibration table: from pixels of the sensor to points of the laser plane, fast.
//!
//! Model: without lens distortion a column sees the laser plane by a homography, z = (a + b t) / (1 + k t) and x alike
//! with the same k, t being the row on [-1, 1]. Distortion bends the numerators a little. So each column has two
//! polynomials of degree 8 in t over one denominator, through nine rows at Chebyshev nodes (Trefethen 2013); without
//! distortion all but two of their coefficients vanish. Kept in single precision.
//!
//! Validity: rows of the sensor. Neglected: the remainder, which a test holds below 0.1 um.

/// Coefficients of a numerator [1].
const TERMS: usize = 9;

/// Where each pixel of a sensor sees the laser plane.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Locator {
    /// Middle row [px].
    middle: f32,
    /// Half of the number of rows [px].
    half: f32,
    /// k of the denominators `[columns]` [1].
    bend: Vec<f32>,
    /// Numerators of z [mm], term by term `[terms][columns]`.
    height: [Vec<f32>; TERMS],
    /// Numerators of x [mm], term by term `[terms][columns]`.
    along: [Vec<f32>; TERMS],
}

impl Locator {
    /// From what `locate` says of a column and a row [px]: x and z [mm].
    pub fn new(columns: usize, rows: usize, locate: impl Fn(f64, f64) -> [f64; 2]) -> Self {
        let half = (0.5 * rows as f64).max(1.0);
        let middle = half - 0.5;
        let row = |t: f64| middle + half * t;
        let nodes: [f64; TERMS] =
            std::array::from_fn(|i| libm::cos(std::f64::consts::PI * (i as f64 + 0.5) / TERMS as f64));
        let powers = powers(&nodes);
        let empty = || std::array::from_fn(|_| Vec::with_capacity(columns));
        let mut locator =
            Self { middle: middle as f32, half: half as f32, bend: Vec::new(), height: empty(), along: empty() };
        for column in 0..columns {
            // The homography through three of its rows.
            let [low, zero, high] = [-1.0, 0.0, 1.0].map(|t| locate(column as f64, row(t))[1]);
            let bend = if high == low { 0.0 } else { (2.0 * zero - high - low) / (high - low) };
            locator.bend.push(bend as f32);
            let points = nodes.map(|t| locate(column as f64, row(t)).map(|mm| mm * (1.0 + bend * t)));
            for (k, row) in powers.iter().enumerate() {
                let term = |axis: usize| row.iter().zip(&points).map(|(p, point)| p * point[axis]).sum::<f64>();
                locator.along[k].push(term(0) as f32);
                locator.height[k].push(term(1) as f32);
            }
        }
        locator
    }

    /// Height of the laser plane in each of the columns from `first` at the `rows` [px], written in place [mm].
    #[inline(always)]
    pub fn heights(&self, first: usize, rows: &mut [f32]) {
        self.evaluate(&self.height, first, rows);
    }

    /// Position along the line in each of the columns from `first` at the `rows` [px], written in place [mm].
    #[inline(always)]
    pub fn alongs(&self, first: usize, rows: &mut [f32]) {
        self.evaluate(&self.along, first, rows);
    }

    #[inline(always)]
    fn evaluate(&self, terms: &[Vec<f32>; TERMS], first: usize, rows: &mut [f32]) {
        let n = rows.len();
        let bend = &self.bend[first..first + n];
        let terms: [&[f32]; TERMS] = std::array::from_fn(|k| &terms[k][first..first + n]);
        for c in 0..n {
            let t = (rows[c] - self.middle) / self.half;
            let mut sum = terms[TERMS - 1][c];
            for term in terms[..TERMS - 1].iter().rev() {
                sum = sum * t + term[c];
            }
            rows[c] = sum / (1.0 + bend[c] * t);
        }
    }
}

/// The matrix from values at the nodes to coefficients of powers: Lagrange's polynomials multiplied out.
fn powers(nodes: &[f64; TERMS]) -> [[f64; TERMS]; TERMS] {
    let mut matrix = [[0.0; TERMS]; TERMS];
    for (i, node) in nodes.iter().enumerate() {
        let mut polynomial = [0.0; TERMS];
        polynomial[0] = 1.0;
        for other in nodes.iter().enumerate().filter(|(j, _)| *j != i).map(|(_, other)| other) {
            for k in (0..TERMS).rev() {
                let shifted = if k > 0 { polynomial[k - 1] } else { 0.0 };
                polynomial[k] = (shifted - other * polynomial[k]) / (node - other);
            }
        }
        for (row, coefficient) in matrix.iter_mut().zip(polynomial) {
            row[i] = coefficient;
        }
    }
    matrix
}
