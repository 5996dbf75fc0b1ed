//! Hypothesis tests: the normal distribution, and exact tests of whether numbers follow a law.
//!
//! Every p-value is exact or an upper bound at any number of samples, and keeps its relative precision far out, where
//! families of tests need it. A test that is made 200 times and may be wrong once in 10^6 asks for tails of 10^-9, of
//! which no limit theorem says anything.

mod count_tests;
mod kolmogorov_smirnov;
mod normal;

pub use self::count_tests::{binomial, likelihood_ratio, likelihood_ratio_chance};
pub use self::kolmogorov_smirnov::{HISTOGRAM_CELLS, UnitHistogram, kolmogorov_smirnov};
pub use self::normal::{normal_below, normal_quantile};
