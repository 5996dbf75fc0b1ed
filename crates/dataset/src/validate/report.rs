//! Validation report: what was found, and how much was looked at.

use std::fmt;

use serde::Serialize;
use serde_json::{Value, json};

use super::rules::{Code, Finding, LOOK};

/// Everything that validation found, and how much it looked at.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct ValidationReport {
    /// Broken rules, in the order of shards.
    pub faults: Vec<Finding>,
    /// Samples of little use though no rule is broken, and estimates that say what to look at where nothing exact can
    /// be compared; in the order of shards.
    pub warnings: Vec<Finding>,
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
    /// Rows that were exposed again, of all samples together.
    pub rows: u64,
    /// Sensor frames that were exposed again.
    pub frames: u64,
    /// Samples of which nothing was exposed or rendered again.
    pub unexposed: u64,
    /// The seed that chose rows and frames; null where none were to be exposed.
    pub rows_seed: Option<u64>,
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
        let counts = |found: &[Finding]| {
            let count = |code: Code| found.iter().filter(|finding| finding.code == code).count();
            Value::Object(codes(found).into_iter().map(|code| (code.name(), count(code).into())).collect())
        };
        // Plain data always becomes JSON.
        let mut value = serde_json::to_value(self).unwrap_or_default();
        value["clean"] = json!(self.is_clean());
        value["fault_counts"] = counts(&self.faults);
        value["warning_counts"] = counts(&self.warnings);
        value
    }

    /// The codes of the faults, each once, in order.
    pub fn codes(&self) -> Vec<Code> {
        codes(&self.faults)
    }

    /// A fault where samples are compared exactly with what their recipe makes, and else a warning that says *look at
    /// this*.
    pub(super) fn tell(&mut self, is_exact: bool, code: Code, place: impl Into<String>, what: impl Into<String>) {
        let finding = Finding::new(code, place, what);
        if is_exact { self.faults.push(finding) } else { self.warnings.push(finding.with_remedy(LOOK)) }
    }

    /// Adds a fault.
    pub(super) fn fault(&mut self, code: Code, place: impl Into<String>, what: impl Into<String>) {
        self.faults.push(Finding::new(code, place, what));
    }

    /// Adds a warning.
    pub(super) fn warn(&mut self, code: Code, place: impl Into<String>, what: impl Into<String>) {
        self.warnings.push(Finding::new(code, place, what));
    }

    pub(super) fn add(&mut self, other: Self) {
        self.faults.extend(other.faults);
        self.warnings.extend(other.warnings);
        self.shards += other.shards;
        self.files += other.files;
        self.bytes += other.bytes;
        self.samples += other.samples;
        self.images += other.images;
        self.rerendered += other.rerendered;
        self.rows += other.rows;
        self.frames += other.frames;
        self.unexposed += other.unexposed;
    }
}

/// The codes of some findings, each once, in order.
fn codes(found: &[Finding]) -> Vec<Code> {
    let mut codes: Vec<Code> = found.iter().map(|finding| finding.code).collect();
    codes.sort_unstable();
    codes.dedup();
    codes
}

/// Prints findings by code and remedy, the first of each in full.
fn print(f: &mut fmt::Formatter<'_>, head: &str, found: &[Finding]) -> fmt::Result {
    let mut kinds: Vec<(Code, &str)> = Vec::new();
    for code in codes(found) {
        for finding in found.iter().filter(|finding| finding.code == code) {
            if !kinds.contains(&(code, &*finding.fault.remedy)) {
                kinds.push((code, &finding.fault.remedy));
            }
        }
    }
    for (code, remedy) in kinds {
        let own: Vec<&Finding> =
            found.iter().filter(|finding| (finding.code, &*finding.fault.remedy) == (code, remedy)).collect();
        writeln!(f, "{head}{} ({}): {remedy}", code.name(), own.len())?;
        for finding in own.iter().take(MAX_PRINTED_FINDINGS) {
            writeln!(f, "  {}: {}", finding.fault.place, finding.fault.what)?;
        }
        if own.len() > MAX_PRINTED_FINDINGS {
            writeln!(f, "  ... and {} more", own.len() - MAX_PRINTED_FINDINGS)?;
        }
    }
    Ok(())
}

impl fmt::Display for ValidationReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        print(f, "", &self.faults)?;
        print(f, "warning: ", &self.warnings)?;
        let megabytes = self.bytes as f64 / 1e6;
        let exposed = self.rows_seed.map_or(String::new(), |seed| {
            let frames = if self.frames > 0 { format!(" and {} sensor frames", self.frames) } else { String::new() };
            let none = if self.unexposed > 0 { format!(", of {} samples none", self.unexposed) } else { String::new() };
            format!(" {} rows{frames} exposed again (--rows-seed {seed}){none};", self.rows)
        });
        write!(
            f,
            "checked {} shards, {} files ({megabytes:.1} MB), {} samples, {} images; {} rendered \
                again;{exposed} {} faults, {} warnings",
            self.shards,
            self.files,
            self.samples,
            self.images,
            self.rerendered,
            self.faults.len(),
            self.warnings.len()
        )
    }
}
