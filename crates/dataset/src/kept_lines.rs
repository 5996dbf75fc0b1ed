//! What long work keeps on disk while it runs: one JSON document a line, so that work that was killed goes on where it
//! was. The first line says what the work is; lines of other work are refused, and a last line that a kill cut short is
//! dropped. Who takes lines from it asks of each whether it is what is wanted next: a kept file saves time and never
//! changes a result.

use std::fs::File;
use std::io::{BufRead, BufReader, Error, ErrorKind, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

use crate::{Fault, atomic_file, enclosed};

/// Longest line that is read: the first one holds a recipe [bytes].
const MAX_LINE_BYTES: u64 = 1 << 24;

/// What a kind of work says of its kept file.
#[derive(Debug, Clone, Copy)]
pub struct KeptKind {
    /// What stands under `kind` in the first line.
    pub kind: &'static str,
    /// The key of the first line that says what the work is.
    pub key: &'static str,
    /// What is told of a file of other work of this kind, and of one of none.
    pub refusals: [&'static str; 2],
}

/// The file, open behind its last whole line.
#[derive(Debug)]
pub struct KeptLines {
    path: PathBuf,
    file: File,
}

impl KeptLines {
    /// Opens the file of the work that `what` describes, or begins it; and the lines that it holds.
    ///
    /// # Errors
    /// Where something else has the name or it is of other work, which stays as it is, or it cannot be written.
    pub fn open<T: DeserializeOwned>(path: &Path, kind: &KeptKind, what: &Value) -> Result<(Self, Vec<T>), Fault> {
        let refused =
            |e: &Error| Fault::at(path, format!("it cannot be used: {e}"), "give another --out, or remove it");
        let head = serde_json::json!({ "kind": kind.kind, kind.key: what });
        let mut file = match enclosed::open_kept(path) {
            Err(e) if e.kind() == ErrorKind::NotFound => begin(path, &head)?,
            opened => opened.map_err(|e| refused(&e))?,
        };
        let mut reader = BufReader::new(&file);
        let (mut whole, mut line, mut kept) = (0_u64, Vec::new(), Vec::new());
        loop {
            line.clear();
            let read = (&mut reader).take(MAX_LINE_BYTES).read_until(b'\n', &mut line).map_err(|e| refused(&e))?;
            if whole == 0 {
                let found = line.strip_suffix(b"\n").and_then(|head| serde_json::from_slice::<Value>(head).ok());
                if found.as_ref() != Some(&head) {
                    let is_other = found.is_some_and(|found| found["kind"] == kind.kind);
                    let what = kind.refusals[usize::from(!is_other)];
                    return Err(Fault::at(path, what, "give another --out, or remove that file to begin anew"));
                }
            } else if line.ends_with(b"\n")
                && let Ok(one) = serde_json::from_slice(&line)
            {
                kept.push(one);
            } else {
                break;
            }
            whole += read as u64;
        }
        drop(reader);
        file.set_len(whole).map_err(|e| refused(&e))?;
        file.seek(SeekFrom::Start(whole)).map_err(|e| refused(&e))?;
        Ok((Self { path: path.into(), file }, kept))
    }

    /// Keeps lines.
    ///
    /// # Errors
    /// Where the disk refuses.
    pub fn keep<T: Serialize>(&mut self, documents: &[T]) -> Result<(), Fault> {
        let mut keep = |one| line(one).and_then(|line| self.file.write_all(&line));
        documents.iter().try_for_each(|one| keep(one).map_err(|e| unwritten(&self.path, &e)))
    }

    /// Where it lies.
    pub fn path(&self) -> &Path {
        &self.path
    }
}

/// A document as a line.
fn line(document: &impl Serialize) -> Result<Vec<u8>, Error> {
    let mut line = serde_json::to_vec(document)?;
    line.push(b'\n');
    Ok(line)
}

/// A new file with this first line, which is there as a whole or not at all.
fn begin(path: &Path, head: &Value) -> Result<File, Fault> {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let partial = path.with_file_name(format!(".tmp-{}-{name}", std::process::id()));
    let begun = line(head).and_then(|head| {
        atomic_file::write(&partial, path, &head).map_err(|refused| refused.source)?;
        enclosed::open_kept(path)
    });
    begun.map_err(|e| unwritten(path, &e))
}

fn unwritten(path: &Path, error: &Error) -> Fault {
    let remedy = "make room, and give the same command again: it goes on";
    Fault::at(path, format!("it cannot be written: {error}"), remedy)
}
