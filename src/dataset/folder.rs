//! The dataset folder: one head for all shards, and which of them are finished.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use output_schema::file::{
    CARD, CROISSANT, DATASET, LOCK, TEMPORARY, data_path, exr_folder, manifest_path, stack_path, temporary,
};
use output_schema::{DatasetHead, Manifest, refuse_version};

use super::atomic_file;
use super::card::Counts;
use super::durable::{create_directory, names, remove, write_whole};
use super::lock::Lock;
use super::{ShardError, card, croissant, refuse};
use crate::split::Split;

/// An open dataset folder.
#[derive(Debug, Clone)]
pub struct DatasetFolder {
    root: PathBuf,
    head: Arc<DatasetHead>,
}

/// Directories of a dataset folder.
const DIRECTORIES: [&str; 4] = ["data", "exr", "stacks", "shards"];

impl DatasetFolder {
    /// Opens the dataset at `path`, or begins it. A larger number of samples extends it, a smaller one changes nothing.
    /// Several processes may do this at once.
    ///
    /// # Errors
    /// [`ShardError::Refused`] where the folder holds another dataset or other files, each difference named;
    /// [`ShardError::Io`] and [`ShardError::DiskFull`].
    pub fn open_or_create(path: &Path, head: DatasetHead) -> Result<Self, ShardError> {
        let foreign = |name: &String| !(name.starts_with(LOCK) || name.starts_with(TEMPORARY));
        if !path.join(DATASET).exists() && names(path)?.iter().any(foreign) && !path.join(DATASET).exists() {
            let reasons = vec![format!("it is not empty and holds no {DATASET}")];
            return Err(ShardError::Refused { path: path.into(), reasons, remedy: "choose an empty folder" });
        }
        create_directory(path)?;
        let _lock = Lock::take(&path.join(format!("{LOCK}dataset")))?;
        let old = read_head(path)?;
        let mut new = head;
        if let Some(old) = &old {
            let reasons = refuse::reasons(old, &new);
            if !reasons.is_empty() {
                let remedy = "choose another folder, or run the recipe, seed and program that began this one";
                return Err(ShardError::Refused { path: path.into(), reasons, remedy });
            }
            new.samples = new.samples.max(old.samples);
            new.recipe = old.recipe.clone();
        }
        new.shards = DatasetHead::shards_for(new.samples, new.samples_per_shard);
        // The head comes first: whoever finds a folder with more than locks and temporary names finds it too.
        if old.as_ref() != Some(&new) {
            write_whole(path, DATASET, &document(&new))?;
        }
        for directory in DIRECTORIES.iter().filter(|&&name| needed(name, &new)) {
            create_directory(&path.join(directory))?;
        }
        let extended = old.as_ref().is_none_or(|old| old.samples != new.samples);
        if extended || [CARD, CROISSANT].iter().any(|name| !path.join(name).exists()) {
            describe(path, &new, &Split::ALL, &Counts::new())?;
        }
        let folder = Self { root: path.into(), head: Arc::new(new) };
        folder.sweep()?;
        Ok(folder)
    }

    /// Opens the dataset at `path` to read it; changes nothing.
    ///
    /// # Errors
    /// [`ShardError::Refused`] where it is no dataset, or one that this program does not read; [`ShardError::Io`].
    pub fn open(path: &Path) -> Result<Self, ShardError> {
        let refused = |reason: String| ShardError::Refused {
            path: path.into(),
            reasons: vec![reason],
            remedy: "name the folder of a dataset",
        };
        let head = read_head(path)?.ok_or_else(|| refused(format!("it holds no {DATASET}")))?;
        Ok(Self { root: path.into(), head: Arc::new(head) })
    }

