//! Files against manifests: there, whole, unchanged, and no others.

use std::collections::HashSet;
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;

use output_schema::file::{DATASET, REPORTS};
use output_schema::{AssetHead, DatasetHead, ManifestFile};
use sha2::{Digest, Sha256};

use super::report::{Code, Fault, Report};
use crate::shard::hex;

/// Checks one file of a manifest; `true` where it is whole.
pub(super) fn check(root: &Path, file: &ManifestFile, report: &mut Report) -> bool {
    let path = root.join(&file.path);
    let found = match fs::symlink_metadata(&path) {
        Ok(found) if found.is_file() => found.len(),
        Ok(_) => return fail(report, Code::FileMissing, file, "is no plain file"),
        Err(e) => return fail(report, Code::FileMissing, file, &e.to_string()),
    };
    if found != file.bytes {
        return fail(report, Code::FileSize, file, &format!("has {found} bytes, not {}", file.bytes));
    }
    match sum(&path) {
        Err(e) => fail(report, Code::FileMissing, file, &format!("cannot be read: {e}")),
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

fn fail(report: &mut Report, code: Code, file: &ManifestFile, what: &str) -> bool {
    report.faults.push(Fault::new(code, &file.path, what));
    false
}

fn sum(path: &Path) -> io::Result<String> {
    let mut file = File::open(path)?;
    let mut sum = Sha256::new();
    let mut part = vec![0; 1 << 20];
    loop {
        let read = file.read(&mut part)?;
        if read == 0 {
            return Ok(hex(&sum.finalize()));
        }
        sum.update(&part[..read]);
    }
}

/// Checks the copies of files that the recipe names; their paths.
pub(super) fn assets(root: &Path, head: &DatasetHead, report: &mut Report) -> Vec<String> {
    let mut paths = Vec::new();
    for asset in &head.assets {
        let place = asset.key.split('.').fold(&head.recipe.canonical, |value, key| &value[key]);
        if !asset.is_in_folder() || place["sha256"].as_str() != Some(&asset.sha256) {
            let what = format!("its asset `{}` is none of its recipe", asset.path);
            report.faults.push(Fault::new(Code::DatasetUnreadable, DATASET, what));
            continue;
        }
        let AssetHead { path, bytes, sha256, .. } = asset.clone();
        let before = report.faults.len();
        check(root, &ManifestFile { path: path.clone(), bytes, sha256, rows: None }, report);
        for fault in &mut report.faults[before..] {
            fault.remedy = "run the command that began the dataset: it writes the file again";
        }
        paths.push(path);
    }
    paths
}

/// Every file below `root` that is not expected; results that are kept in `reports` may be there.
pub(super) fn unexpected(root: &Path, expected: &[String]) -> Vec<Fault> {
    let expected: HashSet<&str> = expected.iter().map(String::as_str).collect();
    let mut faults = Vec::new();
    let mut folders = vec![String::new()];
    while let Some(folder) = folders.pop() {
        let entries = match fs::read_dir(root.join(&folder)) {
            Ok(entries) => entries,
            Err(e) => {
                faults.push(Fault::new(Code::FileUnexpected, folder, format!("cannot be listed: {e}")));
                continue;
            }
        };
        for entry in entries.flatten() {
            let name = entry.file_name().to_string_lossy().into_owned();
            let path = if folder.is_empty() { name } else { format!("{folder}/{name}") };
            if entry.file_type().is_ok_and(|kind| kind.is_dir()) {
                if path != REPORTS {
                    folders.push(path);
                }
            } else if !expected.contains(path.as_str()) {
                faults.push(Fault::new(Code::FileUnexpected, path, "no manifest names it"));
            }
        }
    }
    faults.sort_by(|a, b| a.place.cmp(&b.place));
    faults
}
