//! Jobs: the work on a dataset as a sequence of jobs, each small enough that one for every core fit in memory.
//!
//! Whoever takes the next job moves the reader on: it opens a shard, sums a table, or reads one row of it. The row is
//! then checked outside, beside others, whatever the number of shards. An EXR file is read once, with its row; a table
//! is summed just before its rows are read, so that the second reading comes from the system's cache.

use std::sync::Arc;

use arrow_array::RecordBatch;
use output_schema::file::{data_path, stack_path};
use parquet::arrow::arrow_reader::ParquetRecordBatchReader;

use super::job_result::{CheckedRow, JobResult};
use super::report::ValidationReport;
use super::rules::tables::{self, caught};
use super::rules::{Code, Finding, files, stack};
use super::sample;
use super::shard::{self, OpenShard};
use super::shard_task::ShardTask;
use crate::{check_lengths, largest};
use optical_bench::split::Split;

/// Jobs of one dataset or shard, in the order in which faults are told.
type ShardJobs<'a> = Box<dyn Iterator<Item = ValidationJob<'a>> + Send + 'a>;

/// One piece of work.
pub(super) enum ValidationJob<'a> {
    /// What a shard shows before its files are opened, or the reading of a table.
    Found(Box<JobResult>),
    /// A row of the table at a path, and the place of its sample in the manifest.
    CheckedRow(Arc<OpenShard<'a>>, Arc<str>, Option<usize>, RecordBatch),
    /// The EXR file of a sample, by its place in the manifest, that no row leads to.
    Exr(Arc<OpenShard<'a>>, usize),
    /// The sensor frames.
    Stack(Arc<OpenShard<'a>>),
}

/// Everything that is to be done for one shard.
pub(super) fn of(task: ShardTask<'_>) -> ShardJobs<'_> {
    let (found, shard) = shard::open(task);
    let opened = std::iter::once(ValidationJob::Found(Box::new(found)));
    let Some(shard) = shard.map(Arc::new) else { return Box::new(opened) };
    let stack = shard.file(&stack_path(task.number)).is_some().then(|| ValidationJob::Stack(shard.clone()));
    let splits = Split::ALL.into_iter().map(Some).chain([None]);
    Box::new(opened.chain(splits.flat_map(move |split| table(&shard, split))).chain(stack))
}

/// The rows of one split, and the EXR files of samples that have no row.
fn table<'a>(shard: &Arc<OpenShard<'a>>, split: Option<Split>) -> ShardJobs<'a> {
    let shard = shard.clone();
    let listed = shard.listed(split);
    let path = split.map(|split| data_path(split.name(), shard.task.number)).unwrap_or_default();
    let mut found = JobResult::default();
    let report = &mut found.report;
    let file = shard.file(&path).filter(|file| {
        let most = largest::table_bytes(shard.task.head);
        files::check(shard.task.root, file, most, report)
    });
    let reader = file.and_then(|_| {
        let opened = caught(&path, || tables::rows(&shard, &path));
        opened.map_err(|fault| report.faults.push(fault)).ok()
    });
    let told = std::iter::once(ValidationJob::Found(Box::new(found)));
    Box::new(told.chain(SampleTable { shard, path: path.into(), listed, count: 0, reader }))
}

/// Rows, one after the other, then what is left.
struct SampleTable<'a> {
    shard: Arc<OpenShard<'a>>,
    path: Arc<str>,
    /// Places in the manifest of the samples of this split.
    listed: Vec<usize>,
    /// Jobs that were given out.
    count: usize,
    /// `None` where nothing more can be read.
    reader: Option<ParquetRecordBatchReader>,
}

impl<'a> Iterator for SampleTable<'a> {
    type Item = ValidationJob<'a>;

    fn next(&mut self) -> Option<ValidationJob<'a>> {
        if let Some(reader) = &mut self.reader {
            let next = caught(&self.path, || {
                let unreadable = |what: String| Finding::new(Code::TableUnreadable, &*self.path, what);
                let batch = reader.next().transpose().map_err(|e| unreadable(e.to_string()))?;
                batch.map(|batch| check_lengths(&batch).map(|()| batch).map_err(unreadable)).transpose()
            });
            let fault = match next {
                Ok(Some(batch)) => {
                    self.count += 1;
                    let listed = self.listed.get(self.count - 1).copied();
                    return Some(ValidationJob::CheckedRow(self.shard.clone(), self.path.clone(), listed, batch));
                }
                Ok(None) => self.miscounted(),
                Err(fault) => Some(fault),
            };
            self.reader = None;
            let mut found = JobResult::default();
            found.report.faults.extend(fault);
            return Some(ValidationJob::Found(Box::new(found)));
        }
        self.count += 1;
        self.listed.get(self.count - 1).map(|&place| ValidationJob::Exr(self.shard.clone(), place))
    }
}

impl SampleTable<'_> {
    fn miscounted(&self) -> Option<Finding> {
        let (count, listed) = (self.count, self.listed.len());
        let rows = self.shard.file(&self.path).and_then(|file| file.rows);
        let what = format!("it has {count} rows, its manifest {listed} samples and {rows:?} rows");
        (count != listed || rows != Some(count as u64)).then(|| Finding::new(Code::RowCount, &*self.path, what))
    }
}

impl ValidationJob<'_> {
    /// What is found when it is done.
    pub(super) fn run(self) -> JobResult {
        let mut found = JobResult::default();
        let report = &mut found.report;
        match self {
            ValidationJob::Found(found) => return *found,
            ValidationJob::CheckedRow(shard, path, listed, batch) => {
                found.rows.extend(row(&shard, &path, listed, &batch, report));
            }
            ValidationJob::Exr(shard, place) => {
                shard.exr(&shard.manifest.samples[place], report);
            }
            ValidationJob::Stack(shard) => {
                let ShardTask { root, head, number, .. } = shard.task;
                let path = stack_path(number);
                let most = largest::stack_bytes(head);
                if let Some(file) = shard.file(&path).filter(|file| files::check(root, file, most, report)) {
                    let read = caught(&path, || Ok(stack::check(&shard.task, &shard.manifest, file, report)));
                    match read {
                        Ok(asked) => found.frames = asked,
                        Err(fault) => report.faults.push(fault),
                    }
                }
            }
        }
        found
    }
}

fn row(
    shard: &OpenShard,
    path: &str,
    listed: Option<usize>,
    batch: &RecordBatch,
    report: &mut ValidationReport,
) -> Option<CheckedRow> {
    let file = shard.file(path)?;
    let listed = listed.map(|place| &shard.manifest.samples[place]);
    let exr = listed.and_then(|listed| shard.exr(listed, report));
    let seen = caught(path, || Ok(sample::check(&shard.task, batch, file, listed, exr.as_deref(), report)));
    seen.map_err(|fault| report.faults.push(fault)).ok()?
}
