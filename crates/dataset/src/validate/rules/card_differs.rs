//! Card: the dataset card and `croissant.json` against `dataset.json`: they may have more lines, and another licence;
//! what the program wrote stays.

use std::fs;
use std::path::Path;

use output_schema::DatasetHead;
use output_schema::file::{CROISSANT, DATASET};

use super::files::unread;
use super::{Code, Finding, Rule, ValidationReport};
use crate::{ClassCounts, descriptions, enclosed, largest};
use optical_bench::split::Split;

pub(super) const RULE: Rule = Rule {
    meaning: "The dataset card or `croissant.json` lacks a line that the program wrote.",
    remedy: REWRITE_REMEDY,
};
/// First words of the lines that belong to whoever publishes the dataset.
const OWNERS_LINES: [&str; 2] = ["license: ", "  \"license\": "];
/// What to do about a document that is missing or changed.
const REWRITE_REMEDY: &str = "remove the file and run the command that made the dataset again: it writes it anew";

/// What to do about one that was written before all shards were there, as parts have it that were put together.
const FINISH_REMEDY: &str = "run the command that made the dataset once more, without --part: it finishes the file";

/// Checks the documents of a dataset whose samples are of these splits, so many of each class and split where manifests
/// can be believed; one that is not finished names all splits.
pub(in crate::validate) fn check(
    folder: &Path,
    head: &DatasetHead,
    present: &[Split],
    counts: Option<&ClassCounts>,
    finished: bool,
    report: &mut ValidationReport,
) {
    // Its absence was told before.
    let document = enclosed::read(folder, DATASET, largest::DOCUMENT_BYTES).unwrap_or_default();
    let none = ClassCounts::new();
    // Of parts that were put together nobody has written the counts; nothing in them is wrong where every split has
    // files.
    let unfinished = descriptions(head, &Split::ALL, &none, &document);
    let has_all = present.len() == Split::ALL.len();
    let is_open = counts.is_none();
    let counts = counts.unwrap_or(&none);
    for ((name, text), (_, other)) in descriptions(head, present, counts, &document).into_iter().zip(unfinished) {
        let mut fault = |code, what: String| {
            report.faults.push(Finding::new(code, name, what).with_remedy(REWRITE_REMEDY));
        };
        let path = folder.join(name);
        if name == CROISSANT && head.schema_version[1] < 3 && !path.exists() {
            continue;
        }
        if !fs::symlink_metadata(&path).is_ok_and(|found| found.is_file()) {
            fault(Code::FileMissing, "the document is missing, or no plain file".into());
            continue;
        }
        match enclosed::read(folder, name, largest::DOCUMENT_BYTES) {
            Err(e) => {
                let code = unread(&e, Code::FileMissing);
                let remedy = if code == Code::FileUnreadable { code.remedy() } else { REWRITE_REMEDY };
                let what = format!("the document cannot be read: {e}");
                report.faults.push(Finding::new(code, name, what).with_remedy(remedy));
            }
            Ok(found) => {
                let is_unfinished = || (has_all || !finished) && missing_line(&found, &other, !finished).is_none();
                if let Some((number, line)) = missing_line(&found, &text, is_open).filter(|_| !is_unfinished()) {
                    let what = format!("line {number} as the program writes it is missing or changed: `{line}`");
                    fault(Code::CardDiffers, what);
                    let is_early = finished && missing_line(&found, &other, false).is_none();
                    if let Some(fault) = report.faults.last_mut().filter(|_| is_early) {
                        fault.fault.remedy = FINISH_REMEDY.into();
                    }
                }
            }
        }
    }
}

/// The first line of `expected` that `found` does not have in its place among the others; rows of counts may be filled
/// where it `is_open`.
fn missing_line(found: &[u8], expected: &[u8], is_open: bool) -> Option<(usize, String)> {
    let mut lines = found.split(|&byte| byte == b'\n');
    let own = |line: &[u8], other: &[u8]| {
        OWNERS_LINES.iter().any(|words| line.starts_with(words.as_bytes()) && other.starts_with(words.as_bytes()))
    };
    // A row of classes whose cells are open.
    let filled = |line: &[u8], other: &[u8]| {
        if !is_open {
            return false;
        }
        let rest = line.strip_suffix(b"|  |  |  |").and_then(|start| other.strip_prefix(start));
        rest.is_some_and(|rest| rest.iter().all(|byte| byte.is_ascii_digit() || b" |".contains(byte)))
    };
    let mut expected = (1..).zip(expected.split(|&byte| byte == b'\n'));
    let missing =
        expected.find(|(_, line)| !lines.any(|found| found == *line || own(line, found) || filled(line, found)));
    missing.map(|(number, line)| (number, String::from_utf8_lossy(line).into_owned()))
}
