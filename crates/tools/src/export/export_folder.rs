//! Export folder: marked as unfinished until its last file is there, each file whole or not at all. What lies in it may
//! come from anybody, as in a dataset's folder: it is opened as there, and no link in it is followed.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::fs::{self, File, TryLockError};
use std::io::{self, BufWriter, ErrorKind, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use output_schema::file::{TEMPORARY, temporary};
use serde_json::{Value, json};

use super::source::ExportSource;
use dataset::atomic_file::FileError;
use dataset::{Fault, GENERATOR_VERSION, enclosed, own_remedy};
use optical_bench::split::Split;

/// What is exported, while it is not finished.
const UNFINISHED_MARKER: &str = ".unfinished-export.json";
/// What was exported, with counts and scales.
pub(crate) const EXPORT_DOCUMENT: &str = "export.json";

/// Most bytes of such a document.
const MAX_DOCUMENT_BYTES: u64 = 64 << 20;

/// What was written.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ExportSummary {
    /// Files.
    pub files: u64,
    /// Their size [bytes].
    pub bytes: u64,
    /// Whether everything was there already.
    pub nothing_to_do: bool,
    /// What the user should know.
    pub notes: Vec<String>,
}

/// The folder of an export that is being written.
#[derive(Debug)]
pub(crate) struct ExportFolder {
    root: PathBuf,
    order: Value,
    /// Holds the lock on the marker until it is closed.
    _marker: File,
    files: AtomicU64,
    bytes: AtomicU64,
}

/// A file of an export that grows; it has its name when it is finished.
#[derive(Debug)]
pub(crate) struct GrowingFile {
    root: PathBuf,
    partial: String,
    relative: String,
    file: BufWriter<File>,
}

impl ExportFolder {
    /// Has `fill` write an export of `source` into its folder; does nothing where it is finished already.
    ///
    /// # Errors
    /// As [`ExportFolder::open`], and where `fill` fails.
    pub(super) fn write(
        root: &Path,
        format: &str,
        options: Value,
        source: &ExportSource,
        fill: impl FnOnce(Self) -> Result<ExportSummary, Fault>,
    ) -> Result<ExportSummary, Fault> {
        match Self::open(root, format, options, source.told())? {
            Some(out) => fill(out),
            None => Ok(ExportSummary { nothing_to_do: true, ..ExportSummary::default() }),
        }
    }

    /// Begins an export, or goes on with an unfinished one of the same order. `None` where it is finished already.
    ///
    /// # Errors
    /// Where the folder holds anything else, or cannot be written.
    pub fn open(root: &Path, format: &str, options: Value, source: Value) -> Result<Option<Self>, Fault> {
        let order = json!({"format": format, "program": GENERATOR_VERSION, "options": options, "source": source});
        fs::create_dir_all(root).map_err(|e| refused(root, &e))?;
        let is_begun = length(root, UNFINISHED_MARKER)?.is_some();
        if length(root, EXPORT_DOCUMENT)?.is_some() {
            let text = enclosed::read(root, EXPORT_DOCUMENT, MAX_DOCUMENT_BYTES);
            let text = text.map_err(|e| refused(&root.join(EXPORT_DOCUMENT), &e))?;
            let found: Value = serde_json::from_slice(&text).unwrap_or_default();
            if found.get("order") != Some(&order) {
                let what = "it holds another export, or one of another state of the dataset";
                return Err(Fault::at(root, what, "choose another folder, or remove it first"));
            }
            // A run that was stopped after its last file left the marker alone to remove.
            if is_begun {
                let _marker = locked(root)?;
                enclosed::remove(root, UNFINISHED_MARKER).map_err(unwritten)?;
            }
            return Ok(None);
        }
        if !is_begun {
            let mut entries = fs::read_dir(root).map_err(|e| refused(root, &e))?.flatten();
            // A marker that was being begun is all that a stopped run may have left.
            if entries.any(|entry| entry.file_name() != *temporary(UNFINISHED_MARKER)) {
                return Err(Fault::at(root, "it is not empty and holds no export", "choose an empty folder"));
            }
            put(root, &temporary(UNFINISHED_MARKER), UNFINISHED_MARKER, format!("{order:#}\n").as_bytes())?;
        }
        let mut marker = locked(root)?;
        // By the handle that holds the lock: Windows lets no other one read.
        let mut text = Vec::new();
        let begun = marker.read_to_end(&mut text).ok().and_then(|_| serde_json::from_slice::<Value>(&text).ok());
        if begun.as_ref().is_none_or(|begun| !is_alike(begun, &order)) {
            let what = "it holds an unfinished export of another kind";
            let remedy =
                format!("repeat the command that began it ({UNFINISHED_MARKER} names it), or remove the folder");
            return Err(Fault::at(root, what, remedy));
        }
        if begun.as_ref() != Some(&order) {
            let what = "it holds an unfinished export of another state of the dataset: shards were added since, or it \
                was made anew";
            return Err(Fault::at(root, what, "remove the folder, or choose another one"));
        }
        for name in enclosed::names(root, "").map_err(|e| refused(root, &e))? {
            if name.starts_with(TEMPORARY) {
                enclosed::remove(root, &name).map_err(unwritten)?;
            }
        }
        let (files, bytes) = (AtomicU64::new(0), AtomicU64::new(0));
        Ok(Some(Self { root: root.to_path_buf(), order, _marker: marker, files, bytes }))
    }

