//! Histograms with a fixed number of bins, one count for each class of the recipe.

/// Bins of a histogram.
pub(super) const MAX_BINS: usize = 24;

/// Drawn numbers that are no farther apart, of the larger one, differ by rounding alone [1].
pub(super) const DRAWN_ROUNDING: f64 = 1e-9;
/// The same of derived numbers, which are sums of up to thousands of terms in single precision [1].
pub(super) const DERIVED_ROUNDING: f64 = 1e-5;

/// What is known of a number before its bins are counted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RunningRange {
    /// Smallest.
    pub min: f64,
    /// Largest.
    pub max: f64,
    /// Sum.
    pub sum: f64,
    /// How many.
    pub count: u64,
    /// How many are missing.
    pub missing: u64,
    /// Whether all are whole numbers.
    pub whole: bool,
}

impl Default for RunningRange {
    fn default() -> Self {
        Self { min: f64::INFINITY, max: f64::NEG_INFINITY, sum: 0.0, count: 0, missing: 0, whole: true }
    }
}

impl RunningRange {
    /// Takes a number; what is not finite counts as missing.
    pub fn add(&mut self, value: f64) {
        if !value.is_finite() {
            self.missing += 1;
            return;
        }
        (self.min, self.max) = (self.min.min(value), self.max.max(value));
        self.sum += value;
        self.count += 1;
        self.whole &= value == value.round();
    }

    /// Mean; `None` where there is none.
    pub fn mean(&self) -> Option<f64> {
        (self.count > 0).then(|| self.sum / self.count as f64)
    }

    /// Whether there is one value alone, but for `rounding`, as [`DRAWN_ROUNDING`] or [`DERIVED_ROUNDING`] numbers have
    /// it [1].
    pub(crate) fn is_constant(&self, rounding: f64) -> bool {
        self.count > 0 && self.max - self.min <= rounding * self.min.abs().max(self.max.abs())
    }
}

/// How numbers are laid along a histogram.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum HistogramAxis {
    /// Evenly.
    Linear(f64, f64),
    /// Evenly in the logarithm.
    Log(f64, f64),
    /// A bin for each whole number, or for as many of them as it takes.
    Whole(f64, f64),
}

impl HistogramAxis {
    /// For numbers from `min` to `max`.
    pub fn new(min: f64, max: f64, whole: bool, log: bool) -> Self {
        if whole && max - min < MAX_BINS as f64 {
            Self::Whole(min, max)
        } else if log && min > 0.0 {
            Self::Log(min, max)
        } else {
            Self::Linear(min, max)
        }
    }

    /// Bins of a histogram.
    pub fn bins(self) -> usize {
        match self {
            Self::Whole(min, max) => (max - min) as usize + 1,
            _ => MAX_BINS,
        }
    }

    /// Where a number lies, 0 at the left end and 1 at the right one.
    pub fn place(self, value: f64) -> f64 {
        let share = match self {
            Self::Linear(min, max) => (value - min) / (max - min),
            Self::Log(min, max) => libm::log(value / min) / libm::log(max / min),
            Self::Whole(min, max) => (value - min + 0.5) / (max - min + 1.0),
        };
        if share.is_finite() { share } else { 0.5 }
    }

    /// The number at a place.
    pub fn value(self, place: f64) -> f64 {
        match self {
            Self::Linear(min, max) => min + place * (max - min),
            Self::Log(min, max) => min * libm::exp(place * libm::log(max / min)),
            Self::Whole(min, max) => min - 0.5 + place * (max - min + 1.0),
        }
    }
}

/// A histogram.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Histogram {
    /// Along it.
    pub axis: HistogramAxis,
    /// Counts `[classes, bins]`.
    pub counts: Vec<Vec<u64>>,
}

impl Histogram {
    /// An empty histogram for `classes` classes.
    pub fn new(axis: HistogramAxis, classes: usize) -> Self {
        Self { axis, counts: vec![vec![0; axis.bins()]; classes.max(1)] }
    }

    /// Takes a number of a sample of `class`; what is not finite is left out.
    pub fn add(&mut self, class: usize, value: f64) {
        if !value.is_finite() {
            return;
        }
        let n = self.axis.bins();
        let cell = ((self.axis.place(value) * n as f64).max(0.0) as usize).min(n - 1);
        if let Some(counts) = self.counts.get_mut(class) {
            counts[cell] += 1;
        }
    }

    /// Highest column.
    pub fn most(&self) -> u64 {
        (0..self.axis.bins()).map(|cell| self.counts.iter().map(|c| c[cell]).sum()).max().unwrap_or(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What differs in its last digits alone is one value; what differs by little is not.
    #[test]
    fn rounding_is_no_variety() {
        let within = |values: &[f64], rounding: f64| {
            let mut extent = RunningRange::default();
            values.iter().for_each(|value| extent.add(*value));
            extent.is_constant(rounding)
        };
        let of = |values: &[f64]| within(values, DRAWN_ROUNDING);
        assert!(within(&[185.6003, 185.6011], DERIVED_ROUNDING) && !within(&[185.6003, 185.61], DERIVED_ROUNDING));
        assert!(of(&[185.6, 185.6 + 2e-14, 185.6 - 2e-14]) && of(&[0.0, 0.0]) && of(&[-3.0, -3.0 - 1e-15, f64::NAN]));
        assert!(!of(&[185.6, 185.600_01]) && !of(&[0.0, 1e-12]) && !of(&[-1.0, 1.0]) && !of(&[f64::NAN]));
    }

    /// Every number lands in the cell whose ends enclose it, the largest in the last one.
    #[test]
    fn numbers_land_in_their_cells() {
        for axis in [HistogramAxis::Linear(-2.0, 3.0), HistogramAxis::Log(0.1, 40.0), HistogramAxis::Whole(2.0, 6.0)] {
            let n = axis.bins();
            let mut cells = Histogram::new(axis, 2);
            for cell in 0..n {
                cells.add(1, axis.value((cell as f64 + 0.5) / n as f64));
            }
            assert_eq!(cells.counts[1], vec![1; n]);
            assert_eq!(cells.counts[0], vec![0; n]);
            cells.add(0, axis.value(1.0));
            cells.add(0, f64::NAN);
            assert_eq!((cells.counts[0][n - 1], cells.most()), (1, 2));
        }
    }
}
