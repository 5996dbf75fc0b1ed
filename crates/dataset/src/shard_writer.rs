//! Shard writer: one shard, samples in order of index, straight to disk.

use std::io::Write;
use std::path::Path;
use std::sync::Arc;

use arrow_array::RecordBatch;
use arrow_schema::SchemaRef;
use output_schema::arrow::{row_schema, stack_schema};
use output_schema::file::{data_path, exr_folder, exr_path, manifest_path, shard_folder, stack_path, temporary};
use output_schema::{DatasetHead, Manifest, ManifestFile, ManifestSample, SCHEMA_VERSION};

use super::atomic_file::{FileError, sha256};
use super::enclosed;
use super::folder::{DIRECTORIES, needed, shard_lock};
use super::lock::Lock;
use super::reader::to_document;
use super::sample_rows::{row_batch, stack_batch};
use super::shard_size::TABLES_BYTES;
use super::table_writer::TableWriter;
use super::{Dataset, Encoded, Fault};
use optical_bench::split::Split;

/// A shard in the making. Dropped before [`ShardWriter::finish`], it removes what it wrote.
#[derive(Debug)]
pub struct ShardWriter {
    dataset: Dataset,
    shard: u64,
    rows: SchemaRef,
    frames: SchemaRef,
    tables: [Option<TableWriter>; Split::ALL.len()],
    stack: Option<TableWriter>,
    exr: Vec<ManifestFile>,
    samples: Vec<ManifestSample>,
    bytes: u64,
    finished: bool,
    /// Held to the very end: fields are dropped after the cleaning up in `drop`.
    lock: Option<Lock>,
}

/// What comes of asking for a shard to write.
#[derive(Debug)]
pub enum Claim {
    /// It is the caller's.
    Granted(Box<ShardWriter>),
    /// Another process writes it.
    Busy,
    /// It is finished.
    Done,
}

impl ShardWriter {
    /// Takes the shard's lock and removes what an earlier attempt left. First index and count follow from the head as
    /// it is then: another process may have extended the dataset since it was opened.
    ///
    /// # Errors
    /// Where the folder cannot be read or written, or holds something else under a name of the shard.
    pub fn claim(dataset: &Dataset, shard: u64) -> Result<Claim, Fault> {
        match Lock::try_take(dataset.root(), &shard_lock(shard), dataset.has_locks)? {
            Some(lock) => Self::begin(dataset, shard, lock),
            None => Ok(Claim::Busy),
        }
    }

    /// The same; where another process holds the shard, calls `waits` and waits for it. Never [`Claim::Busy`].
    ///
    /// # Errors
    /// As [`ShardWriter::claim`].
    pub fn claim_when_free(dataset: &Dataset, shard: u64, waits: &dyn Fn()) -> Result<Claim, Fault> {
        Self::begin(dataset, shard, Lock::take(dataset.root(), &shard_lock(shard), dataset.has_locks, waits)?)
    }

    fn begin(dataset: &Dataset, shard: u64, lock: Lock) -> Result<Claim, Fault> {
        let dataset = dataset.renewed()?;
        if dataset.is_done(shard)? {
            lock.release()?;
            return Ok(Claim::Done);
        }
        dataset.clear(shard)?;
        let head = dataset.head();
        let (rows, frames) = (Arc::new(row_schema(head)), Arc::new(stack_schema(head)));
        let mut writer = Self {
            shard,
            rows,
            frames,
            tables: [None, None, None],
            stack: None,
            exr: Vec::new(),
            samples: Vec::new(),
            bytes: 0,
            finished: false,
            lock: Some(lock),
            dataset,
        };
        let images = &writer.dataset.head().images;
        for folder in shard_folders(writer.dataset.head(), shard) {
            enclosed::make_folder(writer.root(), &folder)?;
        }
        if writer.dataset.head().has_exr() {
            enclosed::make_folder(writer.root(), &temporary(&exr_folder(shard)))?;
        }
        if images.stack_every.is_some() {
            writer.stack = Some(TableWriter::create(writer.root(), stack_path(shard), writer.frames.clone())?);
        }
        Ok(Claim::Granted(Box::new(writer)))
    }

    /// First index and count of the shard's samples.
    pub fn span(&self) -> (u64, u64) {
        self.dataset.head().span(self.shard)
    }

    /// Number of the next sample.
    pub fn next(&self) -> u64 {
        self.span().0 + self.samples.len() as u64
    }

    /// Whether every sample is written.
    pub fn is_full(&self) -> bool {
        self.samples.len() as u64 >= self.span().1
    }

    /// Writes the next sample.
    ///
    /// # Errors
    /// Where it is not the next one or not what `dataset.json` promises, before anything of it is written; where the
    /// disk refuses, after which the writer can only be dropped.
    pub fn push(&mut self, sample: Encoded) -> Result<(), Fault> {
        let (row, frames) = self.tabulate(&sample).map_err(|what| self.misfit(sample.index, what))?;
        let (bytes, done) = (sample.bytes(), self.samples.len() as u64);
        let needed = (self.bytes + bytes) / (done + 1) * self.span().1.saturating_sub(done) + TABLES_BYTES;
        self.write(sample, &row, frames.as_ref()).map_err(|error| Fault::of_file(error, Some(needed)))?;
        self.bytes += bytes;
        Ok(())
    }

