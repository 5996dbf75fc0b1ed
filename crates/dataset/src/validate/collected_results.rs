//! Collected results: what all jobs found, put together in any order and told in the order of jobs.

use super::frame_digest::FrameDigest;
use super::job_result::{CheckedRow, JobResult};
use super::report::{MAX_PRINTED_FINDINGS, ValidationReport};
use super::rules::{Code, Finding, duplicates, id_repeated, profile_differs};
use super::shard_task::ShardTask;
use crate::ClassCounts;
use optical_bench::split::Split;

/// What some jobs found.
#[derive(Default)]
pub(super) struct CollectedResults {
    counts: ValidationReport,
    /// Faults with the number of their job.
    faults: Vec<(u64, Vec<Finding>)>,
    /// Warnings with the number of their job.
    warnings: Vec<(u64, Vec<Finding>)>,
    /// Digest of the id, index and shard of every sample.
    ids: Vec<(u128, u64, u64)>,
    /// How many samples of each class and split the manifests name.
    pub(super) listed: ClassCounts,
    /// Paths of tables that manifests name.
    pub(super) tables: Vec<String>,
    /// Shards whose manifest can be read.
    pub(super) opened: Vec<u64>,
    /// Shards whose manifest is there and cannot be read.
    pub(super) hidden: Vec<u64>,
    /// Rows with the number of their job.
    rows: Vec<(u64, CheckedRow)>,
    /// Sensor frames on disk that are to be compared.
    frames: Vec<FrameDigest>,
}

impl CollectedResults {
    /// What job number `place` found.
    pub(super) fn of(place: u64, finding: JobResult) -> Self {
        let JobResult { mut report, ids, counts: listed, tables, opened, hidden, row, frames } = finding;
        let found = [&mut report.faults, &mut report.warnings].map(std::mem::take);
        let placed = |found: Vec<Finding>| if found.is_empty() { Vec::new() } else { vec![(place, found)] };
        let [faults, warnings] = found.map(placed);
        let rows = row.map(|row| (place, row)).into_iter().collect();
        let [opened, hidden] = [opened, hidden].map(|shard| shard.into_iter().collect());
        Self { counts: report, faults, warnings, ids, listed, tables, opened, hidden, rows, frames }
    }

    /// Both.
    pub(super) fn and(mut self, mut other: Self) -> Self {
        self.counts.add(other.counts);
        self.faults.append(&mut other.faults);
        self.warnings.append(&mut other.warnings);
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
        report.add(std::mem::take(&mut self.counts));
        self.faults.sort_by_key(|(place, _)| *place);
        report.faults.extend(runs(self.faults.drain(..).flat_map(|(_, faults)| faults)));
        id_repeated::check(&mut self.ids, report);
        self.warnings.sort_by_key(|(place, _)| *place);
        report.warnings.extend(self.warnings.drain(..).flat_map(|(_, warnings)| warnings));
    }

    /// The splits that manifests name.
    pub(super) fn present(&self) -> Vec<Split> {
        let named = |split: &&Split| self.listed.keys().any(|(_, name)| name == split.name());
        Split::ALL.iter().filter(named).copied().collect()
    }

    /// Samples that are there twice.
    pub(super) fn alike(&mut self) -> Vec<Finding> {
        self.rows.sort_by_key(|(place, _)| *place);
        let prints = self.rows.iter().filter_map(|(_, row)| Some((row, row.print.as_deref()?)));
        let samples =
            prints.map(|(row, print)| duplicates::PrintedSample { index: row.index, split: &row.split, print });
        duplicates::check(&samples.collect::<Vec<_>>())
    }

    /// Sensor frames that are not what they are when they are exposed again.
    pub(super) fn other_frames(&self, task: &ShardTask) -> Vec<Finding> {
        profile_differs::frames(
            task,
            self.rows.iter().flat_map(|(_, row)| &row.frames).copied().collect(),
            &self.frames,
        )
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
