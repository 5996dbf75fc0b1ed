//! Emulator: what the summary statistics of a scan are on average at given scores, and how far scans lie from what it
//! says.
//!
//! The mean of each statistic is a polynomial of the scores, and scans scatter about it by a normal law:
//!
//! m(u) = B^T f(u) + G^T q(u), S(u) ~ N(m(u), C)
//!
//! with f = (1, x), x the scores in units of the kernel, and q the squares, products and cubes of x as Hermite
//! polynomials, which are orthogonal where x is normal (polynomial chaos: Xiu and Karniadakis 2002). A Gaussian kernel
//! W about the region that matters, as wide as is needed for enough scans, weighs them; all count alike where there are
//! no more than these (fourteen keys and 3000 scans). B is weighted regression with a weak ridge (Hoerl and Kennard
//! 1970). G is what evidence calls for: the residuals of the linear part are turned into directions of independent unit
//! scatter. In each of these the curved terms, less what the linear ones say of them, have coefficients of a normal
//! law beforehand whose variance is that of greatest evidence (MacKay 1992). Where a direction is straight the variance
//! goes to nothing; free coefficients would add their noise to every foretold scan, and draw the posterior to the
//! middle of the scans.
//!
//! C is the weighted covariance of the errors of scans that the regression has not seen, e / (1 - h) for a residual e
//! of leverage h (leave-one-out; Allen 1974): scatter, what no polynomial follows, and the regression's own doubt. Its
//! correlations are shrunk towards none (Warton 2008), because there are nearly as many statistics as scans per
//! statistic. This is synthetic likelihood (Wood 2010) with a regression in place of repeated scans at each point, as
//! Bayesian optimisers of likelihoods do (Gutmann and Corander 2016). **Limits**: one region; scatter that is constant
//! over it; residuals whose tails are near normal.
//!
//! Scans of several classes are one vector, as many parts in a row. Each is of a place of its own: their errors have
//! nothing to do with each other, and C is that of each part.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// A simulated scan: scores of its keys, and its statistics in the scales of their laws.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Simulation {
    /// Scores, in the order of the keys.
    pub scores: Vec<f64>,
    /// Statistics; `None` where the scan does not tell one.
    pub statistics: Vec<Option<f64>>,
}

/// Where scans count, a normal law of the scores.
#[derive(Debug, Clone)]
pub(crate) struct ScoreRegion {
    pub mean: DVector<f64>,
    pub covariance: DMatrix<f64>,
}

/// Penalty of slopes, over that of one scan.
const RIDGE: f64 = 1e-2;
/// Least and greatest variance that coefficients of curved terms may have, over that of the scatter, and steps between
/// in equal ratios.
const CURVATURE: [f64; 2] = [1e-5, 10.0];
const CURVATURE_STEPS: usize = 60;
/// Variance, over one and the square of the mean, below which a statistic is constant.
const CONSTANT: f64 = 1e-18;
/// Most that a scan decides of its own mean [1]: beyond, its error when left out is five times its residual, and says
/// little.
const MOST_LEVERAGE: f64 = 0.8;
/// Share of the weight in which a statistic must be there.
const MOSTLY: f64 = 0.9;
/// Fewest scans in the kernel.
const FEWEST: f64 = 300.0;
/// Half of a kernel's width [standard deviations]: 95 % of a normal law.
const KERNEL_HALF: f64 = 2.0;
/// Scans in the kernel per term.
const PER_TERM: f64 = 25.0;

/// Mean and scatter of the statistics near a region.
#[derive(Debug, Clone)]
pub(crate) struct Emulator {
    middle: DVector<f64>,
    scale: DVector<f64>,
    /// `[terms, statistics]`.
    pub coefficients: DMatrix<f64>,
    /// `[statistics, statistics]`; zero rows where a statistic is not known.
    pub covariance: DMatrix<f64>,
    /// Least and greatest value of each statistic among the scans that count.
    ends: Vec<[f64; 2]>,
    /// Whether scans there tell a statistic, and it varies.
    pub known: Vec<bool>,
    /// Scans that count, less the linear terms that they were spent on.
    pub freedom: f64,
    /// Statistics of each part.
    part_length: usize,
}

