//! Locks between processes: the kernel lets go of them when a process ends, in whatever way.
//!
//! Some file systems have none (Lustre mounted without `flock`, buckets through FUSE). There everybody goes on without:
//! what two processes write under one name has the same bytes, documents of the folder get their names from files that
//! one process alone knows, and nobody removes what others left behind. Two processes at one shard are the one thing to
//! avoid: each removes what the other has begun.

use std::fs::{File, TryLockError};
use std::hash::{BuildHasher, Hasher, RandomState};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

use output_schema::file::temporary;

use super::atomic_file::FileError;
use super::enclosed;

/// A held lock; letting go removes the lock file.
#[derive(Debug)]
pub(super) struct Lock {
    root: PathBuf,
    relative: String,
    /// Holds the lock until it is closed; `None` when it was let go, and where the file system has no locks.
    held: Option<File>,
}

/// Whether the file system has no locks, or the machine that keeps it hands out none.
fn has_no_locks(error: &io::Error) -> bool {
    #[cfg(unix)]
    let is_none_left = error.raw_os_error() == Some(rustix::io::Errno::NOLCK.raw_os_error());
    #[cfg(not(unix))]
    let is_none_left = false;
    error.kind() == ErrorKind::Unsupported || is_none_left
}

impl Lock {
    /// Takes the lock `relative` of the folder `root`, or `None` where another process holds it. `has_locks` is what
    /// was found before about the folder: a system that has run out of locks for a moment is no file system without
    /// them.
    pub(super) fn try_take(root: &Path, relative: &str, has_locks: Option<bool>) -> Result<Option<Self>, FileError> {
        let at = |operation| FileError::of(operation, &root.join(relative));
        let unlocked = || Self { root: root.into(), relative: relative.into(), held: None };
        if has_locks == Some(false) {
            return Ok(Some(unlocked()));
        }
        loop {
            let file = enclosed::open_lock(root, relative).map_err(at("create"))?;
            match file.try_lock() {
                Err(TryLockError::WouldBlock) => return Ok(None),
                Err(TryLockError::Error(e)) if has_locks.is_none() && has_no_locks(&e) => {
                    enclosed::remove(root, relative)?;
                    return Ok(Some(unlocked()));
                }
                Err(TryLockError::Error(e)) => return Err(at("lock")(e)),
                Ok(()) if enclosed::is_named(root, relative, &file).map_err(at("read"))? => {
                    return Ok(Some(Self { root: root.into(), relative: relative.into(), held: Some(file) }));
                }
                Ok(()) => {}
            }
        }
    }

    /// Takes the lock; where another process holds it, calls `waits` once and waits for it.
    pub(super) fn take(
        root: &Path,
        relative: &str,
        has_locks: Option<bool>,
        waits: &dyn Fn(),
    ) -> Result<Self, FileError> {
        let at = |operation| FileError::of(operation, &root.join(relative));
        if let Some(lock) = Self::try_take(root, relative, has_locks)? {
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

    /// The folder that it lies in.
    pub(super) fn root(&self) -> &Path {
        &self.root
    }

    /// Whether others are kept out: not where the file system has no locks.
    pub(super) fn is_held(&self) -> bool {
        self.held.is_some()
    }

    /// Writes a document of the folder that this locks, as a whole or not at all. Where nobody is kept out, by way of a
    /// name that no other process has.
    pub(super) fn write(&self, path: &str, content: &[u8]) -> Result<(), FileError> {
        if self.is_held() {
            return enclosed::write(&self.root, path, content);
        }
        let own = RandomState::new().build_hasher().finish();
        let partial = temporary(&match path.rsplit_once('/') {
            Some((folder, name)) => format!("{folder}/{own:016x}-{name}"),
            None => format!("{own:016x}-{path}"),
        });
        enclosed::write_by(&self.root, &partial, path, content)
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
