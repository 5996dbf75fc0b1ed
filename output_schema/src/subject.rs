//! What the files of a dataset hold of each subject: the pixel classes that its labels can show.

use crate::row::PIXEL_CLASSES;

/// The declaration of one subject.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SubjectFiles {
    /// Name in recipes and in `dataset.json`.
    pub name: &'static str,
    /// First pixel class of its own.
    pub first: u8,
    /// Last pixel class of its own.
    pub last: u8,
}

/// Every subject; `background` belongs to all of them.
pub const SUBJECTS: [SubjectFiles; 4] = [
    SubjectFiles { name: "wood", first: 1, last: 4 },
    SubjectFiles { name: "blister", first: 5, last: 25 },
    SubjectFiles { name: "sawtooth", first: 26, last: 26 },
    SubjectFiles { name: "mesh", first: 27, last: 27 },
];

impl SubjectFiles {
    /// The subject of that name.
    pub fn named(name: &str) -> Option<Self> {
        SUBJECTS.into_iter().find(|subject| subject.name == name)
    }

    /// Values that label images may have, in order.
    pub fn label_values(self) -> Vec<u8> {
        std::iter::once(0).chain(self.first..=self.last).collect()
    }

    /// Names of the pixel classes up to the last one that its labels can show; the position is the value.
    pub fn pixel_classes(self) -> Vec<String> {
        PIXEL_CLASSES.iter().take(usize::from(self.last) + 1).map(|name| (*name).into()).collect()
    }
}
