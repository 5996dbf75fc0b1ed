//! Shard task: what the checks of one shard share.

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::{Mutex, PoisonError};

use output_schema::DatasetHead;

use super::row_choice::RowChoice;
use super::{Derive, Expect, Rerender};
use crate::record::{AskedRows, StackFrame};

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
}

impl ShardTask<'_> {
    /// Whether samples are compared exactly with what their recipe makes; where they can't be, estimates say what to
    /// look at.
    pub(super) fn is_exact(&self) -> bool {
        self.derive.is_some()
    }

    /// A sensor frame of a sample as its recipe makes it, where it can be exposed.
    pub(super) fn exposed_again(&self, index: u64, profile: u64) -> Option<StackFrame> {
        let asked = AskedRows { frames: vec![usize::try_from(profile).ok()?], ..AskedRows::default() };
        let made = Mutex::new(None);
        self.derive?(index, &asked, &|frame| *made.lock().unwrap_or_else(PoisonError::into_inner) = Some(frame));
        made.into_inner().unwrap_or_else(PoisonError::into_inner)
    }
}
