//! Sample to check: a row as it is stored, its images decoded, and what its recipe makes of it: all that the rules
//! about a sample ask.

use arrow_array::RecordBatch;
use output_schema::ManifestSample;
use output_schema::file::exr_path;

use super::columns::StoredRow;
use super::decoded_images::DecodedImages;
use super::expected::ExpectedRow;
use super::shard_task::ShardTask;
use crate::ExrChannel;
use crate::record::{DerivedSample, ExposedRows, TrueRow};

/// One sample that is checked.
pub(super) struct SampleToCheck<'a> {
    pub(super) task: &'a ShardTask<'a>,
    /// Its row.
    pub(super) batch: &'a RecordBatch,
    /// The same as plain values.
    pub(super) row: StoredRow,
    /// What the manifest says about it.
    pub(super) listed: &'a ManifestSample,
    /// Its EXR file, where that is whole.
    pub(super) exr: Option<&'a [u8]>,
    /// The channels of that file, where they can be read.
    pub(super) channels: Vec<ExrChannel>,
    /// Its table and index.
    pub(super) place: String,
    /// The images of its row, then those that its EXR file alone has.
    pub(super) images: DecodedImages,
    /// A label that is no pixel class.
    pub(super) unknown_label: Option<u16>,
    /// What its recipe draws.
    pub(super) expected: Option<ExpectedRow>,
    /// What follows from that: without light, and in the rows that are exposed again.
    pub(super) derived: Option<DerivedSample>,
}

impl SampleToCheck<'_> {
    /// Columns of its images.
    pub(super) fn cols(&self) -> usize {
        self.row.cols.max(1) as usize
    }

    /// Whether it is rendered again, and compared as a whole.
    pub(super) fn is_chosen(&self) -> bool {
        self.task.chosen.contains(&self.listed.index)
    }

    /// Path of its EXR file.
    pub(super) fn exr_path(&self) -> String {
        exr_path(self.task.number, &self.listed.id)
    }

    /// The numbers of a channel of its EXR file.
    pub(super) fn channel(&self, name: &str) -> Option<&[f32]> {
        self.channels.iter().find(|channel| channel.name == name).map(|channel| channel.numbers.as_slice())
    }

    /// Some rows of the body that its recipe makes.
    pub(super) fn true_rows(&self) -> &[TrueRow] {
        self.derived.as_ref().map_or(&[], |derived| &derived.rows)
    }

    /// Rows that were exposed again.
    pub(super) fn exposed(&self) -> &[ExposedRows] {
        self.derived.as_ref().map_or(&[], |derived| &derived.exposed)
    }
}
