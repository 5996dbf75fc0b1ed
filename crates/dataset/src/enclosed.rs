//! Enclosed files: what lies below a dataset's folder, opened from there name by name.
//!
//! That folder may come from anybody. No link in it is followed, so nothing outside of it is read, written or removed;
//! only plain files are opened, of which reading ends. No more is read than a file of its kind can hold; and what is
//! written is always a new file, never one that was there. The folder itself is named by the user: links that lead to
//! it are followed.
//!
//! The system's part is `Folder`: on Unix an open folder, in which names cannot be exchanged between looking and
//! opening; on Windows a path that was looked at, which leaves that gap to somebody who may write in the folder at the
//! same time.

use std::fs::File;
use std::io::{self, ErrorKind, Read, Write};
use std::path::Path;

use output_schema::file::temporary;

use super::atomic_file::FileError;

#[cfg(unix)]
mod unix;
#[cfg(windows)]
mod windows;

#[cfg(unix)]
use self::unix::Folder;
#[cfg(windows)]
use self::windows::Folder;

/// What a folder is entered for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Entry {
    /// To open what lies in it.
    Passage,
    /// To list it, or to sync its names.
    Names,
}

/// What a file is opened for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Use {
    /// To read it. A pipe is opened without waiting for its other end.
    Read,
    /// To read and to change it.
    Change,
    /// To sync it.
    Sync,
    /// To lock it; made where it is missing.
    Lock,
    /// To write it; made, and refused where it is there.
    New,
}

/// Something else lies there than a dataset has there, or more of it.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub(super) struct Strange(String);

/// Whether the error is about something strange in the folder, not about the system.
pub(super) fn is_strange(error: &io::Error) -> bool {
    error.get_ref().is_some_and(|inner| inner.is::<Strange>())
}

fn strange(what: String) -> io::Error {
    io::Error::other(Strange(what))
}

/// What has a name; links are not followed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Found {
    Nothing,
    /// A plain file of so many bytes.
    File(u64),
    Folder,
    Other(&'static str),
}

impl Found {
    /// Size of a plain file [bytes]; why it is none.
    fn plain(self, name: &str) -> io::Result<u64> {
        match self {
            Self::File(bytes) => Ok(bytes),
            other => Err(other.refused(name, "plain file")),
        }
    }

    /// Why it is not what is `wanted`.
    fn refused(self, name: &str, wanted: &str) -> io::Error {
        let found = match self {
            Self::Nothing => return ErrorKind::NotFound.into(),
            Self::File(_) => "a file",
            Self::Folder => "a folder",
            Self::Other(kind) => kind,
        };
        strange(format!("`{name}` is {found}, no {wanted}"))
    }
}

/// The reason of a refusal by the system: what has the name, where that is not what is `wanted`.
fn reason(folder: &Folder, name: &str, wanted: &str, error: io::Error) -> io::Error {
    match (folder.found(name), wanted) {
        (Ok(Found::File(_)), "plain file") | (Ok(Found::Folder), "folder") | (Ok(Found::Nothing) | Err(_), _) => error,
        (Ok(found), _) => found.refused(name, wanted),
    }
}

/// A path in folders and its last name; the folders are empty for a name in the root.
fn parted(relative: &str) -> io::Result<(&str, &str)> {
    // A backslash or a colon would lead elsewhere on Windows; no file of a dataset has one.
    if relative.split('/').any(|part| matches!(part, "" | "." | "..") || part.contains(['\0', '\\', ':'])) {
        return Err(strange(format!("`{}` is no path below the folder", relative.escape_debug())));
    }
    Ok(relative.rsplit_once('/').unwrap_or(("", relative)))
}

/// The folder at `folders` below the root, the root itself where that is empty; the last one is entered as `how` says.
fn folder_at(root: &Path, folders: &str, how: Entry) -> io::Result<Folder> {
    let root = if root.as_os_str().is_empty() { Path::new(".") } else { root };
    let mut folder = Folder::open(root, if folders.is_empty() { how } else { Entry::Passage })?;
    let mut parts = folders.split('/').filter(|part| !part.is_empty()).peekable();
    while let Some(part) = parts.next() {
        let how = if parts.peek().is_none() { how } else { Entry::Passage };
        folder = folder.enter(part, how).map_err(|e| reason(&folder, part, "folder", e))?;
    }
    Ok(folder)
}

/// The folder that holds a path, and the path's last name.
fn place<'a>(root: &Path, relative: &'a str) -> io::Result<(Folder, &'a str)> {
    let (folders, name) = parted(relative)?;
    Ok((folder_at(root, folders, Entry::Passage)?, name))
}

