//! Shard: its manifest, and which files it should have.

use std::collections::{HashMap, HashSet};

use output_schema::file::{data_path, exr_folder, exr_path, stack_path};
use output_schema::{Manifest, ManifestFile, ManifestSample};
use sha2::{Digest, Sha256};

use super::job_result::JobResult;
use super::report::ValidationReport;
use super::rules::{files, manifests};
use super::shard_task::ShardTask;
use crate::largest;
use optical_bench::split::Split;

/// One shard whose manifest can be read.
pub(super) struct OpenShard<'a> {
    pub(super) task: ShardTask<'a>,
    pub(super) manifest: Manifest,
    /// Places in the manifest of the files that such a shard can have, by path.
    known: HashMap<String, usize>,
}

/// Reads the manifest and lists the files; `None` where there is no manifest that can be read.
pub(super) fn open<'a>(task: ShardTask<'a>) -> (JobResult, Option<OpenShard<'a>>) {
    let mut found = JobResult::default();
    let Some((text, manifest)) = manifests::read(&task, &mut found) else { return (found, None) };
    found.report.shards = 1;
    found.opened.push(task.number);
    let id = |sample: &ManifestSample| (digest(&sample.id), sample.index, task.number);
    found.ids = manifest.samples.iter().map(id).collect();
    for sample in &manifest.samples {
        *found.listed.entry((sample.class.clone(), sample.split.clone())).or_default() += 1;
    }
    let expected: HashSet<String> = expected_paths(&task, &manifest).into_iter().collect();
    manifests::check(&task, (&text, &manifest), &expected, &mut found.report);

    // Only names that a shard can have are opened: a manifest may not point out of the folder.
    let own = manifest.files.iter().enumerate().filter(|(_, file)| expected.contains(&file.path));
    let known: HashMap<String, usize> = own.map(|(place, file)| (file.path.clone(), place)).collect();
    found.tables = known.keys().filter(|path| path.ends_with(".parquet")).cloned().collect();
    let folder = exr_folder(task.number);
    let strangers = files::unexpected(task.root, &folder, &|path| known.contains_key(path), &|_| false);
    found.report.faults.extend(strangers);
    (found, Some(OpenShard { task, manifest, known }))
}

impl OpenShard<'_> {
    /// What the manifest says of a file; `None` where it names none of that path.
    pub(super) fn file(&self, path: &str) -> Option<&ManifestFile> {
        self.known.get(path).map(|&place| &self.manifest.files[place])
    }

    /// The samples that it lists for a split, as places in the manifest; those of no known split for `None`.
    pub(super) fn listed(&self, split: Option<Split>) -> Vec<usize> {
        let of = |sample: &ManifestSample| Split::ALL.into_iter().find(|split| split.name() == sample.split);
        let samples = self.manifest.samples.iter().enumerate();
        samples.filter(|(_, sample)| of(sample) == split).map(|(place, _)| place).collect()
    }

    /// Bytes of the EXR file of a sample, where there is one that is whole.
    pub(super) fn exr(&self, sample: &ManifestSample, report: &mut ValidationReport) -> Option<Vec<u8>> {
        let file = self.file(&exr_path(self.task.number, &sample.id))?;
        files::read(self.task.root, file, largest::exr_bytes(self.task.head), report)
    }
}

/// The first half of the SHA-256 of an id: two ids with the same one are the same.
fn digest(id: &str) -> u128 {
    let sum = Sha256::digest(id);
    sum.iter().take(16).fold(0, |word, byte| word << 8 | u128::from(*byte))
}

fn expected_paths(task: &ShardTask, manifest: &Manifest) -> Vec<String> {
    let has = |split: &Split| manifest.samples.iter().any(|sample| sample.split == split.name());
    let splits = Split::ALL.iter().filter(|split| has(split));
    let mut paths: Vec<String> = splits.map(|split| data_path(split.name(), task.number)).collect();
    if task.head.images.stack_every.is_some() {
        paths.push(stack_path(task.number));
    }
    if task.head.has_exr() {
        // An id with a slash could lead out of the folder.
        let samples = manifest.samples.iter().filter(|sample| !sample.id.contains('/'));
        paths.extend(samples.map(|sample| exr_path(task.number, &sample.id)));
    }
    paths
}
