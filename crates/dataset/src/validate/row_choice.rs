//! Row choice: which rows and sensor frames of each sample are exposed again.
//!
//! At each place a row is drawn, all of them equally likely, and its neighbours in a strip that begins at a multiple of
//! its length come with it. Places are drawn one by one, so they may coincide: k of them meet a forgery of the share s
//! of the rows with the chance 1 - (1 - s)^k or more, wherever it lies. Frames are drawn without putting back: k of n
//! meet a single forged one with the chance k / n, so that only all of them meet it surely. Who forges must not know
//! which rows and frames these are: nothing that is stored tells the seed.

use std::collections::BTreeSet;

use output_schema::DatasetHead;
use sha2::{Digest, Sha256};

use crate::record::AskedRows;

/// Most profiles of a scan, as recipes allow.
const MAX_PROFILES: u64 = 16_383;

/// Most places in a sample: more have no row that others have not.
const MAX_PLACES: u64 = 1 << 16;

/// How rows are chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RowChoice {
    /// Places in each sample; 0 exposes nothing.
    pub places: u64,
    /// Rows at a place.
    pub strip: u64,
    /// Most sensor frames of each sample, of those that are kept.
    pub frames: u64,
    /// Which rows these are follows from this number, the dataset and the sample's index.
    pub seed: u64,
}

impl RowChoice {
    /// What of sample `index` is exposed again.
    pub fn of(&self, head: &DatasetHead, index: u64) -> AskedRows {
        let (rows, length) = (head.images.rows.max(1), self.strip.max(1));
        let strip = |place: u64| {
            let start = self.word(head, index, &format!("rows/{place}")) % rows / length * length;
            start as usize..(start + length).min(rows) as usize
        };
        let mut strips: Vec<_> = (0..self.places.min(MAX_PLACES)).map(strip).collect();
        strips.sort_unstable_by_key(|strip| strip.start);
        strips.dedup();
        AskedRows { strips, frames: self.frames(head, index), ..AskedRows::default() }
    }

    /// The profiles of the sensor frames that are exposed again, rising, where frames are kept.
    pub(super) fn frames(&self, head: &DatasetHead, index: u64) -> Vec<usize> {
        let Some(every) = head.images.stack_every.filter(|_| self.places > 0) else { return Vec::new() };
        let (every, profiles) = (every.max(1), head.recipe.canonical["scan"]["profiles"].as_u64());
        let kept = profiles.unwrap_or(head.images.rows).clamp(1, MAX_PROFILES).div_ceil(every);
        let frames = subset(kept, self.frames, |place| self.word(head, index, &format!("frames/{place}")));
        frames.into_iter().map(|frame| (frame * every) as usize).collect()
    }

    /// A word that is another one for each dataset, seed, sample and `what`.
    fn word(&self, head: &DatasetHead, index: u64, what: &str) -> u64 {
        let sum = Sha256::digest(format!("{}/{}/{}/{index}/{what}", head.recipe.hash, head.seed, self.seed));
        sum.iter().take(8).fold(0, |word, byte| word << 8 | u64::from(*byte))
    }
}

/// `count` of the first `all` numbers, or all of them: every set of so many is equally likely where `word` gives an
/// even word for each number (Floyd; Bentley 1987).
pub(super) fn subset(all: u64, count: u64, word: impl Fn(u64) -> u64) -> BTreeSet<u64> {
    let mut chosen = BTreeSet::new();
    for last in all - count.min(all)..all {
        let place = word(last) % (last + 1);
        if !chosen.insert(place) {
            chosen.insert(last);
        }
    }
    chosen
}