/// Opens the plain file `relative` below `root`, which has at most `most` bytes.
///
/// # Errors
/// The system's; `FileTooLarge` for a larger file.
pub fn open(root: &Path, relative: &str, most: u64) -> io::Result<File> {
    let (folder, name) = place(root, relative)?;
    let file = folder.file(name, Use::Read).map_err(|e| reason(&folder, name, "plain file", e))?;
    let bytes = Folder::kind(&file)?.plain(name)?;
    if bytes <= most { Ok(file) } else { Err(too_large(bytes, most)) }
}

fn too_large(bytes: u64, most: u64) -> io::Error {
    let what = format!("it has {bytes} bytes, more than the {most} that such a file can have");
    io::Error::new(ErrorKind::FileTooLarge, Strange(what))
}

/// The bytes of such a file.
///
/// # Errors
/// As [`open`].
pub fn read(root: &Path, relative: &str, most: u64) -> io::Result<Vec<u8>> {
    let file = open(root, relative, most)?;
    let bytes = file.metadata()?.len();
    let mut content = Vec::new();
    content.try_reserve_exact(usize::try_from(bytes).unwrap_or(usize::MAX).saturating_add(1))?;
    // It may grow while it is read.
    file.take(most.saturating_add(1)).read_to_end(&mut content)?;
    if content.len() as u64 > most { Err(too_large(content.len() as u64, most)) } else { Ok(content) }
}

/// Whether the plain file `relative` holds just `content`; `false` where there is none.
pub(super) fn holds(root: &Path, relative: &str, content: &[u8]) -> io::Result<bool> {
    match length(root, relative) {
        Ok(bytes) if bytes == content.len() as u64 => Ok(read(root, relative, bytes)? == content),
        Ok(_) => Ok(false),
        Err(e) if e.kind() == ErrorKind::NotFound => Ok(false),
        Err(e) => Err(e),
    }
}

/// Size of the plain file `relative` [bytes].
///
/// # Errors
/// The system's, and where it is something else.
pub fn length(root: &Path, relative: &str) -> io::Result<u64> {
    lengths(root, std::iter::once(relative)).next().unwrap_or_else(|| Err(ErrorKind::NotFound.into()))
}

/// The same of many files, quickly where those of one folder follow each other.
pub(super) fn lengths<'a>(
    root: &'a Path,
    files: impl Iterator<Item = &'a str> + 'a,
) -> impl Iterator<Item = io::Result<u64>> + 'a {
    let mut open: Option<(&str, Folder)> = None;
    files.map(move |relative| {
        let (folders, name) = parted(relative)?;
        let folder = match open.take() {
            Some((known, folder)) if known == folders => folder,
            _ => folder_at(root, folders, Entry::Passage)?,
        };
        let found = folder.found(name);
        open = Some((folders, folder));
        found?.plain(name)
    })
}

/// Names in the folder `relative` below the root, sorted; none where it is missing.
pub fn names(root: &Path, relative: &str) -> io::Result<Vec<String>> {
    match entries(root, relative) {
        Err(e) if e.kind() == ErrorKind::NotFound => Ok(Vec::new()),
        entries => Ok(entries?.into_iter().map(|(name, _)| name).collect()),
    }
}

/// Names in the folder `relative` below the root, sorted, and whether each is a folder.
pub(super) fn entries(root: &Path, relative: &str) -> io::Result<Vec<(String, bool)>> {
    let mut names = folder_at(root, relative, Entry::Names)?.entries()?;
    names.sort_unstable();
    Ok(names)
}

/// A new file of that name: what a killed process left under it is removed before.
///
/// # Errors
/// What the system refuses, and where something else than a file has the name.
pub fn create(root: &Path, relative: &str) -> Result<File, FileError> {
    remove(root, relative)?;
    let made = place(root, relative).and_then(|(folder, name)| folder.file(name, Use::New));
    made.map_err(FileError::of("create", &root.join(relative)))
}

/// Writes `relative` as a whole or not at all: under a temporary name, synced, renamed, its folder synced.
pub fn write(root: &Path, relative: &str, content: &[u8]) -> Result<(), FileError> {
    write_by(root, &temporary(relative), relative, content)
}

/// The same by way of `partial`, a name in the same folder.
pub fn write_by(root: &Path, partial: &str, relative: &str, content: &[u8]) -> Result<(), FileError> {
    let at = |operation| FileError::of(operation, &root.join(partial));
    let mut file = create(root, partial)?;
    let written = file.write_all(content).map_err(at("write"));
    let synced = written.and_then(|()| file.sync_all().map_err(at("sync")));
    let named = synced.and_then(|()| rename(root, partial, relative)).inspect_err(|_| {
        // The first error is the one to tell.
        let _ = remove(root, partial);
    });
    named.and_then(|()| sync_folder(root, parent(relative)))
}

