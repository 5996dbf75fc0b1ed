//! Rows and sensor frames of a sample that were exposed again against those on disk, bit for bit: rows in every image
//! and channel.
//!
//! A row and its frame lie in different files and are read by different jobs, so digests of frames are kept and
//! compared at the end; only frames that differ are exposed and read once more, to say where.

use std::collections::HashMap;
use std::fmt::Display;

use exr::prelude::f16;
use optical_bench::settings::Channel;
use output_schema::SampleType;
use output_schema::file::stack_path;

use super::{Code, Finding, REMAKE_OR_REPORT, Rule, SampleToCheck, ValidationReport};
use crate::record::ExposedRows;
use crate::table_reader::guarded;
use crate::validate::frame_digest::FrameDigest;
use crate::validate::shard_task::ShardTask;
use crate::validate::stored_frames;
use crate::validate::whole_range::shown_channels;
use crate::{ExrChannel, image_of, map_channels};

pub(super) const RULE: Rule = Rule {
    meaning: "A row or a sensor frame that was exposed again is not what is on disk.",
    remedy: REMAKE_OR_REPORT,
};
/// Samples of whose frames a fault says where they differ; it takes as long as to expose one.
const MAX_SHOWN_SAMPLES: usize = 8;

/// Rows of one sample that were exposed again, and what differs on disk.
pub(in crate::validate) struct RowComparison<'a> {
    rows: &'a [ExposedRows],
    /// Columns of the stored images.
    cols: usize,
    /// Their channels, as EXR files have them.
    channels: Vec<Vec<ExrChannel>>,
    /// Maps that differ, and in how many pixels.
    other: Vec<(String, usize)>,
    /// The first pixel that does.
    first: Option<String>,
}

impl<'a> RowComparison<'a> {
    /// Of the images of a sample; channels of its EXR file may follow.
    pub(in crate::validate) fn of_images(sample: &'a SampleToCheck) -> Self {
        let (rows, head) = (sample.exposed(), sample.task.head);
        let declared = if rows.is_empty() { Vec::new() } else { shown_channels(head) };
        let channels = |row: &ExposedRows| map_channels(&row.maps, &row.labels, row.truth.as_ref(), &declared);
        let channels = rows.iter().map(channels).collect();
        let mut comparison = Self { rows, cols: sample.cols(), channels, other: Vec::new(), first: None };
        // What the number 0 of Range means, and what a step is [mm or px].
        let record = sample.derived.as_ref().map(|made| &made.record);
        let scale = record.map_or([0.0; 2], |record| [record.range_offset, record.range_scale]);
        let bits = u32::try_from(head.images.bits).unwrap_or(u32::MAX);
        for row in rows {
            for channel in Channel::ALL {
                let Some(stored) = sample.images.get(channel.name()) else { continue };
                let made = image_of(&row.maps, &row.labels, channel, bits, scale).numbers();
                comparison.strip(&format!("`{}`", channel.name()), row, stored, &made, |a, b| a == b);
            }
        }
        comparison
    }

    /// Compares a channel of the EXR file.
    pub(super) fn channel(&mut self, stored: &ExrChannel) {
        if self.rows.is_empty() {
            return;
        }
        let is_half = stored.samples == SampleType::Half;
        for (place, row) in self.rows.iter().enumerate() {
            let Some(made) = self.channels[place].iter().find(|channel| channel.name == stored.name) else { continue };
            let rounded = |made: &f32| if is_half { f16::from_f32(*made).to_f32() } else { *made };
            let made: Vec<f32> = made.numbers.iter().map(rounded).collect();
            let same = |a: f32, b: f32| a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan());
            self.strip(&stored.name, row, &stored.numbers, &made, same);
        }
    }

    /// Compares the pixels of a map in some neighbouring rows.
    fn strip<T: Copy + Display>(
        &mut self,
        name: &str,
        row: &ExposedRows,
        stored: &[T],
        made: &[T],
        same: impl Fn(T, T) -> bool,
    ) {
        // Images of another size are told by another rule.
        let (cols, from) = (self.cols, row.first * self.cols);
        let Some(stored) = stored.get(from..from + made.len()).filter(|_| row.cols == cols) else { return };
        let mut count = 0;
        for (i, (&stored, &made)) in stored.iter().zip(made).enumerate() {
            if same(stored, made) {
                continue;
            }
            count += 1;
            let place = || format!("{name}, row {}, column {}", row.first + i / cols, i % cols);
            self.first.get_or_insert_with(|| format!("{} is {stored}, exposed again {made}", place()));
        }
        if count > 0 {
            match self.other.iter_mut().find(|(known, _)| known == name) {
                Some((_, sum)) => *sum += count,
                None => self.other.push((name.to_owned(), count)),
            }
        }
    }

    /// Tells what differs, in one fault.
    pub(in crate::validate) fn tell(self, place: &str, report: &mut ValidationReport) {
        report.rows += self.rows.iter().map(|row| row.labels.class.len() / row.cols.max(1)).sum::<usize>() as u64;
        let Some(first) = self.first else { return };
        let counts: Vec<String> = self.other.iter().map(|(name, count)| format!("{count} of {name}")).collect();
        let rows: Vec<String> = self.rows.iter().map(|row| row.name()).collect();
        let what = format!("pixels of rows {} differ: {}; the first: {first}", rows.join(", "), counts.join(", "));
        report.fault(Code::ProfileDiffers, place, what);
    }
}

impl ExposedRows {
    /// Its rows in words.
    fn name(&self) -> String {
        match self.labels.class.len() / self.cols.max(1) {
            0 | 1 => self.first.to_string(),
            rows => format!("{} to {}", self.first, self.first + rows - 1),
        }
    }
}

/// What is wrong with the frames that were exposed again, one fault for each sample; those that are not there are told
/// by another rule.
pub(in crate::validate) fn frames(
    task: &ShardTask,
    mut made: Vec<FrameDigest>,
    stored: &[FrameDigest],
) -> Vec<Finding> {
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
        let shown = (count < MAX_SHOWN_SAMPLES).then(|| guarded(|| Ok(first_difference(&task, index, profile))));
        let first = shown.and_then(|shown| shown.ok()?).map_or(String::new(), |first| format!("; {first}"));
        let others = frames.len() - 1;
        let more = if others > 0 { format!("; nor are {others} of its other frames") } else { String::new() };
        let what =
            format!("the sensor frame of profile {profile} is not what it is when it is exposed again{first}{more}");
        Finding::new(Code::ProfileDiffers, format!("{}, sample {index}", stack_path(shard)), what)
    };
    made.chunk_by(|a, b| a.index == b.index).enumerate().map(finding).collect()
}

/// The first pixel in which a frame differs.
fn first_difference(task: &ShardTask, index: u64, profile: u64) -> Option<String> {
    let made = task.exposed_again(index, profile)?;
    let stored = stored_frames::frames(task, index)?.into_iter().find(|frame| u64::from(frame.profile) == profile)?;
    let pairs = || stored.dn.iter().zip(&made.dn);
    let count = pairs().filter(|(stored, made)| stored != made).count();
    let (place, (stored, made)) = pairs().enumerate().find(|(_, (stored, made))| stored != made)?;
    let cols = task.head.images.sensor_cols.max(1) as usize;
    let (row, column) = (place / cols, place % cols);
    Some(format!(
        "{count} pixels differ, the first, sensor row {row}, column {column}, is {stored}, exposed again {made}"
    ))
}
