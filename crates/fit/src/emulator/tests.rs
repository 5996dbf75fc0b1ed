//! Emulators of known laws: means, scatter, kernels.

use base::{Stream, normal};

use super::*;

/// Scans of a known law: two statistics that are linear in two scores, scatter with a correlation of 0.8; one that is
/// not told, a constant one.
fn scans(n: usize) -> Vec<Simulation> {
    let mut rng = Stream::root(3).rng();
    (0..n)
        .map(|_| {
            let scores = vec![normal(&mut rng), normal(&mut rng)];
            let (a, b) = (normal(&mut rng), normal(&mut rng));
            let [x, y] = [scores[0], scores[1]];
            let constant = Some(-11.512_925_464_970_23);
            let statistics = vec![Some(1.0 + 2.0 * x + 0.3 * a), Some(-y + 0.3 * (0.8 * a + 0.6 * b)), None, constant];
            Simulation { scores, statistics }
        })
        .collect()
}

/// Mean, scatter and what is not told are found (alpha 1e-4 each, and a little).
#[test]
fn a_known_law_is_found() {
    let scans = scans(2000);
    let emulator = Emulator::new(&scans, &vec![1.0; scans.len()], 1);
    assert_eq!(emulator.known, [true, true, false, false]);
    for place in [[0.0, 0.0], [1.0, -1.5], [-2.0, 0.5]] {
        let [x, y] = place;
        // The variance of a line's mean: (1 + x^2 + y^2) / n; curved terms that evidence does not call for add up to a
        // fifth (chosen).
        let error = 3.9 * 0.3 * ((1.0_f64 + x * x + y * y) / 2000.0_f64).sqrt() * 1.2;
        for (found, expected) in emulator.mean(&place).iter().zip([1.0 + 2.0 * x, -y]) {
            assert!((found - expected).abs() < error, "{found} for {expected} +- {error} at {place:?}");
        }
    }
    // A variance from 2000 numbers has a relative standard error of 0.032; shrinking takes 2 of 2002 of the
    // correlation.
    let c = &emulator.covariance;
    assert!((c[(0, 0)] / 0.09 - 1.0).abs() < 3.9 * 0.032, "{}", c[(0, 0)]);
    let r = c[(0, 1)] / (c[(0, 0)] * c[(1, 1)]).sqrt();
    assert!((r - 0.8).abs() < 3.9 * 0.36 / 2000_f64.sqrt() + 0.01, "{r}");
}

/// Of two parts each is what it is alone, whatever their errors have to do with each other.
#[test]
fn parts_are_apart() {
    let alone = scans(400);
    let twice = |scan: &Simulation| Simulation {
        scores: scan.scores.clone(),
        statistics: [scan.statistics.clone(), scan.statistics.iter().map(|s| s.map(|s| 2.0 * s)).collect()].concat(),
    };
    let both: Vec<Simulation> = alone.iter().map(twice).collect();
    let weights = vec![1.0; alone.len()];
    let (of_one, of_both) = (Emulator::new(&alone, &weights, 1), Emulator::new(&both, &weights, 2));
    assert_eq!(of_both.parts_of(&[0, 3, 4, 7]), [0, 0, 1, 1]);
    let is_near = |a: f64, b: f64| (a - b).abs() < 1e-9;
    for (i, j) in (0..4).flat_map(|i| (0..4).map(move |j| (i, j))) {
        let c = |a: usize, b: usize| of_both.covariance[(a, b)];
        assert!(is_near(c(i, j), of_one.covariance[(i, j)]) && is_near(c(i + 4, j + 4), 4.0 * c(i, j)));
        assert_eq!((c(i, j + 4), c(i + 4, j)), (0.0, 0.0));
    }
    let (one, two) = (of_one.mean(&[0.4, -1.1]), of_both.mean(&[0.4, -1.1]));
    assert!((0..4).all(|j| is_near(two[j], one[j]) && is_near(two[j + 4], 2.0 * one[j])));
}