    /// The rows of a sample, or why it does not fit.
    fn tabulate(&self, sample: &Encoded) -> Result<(RecordBatch, Option<RecordBatch>), String> {
        let next = self.next();
        if sample.index != next || self.is_full() {
            let (first, count) = self.span();
            return Err(format!("sample {next} of {} to {} is next", first, first + count));
        }
        let row = row_batch(&self.rows, self.dataset.head(), sample)?;
        let frames = stack_batch(&self.frames, sample)?;
        if frames.is_some() && self.stack.is_none() {
            return Err("it has sensor frames, which dataset.json does not promise".into());
        }
        if sample.exr.is_some() != self.dataset.head().has_exr() {
            return Err("its EXR file is missing, or not promised by dataset.json".into());
        }
        Ok((row, frames))
    }

    fn misfit(&self, index: u64, what: String) -> Fault {
        let place = format!("sample {index} does not fit shard {}", self.shard);
        Fault::new(place, what, "this is a fault of the program, please report it")
    }

    fn write(&mut self, sample: Encoded, row: &RecordBatch, frames: Option<&RecordBatch>) -> Result<(), FileError> {
        let shard = self.shard;
        let root = self.dataset.root().to_path_buf();
        let table = &mut self.tables[sample.split as usize];
        let table = match table {
            Some(table) => table,
            None => table.insert(TableWriter::create(&root, data_path(sample.split.name(), shard), self.rows.clone())?),
        };
        table.write(row)?;
        if let (Some(table), Some(frames)) = (&mut self.stack, frames) {
            table.write(frames)?;
        }
        if let Some(exr) = &sample.exr {
            let partial = format!("{}/{}.exr", temporary(&exr_folder(shard)), sample.id);
            let written = enclosed::create(&root, &partial)?.write_all(exr);
            written.map_err(FileError::of("write", &root.join(&partial)))?;
            let path = exr_path(shard, &sample.id);
            self.exr.push(ManifestFile { path, bytes: exr.len() as u64, sha256: sha256(exr), rows: None });
        }
        self.samples.push(ManifestSample {
            index: sample.index,
            sha256: sample.sha256(),
            id: sample.id,
            split: sample.split.name().into(),
            class: sample.class,
        });
        Ok(())
    }

    /// Closes, syncs and names every file, then writes the manifest. Only after this does the shard count.
    ///
    /// # Errors
    /// Where samples are missing, or the disk refuses; nothing of the shard is left then, unless it is the lock alone
    /// that could not be removed.
    pub fn finish(mut self) -> Result<Manifest, Fault> {
        if !self.is_full() {
            return Err(self.misfit(self.next(), "the shard was to be finished before it was written".into()));
        }
        let root = self.dataset.root().to_path_buf();
        let mut files = Vec::new();
        let tables: Vec<_> = self.tables.iter_mut().chain([&mut self.stack]).filter_map(Option::take).collect();
        // What tables still hold in memory goes to the disk only now.
        let needed = tables.iter().map(TableWriter::unwritten_bytes).sum::<u64>() + TABLES_BYTES;
        for table in tables {
            files.push(table.finish().map_err(|error| Fault::of_file(error, Some(needed)))?);
        }
        files.append(&mut self.exr);
        if self.dataset.head().has_exr() {
            self.name_exr()?;
        }
        for folder in shard_folders(self.dataset.head(), self.shard) {
            enclosed::sync_folder(&root, &folder)?;
            if let Some((above, _)) = folder.rsplit_once('/') {
                enclosed::sync_folder(&root, above)?;
            }
        }
        files.sort_by(|a, b| a.path.cmp(&b.path));
        let (head, (first, count)) = (self.dataset.head(), self.span());
        let manifest = Manifest {
            format: head.format.clone(),
            schema_version: SCHEMA_VERSION,
            generator: head.generator.clone(),
            recipe_hash: head.recipe.hash.clone(),
            seed: head.seed,
            shard: self.shard,
            first,
            count,
            files,
            samples: std::mem::take(&mut self.samples),
        };
        enclosed::write(&root, &manifest_path(self.shard), &to_document(&manifest))?;
        self.finished = true;
        if let Some(lock) = self.lock.take() {
            lock.release()?;
        }
        Ok(manifest)
    }

    fn name_exr(&self) -> Result<(), FileError> {
        let (root, whole) = (self.root(), exr_folder(self.shard));
        let partial = temporary(&whole);
        for sample in &self.samples {
            let file = format!("{partial}/{}.exr", sample.id);
            enclosed::sync(root, &file)?;
        }
        enclosed::sync_folder(root, &partial)?;
        enclosed::rename(root, &partial, &whole)
    }

    fn root(&self) -> &Path {
        self.dataset.root()
    }
}

/// The folders in which a shard has files.
fn shard_folders(head: &DatasetHead, shard: u64) -> impl Iterator<Item = String> {
    DIRECTORIES.into_iter().filter(|name| needed(name, head)).map(move |name| shard_folder(name, shard))
}

impl Drop for ShardWriter {
    fn drop(&mut self) {
        if !self.finished {
            self.tables = [None, None, None];
            self.stack = None;
            // What cannot be removed now has a temporary name, or no manifest, and is removed by the next attempt.
            let _ = self.dataset.clear(self.shard);
        }
    }
}
