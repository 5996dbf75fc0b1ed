//! Export folder: marked as unfinished until its last file is there, each file whole or not at all.

use std::fs::{self, File, TryLockError};
use std::io::{self, BufWriter, Error, ErrorKind, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use output_schema::file::{TEMPORARY, temporary};
use serde_json::{Value, json};

use super::Source;
use dataset::{Fault, GENERATOR_VERSION, own_remedy};

/// What is exported, while it is not finished.
const UNFINISHED_MARKER: &str = ".unfinished-export.json";
/// What was exported, with counts and scales.
pub(crate) const EXPORT_DOCUMENT: &str = "export.json";

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
    partial: PathBuf,
    path: PathBuf,
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
        source: &Source,
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
        let path = root.join(UNFINISHED_MARKER);
        fs::create_dir_all(root).map_err(|e| refused(root, &e))?;
        if let Ok(text) = fs::read(root.join(EXPORT_DOCUMENT)) {
            let found: Value = serde_json::from_slice(&text).unwrap_or_default();
            if found.get("order") != Some(&order) {
                let what = "it holds another export, or one of another state of the dataset";
                return Err(Fault::at(root, what, "choose another folder, or remove it first"));
            }
            // A run that was stopped after its last file left the marker alone to remove.
            if path.exists() {
                let _marker = locked(root, &path)?;
                fs::remove_file(&path).map_err(|e| refused(&path, &e))?;
            }
            return Ok(None);
        }
        if !path.exists() {
            let mut entries = fs::read_dir(root).map_err(|e| refused(root, &e))?.flatten();
            // A marker that was being begun is all that a stopped run may have left.
            if entries.any(|entry| entry.file_name() != *temporary(UNFINISHED_MARKER)) {
                return Err(Fault::at(root, "it is not empty and holds no export", "choose an empty folder"));
            }
            let partial = root.join(temporary(UNFINISHED_MARKER));
            let made = fs::write(&partial, format!("{order:#}\n")).and_then(|()| fs::rename(&partial, &path));
            made.map_err(|e| refused(&path, &e))?;
        }
        let mut marker = locked(root, &path)?;
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
        for entry in fs::read_dir(root).map_err(|e| refused(root, &e))?.flatten() {
            if entry.file_name().to_string_lossy().starts_with(TEMPORARY) {
                fs::remove_file(entry.path()).map_err(|e| refused(&entry.path(), &e))?;
            }
        }
        let (files, bytes) = (AtomicU64::new(0), AtomicU64::new(0));
        Ok(Some(Self { root: root.to_path_buf(), order, _marker: marker, files, bytes }))
    }

    /// The folder.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// Writes a file, unless a run before has; `content` is asked only where it has not.
    ///
    /// # Errors
    /// Where `content` fails, or the file cannot be written.
    pub fn put(&self, relative: &str, content: impl FnOnce() -> Result<Vec<u8>, Fault>) -> Result<(), Fault> {
        let path = self.root.join(relative);
        // A name stands for a whole file; after a loss of power it may stand for an empty one.
        if let Ok(found) = fs::metadata(&path)
            && found.len() > 0
        {
            self.count(found.len());
            return Ok(());
        }
        let content = content()?;
        let partial = self.beside(relative)?;
        let written = fs::write(&partial, &content).and_then(|()| fs::rename(&partial, &path));
        written.map_err(|e| {
            // The first error is the one to tell.
            let _ = fs::remove_file(&partial);
            refused(&path, &e)
        })?;
        self.count(content.len() as u64);
        Ok(())
    }

    /// Begins a file that grows.
    ///
    /// # Errors
    /// Where it cannot be made.
    pub fn create(&self, relative: &str) -> Result<GrowingFile, Fault> {
        let (partial, path) = (self.beside(relative)?, self.root.join(relative));
        let file = File::create(&partial).map_err(|e| refused(&path, &e))?;
        Ok(GrowingFile { partial, path, file: BufWriter::new(file) })
    }

    /// Syncs a file that grew and gives it its name: after a loss of power too the name stands for all of it.
    ///
    /// # Errors
    /// Where it cannot be written.
    pub(crate) fn finish_file(&self, growing: GrowingFile) -> Result<(), Fault> {
        let GrowingFile { partial, path, file } = growing;
        let file = file.into_inner().map_err(|e| refused(&path, e.error()))?;
        let bytes = file.sync_all().and_then(|()| file.metadata()).map_err(|e| refused(&path, &e))?.len();
        fs::rename(&partial, &path).map_err(|e| refused(&path, &e))?;
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
        sync_below(&self.root).map_err(|e| refused(&self.root, &e))?;
        let (files, bytes) = (self.files.into_inner(), self.bytes.into_inner());
        let document = json!({"order": self.order, "files": files, "bytes": bytes, "result": result, "notes": notes});
        let path = self.root.join(EXPORT_DOCUMENT);
        let partial = self.root.join(temporary(EXPORT_DOCUMENT));
        let written = dataset::atomic_file::write(&partial, &path, format!("{document:#}\n").as_bytes());
        written.map_err(|e| refused(&path, &e.source))?;
        let marker = self.root.join(UNFINISHED_MARKER);
        fs::remove_file(&marker).map_err(|e| refused(&marker, &e))?;
        Ok(ExportSummary { files, bytes, nothing_to_do: false, notes })
    }

    /// The same error, after the marker was taken away where nothing else was written: the folder is free again.
    pub(super) fn withdrawn(&self, error: Fault) -> Fault {
        let is_marker =
            |entry: io::Result<fs::DirEntry>| entry.is_ok_and(|entry| entry.file_name() == *UNFINISHED_MARKER);
        if fs::read_dir(&self.root).is_ok_and(|mut entries| entries.all(is_marker)) {
            // The first error is the one to tell.
            let _ = fs::remove_file(self.root.join(UNFINISHED_MARKER));
        }
        error
    }

    /// The temporary path beside a file, in a folder that is there.
    fn beside(&self, relative: &str) -> Result<PathBuf, Fault> {
        let partial = self.root.join(temporary(relative));
        let folder = partial.parent().unwrap_or(&self.root);
        fs::create_dir_all(folder).map_err(|e| refused(folder, &e))?;
        Ok(partial)
    }
}

