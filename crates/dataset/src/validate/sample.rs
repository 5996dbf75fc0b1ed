//! The pass over one sample: reads what the rules about it ask, makes again what can be, and asks them.

use std::borrow::Cow;
use std::sync::{Mutex, PoisonError};

use arrow_array::RecordBatch;
use output_schema::{ManifestFile, ManifestSample};

use super::decoded_images::DecodedImages;
use super::frame_digest::FrameDigest;
use super::job_result::CheckedRow;
use super::report::ValidationReport;
use super::rules::profile_differs::RowComparison;
use super::rules::{dive_differs, duplicates, exr, images, label_unknown, of_sample, tables, truth_differs};
use super::sample_to_check::SampleToCheck;
use super::shard_task::ShardTask;
use crate::record::{AskedRows, DerivedSample, StackFrame};

/// Checks one row of a table; `listed` is what the manifest says about it, `exr` its EXR file, where that is whole.
/// What later checks need, where the row can be read.
pub(super) fn check(
    task: &ShardTask,
    batch: &RecordBatch,
    file: &ManifestFile,
    listed: Option<&ManifestSample>,
    exr: Option<&[u8]>,
    report: &mut ValidationReport,
) -> Option<CheckedRow> {
    report.samples += 1;
    let row = tables::row(task, batch, file, report)?;
    let place = format!("{}, sample {}", file.path, row.index);
    let listed = tables::in_order(&row, listed, &place, report)?;
    let images = images::check(&row, &task.head.images, &place, report);
    let (derived, frames) = made_again(task, listed.index, row.cols.max(1) as usize, &images, exr);
    let expected = task.expect.map(|expect| expect(listed.index));
    let (channels, unknown_label) = (Vec::new(), None);
    let mut sample =
        SampleToCheck { task, batch, row, listed, exr, channels, place, images, unknown_label, expected, derived };
    report.frames += frames.len() as u64;
    report.unexposed += u64::from(sample.exposed().is_empty() && !sample.is_chosen());
    let mut exposed = RowComparison::of_images(&sample);
    let channels = exr::check(&sample, &mut exposed, report);
    exposed.tell(&sample.place, report);
    sample.images.add_channels(&channels, [sample.row.range_offset, sample.row.range_scale]);
    sample.channels = channels;
    truth_differs::labels(&sample, report);
    dive_differs::check(&sample, report);
    // They are as large as the file, and nothing asks for them while the sample is rendered again.
    sample.channels = Vec::new();
    sample.unknown_label = label_unknown::unknown(&sample.images, &task.head.label_values);
    of_sample::check(&sample, report);
    // A copy differs in every row that is exposed again.
    let is_printed = task.rows.is_none();
    let print = is_printed.then(|| duplicates::print(sample.cols(), &sample.images, &sample.row.numbers)).flatten();
    Some(CheckedRow { place: 0, index: listed.index, split: sample.row.split, print: print.map(Box::new), frames })
}

/// What the recipe makes of a sample without rendering it whole, and its sensor frames that were exposed again, in any
/// order; nothing of one that is rendered again, and compared as a whole.
fn made_again(
    task: &ShardTask,
    index: u64,
    cols: usize,
    images: &DecodedImages,
    exr: Option<&[u8]>,
) -> (Option<DerivedSample>, Vec<FrameDigest>) {
    let Some(derive) = task.derive.filter(|_| !task.chosen.contains(&index)) else { return (None, Vec::new()) };
    let mut asked = task.rows.map_or_else(AskedRows::default, |rows| rows.of(task.head, index));
    let of_file = || exr.and_then(|bytes| exr::label(bytes, task.head));
    let label = images.get("label").map(Cow::Borrowed).or_else(|| of_file().map(Cow::Owned));
    asked.unlit = label.map_or_else(Vec::new, |label| object_ends(&label, cols));
    let frames = Mutex::new(Vec::new());
    let take = |frame: StackFrame| {
        let digest = FrameDigest::of(index, frame.profile.into(), &frame.dn);
        frames.lock().unwrap_or_else(PoisonError::into_inner).push(digest);
    };
    let derived = derive(index, &asked, &take);
    (Some(derived), frames.into_inner().unwrap_or_else(PoisonError::into_inner))
}

/// The first and the last row of a label image that show the object, with the row before and the row behind.
fn object_ends(label: &[u16], cols: usize) -> Vec<usize> {
    let shows = |row: &[u16]| row.iter().any(|class| *class != 0);
    let ends = label.chunks(cols).position(shows).zip(label.chunks(cols).rposition(shows));
    ends.map_or_else(Vec::new, |(first, last)| vec![first.saturating_sub(1), first, last, last + 1])
}
