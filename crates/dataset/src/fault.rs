//! Fault: what is wrong, where, and what to do about it. The one error of everything that reads or writes datasets.

use std::borrow::Cow;
use std::fmt;
use std::io::{Error, ErrorKind};
use std::path::Path;

use parquet::errors::ParquetError;
use serde::Serialize;

use super::atomic_file::{DiskSpace, FileError, disk_space};
use super::enclosed::is_strange;

/// Free space that is no sign of a full disk [bytes].
const ROOM_BYTES: u64 = 1 << 20;

/// What is wrong, where, and what to do.
///
/// ```
/// use dataset::Fault;
///
/// let fault = Fault::new("planks/data/train-00000.parquet", "it has no column `index`", "make it again");
/// assert_eq!(fault.to_string(), "planks/data/train-00000.parquet: it has no column `index`; make it again");
/// let fault = Fault { tried: Some("use"), ..Fault::new("planks", "it is not empty", "choose an empty folder") };
/// assert_eq!(fault.to_string(), "cannot use planks: it is not empty; choose an empty folder");
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Fault {
    /// What could not be done there, such as `write`; `None` where the content is wrong.
    #[serde(skip)]
    pub tried: Option<&'static str>,
    /// File, folder, shard, sample or option.
    pub place: String,
    /// What is wrong.
    pub what: String,
    /// What to do.
    pub remedy: Cow<'static, str>,
}

impl Fault {
    /// Wrong content of a place.
    pub fn new(place: impl Into<String>, what: impl Into<String>, remedy: impl Into<Cow<'static, str>>) -> Self {
        Self { tried: None, place: one_line(place.into()), what: what.into(), remedy: remedy.into() }
    }

    /// Wrong content of a file or folder.
    pub fn at(place: &Path, what: impl Into<String>, remedy: impl Into<Cow<'static, str>>) -> Self {
        Self::new(place.display().to_string(), what, remedy)
    }

    /// Damage of a dataset that was whole once.
    pub fn damaged(place: &Path, what: impl Into<String>) -> Self {
        Self::at(place, what, "`gen validate` says what is damaged")
    }

    /// The same fault, said of a part of the place: `part: what`.
    pub fn of_part(mut self, part: impl fmt::Display) -> Self {
        self.what = format!("{part}: {}", self.what);
        self
    }

    /// A refusal of the operating system. Where the disk is full, `needed` is what the rest of a shard takes [bytes].
    pub(super) fn of_file(error: FileError, needed: Option<u64>) -> Self {
        let FileError { operation, path, source } = error;
        let (what, remedy) = match source.kind() {
            kind @ (ErrorKind::StorageFull | ErrorKind::QuotaExceeded) => {
                full(kind, &source, disk_space(&path), needed)
            }
            _ => (source.to_string(), remedy(operation, &source)),
        };
        Self { tried: Some(operation), ..Self::at(&path, what, remedy) }
    }
}

/// A name on one line, without what a terminal would obey: a file can be called anything.
pub fn one_line(name: String) -> String {
    plain(&name, &[]).into_owned()
}

/// A text without what a terminal would obey, but for characters that are `kept`.
pub fn plain<'t>(text: &'t str, kept: &[char]) -> Cow<'t, str> {
    let is_plain = |c: char| kept.contains(&c) || !c.is_control();
    if text.chars().all(is_plain) {
        return Cow::Borrowed(text);
    }
    let mut plain = String::with_capacity(text.len());
    for c in text.chars() {
        if is_plain(c) { plain.push(c) } else { plain.extend(c.escape_default()) }
    }
    Cow::Owned(plain)
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { tried, place, what, remedy } = self;
        match tried {
            Some(tried) => write!(f, "cannot {tried} {place}: {what}; {remedy}"),
            None => write!(f, "{place}: {what}; {remedy}"),
        }
    }
}

impl std::error::Error for Fault {}

impl From<FileError> for Fault {
    fn from(error: FileError) -> Self {
        Self::of_file(error, None)
    }
}

