//! What can go wrong while a dataset is written: where, what, why, and what to do.

use std::io::{Error as IoError, ErrorKind};
use std::path::{Path, PathBuf};

use parquet::errors::ParquetError;

use super::atomic_file::Refused;
use super::durable::free_bytes;

/// Why a dataset folder or a shard cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum ShardError {
    /// The operating system refused.
    #[error("cannot {operation} {}: {source}; {remedy}", path.display())]
    Io {
        /// What was tried.
        operation: &'static str,
        /// Where.
        path: PathBuf,
        /// The system's reason.
        source: IoError,
        /// What to do.
        remedy: &'static str,
    },
    /// No space is left.
    #[error("cannot {operation} {}: the disk is full ({source}): {}; finished shards are intact: make room, then run the same command to continue", path.display(), space(*free, *needed))]
    DiskFull {
        /// What was tried.
        operation: &'static str,
        /// Where.
        path: PathBuf,
        /// The system's reason.
        source: IoError,
        /// Free space [bytes], where the system tells.
        free: Option<u64>,
        /// Space that the rest of the shard needs [bytes], estimated from what it has taken so far.
        needed: Option<u64>,
    },
    /// A Parquet file could not be written for a reason that is not the disk.
    #[error("cannot write {}: {source}; this is a fault of the program, please report it", path.display())]
    Parquet {
        /// Where.
        path: PathBuf,
        /// The reason.
        source: ParquetError,
    },
    /// The shard is locked by another process.
    #[error("shard {shard} is being written by another process; leave it to that process")]
    Busy {
        /// Number of the shard.
        shard: u64,
    },
    /// The shard is finished.
    #[error("shard {shard} is finished already; there is nothing to do")]
    Done {
        /// Number of the shard.
        shard: u64,
    },
    /// The folder holds something else.
    #[error("cannot use {}: {}; {remedy}", path.display(), reasons.join("; "))]
    Refused {
        /// The folder.
        path: PathBuf,
        /// Each difference.
        reasons: Vec<String>,
        /// What to do.
        remedy: &'static str,
    },
    /// A sample does not fit what `dataset.json` promises.
    #[error("sample {index} does not fit shard {shard}: {reason}; this is a fault of the program, please report it")]
    Misfit {
        /// Number of the shard.
        shard: u64,
        /// Number of the sample.
        index: u64,
        /// What differs.
        reason: String,
    },
}

impl ShardError {
    /// Whether the shard needs no work from this process: somebody else has it, or it is finished.
    pub fn is_skip(&self) -> bool {
        matches!(self, Self::Busy { .. } | Self::Done { .. })
    }

    pub(super) fn io(operation: &'static str, path: &Path, source: IoError) -> Self {
        let path = path.to_path_buf();
        if matches!(source.kind(), ErrorKind::StorageFull | ErrorKind::QuotaExceeded) {
            let free = free_bytes(&path);
            return Self::DiskFull { operation, path, source, free, needed: None };
        }
        let remedy = match source.kind() {
            ErrorKind::PermissionDenied => "allow this user to write there, or choose another folder",
            ErrorKind::ReadOnlyFilesystem => "choose a folder on a disk that can be written",
            ErrorKind::NotFound | ErrorKind::NotADirectory => "check the path: a part of it is missing or is no folder",
            _ => "check the disk, then run the same command to continue",
        };
        Self::Io { operation, path, source, remedy }
    }

    pub(super) fn parquet(path: &Path, source: ParquetError) -> Self {
        match source {
            ParquetError::External(inner) => match inner.downcast::<IoError>() {
                Ok(io) => Self::io("write", path, *io),
                Err(inner) => Self::Parquet { path: path.into(), source: ParquetError::External(inner) },
            },
            source => Self::Parquet { path: path.into(), source },
        }
    }

    /// Adds what the rest of the shard needs to an error about a full disk.
    pub(super) fn needing(mut self, bytes: u64) -> Self {
        if let Self::DiskFull { needed, .. } = &mut self {
            *needed = Some(bytes);
        }
        self
    }
}

impl From<Refused> for ShardError {
    fn from(Refused { operation, path, source }: Refused) -> Self {
        Self::io(operation, &path, source)
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
