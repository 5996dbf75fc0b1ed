//! Stored sensor frames: read from a shard's table, with or without their pixels.

use arrow_array::cast::AsArray;
use arrow_array::types::{Int32Type, Int64Type};
use arrow_array::{ArrayRef, RecordBatch};
use output_schema::SCHEMA_VERSION;
use output_schema::arrow::stack_schema;
use output_schema::file::stack_path;

use super::frame_digest::{self, FrameDigest};
use super::rules::Code;
use super::rules::duplicates::sum;
use super::shard_task::ShardTask;
use crate::record::StackFrame;
use crate::{TableBounds, check_lengths, enclosed, frame_numbers, largest};

/// Id, index and profile of each row.
type Key = (String, i64, i64);

/// A row without its pixels.
pub(super) struct FrameRow {
    pub(super) key: Key,
    /// Of all pixels.
    pub(super) sum: u64,
    pub(super) least: u16,
    pub(super) most: u16,
}

impl FrameRow {
    /// The frame in words.
    pub(super) fn name(&self) -> String {
        let (id, index, profile) = &self.key;
        format!("profile {profile} of sample {index} ({id})")
    }
}

/// Every row without its pixels, and the frames that are to be compared.
pub(super) fn read(task: &ShardTask, path: &str) -> Result<(Vec<FrameRow>, Vec<FrameDigest>), (Code, String)> {
    let (mut rows, mut asked) = (Vec::new(), Vec::new());
    // Frames of a sample follow on each other.
    let (mut sample, mut profiles) = (None, Vec::new());
    each(task, path, &mut |key, pixels| {
        let dn = frame_numbers(pixels)?;
        if sample != Some(key.1) {
            (sample, profiles) = (Some(key.1), frame_digest::asked(task, key.1));
        }
        if usize::try_from(key.2).is_ok_and(|profile| profiles.binary_search(&profile).is_ok()) {
            asked.push(FrameDigest::of(key.1.unsigned_abs(), key.2.unsigned_abs(), &dn));
        }
        let (least, most) = (dn.iter().min().copied(), dn.iter().max().copied());
        rows.push(FrameRow { key, sum: sum(&dn), least: least.unwrap_or(0), most: most.unwrap_or(0) });
        Some(())
    })?;
    Ok((rows, asked))
}

/// The sensor frames of one sample; `None` where they cannot be read.
pub(super) fn frames(task: &ShardTask, index: u64) -> Option<Vec<StackFrame>> {
    let mut frames = Vec::new();
    each(task, &stack_path(task.number), &mut |(_, sample, profile), pixels| {
        if sample == index as i64 {
            frames.push(StackFrame { profile: profile as u32, dn: frame_numbers(pixels)? });
        }
        Some(())
    })
    .ok()?;
    Some(frames)
}

/// Hands each row of a table with its pixels to `take`, which gives `None` for pixels of another type.
fn each(
    task: &ShardTask,
    path: &str,
    take: &mut dyn FnMut(Key, &ArrayRef) -> Option<()>,
) -> Result<(), (Code, String)> {
    let head = task.head;
    let unreadable = |e: String| (Code::TableUnreadable, e);
    let file = enclosed::open(task.root, path, largest::stack_bytes(head)).map_err(|e| unreadable(e.to_string()))?;
    let builder = TableBounds::of_frames(head).open(file, &|_| true).map_err(unreadable)?;
    if head.schema_version == SCHEMA_VERSION && **builder.schema() != stack_schema(head) {
        return Err((Code::SchemaDiffers, "its columns are not those that are declared".into()));
    }
    for batch in builder.with_batch_size(8).build().map_err(|e| unreadable(e.to_string()))? {
        let batch = batch.map_err(|e| unreadable(e.to_string()))?;
        check_lengths(&batch).map_err(unreadable)?;
        rows(&batch, take).ok_or_else(|| unreadable("a column has another type".into()))?;
    }
    Ok(())
}

/// The same of some rows; `None` where a column has another type.
fn rows(batch: &RecordBatch, take: &mut dyn FnMut(Key, &ArrayRef) -> Option<()>) -> Option<()> {
    let id = batch.column(0).as_string_opt::<i32>()?;
    let index = batch.column(1).as_primitive_opt::<Int64Type>()?;
    let profile = batch.column(2).as_primitive_opt::<Int32Type>()?;
    let frames = batch.column(3).as_fixed_size_list_opt()?;
    (0..batch.num_rows())
        .try_for_each(|i| take((id.value(i).into(), index.value(i), profile.value(i).into()), &frames.value(i)))
}
