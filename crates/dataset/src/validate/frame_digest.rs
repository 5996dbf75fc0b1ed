//! Frame digest: a sensor frame by its content, and which of those on disk are to be compared.

use sha2::{Digest, Sha256};

use super::shard_task::ShardTask;

/// A sensor frame by its content.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct FrameDigest {
    /// Its sample.
    pub(super) index: u64,
    /// Its profile.
    pub(super) profile: u64,
    /// Half of the SHA-256 of its pixels.
    pub(super) digest: u128,
}

impl FrameDigest {
    /// Of the pixels of a frame.
    pub(super) fn of(index: u64, profile: u64, dn: &[u16]) -> Self {
        let mut sum = Sha256::new();
        let mut bytes = Vec::with_capacity(8192);
        for part in dn.chunks(4096) {
            bytes.clear();
            bytes.extend(part.iter().flat_map(|n| n.to_le_bytes()));
            sum.update(&bytes);
        }
        let digest = sum.finalize().iter().take(16).fold(0, |word, byte| word << 8 | u128::from(*byte));
        Self { index, profile, digest }
    }
}

/// The profiles of a sample's stored frames that are to be compared, rising.
pub(super) fn asked(task: &ShardTask, index: i64) -> Vec<usize> {
    // Samples that are rendered again are compared as a whole.
    let index = u64::try_from(index).ok().filter(|index| !task.chosen.contains(index));
    index.zip(task.rows).map_or_else(Vec::new, |(index, rows)| rows.frames(task.head, index))
}
