//! Sensor frames: every kept profile of every sample, in order.

use std::collections::HashMap;

use arrow_array::RecordBatch;
use arrow_array::cast::AsArray;
use arrow_array::types::{Int32Type, Int64Type};
use output_schema::arrow::stack_schema;
use output_schema::file::stack_path;
use output_schema::{DatasetHead, Manifest, ManifestFile, SCHEMA_VERSION};

use super::duplicates::sum;
use super::finding::{Code, Finding};
use super::frame_digest::{self, FrameDigest};
use super::report::ValidationReport;
use super::shard_task::ShardTask;
use crate::record::StackFrame;
use crate::{TableBounds, check_lengths, enclosed, frame_numbers, largest};

/// Blank frames of a shard that are exposed again.
const MAX_BLANK_AGAIN: usize = 8;

/// Checks the sensor frames of a shard: every so-many-th of the profiles of each sample, as the recipe says; those that are to be
/// compared with what is exposed again.
pub(super) fn check(
    task: &ShardTask,
    manifest: &Manifest,
    file: &ManifestFile,
    report: &mut ValidationReport,
) -> Vec<FrameDigest> {
    let mut fault = |code, what: String| report.faults.push(Finding::new(code, &file.path, what));
    match read(task, &file.path) {
        Ok((rows, asked)) => {
            order(&rows, task.head, manifest, file, &mut fault);
            blank(&rows, task, &file.path, report);
            asked
        }
        Err((code, what)) => {
            fault(code, what);
            Vec::new()
        }
    }
}

/// The frames are there, in order, and each has a content of its own.
fn order(
    rows: &[FrameRow],
    head: &DatasetHead,
    manifest: &Manifest,
    file: &ManifestFile,
    fault: &mut dyn FnMut(Code, String),
) {
    content(rows, head, fault);
    if file.rows != Some(rows.len() as u64) {
        fault(Code::RowCount, format!("it has {} rows, its manifest says {:?}", rows.len(), file.rows));
    }
    // `stack_every` is checked by the caller; a step of 1 keeps the rule harmless without it.
    let step = head.images.stack_every.unwrap_or(1) as i64;
    let mut rows = rows.iter().peekable();
    let mut counts = Vec::new();
    for sample in &manifest.samples {
        let mut count = 0;
        while let Some(FrameRow { key: (id, _, profile), .. }) = rows.next_if(|row| row.key.1 == sample.index as i64) {
            if *id != sample.id || *profile != count * step {
                return fault(
                    Code::StackDiffers,
                    format!("sample {}: frame {count} is profile {profile} of {id}", sample.index),
                );
            }
            count += 1;
        }
        counts.push(count);
    }
    if let Some(FrameRow { key: (id, index, profile), .. }) = rows.next() {
        fault(Code::StackDiffers, format!("profile {profile} of sample {index} ({id}) is out of order"));
    }
    // A recipe that is none is told elsewhere.
    let profiles = head.recipe.canonical["scan"]["profiles"].as_u64();
    let kept = profiles.map(|profiles| profiles.div_ceil(step.max(1) as u64) as i64).or(counts.first().copied());
    let other = manifest.samples.iter().zip(&counts).find(|(_, count)| Some(**count) != kept || **count == 0);
    if let Some((sample, count)) = other {
        let what = format!("sample {} has {count} frames, not {}", sample.index, kept.unwrap_or_default());
        fault(Code::StackDiffers, what);
    }
}

/// Id, index and profile of each row.
type Key = (String, i64, i64);

/// A row without its pixels.
struct FrameRow {
    key: Key,
    /// Of all pixels.
    sum: u64,
    least: u16,
    most: u16,
}

/// Noise makes each frame the only one of its kind; no number is beyond the converter's greatest.
fn content(rows: &[FrameRow], head: &DatasetHead, fault: &mut dyn FnMut(Code, String)) {
    let mut first: HashMap<u64, &Key> = HashMap::new();
    for row in rows {
        let (id, index, profile) = &row.key;
        let frame = format!("profile {profile} of sample {index} ({id})");
        if row.most > head.images.most_dn() {
            fault(Code::ValueRange, format!("{frame} has {} DN, beyond {}", row.most, head.images.most_dn()));
        }
        let before = *first.entry(row.sum).or_insert(&row.key);
        if *before != row.key && row.least < row.most {
            let what = format!("{frame} has the pixels of profile {} of sample {} ({})", before.2, before.1, before.0);
            fault(Code::StackRepeated, what);
        }
    }
}

