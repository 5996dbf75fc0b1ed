//! Output files of commands: the path is tried before the work, and the file is written atomically.

use std::fs::{self, File};
use std::io::{Error, ErrorKind};
use std::path::{Component, Path, PathBuf};

use image::RgbImage;

use dataset::atomic_file;

/// Writes `content` to `path`, which `--out` names.
pub(super) fn write(path: &Path, content: &[u8]) -> Result<(), String> {
    write_or(path, content, "give another place with --out")
}

/// The same for a path that follows from other arguments; `remedy` is what to do where it cannot be written.
pub(super) fn write_or(path: &Path, content: &[u8], remedy: &str) -> Result<(), String> {
    let error_text = |error: Error, first: &str| format!("cannot write {}: {error}; {first}{remedy}", path.display());
    let Some(name) = path.file_name().filter(|_| !path.is_dir()) else {
        return Err(error_text(Error::from(ErrorKind::IsADirectory), "a folder has that name: "));
    };
    let partial = path.with_file_name(format!(".tmp-{}-{}", std::process::id(), name.to_string_lossy()));
    atomic_file::write(&partial, path, content).map_err(|refused| match refused.source.kind() {
        ErrorKind::NotFound => error_text(refused.source, "make the folder first, or "),
        _ => error_text(refused.source, ""),
    })
}

/// A picture as the bytes of a PNG file.
pub(super) fn png(picture: &RgbImage) -> Result<Vec<u8>, image::ImageError> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    picture.write_to(&mut bytes, image::ImageFormat::Png)?;
    Ok(bytes.into_inner())
}

/// The path without links and `..`, as far as it exists.
pub(super) fn resolve(path: &Path) -> Option<PathBuf> {
    let mut resolved = PathBuf::new();
    for part in std::path::absolute(path).ok()?.components() {
        match part {
            Component::ParentDir => _ = resolved.pop(),
            part => resolved.push(part),
        }
        resolved = resolved.canonicalize().unwrap_or(resolved);
    }
    Some(resolved)
}

/// Refuses a path that cannot be written, before hours are spent on its content; `--out` names it.
pub(super) fn check_writable(path: &Path) -> Result<(), String> {
    check_writable_or(path, "give another place with --out")
}

/// The same for a path that follows from other arguments.
pub(super) fn check_writable_or(path: &Path, remedy: &str) -> Result<(), String> {
    let error_text =
        |what: String, first: &str| Err(format!("cannot write {}: {what}; {first}{remedy}", path.display()));
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if path.is_dir() || path.file_name().is_none() {
        return error_text("it is a folder".into(), "name a file: ");
    }
    if !folder.is_dir() {
        return error_text(format!("there is no folder {}", folder.display()), "make it first, or ");
    }
    let probe = folder.join(format!(".tmp-{}-probe", std::process::id()));
    let made = File::create(&probe).map(|_| ());
    let _ = fs::remove_file(&probe);
    made.or_else(|error| error_text(error.to_string(), ""))
}
