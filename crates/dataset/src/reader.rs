//! Dataset reader: the one way from the files of a dataset back to rows, images, maps and sensor frames.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use arrow_array::cast::AsArray;
use output_schema::file::{DATASET, data_path, exr_path, manifest_path, stack_path};
use output_schema::{AssetHead, DatasetHead, FORMAT, Manifest, ManifestSample, refuse_version};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use sha2::{Digest, Sha256};

use super::atomic_file::FileError;
use super::exr::ExrContent;
use super::sample_rows::frame_numbers;
use super::table_reader::{RowBatch, RowQuery, Table, guarded, is_id};
use super::{ExrChannel, ExrSize, Fault, TableBounds, differences, enclosed, hex, largest, read_exr, read_exr_of};
use crate::record::StackFrame;
use optical_bench::split::Split;

/// What to do about a `dataset.json` that cannot be used.
const BRING_BACK: &str = "choose another folder, or bring the file back";
/// What to do about a manifest that cannot be used.
const VALIDATE: &str = "run gen validate: it says what is wrong with the dataset";

/// An open dataset: its folder, and `dataset.json`, which is read once.
///
/// A dataset consists of shards; a shard is there when its manifest is. Reading takes what is finished and says how
/// much is not. It trusts the manifests about which file holds what, and checks no sums and no content: `gen validate`
/// does.
///
/// ```
/// use std::path::Path;
///
/// use dataset::{Dataset, Fault, RowQuery};
/// use optical_bench::split::Split;
///
/// /// Widest board of a split, and the samples that were looked at.
/// fn widest(folder: &Path, split: Split) -> Result<(f64, usize), Fault> {
///     let dataset = Dataset::open(folder)?;
///     let (mut widest, mut samples) = (f64::NAN, 0);
///     for table in dataset.tables(Some(split))?.tables {
///         for rows in table.rows(&RowQuery::of(&|column| column == "board"))? {
///             let widths = rows?.numbers("board.width_mm").map_err(|what| table.damaged(what))?;
///             samples += widths.len();
///             widest = widths.into_iter().fold(widest, f64::max);
///         }
///     }
///     Ok((widest, samples))
/// }
///
/// let fault = widest("nowhere".as_ref(), Split::Test).unwrap_err();
/// assert_eq!(fault.to_string(), "cannot use nowhere: it holds no dataset.json; name the folder of a dataset");
/// ```
///
/// # Failures
/// Each is a [`Fault`] with the place and what to do; nothing panics, whatever the files hold.
///
/// | of | when |
/// |---|---|
/// | [`Dataset::open`] | there is no `dataset.json`; it is no JSON, of a newer schema, or its sizes contradict each other |
/// | [`Dataset::manifest`] | it is no JSON, or of a newer schema; a missing one is no failure but `None` |
/// | [`Dataset::tables`] | no shard is finished, or none has samples of the split |
/// | [`Table::rows`] and its items | the file is missing or no Parquet, or a page of it is damaged |
/// | values of a [`RowBatch`] | a column is missing, of another type, or empty where a value must be: a reason in words |
/// | [`Dataset::exr`] | the id is none, the file is missing, or it is no EXR file with the attribute `sheetlight` |
/// | [`Dataset::sensor_frames`] | the manifest does not count them, or they are not where they should be |
#[derive(Debug, Clone)]
pub struct Dataset {
    root: PathBuf,
    head: Arc<DatasetHead>,
    /// Whether the file system keeps processes apart; `None` where nobody has tried.
    pub(super) has_locks: Option<bool>,
}

/// What is finished of a dataset or of one split of it.
#[derive(Debug, Clone)]
pub struct FinishedTables {
    /// Tables in the order of shards, then of splits.
    pub tables: Vec<Table>,
    /// Shards that are not finished.
    pub unfinished: u64,
}

/// SHA-256 of a dataset's documents, hexadecimal: two sums that change when the dataset does, which a saved result
/// names.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DatasetSums {
    /// Of `dataset.json`.
    pub dataset: String,
    /// Of the manifests that are there, one after the other in the order of shards.
    pub manifests: String,
}

