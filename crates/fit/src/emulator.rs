//! Emulator: what the summary statistics of a scan are on average at given scores, how they scatter from scan to scan, and how well
//! either is known.
//!
//! Near the region that matters the mean of each statistic is linear in the scores, by weighted regression over simulated scans:
//!
//! m(u) = B^T f(u), f = (1, u), B = (F^T W F + R)^-1 F^T W S, S(u) ~ N(m(u), C)
//!
//! with a Gaussian kernel W about the region, as wide as is needed for enough scans, and a weak ridge R (Hoerl and Kennard 1970). C is the weighted covariance of the residuals, its
//! correlations shrunk towards none (Warton 2008), because there are nearly as many statistics as scans per statistic; what is not linear is in it
//! too. This is synthetic likelihood (Wood 2010) with a regression in place of repeated scans at each point, as Bayesian optimisers of likelihoods do
//! (Gutmann and Corander 2016). Squares and products foretell unseen scans better, and make posteriors half as wide as they should be:
//! the noise of some fifty curvatures in each key adds to every residual but those in the middle of the scans, and draws the posterior there. **Limits**: one
//! region; scatter that is constant over it; residuals whose tails are near normal.

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
/// Share of the weight in which a statistic must be there.
const MOSTLY: f64 = 0.9;
/// Fewest scans in the kernel.
const FEWEST: f64 = 300.0;
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
    /// Variance of the mean, over that of the scatter, on average over the scans: terms over scans that count.
    pub doubt: f64,
    /// Whether scans there tell a statistic.
    pub known: Vec<bool>,
    /// Scans that count, less the terms that they were spent on.
    pub freedom: f64,
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

    /// Weights exp(-share d^2 / 2) for squared distances d^2 from the middle of the region: what makes of scans that were drawn from a wider
    /// law those that lie as the region does.
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
        (PER_TERM * (1 + keys) as f64).max(FEWEST)
    }

    /// From scans with these weights.
    pub fn new(simulations: &[Simulation], weights: &[f64]) -> Self {
        let keys = simulations.first().map_or(0, |simulation| simulation.scores.len());
        let count = simulations.first().map_or(0, |simulation| simulation.statistics.len());
        let all: f64 = weights.iter().sum();
        let mean_of = |value: &dyn Fn(&Simulation) -> f64| {
            simulations.iter().zip(weights).map(|(simulation, w)| w * value(simulation)).sum::<f64>() / all
        };
        let middle = DVector::from_fn(keys, |k, _| mean_of(&|s| s.scores[k]));
        let scale = DVector::from_fn(keys, |k, _| {
            mean_of(&|s| (s.scores[k] - middle[k]) * (s.scores[k] - middle[k])).sqrt().max(1e-6)
        });
        let p = keys + 1;
        let mut emulator = Self {
            middle,
            scale,
            coefficients: DMatrix::zeros(p, count),
            covariance: DMatrix::zeros(count, count),
            doubt: 0.0,
            known: vec![false; count],
            freedom: 1.0,
        };
        let kept: Vec<(usize, f64)> =
            weights.iter().copied().enumerate().filter(|(_, weight)| *weight > 1e-6).collect();
        let features: Vec<DVector<f64>> =
            kept.iter().map(|(n, _)| emulator.features(&simulations[*n].scores)).collect();
        let mut normal = DMatrix::zeros(p, p);
        for ((_, weight), f) in kept.iter().zip(&features) {
            normal.ger(*weight, f, f, 1.0);
        }
        for i in 1..p {
            normal[(i, i)] += RIDGE;
        }
        let solver = cholesky(&normal);
        let mut residuals = DMatrix::zeros(kept.len(), count);
        for j in 0..count {
            let (mut there, mut sum) = (0.0, 0.0);
            for (n, weight) in &kept {
                if let Some(value) = simulations[*n].statistics[j] {
                    (there, sum) = (there + weight, sum + weight * value);
                }
            }
            if there < MOSTLY * all {
                continue;
            }
            emulator.known[j] = true;
            let mean = sum / there;
            let value = |n: usize| simulations[n].statistics[j].unwrap_or(mean);
            let mut right = DVector::zeros(p);
            for ((n, weight), f) in kept.iter().zip(&features) {
                right.axpy(weight * value(*n), f, 1.0);
            }
            let coefficients = solver.solve(&right);
            for (row, ((n, _), f)) in kept.iter().zip(&features).enumerate() {
                residuals[(row, j)] = value(*n) - coefficients.dot(f);
            }
            emulator.coefficients.set_column(j, &coefficients);
        }
        let squares: f64 = kept.iter().map(|(_, weight)| weight * weight).sum();
        let effective = all * all / squares.max(1e-300);
        emulator.freedom = (effective - p as f64).max(2.0);
        emulator.doubt = p as f64 / effective.max(1.0);
        emulator.covariance = scatter(&residuals, &kept, all * emulator.freedom / effective);
        emulator
    }

    /// Terms at a place: 1 and the scores, in units of the kernel.
    pub fn features(&self, scores: &[f64]) -> DVector<f64> {
        DVector::from_fn(scores.len() + 1, |t, _| match t.checked_sub(1) {
            None => 1.0,
            Some(i) => (scores[i] - self.middle[i]) / self.scale[i],
        })
    }

    /// Derivatives of the terms by the scores, `[terms, keys]`.
    pub fn slopes(&self) -> DMatrix<f64> {
        let keys = self.scale.len();
        DMatrix::from_fn(keys + 1, keys, |t, i| if t == i + 1 { 1.0 / self.scale[i] } else { 0.0 })
    }

    /// Mean of the statistics at a place.
    pub fn mean(&self, scores: &[f64]) -> DVector<f64> {
        self.coefficients.tr_mul(&self.features(scores))
    }
}

