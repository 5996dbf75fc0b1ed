//! Noise makes each sensor frame the only one of its kind.

use std::collections::HashMap;

use super::{Code, REMAKE_OR_REPORT, Rule, ValidationReport};
use crate::validate::stored_frames::FrameRow;

pub(super) const RULE: Rule =
    Rule { meaning: "Two sensor frames have the same pixels, noise and all.", remedy: REMAKE_OR_REPORT };

pub(in crate::validate) fn check(rows: &[FrameRow], path: &str, report: &mut ValidationReport) {
    let mut first: HashMap<u64, &FrameRow> = HashMap::new();
    for row in rows {
        let before = *first.entry(row.sum).or_insert(row);
        if before.key != row.key && row.least < row.most {
            let what = format!("{} has the pixels of {}", row.name(), before.name());
            report.fault(Code::StackRepeated, path, what);
        }
    }
}
