//! Atomic file: a file that is there as a whole or not at all: written under a temporary name, synced, renamed, its
//! folder synced. For paths that the user names, which `files` opens to read; what lies in a dataset's folder goes by
//! [`super::enclosed`].

use std::fs::{self, File};
use std::io::{self, Error, ErrorKind, Write};
use std::path::{Path, PathBuf};

pub use files::read;
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
    pub(super) fn of(operation: &'static str, path: &Path) -> impl Fn(Error) -> Self + use<> {
        let path = path.to_path_buf();
        move |source| Self { operation, path: path.clone(), source }
    }
}

/// Puts `content` at `whole` by way of `partial`, a name in the same folder that is gone afterwards.
pub fn write(partial: &Path, whole: &Path, content: &[u8]) -> Result<(), FileError> {
    let write = || {
        let at = |operation| FileError::of(operation, partial);
        let mut file = create(partial)?;
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

/// A new file: what has the name is removed before, and is never written through where it is a link.
///
/// # Errors
/// What the system refuses.
pub fn create(partial: &Path) -> Result<File, FileError> {
    match fs::remove_file(partial) {
        Err(e) if e.kind() != ErrorKind::NotFound => return Err(FileError::of("remove", partial)(e)),
        _ => {}
    }
    File::create_new(partial).map_err(FileError::of("create", partial))
}

/// Gives a file that is synced its name.
pub fn rename(from: &Path, to: &Path) -> Result<(), FileError> {
    fs::rename(from, to).map_err(FileError::of("rename to", to))
}

/// Makes names in a folder last. Windows has no call for that: its file system keeps a journal of names.
fn sync_directory(path: &Path) -> Result<(), FileError> {
    if cfg!(windows) {
        return Ok(());
    }
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
    /// A new file in `file`.
    pub(super) fn new(file: File) -> Self {
        Self { file, sum: Sha256::new(), bytes: 0 }
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

/// What a disk has left for this user.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct DiskSpace {
    /// Space [bytes].
    pub(super) bytes: u64,
    /// Files; `None` where the file system sets no number.
    pub(super) files: Option<u64>,
}

/// What the disk at `path` has left; `None` where the system does not tell.
#[cfg(unix)]
pub(super) fn disk_space(path: &Path) -> Option<DiskSpace> {
    let absolute = std::path::absolute(path).ok()?;
    let state = absolute.ancestors().find_map(|place| rustix::fs::statvfs(place).ok())?;
    let files = (state.f_files > 0).then_some(state.f_favail);
    Some(DiskSpace { bytes: state.f_bavail.saturating_mul(state.f_frsize), files })
}

/// What the disk at `path` has left: only Unix is asked.
#[cfg(not(unix))]
pub(super) fn disk_space(_path: &Path) -> Option<DiskSpace> {
    None
}

/// Space that this user may still fill at `path` [bytes]; `None` where the system does not tell.
pub fn free_bytes(path: &Path) -> Option<u64> {
    disk_space(path).map(|space| space.bytes)
}