impl GrowingFile {
    /// Appends bytes.
    ///
    /// # Errors
    /// Where they cannot be written.
    pub fn push(&mut self, bytes: &[u8]) -> Result<(), Fault> {
        self.file.write_all(bytes).map_err(|e| refused(&self.path, &e))
    }

    /// Appends another file that grew, and removes that one.
    ///
    /// # Errors
    /// Where it cannot be read or written.
    pub fn append(&mut self, other: Self) -> Result<(), Fault> {
        let copied = (|| {
            other.file.into_inner().map_err(std::io::IntoInnerError::into_error)?;
            std::io::copy(&mut File::open(&other.partial)?, &mut self.file)?;
            fs::remove_file(&other.partial)
        })();
        copied.map_err(|e: Error| refused(&self.path, &e))
    }
}

/// Makes all files in a folder last, and their names: at once for all that wait on its disk, which takes far less than file by
/// file.
#[cfg(target_os = "linux")]
fn sync_below(folder: &Path) -> io::Result<()> {
    Ok(rustix::fs::syncfs(File::open(folder)?)?)
}

/// Makes all files in a folder last, and their names where the system can.
#[cfg(not(target_os = "linux"))]
fn sync_below(folder: &Path) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        if entry.file_type()?.is_dir() {
            sync_below(&entry.path())?;
        } else {
            // Windows syncs only what is open for writing.
            fs::OpenOptions::new().write(true).open(entry.path())?.sync_all()?;
        }
    }
    if cfg!(windows) { Ok(()) } else { File::open(folder)?.sync_all() }
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

/// The marker of a folder, held by this process alone.
fn locked(root: &Path, path: &Path) -> Result<File, Fault> {
    let marker = File::open(path).map_err(|e| refused(path, &e))?;
    match marker.try_lock() {
        Ok(()) => Ok(marker),
        Err(TryLockError::WouldBlock) => {
            Err(Fault::at(root, "another process is writing it", "wait for it, or choose another folder"))
        }
        Err(TryLockError::Error(e)) => Err(refused(path, &e)),
    }
}

/// What the system refused, and what to do.
pub(super) fn refused(path: &Path, error: &Error) -> Fault {
    let (what, remedy) = match error.kind() {
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => (
            format!("the disk is full ({error})"),
            "make room, then run the same command to continue: files that are written stay",
        ),
        _ => (format!("it cannot be written: {error}"), own_remedy(error).unwrap_or("give another place with --out")),
    };
    Fault::at(path, what, remedy)
}
