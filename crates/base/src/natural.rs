//! Natural variation: how a number differs between the rigs, logs, batches or samples of good installations.
//!
//! It is declared beside the default that it contains, from the same source. Where that tells no spread, the word
//! `spread` in it marks whose estimate the numbers are. What cannot be known from outside is fixed: what is built or
//! chosen, effects that are off, and counts of defects, which classes say.

/// The distribution that a number has where no recipe says it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Natural {
    /// None: it is the default.
    Fixed,
    /// Even between two numbers; of counts, every whole number as often.
    Uniform {
        /// Smallest.
        min: f64,
        /// Largest.
        max: f64,
    },
    /// Even in the logarithm.
    LogUniform {
        /// Smallest, above 0.
        min: f64,
        /// Largest.
        max: f64,
    },
    /// Gaussian, cut at two standard deviations.
    Normal {
        /// Mean.
        mean: f64,
        /// Standard deviation before the cut, above 0.
        sd: f64,
    },
    /// Some numbers, in rising order, each as often as another.
    OneOf(&'static [f64]),
}

impl Natural {
    /// Where a normal one is cut [standard deviations].
    pub const CUT_SD: f64 = 2.0;

    /// Smallest and largest number that comes; `None` where it is fixed.
    pub fn ends(&self) -> Option<[f64; 2]> {
        match *self {
            Self::Fixed => None,
            Self::Uniform { min, max } | Self::LogUniform { min, max } => Some([min, max]),
            Self::Normal { mean, sd } => Some([mean - Self::CUT_SD * sd, mean + Self::CUT_SD * sd]),
            Self::OneOf(values) => Some([*values.first()?, *values.last()?]),
        }
    }
}