/// Whether numbers of this variance and mean differ by more than rounding.
pub(crate) fn varies(variance: f64, mean: f64) -> bool {
    variance > CONSTANT * (1.0 + mean * mean)
}

/// Terms beyond the linear ones: squares, products, cubes.
fn curved_terms(keys: usize) -> usize {
    keys * (keys + 1) / 2 + keys
}

impl ScoreRegion {
    /// Where scores lie beforehand.
    pub fn prior(keys: usize) -> Self {
        Self { mean: DVector::zeros(keys), covariance: DMatrix::identity(keys, keys) }
    }

    /// Of scores drawn from it.
    pub fn of<'a>(samples: impl Iterator<Item = &'a [f64]> + Clone, keys: usize) -> Self {
        let n = samples.clone().count().max(1) as f64;
        let mean = samples.clone().fold(DVector::zeros(keys), |sum, u| sum + DVector::from_column_slice(u)) / n;
        let covariance = samples.fold(DMatrix::zeros(keys, keys), |sum, u| {
            let d = DVector::from_column_slice(u) - &mean;
            sum + &d * d.transpose()
        }) / n;
        // No direction is narrower than what a regression can tell.
        Self { mean, covariance: covariance + DMatrix::identity(keys, keys) * 1e-6 }
    }

    fn squared_distances(&self, simulations: &[Simulation]) -> Vec<f64> {
        let cholesky = cholesky(&self.covariance);
        let distance = |simulation: &Simulation| {
            let d = DVector::from_column_slice(&simulation.scores) - &self.mean;
            d.dot(&cholesky.solve(&d))
        };
        simulations.iter().map(distance).collect()
    }

    /// Weights exp(-share d^2 / 2) for squared distances d^2 from the middle of the region: what makes of scans that
    /// were drawn from a wider law those that lie as the region does.
    pub fn like(&self, simulations: &[Simulation], share: f64) -> Vec<f64> {
        self.squared_distances(simulations).into_iter().map(|d| libm::exp(-0.5 * share * d)).collect()
    }

    /// Weights of scans, from 0 to 1: a Gaussian as wide as `wanted` scans need.
    pub fn weights(&self, simulations: &[Simulation], wanted: f64) -> Vec<f64> {
        let distances = self.squared_distances(simulations);
        let of = |width: f64| -> Vec<f64> { distances.iter().map(|d| libm::exp(-0.5 * d / (width * width))).collect() };
        let effective = |weights: &[f64]| {
            let (sum, squares) = weights.iter().fold((0.0, 0.0), |(s, q), w| (s + w, q + w * w));
            if squares > 0.0 { sum * sum / squares } else { 0.0 }
        };
        let (mut low, mut high) = (1.0_f64, 1e4_f64);
        if effective(&of(low)) >= wanted {
            return of(low);
        }
        for _ in 0..40 {
            let middle = (low * high).sqrt();
            if effective(&of(middle)) < wanted { low = middle } else { high = middle }
        }
        of(high)
    }
}

/// Cholesky factors of a covariance, which is made definite where rounding has left it otherwise.
pub(crate) fn cholesky(covariance: &DMatrix<f64>) -> Cholesky<f64, Dyn> {
    let n = covariance.nrows();
    let scale = (covariance.trace() / n.max(1) as f64).max(1e-300);
    let mut lift = 0.0;
    loop {
        if let Some(found) = Cholesky::new(covariance + DMatrix::identity(n, n) * (lift * scale)) {
            return found;
        }
        // A matrix with NaN is never definite; then no scatter is as good as any.
        if lift > 1.0 {
            return Cholesky::new_unchecked(DMatrix::identity(n, n));
        }
        lift = if lift == 0.0 { 1e-12 } else { lift * 10.0 };
    }
}

impl Emulator {
    /// Scans that it wants in its kernel for so many keys.
    pub fn wanted(keys: usize) -> f64 {
        (PER_TERM * (1 + keys + curved_terms(keys)) as f64).max(FEWEST)
    }