    /// Keeps a file that the recipe names, under its path in the folder; one that is there as it should be stays.
    ///
    /// # Errors
    /// [`ShardError::Io`] and [`ShardError::DiskFull`].
    pub fn keep(&self, path: &str, content: &[u8]) -> Result<(), ShardError> {
        let _lock = Lock::take(&self.root.join(format!("{LOCK}dataset")))?;
        if fs::read(self.root.join(path)).is_ok_and(|found| found == content) {
            return Ok(());
        }
        create_directory(&self.root.join("assets"))?;
        write_whole(&self.root, path, content)
    }

    /// The folder.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// `dataset.json`.
    pub fn head(&self) -> &DatasetHead {
        &self.head
    }

    /// Whether the shard is finished: its manifest is there, counts as many samples as it should, and every file has
    /// its size.
    pub fn is_done(&self, shard: u64) -> bool {
        let Ok(Some(manifest)) = self.read_manifest(shard) else { return false };
        let whole = |file: &output_schema::ManifestFile| {
            fs::metadata(self.root.join(&file.path)).is_ok_and(|found| found.is_file() && found.len() == file.bytes)
        };
        let (first, count) = self.head.span(shard);
        manifest.recipe_hash == self.head.recipe.hash
            && manifest.generator == self.head.generator
            && manifest.seed == self.head.seed
            && (manifest.first, manifest.count) == (first, count)
            && manifest.files.iter().all(whole)
    }

    /// The shards among `shards` that are not finished.
    pub fn remaining(&self, shards: impl IntoIterator<Item = u64>) -> Vec<u64> {
        shards.into_iter().filter(|&shard| shard < self.head.shards && !self.is_done(shard)).collect()
    }

    /// To call when no shard remains: card and metadata then name only splits that have files, as `datasets` asks.
    ///
    /// # Errors
    /// [`ShardError::Io`] and [`ShardError::DiskFull`].
    pub fn complete(&self) -> Result<(), ShardError> {
        let _lock = Lock::take(&self.root.join(format!("{LOCK}dataset")))?;
        let files = names(&self.root.join("data"))?;
        let present: Vec<Split> =
            Split::ALL.into_iter().filter(|split| files.iter().any(|f| f.starts_with(split.name()))).collect();
        let mut counts = Counts::new();
        for shard in 0..self.head.shards {
            for sample in self.read_manifest(shard)?.into_iter().flat_map(|manifest| manifest.samples) {
                *counts.entry((sample.class, sample.split)).or_default() += 1;
            }
        }
        describe(&self.root, &self.head, &present, &counts)
    }

    /// The manifest of a finished shard; `None` where the shard is not finished.
    ///
    /// # Errors
    /// [`ShardError::Refused`] where it is damaged, or one that this program does not read; [`ShardError::Io`].
    pub fn read_manifest(&self, shard: u64) -> Result<Option<Manifest>, ShardError> {
        read_document(&self.root.join(manifest_path(shard)), "run gen validate: it says what is wrong with the dataset")
    }

    pub(super) fn lock_path(&self, shard: u64) -> PathBuf {
        self.root.join(format!("shards/{LOCK}{shard:05}"))
    }

    /// Removes every file of a shard, finished or not; the manifest goes first. Asks for the shard's lock.
    pub(super) fn clear(&self, shard: u64) -> Result<(), ShardError> {
        let mut paths = vec![manifest_path(shard), exr_folder(shard), stack_path(shard)];
        paths.extend(Split::ALL.map(|split| data_path(split.name(), shard)));
        for path in paths {
            remove(&self.root.join(&path))?;
            remove(&self.root.join(temporary(&path)))?;
        }
        Ok(())
    }

    /// Removes what processes left behind that were killed: temporary names and locks of shards that nobody holds.
    /// Asks for the dataset's lock.
    fn sweep(&self) -> Result<(), ShardError> {
        // The dataset's lock is held: nobody is at work on these.
        for path in [DATASET, CARD, CROISSANT] {
            remove(&self.root.join(temporary(path)))?;
        }
        let mut shards = Vec::new();
        for directory in DIRECTORIES {
            let found = names(&self.root.join(directory))?;
            shards.extend(found.iter().filter_map(|name| left_behind(name)));
        }
        shards.sort_unstable();
        shards.dedup();
        for shard in shards {
            if let Some(_lock) = Lock::try_take(&self.lock_path(shard))?
                && !self.is_done(shard)
            {
                self.clear(shard)?;
            }
        }
        Ok(())
    }
}