/// What to do about a refusal of the system, but for a disk that is full.
fn remedy(operation: &str, source: &Error) -> &'static str {
    if is_strange(source) {
        return "move it away: a dataset's folder holds plain files and folders, and no link in it is followed";
    }
    if let Some(remedy) = own_remedy(source) {
        return remedy;
    }
    match source.kind() {
        ErrorKind::PermissionDenied if ["read", "list"].contains(&operation) => {
            "allow this user to read it, then run the same command again"
        }
        ErrorKind::PermissionDenied => "allow this user to write there, or choose another folder",
        ErrorKind::ReadOnlyFilesystem => "choose a folder on a disk that can be written",
        ErrorKind::NotFound | ErrorKind::NotADirectory => "check the path: a part of it is missing or is no folder",
        ErrorKind::IsADirectory | ErrorKind::DirectoryNotEmpty => "move the folder of that name away",
        ErrorKind::ResourceBusy => "wait until no other program uses it, then run the same command again",
        _ if source.get_ref().is_some_and(|inner| inner.is::<ParquetError>()) => {
            "this is a fault of the program, please report it"
        }
        _ => "check the disk, then run the same command to continue",
    }
}

/// What to do about a refusal of the system that has a remedy of its own, whatever was tried; `None` for others.
///
/// ```
/// let refusal = std::io::Error::other("no refusal of the system");
/// assert_eq!(dataset::own_remedy(&refusal), None);
/// ```
pub fn own_remedy(refusal: &Error) -> Option<&'static str> {
    let number = refusal.raw_os_error()?;
    match refusal.kind() {
        ErrorKind::InvalidFilename => Some("give a shorter or plainer path"),
        ErrorKind::FileTooLarge => {
            Some("have the limit on the size of a file raised, take a disk without one, or smaller --samples-per-shard")
        }
        ErrorKind::OutOfMemory => Some("end other programs or take fewer --threads, then run the same command again"),
        ErrorKind::StaleNetworkFileHandle | ErrorKind::TimedOut => {
            Some("look whether the machine that keeps this disk is there, then run the same command to continue")
        }
        _ => remedy_of_number(number),
    }
}

/// The same of refusals that the standard library has no name for.
fn remedy_of_number(number: i32) -> Option<&'static str> {
    const OPEN_FILES: &str = "raise the limit of open files (`ulimit -n 1024`), then run the same command again; \
        nothing is known to be wrong";
    #[cfg(unix)]
    match rustix::io::Errno::from_raw_os_error(number) {
        rustix::io::Errno::MFILE => Some(OPEN_FILES),
        rustix::io::Errno::NFILE => {
            Some("end other programs or have the system's limit of open files raised, then run the same command again")
        }
        rustix::io::Errno::IO => Some(
            "the disk fails: save what is on it, look into the system's log (`dmesg`), and go on with another disk",
        ),
        rustix::io::Errno::LOOP => Some("correct the path: its links lead back to themselves"),
        _ => None,
    }
    // ERROR_TOO_MANY_OPEN_FILES.
    #[cfg(not(unix))]
    (number == 4).then_some(OPEN_FILES)
}

/// A size in words.
pub fn describe_bytes(n: u64) -> String {
    let units = [("TB", 1e12), ("GB", 1e9), ("MB", 1e6), ("kB", 1e3)];
    let n = n as f64;
    units
        .iter()
        .find(|(_, size)| n >= *size)
        .map_or(format!("{n} bytes"), |(unit, size)| format!("{:.1} {unit}", n / size))
}

