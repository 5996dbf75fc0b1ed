//! One shard: manifest, files, rows.

use std::collections::HashSet;
use std::fs::{self, File};
use std::io::ErrorKind;
use std::panic::{AssertUnwindSafe, catch_unwind};

use output_schema::arrow::row_schema;
use output_schema::file::{data_path, exr_path, manifest_path, stack_path};
use output_schema::{Manifest, ManifestFile, ManifestSample, refuse_version};
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;

use super::report::{Code, Fault, Report};
use super::sample::Seen;
use super::task::Task;
use super::{expected, files, sample, stack};
use crate::record::Split;
use crate::shard::document;

/// What was found in one shard.
#[derive(Default)]
pub(super) struct Part {
    pub(super) report: Report,
    /// Paths that the manifest names.
    pub(super) files: Vec<String>,
    /// Index and id of every sample that the manifest names.
    pub(super) ids: Vec<(u64, String)>,
    /// What later checks need of every row.
    pub(super) seen: Vec<Seen>,
}

pub(super) fn check(task: &Task) -> Part {
    let mut part = Part::default();
    let place = manifest_path(task.number);
    let text = match fs::read(task.root.join(&place)) {
        Ok(text) => text,
        Err(e) => {
            let code = if e.kind() == ErrorKind::NotFound { Code::ManifestMissing } else { Code::ManifestUnreadable };
            part.report.faults.push(Fault::new(code, place, format!("shard {}: {e}", task.number)));
            return part;
        }
    };
    let manifest: Manifest = match serde_json::from_slice(&text) {
        Ok(manifest) => manifest,
        Err(e) => {
            part.report.faults.push(Fault::new(Code::ManifestUnreadable, place, e.to_string()));
            return part;
        }
    };
    part.report.shards = 1;
    part.ids = manifest.samples.iter().map(|sample| (sample.index, sample.id.clone())).collect();
    let expected: HashSet<String> = expected_paths(task, &manifest).into_iter().collect();
    let mut reasons = manifest_reasons(task, &manifest, &expected);
    if document(&manifest) != text {
        reasons.push("it is not written as the program writes it: keys, order, blanks".into());
    }
    part.report.faults.extend(reasons.into_iter().map(|what| Fault::new(Code::ManifestDiffers, &place, what)));

    // Only names that a shard can have are opened: a manifest may not point out of the folder.
    let known: Vec<&ManifestFile> = manifest.files.iter().filter(|file| expected.contains(&file.path)).collect();
    part.files = known.iter().map(|file| file.path.clone()).collect();
    let whole: HashSet<&str> =
        known.iter().filter(|file| files::check(task.root, file, &mut part.report)).map(|f| f.path.as_str()).collect();
    for file in known.iter().filter(|file| file.path.ends_with(".parquet") && whole.contains(file.path.as_str())) {
        // Readers of other crates may panic on content that was made to mislead; that is a fault of the file.
        let report = &mut part.report;
        let read = catch_unwind(AssertUnwindSafe(|| {
            if file.path == stack_path(task.number) {
                stack::check(task.root, task.head, &manifest, file, report);
            } else {
                rows(task, &manifest, file, &|path| whole.contains(path), &mut part.seen, report);
            }
        }));
        if read.is_err() {
            let what = "a reader gave up on its content";
            part.report.faults.push(Fault::new(Code::TableUnreadable, &file.path, what));
        }
    }
    part
}

