//! Simulated scans that are kept on disk while a fit runs: one JSON document a line, so that a fit that was killed goes
//! on where it was. The first line says what is fitted; a scan is taken from the file only where its number and its
//! scores are those that the fit asks for, so a kept file can save time and never change a result. A last line that a
//! kill cut short is dropped.

use std::fs::File;
use std::io::{BufRead, BufReader, Error, ErrorKind, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use dataset::{Fault, atomic_file, enclosed};
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// What kept scans are of.
const KIND: &str = "sheetlight fit";

/// Longest line that is read: the first one holds a recipe [bytes].
const MAX_LINE_BYTES: u64 = 1 << 24;

/// A kept scan.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct KeptScan {
    /// Its number.
    pub index: u64,
    /// Scores of the keys.
    pub scores: Vec<f64>,
    /// Statistics, null where there is none.
    pub statistics: Vec<Option<f64>>,
}

/// The file, with what it held.
#[derive(Debug)]
pub(crate) struct ScanStore {
    path: PathBuf,
    file: File,
    kept: std::collections::VecDeque<KeptScan>,
}

impl ScanStore {
    /// Opens the file of a fit that `what` describes, or begins it.
    ///
    /// # Errors
    /// Where something else has the name or it is of another fit, which stays as it is, or it cannot be written.
    pub fn open(path: &Path, what: &Value) -> Result<Self, Fault> {
        let refused =
            |e: &Error| Fault::at(path, format!("it cannot be used: {e}"), "give another --out, or remove it");
        let head = serde_json::json!({ "kind": KIND, "fit": what });
        let file = match enclosed::open_kept(path) {
            Err(e) if e.kind() == ErrorKind::NotFound => begin(path, &head)?,
            opened => opened.map_err(|e| refused(&e))?,
        };
        let mut store = Self { path: path.into(), file, kept: Default::default() };
        let mut reader = BufReader::new(&store.file);
        let (mut whole, mut line) = (0_u64, Vec::new());
        loop {
            line.clear();
            let read = (&mut reader).take(MAX_LINE_BYTES).read_until(b'\n', &mut line).map_err(|e| refused(&e))?;
            if whole == 0 {
                let found = line.strip_suffix(b"\n").and_then(|head| serde_json::from_slice::<Value>(head).ok());
                if found.as_ref() != Some(&head) {
                    let is_fit = found.is_some_and(|found| found["kind"] == KIND);
                    let what = if is_fit {
                        "it keeps the scans of another fit (recipe, keys, seed or real scans differ)"
                    } else {
                        "it keeps no scans of a fit"
                    };
                    return Err(Fault::at(path, what, "give another --out, or remove that file to begin anew"));
                }
            } else if line.ends_with(b"\n")
                && let Ok(scan) = serde_json::from_slice(&line)
            {
                store.kept.push_back(scan);
            } else {
                break;
            }
            whole += read as u64;
        }
        drop(reader);
        store.file.set_len(whole).map_err(|e| refused(&e))?;
        store.file.seek(SeekFrom::Start(whole)).map_err(|e| refused(&e))?;
        Ok(store)
    }

    /// Scans that it holds and that were not asked for yet.
    pub fn len(&self) -> usize {
        self.kept.len()
    }

    /// The kept scan of this number at these scores. Where the next one is another, the rest is of no use.
    pub fn take(&mut self, index: u64, scores: &[f64]) -> Option<Vec<Option<f64>>> {
        let next = self.kept.front()?;
        if next.index == index && next.scores == scores {
            return self.kept.pop_front().map(|scan| scan.statistics);
        }
        self.kept.clear();
        None
    }

    /// Removes the file, whose scans are of use to nobody. Where that is refused, the next fit says what to do.
    pub fn remove(&self) {
        let _ = std::fs::remove_file(&self.path);
    }

    /// Keeps scans.
    ///
    /// # Errors
    /// Where the disk refuses.
    pub fn keep(&mut self, scans: &[KeptScan]) -> Result<(), Fault> {
        let mut keep = |scan| line(scan).and_then(|line| self.file.write_all(&line));
        scans.iter().try_for_each(|scan| keep(scan).map_err(|e| unwritten(&self.path, &e)))
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

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn scan(index: u64) -> KeptScan {
        KeptScan { index, scores: vec![0.1 * index as f64, -1.0 / 3.0], statistics: vec![Some(1e-7), None] }
    }

    /// What was kept comes back bit for bit, also after a line was cut short; what is not asked for ends it; another
    /// fit is refused.
    #[test]
    fn kept_scans_come_back() {
        let folder = std::env::temp_dir().join(format!("fit-store-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        let path = folder.join("kept.jsonl");
        let _ = std::fs::remove_file(&path);
        let what = json!({ "seed": 1 });
        let mut store = ScanStore::open(&path, &what).expect("it is new");
        store.keep(&[scan(0), scan(1), scan(2)]).expect("there is room");
        let whole = std::fs::read(&path).expect("it is there");
        std::fs::write(&path, &whole[..whole.len() - 5]).expect("it can be cut");
        let mut store = ScanStore::open(&path, &what).expect("it goes on");
        assert_eq!(store.len(), 2);
        assert_eq!(store.take(0, &scan(0).scores), Some(scan(0).statistics));
        store.keep(&[scan(2)]).expect("there is room");
        let mut again = ScanStore::open(&path, &what).expect("it goes on");
        assert_eq!(again.len(), 3);
        assert_eq!(again.take(7, &scan(7).scores), None);
        assert_eq!(again.take(0, &scan(0).scores), None);
        let other = ScanStore::open(&path, &json!({ "seed": 2 })).expect_err("it is another");
        assert!(other.to_string().contains("another fit"), "{other}");
        std::fs::remove_dir_all(&folder).expect("it goes");
    }
}
