//! Writing so that a name stands for a whole file: temporary name, sync, rename, sync of the directory.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::Path;

use output_schema::file::temporary;
use sha2::{Digest, Sha256};

use super::ShardError;
use super::atomic_file;

/// A file that knows its size and SHA-256 while it grows.
#[derive(Debug)]
pub(super) struct SummedFile {
    file: File,
    sum: Sha256,
    bytes: u64,
}

impl SummedFile {
    pub(super) fn create(path: &Path) -> Result<Self, ShardError> {
        let file = File::create(path).map_err(|e| ShardError::io("create", path, e))?;
        Ok(Self { file, sum: Sha256::new(), bytes: 0 })
    }

    /// Syncs, and gives size [bytes] and SHA-256.
    pub(super) fn finish(self, path: &Path) -> Result<(u64, String), ShardError> {
        self.file.sync_all().map_err(|e| ShardError::io("sync", path, e))?;
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
pub(crate) fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// SHA-256 of `bytes` as hexadecimal digits.
pub(crate) fn sha256(bytes: &[u8]) -> String {
    hex(&Sha256::digest(bytes))
}

/// Writes `root/relative` as a whole or not at all.
pub(super) fn write_whole(root: &Path, relative: &str, content: &[u8]) -> Result<(), ShardError> {
    Ok(atomic_file::write(&root.join(temporary(relative)), &root.join(relative), content)?)
}

pub(super) fn rename(from: &Path, to: &Path) -> Result<(), ShardError> {
    Ok(atomic_file::rename(from, to)?)
}

pub(super) fn sync_directory(path: &Path) -> Result<(), ShardError> {
    Ok(atomic_file::sync_directory(path)?)
}

pub(super) fn create_directory(path: &Path) -> Result<(), ShardError> {
    fs::create_dir_all(path).map_err(|e| ShardError::io("create", path, e))
}

/// Removes a file or a folder with all that is in it; nothing to remove is well.
pub(super) fn remove(path: &Path) -> Result<(), ShardError> {
    let removed = match fs::symlink_metadata(path) {
        Ok(what) if what.is_dir() => fs::remove_dir_all(path),
        Ok(_) => fs::remove_file(path),
        Err(e) => Err(e),
    };
    match removed {
        Err(e) if e.kind() != io::ErrorKind::NotFound => Err(ShardError::io("remove", path, e)),
        _ => Ok(()),
    }
}

/// Names in a directory, sorted; empty where it is missing.
pub(super) fn names(path: &Path) -> Result<Vec<String>, ShardError> {
    let entries = match fs::read_dir(path) {
        Ok(entries) => entries,
        Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(e) => return Err(ShardError::io("list", path, e)),
    };
    let mut names = Vec::new();
    for entry in entries {
        let entry = entry.map_err(|e| ShardError::io("list", path, e))?;
        names.push(entry.file_name().to_string_lossy().into_owned());
    }
    names.sort_unstable();
    Ok(names)
}

/// Space that this user may still fill at `path` [bytes]; `None` where the system does not tell.
pub(crate) fn free_bytes(path: &Path) -> Option<u64> {
    let absolute = std::path::absolute(path).ok()?;
    let state = absolute.ancestors().find_map(|place| rustix::fs::statvfs(place).ok())?;
    Some(state.f_bavail.saturating_mul(state.f_frsize))
}
