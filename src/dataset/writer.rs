//! Writing one shard: samples in order of index, straight to disk.

use std::fs::{self, File};
use std::path::PathBuf;
use std::sync::Arc;

use arrow_schema::SchemaRef;
use output_schema::arrow::{row_schema, stack_schema};
use output_schema::file::{data_path, exr_folder, exr_path, manifest_path, stack_path, temporary};
use output_schema::{Manifest, ManifestFile, ManifestSample, SCHEMA_VERSION};

use super::durable::{create_directory, rename, sha256, sync_directory, write_whole};
use super::folder::document;
use super::lock::Lock;
use super::rows::{row_batch, stack_batch};
use super::table::Table;
use super::{DatasetFolder, Encoded, ShardError};
use crate::split::Split;

/// A shard in the making. Dropped before [`ShardWriter::finish`], it removes what it wrote.
#[derive(Debug)]
pub struct ShardWriter {
    folder: DatasetFolder,
    shard: u64,
    first: u64,
    count: u64,
    rows: SchemaRef,
    frames: SchemaRef,
    tables: [Option<Table>; Split::ALL.len()],
    stack: Option<Table>,
    exr: Vec<ManifestFile>,
    samples: Vec<ManifestSample>,
    bytes: u64,
    finished: bool,
    /// Held to the very end: fields are dropped after the cleaning up in `drop`.
    _lock: Lock,
}

impl ShardWriter {
    /// Takes the shard's lock and removes what an earlier attempt left. First index and count follow from the head.
    ///
    /// # Errors
    /// [`ShardError::Busy`] and [`ShardError::Done`], see [`ShardError::is_skip`]; [`ShardError::Io`].
    pub fn create(folder: &DatasetFolder, shard: u64) -> Result<Self, ShardError> {
        let lock = Lock::try_take(&folder.lock_path(shard))?.ok_or(ShardError::Busy { shard })?;
        if folder.is_done(shard) {
            return Err(ShardError::Done { shard });
        }
        folder.clear(shard)?;
        let head = folder.head();
        let (first, count) = head.span(shard);
        let (rows, frames) = (Arc::new(row_schema(head)), Arc::new(stack_schema(head)));
        let mut writer = Self {
            folder: folder.clone(),
            shard,
            first,
            count,
            rows,
            frames,
            tables: [None, None, None],
            stack: None,
            exr: Vec::new(),
            samples: Vec::new(),
            bytes: 0,
            finished: false,
            _lock: lock,
        };
        if !head.images.exr.is_empty() {
            create_directory(&writer.path(&temporary(&exr_folder(shard))))?;
        }
        if head.images.stack_every.is_some() {
            writer.stack = Some(Table::create(folder.root(), stack_path(shard), writer.frames.clone())?);
        }
        Ok(writer)
    }

    /// First index and count of the shard's samples.
    pub fn span(&self) -> (u64, u64) {
        (self.first, self.count)
    }

    /// Writes the next sample.
    ///
    /// # Errors
    /// [`ShardError::Misfit`] where it is not the next one or not what `dataset.json` promises; [`ShardError::Io`] and
    /// [`ShardError::DiskFull`], after which the writer can only be dropped.
    pub fn push(&mut self, sample: Encoded) -> Result<(), ShardError> {
        let (bytes, done) = (sample.bytes(), self.samples.len() as u64);
        let left = self.count.saturating_sub(done);
        let needed = (self.bytes + bytes) / (done + 1) * left;
        self.write(sample).map_err(|e| e.needing(needed))?;
        self.bytes += bytes;
        Ok(())
    }