    /// From scans with these weights, whose statistics are of so many parts.
    pub fn new(simulations: &[Simulation], weights: &[f64], parts: usize) -> Self {
        let keys = simulations.first().map_or(0, |simulation| simulation.scores.len());
        let count = simulations.first().map_or(0, |simulation| simulation.statistics.len());
        let (kept, effective) = counted_scans(simulations, weights);
        let mean_of = |value: &dyn Fn(&Simulation) -> f64| {
            kept.iter().map(|(simulation, w)| w * value(simulation)).sum::<f64>() / effective
        };
        let middle = DVector::from_fn(keys, |k, _| mean_of(&|s| s.scores[k]));
        let scale = DVector::from_fn(keys, |k, _| {
            mean_of(&|s| (s.scores[k] - middle[k]) * (s.scores[k] - middle[k])).sqrt().max(1e-6)
        });
        let linear = keys + 1;
        let mut emulator = Self {
            middle,
            scale,
            coefficients: DMatrix::zeros(linear + curved_terms(keys), count),
            covariance: DMatrix::zeros(count, count),
            ends: vec![[f64::INFINITY, f64::NEG_INFINITY]; count],
            known: vec![false; count],
            freedom: (effective - linear as f64).max(2.0),
            part_length: count / parts.max(1),
        };
        let weight = DVector::from_iterator(kept.len(), kept.iter().map(|(_, weight)| *weight));
        let (statistics, which) = told_statistics(&kept, count);
        if which.is_empty() {
            return emulator;
        }
        let terms = DMatrix::from_rows(
            &kept.iter().map(|(scan, _)| emulator.features(&scan.scores).transpose()).collect::<Vec<_>>(),
        );
        let (straight, curved) = (terms.columns(0, linear).into_owned(), terms.columns_range(linear..));

        let of_straight = weigh_rows(&straight, &weight);
        let mut normal = of_straight.tr_mul(&straight);
        for i in 1..linear {
            normal[(i, i)] += RIDGE;
        }
        let solver = cholesky(&normal);
        let slopes = solver.solve(&of_straight.tr_mul(&statistics));
        let residuals = statistics - &straight * &slopes;
        let taken = solver.solve(&of_straight.tr_mul(&curved));
        let curved = curved - &straight * &taken;

        // Statistics that do not vary but by rounding tell nothing.
        let scattered = scatter(&residuals, &weight, emulator.freedom, &emulator.parts_of(&which));
        let varies: Vec<usize> = (0..which.len()).filter(|&a| varies(scattered[(a, a)], slopes[(0, a)])).collect();
        if varies.is_empty() {
            return emulator;
        }
        let (scattered, residuals) =
            (scattered.select_rows(&varies).select_columns(&varies), residuals.select_columns(&varies));
        let parts = emulator.parts_of(&varies.iter().map(|&among| which[among]).collect::<Vec<_>>());
        let directions = Directions::new(&scattered, &parts);
        let residuals = residuals * directions.to.transpose();
        let curvature = Curvature::new(&curved, &weigh_rows(&curved, &weight), &residuals, &weight, emulator.freedom);
        let bent = &curvature.coefficients * directions.back.transpose();

        let hat = solver.solve(&straight.transpose());
        let errors = residuals - &curved * &curvature.coefficients;
        let errors = unseen_errors(errors, [&straight, &hat, &curved], &curvature, &weight);
        let covariance = scatter(&(errors * directions.back.transpose()), &weight, effective, &parts);
        let straightened = taken * &bent;
        for (a, &among) in varies.iter().enumerate() {
            let j = which[among];
            emulator.known[j] = true;
            for value in kept.iter().filter_map(|(scan, _)| scan.statistics[j]) {
                let [least, greatest] = emulator.ends[j];
                emulator.ends[j] = [least.min(value), greatest.max(value)];
            }
            for t in 0..linear {
                emulator.coefficients[(t, j)] = slopes[(t, among)] - straightened[(t, a)];
            }
            for t in 0..bent.nrows() {
                emulator.coefficients[(linear + t, j)] = bent[(t, a)];
            }
            for (b, &other) in varies.iter().enumerate() {
                emulator.covariance[(j, which[other])] = covariance[(a, b)];
            }
        }
        emulator
    }

