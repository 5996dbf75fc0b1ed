//! Dataset folder: beginning, continuing and completing a dataset; what is done of it is read as everybody reads it.

use std::fs;
use std::path::{Path, PathBuf};

use output_schema::DatasetHead;
use output_schema::file::{
    CARD, CROISSANT, DATASET, LOCK, TEMPORARY, data_path, exr_folder, manifest_path, stack_path, temporary,
};

use super::atomic_file::{FileError, create_directory, names, remove, write_in};
use super::card::ClassCounts;
use super::lock::Lock;
use super::reader::{read_head, to_document, unusable};
use super::{Dataset, Fault, card, croissant, differences};
use bench::split::Split;

/// Directories of a dataset folder.
const DIRECTORIES: [&str; 4] = ["data", "exr", "stacks", "shards"];

impl Dataset {
    /// Opens the dataset at `path`, or begins it. A larger number of samples extends it, a smaller one changes nothing.
    /// Several processes may do this at once.
    ///
    /// # Errors
    /// Where the folder holds another dataset or other files, each difference named, or cannot be written.
    pub fn open_or_create(path: &Path, head: DatasetHead) -> Result<Self, Fault> {
        let foreign = |name: &String| !(name.starts_with(LOCK) || name.starts_with(TEMPORARY));
        if !path.join(DATASET).exists() && names(path)?.iter().any(foreign) && !path.join(DATASET).exists() {
            return Err(unusable(path, format!("it is not empty and holds no {DATASET}"), "choose an empty folder"));
        }
        create_directory(path)?;
        let _lock = Lock::take(&path.join(format!("{LOCK}dataset")))?;
        let old = read_head(path)?;
        let mut new = head;
        if let Some(old) = &old {
            let reasons = differences::reasons_to_refuse(old, &new);
            if !reasons.is_empty() {
                let remedy = "choose another folder, or run the recipe, seed and program that began this one";
                return Err(unusable(path, reasons.join("; "), remedy));
            }
            new.samples = new.samples.max(old.samples);
            new.recipe = old.recipe.clone();
        }
        new.shards = DatasetHead::shards_for(new.samples, new.samples_per_shard);
        // The head comes first: whoever finds a folder with more than locks and temporary names finds it too.
        if old.as_ref() != Some(&new) {
            write_in(path, DATASET, &to_document(&new))?;
        }
        for directory in DIRECTORIES.iter().filter(|&&name| needed(name, &new)) {
            create_directory(&path.join(directory))?;
        }
        let extended = old.as_ref().is_none_or(|old| old.samples != new.samples);
        if extended || [CARD, CROISSANT].iter().any(|name| !path.join(name).exists()) {
            describe(path, &new, &Split::ALL, &ClassCounts::new())?;
        }
        let folder = Self::of(path, new);
        folder.sweep()?;
        Ok(folder)
    }

    /// Keeps a file that the recipe names, under its path in the folder; one that is there as it should be stays.
    ///
    /// # Errors
    /// Where the folder cannot be written.
    pub fn keep(&self, path: &str, content: &[u8]) -> Result<(), Fault> {
        let _lock = Lock::take(&self.root().join(format!("{LOCK}dataset")))?;
        if fs::read(self.root().join(path)).is_ok_and(|found| found == content) {
            return Ok(());
        }
        create_directory(&self.root().join("assets"))?;
        Ok(write_in(self.root(), path, content)?)
    }

    /// To call when no shard remains: card and metadata then name only splits that have files, as `datasets` asks.
    ///
    /// # Errors
    /// Where the folder cannot be written.
    pub fn complete(&self) -> Result<(), Fault> {
        let _lock = Lock::take(&self.root().join(format!("{LOCK}dataset")))?;
        let files = names(&self.root().join("data"))?;
        let present: Vec<Split> =
            Split::ALL.into_iter().filter(|split| files.iter().any(|f| f.starts_with(split.name()))).collect();
        let mut counts = ClassCounts::new();
        for shard in 0..self.head().shards {
            for sample in self.manifest(shard)?.into_iter().flat_map(|manifest| manifest.samples) {
                *counts.entry((sample.class, sample.split)).or_default() += 1;
            }
        }
        describe(self.root(), self.head(), &present, &counts)
    }

    pub(super) fn lock_path(&self, shard: u64) -> PathBuf {
        self.root().join(format!("shards/{LOCK}{shard:05}"))
    }

    /// Removes every file of a shard, finished or not; the manifest goes first. Asks for the shard's lock.
    pub(super) fn clear(&self, shard: u64) -> Result<(), Fault> {
        let mut paths = vec![manifest_path(shard), exr_folder(shard), stack_path(shard)];
        paths.extend(Split::ALL.map(|split| data_path(split.name(), shard)));
        for path in paths {
            remove(&self.root().join(&path))?;
            remove(&self.root().join(temporary(&path)))?;
        }
        Ok(())
    }

    /// Removes what processes left behind that were killed: temporary names and locks of shards that nobody holds.
    /// Asks for the dataset's lock.
    fn sweep(&self) -> Result<(), Fault> {
        // The dataset's lock is held: nobody is at work on these.
        for path in [DATASET, CARD, CROISSANT] {
            remove(&self.root().join(temporary(path)))?;
        }
        let mut shards = Vec::new();
        for directory in DIRECTORIES {
            let found = names(&self.root().join(directory))?;
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
fn describe(root: &Path, head: &DatasetHead, present: &[Split], counts: &ClassCounts) -> Result<(), Fault> {
    let path = root.join(DATASET);
    let document = fs::read(&path).map_err(FileError::of("read", &path))?;
    for (name, text) in descriptions(head, present, counts, &document) {
        if !fs::read(root.join(name)).is_ok_and(|found| found == text) {
            write_in(root, name, &text)?;
        }
    }
    Ok(())
}

/// Card and metadata of a dataset whose `present` splits have files; `counts` is empty while it is not finished, `document` is
/// `dataset.json` as it is on disk.
pub(crate) fn descriptions(
    head: &DatasetHead,
    present: &[Split],
    counts: &ClassCounts,
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
