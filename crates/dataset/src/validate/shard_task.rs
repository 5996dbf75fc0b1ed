//! Shard task: what the checks of one shard share.

use std::collections::BTreeSet;
use std::path::Path;

use output_schema::DatasetHead;

use super::row_choice::RowChoice;
use super::sample_counts::RowNumbers;
use super::{Derive, Expect, Rerender};

/// What is to be checked.
#[derive(Clone, Copy)]
pub(super) struct ShardTask<'a> {
    pub(super) root: &'a Path,
    pub(super) head: &'a DatasetHead,
    pub(super) number: u64,
    pub(super) expect: Option<Expect<'a>>,
    pub(super) derive: Option<Derive<'a>>,
    /// Which rows of each sample are exposed again.
    pub(super) rows: Option<RowChoice>,
    pub(super) rerender: Option<Rerender<'a>>,
    pub(super) chosen: &'a BTreeSet<u64>,
    /// Takes what each row says.
    pub(super) seen: &'a (dyn Fn(&RowNumbers) + Sync),
}
