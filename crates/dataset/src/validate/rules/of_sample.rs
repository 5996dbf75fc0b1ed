//! Every rule about one sample, in the order in which they are told.

use super::{
    SampleToCheck, ValidationReport, class_area_differs, draw_differs, instance_class, label_differs, label_unknown,
    object_differs, outline_differs, range_differs, rerender, row_differs, sample_checksum, shares, value_range,
};

/// The rules about one sample that can be read and whose images are decoded, in the order in which they are told.
const OF_SAMPLE: [fn(&SampleToCheck, &mut ValidationReport); 13] = [
    draw_differs::check,
    row_differs::check,
    value_range::check,
    label_unknown::check,
    class_area_differs::check,
    object_differs::check,
    instance_class::check,
    shares::check,
    outline_differs::check,
    label_differs::check,
    range_differs::check,
    sample_checksum::check,
    rerender::check,
];

/// Checks one sample.
pub(in crate::validate) fn check(sample: &SampleToCheck, report: &mut ValidationReport) {
    OF_SAMPLE.iter().for_each(|check| check(sample, report));
}
