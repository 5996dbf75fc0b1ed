//! What a command writes for people: the place is tried before the work, the file is there as a whole or not at all.

use std::fs::{self, File};
use std::io::{Error, ErrorKind};
use std::path::{Component, Path, PathBuf};

use crate::dataset::atomic_file;

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
    atomic_file::write(&partial, path, content).map_err(|refused| match refused.source.kind() {
        ErrorKind::NotFound => told(refused.source, "make the folder first, or "),
        _ => told(refused.source, ""),
    })
}

/// Where a path leads, whatever of it is there: no links, no `..`.
pub(super) fn place(path: &Path) -> Option<PathBuf> {
    let mut at = PathBuf::new();
    for part in std::path::absolute(path).ok()?.components() {
        match part {
            Component::ParentDir => _ = at.pop(),
            part => at.push(part),
        }
        at = at.canonicalize().unwrap_or(at);
    }
    Some(at)
}

/// Faults a place that cannot be written before hours are spent on what should go there; `--out` names it.
pub(super) fn check(path: &Path) -> Result<(), String> {
    check_or(path, "give another place with --out")
}

/// The same for a path that follows from other arguments.
pub(super) fn check_or(path: &Path, remedy: &str) -> Result<(), String> {
    let told = |what: String, first: &str| Err(format!("cannot write {}: {what}; {first}{remedy}", path.display()));
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if path.is_dir() || path.file_name().is_none() {
        return told("it is a folder".into(), "name a file: ");
    }
    if !folder.is_dir() {
        return told(format!("there is no folder {}", folder.display()), "make it first, or ");
    }
    let probe = folder.join(format!(".tmp-{}-probe", std::process::id()));
    let made = File::create(&probe).map(|_| ());
    let _ = fs::remove_file(&probe);
    made.or_else(|error| told(error.to_string(), ""))
}