    fn write(&mut self, sample: Encoded) -> Result<(), ShardError> {
        let (shard, index) = (self.shard, sample.index);
        let misfit = |reason: String| ShardError::Misfit { shard, index, reason };
        let next = self.first + self.samples.len() as u64;
        if index != next || next >= self.first + self.count {
            return Err(misfit(format!("sample {next} of {} to {} is next", self.first, self.first + self.count)));
        }
        let row = row_batch(&self.rows, self.folder.head(), &sample).map_err(misfit)?;
        let root = self.folder.root().to_path_buf();
        let table = &mut self.tables[sample.split as usize];
        let table = match table {
            Some(table) => table,
            None => table.insert(Table::create(&root, data_path(sample.split.name(), shard), self.rows.clone())?),
        };
        table.write(&row)?;

        match (&mut self.stack, stack_batch(&self.frames, &sample).map_err(misfit)?) {
            (Some(table), Some(frames)) => table.write(&frames)?,
            (None, Some(_)) => return Err(misfit("it has sensor frames, which dataset.json does not promise".into())),
            (_, None) => {}
        }
        if sample.exr.is_some() == self.folder.head().images.exr.is_empty() {
            return Err(misfit("its EXR file is missing, or not promised by dataset.json".into()));
        }
        if let Some(exr) = &sample.exr {
            let partial = self.path(&format!("{}/{}.exr", temporary(&exr_folder(shard)), sample.id));
            fs::write(&partial, exr).map_err(|e| ShardError::io("write", &partial, e))?;
            let path = exr_path(shard, &sample.id);
            self.exr.push(ManifestFile { path, bytes: exr.len() as u64, sha256: sha256(exr), rows: None });
        }
        self.samples.push(ManifestSample {
            index,
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
    /// [`ShardError::Misfit`] where samples are missing; [`ShardError::Io`] and [`ShardError::DiskFull`], after which
    /// nothing of the shard is left.
    pub fn finish(mut self) -> Result<Manifest, ShardError> {
        if (self.samples.len() as u64) < self.count {
            let index = self.first + self.samples.len() as u64;
            let reason = "the shard was to be finished before it was written".into();
            return Err(ShardError::Misfit { shard: self.shard, index, reason });
        }
        let root = self.folder.root().to_path_buf();
        let mut files = Vec::new();
        for table in self.tables.iter_mut().chain([&mut self.stack]).filter_map(Option::take) {
            files.push(table.finish()?);
        }
        files.append(&mut self.exr);
        let images = &self.folder.head().images;
        sync_directory(&root.join("data"))?;
        if images.stack_every.is_some() {
            sync_directory(&root.join("stacks"))?;
        }
        if !images.exr.is_empty() {
            self.name_exr()?;
        }
        files.sort_by(|a, b| a.path.cmp(&b.path));
        let head = self.folder.head();
        let manifest = Manifest {
            format: head.format.clone(),
            schema_version: SCHEMA_VERSION,
            generator: head.generator.clone(),
            recipe_hash: head.recipe.hash.clone(),
            seed: head.seed,
            shard: self.shard,
            first: self.first,
            count: self.count,
            files,
            samples: std::mem::take(&mut self.samples),
        };
        write_whole(&root, &manifest_path(self.shard), &document(&manifest))?;
        self.finished = true;
        Ok(manifest)
    }

    fn name_exr(&self) -> Result<(), ShardError> {
        let (whole, exr) = (self.path(&exr_folder(self.shard)), self.path("exr"));
        let partial = self.path(&temporary(&exr_folder(self.shard)));
        for sample in &self.samples {
            let file = partial.join(format!("{}.exr", sample.id));
            File::open(&file).and_then(|file| file.sync_all()).map_err(|e| ShardError::io("sync", &file, e))?;
        }
        sync_directory(&partial)?;
        rename(&partial, &whole)?;
        sync_directory(&exr)
    }

    fn path(&self, relative: &str) -> PathBuf {
        self.folder.root().join(relative)
    }
}

impl Drop for ShardWriter {
    fn drop(&mut self) {
        if !self.finished {
            self.tables = [None, None, None];
            self.stack = None;
            // What cannot be removed now has a temporary name, or no manifest, and is removed by the next attempt.
            let _ = self.folder.clear(self.shard);
        }
    }
}
