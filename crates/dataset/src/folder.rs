//! Dataset folder: beginning, continuing and completing a dataset; what is done of it is read as everybody reads it.
//!
//! - One process at a time holds a shard, by a lock of the kernel on `shards/.lock-<shard>`; the folder has one for its
//!   documents. Shards that others hold come last and are waited for: exit status 0 means that all is there.
//! - Whoever opens the folder to write removes temporary names, and shards that nobody holds and that have no manifest.
//!   These are names that this program makes for shards of this dataset, to the letter; others stay.
//! - A manifest that cannot be read is a fault: somebody finished its shard, so it is not made again.
//! - `dataset.json` is read anew before each shard, and before card and metadata are finished: another process may have
//!   extended the dataset.
//! - To continue is to make the shards that are not finished. Recipe, seed, version, target and shard size must be the
//!   same, else each difference is named. A larger number of samples extends the dataset; of a smaller one only the
//!   shards with these samples are made.
//! - A dataset of which nothing is made or held takes another number and another size of shards; one of many parts may
//!   not do that, since it does not know what others have elsewhere.
//! - No dataset begins in another one's folder, and commands write nothing there but under `reports/`.

use std::fs;
use std::io::{Error, ErrorKind};
use std::path::Path;

use output_schema::DatasetHead;
use output_schema::file::{
    CARD, CROISSANT, DATASET, LOCK, SHARDS_PER_FOLDER, TEMPORARY, data_path, exr_folder, manifest_path, shard_folder,
    stack_path, temporary,
};

use super::atomic_file::FileError;
use super::card::ClassCounts;
use super::lock::Lock;
use super::reader::{read_head, to_document, unusable};
use super::table_reader::is_id;
use super::{Dataset, Fault, card, croissant, differences, enclosed, largest};
use optical_bench::split::Split;

/// Directories of a dataset folder.
pub(super) const DIRECTORIES: [&str; 4] = ["data", "exr", "stacks", "shards"];

/// Reasons against continuing a dataset that one fault names, and those that it names first: what the objects are.
const MAX_NAMED_REASONS: usize = 8;
const FIRST_KEYS: [&str; 2] = ["recipe.subject:", "recipe.name:"];

impl Dataset {
    /// Opens the dataset at `path`, or begins it. A larger number of samples extends it, a smaller one changes nothing.
    /// Several processes may do this at once; `waits` is called before it waits for another one that holds the folder.
    /// Where it may begin `anew`, a dataset of which nothing is made, and nothing is being made, takes the sizes of
    /// `head`: a smaller number of samples, or shards of another size. Not for one of many parts, which does not know
    /// what others have made elsewhere.
    ///
    /// # Errors
    /// Where the folder holds another dataset or other files, each difference named, or a link, or cannot be written.
    pub fn open_or_create(path: &Path, head: DatasetHead, anew: bool, waits: &dyn Fn()) -> Result<Self, Fault> {
        let foreign = |name: &String| *name != folder_lock() && !is_begun(name);
        if !is_there(path, DATASET)? && names(path, "")?.iter().any(foreign) && !is_there(path, DATASET)? {
            return Err(unusable(path, format!("it is not empty and holds no {DATASET}"), "choose an empty folder"));
        }
        fs::create_dir_all(path).map_err(FileError::of("create", path))?;
        let lock = Lock::take(path, &folder_lock(), None, waits)?;
        let old = read_head(path)?;
        let mut new = head;
        if let Some(old) = &old {
            let mut reasons = differences::reasons_to_refuse(old, &new);
            let only_size = reasons.iter().all(|reason| reason.starts_with("samples_per_shard"));
            let is_other = !reasons.is_empty() || new.samples < old.samples;
            if !(anew && only_size && is_other && Self::of(path, old.clone()).nothing_is_made(&lock)?) {
                if !reasons.is_empty() {
                    let remedy = if only_size {
                        "leave out --samples-per-shard, which a dataset keeps from its first finished shard on, or \
                            choose \
                         another folder"
                    } else {
                        "choose another folder, or run the recipe, seed and program that began this one"
                    };
                    reasons.sort_by_key(|reason| !FIRST_KEYS.iter().any(|key| reason.starts_with(key)));
                    return Err(unusable(path, differences::shortened(&reasons, MAX_NAMED_REASONS), remedy));
                }
                new.samples = new.samples.max(old.samples);
            }
            new.recipe = old.recipe.clone();
        }
        new.shards = DatasetHead::shards_for(new.samples, new.samples_per_shard);
        // The head comes first: whoever finds a folder with more than locks and temporary names finds it too.
        let is_same = old.as_ref() == Some(&new);
        if !is_same {
            let document = to_document(&new);
            if document.len() as u64 > largest::DOCUMENT_BYTES {
                let what = format!("{DATASET} would have {} bytes", document.len());
                return Err(unusable(path, what, "give a shorter recipe: nobody reads such a document"));
            }
            lock.write(DATASET, &document)?;
        }
        for directory in DIRECTORIES.iter().filter(|&&name| needed(name, &new)) {
            enclosed::make_folder(path, directory)?;
        }
        if !is_same || !is_there(path, CARD)? || !is_there(path, CROISSANT)? {
            describe(&lock, &new, &Split::ALL, &ClassCounts::new())?;
        }
        let mut folder = Self::of(path, new);
        folder.has_locks = Some(lock.is_held());
        if lock.is_held() {
            folder.sweep()?;
        }
        lock.release()?;
        Ok(folder)
    }

