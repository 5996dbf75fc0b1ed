//! Samples that are rendered again, compared byte for byte: every column, the EXR file, sensor frames. A sample that
//! cannot be rendered has a code of its own.

use std::sync::Arc;

use super::{Code, Rule, SampleToCheck, ValidationReport};
use crate::row_batch;
use crate::validate::stored_frames;

pub(super) const FAILED: Rule = Rule {
    meaning: "A sample could not be rendered again.",
    remedy: "validate with the recipe and program version of dataset.json",
};
pub(super) const DIFFERS: Rule = Rule {
    meaning: "A sample that was rendered again is not what is on disk.",
    remedy: "use the same program version and target; if they are the same, report it",
};

pub(super) fn check(sample: &SampleToCheck, report: &mut ValidationReport) {
    let SampleToCheck { task, place, batch: stored, exr, .. } = sample;
    let (index, chosen) = (sample.listed.index, sample.is_chosen());
    let Some(render) = task.rerender.filter(|_| chosen) else { return };
    report.rerendered += 1;
    let schema = Arc::new(output_schema::arrow::row_schema(task.head));
    let again = render(index).and_then(|sample| Ok((row_batch(&schema, task.head, &sample)?, sample)));
    let (row, made) = match again {
        Ok(again) => again,
        Err(what) => return report.fault(Code::RerenderFailed, place, what),
    };
    let names = schema.fields().iter().map(|field| field.name());
    let mut other: Vec<&str> =
        names.filter(|name| row.column_by_name(name) != stored.column_by_name(name)).map(String::as_str).collect();
    if made.exr.as_deref() != *exr {
        other.push("EXR file");
    }
    if task.head.images.stack_every.is_some() && stored_frames::frames(task, index) != Some(made.stack) {
        other.push("sensor frames");
    }
    if !other.is_empty() {
        report.fault(Code::RerenderDiffers, place, format!("not the same: {}", other.join(", ")));
    }
}
