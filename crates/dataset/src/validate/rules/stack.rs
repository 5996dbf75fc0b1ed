//! The sensor frames of a shard: every kept profile of every sample, in order, no two alike and none of nothing. Their
//! table is read in one pass, so these rules are one file.

use std::collections::HashMap;

use output_schema::{DatasetHead, Manifest, ManifestFile};

use super::{Code, REMAKE_OR_REPORT, Rule, ValidationReport};
use crate::validate::frame_digest::FrameDigest;
use crate::validate::shard_task::ShardTask;
use crate::validate::stored_frames::{self, FrameRow};

pub(super) const DIFFERS: Rule =
    Rule { meaning: "The sensor frames are not those that the recipe keeps.", remedy: REMAKE_OR_REPORT };
pub(super) const BLANK: Rule = Rule {
    meaning: "A sensor frame is 0 everywhere, and is not when it is exposed again; a warning where it cannot be.",
    remedy: REMAKE_OR_REPORT,
};
pub(super) const REPEATED: Rule =
    Rule { meaning: "Two sensor frames have the same pixels, noise and all.", remedy: REMAKE_OR_REPORT };
/// Blank frames of a shard that are exposed again.
const MAX_BLANK_AGAIN: usize = 8;

/// Checks the sensor frames of a shard: every so-many-th of the profiles of each sample, as the recipe says; those that
/// are to be compared with what is exposed again.
pub(in crate::validate) fn check(
    task: &ShardTask,
    manifest: &Manifest,
    file: &ManifestFile,
    report: &mut ValidationReport,
) -> Vec<FrameDigest> {
    let (rows, asked) = match stored_frames::read(task, &file.path) {
        Ok(read) => read,
        Err((code, what)) => {
            report.fault(code, &file.path, what);
            return Vec::new();
        }
    };
    let most = task.head.images.most_dn();
    for row in rows.iter().filter(|row| row.most > most) {
        report.fault(Code::ValueRange, &file.path, format!("{} has {} DN, beyond {most}", row.name(), row.most));
    }
    repeated(&rows, &file.path, report);
    if file.rows != Some(rows.len() as u64) {
        let what = format!("it has {} rows, its manifest says {:?}", rows.len(), file.rows);
        report.fault(Code::RowCount, &file.path, what);
    }
    differs(&rows, task.head, manifest, &file.path, report);
    blank(&rows, task, &file.path, report);
    asked
}

/// The sensor frames of each sample are those that the recipe keeps, in order.
fn differs(rows: &[FrameRow], head: &DatasetHead, manifest: &Manifest, path: &str, report: &mut ValidationReport) {
    let mut fault = |what: String| report.fault(Code::StackDiffers, path, what);
    // `stack_every` is checked by the caller; a step of 1 keeps the rule harmless without it.
    let step = head.images.stack_every.unwrap_or(1) as i64;
    let mut rows = rows.iter().peekable();
    let mut counts = Vec::new();
    for sample in &manifest.samples {
        let mut count = 0;
        while let Some(FrameRow { key: (id, _, profile), .. }) = rows.next_if(|row| row.key.1 == sample.index as i64) {
            if *id != sample.id || *profile != count * step {
                return fault(format!("sample {}: frame {count} is profile {profile} of {id}", sample.index));
            }
            count += 1;
        }
        counts.push(count);
    }
    if let Some(row) = rows.next() {
        fault(format!("{} is out of order", row.name()));
    }
    // A recipe that is none is told elsewhere.
    let profiles = head.recipe.canonical["scan"]["profiles"].as_u64();
    let kept = profiles.map(|profiles| profiles.div_ceil(step.max(1) as u64) as i64).or(counts.first().copied());
    let other = manifest.samples.iter().zip(&counts).find(|(_, count)| Some(**count) != kept || **count == 0);
    if let Some((sample, count)) = other {
        fault(format!("sample {} has {count} frames, not {}", sample.index, kept.unwrap_or_default()));
    }
}

/// A sensor frame of nothing is a fault unless it is one when it is exposed again: where little light comes and the
/// dark level is 0, some are. Where none can be exposed it is looked at.
fn blank(rows: &[FrameRow], task: &ShardTask, path: &str, report: &mut ValidationReport) {
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

/// Noise makes each sensor frame the only one of its kind.
fn repeated(rows: &[FrameRow], path: &str, report: &mut ValidationReport) {
    let mut first: HashMap<u64, &FrameRow> = HashMap::new();
    for row in rows {
        let before = *first.entry(row.sum).or_insert(row);
        if before.key != row.key && row.least < row.most {
            let what = format!("{} has the pixels of {}", row.name(), before.name());
            report.fault(Code::StackRepeated, path, what);
        }
    }
}