    /// The part that each of these statistics belongs to.
    pub fn parts_of(&self, which: &[usize]) -> Vec<usize> {
        which.iter().map(|j| j / self.part_length.max(1)).collect()
    }

    /// Scores at a place, in units of the kernel.
    fn units(&self, scores: &[f64]) -> Vec<f64> {
        scores.iter().zip(self.middle.iter().zip(self.scale.iter())).map(|(u, (m, s))| (u - m) / s).collect()
    }

    /// Terms at a place: 1, the scores in units of the kernel, their squares and products, their cubes.
    pub fn features(&self, scores: &[f64]) -> DVector<f64> {
        let x = self.units(scores);
        let mut terms = Vec::with_capacity(1 + x.len() + curved_terms(x.len()));
        terms.push(1.0);
        terms.extend(&x);
        for i in 0..x.len() {
            terms.push((x[i] * x[i] - 1.0) / SQUARE);
            terms.extend((i + 1..x.len()).map(|j| x[i] * x[j]));
        }
        terms.extend(x.iter().map(|x| x * (x * x - 3.0) / CUBE));
        DVector::from_vec(terms)
    }

    /// Derivatives of the terms by the scores at a place, `[terms, keys]`.
    pub fn slopes(&self, scores: &[f64]) -> DMatrix<f64> {
        let x = self.units(scores);
        let keys = x.len();
        let mut slopes = DMatrix::zeros(1 + keys + curved_terms(keys), keys);
        let mut term = 1 + keys;
        for i in 0..keys {
            let by = 1.0 / self.scale[i];
            slopes[(1 + i, i)] = by;
            slopes[(term, i)] = 2.0 * x[i] / SQUARE * by;
            term += 1;
            for j in i + 1..keys {
                slopes[(term, i)] = x[j] * by;
                slopes[(term, j)] = x[i] / self.scale[j];
                term += 1;
            }
        }
        for i in 0..keys {
            slopes[(term + i, i)] = 3.0 * (x[i] * x[i] - 1.0) / CUBE / self.scale[i];
        }
        slopes
    }

    /// How far each of a scan's statistics lies from its mean at a place; 0 where it is not told.
    pub fn off(&self, scores: &[f64], statistics: &[Option<f64>]) -> Vec<f64> {
        let mean = self.mean(scores);
        let off =
            |(j, value): (usize, &Option<f64>)| value.filter(|_| self.known[j]).map_or(0.0, |value| value - mean[j]);
        statistics.iter().enumerate().map(off).collect()
    }

    /// How far each of a scan's statistics lies beyond those of all scans of the kernel; 0 where it does not.
    pub fn beyond(&self, statistics: &[Option<f64>]) -> Vec<f64> {
        let beyond = |(j, value): (usize, &Option<f64>)| {
            let [least, greatest] = self.ends[j];
            value.filter(|_| self.known[j]).map_or(0.0, |value| (least - value).max(value - greatest).max(0.0))
        };
        statistics.iter().enumerate().map(beyond).collect()
    }

    /// Mean of the statistics at a place.
    pub fn mean(&self, scores: &[f64]) -> DVector<f64> {
        self.coefficients.tr_mul(&self.features(scores))
    }

    /// Mean of the statistics where one of the scores is another. Beyond what the kernel holds of that score it goes on
    /// along the tangent, since cubes of a narrow kernel say nothing of far places.
    pub fn mean_along(&self, scores: &[f64], key: usize, score: f64) -> DVector<f64> {
        let [low, high] = [-KERNEL_HALF, KERNEL_HALF].map(|side| self.middle[key] + side * self.scale[key]);
        let mut place = scores.to_vec();
        place[key] = score.clamp(low, high);
        let tangent = self.coefficients.tr_mul(&self.slopes(&place).column(key));
        self.mean(&place) + tangent * (score - place[key])
    }
}

/// Roots of 2 and 6: with these the Hermite polynomials have unit variance.
const SQUARE: f64 = std::f64::consts::SQRT_2;
const CUBE: f64 = 2.449_489_742_783_178;

