//! Fault: what is wrong, where, and what to do about it. The one error of everything that reads or writes datasets.

use std::borrow::Cow;
use std::fmt;
use std::io::ErrorKind;
use std::path::Path;

use parquet::errors::ParquetError;
use serde::Serialize;

use super::atomic_file::{FileError, free_bytes};

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
        Self { tried: None, place: place.into(), what: what.into(), remedy: remedy.into() }
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
            ErrorKind::StorageFull | ErrorKind::QuotaExceeded => (
                format!("the disk is full ({source}): {}", space(free_bytes(&path), needed)),
                "finished shards are intact: make room, then run the same command to continue",
            ),
            kind => (
                source.to_string(),
                match kind {
                    ErrorKind::PermissionDenied => "allow this user to write there, or choose another folder",
                    ErrorKind::ReadOnlyFilesystem => "choose a folder on a disk that can be written",
                    ErrorKind::NotFound | ErrorKind::NotADirectory => {
                        "check the path: a part of it is missing or is no folder"
                    }
                    _ if source.get_ref().is_some_and(|inner| inner.is::<ParquetError>()) => {
                        "this is a fault of the program, please report it"
                    }
                    _ => "check the disk, then run the same command to continue",
                },
            ),
        };
        Self { tried: Some(operation), ..Self::at(&path, what, remedy) }
    }
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

fn space(free: Option<u64>, needed: Option<u64>) -> String {
    let mb = |bytes: u64| format!("{:.1} MB", bytes as f64 / 1e6);
    let free = free.map_or("free space unknown".into(), |bytes| format!("{} free", mb(bytes)));
    match needed {
        Some(bytes) => format!("{free}, about {} needed for the rest of this shard", mb(bytes)),
        None => free,
    }
}
