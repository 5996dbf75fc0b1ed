//! What the files of a dataset hold of each subject: the pixel classes that its labels can show.

use crate::row::PIXEL_CLASSES;

/// A run of pixel classes, both ends included.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ClassRun {
    /// First value.
    pub first: u8,
    /// Last value.
    pub last: u8,
    /// Minor version of the schema from which on labels can show it.
    pub since: u32,
}

/// The declaration of one subject.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SubjectFiles {
    /// Name in recipes and in `dataset.json`.
    pub name: &'static str,
    /// Pixel classes of its own, by rising values. What is added later is a run of its own: values in stored labels
    /// keep their meaning.
    pub runs: &'static [ClassRun],
}

/// Every subject; `background` belongs to all of them.
pub const SUBJECTS: [SubjectFiles; 4] = [
    SubjectFiles {
        name: "wood",
        runs: &[ClassRun { first: 1, last: 4, since: 0 }, ClassRun { first: 28, last: 45, since: 5 }],
    },
    SubjectFiles { name: "blister", runs: &[ClassRun { first: 5, last: 25, since: 0 }] },
    SubjectFiles { name: "sawtooth", runs: &[ClassRun { first: 26, last: 26, since: 0 }] },
    SubjectFiles { name: "mesh", runs: &[ClassRun { first: 27, last: 27, since: 0 }] },
];

impl SubjectFiles {
    /// The subject of that name.
    pub fn named(name: &str) -> Option<Self> {
        SUBJECTS.into_iter().find(|subject| subject.name == name)
    }

    /// Whether a pixel class is one of its own.
    pub fn has(self, value: usize) -> bool {
        self.runs.iter().any(|run| (usize::from(run.first)..=run.last.into()).contains(&value))
    }

    /// Values that label images of a dataset of that minor version may have, in order.
    pub fn label_values(self, minor: u32) -> Vec<u8> {
        let runs = self.runs.iter().filter(|run| run.since <= minor);
        std::iter::once(0).chain(runs.flat_map(|run| run.first..=run.last)).collect()
    }

    /// Names of the pixel classes up to the last one that such labels can show; the position is the value.
    pub fn pixel_classes(self, minor: u32) -> Vec<String> {
        let last = self.label_values(minor).last().copied().unwrap_or(0);
        PIXEL_CLASSES.iter().take(usize::from(last) + 1).map(|name| (*name).into()).collect()
    }
}