impl Dataset {
    /// Opens the dataset at `path` to read it; changes nothing.
    ///
    /// # Errors
    /// Where it is no dataset, or one that this program does not read.
    pub fn open(path: &Path) -> Result<Self, Fault> {
        let missing = || unusable(path, format!("it holds no {DATASET}"), "name the folder of a dataset");
        Ok(Self::of(path, read_head(path)?.ok_or_else(missing)?))
    }

    /// The dataset in the folder `root`, whose `dataset.json` is `head`.
    pub(super) fn of(root: &Path, head: DatasetHead) -> Self {
        Self { root: root.into(), head: Arc::new(head), has_locks: None }
    }

    /// The same dataset with the head that it has now: another process may have extended it.
    ///
    /// # Errors
    /// Where it cannot be read, or is another dataset by now.
    pub(super) fn renewed(&self) -> Result<Self, Fault> {
        let now = Self { has_locks: self.has_locks, ..Self::open(&self.root)? };
        let mut reasons = differences::reasons_to_refuse(&self.head, &now.head);
        if now.head.samples < self.head.samples {
            reasons.push(format!("samples: {} -> {}", self.head.samples, now.head.samples));
        }
        if reasons.is_empty() {
            return Ok(now);
        }
        let what = format!("its {DATASET} was changed meanwhile: {}", reasons.join("; "));
        Err(unusable(&self.root, what, "let nobody change it while it is written, then run the same command again"))
    }

    /// Whether the file system keeps processes apart that write the same shard; known once the dataset was begun or
    /// continued.
    pub fn has_locks(&self) -> bool {
        self.has_locks != Some(false)
    }

    /// The folder.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// `dataset.json`.
    pub fn head(&self) -> &DatasetHead {
        &self.head
    }

    /// The manifest of a finished shard; `None` where the shard is not finished.
    ///
    /// # Errors
    /// Where it is damaged, or one that this program does not read.
    pub fn manifest(&self, shard: u64) -> Result<Option<Manifest>, Fault> {
        read_document(&self.root, &manifest_path(shard), largest::manifest_bytes(&self.head), VALIDATE)
    }

    /// Whether a shard has a manifest, readable or not.
    pub fn has_manifest(&self, shard: u64) -> bool {
        !enclosed::length(&self.root, &manifest_path(shard)).is_err_and(|e| e.kind() == ErrorKind::NotFound)
    }

    /// Whether the shard needs no more work: its manifest is there, counts as many samples as it should, and every file
    /// has its size.
    ///
    /// # Errors
    /// Where that cannot be told: what this process may not read was made by somebody, and is not made again.
    pub fn is_done(&self, shard: u64) -> Result<bool, Fault> {
        let Some(manifest) = self.manifest(shard)? else { return Ok(false) };
        if !self.is_own(shard, &manifest) {
            return Ok(false);
        }
        let paths = manifest.files.iter().map(|file| file.path.as_str());
        for (file, length) in manifest.files.iter().zip(enclosed::lengths(&self.root, paths)) {
            match length {
                Ok(bytes) if bytes == file.bytes => {}
                Ok(_) => return Ok(false),
                Err(e) if e.kind() == ErrorKind::NotFound => return Ok(false),
                Err(e) => return Err(FileError::of("read", &self.root.join(&file.path))(e).into()),
            }
        }
        Ok(true)
    }

    /// Whether a manifest is that of this shard of this dataset, with as many samples as it has now.
    pub(super) fn is_own(&self, shard: u64, manifest: &Manifest) -> bool {
        manifest.recipe_hash == self.head.recipe.hash
            && manifest.generator == self.head.generator
            && manifest.seed == self.head.seed
            && (manifest.first, manifest.count) == self.head.span(shard)
    }