/// Writes card and metadata where they are not as they should be. Asks for the dataset's lock.
fn describe(root: &Path, head: &DatasetHead, present: &[Split], counts: &Counts) -> Result<(), ShardError> {
    let path = root.join(DATASET);
    let document = fs::read(&path).map_err(|e| ShardError::io("read", &path, e))?;
    for (name, text) in descriptions(head, present, counts, &document) {
        if !fs::read(root.join(name)).is_ok_and(|found| found == text) {
            write_whole(root, name, &text)?;
        }
    }
    Ok(())
}

/// Card and metadata of a dataset whose `present` splits have files; `counts` is empty while it is not finished, `document` is
/// `dataset.json` as it is on disk.
pub(crate) fn descriptions(
    head: &DatasetHead,
    present: &[Split],
    counts: &Counts,
    document: &[u8],
) -> [(&'static str, Vec<u8>); 2] {
    let card = card::card(head, present, counts).into_bytes();
    [(CARD, card), (CROISSANT, croissant::croissant(head, present, document))]
}

/// The shard that a temporary name or a lock belongs to.
fn left_behind(name: &str) -> Option<u64> {
    let name = name.strip_prefix(TEMPORARY).or_else(|| name.strip_prefix(LOCK))?;
    let stem = name.split('.').next()?;
    stem.rsplit('-').next()?.parse().ok()
}

fn needed(directory: &str, head: &DatasetHead) -> bool {
    match directory {
        "exr" => !head.images.exr.is_empty(),
        "stacks" => head.images.stack_every.is_some(),
        _ => true,
    }
}

/// `dataset.json` of a folder; `None` where there is none.
fn read_head(root: &Path) -> Result<Option<DatasetHead>, ShardError> {
    let (path, remedy) = (root.join(DATASET), "choose another folder, or bring the file back");
    let head: Option<DatasetHead> = read_document(&path, remedy)?;
    let size = |head: &DatasetHead| DatasetHead::refuse_size(head.samples, head.samples_per_shard, head.shards);
    match head.as_ref().and_then(size) {
        Some(reason) => Err(ShardError::Refused { path, reasons: vec![reason], remedy }),
        None => Ok(head),
    }
}

/// A document with format and version; `None` where there is none.
fn read_document<T: serde::de::DeserializeOwned>(path: &Path, remedy: &'static str) -> Result<Option<T>, ShardError> {
    let text = match atomic_file::read(path) {
        Ok(text) => text,
        Err(e) if e.kind() == ErrorKind::NotFound => return Ok(None),
        Err(e) => return Err(ShardError::io("read", path, e)),
    };
    let refused = |reason: String| ShardError::Refused { path: path.into(), reasons: vec![reason], remedy };
    let value: serde_json::Value =
        serde_json::from_slice(&text).map_err(|e| refused(format!("it cannot be read: {e}")))?;
    // The version first: a newer document may have other keys.
    let version = serde_json::from_value(value["schema_version"].clone()).unwrap_or([0, 0]);
    if let Some(reason) = refuse_version(value["format"].as_str().unwrap_or(""), version) {
        return Err(refused(reason));
    }
    serde_json::from_value(value).map(Some).map_err(|e| refused(format!("it cannot be read: {e}")))
}

/// A document as it is written: indented, with a last line end.
pub(crate) fn document<T: serde::Serialize>(document: &T) -> Vec<u8> {
    // Heads and manifests are plain data with text keys: they always become JSON.
    let mut text = serde_json::to_vec_pretty(document).unwrap_or_default();
    text.push(b'\n');
    text
}
