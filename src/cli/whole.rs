//! Files that are there as a whole or not at all: written under a temporary name, synced, renamed.

use std::fs::{self, File};
use std::io::{Error, ErrorKind, Write};
use std::path::Path;

/// Writes `content` to `path`.
pub(super) fn write(path: &Path, content: &[u8]) -> Result<(), String> {
    let told = |error: Error, remedy: &str| format!("cannot write {}: {error}; {remedy}", path.display());
    let elsewhere = "give another place with --out";
    let Some(name) = path.file_name().filter(|_| !path.is_dir()) else {
        return Err(told(Error::from(ErrorKind::IsADirectory), "give the name of a file with --out"));
    };
    let partial = path.with_file_name(format!(".tmp-{}-{}", std::process::id(), name.to_string_lossy()));
    let write = || {
        let mut file = File::create(&partial)?;
        file.write_all(content)?;
        file.sync_all()?;
        fs::rename(&partial, path)
    };
    write().map_err(|error| {
        // The first error is the one to tell.
        let _ = fs::remove_file(&partial);
        match error.kind() {
            ErrorKind::NotFound => told(error, "make the folder first, or give another place with --out"),
            _ => told(error, elsewhere),
        }
    })
}

/// Faults a place that cannot be written before hours are spent on what should go there.
pub(super) fn check(path: &Path) -> Result<(), String> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if path.is_dir() || path.file_name().is_none() {
        return Err(format!("cannot write {}: it is a folder; give the name of a file with --out", path.display()));
    }
    if !folder.is_dir() {
        let remedy = "make it first, or give another place with --out";
        return Err(format!("cannot write {}: there is no folder {}; {remedy}", path.display(), folder.display()));
    }
    let probe = folder.join(format!(".tmp-{}-probe", std::process::id()));
    let made = File::create(&probe).map(|_| ());
    let _ = fs::remove_file(&probe);
    made.map_err(|error| format!("cannot write {}: {error}; give another place with --out", path.display()))
}
