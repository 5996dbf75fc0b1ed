//! Validation report: what was found, and how much was looked at.

use std::fmt;

use serde::Serialize;
use serde_json::{Value, json};

use super::balance::BalanceStatistics;
use super::finding::{Code, Finding};

/// Everything that validation found, and how much it looked at.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct ValidationReport {
    /// Broken rules, in the order of shards.
    pub faults: Vec<Finding>,
    /// Shards that have a manifest.
    pub shards: u64,
    /// Files whose checksum was computed.
    pub files: u64,
    /// Size of those files [bytes].
    pub bytes: u64,
    /// Rows that were read.
    pub samples: u64,
    /// Images that were decoded, EXR channels included.
    pub images: u64,
    /// Samples that were rendered again.
    pub rerendered: u64,
    /// Indices of the samples that were chosen for that.
    pub chosen: Vec<u64>,
    /// Classes, splits and drawn numbers against the recipe; null where there is none to compare with.
    pub statistics: Option<BalanceStatistics>,
}

/// Faults of one code that [`ValidationReport`] prints in full.
pub(super) const MAX_PRINTED_FINDINGS: usize = 8;

impl ValidationReport {
    /// Whether no rule is broken.
    pub fn is_clean(&self) -> bool {
        self.faults.is_empty()
    }

    /// Everything as JSON, with the number of faults of each code.
    pub fn json(&self) -> Value {
        let mut counts = serde_json::Map::new();
        for code in self.codes() {
            counts.insert(code.name(), self.faults.iter().filter(|f| f.code == code).count().into());
        }
        // Plain data always becomes JSON.
        let mut value = serde_json::to_value(self).unwrap_or_default();
        value["clean"] = json!(self.is_clean());
        value["fault_counts"] = Value::Object(counts);
        value
    }

    /// The codes of the faults, each once, in order.
    pub fn codes(&self) -> Vec<Code> {
        let mut codes: Vec<Code> = self.faults.iter().map(|fault| fault.code).collect();
        codes.sort_unstable();
        codes.dedup();
        codes
    }

    pub(super) fn add(&mut self, other: Self) {
        self.faults.extend(other.faults);
        self.shards += other.shards;
        self.files += other.files;
        self.bytes += other.bytes;
        self.samples += other.samples;
        self.images += other.images;
        self.rerendered += other.rerendered;
    }
}

impl fmt::Display for ValidationReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut kinds: Vec<(Code, &str)> = Vec::new();
        for code in self.codes() {
            for finding in self.faults.iter().filter(|finding| finding.code == code) {
                if !kinds.contains(&(code, &*finding.fault.remedy)) {
                    kinds.push((code, &finding.fault.remedy));
                }
            }
        }
        for (code, remedy) in kinds {
            let faults: Vec<&Finding> =
                self.faults.iter().filter(|finding| (finding.code, &*finding.fault.remedy) == (code, remedy)).collect();
            writeln!(f, "{} ({}): {remedy}", code.name(), faults.len())?;
            for finding in faults.iter().take(MAX_PRINTED_FINDINGS) {
                writeln!(f, "  {}: {}", finding.fault.place, finding.fault.what)?;
            }
            if faults.len() > MAX_PRINTED_FINDINGS {
                writeln!(f, "  ... and {} more", faults.len() - MAX_PRINTED_FINDINGS)?;
            }
        }
        let megabytes = self.bytes as f64 / 1e6;
        write!(
            f,
            "checked {} shards, {} files ({megabytes:.1} MB), {} samples, {} images; {} rendered again; {} faults",
            self.shards,
            self.files,
            self.samples,
            self.images,
            self.rerendered,
            self.faults.len()
        )
    }
}