/// The folders of a path; empty for a name in the root.
fn parent(relative: &str) -> &str {
    relative.rsplit_once('/').map_or("", |(folders, _)| folders)
}

/// Gives a file that is synced, or a folder of such, its name; a link of that name is replaced, not followed.
///
/// # Errors
/// What the system refuses.
pub fn rename(root: &Path, from: &str, to: &str) -> Result<(), FileError> {
    let renamed = (|| {
        let ((folder, name), (other, new)) = (place(root, from)?, place(root, to)?);
        folder.rename(name, &other, new)
    })();
    renamed.map_err(FileError::of("rename to", &root.join(to)))
}

/// Makes the folder `relative`, and those on the way to it, where they are not there.
pub fn make_folder(root: &Path, relative: &str) -> Result<(), FileError> {
    let made = (|| {
        parted(relative)?;
        let mut folder = folder_at(root, "", Entry::Passage)?;
        for part in relative.split('/') {
            match folder.make(part) {
                Err(e) if e.kind() != ErrorKind::AlreadyExists => return Err(e),
                _ => folder = folder.enter(part, Entry::Passage).map_err(|e| reason(&folder, part, "folder", e))?,
            }
        }
        Ok(())
    })();
    made.map_err(FileError::of("create", &root.join(relative)))
}

/// Makes the names in the folder `relative` last.
pub(super) fn sync_folder(root: &Path, relative: &str) -> Result<(), FileError> {
    let synced = folder_at(root, relative, Entry::Names).and_then(Folder::sync);
    synced.map_err(FileError::of("sync", &root.join(relative)))
}

/// Makes the bytes of a plain file last.
pub(super) fn sync(root: &Path, relative: &str) -> Result<(), FileError> {
    let synced = place(root, relative).and_then(|(folder, name)| folder.file(name, Use::Sync)?.sync_all());
    synced.map_err(FileError::of("sync", &root.join(relative)))
}

/// Makes all that lies below the root last, and its names: at once for all that waits on its disk, which takes far less
/// than file by file.
///
/// # Errors
/// What the system refuses.
#[cfg(target_os = "linux")]
pub fn sync_below(root: &Path) -> io::Result<()> {
    folder_at(root, "", Entry::Names)?.sync_disk()
}

/// Makes all that lies below the root last, and its names where the system can.
///
/// # Errors
/// What the system refuses.
#[cfg(not(target_os = "linux"))]
pub fn sync_below(root: &Path) -> io::Result<()> {
    fn below(root: &Path, folder: &str) -> io::Result<()> {
        for (name, is_folder) in entries(root, folder)? {
            let path = if folder.is_empty() { name } else { format!("{folder}/{name}") };
            if is_folder { below(root, &path)? } else { sync(root, &path).map_err(|refused| refused.source)? }
        }
        folder_at(root, folder, Entry::Names)?.sync()
    }
    below(root, "")
}

/// Opens the plain file at `path`, which a command keeps beside its results, to read and to change; no link of that
/// name is followed.
///
/// # Errors
/// The system's, and where something else has the name.
pub fn open_kept(path: &Path) -> io::Result<File> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let name = path.file_name().ok_or(ErrorKind::NotFound)?;
    let folder = Folder::open(folder, Entry::Passage)?;
    let file = match (folder.file(name, Use::Change), path.symlink_metadata()) {
        (Ok(file), _) => file,
        (Err(_), Ok(found)) if found.is_symlink() => return Err(strange("it is a link, no plain file".into())),
        (Err(error), _) => return Err(error),
    };
    match Folder::kind(&file)? {
        Found::File(_) => Ok(file),
        Found::Other(kind) => Err(strange(format!("it is {kind}, no plain file"))),
        Found::Folder | Found::Nothing => Err(strange("it is no plain file".into())),
    }
}

/// What came of removing something; nothing to remove is well.
fn removed<T>(root: &Path, relative: &str, outcome: io::Result<T>) -> Result<(), FileError> {
    match outcome {
        Err(e) if e.kind() != ErrorKind::NotFound => Err(FileError::of("remove", &root.join(relative))(e)),
        _ => Ok(()),
    }
}

/// Refuses what [`remove`] would refuse, and removes nothing.
pub(super) fn check_removable(root: &Path, relative: &str) -> Result<(), FileError> {
    removed(root, relative, length(root, relative))
}

/// Removes a plain file; nothing to remove is well.
pub fn remove(root: &Path, relative: &str) -> Result<(), FileError> {
    check_removable(root, relative)?;
    removed(root, relative, place(root, relative).and_then(|(folder, name)| folder.remove_file(name)))
}

/// Whether a new file of that name can be made; none is left.
pub fn check_writable(root: &Path, relative: &str) -> Result<(), FileError> {
    create(root, relative)?;
    remove(root, relative)
}