/// What is used up, and what to do: the disk, its files, or what a quota gives to this user or folder.
fn full(kind: ErrorKind, source: &Error, space: Option<DiskSpace>, needed: Option<u64>) -> (String, &'static str) {
    let free = space.map_or("free space unknown".into(), |space| format!("{} free", describe_bytes(space.bytes)));
    let needed_there = needed
        .map_or(String::new(), |bytes| format!(", about {} needed for the rest of this shard", describe_bytes(bytes)));
    if space.is_some_and(|space| space.files == Some(0)) {
        return (
            format!("the disk takes no more files ({source}): its inodes are used up, {free}"),
            "finished shards are intact: remove files or ask for fewer EXR files, then run the same command to \
                continue",
        );
    }
    let is_roomy = space.is_some_and(|space| space.bytes >= needed.unwrap_or(0).max(ROOM_BYTES));
    if kind == ErrorKind::QuotaExceeded || is_roomy {
        return (
            format!("a quota or another limit of this disk is reached ({source}): the disk has {free}{needed_there}"),
            "finished shards are intact: have the limit raised or make room below it, then run the same command to \
                continue",
        );
    }
    (
        format!("the disk is full ({source}): {free}{needed_there}"),
        "finished shards are intact: make room, then run the same command to continue",
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Guards every refusal of the system that users meet: each has a remedy that fits, and only a disk that fails is
    /// called one.
    #[cfg(unix)]
    #[test]
    fn every_refusal_has_its_own_remedy() {
        use rustix::io::Errno;
        let told = |errno: Errno, operation| {
            let source = Error::from_raw_os_error(errno.raw_os_error());
            Fault::from(FileError { operation, path: "planks".into(), source }).remedy
        };
        let cases = [
            (Errno::MFILE, "`ulimit -n"),
            (Errno::NFILE, "limit of open files"),
            (Errno::DQUOT, "limit raised"),
            (Errno::NOSPC, "make room"),
            (Errno::ROFS, "that can be written"),
            (Errno::NAMETOOLONG, "shorter"),
            (Errno::ACCESS, "allow this user"),
            (Errno::PERM, "allow this user"),
            (Errno::IO, "the disk fails"),
            (Errno::FBIG, "limit on the size of a file"),
            (Errno::LOOP, "links"),
            (Errno::NOENT, "check the path"),
            (Errno::NOTDIR, "check the path"),
            (Errno::ISDIR, "the folder of that name"),
            (Errno::NOTEMPTY, "the folder of that name"),
            (Errno::BUSY, "no other program"),
            (Errno::STALE, "machine that keeps this disk"),
            (Errno::TIMEDOUT, "machine that keeps this disk"),
            (Errno::NOMEM, "fewer --threads"),
        ];
        for (errno, words) in cases {
            for operation in ["read", "list", "create", "write", "sync", "rename to", "remove", "lock"] {
                let remedy = told(errno, operation);
                let is_room = [Errno::NOSPC, Errno::DQUOT].contains(&errno) && remedy.contains("finished shards");
                assert!(remedy.contains(words) || is_room, "{errno:?} at {operation}: {remedy}");
                assert!(!remedy.contains("check the disk"), "{errno:?} at {operation}: {remedy}");
            }
        }
    }

    /// Sizes of a full disk are told in units that fit: never as nothing.
    #[test]
    fn small_sizes_are_told() {
        let space = Some(DiskSpace { bytes: 4096, files: None });
        let (what, _) = full(ErrorKind::StorageFull, &Error::from(ErrorKind::StorageFull), space, Some(36_000));
        assert!(what.contains("4.1 kB free, about 36.0 kB needed"), "{what}");
        let space = Some(DiskSpace { bytes: 0, files: None });
        let (what, _) = full(ErrorKind::StorageFull, &Error::from(ErrorKind::StorageFull), space, None);
        assert!(what.contains("0 bytes free"), "{what}");
    }

    /// What the system calls a full disk is called what it is.
    #[test]
    fn a_limit_is_no_full_disk() {
        let told = |kind: ErrorKind, bytes: u64, files: Option<u64>, needed: Option<u64>| {
            full(kind, &Error::from(kind), Some(DiskSpace { bytes, files }), needed).0
        };
        let no_space = ErrorKind::StorageFull;
        assert!(told(no_space, 4096, None, Some(9_000_000)).starts_with("the disk is full"));
        assert!(told(no_space, 4096, Some(7), None).starts_with("the disk is full"));
        assert!(told(no_space, 5_000_000, Some(7), Some(9_000_000)).contains("5.0 MB free, about 9.0 MB needed"));
        assert!(told(no_space, 56_096_000_000, Some(7), Some(9_000_000)).starts_with("a quota or another limit"));
        assert!(told(no_space, 56_096_000_000, Some(0), None).starts_with("the disk takes no more files"));
        assert!(told(ErrorKind::QuotaExceeded, 4096, None, None).starts_with("a quota or another limit"));
    }
}