/// A frame of nothing is a fault unless it is one when it is exposed again: where little light comes and the dark level
/// is 0, some are. Where none can be exposed it is looked at.
fn blank(rows: &[FrameRow], task: &ShardTask, path: &str, report: &mut ValidationReport) {
    let blank: Vec<&Key> = rows.iter().filter(|row| row.most == 0).map(|row| &row.key).collect();
    let is_blank = |(_, index, profile): &&Key| {
        let made = task.exposed_again(index.unsigned_abs(), profile.unsigned_abs());
        made.is_some_and(|frame| frame.dn.iter().all(|dn| *dn == 0))
    };
    // The first tell of all of them.
    if task.is_exact() && blank.iter().take(MAX_BLANK_AGAIN).all(is_blank) {
        return;
    }
    let what = |(id, index, profile): &Key| format!("profile {profile} of sample {index} ({id}) is 0 everywhere");
    for key in blank {
        report.tell(task.is_exact(), Finding::new(Code::StackBlank, path, what(key)));
    }
}

/// Every row without its pixels, and the frames that are to be compared.
fn read(task: &ShardTask, path: &str) -> Result<(Vec<FrameRow>, Vec<FrameDigest>), (Code, String)> {
    let head = task.head;
    let unreadable = |e: String| (Code::TableUnreadable, e);
    let file = enclosed::open(task.root, path, largest::stack_bytes(head)).map_err(|e| unreadable(e.to_string()))?;
    let builder = TableBounds::of_frames(head).open(file, &|_| true).map_err(unreadable)?;
    if head.schema_version == SCHEMA_VERSION && **builder.schema() != stack_schema(head) {
        return Err((Code::SchemaDiffers, "its columns are not those that are declared".into()));
    }
    let (mut rows, mut asked) = (Vec::new(), Vec::new());
    // Frames of a sample follow on each other.
    let (mut sample, mut profiles) = (None, Vec::new());
    for batch in builder.with_batch_size(8).build().map_err(|e| unreadable(e.to_string()))? {
        let batch = batch.map_err(|e| unreadable(e.to_string()))?;
        check_lengths(&batch).map_err(unreadable)?;
        let wrong = || unreadable("a column has another type".into());
        let mut keys = Vec::new();
        keys_of(&batch, &mut keys).ok_or_else(wrong)?;
        let frames = batch.column(3).as_fixed_size_list_opt().ok_or_else(wrong)?;
        for (i, key) in keys.into_iter().enumerate() {
            let dn = frame_numbers(&frames.value(i)).ok_or_else(wrong)?;
            if sample != Some(key.1) {
                (sample, profiles) = (Some(key.1), frame_digest::asked(task, key.1));
            }
            if usize::try_from(key.2).is_ok_and(|profile| profiles.binary_search(&profile).is_ok()) {
                asked.push(FrameDigest::of(key.1.unsigned_abs(), key.2.unsigned_abs(), &dn));
            }
            let (least, most) = (dn.iter().min().copied(), dn.iter().max().copied());
            let row = FrameRow { key, sum: sum(&dn), least: least.unwrap_or(0), most: most.unwrap_or(0) };
            rows.push(row);
        }
    }
    Ok((rows, asked))
}

/// The sensor frames of one sample.
///
/// # Errors
/// Why they cannot be read.
pub(super) fn frames(task: &ShardTask, index: u64) -> Result<Vec<StackFrame>, String> {
    let file = enclosed::open(task.root, &stack_path(task.number), largest::stack_bytes(task.head));
    let file = file.map_err(|e| e.to_string())?;
    let builder = TableBounds::of_frames(task.head).open(file, &|_| true)?;
    let mut frames = Vec::new();
    for batch in builder.with_batch_size(8).build().map_err(|e| e.to_string())? {
        let batch = batch.map_err(|e| e.to_string())?;
        let mut keys = Vec::new();
        keys_of(&batch, &mut keys).ok_or("a column has another type")?;
        let tensors = batch.column(3).as_fixed_size_list_opt().ok_or("the frames are no tensors")?;
        for (i, (.., profile)) in keys.iter().enumerate().filter(|(_, key)| key.1 == index as i64) {
            let pixels = tensors.value(i);
            let dn = frame_numbers(&pixels).ok_or("the frames are neither uint8 nor uint16")?;
            frames.push(StackFrame { profile: *profile as u32, dn });
        }
    }
    Ok(frames)
}

fn keys_of(batch: &RecordBatch, keys: &mut Vec<Key>) -> Option<()> {
    let id = batch.column(0).as_string_opt::<i32>()?;
    let index = batch.column(1).as_primitive_opt::<Int64Type>()?;
    let profile = batch.column(2).as_primitive_opt::<Int32Type>()?;
    keys.extend((0..batch.num_rows()).map(|i| (id.value(i).into(), index.value(i), profile.value(i).into())));
    Some(())
}
