//! Laws of numbers: the law of one number, and the normal distribution.

mod normal;

pub use self::normal::{normal_below, normal_quantile};

/// Cumulative distribution function of a law.
pub(crate) type DistributionFunction = Box<dyn Fn(f64) -> f64 + Send + Sync>;

/// How one number is drawn.
pub enum DrawLaw {
    /// Always the same.
    Fixed(f64),
    /// One of some numbers, ascending, each with its chance above 0; the chances sum to 1.
    Discrete(Vec<(f64, f64)>),
    /// Any number between two.
    Continuous {
        /// Smallest.
        min: f64,
        /// Largest.
        max: f64,
        /// The distribution function: 0 at the smallest, 1 at the largest.
        cdf: DistributionFunction,
    },
}
