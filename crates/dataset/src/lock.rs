//! Locks between processes: the kernel lets go of them when a process ends, in whatever way.

use std::fs::{self, File, TryLockError};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use super::atomic_file::FileError;

/// A held lock; letting go removes the lock file.
#[derive(Debug)]
pub(super) struct Lock {
    path: PathBuf,
    /// Holds the lock until it is closed.
    _file: File,
}

impl Lock {
    /// Takes the lock, or `None` where another process holds it.
    pub(super) fn try_take(path: &Path) -> Result<Option<Self>, FileError> {
        loop {
            let file = open(path)?;
            match file.try_lock() {
                Err(TryLockError::WouldBlock) => return Ok(None),
                Err(TryLockError::Error(e)) => return Err(FileError::of("lock", path)(e)),
                Ok(()) if is_current(&file, path)? => return Ok(Some(Self { path: path.into(), _file: file })),
                Ok(()) => {}
            }
        }
    }

    /// Takes the lock, and waits for it where another process holds it.
    pub(super) fn take(path: &Path) -> Result<Self, FileError> {
        loop {
            let file = open(path)?;
            file.lock().map_err(FileError::of("lock", path))?;
            if is_current(&file, path)? {
                return Ok(Self { path: path.into(), _file: file });
            }
        }
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        // Removed while it is still held: whoever waits on the old file sees that it is gone and opens the new one.
        let _ = fs::remove_file(&self.path);
    }
}

fn open(path: &Path) -> Result<File, FileError> {
    File::options().create(true).truncate(false).write(true).open(path).map_err(FileError::of("create", path))
}

/// Whether the open file is still the one of that name.
fn is_current(file: &File, path: &Path) -> Result<bool, FileError> {
    let held = file.metadata().map_err(FileError::of("read", path))?;
    Ok(fs::metadata(path).is_ok_and(|named| named.dev() == held.dev() && named.ino() == held.ino()))
}
