//! Files that a user names are opened here, and nowhere else.
//!
//! A link to a plain file is followed: caches and version control of data consist of them. A folder, a pipe, a socket
//! or a device, of which reading may wait or never end, is refused at once. Nothing is read beyond what the caller can
//! use. `-` stands for standard input where a command takes the content of one file. `./-` is a file of that name.
//!
//! What can be made again is kept in a [`Cache`].
//!
//! What lies in a dataset's folder, and what a command keeps for itself beside its results, comes from anybody: that is
//! opened by `dataset::enclosed`, which follows no link.

mod cache;

use std::fs::{File, Metadata};
use std::io::{self, Error, ErrorKind, Read};
use std::path::Path;

pub use cache::Cache;

/// How arguments name standard input.
const STANDARD_INPUT: &str = "-";

/// Opens a plain file to read.
///
/// # Errors
/// The system's; `Other` where the name is no plain file's.
pub fn open(path: &Path) -> io::Result<File> {
    match open_at_once(path) {
        Ok(file) => match refusal(&file.metadata()?) {
            Some(refused) => Err(refused),
            None => Ok(file),
        },
        // A socket cannot be opened, a folder not everywhere: why is of more use than what the system says.
        Err(error) => Err(std::fs::metadata(path).ok().and_then(|found| refusal(&found)).unwrap_or(error)),
    }
}

/// Opens a plain file of at most `most` bytes, and tells how many it has.
///
/// # Errors
/// As [`open`]; `FileTooLarge` for a larger file.
pub fn open_within(path: &Path, most: u64) -> io::Result<(File, u64)> {
    let file = open(path)?;
    let bytes = file.metadata()?.len();
    if bytes > most {
        Err(too_large(&format!("{bytes} bytes, more than the {most} that are read")))
    } else {
        Ok((file, bytes))
    }
}

/// The bytes of a plain file of at most `most`.
///
/// # Errors
/// As [`open_within`].
pub fn read(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let (file, bytes) = open_within(path, most)?;
    let mut content = Vec::new();
    content.try_reserve_exact(usize::try_from(bytes).unwrap_or(usize::MAX).saturating_add(1))?;
    read_to_end(file, most, content)
}

/// The same, of standard input where the path is `-`.
///
/// # Errors
/// As [`read`].
pub fn read_or_standard_input(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    if is_standard_input(path) { read_to_end(io::stdin().lock(), most, Vec::new()) } else { read(path, most) }
}

/// The first bytes of a plain file, `most` or as many as it has.
///
/// # Errors
/// As [`open`].
pub fn read_start(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    start(open(path)?, most)
}

/// The same, of standard input where the path is `-`.
///
/// # Errors
/// As [`open`].
pub fn read_start_or_standard_input(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    if is_standard_input(path) { start(io::stdin().lock(), most) } else { read_start(path, most) }
}

/// Whether a path stands for standard input.
pub fn is_standard_input(path: &Path) -> bool {
    path == Path::new(STANDARD_INPUT)
}

/// What such a path is called where something is said about its content.
pub fn shown(path: &Path) -> String {
    if is_standard_input(path) { "standard input".into() } else { path.display().to_string() }
}

fn start(reader: impl Read, most: u64) -> io::Result<Vec<u8>> {
    let mut content = Vec::new();
    reader.take(most).read_to_end(&mut content)?;
    Ok(content)
}

/// All that a reader gives, which may grow meanwhile.
fn read_to_end(reader: impl Read, most: u64, mut content: Vec<u8>) -> io::Result<Vec<u8>> {
    reader.take(most.saturating_add(1)).read_to_end(&mut content)?;
    if content.len() as u64 > most {
        Err(too_large(&format!("more than the {most} bytes that are read")))
    } else {
        Ok(content)
    }
}

fn too_large(has: &str) -> Error {
    Error::new(ErrorKind::FileTooLarge, format!("it has {has}"))
}

/// Why nothing is read of what was found; `None` for a plain file.
fn refusal(found: &Metadata) -> Option<Error> {
    (!found.is_file()).then(|| Error::other(format!("it is {}, no plain file", kind(found))))
}

/// What is no plain file, in words.
#[cfg(unix)]
fn kind(found: &Metadata) -> &'static str {
    use std::os::unix::fs::FileTypeExt;
    match found.file_type() {
        kind if kind.is_dir() => "a folder",
        kind if kind.is_fifo() => "a pipe",
        kind if kind.is_socket() => "a socket",
        _ => "a device",
    }
}

/// What is no plain file, in words.
#[cfg(not(unix))]
fn kind(found: &Metadata) -> &'static str {
    if found.is_dir() { "a folder" } else { "a device" }
}

/// Opens for reading whatever has the name, and waits for nobody at the other end of a pipe.
#[cfg(unix)]
fn open_at_once(path: &Path) -> io::Result<File> {
    use rustix::fs::{Mode, OFlags};
    let flags = OFlags::RDONLY | OFlags::NONBLOCK | OFlags::NOCTTY | OFlags::CLOEXEC;
    Ok(rustix::fs::open(path, flags, Mode::empty())?.into())
}

/// Opens for reading whatever has the name; pipes have no names among files here.
#[cfg(not(unix))]
fn open_at_once(path: &Path) -> io::Result<File> {
    File::open(path)
}

#[cfg(all(test, unix))]
mod tests {
    use std::os::unix::fs::symlink;
    use std::os::unix::net::UnixListener;
    use std::process::Command;

    use super::*;

    /// Plain files and links to them are read, up to the bound; all else is refused by its kind, and nothing is waited
    /// for.
    #[test]
    fn plain_files_are_read_and_nothing_else() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = |name: &str| folder.path().join(name);
        std::fs::write(path("plain"), "abc").expect("written");
        symlink("plain", path("link")).expect("linked");
        symlink("nothing", path("dangling")).expect("linked");
        symlink("/dev/zero", path("endless")).expect("linked");
        assert!(Command::new("mkfifo").arg(path("pipe")).status().is_ok_and(|status| status.success()));
        let _socket = UnixListener::bind(path("socket")).expect("a socket");
        File::create(path("sparse")).and_then(|file| file.set_len(20_000_000_000)).expect("it takes no room");
        for name in ["plain", "link"] {
            assert_eq!(read(&path(name), 3).expect("it is plain"), b"abc");
            assert_eq!(read_start(&path(name), 2).expect("it is plain"), b"ab");
            assert_eq!(read(&path(name), 2).expect_err("it is larger").kind(), ErrorKind::FileTooLarge);
        }
        let said = |name: &str| read(&path(name), 1 << 20).expect_err(name).to_string();
        assert_eq!(said("sparse"), "it has 20000000000 bytes, more than the 1048576 that are read");
        for (name, what) in [("", "a folder"), ("pipe", "a pipe"), ("socket", "a socket"), ("endless", "a device")] {
            assert_eq!(said(name), format!("it is {what}, no plain file"));
        }
        for name in ["dangling", "nothing"] {
            assert_eq!(read(&path(name), 3).expect_err(name).kind(), ErrorKind::NotFound);
        }
    }
}
