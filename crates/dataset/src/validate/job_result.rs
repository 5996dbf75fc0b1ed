//! What one job of validation found, and what stays of a row to be compared with others.

use super::frame_digest::FrameDigest;
use super::report::ValidationReport;
use super::rules::duplicates::NoisePrint;
use crate::ClassCounts;

/// What one job found.
#[derive(Default)]
pub(super) struct JobResult {
    pub(super) report: ValidationReport,
    /// Digest of the id, index and shard of every sample that the manifest names.
    pub(super) ids: Vec<(u128, u64, u64)>,
    /// How many samples of each class and split the manifest names.
    pub(super) counts: ClassCounts,
    /// Paths of its tables, as the manifest names them.
    pub(super) tables: Vec<String>,
    /// Its number, where there is a manifest that can be read.
    pub(super) opened: Option<u64>,
    /// Its number, where there is a manifest that cannot be read: nobody knows which files are its own.
    pub(super) hidden: Option<u64>,
    /// The row that it read.
    pub(super) row: Option<CheckedRow>,
    /// The sensor frames that it read and that are to be compared.
    pub(super) frames: Vec<FrameDigest>,
}

/// What stays of a row to be compared with others.
pub(super) struct CheckedRow {
    pub(super) index: u64,
    pub(super) split: String,
    /// `None` where rows of it are exposed again, which tell copies exactly.
    pub(super) print: Option<Box<NoisePrint>>,
    /// Its sensor frames that were exposed again, in any order.
    pub(super) frames: Vec<FrameDigest>,
}
