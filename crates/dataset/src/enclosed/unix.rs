//! Folders on Unix: open ones, names looked up in them without following links.

use std::fs::File;
use std::io;
use std::os::fd::OwnedFd;
use std::path::Path;

use rustix::fs::{AtFlags, Dir, FileType, Mode, OFlags, Stat};
use rustix::io::Errno;
use rustix::path::Arg;

use super::{Entry, Found, Use};

/// How a folder is opened that is only gone through.
#[cfg(target_os = "linux")]
const PASSAGE: OFlags = OFlags::PATH;
/// How a folder is opened that is only gone through.
#[cfg(not(target_os = "linux"))]
const PASSAGE: OFlags = OFlags::RDONLY;

/// An open folder.
pub(super) struct Folder(OwnedFd);

fn flags(how: Entry) -> OFlags {
    let own = if how == Entry::Passage { PASSAGE } else { OFlags::RDONLY };
    own | OFlags::DIRECTORY | OFlags::CLOEXEC
}

fn kind(stat: &Stat) -> Found {
    match FileType::from_raw_mode(stat.st_mode) {
        FileType::RegularFile => Found::File(u64::try_from(stat.st_size).unwrap_or(0)),
        FileType::Directory => Found::Folder,
        FileType::Symlink => Found::Other("a link"),
        FileType::Fifo => Found::Other("a pipe"),
        FileType::Socket => Found::Other("a socket"),
        _ => Found::Other("a device"),
    }
}

impl Folder {
    /// The folder at a path of the user's.
    pub(super) fn open(root: &Path, how: Entry) -> io::Result<Self> {
        Ok(Self(rustix::fs::open(root, flags(how), Mode::empty())?))
    }

    /// A folder in it.
    pub(super) fn enter(&self, name: &str, how: Entry) -> io::Result<Self> {
        Ok(Self(rustix::fs::openat(&self.0, name, flags(how) | OFlags::NOFOLLOW, Mode::empty())?))
    }

    /// What has the name.
    pub(super) fn found(&self, name: &str) -> io::Result<Found> {
        match rustix::fs::statat(&self.0, name, AtFlags::SYMLINK_NOFOLLOW) {
            Ok(stat) => Ok(kind(&stat)),
            Err(Errno::NOENT) => Ok(Found::Nothing),
            Err(e) => Err(e.into()),
        }
    }

    /// What was opened.
    pub(super) fn kind(file: &File) -> io::Result<Found> {
        Ok(kind(&rustix::fs::fstat(file)?))
    }

    /// A file in it.
    pub(super) fn file(&self, name: impl Arg, how: Use) -> io::Result<File> {
        let own = match how {
            Use::Read | Use::Sync => OFlags::RDONLY | OFlags::NONBLOCK | OFlags::NOCTTY,
            Use::Change => OFlags::RDWR | OFlags::NONBLOCK,
            Use::Lock => OFlags::RDWR | OFlags::CREATE | OFlags::NONBLOCK,
            Use::New => OFlags::WRONLY | OFlags::CREATE | OFlags::EXCL,
        };
        let flags = own | OFlags::NOFOLLOW | OFlags::CLOEXEC;
        Ok(rustix::fs::openat(&self.0, name, flags, Mode::from_raw_mode(0o666))?.into())
    }

    /// Makes a folder in it.
    pub(super) fn make(&self, name: &str) -> io::Result<()> {
        Ok(rustix::fs::mkdirat(&self.0, name, Mode::from_raw_mode(0o777))?)
    }

    /// Gives what has the name another one, there or in `other`.
    pub(super) fn rename(&self, name: &str, other: &Self, new: &str) -> io::Result<()> {
        Ok(rustix::fs::renameat(&self.0, name, &other.0, new)?)
    }

    /// Removes a file or a link.
    pub(super) fn remove_file(&self, name: &str) -> io::Result<()> {
        Ok(rustix::fs::unlinkat(&self.0, name, AtFlags::empty())?)
    }

    /// Removes an empty folder.
    pub(super) fn remove_folder(&self, name: &str) -> io::Result<()> {
        Ok(rustix::fs::unlinkat(&self.0, name, AtFlags::REMOVEDIR)?)
    }

    /// The names in it, and whether each is a folder; entered for its names.
    pub(super) fn entries(&self) -> io::Result<Vec<(String, bool)>> {
        let mut names = Vec::new();
        for entry in Dir::read_from(&self.0)? {
            let entry = entry?;
            let name = entry.file_name().to_string_lossy().into_owned();
            let is_folder = match entry.file_type() {
                FileType::Unknown => self.found(&name)? == Found::Folder,
                known => known == FileType::Directory,
            };
            if name != "." && name != ".." {
                names.push((name, is_folder));
            }
        }
        Ok(names)
    }

    /// Makes the names in it last; entered for its names.
    pub(super) fn sync(self) -> io::Result<()> {
        File::from(self.0).sync_all()
    }

    /// Makes all that waits on its disk last.
    #[cfg(target_os = "linux")]
    pub(super) fn sync_disk(self) -> io::Result<()> {
        Ok(rustix::fs::syncfs(self.0)?)
    }

    /// Whether the open file is the one of that name.
    pub(super) fn is_named(&self, name: &str, file: &File) -> io::Result<bool> {
        let held = rustix::fs::fstat(file)?;
        match rustix::fs::statat(&self.0, name, AtFlags::SYMLINK_NOFOLLOW) {
            Ok(named) => Ok((named.st_dev, named.st_ino) == (held.st_dev, held.st_ino)),
            Err(Errno::NOENT) => Ok(false),
            Err(e) => Err(e.into()),
        }
    }
}