/// The plain files in a folder that holds nothing else, each of a name that `is_own`; none where it is missing.
pub(super) fn own_files(root: &Path, relative: &str, is_own: fn(&str) -> bool) -> Result<Vec<String>, FileError> {
    let names = names(root, relative).map_err(FileError::of("list", &root.join(relative)))?;
    let paths: Vec<String> = names.iter().map(|name| format!("{relative}/{name}")).collect();
    for ((name, path), length) in names.iter().zip(&paths).zip(lengths(root, paths.iter().map(String::as_str))) {
        let foreign = (!is_own(name)).then(|| strange(format!("`{name}` is no file of a dataset")));
        if let Some(error) = foreign.or(length.err()) {
            return Err(FileError::of("remove", &root.join(path))(error));
        }
    }
    Ok(paths)
}

/// Removes an empty folder; nothing to remove is well.
pub(super) fn remove_empty_folder(root: &Path, relative: &str) -> Result<(), FileError> {
    removed(root, relative, place(root, relative).and_then(|(folder, name)| folder.remove_folder(name)))
}

/// Opens a lock file, and makes it where it is missing; its content is never looked at.
pub(super) fn open_lock(root: &Path, relative: &str) -> io::Result<File> {
    let (folder, name) = place(root, relative)?;
    let file = folder.file(name, Use::Lock).map_err(|e| reason(&folder, name, "plain file", e))?;
    Folder::kind(&file)?.plain(name)?;
    Ok(file)
}

/// Whether the open file is still the one of that name.
pub(super) fn is_named(root: &Path, relative: &str, file: &File) -> io::Result<bool> {
    let (folder, name) = match place(root, relative) {
        Err(e) if e.kind() == ErrorKind::NotFound => return Ok(false),
        place => place?,
    };
    folder.is_named(name, file)
}

#[cfg(all(test, unix))]
mod tests {
    use std::fs;
    use std::os::unix::fs::symlink;

    use super::*;

    #[test]
    fn no_path_leads_out() {
        let place = tempfile::tempdir().expect("a folder");
        let (root, out) = (place.path().join("set"), place.path().join("out"));
        fs::create_dir_all(root.join("data")).expect("made");
        fs::create_dir(&out).expect("made");
        fs::write(out.join("a"), "mine").expect("written");
        fs::write(root.join("data/a"), "own").expect("written");
        symlink("../out", root.join("link")).expect("linked");
        symlink("../../out/a", root.join("data/b")).expect("linked");
        assert_eq!(read(&root, "data/a", 3).expect("it is there"), b"own");
        assert_eq!(read(&root, "data/a", 2).expect_err("it is larger").kind(), ErrorKind::FileTooLarge);
        for path in [
            "../out/a",
            "data/../../out/a",
            "/etc/passwd",
            "data//a",
            "./data/a",
            "",
            "link/a",
            "data/b",
            "data\\a",
            "c:a",
        ] {
            let error = read(&root, path, 99).expect_err(path);
            assert!(is_strange(&error), "{path}: {error}");
            assert!(length(&root, path).is_err() && create(&root, path).is_err() && remove(&root, path).is_err());
            assert!(open_lock(&root, path).is_err() && make_folder(&root, path).is_err(), "{path}");
        }
        assert_eq!(fs::read(out.join("a")).expect("it is there"), b"mine");
        assert_eq!(fs::read_dir(&out).expect("it lists").count(), 1);
        assert!(names(&root, "link").is_err() && names(&root, "none").is_ok_and(|names| names.is_empty()));
        let message = read(&root, "data/b", 99).expect_err("a link").to_string();
        assert_eq!(message, "`b` is a link, no plain file");
        assert_eq!(read(&root, "link/a", 99).expect_err("a link").to_string(), "`link` is a link, no folder");
        write(&root, "data/b", b"new").expect("it takes the place of the link");
        assert_eq!(read(&root, "data/b", 99).expect("a file now"), b"new");
        assert_eq!(fs::read(out.join("a")).expect("it is there"), b"mine");
    }

    /// What is written is a new file: a second name of a file elsewhere keeps its content.
    #[test]
    fn a_second_name_is_not_written_through() {
        let place = tempfile::tempdir().expect("a folder");
        fs::write(place.path().join("victim"), "mine").expect("written");
        fs::hard_link(place.path().join("victim"), place.path().join(".tmp-a")).expect("linked");
        write(place.path(), "a", b"own").expect("it is written");
        assert_eq!(fs::read(place.path().join("victim")).expect("it is there"), b"mine");
        assert_eq!(names(place.path(), "").expect("it lists"), ["a", "victim"]);
    }
}