    /// Writes a file, unless a run before has; `content` is asked only where it has not.
    ///
    /// # Errors
    /// Where `content` fails, or the file cannot be written.
    pub fn put(&self, relative: &str, content: impl FnOnce() -> Result<Vec<u8>, Fault>) -> Result<(), Fault> {
        if let Some(bytes) = self.length(relative)? {
            self.count(bytes);
            return Ok(());
        }
        let content = content()?;
        put(&self.root, &self.beside(relative)?, relative, &content)?;
        self.count(content.len() as u64);
        Ok(())
    }

    /// Size of a file that a run before has written [bytes]. A name stands for a whole file; after a loss of power it
    /// may stand for an empty one, which counts as none.
    ///
    /// # Errors
    /// Where something else has its name.
    pub(super) fn length(&self, relative: &str) -> Result<Option<u64>, Fault> {
        Ok(length(&self.root, relative)?.filter(|bytes| *bytes > 0))
    }

    /// A file that a run before has written, to read; `None` where there is none.
    pub(super) fn read(&self, relative: &str) -> Option<File> {
        enclosed::open(&self.root, relative, u64::MAX).ok()
    }

    /// Begins a file that grows.
    ///
    /// # Errors
    /// Where it cannot be made.
    pub fn create(&self, relative: &str) -> Result<GrowingFile, Fault> {
        let partial = self.beside(relative)?;
        let file = BufWriter::new(enclosed::create(&self.root, &partial).map_err(unwritten)?);
        Ok(GrowingFile { root: self.root.clone(), partial, relative: relative.into(), file })
    }

    /// Syncs a file that grew and gives it its name: after a loss of power too the name stands for all of it.
    ///
    /// # Errors
    /// Where it cannot be written.
    pub(crate) fn finish_file(&self, growing: GrowingFile) -> Result<(), Fault> {
        let GrowingFile { root, partial, relative, file } = growing;
        let refused = |e: &io::Error| refused(&root.join(&relative), e);
        let file = file.into_inner().map_err(|e| refused(e.error()))?;
        let bytes = file.sync_all().and_then(|()| file.metadata()).map_err(|e| refused(&e))?.len();
        enclosed::rename(&root, &partial, &relative).map_err(unwritten)?;
        self.count(bytes);
        Ok(())
    }

    /// Counts a file that was written by other means [bytes].
    pub(super) fn count(&self, bytes: u64) {
        self.files.fetch_add(1, Ordering::Relaxed);
        self.bytes.fetch_add(bytes, Ordering::Relaxed);
    }

    /// Makes all files last, says what they are in `export.json`, and takes the marker away.
    ///
    /// # Errors
    /// Where that cannot be written.
    pub fn finish(self, result: &Value, notes: Vec<String>) -> Result<ExportSummary, Fault> {
        enclosed::sync_below(&self.root).map_err(|e| refused(&self.root, &e))?;
        let (files, bytes) = (self.files.into_inner(), self.bytes.into_inner());
        let document = json!({"order": self.order, "files": files, "bytes": bytes, "result": result, "notes": notes});
        enclosed::write(&self.root, EXPORT_DOCUMENT, format!("{document:#}\n").as_bytes()).map_err(unwritten)?;
        enclosed::remove(&self.root, UNFINISHED_MARKER).map_err(unwritten)?;
        Ok(ExportSummary { files, bytes, nothing_to_do: false, notes })
    }

