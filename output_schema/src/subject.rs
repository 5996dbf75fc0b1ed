//! What the files of a dataset hold of each subject: the pixel classes that its labels can show.

use base::Class;

/// Every subject, as recipes and `dataset.json` call it; `background` belongs to all of them.
pub const SUBJECTS: [&str; 4] = ["wood", "blister", "sawtooth", "mesh"];

/// Values that label images of a dataset of that subject and minor version may have, in order.
pub fn label_values(subject: &str, minor: u32) -> Vec<u8> {
    let own = Class::of_subject(subject, minor);
    std::iter::once(Class::Background).chain(own).map(|class| class as u8).collect()
}

/// Names of the pixel classes up to the last one that such labels can show; the position is the value.
pub fn pixel_classes(subject: &str, minor: u32) -> Vec<String> {
    let last = Class::of_subject(subject, minor).last();
    Class::ALL.into_iter().take_while(|class| Some(*class) <= last).map(|class| class.name().into()).collect()
}
