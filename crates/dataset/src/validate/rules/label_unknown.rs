//! Every label is a pixel class of the dataset's subject.

use super::{Code, REMAKE_OR_REPORT, Rule, SampleToCheck, ValidationReport};
use crate::validate::decoded_images::DecodedImages;

pub(super) const RULE: Rule = Rule { meaning: "A label that is no pixel class.", remedy: REMAKE_OR_REPORT };

/// The first label of an image that is none of `values`.
pub(in crate::validate) fn unknown(images: &DecodedImages, values: &[u8]) -> Option<u16> {
    let mut known = [false; 256];
    values.iter().for_each(|&value| known[usize::from(value)] = true);
    let is_known = |class: u16| known.get(usize::from(class)).is_some_and(|known| *known);
    images.get("label")?.iter().copied().find(|&class| !is_known(class))
}

pub(super) fn check(sample: &SampleToCheck, report: &mut ValidationReport) {
    if let Some(class) = sample.unknown_label {
        let what = format!("the label {class} is no pixel class of the subject");
        report.fault(Code::LabelUnknown, &sample.place, what);
    }
}
