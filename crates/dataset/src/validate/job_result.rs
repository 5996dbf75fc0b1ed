//! What jobs of validation found: one, or many put together in any order and told in the order of jobs.

use super::frame_digest::FrameDigest;
use super::report::{MAX_PRINTED_FINDINGS, ValidationReport};
use super::rules::duplicates::{self, NoisePrint};
use super::rules::{Code, Finding, id_repeated, profile_differs};
use super::shard_task::ShardTask;
use crate::ClassCounts;
use optical_bench::split::Split;

/// What some jobs found.
#[derive(Default)]
pub(super) struct JobResult {
    /// Counts, and the faults and warnings of a job that has no place yet.
    pub(super) report: ValidationReport,
    /// Faults and warnings with the number of their job.
    told: Vec<(u64, [Vec<Finding>; 2])>,
    /// Digest of the id, index and shard of every sample that a manifest names.
    pub(super) ids: Vec<(u128, u64, u64)>,
    /// How many samples of each class and split the manifests name.
    pub(super) listed: ClassCounts,
    /// Paths of tables that manifests name.
    pub(super) tables: Vec<String>,
    /// Shards whose manifest can be read.
    pub(super) opened: Vec<u64>,
    /// Shards whose manifest is there and cannot be read: nobody knows which files are their own.
    pub(super) hidden: Vec<u64>,
    /// Rows that were read.
    pub(super) rows: Vec<CheckedRow>,
    /// Sensor frames on disk that are to be compared.
    pub(super) frames: Vec<FrameDigest>,
}

/// What stays of a row to be compared with others.
pub(super) struct CheckedRow {
    /// The number of its job.
    pub(super) place: u64,
    pub(super) index: u64,
    pub(super) split: String,
    /// `None` where rows of it are exposed again, which tell copies exactly.
    pub(super) print: Option<Box<NoisePrint>>,
    /// Its sensor frames that were exposed again, in any order.
    pub(super) frames: Vec<FrameDigest>,
}

impl JobResult {
    /// The same of job number `place`.
    pub(super) fn at(mut self, place: u64) -> Self {
        let told = [&mut self.report.faults, &mut self.report.warnings].map(std::mem::take);
        if told.iter().any(|found| !found.is_empty()) {
            self.told.push((place, told));
        }
        self.rows.iter_mut().for_each(|row| row.place = place);
        self
    }

    /// Both.
    pub(super) fn and(mut self, mut other: Self) -> Self {
        self.report.add(other.report);
        self.told.append(&mut other.told);
        self.ids.append(&mut other.ids);
        other.listed.into_iter().for_each(|(kind, count)| *self.listed.entry(kind).or_default() += count);
        self.tables.append(&mut other.tables);
        self.opened.append(&mut other.opened);
        self.hidden.append(&mut other.hidden);
        self.rows.append(&mut other.rows);
        self.frames.append(&mut other.frames);
        self
    }

    /// Adds counts and faults to a report.
    pub(super) fn tell(&mut self, report: &mut ValidationReport) {
        report.add(std::mem::take(&mut self.report));
        self.told.sort_by_key(|(place, _)| *place);
        let told = self.told.drain(..).map(|(_, [faults, warnings])| (faults, warnings));
        let (faults, warnings): (Vec<_>, Vec<_>) = told.unzip();
        report.faults.extend(runs(faults.into_iter().flatten()));
        id_repeated::check(&mut self.ids, report);
        report.warnings.extend(warnings.into_iter().flatten());
    }

    /// The splits that manifests name.
    pub(super) fn present(&self) -> Vec<Split> {
        let named = |split: &&Split| self.listed.keys().any(|(_, name)| name == split.name());
        Split::ALL.iter().filter(named).copied().collect()
    }

    /// Samples that are there twice.
    pub(super) fn alike(&mut self) -> Vec<Finding> {
        self.rows.sort_by_key(|row| row.place);
        let prints = self.rows.iter().filter_map(|row| Some((row, row.print.as_deref()?)));
        let samples =
            prints.map(|(row, print)| duplicates::PrintedSample { index: row.index, split: &row.split, print });
        duplicates::check(&samples.collect::<Vec<_>>())
    }

    /// Sensor frames that are not what they are when they are exposed again.
    pub(super) fn other_frames(&self, task: &ShardTask) -> Vec<Finding> {
        let made = self.rows.iter().flat_map(|row| &row.frames).copied().collect();
        profile_differs::frames(task, made, &self.frames)
    }
}

/// Faults as they are, but many missing manifests in a row as one.
fn runs(faults: impl Iterator<Item = Finding>) -> Vec<Finding> {
    let mut told: Vec<Finding> = Vec::new();
    let mut missing: Vec<Finding> = Vec::new();
    let end = |missing: &mut Vec<Finding>, told: &mut Vec<Finding>| match missing.as_slice() {
        [first, .., last] if missing.len() > MAX_PRINTED_FINDINGS => {
            let place = format!("{} to {}", first.fault.place, last.fault.place);
            let what = format!("{} shards in a row have no manifest", missing.len());
            told.push(Finding::new(Code::ManifestMissing, place, what));
            missing.clear();
        }
        _ => told.append(missing),
    };
    for fault in faults {
        if fault.code == Code::ManifestMissing {
            missing.push(fault);
        } else {
            end(&mut missing, &mut told);
            told.push(fault);
        }
    }
    end(&mut missing, &mut told);
    told
}
