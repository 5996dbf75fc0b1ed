//! Dataset folder as a page shows it: its head, its finished shards, and bytes by kind of file.

use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::ops::Range;
use std::path::Path;

use output_schema::Manifest;
use output_schema::file::manifest_path;

use dataset::{Dataset, Fault, Table, enclosed};

/// Most faults that the page lists; the others are counted.
pub(super) const LISTED: usize = 40;

/// Files of one kind.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Files {
    /// How many.
    pub count: u64,
    /// Size of all [bytes].
    pub bytes: u64,
}

/// What lies in the folder.
#[derive(Debug, Default)]
pub(super) struct DatasetFolder {
    /// Tables in the order of shards, then of splits.
    pub tables: Vec<Table>,
    /// Shards with a manifest.
    pub finished: u64,
    /// Files by kind, the largest kinds not first but in the order of the alphabet.
    pub kinds: BTreeMap<&'static str, Files>,
    /// What is missing, the first of it.
    pub troubles: Vec<Fault>,
    /// How much more is.
    pub more: u64,
    /// How much of both is damage, not shards that are yet to be made.
    pub damage: u64,
}

impl DatasetFolder {
    /// Looks at every file that the head and the manifests name, by size alone.
    pub fn look(dataset: &Dataset) -> Self {
        let (head, root) = (dataset.head(), dataset.root());
        let mut found = Self::default();
        for name in ["dataset.json", "README.md", "croissant.json"] {
            if let Ok(bytes) = enclosed::length(root, name) {
                found.count("documents", bytes);
            }
        }
        for asset in head.assets.iter().filter(|asset| asset.is_in_folder()) {
            found.file("files of the recipe", root, &asset.path, asset.bytes, "`gen validate` says what is damaged");
        }
        // Shards in a row that are not finished: the first of them, and the one behind the last.
        let mut gap = 0..0;
        for shard in 0..head.shards {
            let manifest = dataset.manifest(shard);
            if !matches!(manifest, Ok(None)) {
                found.gap(std::mem::take(&mut gap));
            }
            match manifest {
                Ok(Some(manifest)) => found.shard(dataset, shard, &manifest),
                Ok(None) => gap = if gap.is_empty() { shard } else { gap.start }..shard + 1,
                Err(error) => {
                    let remedy = "run gen validate: it says what is wrong with the dataset";
                    found.trouble(manifest_path(shard), told(error), remedy);
                }
            }
        }
        found.gap(gap);
        found
    }

    /// Notes shards in a row that are not finished.
    fn gap(&mut self, shards: Range<u64>) {
        let remedy = "run the command that began the dataset to finish it";
        match shards.end - shards.start {
            0 => {}
            1 => self.list(manifest_path(shards.start), "is missing: the shard is not finished".into(), remedy),
            n => {
                let place = format!("shards {} to {}", shards.start, shards.end - 1);
                self.list(place, format!("their {n} manifests are missing: the shards are not finished"), remedy);
            }
        }
    }

    fn shard(&mut self, dataset: &Dataset, shard: u64, manifest: &Manifest) {
        let root = dataset.root();
        self.finished += 1;
        self.count("documents", enclosed::length(root, &manifest_path(shard)).unwrap_or(0));
        for file in &manifest.files {
            let remedy = "remove the shard's manifest and run gen again: the shard is made again";
            self.file(kind(&file.path), root, &file.path, file.bytes, remedy);
        }
        self.tables.extend(dataset.tables_of(shard, manifest));
    }

    /// Counts a file where it is there, by the size that it has; notes one that is not there or has another size than
    /// it should.
    fn file(&mut self, kind: &'static str, root: &Path, relative: &str, bytes: u64, remedy: &'static str) {
        let there = match enclosed::length(root, relative) {
            Ok(there) => there,
            Err(e) if e.kind() == ErrorKind::NotFound => {
                return self.trouble(relative.into(), "is missing".into(), remedy);
            }
            Err(e) => return self.trouble(relative.into(), format!("cannot be read: {e}"), remedy),
        };
        if there != bytes {
            self.trouble(relative.into(), format!("has {there} bytes and should have {bytes}"), remedy);
        }
        self.count(kind, there);
    }

    fn count(&mut self, kind: &'static str, bytes: u64) {
        let files = self.kinds.entry(kind).or_default();
        files.count += 1;
        files.bytes += bytes;
    }

    /// Notes what is damaged.
    pub fn trouble(&mut self, place: String, what: String, remedy: &'static str) {
        self.damage += 1;
        self.list(place, what, remedy);
    }

    fn list(&mut self, place: String, what: String, remedy: &'static str) {
        if self.troubles.len() < LISTED {
            self.troubles.push(Fault::new(place, what, remedy));
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
fn told(fault: Fault) -> String {
    if fault.tried == Some("read") { format!("cannot be read: {}", fault.what) } else { fault.what }
}
