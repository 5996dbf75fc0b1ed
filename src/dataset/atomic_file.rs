//! A file that is there as a whole or not at all: written under a temporary name, synced, renamed, its folder synced; and read so.

use std::fs::{self, File};
use std::io::{Error, Write};
use std::path::{Path, PathBuf};

/// What the system refused; who calls knows the remedy.
#[derive(Debug)]
pub(crate) struct Refused {
    /// What was tried.
    pub operation: &'static str,
    /// With which file or folder.
    pub path: PathBuf,
    /// The system's reason.
    pub source: Error,
}

/// Puts `content` at `whole` by way of `partial`, a name in the same folder that is gone afterwards.
pub(crate) fn write(partial: &Path, whole: &Path, content: &[u8]) -> Result<(), Refused> {
    let write = || {
        let at = |operation| refused(operation, partial);
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
pub(crate) fn read(path: &Path) -> Result<Vec<u8>, Error> {
    if !fs::metadata(path)?.is_file() {
        return Err(Error::other("it is no plain file"));
    }
    fs::read(path)
}

/// Gives a file that is synced its name.
pub(crate) fn rename(from: &Path, to: &Path) -> Result<(), Refused> {
    fs::rename(from, to).map_err(refused("rename to", to))
}

/// Makes names in a folder last.
pub(crate) fn sync_directory(path: &Path) -> Result<(), Refused> {
    let path = if path.as_os_str().is_empty() { Path::new(".") } else { path };
    File::open(path).and_then(|directory| directory.sync_all()).map_err(refused("sync", path))
}

fn refused(operation: &'static str, path: &Path) -> impl FnOnce(Error) -> Refused {
    move |source| Refused { operation, path: path.to_path_buf(), source }
}
