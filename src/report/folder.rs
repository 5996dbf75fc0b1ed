//! What lies in a dataset's folder: its head, its finished shards, and bytes by kind of file.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use output_schema::file::{data_path, manifest_path};
use output_schema::{DatasetHead, Manifest};

use crate::record::Split;
use crate::shard::{DatasetFolder, ShardError};

/// Most faults that the page lists; the others are counted.
pub(super) const LISTED: usize = 40;

/// Something that is missing or cannot be read.
#[derive(Debug, Clone, PartialEq)]
pub struct Trouble {
    /// File.
    pub place: String,
    /// What is wrong.
    pub what: String,
    /// What to do.
    pub remedy: &'static str,
}

/// Rows of one split in one shard.
#[derive(Debug, Clone)]
pub(super) struct Table {
    /// Where it is.
    pub path: PathBuf,
    /// The same, relative to the folder.
    pub relative: String,
    /// Number of the shard.
    pub shard: u64,
    /// Place of the split in [`Split::ALL`].
    pub split: usize,
}

/// Files of one kind.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Files {
    /// How many.
    pub count: u64,
    /// Size of all [bytes].
    pub bytes: u64,
}

/// What lies in the folder.
#[derive(Debug)]
pub(super) struct Folder {
    /// Tables in the order of shards, then of splits.
    pub tables: Vec<Table>,
    /// Shards with a manifest.
    pub finished: u64,
    /// Files by kind, the largest kinds not first but in the order of the alphabet.
    pub kinds: BTreeMap<&'static str, Files>,
    /// What is missing, the first of it.
    pub troubles: Vec<Trouble>,
    /// How much more is.
    pub more: u64,
}

impl Folder {
    /// Looks at every file that the manifests name, by size alone.
    pub fn look(folder: &DatasetFolder) -> Self {
        let (head, root) = (folder.head(), folder.root());
        let mut found = Self { tables: Vec::new(), finished: 0, kinds: BTreeMap::new(), troubles: Vec::new(), more: 0 };
        for name in ["dataset.json", "README.md", "croissant.json"] {
            if let Ok(file) = fs::metadata(root.join(name)) {
                found.count("documents", file.len());
            }
        }
        head.assets.iter().for_each(|asset| found.count("files of the recipe", asset.bytes));
        for shard in 0..head.shards {
            match folder.read_manifest(shard) {
                Ok(Some(manifest)) => found.shard(root, shard, &manifest),
                Ok(None) => {
                    let remedy = "run the command that began the dataset to finish it";
                    found.trouble(manifest_path(shard), "is missing: the shard is not finished".into(), remedy);
                }
                Err(error) => {
                    let remedy = "run gen validate: it says what is wrong with the dataset";
                    found.trouble(manifest_path(shard), told(error), remedy);
                }
            }
        }
        found
    }

    fn shard(&mut self, root: &Path, shard: u64, manifest: &Manifest) {
        self.finished += 1;
        self.count("documents", fs::metadata(root.join(manifest_path(shard))).map_or(0, |file| file.len()));
        for file in &manifest.files {
            let remedy = "remove the shard's manifest and run gen again: the shard is made again";
            let path = root.join(&file.path);
            match fs::metadata(&path) {
                Err(_) => self.trouble(file.path.clone(), "is missing".into(), remedy),
                Ok(there) if there.len() != file.bytes => {
                    let what = format!("has {} bytes, its manifest says {}", there.len(), file.bytes);
                    self.trouble(file.path.clone(), what, remedy);
                }
                Ok(_) => {}
            }
            self.count(kind(&file.path), file.bytes);
            let split = Split::ALL.iter().position(|split| data_path(split.name(), shard) == file.path);
            if let Some(split) = split {
                self.tables.push(Table { path, relative: file.path.clone(), shard, split });
            }
        }
        self.tables.sort_by_key(|table| (table.shard, table.split));
    }

    fn count(&mut self, kind: &'static str, bytes: u64) {
        let files = self.kinds.entry(kind).or_default();
        files.count += 1;
        files.bytes += bytes;
    }

    /// Notes what is wrong.
    pub fn trouble(&mut self, place: String, what: String, remedy: &'static str) {
        if self.troubles.len() < LISTED {
            self.troubles.push(Trouble { place, what, remedy });
        } else {
            self.more += 1;
        }
    }

    /// Size of everything [bytes].
    pub fn bytes(&self) -> u64 {
        self.kinds.values().map(|files| files.bytes).sum()
    }
}

fn kind(path: &str) -> &'static str {
    match path.split('/').next() {
        Some("data") => "tables with PNG images (data)",
        Some("exr") => "EXR images (exr)",
        Some("stacks") => "sensor frames (stacks)",
        _ => "others",
    }
}

/// What is wrong with a manifest, without its path and remedy, which stand beside it.
fn told(error: ShardError) -> String {
    match error {
        ShardError::Refused { reasons, .. } => reasons.join("; "),
        ShardError::Io { source, .. } => format!("cannot be read: {source}"),
        error => error.to_string(),
    }
}

/// Samples that the head promises in the shards that are not finished.
pub(super) fn unfinished(head: &DatasetHead, folder: &Folder) -> u64 {
    head.shards.saturating_sub(folder.finished)
}
