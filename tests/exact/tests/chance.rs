//! Purpose: exact tests of laws give the chances that they say: against tables, other ways of computing them,
//! simulation.

use base::Stream;
use rand::RngExt;

use exact::{HISTOGRAM_CELLS, UnitHistogram, binomial, kolmogorov_smirnov, likelihood_ratio, likelihood_ratio_chance};

/// Even numbers of [0, 1), the same in every run.
fn even(name: &str, index: u64, n: usize) -> Vec<f64> {
    let mut rng = Stream::root(1).child(name).index(index).rng();
    (0..n).map(|_| rng.random()).collect()
}

fn grid(numbers: impl IntoIterator<Item = f64>) -> UnitHistogram {
    let mut grid = UnitHistogram::default();
    numbers.into_iter().for_each(|u| grid.add(u));
    grid
}

#[test]
fn smirnov_is_that_of_tables() {
    // Kolmogorov's critical values (Miller 1956, table 1): two sides at 0.05 and 0.01; one side at half of them.
    for (n, critical) in [(5, [0.56328, 0.66853]), (20, [0.29408, 0.35241]), (100, [0.13403, 0.16081])] {
        for (d, p) in critical.into_iter().zip([0.05, 0.01]) {
            let found = kolmogorov_smirnov(n, d);
            assert!((found / p - 1.0).abs() < 1e-3, "n {n}, d {d}: {found}, not {p}");
        }
    }
    // One sample is at a distance of max(u, 1 - u).
    assert!((kolmogorov_smirnov(1, 0.9) - 0.2).abs() < 1e-15);
    assert_eq!([kolmogorov_smirnov(0, 0.5), kolmogorov_smirnov(9, 0.0), kolmogorov_smirnov(9, 1.0)], [1.0, 1.0, 0.0]);
}

#[test]
fn the_limit_continues_the_sum() {
    for lambda in [0.8f64, 1.5, 2.5, 3.5, 4.5] {
        let [sum, limit] = [10_000, 10_001].map(|n| kolmogorov_smirnov(n, lambda / (n as f64).sqrt()));
        assert!((limit / sum - 1.0).abs() < 0.02, "lambda {lambda}: {sum}, then {limit}");
    }
}

#[test]
fn chances_of_even_numbers_are_even() {
    // 2000 sets of 50: a share alpha of them has a chance below alpha, within 4.5 standard errors (false once in 10^5).
    const SETS: u64 = 2000;
    let chances: Vec<f64> = (0..SETS).map(|i| kolmogorov_smirnov(50, grid(even("grid", i, 50)).distance())).collect();
    for alpha in [0.005, 0.02, 0.05, 0.1] {
        let below = chances.iter().filter(|p| **p < alpha).count() as f64;
        let (mean, error) = (SETS as f64 * alpha, (SETS as f64 * alpha * (1.0 - alpha)).sqrt());
        assert!((below - mean).abs() < 4.5 * error, "alpha {alpha}: {below}, not {mean}");
    }
}

#[test]
fn a_grid_is_never_farther_off_than_its_numbers() {
    for i in 0..50 {
        let mut numbers = even("never", i, 30);
        let found = grid(numbers.iter().copied()).distance();
        numbers.sort_by(f64::total_cmp);
        let n = numbers.len() as f64;
        let distance = numbers.iter().enumerate().map(|(i, u)| (u - i as f64 / n).max((i + 1) as f64 / n - u));
        let exact = distance.fold(0.0, f64::max);
        assert!(found <= exact && found > exact - 1.0 / HISTOGRAM_CELLS as f64, "{found}, exactly {exact}");
    }
    assert_eq!(grid([]).distance(), 0.0);
}

#[test]
fn binomial_tails_are_sums() {
    // Pascal's triangle: no logarithms, no recurrence between terms.
    let mut ways = vec![1.0f64];
    for n in 1..=30u64 {
        ways =
            (0..=n as usize).map(|k| k.checked_sub(1).map_or(0.0, |i| ways[i]) + ways.get(k).unwrap_or(&0.0)).collect();
        for share in [0.03f64, 0.5, 0.8] {
            let term = |k: u64| ways[k as usize] * share.powi(k as i32) * (1.0 - share).powi((n - k) as i32);
            for count in 0..=n {
                let up = count as f64 >= n as f64 * share;
                let tail: f64 = if up { (count..=n).map(term).sum() } else { (0..=count).map(term).sum() };
                let found = binomial(n, count, share);
                assert!((found / (2.0 * tail).min(1.0) - 1.0).abs() < 1e-11, "{count} of {n} at {share}: {found}");
            }
        }
    }
    assert_eq!(
        [binomial(5, 0, 0.0), binomial(5, 1, 0.0), binomial(5, 5, 1.0), binomial(0, 0, 0.3)],
        [1.0, 0.0, 1.0, 1.0]
    );
    // 10^-20 is told from 0: an all-right count among many.
    let far = binomial(1000, 1000, 0.95);
    assert!((far / (2.0 * 0.95f64.powi(1000)) - 1.0).abs() < 1e-9, "{far}");
}

#[test]
fn the_chi_square_bound_bounds_the_exact_chance() {
    // Every outcome of 24 samples in three cells: exact chance of each G against its bound.
    let (n, chances) = (24u64, [0.05f64, 0.3, 0.65]);
    let ways = |k: u64| libm::lgamma(k as f64 + 1.0);
    let mut outcomes = Vec::new();
    for a in 0..=n {
        for b in 0..=n - a {
            let counts = [a, b, n - a - b];
            let terms = counts.iter().zip(&chances).map(|(&k, p)| k as f64 * p.ln() - ways(k));
            outcomes.push((likelihood_ratio(&counts, &chances), (ways(n) + terms.sum::<f64>()).exp()));
        }
    }
    assert!((outcomes.iter().map(|o| o.1).sum::<f64>() - 1.0).abs() < 1e-12);
    let mut least = f64::MAX;
    for (statistic, _) in &outcomes {
        let exact: f64 = outcomes.iter().filter(|o| o.0 >= statistic - 1e-9).map(|o| o.1).sum();
        let bound = likelihood_ratio_chance(*statistic, 3);
        assert!(bound >= exact * (1.0 - 1e-9), "G {statistic}: bound {bound}, exactly {exact}");
        least = least.min(bound / exact);
    }
    // It is no idle one either.
    assert!(least < 10.0, "{least}");
    assert_eq!(likelihood_ratio(&[1, 3], &[0.0, 1.0]), f64::INFINITY);
    assert_eq!(likelihood_ratio_chance(f64::INFINITY, 2), 0.0);
}
