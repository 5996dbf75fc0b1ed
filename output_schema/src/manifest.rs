//! `shards/<shard>.json`: the last file of a shard, and so the sign that it is finished.

use serde::{Deserialize, Serialize};

use crate::dataset::Generator;

/// One file of a shard.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ManifestFile {
    /// Path relative to the folder.
    pub path: String,
    /// Size [bytes].
    pub bytes: u64,
    /// SHA-256 of the file, hexadecimal.
    pub sha256: String,
    /// Rows of a Parquet file; null for other files.
    pub rows: Option<u64>,
}

/// One sample of a shard.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ManifestSample {
    /// Number in the dataset.
    pub index: u64,
    /// Name.
    pub id: String,
    /// Part of the dataset.
    pub split: String,
    /// Name of the recipe's class.
    pub class: String,
    /// SHA-256 over the sample's encoded maps: for each PNG in the order of columns, then for the EXR file, name,
    /// length (8 bytes, little-endian) and bytes.
    pub sha256: String,
}

/// `shards/<shard>.json`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Manifest {
    /// [`crate::FORMAT`].
    pub format: String,
    /// [`crate::SCHEMA_VERSION`] of the writer.
    pub schema_version: [u32; 2],
    /// The program.
    pub generator: Generator,
    /// SHA-256 of the recipe's canonical form.
    pub recipe_hash: String,
    /// Seed.
    pub seed: u64,
    /// Number of the shard.
    pub shard: u64,
    /// Index of its first sample.
    pub first: u64,
    /// Samples.
    pub count: u64,
    /// Every file, by path.
    pub files: Vec<ManifestFile>,
    /// Every sample, by index.
    pub samples: Vec<ManifestSample>,
}
