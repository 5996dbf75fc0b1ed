//! The sensor frames of each sample are those that the recipe keeps, in order.

use output_schema::{DatasetHead, Manifest};

use super::{Code, REMAKE_OR_REPORT, Rule, ValidationReport};
use crate::validate::stored_frames::FrameRow;

pub(super) const RULE: Rule =
    Rule { meaning: "The sensor frames are not those that the recipe keeps.", remedy: REMAKE_OR_REPORT };

pub(in crate::validate) fn check(
    rows: &[FrameRow],
    head: &DatasetHead,
    manifest: &Manifest,
    path: &str,
    report: &mut ValidationReport,
) {
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