    /// The same error, after the marker was taken away where nothing else was written: the folder is free again.
    pub(super) fn withdrawn(&self, error: Fault) -> Fault {
        let is_marker =
            |entry: io::Result<fs::DirEntry>| entry.is_ok_and(|entry| entry.file_name() == *UNFINISHED_MARKER);
        if fs::read_dir(&self.root).is_ok_and(|mut entries| entries.all(is_marker)) {
            // The first error is the one to tell.
            let _ = enclosed::remove(&self.root, UNFINISHED_MARKER);
        }
        error
    }

    /// The temporary name beside a file, in a folder that is there.
    fn beside(&self, relative: &str) -> Result<String, Fault> {
        if let Some((folder, _)) = relative.rsplit_once('/') {
            enclosed::make_folder(&self.root, folder).map_err(unwritten)?;
        }
        Ok(temporary(relative))
    }
}

impl GrowingFile {
    /// Appends bytes.
    ///
    /// # Errors
    /// Where they cannot be written.
    pub fn push(&mut self, bytes: &[u8]) -> Result<(), Fault> {
        self.file.write_all(bytes).map_err(|e| refused(&self.root.join(&self.relative), &e))
    }

    /// Appends another file that grew, and removes that one.
    ///
    /// # Errors
    /// Where it cannot be read or written.
    pub fn append(&mut self, other: Self) -> Result<(), Fault> {
        let copied = (|| {
            other.file.into_inner().map_err(io::IntoInnerError::into_error)?;
            io::copy(&mut enclosed::open(&other.root, &other.partial, u64::MAX)?, &mut self.file)
        })();
        copied.map_err(|e| refused(&self.root.join(&self.relative), &e))?;
        enclosed::remove(&other.root, &other.partial).map_err(unwritten)
    }
}

/// What belongs to a split, begun where nothing does yet.
pub(super) fn of_split<T>(
    all: &mut BTreeMap<Split, T>,
    split: Split,
    begin: impl FnOnce() -> Result<T, Fault>,
) -> Result<&mut T, Fault> {
    match all.entry(split) {
        Entry::Occupied(entry) => Ok(entry.into_mut()),
        Entry::Vacant(entry) => Ok(entry.insert(begin()?)),
    }
}

/// Whether two orders are the same but for the state of the dataset.
fn is_alike(a: &Value, b: &Value) -> bool {
    let without_state = |order: &Value| {
        let mut order = order.clone();
        for sum in ["/source/dataset_sha256", "/source/manifests_sha256"] {
            order.pointer_mut(sum).map(Value::take);
        }
        order
    };
    without_state(a) == without_state(b)
}

/// Size of a plain file in the folder [bytes]; `None` where there is none.
fn length(root: &Path, relative: &str) -> Result<Option<u64>, Fault> {
    match enclosed::length(root, relative) {
        Ok(bytes) => Ok(Some(bytes)),
        Err(e) if e.kind() == ErrorKind::NotFound => Ok(None),
        Err(e) => Err(refused(&root.join(relative), &e)),
    }
}

/// Writes a file by way of `partial`; it is synced later, with all others.
fn put(root: &Path, partial: &str, relative: &str, content: &[u8]) -> Result<(), Fault> {
    let mut file = enclosed::create(root, partial).map_err(unwritten)?;
    let written = file.write_all(content).map_err(|e| refused(&root.join(relative), &e));
    written.and_then(|()| enclosed::rename(root, partial, relative).map_err(unwritten)).inspect_err(|_| {
        // The first error is the one to tell.
        let _ = enclosed::remove(root, partial);
    })
}

/// The marker of a folder, held by this process alone.
fn locked(root: &Path) -> Result<File, Fault> {
    let path = &root.join(UNFINISHED_MARKER);
    let marker = enclosed::open(root, UNFINISHED_MARKER, MAX_DOCUMENT_BYTES).map_err(|e| refused(path, &e))?;
    match marker.try_lock() {
        Ok(()) => Ok(marker),
        Err(TryLockError::WouldBlock) => {
            Err(Fault::at(root, "another process is writing it", "wait for it, or choose another folder"))
        }
        Err(TryLockError::Error(e)) => Err(refused(path, &e)),
    }
}

/// What was refused in the folder, and what to do.
fn unwritten(error: FileError) -> Fault {
    refused(&error.path, &error.source)
}

/// What the system refused, and what to do.
fn refused(path: &Path, error: &io::Error) -> Fault {
    let (what, remedy) = match error.kind() {
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => (
            format!("the disk is full ({error})"),
            "make room, then run the same command to continue: files that are written stay",
        ),
        _ => (format!("it cannot be written: {error}"), own_remedy(error).unwrap_or("give another place with --out")),
    };
    Fault::at(path, what, remedy)
}