    /// The shards among `shards` that are not done.
    ///
    /// # Errors
    /// As [`Dataset::is_done`].
    pub fn remaining(&self, shards: impl IntoIterator<Item = u64>) -> Result<Vec<u64>, Fault> {
        let mut remaining = Vec::new();
        for shard in shards.into_iter().filter(|&shard| shard < self.head.shards) {
            if !self.is_done(shard)? {
                remaining.push(shard);
            }
        }
        Ok(remaining)
    }

    /// Sums of `dataset.json` and of all manifests; documents that cannot be read count as empty.
    pub fn sums(&self) -> DatasetSums {
        self.sums_of(0..self.head.shards)
    }

    /// The same with the manifests of these shards alone.
    pub fn sums_of(&self, shards: impl IntoIterator<Item = u64>) -> DatasetSums {
        let mut manifests = Sha256::new();
        let most = largest::manifest_bytes(&self.head);
        for shard in shards {
            manifests.update(enclosed::read(&self.root, &manifest_path(shard), most).unwrap_or_default());
        }
        let dataset = enclosed::read(&self.root, DATASET, largest::DOCUMENT_BYTES).unwrap_or_default();
        let dataset = Sha256::digest(dataset);
        DatasetSums { dataset: hex(&dataset), manifests: hex(&manifests.finalize()) }
    }

    /// The copy of a file that the recipe names.
    ///
    /// # Errors
    /// In words, where it is not there or cannot be read.
    pub fn asset(&self, asset: &AssetHead) -> Result<Vec<u8>, String> {
        let read = enclosed::read(&self.root, &asset.path, asset.bytes.min(largest::ASSET_BYTES));
        read.map_err(|e| format!("{}: {e}", self.root.join(&asset.path).display()))
    }

    /// The tables of all finished shards, of one split or of all.
    ///
    /// # Errors
    /// Where there is none, or a manifest is damaged.
    pub fn tables(&self, split: Option<Split>) -> Result<FinishedTables, Fault> {
        let mut found = FinishedTables { tables: Vec::new(), unfinished: 0 };
        for shard in 0..self.head.shards {
            match self.manifest(shard)? {
                None => found.unfinished += 1,
                Some(manifest) => {
                    let tables = self.tables_of(shard, &manifest);
                    found
                        .tables
                        .extend(tables.into_iter().filter(|table| split.is_none_or(|split| split == table.split)));
                }
            }
        }
        if found.tables.is_empty() {
            let (what, remedy) = match split {
                _ if found.unfinished == self.head.shards => {
                    ("no shard of it is finished".into(), "run gen again to finish it")
                }
                Some(split) => (
                    format!("it has no samples of the split `{}`", split.name()),
                    "give --split all, or make more samples",
                ),
                None => ("it has no samples".into(), "make some"),
            };
            return Err(Fault::at(&self.root, what, remedy));
        }
        Ok(found)
    }

    /// The tables that the manifest of a shard names, in the order of splits.
    pub fn tables_of(&self, shard: u64, manifest: &Manifest) -> Vec<Table> {
        let tables = Split::ALL.into_iter().map(|split| self.table(shard, split));
        tables.filter(|table| manifest.files.iter().any(|file| file.path == table.relative)).collect()
    }

    /// The table of a split in a shard, whether it is there or not.
    pub fn table(&self, shard: u64, split: Split) -> Table {
        let relative = data_path(split.name(), shard);
        let bounds = TableBounds::of_rows(&self.head);
        let most_bytes = largest::table_bytes(&self.head);
        Table { path: self.root.join(&relative), root: self.root.clone(), relative, shard, split, most_bytes, bounds }
    }

    /// The shard that a sample belongs to.
    pub fn shard_of(&self, index: u64) -> u64 {
        index / self.head.samples_per_shard.max(1)
    }