/// Weighted covariance of residuals `[scans, statistics]`, correlations shrunk.
fn scatter(residuals: &DMatrix<f64>, kept: &[(usize, f64)], divisor: f64) -> DMatrix<f64> {
    let count = residuals.ncols();
    let mut weighted = residuals.clone();
    for (row, (_, weight)) in kept.iter().enumerate() {
        weighted.row_mut(row).scale_mut(weight.sqrt());
    }
    let mut covariance = weighted.tr_mul(&weighted) / divisor.max(1e-300);
    let shrink = count as f64 / (count as f64 + divisor.max(1.0));
    for i in 0..count {
        for j in 0..count {
            if i != j {
                covariance[(i, j)] *= 1.0 - shrink;
            }
        }
    }
    covariance
}

#[cfg(test)]
mod tests {
    use procedural::{Stream, normal};

    use super::*;

    /// Scans of a known law: three statistics, linear in two scores, scatter with a correlation of 0.8.
    fn scans(n: usize) -> Vec<Simulation> {
        let mut rng = Stream::root(3).rng();
        (0..n)
            .map(|_| {
                let scores = vec![normal(&mut rng), normal(&mut rng)];
                let (a, b) = (normal(&mut rng), normal(&mut rng));
                let [x, y] = [scores[0], scores[1]];
                let statistics = vec![Some(1.0 + 2.0 * x + 0.3 * a), Some(-y + 0.3 * (0.8 * a + 0.6 * b)), None];
                Simulation { scores, statistics }
            })
            .collect()
    }

    /// Mean, scatter and what is not told are found (alpha 1e-4 each).
    #[test]
    fn a_known_law_is_found() {
        let scans = scans(2000);
        let emulator = Emulator::new(&scans, &vec![1.0; scans.len()]);
        assert_eq!(emulator.known, [true, true, false]);
        assert!((emulator.doubt * 2000.0 - 3.0).abs() < 1e-9);
        for place in [[0.0, 0.0], [1.0, -1.5], [-2.0, 0.5]] {
            let [x, y] = place;
            // The variance of a line's mean: (1 + x^2 + y^2) / n.
            let error = 3.9 * 0.3 * ((1.0_f64 + x * x + y * y) / 2000.0_f64).sqrt();
            for (found, expected) in emulator.mean(&place).iter().zip([1.0 + 2.0 * x, -y]) {
                assert!((found - expected).abs() < error, "{found} for {expected} +- {error} at {place:?}");
            }
        }
        // A variance from 2000 numbers has a relative standard error of 0.032; shrinking takes 3 of 2000 of the correlation.
        let c = &emulator.covariance;
        assert!((c[(0, 0)] / 0.09 - 1.0).abs() < 3.9 * 0.032, "{}", c[(0, 0)]);
        let r = c[(0, 1)] / (c[(0, 0)] * c[(1, 1)]).sqrt();
        assert!((r - 0.8).abs() < 3.9 * 0.36 / 2000_f64.sqrt() + 0.01, "{r}");
    }

    /// A kernel takes the scans that it needs about its region, and all where there are fewer.
    #[test]
    fn a_kernel_has_the_scans_that_are_wanted() {
        let scans = scans(3000);
        let region =
            ScoreRegion { mean: DVector::from_vec(vec![1.0, 1.0]), covariance: DMatrix::identity(2, 2) * 1e-3 };
        let weights = region.weights(&scans, 300.0);
        let (sum, squares): (f64, f64) = (weights.iter().sum(), weights.iter().map(|w| w * w).sum());
        assert!((sum * sum / squares / 300.0 - 1.0).abs() < 0.01);
        let nearest = scans.iter().zip(&weights).filter(|(_, w)| **w > 0.5).map(|(s, _)| (s.scores[0] - 1.0).abs());
        assert!(nearest.fold(0.0, f64::max) < 1.0);
        assert!(region.weights(&scans[..200], 300.0).iter().all(|weight| *weight > 0.9));
    }
}
