//! Files against manifests: there, whole, unchanged, and no others. A file is opened, measured and summed in one pass,
//! so its rules are one file.

use std::fs::File;
use std::io::{self, ErrorKind, Read};
use std::path::Path;

use output_schema::file::DATASET;
use output_schema::{AssetHead, DatasetHead, ManifestFile};
use sha2::{Digest, Sha256};

use super::{Code, Finding, REMAKE, Rule, ValidationReport};
use crate::{enclosed, hex, largest, own_remedy};

pub(super) const MISSING: Rule = Rule { meaning: "A file of the manifest is not there.", remedy: REMAKE };
pub(super) const UNREADABLE: Rule = Rule {
    meaning: "A file or folder is there, but may not be read.",
    remedy: "let it be read by whom `gen` runs for; nothing is known to be wrong with it",
};
pub(super) const SIZE: Rule = Rule { meaning: "A file has another size than its manifest says.", remedy: REMAKE };
pub(super) const CHECKSUM: Rule =
    Rule { meaning: "A file has another SHA-256 than its manifest says.", remedy: REMAKE };
pub(super) const UNEXPECTED: Rule = Rule {
    meaning: "A file that no manifest names.",
    remedy: "remove the file, or continue the dataset if it is being written",
};

/// Reads one file of a manifest, once; its bytes, where it is whole and of at most `most` bytes.
pub(in crate::validate) fn read(
    root: &Path,
    file: &ManifestFile,
    most: u64,
    report: &mut ValidationReport,
) -> Option<Vec<u8>> {
    let mut bytes = Vec::new();
    let whole = whole(root, file, most, report, |part| bytes.extend_from_slice(part));
    whole.then_some(bytes)
}

/// Checks one file of a manifest; `true` where it is whole and of at most `most` bytes.
pub(in crate::validate) fn check(root: &Path, file: &ManifestFile, most: u64, report: &mut ValidationReport) -> bool {
    whole(root, file, most, report, |_| ())
}

/// Hands the bytes on as they are read and summed.
fn whole(root: &Path, file: &ManifestFile, most: u64, report: &mut ValidationReport, take: impl FnMut(&[u8])) -> bool {
    let length = |open: &File| open.metadata().map(|found| found.len());
    let opened = enclosed::open(root, &file.path, most).and_then(|open| Ok((length(&open)?, open)));
    let (found, open) = match opened {
        Ok(opened) => opened,
        Err(e) if e.kind() == ErrorKind::FileTooLarge => return fail(report, Code::FileSize, file, &e.to_string()),
        Err(e) => return fail(report, unread(&e, Code::FileMissing), file, &e.to_string()),
    };
    if found != file.bytes {
        return fail(report, Code::FileSize, file, &format!("has {found} bytes, not {}", file.bytes));
    }
    match sum(open.take(found), take) {
        Err(e) => fail(report, unread(&e, Code::FileMissing), file, &format!("cannot be read: {e}")),
        Ok(sum) if sum != file.sha256 => {
            fail(report, Code::FileChecksum, file, &format!("has SHA-256 {sum}, not {}", file.sha256))
        }
        Ok(_) => {
            report.files += 1;
            report.bytes += found;
            true
        }
    }
}

/// The code of a file that could not be read: `otherwise`, unless it is there and may not be, or the system is at
/// fault.
pub(in crate::validate) fn unread(e: &io::Error, otherwise: Code) -> Code {
    let is_there = e.kind() == ErrorKind::PermissionDenied || own_remedy(e).is_some();
    if is_there { Code::FileUnreadable } else { otherwise }
}

fn fail(report: &mut ValidationReport, code: Code, file: &ManifestFile, what: &str) -> bool {
    report.fault(code, &file.path, what);
    false
}

fn sum(mut file: impl Read, mut take: impl FnMut(&[u8])) -> io::Result<String> {
    let mut sum = Sha256::new();
    // Small enough to be summed and copied while it is in the processor's cache.
    let mut part = vec![0; 1 << 16];
    loop {
        let read = file.read(&mut part)?;
        if read == 0 {
            return Ok(hex(&sum.finalize()));
        }
        sum.update(&part[..read]);
        take(&part[..read]);
    }
}

/// Checks the copies of files that the recipe names; their paths.
pub(in crate::validate) fn assets(root: &Path, head: &DatasetHead, report: &mut ValidationReport) -> Vec<String> {
    let mut paths = Vec::new();
    for asset in &head.assets {
        let place = asset.key.split('.').fold(&head.recipe.canonical, |value, key| &value[key]);
        if !asset.is_in_folder() || place["sha256"].as_str() != Some(&asset.sha256) {
            let what = format!("its asset `{}` is none of its recipe", asset.path);
            report.fault(Code::DatasetUnreadable, DATASET, what);
            continue;
        }
        let AssetHead { path, bytes, sha256, .. } = asset.clone();
        let before = report.faults.len();
        check(root, &ManifestFile { path: path.clone(), bytes, sha256, rows: None }, largest::ASSET_BYTES, report);
        for fault in &mut report.faults[before..] {
            fault.fault.remedy = "run the command that began the dataset: it writes the file again".into();
        }
        paths.push(path);
    }
    paths
}

/// Every file below `folder` of `root` that is not expected; folders that are skipped are not listed.
pub(in crate::validate) fn unexpected(
    root: &Path,
    folder: &str,
    is_expected: &dyn Fn(&str) -> bool,
    is_skipped: &dyn Fn(&str) -> bool,
) -> Vec<Finding> {
    let mut faults = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        let entries = match enclosed::entries(root, &folder) {
            Ok(entries) => entries,
            // A folder of files that are missing: each of them is told.
            Err(e) if e.kind() == ErrorKind::NotFound => continue,
            Err(e) => {
                faults.push(Finding::new(unread(&e, Code::FileUnexpected), folder, format!("cannot be listed: {e}")));
                continue;
            }
        };
        for (name, is_folder) in entries {
            let path = if folder.is_empty() { name } else { format!("{folder}/{name}") };
            if is_folder {
                if !is_skipped(&path) {
                    folders.push(path);
                }
            } else if !is_expected(&path) {
                faults.push(Finding::new(Code::FileUnexpected, path, "no manifest names it"));
            }
        }
    }
    faults.sort_by(|a, b| a.fault.place.cmp(&b.fault.place));
    faults
}
