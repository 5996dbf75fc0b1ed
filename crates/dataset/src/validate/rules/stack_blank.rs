//! A sensor frame of nothing is a fault unless it is one when it is exposed again: where little light comes and the
//! dark level is 0, some are. Where none can be exposed it is looked at.

use super::{Code, REMAKE_OR_REPORT, Rule, ValidationReport};
use crate::validate::shard_task::ShardTask;
use crate::validate::stored_frames::FrameRow;

pub(super) const RULE: Rule = Rule {
    meaning: "A sensor frame is 0 everywhere, and is not when it is exposed again; a warning where it cannot be.",
    remedy: REMAKE_OR_REPORT,
};
/// Blank frames of a shard that are exposed again.
const MAX_BLANK_AGAIN: usize = 8;

pub(in crate::validate) fn check(rows: &[FrameRow], task: &ShardTask, path: &str, report: &mut ValidationReport) {
    let blank: Vec<&FrameRow> = rows.iter().filter(|row| row.most == 0).collect();
    let is_blank = |row: &&FrameRow| {
        let made = task.exposed_again(row.key.1.unsigned_abs(), row.key.2.unsigned_abs());
        made.is_some_and(|frame| frame.dn.iter().all(|dn| *dn == 0))
    };
    // The first tell of all of them.
    if task.is_exact() && blank.iter().take(MAX_BLANK_AGAIN).all(is_blank) {
        return;
    }
    for row in blank {
        report.tell(task.is_exact(), Code::StackBlank, path, format!("{} is 0 everywhere", row.name()));
    }
}
