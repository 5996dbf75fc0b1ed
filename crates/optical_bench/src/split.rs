//! Splits of a dataset: training, validation and test; and the groups that they do not part.

use base::words;

words! {
    /// Which part of the dataset a sample belongs to.
    #[derive(Default, PartialOrd, Ord, Hash)]
    Split {
        /// For training.
        #[default]
        Train = "train",
        /// For choosing.
        Validation = "validation",
        /// For the last word.
        Test = "test",
    }
}

/// Which instrument, log and batch a sample has, by their numbers from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SampleGroups {
    /// Instrument.
    pub rig: u64,
    /// Log, of a board.
    pub log: Option<u64>,
    /// Batch, of other objects.
    pub batch: Option<u64>,
}
