//! The area of each class that a row gives is what its label image shows; all of them together are the image.

use base::Class;

use super::{Code, REMAKE_OR_REPORT, Rule, SampleToCheck, ValidationReport};

pub(super) const RULE: Rule =
    Rule { meaning: "The area of a class is not what the label image shows.", remedy: REMAKE_OR_REPORT };

pub(super) fn check(sample: &SampleToCheck, report: &mut ValidationReport) {
    let SampleToCheck { row, place, .. } = sample;
    let (cols, rows) = (i64::from(row.cols), i64::from(row.rows));
    if row.class_area_px.iter().sum::<i64>() != cols * rows {
        let what = format!("the areas {:?} are not {cols} x {rows} pixels", row.class_area_px);
        report.fault(Code::ClassAreaDiffers, place, what);
    }
    let Some(label) = sample.images.get("label").filter(|_| sample.unknown_label.is_none()) else { return };
    let mut areas = vec![0i64; Class::ALL.len()];
    label.iter().for_each(|&class| areas[usize::from(class)] += 1);
    let shown: Vec<i64> = sample.task.head.label_values.iter().map(|&value| areas[usize::from(value)]).collect();
    if shown != row.class_area_px {
        let what = format!("the label image shows {shown:?} pixels, the row says {:?}", row.class_area_px);
        report.fault(Code::ClassAreaDiffers, place, what);
    }
}
