//! What a saved result says of the dataset that it was made from: two sums that change when the dataset does.

use std::fs;
use std::path::Path;

use output_schema::file::{DATASET, manifest_path};
use sha2::{Digest, Sha256};

use super::hex;

/// SHA-256 of a dataset's documents, hexadecimal.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Sums {
    /// Of `dataset.json`.
    pub dataset: String,
    /// Of the manifests that are there, one after the other in the order of shards.
    pub manifests: String,
}

impl Sums {
    /// Of the dataset at `root` with so many shards; documents that are not there count as empty.
    pub fn of(root: &Path, shards: u64) -> Self {
        Self::of_shards(root, 0..shards)
    }

    /// The same with the manifests of these shards alone.
    pub(crate) fn of_shards(root: &Path, shards: impl IntoIterator<Item = u64>) -> Self {
        let mut manifests = Sha256::new();
        for shard in shards {
            manifests.update(fs::read(root.join(manifest_path(shard))).unwrap_or_default());
        }
        let dataset = Sha256::digest(fs::read(root.join(DATASET)).unwrap_or_default());
        Self { dataset: hex(&dataset), manifests: hex(&manifests.finalize()) }
    }
}
