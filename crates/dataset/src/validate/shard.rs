//! Shard: its manifest, and which files it should have.

use std::collections::{HashMap, HashSet};
use std::io::ErrorKind;

use output_schema::file::{data_path, exr_folder, exr_path, manifest_path, stack_path};
use output_schema::{FORMAT, Manifest, ManifestFile, ManifestSample, SCHEMA_VERSION, refuse_version};
use serde::Deserialize;
use sha2::{Digest, Sha256};

use super::duplicates::NoisePrint;
use super::finding::{Code, Finding};
use super::frame_digest::FrameDigest;
use super::report::ValidationReport;
use super::shard_task::ShardTask;
use super::{expected, files};
use crate::{ClassCounts, enclosed, largest, one_line, to_document};
use bench::split::Split;

/// Letters of a path that a message shows.
const MAX_SHOWN: usize = 200;

/// One shard whose manifest can be read.
pub(super) struct OpenShard<'a> {
    pub(super) task: ShardTask<'a>,
    pub(super) manifest: Manifest,
    /// Places in the manifest of the files that such a shard can have, by path.
    known: HashMap<String, usize>,
}

/// What one job found.
#[derive(Default)]
pub(super) struct JobResult {
    pub(super) report: ValidationReport,
    /// Digest of the id, index and shard of every sample that the manifest names.
    pub(super) ids: Vec<(u128, u64, u64)>,
    /// How many samples of each class and split the manifest names.
    pub(super) counts: ClassCounts,
    /// Paths of its tables, as the manifest names them.
    pub(super) tables: Vec<String>,
    /// Its number, where there is a manifest that can be read.
    pub(super) opened: Option<u64>,
    /// Its number, where there is a manifest that cannot be read: nobody knows which files are its own.
    pub(super) hidden: Option<u64>,
    /// The row that it read.
    pub(super) row: Option<CheckedRow>,
    /// The sensor frames that it read and that are to be compared.
    pub(super) frames: Vec<FrameDigest>,
}

/// What stays of a row to be compared with others.
pub(super) struct CheckedRow {
    pub(super) index: u64,
    pub(super) split: String,
    /// `None` where rows of it are exposed again, which tell copies exactly.
    pub(super) print: Option<Box<NoisePrint>>,
    /// Its sensor frames that were exposed again, in any order.
    pub(super) frames: Vec<FrameDigest>,
}

/// Reads the manifest and lists the files; `None` where there is no manifest that can be read.
pub(super) fn open<'a>(task: ShardTask<'a>) -> (JobResult, Option<OpenShard<'a>>) {
    let mut found = JobResult::default();
    let place = manifest_path(task.number);
    let text = match enclosed::read(task.root, &place, largest::manifest_bytes(task.head)) {
        Ok(text) => text,
        Err(e) => {
            found.hidden = (e.kind() != ErrorKind::NotFound).then_some(task.number);
            let otherwise = if found.hidden.is_none() { Code::ManifestMissing } else { Code::ManifestUnreadable };
            let code = files::unread(&e, otherwise);
            found.report.faults.push(Finding::new(code, place, format!("shard {}: {e}", task.number)));
            return (found, None);
        }
    };
    let manifest: Manifest = match serde_json::from_slice(&text) {
        Ok(manifest) => manifest,
        Err(e) => {
            found.hidden = Some(task.number);
            // A newer document may have other keys.
            let newer = newer(&text);
            let code = if newer.is_some() { Code::VersionUnknown } else { Code::ManifestUnreadable };
            found.report.faults.push(Finding::new(code, place, newer.unwrap_or_else(|| e.to_string())));
            return (found, None);
        }
    };
    found.report.shards = 1;
    found.opened = Some(task.number);
    let id = |sample: &ManifestSample| (digest(&sample.id), sample.index, task.number);
    found.ids = manifest.samples.iter().map(id).collect();
    for sample in &manifest.samples {
        *found.counts.entry((sample.class.clone(), sample.split.clone())).or_default() += 1;
    }
    let expected: HashSet<String> = expected_paths(&task, &manifest).into_iter().collect();
    if let Some(reason) = refuse_version(&manifest.format, manifest.schema_version) {
        let code = if manifest.format == FORMAT { Code::VersionUnknown } else { Code::ManifestDiffers };
        found.report.faults.push(Finding::new(code, &place, reason));
    } else {
        let mut reasons = manifest_reasons(&task, &manifest, &expected);
        if task.head.schema_version == SCHEMA_VERSION && to_document(&manifest) != text {
            reasons.push("it is not written as the program writes it: keys, order, blanks".into());
        }
        found.report.faults.extend(reasons.into_iter().map(|what| Finding::new(Code::ManifestDiffers, &place, what)));
    }

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

/// Why a document that cannot be read as a manifest is one of another version, where it is.
fn newer(text: &[u8]) -> Option<String> {
    /// All that is kept of it: content that was made to mislead takes no room.
    #[derive(Deserialize)]
    struct Said {
        format: String,
        schema_version: [u32; 2],
    }
    let said: Said = serde_json::from_slice(text).ok()?;
    refuse_version(FORMAT, said.schema_version).filter(|_| said.format == FORMAT)
}

/// Everything in which a manifest is not that of its shard.
fn manifest_reasons(task: &ShardTask, manifest: &Manifest, expected: &HashSet<String>) -> Vec<String> {
    let head = task.head;
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
    let shown = |path: &str| one_line(path.chars().take(MAX_SHOWN).collect());
    reasons.extend(odd.map(|file| format!("it gives {} the rows {:?}", shown(&file.path), file.rows)));
    let found: HashSet<&str> = manifest.files.iter().map(|file| file.path.as_str()).collect();
    let mut missing: Vec<&String> = expected.iter().filter(|path| !found.contains(path.as_str())).collect();
    missing.sort_unstable();
    reasons.extend(missing.iter().map(|path| format!("it does not name {}", shown(path))));
    let foreign = manifest.files.iter().filter(|file| !expected.contains(&file.path));
    reasons.extend(foreign.map(|file| format!("it names {}, which is no file of this shard", shown(&file.path))));
    reasons
}

fn expected_paths(task: &ShardTask, manifest: &Manifest) -> Vec<String> {
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
