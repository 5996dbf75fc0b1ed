//! Numbers of a row lie in their ranges. Those of objects, images, channels, shares and sensor frames are told with
//! this code where they are read.

use super::{Code, REMAKE_OR_REPORT, Rule, SampleToCheck, ValidationReport};

pub(super) const RULE: Rule = Rule { meaning: "A number is outside of its range.", remedy: REMAKE_OR_REPORT };

pub(super) fn check(sample: &SampleToCheck, report: &mut ValidationReport) {
    let (head, row) = (sample.task.head, &sample.row);
    let mut fault = |what: String| report.fault(Code::ValueRange, &sample.place, what);
    if (i64::from(row.cols), i64::from(row.rows)) != (head.images.cols as i64, head.images.rows as i64) {
        let (cols, rows) = (head.images.cols, head.images.rows);
        fault(format!("it has {} columns and {} rows, not {cols} and {rows}", row.cols, row.rows));
    }
    for (name, value) in [("row_mm", row.row_mm), ("col_mm", row.col_mm), ("range_scale", row.range_scale)] {
        if !(value > 0.0 && value.is_finite()) {
            fault(format!("{name} is {value}"));
        }
    }
    let drawn = head.parameters.iter().map(|number| number.path()).zip(row.numbers.iter().copied());
    let derived = row.derived.iter().map(|(name, value)| (name.clone(), *value));
    for (name, value) in drawn.chain(derived).filter(|(_, value)| !value.is_finite()) {
        fault(format!("{name} is {value}"));
    }
    if !row.range_offset.is_finite() {
        fault(format!("range_offset is {}", row.range_offset));
    }
}
