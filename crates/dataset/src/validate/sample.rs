//! Sample: its row against file, manifest and images, and against itself when it is rendered again.

use std::borrow::Cow;
use std::sync::{Arc, Mutex, PoisonError};

use arrow_array::RecordBatch;
use output_schema::file::exr_path;
use output_schema::{ManifestFile, ManifestSample};

use super::columns::{StoredRow, stored_row};
use super::expected::DerivedSample;
use super::exposed_rows::RowComparison;
use super::finding::{Code, Finding};
use super::frame_digest::FrameDigest;
use super::outline::ScanLight;
use super::report::ValidationReport;
use super::shard::CheckedRow;
use super::shard_task::ShardTask;
use super::{duplicates, expected, exr, images, labels, outline, pixels, stack, true_rows, unlit, usefulness};
use crate::record::{AskedRows, StackFrame};
use crate::{image_path, maps_sha256, row_batch};

/// Checks one row; `listed` is what the manifest says about it, `exr` its EXR file, where that is whole. What later checks
/// need, where the row can be read.
pub(super) fn check(
    task: &ShardTask,
    batch: &RecordBatch,
    file: &ManifestFile,
    listed: Option<&ManifestSample>,
    exr: Option<&[u8]>,
    report: &mut ValidationReport,
) -> Option<CheckedRow> {
    report.samples += 1;
    let row = match stored_row(batch, task.head) {
        Ok(row) => row,
        Err(what) => {
            report.faults.push(Finding::new(Code::NumberMissing, &file.path, what));
            return None;
        }
    };
    let place = format!("{}, sample {}", file.path, row.index);
    let Some(listed) = listed else {
        let what = format!("index {} is not the next one of this split in the manifest", row.index);
        report.faults.push(Finding::new(Code::IndexOrder, place, what));
        return None;
    };
    if row.index != listed.index as i64 {
        let what = format!("index {} stands where the manifest has {}", row.index, listed.index);
        report.faults.push(Finding::new(Code::IndexOrder, &place, what));
        return None;
    }
    let expected = task.expect.map(|expect| expect(listed.index));
    if let Some(expected) = &expected {
        expected::numbers(&row, task.head, expected, &place, report);
    }
    let mut decoded = images::check(&row, &task.head.images, &place, report);
    let cols = row.cols.max(1) as usize;
    // A sample that is rendered again is compared as a whole.
    let derive = task.derive.filter(|_| !task.chosen.contains(&listed.index));
    let mut asked = task.rows.map_or_else(AskedRows::default, |rows| rows.of(task.head, listed.index));
    if derive.is_some() {
        let of_file = || exr.and_then(|bytes| exr::label(bytes, task.head));
        let label = decoded.get("label").map(Cow::Borrowed).or_else(|| of_file().map(Cow::Owned));
        asked.unlit = label.map_or_else(Vec::new, |label| object_ends(&label, cols));
    }
    let frames = Mutex::new(Vec::new());
    let take = |frame: StackFrame| {
        let digest = FrameDigest::of(listed.index, frame.profile.into(), &frame.dn);
        frames.lock().unwrap_or_else(PoisonError::into_inner).push(digest);
    };
    let derived = derive.map(|derive| derive(listed.index, &asked, &take));
    let frames = frames.into_inner().unwrap_or_else(PoisonError::into_inner);
    let (mut rows, mut exposed, mut scale) = (Vec::new(), Vec::new(), [0.0; 2]);
    if let Some(DerivedSample { unlit, exposed: lit }) = derived {
        unlit::check(&row, &unlit, &place, report);
        scale = [unlit.grid[2], unlit.grid[3]];
        (rows, exposed) = (unlit.rows, lit);
    }
    report.frames += frames.len() as u64;
    report.unexposed += u64::from(exposed.is_empty() && !task.chosen.contains(&listed.index));
    // What the manifest lists was compared with the recipe where there is one.
    let named = expected.as_ref().map_or([&listed.id, &listed.split, &listed.class], |e| [&e.id, &e.split, &e.class]);
    numbers(task, &row, named, &place, report);
    let mut comparison = RowComparison::new(&exposed, task.head);
    comparison.images(cols, &decoded, task.head, scale);
    if let Some(bytes) = exr {
        let path = exr_path(task.number, &listed.id);
        exr::check(bytes, task, &row, (&mut decoded, &rows, &mut comparison), &path, report);
    }
    comparison.tell(&place, report);
    let turned = task.head.recipe.canonical["motion"]["kind"] == "turntable";
    labels::check(&row, &task.head.label_values, turned, &decoded, &place, report);
    pixels::instances(&row, &decoded, &place, report);
    usefulness::check(task, &row, &decoded, &place, report);
    // The thesis' method lets light out beyond the object's edges.
    if !task.is_exact() && task.head.recipe.canonical["transport"]["model"] != "thesis" {
        let light = ScanLight {
            second_line: task.head.recipe.canonical["laser"]["second_line_mm"] != 0.0,
            most_dn: task.head.images.most_dn(),
            saturated_share: row.shares.as_ref().map(|shares| shares.saturated),
        };
        outline::check(cols, &light, &decoded, &place, report);
    }
    true_rows::labels(&rows, cols, &decoded, &place, report);
    if exposed.is_empty() && task.head.range_unit() == "mm" {
        let scale = [row.range_offset, row.range_scale];
        true_rows::range(&rows, (cols, scale, task.head.images.most_dn()), &decoded, &place, report);
    }
    // A copy differs in every row that is exposed again.
    let print = if task.rows.is_none() { duplicates::print(cols, &decoded, &row.numbers) } else { None };
    let complete = exr.is_some() || task.head.images.exr.is_empty();
    let png = row.png.iter().map(|(name, bytes)| (name.as_str(), bytes.as_slice()));
    if complete && maps_sha256(png, exr) != listed.sha256 {
        report.faults.push(Finding::new(Code::SampleChecksum, &place, "its maps are not those of the manifest"));
    }
    if task.chosen.contains(&listed.index) {
        rerender(task, batch, exr, listed.index, &place, report);
    }
    Some(CheckedRow { index: listed.index, split: row.split, print: print.map(Box::new), frames })
}

