//! What a command writes for people: the place is tried before the work, the file is there as a whole or not at all.

use std::fs::{self, File};
use std::io::{Error, ErrorKind};
use std::path::Path;

use crate::whole;

/// Writes `content` to `path`, which `--out` names.
pub(super) fn write(path: &Path, content: &[u8]) -> Result<(), String> {
    write_or(path, content, "give another place with --out")
}

/// The same for a path that follows from other arguments; `remedy` is what to do where it cannot be written.
pub(super) fn write_or(path: &Path, content: &[u8], remedy: &str) -> Result<(), String> {
    let told = |error: Error, first: &str| format!("cannot write {}: {error}; {first}{remedy}", path.display());
    let Some(name) = path.file_name().filter(|_| !path.is_dir()) else {
        return Err(told(Error::from(ErrorKind::IsADirectory), "a folder has that name: "));
    };
    let partial = path.with_file_name(format!(".tmp-{}-{}", std::process::id(), name.to_string_lossy()));
    whole::write(&partial, path, content).map_err(|refused| match refused.source.kind() {
        ErrorKind::NotFound => told(refused.source, "make the folder first, or "),
        _ => told(refused.source, ""),
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
