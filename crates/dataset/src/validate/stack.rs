//! Sensor frames: every kept profile of every sample, in order.

use output_schema::{Manifest, ManifestFile};

use super::frame_digest::FrameDigest;
use super::report::ValidationReport;
use super::rules::{Code, stack_blank, stack_differs, stack_repeated};
use super::shard_task::ShardTask;
use super::stored_frames;

/// Checks the sensor frames of a shard: every so-many-th of the profiles of each sample, as the recipe says; those that
/// are to be compared with what is exposed again.
pub(super) fn check(
    task: &ShardTask,
    manifest: &Manifest,
    file: &ManifestFile,
    report: &mut ValidationReport,
) -> Vec<FrameDigest> {
    let (rows, asked) = match stored_frames::read(task, &file.path) {
        Ok(read) => read,
        Err((code, what)) => {
            report.fault(code, &file.path, what);
            return Vec::new();
        }
    };
    let most = task.head.images.most_dn();
    for row in rows.iter().filter(|row| row.most > most) {
        report.fault(Code::ValueRange, &file.path, format!("{} has {} DN, beyond {most}", row.name(), row.most));
    }
    stack_repeated::check(&rows, &file.path, report);
    if file.rows != Some(rows.len() as u64) {
        let what = format!("it has {} rows, its manifest says {:?}", rows.len(), file.rows);
        report.fault(Code::RowCount, &file.path, what);
    }
    stack_differs::check(&rows, task.head, manifest, &file.path, report);
    stack_blank::check(&rows, task, &file.path, report);
    asked
}