    /// The row of a sample that the manifest of its shard lists, with the wanted columns, `index` and `id` among them.
    ///
    /// # Errors
    /// Where it is not where it should be, or cannot be read.
    pub fn row(
        &self,
        manifest: &Manifest,
        listed: &ManifestSample,
        columns: &dyn Fn(&str) -> bool,
    ) -> Result<RowBatch, Fault> {
        let shard = self.shard_of(listed.index);
        let split = Split::ALL.into_iter().find(|split| split.name() == listed.split);
        let unknown =
            || Fault::damaged(&self.root.join(manifest_path(shard)), format!("there is no split `{}`", listed.split));
        let table = self.table(shard, split.ok_or_else(unknown)?);
        let is_before = |other: &&ManifestSample| other.split == listed.split && other.index < listed.index;
        let place = manifest.samples.iter().filter(is_before).count();
        let row = table.row(place, columns)?;
        let damaged = |what| table.damaged(what);
        let is_listed = row.integers("index").map_err(damaged)? == [listed.index as i64];
        if !is_listed || row.texts("id").map_err(damaged)? != [listed.id.as_str()] {
            return Err(damaged(format!("row {place} is not sample {} of id {}", listed.index, listed.id)));
        }
        Ok(row)
    }

    /// The maps of a sample's EXR file.
    ///
    /// # Errors
    /// Where it is missing or damaged.
    pub fn exr(&self, shard: u64, id: &str) -> Result<ExrMaps, Fault> {
        let relative = exr_path(shard, id);
        let path = self.root.join(&relative);
        if !is_id(id) {
            return Err(Fault::damaged(&path, "its name is no id"));
        }
        let bytes = enclosed::read(&self.root, &relative, largest::exr_bytes(&self.head));
        let bytes = bytes.map_err(|e| Fault::damaged(&path, format!("it cannot be read: {e}")))?;
        let maps = guarded(|| read_exr_of(&bytes, &ExrSize::of(&self.head))).map(|content| ExrMaps::of(&path, content));
        maps.map_err(|what| Fault::damaged(&path, what))
    }

    /// The sensor frames of a sample that the manifest of its shard lists, at most `most` of them: the middle ones.
    ///
    /// # Errors
    /// Where they are not where they should be, or cannot be read.
    pub fn sensor_frames(&self, manifest: &Manifest, index: u64, most: usize) -> Result<Vec<StackFrame>, Fault> {
        let relative = stack_path(self.shard_of(index));
        let path = self.root.join(&relative);
        let damaged = |what: String| Fault::damaged(&path, what);
        let rows = manifest.files.iter().find(|file| file.path == relative).and_then(|file| file.rows);
        let rows = rows.ok_or_else(|| damaged("the manifest does not count its rows".into()))?;
        // Each sample of a shard has as many, in order.
        let each = (rows / manifest.samples.len().max(1) as u64) as usize;
        let before = manifest.samples.iter().filter(|sample| sample.index < index).count() * each;
        let take = each.min(most);
        let first = before + (each - take) / 2;
        let query = RowQuery {
            ranges: Some(std::iter::once(first..first + take).collect()),
            at_once: take.clamp(1, 8),
            ..RowQuery::of(&|_| true)
        };
        let mut frames = Vec::new();
        let file = enclosed::open(&self.root, &relative, largest::stack_bytes(&self.head));
        for batch in Table::read(&path, file, &TableBounds::of_frames(&self.head), &query)? {
            let batch = batch?;
            let values = (|| Ok::<_, String>((batch.integers("index")?, batch.integers("profile")?)))();
            let (indices, profiles) = values.map_err(damaged)?;
            let tensors = batch.column("frame").map_err(damaged)?.as_fixed_size_list_opt();
            let tensors = tensors.ok_or_else(|| damaged("the frames are no tensors".into()))?;
            for (row, (found, profile)) in indices.into_iter().zip(profiles).enumerate() {
                if found != index as i64 {
                    return Err(damaged(format!("a sensor frame of sample {index} is not where it should be")));
                }
                let dn = frame_numbers(&tensors.value(row));
                let dn = dn.ok_or_else(|| damaged("the frames are neither uint8 nor uint16".into()))?;
                frames.push(StackFrame { profile: u32::try_from(profile).unwrap_or(0), dn });
            }
        }
        Ok(frames)
    }
}

