//! Frames: the sensor frames that were exposed again against those on disk.
//!
//! A row and its frame lie in different files and are read by different jobs, so digests are kept and compared at the end; only
//! frames that differ are exposed and read once more, to say where.

use std::collections::HashMap;
use std::panic::{AssertUnwindSafe, catch_unwind};

use output_schema::file::stack_path;

use super::finding::{Code, Finding};
use super::frame_digest::FrameDigest;
use super::shard_task::ShardTask;
use super::stack;

/// Samples of whose frames a fault says where they differ; it takes as long as to expose one.
const MAX_SHOWN_SAMPLES: usize = 8;

/// What is wrong with the frames that were exposed again, one fault for each sample; those that are not there are told
/// by another rule.
pub(super) fn check(task: &ShardTask, mut made: Vec<FrameDigest>, stored: &[FrameDigest]) -> Vec<Finding> {
    let stored: HashMap<(u64, u64), u128> =
        stored.iter().map(|frame| ((frame.index, frame.profile), frame.digest)).collect();
    let differs =
        |frame: &FrameDigest| stored.get(&(frame.index, frame.profile)).is_some_and(|digest| *digest != frame.digest);
    made.retain(differs);
    made.sort_unstable_by_key(|frame| (frame.index, frame.profile));
    let finding = |(count, frames): (usize, &[FrameDigest])| {
        let FrameDigest { index, profile, .. } = frames[0];
        let shard = index / task.head.samples_per_shard.max(1);
        let task = ShardTask { number: shard, ..*task };
        let shown = (count < MAX_SHOWN_SAMPLES).then(|| caught(|| first_difference(&task, index, profile)));
        let first = shown.flatten().map_or(String::new(), |first| format!("; {first}"));
        let others = frames.len() - 1;
        let more = if others > 0 { format!("; nor are {others} of its other frames") } else { String::new() };
        let what =
            format!("the sensor frame of profile {profile} is not what it is when it is exposed again{first}{more}");
        Finding::new(Code::ProfileDiffers, format!("{}, sample {index}", stack_path(shard)), what)
    };
    made.chunk_by(|a, b| a.index == b.index).enumerate().map(finding).collect()
}

/// What a reader of another crate says, which may panic on content that was made to mislead.
fn caught(read: impl FnOnce() -> Option<String>) -> Option<String> {
    catch_unwind(AssertUnwindSafe(read)).ok().flatten()
}

/// The first pixel in which a frame differs.
fn first_difference(task: &ShardTask, index: u64, profile: u64) -> Option<String> {
    let made = task.exposed_again(index, profile)?;
    let stored = stack::frames(task, index).ok()?.into_iter().find(|frame| u64::from(frame.profile) == profile)?;
    let pairs = || stored.dn.iter().zip(&made.dn);
    let count = pairs().filter(|(stored, made)| stored != made).count();
    let (place, (stored, made)) = pairs().enumerate().find(|(_, (stored, made))| stored != made)?;
    let cols = task.head.images.sensor_cols.max(1) as usize;
    let (row, column) = (place / cols, place % cols);
    Some(format!(
        "{count} pixels differ, the first, sensor row {row}, column {column}, is {stored}, exposed again {made}"
    ))
}
