//! Atomic file: a file that is there as a whole or not at all: written under a temporary name, synced, renamed, its folder
//! synced; and read so.

use std::fs::{self, File};
use std::io::{self, Error, ErrorKind, Write};
use std::path::{Path, PathBuf};

use output_schema::file::temporary;
use sha2::{Digest, Sha256};

/// What the system refused; who calls knows the remedy.
#[derive(Debug)]
pub struct FileError {
    /// What was tried.
    pub operation: &'static str,
    /// With which file or folder.
    pub path: PathBuf,
    /// The system's reason.
    pub source: Error,
}

impl FileError {
    /// For `map_err`: makes the system's reason an error of `operation` on `path`.
    pub(super) fn of(operation: &'static str, path: &Path) -> impl Fn(Error) -> Self {
        move |source| Self { operation, path: path.to_path_buf(), source }
    }
}

/// Puts `content` at `whole` by way of `partial`, a name in the same folder that is gone afterwards.
pub fn write(partial: &Path, whole: &Path, content: &[u8]) -> Result<(), FileError> {
    let write = || {
        let at = |operation| FileError::of(operation, partial);
        let mut file = File::create(partial).map_err(at("create"))?;
        file.write_all(content).map_err(at("write"))?;
        file.sync_all().map_err(at("sync"))?;
        rename(partial, whole)?;
        sync_directory(whole.parent().unwrap_or(Path::new(".")))
    };
    write().inspect_err(|_| {
        // The first error is the one to tell.
        let _ = fs::remove_file(partial);
    })
}

/// The bytes of a plain file; a pipe or a device, of which reading may never end, is refused.
pub fn read(path: &Path) -> Result<Vec<u8>, Error> {
    if !fs::metadata(path)?.is_file() {
        return Err(Error::other("it is no plain file"));
    }
    fs::read(path)
}

/// Gives a file that is synced its name.
pub fn rename(from: &Path, to: &Path) -> Result<(), FileError> {
    fs::rename(from, to).map_err(FileError::of("rename to", to))
}

/// Makes names in a folder last.
pub(crate) fn sync_directory(path: &Path) -> Result<(), FileError> {
    let path = if path.as_os_str().is_empty() { Path::new(".") } else { path };
    File::open(path).and_then(|directory| directory.sync_all()).map_err(FileError::of("sync", path))
}

/// A file that knows its size and SHA-256 while it grows.
#[derive(Debug)]
pub(super) struct SummedFile {
    file: File,
    sum: Sha256,
    bytes: u64,
}

impl SummedFile {
    pub(super) fn create(path: &Path) -> Result<Self, FileError> {
        let file = File::create(path).map_err(FileError::of("create", path))?;
        Ok(Self { file, sum: Sha256::new(), bytes: 0 })
    }

    /// Syncs, and gives size [bytes] and SHA-256.
    pub(super) fn finish(self, path: &Path) -> Result<(u64, String), FileError> {
        self.file.sync_all().map_err(FileError::of("sync", path))?;
        Ok((self.bytes, hex(&self.sum.finalize())))
    }
}

impl Write for SummedFile {
    fn write(&mut self, part: &[u8]) -> io::Result<usize> {
        let written = self.file.write(part)?;
        self.sum.update(&part[..written]);
        self.bytes += written as u64;
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

/// Bytes as hexadecimal digits.
pub fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// SHA-256 of `bytes` as hexadecimal digits.
pub fn sha256(bytes: &[u8]) -> String {
    hex(&Sha256::digest(bytes))
}

/// Writes `root/relative` as a whole or not at all.
pub(super) fn write_in(root: &Path, relative: &str, content: &[u8]) -> Result<(), FileError> {
    write(&root.join(temporary(relative)), &root.join(relative), content)
}

pub(super) fn create_directory(path: &Path) -> Result<(), FileError> {
    fs::create_dir_all(path).map_err(FileError::of("create", path))
}

/// Removes a file or a folder with all that is in it; nothing to remove is well.
pub(super) fn remove(path: &Path) -> Result<(), FileError> {
    let removed = match fs::symlink_metadata(path) {
        Ok(what) if what.is_dir() => fs::remove_dir_all(path),
        Ok(_) => fs::remove_file(path),
        Err(e) => Err(e),
    };
    match removed {
        Err(e) if e.kind() != ErrorKind::NotFound => Err(FileError::of("remove", path)(e)),
        _ => Ok(()),
    }
}

/// Names in a directory, sorted; empty where it is missing.
pub(super) fn names(path: &Path) -> Result<Vec<String>, FileError> {
    let entries = match fs::read_dir(path) {
        Ok(entries) => entries,
        Err(e) if e.kind() == ErrorKind::NotFound => return Ok(Vec::new()),
        Err(e) => return Err(FileError::of("list", path)(e)),
    };
    let mut names = Vec::new();
    for entry in entries {
        let entry = entry.map_err(FileError::of("list", path))?;
        names.push(entry.file_name().to_string_lossy().into_owned());
    }
    names.sort_unstable();
    Ok(names)
}

/// Space that this user may still fill at `path` [bytes]; `None` where the system does not tell.
pub fn free_bytes(path: &Path) -> Option<u64> {
    let absolute = std::path::absolute(path).ok()?;
    let state = absolute.ancestors().find_map(|place| rustix::fs::statvfs(place).ok())?;
    Some(state.f_bavail.saturating_mul(state.f_frsize))
}
