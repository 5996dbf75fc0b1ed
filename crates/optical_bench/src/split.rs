//! Splits of a dataset: training, validation and test.

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
