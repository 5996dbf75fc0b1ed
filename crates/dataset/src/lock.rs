//! Locks between processes: the kernel lets go of them when a process ends, in whatever way.

use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};

use super::atomic_file::FileError;
use super::enclosed;

/// A held lock; letting go removes the lock file.
#[derive(Debug)]
pub(super) struct Lock {
    root: PathBuf,
    relative: String,
    /// Holds the lock until it is closed; `None` when it was let go.
    held: Option<File>,
}

impl Lock {
    /// Takes the lock `relative` of the folder `root`, or `None` where another process holds it.
    pub(super) fn try_take(root: &Path, relative: &str) -> Result<Option<Self>, FileError> {
        let at = |operation| FileError::of(operation, &root.join(relative));
        loop {
            let file = enclosed::open_lock(root, relative).map_err(at("create"))?;
            match file.try_lock() {
                Err(TryLockError::WouldBlock) => return Ok(None),
                Err(TryLockError::Error(e)) => return Err(at("lock")(e)),
                Ok(()) if enclosed::is_named(root, relative, &file).map_err(at("read"))? => {
                    return Ok(Some(Self { root: root.into(), relative: relative.into(), held: Some(file) }));
                }
                Ok(()) => {}
            }
        }
    }

    /// Takes the lock; where another process holds it, calls `waits` once and waits for it.
    pub(super) fn take(root: &Path, relative: &str, waits: &dyn Fn()) -> Result<Self, FileError> {
        let at = |operation| FileError::of(operation, &root.join(relative));
        if let Some(lock) = Self::try_take(root, relative)? {
            return Ok(lock);
        }
        waits();
        loop {
            let file = enclosed::open_lock(root, relative).map_err(at("create"))?;
            file.lock().map_err(at("lock"))?;
            if enclosed::is_named(root, relative, &file).map_err(at("read"))? {
                return Ok(Self { root: root.into(), relative: relative.into(), held: Some(file) });
            }
        }
    }

    /// Lets go, and says where the lock file stays.
    pub(super) fn release(mut self) -> Result<(), FileError> {
        self.let_go()
    }

    fn let_go(&mut self) -> Result<(), FileError> {
        let Some(file) = self.held.take() else { return Ok(()) };
        let at = |operation| FileError::of(operation, &self.root.join(&self.relative));
        // Removed while it is still held: whoever waits on the old file sees that it is gone and opens the new one.
        if enclosed::is_named(&self.root, &self.relative, &file).map_err(at("read"))? {
            enclosed::remove(&self.root, &self.relative)?;
        }
        Ok(())
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        // Whoever drops a lock without letting go of it has an error to tell already.
        let _ = self.let_go();
    }
}