/// The first and the last row of a label image that show the object, with the row before and the row behind.
fn object_ends(label: &[u16], cols: usize) -> Vec<usize> {
    let shows = |row: &[u16]| row.iter().any(|class| *class != 0);
    let ends = label.chunks(cols).position(shows).zip(label.chunks(cols).rposition(shows));
    ends.map_or_else(Vec::new, |(first, last)| vec![first.saturating_sub(1), first, last, last + 1])
}

/// `named` are the id, split and class that it should say.
fn numbers(task: &ShardTask, row: &StoredRow, named: [&String; 3], place: &str, report: &mut ValidationReport) {
    let mut fault = |code, what: String| report.faults.push(Finding::new(code, place, what));
    let head = task.head;
    let [id, split, class] = named;
    if (&row.id, &row.split, row.seed) != (id, split, head.seed) {
        let said = format!("id {}, split {}, seed {}", row.id, row.split, row.seed);
        fault(Code::RowDiffers, format!("it says {said}, it should be id {id}, split {split}, seed {}", head.seed));
    }
    for (name, path) in row.paths.iter().filter(|(name, path)| *path != image_path(&row.id, name)) {
        fault(Code::RowDiffers, format!("`{name}.path` is {path}, not {}", image_path(&row.id, name)));
    }
    match usize::try_from(row.class).ok().and_then(|class| head.classes.get(class)) {
        None => fault(Code::ClassUnknown, format!("class {} is none of {:?}", row.class, head.classes)),
        Some(name) if name != class => {
            fault(Code::RowDiffers, format!("it is of class {name}, it should be {class}"));
        }
        Some(_) => {}
    }
    if (i64::from(row.cols), i64::from(row.rows)) != (head.images.cols as i64, head.images.rows as i64) {
        let (cols, rows) = (head.images.cols, head.images.rows);
        fault(Code::ValueRange, format!("it has {} columns and {} rows, not {cols} and {rows}", row.cols, row.rows));
    }
    for (name, value) in [("row_mm", row.row_mm), ("col_mm", row.col_mm), ("range_scale", row.range_scale)] {
        if !(value > 0.0 && value.is_finite()) {
            fault(Code::ValueRange, format!("{name} is {value}"));
        }
    }
    let drawn = head.parameters.iter().map(|number| number.path()).zip(row.numbers.iter().copied());
    let derived = row.derived.iter().map(|(name, value)| (name.clone(), *value));
    for (name, value) in drawn.chain(derived).filter(|(_, value)| !value.is_finite()) {
        fault(Code::ValueRange, format!("{name} is {value}"));
    }
    if !row.range_offset.is_finite() {
        fault(Code::ValueRange, format!("range_offset is {}", row.range_offset));
    }
}

fn rerender(
    task: &ShardTask,
    stored: &RecordBatch,
    exr: Option<&[u8]>,
    index: u64,
    place: &str,
    report: &mut ValidationReport,
) {
    let Some(render) = task.rerender else { return };
    report.rerendered += 1;
    let schema = Arc::new(output_schema::arrow::row_schema(task.head));
    let again = render(index).and_then(|sample| Ok((row_batch(&schema, task.head, &sample)?, sample)));
    let (row, sample) = match again {
        Ok(again) => again,
        Err(what) => return report.faults.push(Finding::new(Code::RerenderFailed, place, what)),
    };
    let names = schema.fields().iter().map(|field| field.name());
    let mut other: Vec<&str> =
        names.filter(|name| row.column_by_name(name) != stored.column_by_name(name)).map(String::as_str).collect();
    if sample.exr.as_deref() != exr {
        other.push("EXR file");
    }
    if task.head.images.stack_every.is_some() && stack::frames(task, index) != Ok(sample.stack) {
        other.push("sensor frames");
    }
    if !other.is_empty() {
        report.faults.push(Finding::new(Code::RerenderDiffers, place, format!("not the same: {}", other.join(", "))));
    }
}