/// The maps of one sample, as its EXR file holds them.
#[derive(Debug, Clone, PartialEq)]
pub struct ExrMaps {
    /// The file.
    pub path: PathBuf,
    /// Columns [px].
    pub cols: usize,
    /// Rows [px].
    pub rows: usize,
    /// Its channels `[rows, cols]`, row-major.
    pub channels: Vec<ExrChannel>,
    /// The text attribute `sheetlight`: a JSON document.
    pub description: String,
}

impl ExrMaps {
    /// The maps in the bytes of the file at `path`, which lies in no dataset.
    ///
    /// # Errors
    /// What is wrong with it, or that it is larger than any.
    pub fn decode(path: &Path, bytes: &[u8]) -> Result<Self, String> {
        guarded(|| read_exr(bytes)).map(|content| Self::of(path, content))
    }

    fn of(path: &Path, (cols, rows, channels, description): ExrContent) -> Self {
        Self { path: path.into(), cols, rows, channels, description }
    }

    /// The channel of that name, whatever the case of its letters.
    pub fn channel(&self, name: &str) -> Option<&ExrChannel> {
        self.channels.iter().find(|channel| channel.name.eq_ignore_ascii_case(name))
    }
}

/// A folder or document that cannot be used.
pub(super) fn unusable(path: &Path, what: String, remedy: &'static str) -> Fault {
    Fault { tried: Some("use"), ..Fault::at(path, what, remedy) }
}

/// `dataset.json` of a folder; `None` where there is none.
pub(super) fn read_head(root: &Path) -> Result<Option<DatasetHead>, Fault> {
    let head: Option<DatasetHead> = read_document(root, DATASET, largest::DOCUMENT_BYTES, BRING_BACK)?;
    match head.as_ref().and_then(DatasetHead::refuse) {
        Some(reason) => Err(unusable(&root.join(DATASET), reason, BRING_BACK)),
        None => Ok(head),
    }
}

/// What every document says first; a newer one may have other keys beside.
#[derive(Deserialize)]
struct Versioned {
    #[serde(default)]
    format: String,
    #[serde(default)]
    schema_version: [u32; 2],
}

/// Whether a folder is that of a dataset, be it damaged or of another version: not where its `dataset.json` is another
/// program's.
pub fn is_dataset(folder: &Path) -> bool {
    match enclosed::read(folder, DATASET, largest::DOCUMENT_BYTES) {
        Ok(text) => serde_json::from_slice::<serde_json::Value>(&text).map_or(true, |found| found["format"] == FORMAT),
        Err(e) => enclosed::is_strange(&e),
    }
}

/// A document with format and version, of at most `most` bytes; `None` where there is none.
fn read_document<T: DeserializeOwned>(
    root: &Path,
    relative: &str,
    most: u64,
    remedy: &'static str,
) -> Result<Option<T>, Fault> {
    let path = root.join(relative);
    let text = match enclosed::read(root, relative, most) {
        Ok(text) => text,
        Err(e) if e.kind() == ErrorKind::NotFound => return Ok(None),
        Err(e) if e.kind() == ErrorKind::FileTooLarge => return Err(unusable(&path, e.to_string(), remedy)),
        Err(e) => return Err(FileError::of("read", &path)(e).into()),
    };
    let unread = |e: serde_json::Error| unusable(&path, format!("it cannot be read: {e}"), remedy);
    let Versioned { format, schema_version } = serde_json::from_slice(&text).map_err(unread)?;
    if let Some(reason) = refuse_version(&format, schema_version) {
        return Err(unusable(&path, reason, remedy));
    }
    serde_json::from_slice(&text).map(Some).map_err(unread)
}

/// A document as it is written: indented, with a last line end.
pub(crate) fn to_document<T: serde::Serialize>(document: &T) -> Vec<u8> {
    // Heads and manifests are plain data with text keys: they always become JSON.
    let mut text = serde_json::to_vec_pretty(document).unwrap_or_default();
    text.push(b'\n');
    text
}
