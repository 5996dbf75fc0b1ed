//! The manifest of a shard, read once: there, readable, of this dataset, and written as the program writes it. The
//! rules of reading it are one file.

use std::collections::HashSet;
use std::io::ErrorKind;

use output_schema::file::manifest_path;
use output_schema::{FORMAT, Manifest, ManifestFile, SCHEMA_VERSION, refuse_version};
use serde::Deserialize;

use super::{Code, REMAKE, Rule, ValidationReport, files};
use crate::validate::expected;
use crate::validate::job_result::JobResult;
use crate::validate::shard_task::ShardTask;
use crate::{enclosed, largest, one_line, to_document};

pub(super) const MISSING: Rule = Rule {
    meaning: "A shard has no manifest: it is not finished.",
    remedy: "run the command that began the dataset to continue it",
};
pub(super) const UNREADABLE: Rule = Rule { meaning: "A manifest is no document of this format.", remedy: REMAKE };
pub(super) const DIFFERS: Rule = Rule {
    meaning: "A manifest belongs to another dataset, or counts other samples or files than it should.",
    remedy: REMAKE,
};
/// Letters of a path that a message shows.
const MAX_SHOWN: usize = 200;

/// The manifest of a shard and its text.
pub(in crate::validate) fn read(task: &ShardTask, found: &mut JobResult) -> Option<(Vec<u8>, Manifest)> {
    let place = manifest_path(task.number);
    let text = match enclosed::read(task.root, &place, largest::manifest_bytes(task.head)) {
        Ok(text) => text,
        Err(e) => {
            found.hidden.extend((e.kind() != ErrorKind::NotFound).then_some(task.number));
            let otherwise = if found.hidden.is_empty() { Code::ManifestMissing } else { Code::ManifestUnreadable };
            found.report.fault(files::unread(&e, otherwise), place, format!("shard {}: {e}", task.number));
            return None;
        }
    };
    match serde_json::from_slice(&text) {
        Ok(manifest) => Some((text, manifest)),
        Err(e) => {
            found.hidden.push(task.number);
            // A newer document may have other keys.
            let newer = newer(&text);
            let code = if newer.is_some() { Code::VersionUnknown } else { Code::ManifestUnreadable };
            found.report.fault(code, place, newer.unwrap_or_else(|| e.to_string()));
            None
        }
    }
}

/// Checks a manifest, whose shard has the `expected` files.
pub(in crate::validate) fn check(
    task: &ShardTask,
    (text, manifest): (&[u8], &Manifest),
    expected: &HashSet<String>,
    report: &mut ValidationReport,
) {
    let place = manifest_path(task.number);
    if let Some(reason) = refuse_version(&manifest.format, manifest.schema_version) {
        let code = if manifest.format == FORMAT { Code::VersionUnknown } else { Code::ManifestDiffers };
        return report.fault(code, place, reason);
    }
    let mut reasons = manifest_reasons(task, manifest, expected);
    if task.head.schema_version == SCHEMA_VERSION && to_document(manifest) != text {
        reasons.push("it is not written as the program writes it: keys, order, blanks".into());
    }
    reasons.into_iter().for_each(|what| report.fault(Code::ManifestDiffers, &place, what));
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