/// Polynomials of drawn coefficients in five scores, scattered: nine statistics.
pub(crate) struct Polynomials {
    coefficients: DMatrix<f64>,
    like: Emulator,
}

impl Polynomials {
    pub const KEYS: usize = 5;
    pub const STATISTICS: usize = 9;

    pub fn new(seed: u64, curvature: f64) -> Self {
        let mut rng = Stream::root(seed).child("law").rng();
        let terms = 1 + Self::KEYS + curved_terms(Self::KEYS);
        let coefficients = DMatrix::from_fn(terms, Self::STATISTICS, |t, _| {
            normal(&mut rng) * if t > Self::KEYS { curvature } else { 1.0 }
        });
        let like = Emulator {
            middle: DVector::zeros(Self::KEYS),
            scale: DVector::from_element(Self::KEYS, 1.0),
            coefficients: DMatrix::zeros(0, 0),
            covariance: DMatrix::zeros(0, 0),
            ends: Vec::new(),
            known: Vec::new(),
            freedom: 1.0,
            part_length: Self::STATISTICS,
        };
        Self { coefficients, like }
    }

    fn mean(&self, scores: &[f64]) -> DVector<f64> {
        self.coefficients.tr_mul(&self.like.features(scores))
    }

    /// Scans with a scatter that the statistics have half in common.
    pub fn scans(&self, n: usize, seed: u64) -> Vec<Simulation> {
        let mut rng = Stream::root(seed).child("scans").rng();
        (0..n)
            .map(|_| {
                let scores: Vec<f64> = (0..Self::KEYS).map(|_| normal(&mut rng)).collect();
                let common = normal(&mut rng);
                let scattered = |mean: &f64| Some(mean + 0.5 * (common + normal(&mut rng)));
                let statistics = self.mean(&scores).iter().map(scattered).collect();
                Simulation { scores, statistics }
            })
            .collect()
    }
}

/// Regression on the same terms with free coefficients.
fn free_coefficients(emulator: &Emulator, scans: &[Simulation]) -> DMatrix<f64> {
    let terms =
        DMatrix::from_rows(&scans.iter().map(|scan| emulator.features(&scan.scores).transpose()).collect::<Vec<_>>());
    let told =
        DMatrix::from_fn(scans.len(), Polynomials::STATISTICS, |n, j| scans[n].statistics[j].expect("all are told"));
    cholesky(&terms.tr_mul(&terms)).solve(&terms.tr_mul(&told))
}

/// What an emulator says of 4000 scans that it has not seen: squares of their errors over told ones, and squares of
/// errors of means, by it and with free coefficients.
fn of_unseen(law: &Polynomials, emulator: &Emulator, scans: &[Simulation], seed: u64) -> (f64, [f64; 2]) {
    let fresh = law.scans(4000, seed + 100);
    let whiten = cholesky(&emulator.covariance);
    let free = free_coefficients(emulator, scans);
    let (mut squares, mut of_means) = (0.0, [0.0; 2]);
    for scan in &fresh {
        let told = DVector::from_iterator(9, scan.statistics.iter().flatten().copied());
        let error = told - emulator.mean(&scan.scores);
        squares += error.dot(&whiten.solve(&error)) / (9.0 * 4000.0);
        let truth = law.mean(&scan.scores);
        let by_free = free.tr_mul(&emulator.features(&scan.scores));
        for (way, mean) in [emulator.mean(&scan.scores), by_free].into_iter().enumerate() {
            of_means[way] += (mean - &truth).norm_squared();
        }
    }
    (squares, of_means)
}

