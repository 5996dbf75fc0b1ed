//! Simulated scans that are kept on disk while a fit runs, so that a killed one goes on where it was. A scan is taken
//! from the file only where its number and its scores are those that the fit asks for.

use std::path::Path;

use dataset::Fault;
use dataset::kept_lines::{KeptKind, KeptLines};
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// What kept scans are of.
const KIND: KeptKind = KeptKind {
    kind: "sheetlight fit",
    key: "fit",
    refusals: [
        "it keeps the scans of another fit (recipe, keys, seed or real scans differ)",
        "it keeps no scans of a fit",
    ],
};

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
    lines: KeptLines,
    kept: std::collections::VecDeque<KeptScan>,
}

impl ScanStore {
    /// Opens the file of a fit that `what` describes, or begins it.
    ///
    /// # Errors
    /// As [`KeptLines::open`].
    pub fn open(path: &Path, what: &Value) -> Result<Self, Fault> {
        let (lines, kept) = KeptLines::open(path, &KIND, what)?;
        Ok(Self { lines, kept: kept.into() })
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
        let _ = std::fs::remove_file(self.lines.path());
    }

    /// Keeps scans.
    ///
    /// # Errors
    /// Where the disk refuses.
    pub fn keep(&mut self, scans: &[KeptScan]) -> Result<(), Fault> {
        self.lines.keep(scans)
    }
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