/// Everything in which a manifest is not that of its shard.
fn manifest_reasons(task: &Task, manifest: &Manifest, expected: &HashSet<String>) -> Vec<String> {
    let head = task.head;
    if let Some(reason) = refuse_version(&manifest.format, manifest.schema_version) {
        return vec![reason];
    }
    let mut reasons = Vec::new();
    let mut differ = |name: &str, found: String, expected: String| {
        if found != expected {
            reasons.push(format!("{name} is {found}, not {expected}"));
        }
    };
    let (first, count) = head.span(task.number);
    differ("schema version", format!("{:?}", manifest.schema_version), format!("{:?}", head.schema_version));
    differ("generator", format!("{:?}", manifest.generator), format!("{:?}", head.generator));
    differ("recipe hash", manifest.recipe_hash.clone(), head.recipe.hash.clone());
    differ("seed", manifest.seed.to_string(), head.seed.to_string());
    differ("shard", manifest.shard.to_string(), task.number.to_string());
    differ("first index", manifest.first.to_string(), first.to_string());
    differ("count", manifest.count.to_string(), count.to_string());
    differ("number of samples", manifest.samples.len().to_string(), count.to_string());
    let order = manifest.samples.iter().zip(first..).find(|(sample, index)| sample.index != *index);
    if let Some((sample, index)) = order {
        differ("index of a sample", sample.index.to_string(), index.to_string());
    }
    if let Some(expect) = task.expect {
        // An index of another shard is told above.
        let own = manifest.samples.iter().filter(|sample| (first..first + count).contains(&sample.index));
        reasons.extend(own.filter_map(|sample| expected::listed(sample, &expect(sample.index))));
    }
    if !manifest.files.is_sorted_by(|a, b| a.path < b.path) {
        reasons.push("its files are not in order, or there twice".into());
    }
    let counted = |file: &&ManifestFile| file.rows.is_some() != file.path.ends_with(".parquet");
    let odd = manifest.files.iter().filter(counted);
    reasons.extend(odd.map(|file| format!("it gives {} the rows {:?}", file.path, file.rows)));
    let found: HashSet<&str> = manifest.files.iter().map(|file| file.path.as_str()).collect();
    let mut missing: Vec<&String> = expected.iter().filter(|path| !found.contains(path.as_str())).collect();
    missing.sort_unstable();
    reasons.extend(missing.iter().map(|path| format!("it does not name {path}")));
    let foreign = manifest.files.iter().filter(|file| !expected.contains(&file.path));
    reasons.extend(foreign.map(|file| format!("it names {}, which is no file of this shard", file.path)));
    reasons
}

fn expected_paths(task: &Task, manifest: &Manifest) -> Vec<String> {
    let has = |split: &Split| manifest.samples.iter().any(|sample| sample.split == split.name());
    let splits = Split::ALL.iter().filter(|split| has(split));
    let mut paths: Vec<String> = splits.map(|split| data_path(split.name(), task.number)).collect();
    if task.head.images.stack_every.is_some() {
        paths.push(stack_path(task.number));
    }
    if !task.head.images.exr.is_empty() {
        // An id with a slash could lead out of the folder.
        let samples = manifest.samples.iter().filter(|sample| !sample.id.contains('/'));
        paths.extend(samples.map(|sample| exr_path(task.number, &sample.id)));
    }
    paths
}

/// The rows of one split.
fn rows(
    task: &Task,
    manifest: &Manifest,
    file: &ManifestFile,
    whole: &dyn Fn(&str) -> bool,
    seen: &mut Vec<Seen>,
    report: &mut Report,
) {
    let split = Split::ALL.into_iter().find(|split| file.path == data_path(split.name(), task.number));
    let listed: Vec<&ManifestSample> =
        manifest.samples.iter().filter(|sample| split.is_some_and(|split| sample.split == split.name())).collect();
    let unreadable = |e: String| Fault::new(Code::TableUnreadable, &file.path, e);
    let opened = File::open(task.root.join(&file.path)).map_err(|e| e.to_string());
    let builder = opened.and_then(|file| ParquetRecordBatchReaderBuilder::try_new(file).map_err(|e| e.to_string()));
    let builder = match builder {
        Ok(builder) => builder,
        Err(e) => return report.faults.push(unreadable(e)),
    };
    let (found, expected) = (builder.schema().clone(), row_schema(task.head));
    if *found != expected {
        let fields =
            expected.fields().iter().filter(|field| found.field_with_name(field.name()).ok() != Some(field.as_ref()));
        let names: Vec<&str> = fields.map(|field| field.name().as_str()).collect();
        let what = format!("its columns are not those that are declared: {names:?}, their order, or the metadata");
        return report.faults.push(Fault::new(Code::SchemaDiffers, &file.path, what));
    }
    let reader = match builder.with_batch_size(1).build() {
        Ok(reader) => reader,
        Err(e) => return report.faults.push(unreadable(e.to_string())),
    };
    let mut count = 0;
    for batch in reader {
        match batch {
            Ok(batch) => seen.extend(sample::check(task, &batch, file, listed.get(count).copied(), whole, report)),
            Err(e) => return report.faults.push(unreadable(e.to_string())),
        }
        count += 1;
    }
    if count != listed.len() || file.rows != Some(count as u64) {
        let what = format!("it has {count} rows, its manifest {} samples and {:?} rows", listed.len(), file.rows);
        report.faults.push(Fault::new(Code::RowCount, &file.path, what));
    }
}
