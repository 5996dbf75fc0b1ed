//! What all jobs found, put together in any order and told in the order of jobs.

use super::report::{Code, Fault, Report};
use super::shard::Opening;
use output_schema::file::manifest_path;

/// What some jobs found.
#[derive(Default)]
pub(super) struct Found {
    counts: Report,
    /// Faults with the number of their job.
    faults: Vec<(u64, Vec<Fault>)>,
    /// Digest of the id, index and shard of every sample.
    ids: Vec<(u128, u64, u64)>,
    /// Paths of tables that manifests name.
    pub(super) tables: Vec<String>,
    /// Shards whose manifest can be read.
    pub(super) opened: Vec<u64>,
}

impl Found {
    /// What job number `place` found.
    pub(super) fn of(place: u64, opening: Opening) -> Self {
        let Opening { mut report, ids, tables, opened } = opening;
        let faults = std::mem::take(&mut report.faults);
        let faults = if faults.is_empty() { Vec::new() } else { vec![(place, faults)] };
        Self { counts: report, faults, ids, tables, opened: opened.into_iter().collect() }
    }

    /// Both.
    pub(super) fn and(mut self, mut other: Self) -> Self {
        self.counts.add(other.counts);
        self.faults.append(&mut other.faults);
        self.ids.append(&mut other.ids);
        self.tables.append(&mut other.tables);
        self.opened.append(&mut other.opened);
        self
    }

    /// Adds counts and faults to a report.
    pub(super) fn tell(&mut self, report: &mut Report) {
        report.add(std::mem::take(&mut self.counts));
        self.faults.sort_by_key(|(place, _)| *place);
        report.faults.extend(self.faults.drain(..).flat_map(|(_, faults)| faults));
        report.faults.extend(self.repeated());
    }

    /// Samples whose id another one has.
    fn repeated(&mut self) -> Vec<Fault> {
        self.ids.sort_unstable();
        let same = self.ids.windows(2).filter(|pair| pair[0].0 == pair[1].0);
        same.map(|pair| {
            let what = format!("samples {} and {} have the same id", pair[0].1, pair[1].1);
            Fault::new(Code::IdRepeated, manifest_path(pair[1].2), what)
        })
        .collect()
    }
}