    /// Keeps a file that the recipe names, under its path in the folder; one that is there as it should be stays.
    /// `waits` as in [`Dataset::open_or_create`].
    ///
    /// # Errors
    /// Where the folder cannot be written.
    pub fn keep(&self, path: &str, content: &[u8], waits: &dyn Fn()) -> Result<(), Fault> {
        let lock = self.lock(waits)?;
        if !enclosed::holds(self.root(), path, content).map_err(FileError::of("read", &self.root().join(path)))? {
            enclosed::make_folder(self.root(), "assets")?;
            lock.write(path, content)?;
        }
        Ok(lock.release()?)
    }

    /// The lock of the folder's documents.
    fn lock(&self, waits: &dyn Fn()) -> Result<Lock, FileError> {
        Lock::take(self.root(), &folder_lock(), self.has_locks, waits)
    }

    /// A directory and those in it, one for each thousand shards that has files.
    fn parts_of(&self, directory: &str) -> Vec<String> {
        let firsts = (0..self.head().shards).step_by(SHARDS_PER_FOLDER as usize);
        firsts.map(|first| shard_folder(directory, first)).collect()
    }

    /// Whether nothing of its shards is made, or is being made by a process that holds one. Where there are no locks
    /// nobody knows.
    fn nothing_is_made(mut self, lock: &Lock) -> Result<bool, Fault> {
        if !lock.is_held() {
            return Ok(false);
        }
        self.has_locks = Some(true);
        self.sweep()?;
        let folders: Vec<String> = DIRECTORIES.iter().flat_map(|name| self.parts_of(name)).collect();
        for folder in &folders {
            if names(self.root(), folder)?.iter().any(|name| !folders.contains(&format!("{folder}/{name}"))) {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// How many shards have a manifest, told from the names alone.
    ///
    /// # Errors
    /// Where the folder cannot be listed.
    pub fn manifests_named(&self) -> Result<u64, Fault> {
        let mut count = 0;
        for folder in self.parts_of("shards") {
            let own = |name: &&String| {
                let shard = name.strip_suffix(".json").and_then(|digits| digits.parse().ok());
                shard.is_some_and(|shard| {
                    shard < self.head().shards && manifest_path(shard) == format!("{folder}/{name}")
                })
            };
            count += names(self.root(), &folder)?.iter().filter(own).count() as u64;
        }
        Ok(count)
    }

    /// Writes card and metadata of a dataset from its `dataset.json` and manifests alone: other files may lie
    /// elsewhere. Nobody looks whether they are there, or whole.
    ///
    /// # Errors
    /// Where a manifest is missing, damaged or of another dataset; where the folder cannot be written.
    pub fn finish(&self, waits: &dyn Fn()) -> Result<(), Fault> {
        let mut missing = Vec::new();
        for shard in 0..self.head().shards {
            if !self.manifest(shard)?.is_some_and(|manifest| self.is_own(shard, &manifest)) {
                missing.push(shard);
            }
        }
        if !missing.is_empty() {
            let what = format!(
                "{} of {} shards have no manifest of this dataset: {}",
                missing.len(),
                self.head().shards,
                ranges(&missing)
            );
            return Err(unusable(
                self.root(),
                what,
                "make them (gen with the same recipe, seed and folder), or copy their manifests here",
            ));
        }
        let lock = self.lock(waits)?;
        let now = self.renewed()?;
        if now.head().samples != self.head().samples {
            let what = format!("it was extended to {} samples meanwhile", now.head().samples);
            return Err(unusable(self.root(), what, "make the new ones, then finish it again"));
        }
        now.describe_samples(&lock)?;
        Ok(lock.release()?)
    }

    /// To call at the end: where no shard of the dataset remains, as it is by now, card and metadata then count its
    /// samples and name only splits that have files, as `datasets` asks. Whether that is so. `waits` as in
    /// [`Dataset::open_or_create`].
    ///
    /// # Errors
    /// Where the folder cannot be read or written.
    pub fn complete(&self, waits: &dyn Fn()) -> Result<bool, Fault> {
        loop {
            let now = self.renewed()?;
            // One of many parts does not open what the others made: names tell that something remains.
            if now.manifests_named()? < now.head().shards || !now.remaining(0..now.head().shards)?.is_empty() {
                return Ok(false);
            }
            let lock = now.lock(waits)?;
            // Whoever extended it meanwhile has written card and metadata; it is looked at again.
            let is_same = self.renewed()?.head().samples == now.head().samples;
            if is_same {
                now.describe_samples(&lock)?;
            }
            lock.release()?;
            if is_same {
                return Ok(true);
            }
        }
    }

    /// Card and metadata of a dataset whose shards are all there.
    fn describe_samples(&self, lock: &Lock) -> Result<(), Fault> {
        let mut counts = ClassCounts::new();
        for shard in 0..self.head().shards {
            for sample in self.manifest(shard)?.into_iter().flat_map(|manifest| manifest.samples) {
                *counts.entry((sample.class, sample.split)).or_default() += 1;
            }
        }
        let has = |split: &Split| counts.keys().any(|(_, of)| of == split.name());
        let present: Vec<Split> = Split::ALL.into_iter().filter(has).collect();
        describe(lock, self.head(), &present, &counts)
    }

    /// Removes every file of a shard, finished or not; the manifest goes first. Asks for the shard's lock.
    ///
    /// Nothing is removed where something has the name of a file of the shard and is none: a link, or a folder.
    pub(super) fn clear(&self, shard: u64) -> Result<(), Fault> {
        let root = self.root();
        let mut files = vec![manifest_path(shard), stack_path(shard)];
        files.extend(Split::ALL.map(|split| data_path(split.name(), shard)));
        let mut files: Vec<String> = files.into_iter().flat_map(|path| [path.clone(), temporary(&path)]).collect();
        let folders = [exr_folder(shard), temporary(&exr_folder(shard))];
        files.iter().try_for_each(|path| enclosed::check_removable(root, path))?;
        for folder in &folders {
            files.extend(enclosed::own_files(root, folder, |name| name.strip_suffix(".exr").is_some_and(is_id))?);
        }
        files.iter().try_for_each(|path| enclosed::remove(root, path))?;
        Ok(folders.iter().try_for_each(|folder| enclosed::remove_empty_folder(root, folder))?)
    }

    /// Removes what processes left behind that were killed: temporary names and locks of shards that nobody holds. What
    /// no process of this program can have left stays. Asks for the dataset's lock.
    fn sweep(&self) -> Result<(), Fault> {
        // The dataset's lock is held: nobody is at work on these.
        for name in names(self.root(), "")?.iter().filter(|name| is_begun(name)) {
            enclosed::remove(self.root(), name)?;
        }
        for asset in &self.head().assets {
            // Written without locks, by a process that was killed.
            let own = |name: &&String| temporary_of(name).is_some_and(|name| asset.path == format!("assets/{name}"));
            for name in names(self.root(), "assets")?.iter().filter(own) {
                enclosed::remove(self.root(), &format!("assets/{name}"))?;
            }
        }
        let mut shards = Vec::new();
        for directory in DIRECTORIES.iter().flat_map(|name| self.parts_of(name)) {
            let found = names(self.root(), &directory)?;
            shards.extend(found.iter().filter_map(|name| left_behind(&directory, name)));
        }
        shards.sort_unstable();
        shards.dedup();
        for shard in shards.into_iter().filter(|&shard| shard < self.head().shards) {
            if let Some(lock) = Lock::try_take(self.root(), &shard_lock(shard), self.has_locks)? {
                if !self.is_done(shard)? {
                    self.clear(shard)?;
                }
                lock.release()?;
            }
        }
        Ok(())
    }
}

/// Whether it is the temporary name of a document of the folder, with locks or without.
fn is_begun(name: &str) -> bool {
    let own = |rest: &str| [DATASET, CARD, CROISSANT].contains(&rest);
    name.strip_prefix(TEMPORARY).is_some_and(own) || temporary_of(name).is_some_and(own)
}

/// The name behind a temporary one that was given without locks.
fn temporary_of(name: &str) -> Option<&str> {
    let (key, rest) = name.strip_prefix(TEMPORARY)?.split_once('-')?;
    (key.len() == 16 && key.bytes().all(|digit| digit.is_ascii_hexdigit())).then_some(rest)
}

/// Path of the lock of the folder's documents.
fn folder_lock() -> String {
    format!("{LOCK}dataset")
}

/// Path of a shard's lock.
pub(super) fn shard_lock(shard: u64) -> String {
    format!("shards/{LOCK}{shard:05}")
}

/// Whether a plain file of that name lies in the folder, which may not be there itself.
fn is_there(root: &Path, name: &str) -> Result<bool, FileError> {
    match enclosed::length(root, name) {
        Ok(_) => Ok(true),
        Err(e) if e.kind() == ErrorKind::NotFound => Ok(false),
        Err(e) => Err(FileError::of("read", &root.join(name))(e)),
    }
}

fn names(root: &Path, folder: &str) -> Result<Vec<String>, FileError> {
    enclosed::names(root, folder).map_err(FileError::of("list", &root.join(folder)))
}

/// Writes card and metadata where they are not as they should be.
fn describe(lock: &Lock, head: &DatasetHead, present: &[Split], counts: &ClassCounts) -> Result<(), Fault> {
    let root = lock.root();
    let at = |name: &str, e: Error| FileError::of("read", &root.join(name))(e);
    let document = enclosed::read(root, DATASET, largest::DOCUMENT_BYTES).map_err(|e| at(DATASET, e))?;
    for (name, text) in descriptions(head, present, counts, &document) {
        if !enclosed::holds(root, name, &text).map_err(|e| at(name, e))? {
            lock.write(name, &text)?;
        }
    }
    Ok(())
}

/// Card and metadata of a dataset whose `present` splits have files; `counts` is empty while it is not finished,
/// `document` is `dataset.json` as it is on disk.
pub(crate) fn descriptions(
    head: &DatasetHead,
    present: &[Split],
    counts: &ClassCounts,
    document: &[u8],
) -> [(&'static str, Vec<u8>); 2] {
    let card = card::card(head, present, counts).into_bytes();
    [(CARD, card), (CROISSANT, croissant::croissant(head, present, document))]
}

/// The shard that a temporary name or a lock in a folder belongs to; `None` for a name that this program makes nowhere.
fn left_behind(folder: &str, name: &str) -> Option<u64> {
    let rest = name.strip_prefix(TEMPORARY).or_else(|| name.strip_prefix(LOCK))?;
    let digits = rest.split('.').next()?.rsplit('-').next()?;
    let shard: u64 = digits.parse().ok()?;
    let mut own = vec![shard_lock(shard)];
    let files = [exr_folder(shard), stack_path(shard), manifest_path(shard)];
    own.extend(files.iter().map(|path| temporary(path)));
    own.extend(Split::ALL.map(|split| temporary(&data_path(split.name(), shard))));
    own.contains(&format!("{folder}/{name}")).then_some(shard)
}

/// Whether datasets of such a head have files in this directory.
pub(super) fn needed(directory: &str, head: &DatasetHead) -> bool {
    match directory {
        "exr" => head.has_exr(),
        "stacks" => head.images.stack_every.is_some(),
        _ => true,
    }
}

/// Numbers in ascending order as a reader takes them in: `0, 3 to 9`; no more than a few.
fn ranges(numbers: &[u64]) -> String {
    const MOST: usize = 8;
    let mut runs: Vec<[u64; 2]> = Vec::new();
    for &number in numbers {
        match runs.last_mut() {
            Some([_, last]) if *last + 1 == number => *last = number,
            _ => runs.push([number, number]),
        }
    }
    let told = |[first, last]: &[u64; 2]| if first == last { first.to_string() } else { format!("{first} to {last}") };
    let told: Vec<String> = runs.iter().take(MOST).map(told).collect();
    let more = if runs.len() > MOST { ", and others" } else { "" };
    format!("{}{more}", told.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Names of this program lead to their shard, in their folder alone; others to none.
    #[test]
    fn only_own_names_are_left_behind() {
        let own = [
            ("shards", ".lock-00003"),
            ("shards", ".tmp-00003.json"),
            ("data", ".tmp-validation-00003.parquet"),
            ("stacks", ".tmp-00003.parquet"),
            ("exr", ".tmp-00003"),
        ];
        for (folder, name) in own {
            assert_eq!(left_behind(folder, name), Some(3), "{folder}/{name}");
            for other in DIRECTORIES.iter().filter(|other| **other != folder) {
                assert_eq!(left_behind(other, name), None, "{other}/{name}");
            }
        }
        let foreign =
            [".lock-20240101x", ".lock-3", ".lock-+0003", ".lock-a-00003", ".tmp-00003.json.bak", "00003.json"];
        for name in foreign {
            assert!(DIRECTORIES.iter().all(|folder| left_behind(folder, name).is_none()), "{name}");
        }
        assert_eq!(left_behind("shards", ".lock-20240101"), Some(20_240_101), "of a shard that no dataset has");
    }
}
