//! Splits of a dataset: training, validation and test.

/// Which part of the dataset a sample belongs to.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Split {
    /// For training.
    #[default]
    Train,
    /// For choosing.
    Validation,
    /// For the last word.
    Test,
}

impl Split {
    /// Every split in the order of files.
    pub const ALL: [Self; 3] = [Self::Train, Self::Validation, Self::Test];

    /// Name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Train => "train",
            Self::Validation => "validation",
            Self::Test => "test",
        }
    }
}