/// Curved laws are found as well as free coefficients find them, straight ones twice as well, and scans that were not
/// seen lie about the mean as the covariance says: by a chi-square of whitened errors over ten laws, for few scans and
/// for many. Slopes are the derivatives of the terms.
#[test]
fn curved_laws_are_found_and_errors_are_as_told() {
    for (n, curvature) in [(120, 0.3), (300, 0.3), (2000, 0.3), (120, 0.0), (2000, 0.0)] {
        let (mut squares, mut of_means) = (0.0, [0.0; 2]);
        for seed in 1..=10 {
            let law = Polynomials::new(seed, curvature);
            let scans = law.scans(n, seed);
            let emulator = Emulator::new(&scans, &vec![1.0; n], 1);
            let (of_scans, [ours, free]) = of_unseen(&law, &emulator, &scans, seed);
            squares += 0.1 * of_scans;
            of_means = [of_means[0] + ours, of_means[1] + free];
            let place: Vec<f64> = scans[0].scores.clone();
            let slopes = emulator.slopes(&place);
            for key in 0..5 {
                let moved = |by: f64| {
                    let mut moved = place.clone();
                    moved[key] += by;
                    emulator.features(&moved)
                };
                let difference = (moved(1e-5) - moved(-1e-5)) / 2e-5;
                assert!((difference - slopes.column(key)).amax() < 1e-8);
            }
        }
        let most = if curvature > 0.0 { 1.05 } else { 0.5 };
        println!("{n} scans, curvature {curvature}: squares {squares}, means {of_means:?}");
        assert!(of_means[0] < most * of_means[1], "{n} scans, curvature {curvature}: means are off by {of_means:?}");
        // The inverse of a covariance from n scans in 9 statistics is n / (n - 10) too large. Residuals of the scans
        // that were regressed on give 1.7 for 120.
        let expected = n as f64 / (n as f64 - 10.0);
        assert!((squares / expected - 1.0).abs() < 0.12, "{n} scans: errors have {squares} of their told squares");
    }
}

/// Where scans have unlike weights, as in a kernel about a narrow region, those of the same kernel that were not seen
/// lie about the mean as told, too.
#[test]
fn errors_in_kernels_are_as_told() {
    let mean_square = |seed: u64| {
        let law = Polynomials::new(seed, 0.3);
        let scans = law.scans(3000, seed);
        let keys = Polynomials::KEYS;
        let region =
            ScoreRegion { mean: DVector::from_element(keys, 0.4), covariance: DMatrix::identity(keys, keys) * 0.1 };
        let emulator = Emulator::new(&scans, &region.weights(&scans, 400.0), 1);
        let whiten = cholesky(&emulator.covariance);
        let fresh = law.scans(6000, seed + 100);
        // Twice the scans, twice as many of them: a kernel as wide.
        let weights = region.weights(&fresh, 800.0);
        let square = |scan: &Simulation| {
            let told = DVector::from_iterator(9, scan.statistics.iter().flatten().copied());
            let error = told - emulator.mean(&scan.scores);
            error.dot(&whiten.solve(&error)) / 9.0
        };
        fresh.iter().zip(&weights).map(|(scan, w)| w * square(scan)).sum::<f64>() / weights.iter().sum::<f64>()
    };
    let squares = (1..=10).map(|seed| 0.1 * mean_square(seed)).sum::<f64>();
    // 400 scans that count, and 800 fresh ones of each law: two standard errors are 1.5 %. A kernel's unequal weights
    // make leave-one-out a little unlike.
    let expected = 400.0 / 390.0;
    assert!((squares / expected - 1.0).abs() < 0.08, "errors have {squares} of their told squares");
}

/// A kernel takes the scans that it needs about its region, and all where there are fewer.
#[test]
fn a_kernel_has_the_scans_that_are_wanted() {
    let scans = scans(3000);
    let region = ScoreRegion { mean: DVector::from_vec(vec![1.0, 1.0]), covariance: DMatrix::identity(2, 2) * 1e-3 };
    let weights = region.weights(&scans, 300.0);
    let (sum, squares): (f64, f64) = (weights.iter().sum(), weights.iter().map(|w| w * w).sum());
    assert!((sum * sum / squares / 300.0 - 1.0).abs() < 0.01);
    let nearest = scans.iter().zip(&weights).filter(|(_, w)| **w > 0.5).map(|(s, _)| (s.scores[0] - 1.0).abs());
    assert!(nearest.fold(0.0, f64::max) < 1.0);
    assert!(region.weights(&scans[..200], 300.0).iter().all(|weight| *weight > 0.9));
}