/// The scans that count, with weights whose sum is how many they stand for, and that number.
fn counted_scans<'a>(simulations: &'a [Simulation], weights: &[f64]) -> (Vec<(&'a Simulation, f64)>, f64) {
    let all: f64 = weights.iter().sum();
    let squares: f64 = weights.iter().map(|weight| weight * weight).sum();
    let effective = all * all / squares.max(1e-300);
    let counted = simulations.iter().zip(weights).filter(|(_, weight)| **weight > 1e-6);
    (counted.map(|(simulation, weight)| (simulation, weight * effective / all)).collect(), effective)
}

/// Errors `[scans, directions]` of each scan where it is left out, from those of a fit to all: by its leverage on the
/// linear terms, which `hat` are solved for, and on the curved ones.
fn unseen_errors(
    mut errors: DMatrix<f64>,
    [straight, hat, curved]: [&DMatrix<f64>; 3],
    curvature: &Curvature,
    weight: &DVector<f64>,
) -> DMatrix<f64> {
    for scan in 0..errors.nrows() {
        let of_linear = straight.row(scan).transpose().dot(&hat.column(scan));
        let of_curved = curvature.doubts(&curved.row(scan).transpose());
        for (direction, of_curved) in of_curved.into_iter().enumerate() {
            errors[(scan, direction)] /= 1.0 - (weight[scan] * (of_linear + of_curved)).min(MOST_LEVERAGE);
        }
    }
    errors
}

/// The statistics `[scans, statistics]` that most scans tell, with their mean where a scan does not, and which they
/// are.
fn told_statistics(kept: &[(&Simulation, f64)], count: usize) -> (DMatrix<f64>, Vec<usize>) {
    let all: f64 = kept.iter().map(|(_, weight)| weight).sum();
    let mut columns = Vec::new();
    let mut which = Vec::new();
    for j in 0..count {
        let told = kept.iter().filter_map(|(scan, weight)| Some((scan.statistics[j]?, weight)));
        let (there, sum) =
            told.fold((0.0, 0.0), |(there, sum), (value, weight)| (there + weight, sum + weight * value));
        if there > 0.0 && there >= MOSTLY * all {
            let mean = sum / there;
            columns.push(DVector::from_iterator(
                kept.len(),
                kept.iter().map(|(scan, _)| scan.statistics[j].unwrap_or(mean)),
            ));
            which.push(j);
        }
    }
    let statistics = if columns.is_empty() { DMatrix::zeros(kept.len(), 0) } else { DMatrix::from_columns(&columns) };
    (statistics, which)
}

/// Principal directions of the correlations of a covariance, each of unit scatter and of one part.
pub(crate) struct Directions {
    /// `[directions, statistics]`.
    pub to: DMatrix<f64>,
    /// `[statistics, directions]`, its inverse.
    back: DMatrix<f64>,
}

impl Directions {
    /// Of a covariance whose variances are all above zero, of statistics of these parts, one part after the other.
    pub fn new(covariance: &DMatrix<f64>, parts: &[usize]) -> Self {
        let n = covariance.nrows();
        let mut found = Self { to: DMatrix::zeros(n, n), back: DMatrix::zeros(n, n) };
        let mut from = 0;
        for part in parts.chunk_by(|a, b| a == b) {
            let size = part.len();
            let covariance = covariance.view((from, from), (size, size));
            let deviation: Vec<f64> = covariance.diagonal().iter().map(|variance| variance.sqrt()).collect();
            let correlation = DMatrix::from_fn(size, size, |a, b| covariance[(a, b)] / (deviation[a] * deviation[b]));
            let eigen = correlation.symmetric_eigen();
            let root: Vec<f64> = eigen.eigenvalues.iter().map(|value| value.max(1e-9).sqrt()).collect();
            for a in 0..size {
                for e in 0..size {
                    let vector = eigen.eigenvectors[(a, e)];
                    found.to[(from + e, from + a)] = vector / (root[e] * deviation[a]);
                    found.back[(from + a, from + e)] = vector * root[e] * deviation[a];
                }
            }
            from += size;
        }
        found
    }
}

/// Coefficients of the curved terms in each direction, shrunk as its evidence calls for.
struct Curvature {
    /// `[terms, directions]`.
    coefficients: DMatrix<f64>,
    /// Eigenvectors of the terms' normal matrix, and its eigenvalues.
    vectors: DMatrix<f64>,
    values: DVector<f64>,
    /// Inverse of the variance that coefficients of a direction have beforehand, over its scatter's.
    penalty: Vec<f64>,
}

impl Curvature {
    /// Of terms and residuals `[scans, ..]` with these weights. The evidence of a variance t is, but for a constant,
    /// -(sum of ln(1 + t d) + n ln(r)) / 2, with eigenvalues d of the normal matrix and r the squares that are left.
    fn new(
        terms: &DMatrix<f64>,
        weighted: &DMatrix<f64>,
        residuals: &DMatrix<f64>,
        weight: &DVector<f64>,
        freedom: f64,
    ) -> Self {
        let eigen = weighted.tr_mul(terms).symmetric_eigen();
        let values = eigen.eigenvalues.map(|value| value.max(0.0));
        let along = eigen.eigenvectors.tr_mul(&weighted.tr_mul(residuals));
        let [least, most] = CURVATURE;
        let steps = (0..CURVATURE_STEPS)
            .map(|step| least * libm::pow(most / least, step as f64 / (CURVATURE_STEPS - 1) as f64));
        let tried: Vec<(f64, f64)> =
            steps.map(|t| (t, values.iter().map(|d| libm::log1p(t * d)).sum::<f64>())).collect();
        let mut found = Self {
            coefficients: DMatrix::zeros(values.len(), residuals.ncols()),
            vectors: eigen.eigenvectors,
            values,
            penalty: Vec::new(),
        };
        let mut shrunk = found.coefficients.clone();
        for direction in 0..residuals.ncols() {
            let squares: f64 = residuals.column(direction).iter().zip(weight.iter()).map(|(e, w)| w * e * e).sum();
            let evidence = |(t, logs): &(f64, f64)| {
                let told: f64 = found
                    .values
                    .iter()
                    .zip(along.column(direction).iter())
                    .map(|(d, a)| a * a * t / (1.0 + t * d))
                    .sum();
                -0.5 * (logs + freedom * libm::log((squares - told).max(1e-12)))
            };
            let best = tried.iter().map(|tried| (evidence(tried), tried.0)).max_by(|a, b| a.0.total_cmp(&b.0));
            let penalty = 1.0 / best.map_or(least, |(_, t)| t);
            found.penalty.push(penalty);
            for (term, d) in found.values.iter().enumerate() {
                shrunk[(term, direction)] = along[(term, direction)] / (d + penalty);
            }
        }
        found.coefficients = &found.vectors * shrunk;
        found
    }

    /// Variance of what the curved terms add at a place, over the scatter's, in each direction.
    fn doubts(&self, terms: &DVector<f64>) -> Vec<f64> {
        let along = self.vectors.tr_mul(terms);
        let doubt = |penalty: &f64| along.iter().zip(self.values.iter()).map(|(a, d)| a * a / (d + penalty)).sum();
        self.penalty.iter().map(doubt).collect()
    }
}

/// Rows `[scans, ..]` times their weights.
fn weigh_rows(matrix: &DMatrix<f64>, weight: &DVector<f64>) -> DMatrix<f64> {
    let mut weighted = matrix.clone();
    weighted.row_iter_mut().zip(weight.iter()).for_each(|(mut row, weight)| row *= *weight);
    weighted
}

/// Weighted covariance of residuals `[scans, statistics]` of these parts, correlations within a part shrunk.
fn scatter(residuals: &DMatrix<f64>, weight: &DVector<f64>, divisor: f64, parts: &[usize]) -> DMatrix<f64> {
    let count = residuals.ncols();
    let mut covariance = weigh_rows(residuals, weight).tr_mul(residuals) / divisor.max(1e-300);
    for i in 0..count {
        let of_part = parts.iter().filter(|part| **part == parts[i]).count() as f64;
        let shrink = of_part / (of_part + divisor.max(1.0));
        for j in (0..count).filter(|&j| j != i) {
            covariance[(i, j)] *= if parts[i] == parts[j] { 1.0 - shrink } else { 0.0 };
        }
    }
    covariance
}

#[cfg(test)]
pub(crate) mod tests;
