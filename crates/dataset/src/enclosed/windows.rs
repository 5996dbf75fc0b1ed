//! Folders on Windows: paths that were looked at, part by part, before they are used.

use std::fs::{self, File, Metadata, OpenOptions};
use std::io::{self, ErrorKind};
use std::os::windows::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};

use same_file::Handle;

use super::{Entry, Found, Use};

/// Opens a link itself, not what it leads to (`FILE_FLAG_OPEN_REPARSE_POINT`).
const NO_FOLLOW: u32 = 0x0020_0000;

/// A folder that was one when it was entered.
pub(super) struct Folder(PathBuf);

fn kind(data: &Metadata) -> Found {
    if data.file_type().is_symlink() {
        Found::Other("a link")
    } else if data.is_file() {
        Found::File(data.len())
    } else if data.is_dir() {
        Found::Folder
    } else {
        Found::Other("a device")
    }
}

impl Folder {
    /// The folder at a path of the user's.
    pub(super) fn open(root: &Path, _: Entry) -> io::Result<Self> {
        let is_folder = fs::metadata(root)?.is_dir();
        if is_folder { Ok(Self(root.into())) } else { Err(ErrorKind::NotADirectory.into()) }
    }

    /// A folder in it.
    pub(super) fn enter(&self, name: &str, _: Entry) -> io::Result<Self> {
        match self.found(name)? {
            Found::Folder => Ok(Self(self.0.join(name))),
            Found::Nothing => Err(ErrorKind::NotFound.into()),
            Found::File(_) | Found::Other(_) => Err(ErrorKind::NotADirectory.into()),
        }
    }

    /// What has the name.
    pub(super) fn found(&self, name: &str) -> io::Result<Found> {
        match fs::symlink_metadata(self.0.join(name)) {
            Ok(data) => Ok(kind(&data)),
            Err(e) if e.kind() == ErrorKind::NotFound => Ok(Found::Nothing),
            Err(e) => Err(e),
        }
    }

    /// What was opened.
    pub(super) fn kind(file: &File) -> io::Result<Found> {
        Ok(kind(&file.metadata()?))
    }

    /// A file in it. The system lets those sync a file alone who may write it.
    pub(super) fn file(&self, name: impl AsRef<Path>, how: Use) -> io::Result<File> {
        let mut options = OpenOptions::new();
        match how {
            Use::Read => options.read(true),
            Use::Sync => options.write(true),
            Use::Change => options.read(true).write(true),
            Use::Lock => options.read(true).write(true).create(true).truncate(false),
            Use::New => return options.write(true).create_new(true).open(self.0.join(name)),
        };
        options.custom_flags(NO_FOLLOW).open(self.0.join(name))
    }

    /// Makes a folder in it.
    pub(super) fn make(&self, name: &str) -> io::Result<()> {
        fs::create_dir(self.0.join(name))
    }

    /// Gives what has the name another one, there or in `other`.
    pub(super) fn rename(&self, name: &str, other: &Self, new: &str) -> io::Result<()> {
        fs::rename(self.0.join(name), other.0.join(new))
    }

    /// Removes a file or a link.
    pub(super) fn remove_file(&self, name: &str) -> io::Result<()> {
        fs::remove_file(self.0.join(name))
    }

    /// Removes an empty folder.
    pub(super) fn remove_folder(&self, name: &str) -> io::Result<()> {
        fs::remove_dir(self.0.join(name))
    }

    /// The names in it, and whether each is a folder.
    pub(super) fn entries(&self) -> io::Result<Vec<(String, bool)>> {
        let entry = |entry: io::Result<fs::DirEntry>| {
            let entry = entry?;
            Ok((entry.file_name().to_string_lossy().into_owned(), entry.file_type()?.is_dir()))
        };
        fs::read_dir(&self.0)?.map(entry).collect()
    }

    /// Makes the names in it last: the file system's journal does, and there is nothing to call.
    pub(super) fn sync(self) -> io::Result<()> {
        Ok(())
    }

    /// Whether the open file is the one of that name.
    pub(super) fn is_named(&self, name: &str, file: &File) -> io::Result<bool> {
        match Handle::from_path(self.0.join(name)) {
            Ok(named) => Ok(named == Handle::from_file(file.try_clone()?)?),
            Err(e) if e.kind() == ErrorKind::NotFound => Ok(false),
            Err(e) => Err(e),
        }
    }
}
