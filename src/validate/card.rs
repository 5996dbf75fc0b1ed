//! The dataset card against `dataset.json`: it may have more lines, and another licence; what the program wrote stays.

use std::fs;
use std::path::Path;

use output_schema::DatasetHead;
use output_schema::file::CARD;

use super::report::{Code, Fault, Report};
use crate::record::Split;
use crate::shard::card;

/// Checks the card of a dataset whose samples are of these splits; one that is not finished names all splits.
pub(super) fn check(folder: &Path, head: &DatasetHead, present: &[Split], finished: bool, report: &mut Report) {
    let mut fault = |code, what: String| report.faults.push(Fault::new(code, CARD, what));
    let path = folder.join(CARD);
    if !fs::symlink_metadata(&path).is_ok_and(|found| found.is_file()) {
        return fault(Code::FileMissing, "the dataset card is missing, or no plain file".into());
    }
    let found = match fs::read(&path) {
        Ok(bytes) => bytes,
        Err(e) => return fault(Code::FileMissing, format!("the dataset card cannot be read: {e}")),
    };
    let found = String::from_utf8_lossy(&found);
    let differs = |present: &[Split]| missing_line(&found, &card(head, present));
    let missing = differs(present).filter(|_| finished || differs(&Split::ALL).is_some());
    if let Some((number, line)) = missing {
        fault(
            Code::CardDiffers,
            format!("line {number} of the card as the program writes it is missing or changed: `{line}`"),
        );
    }
}

/// The first line of `expected` that `found` does not have in its place among the others.
fn missing_line(found: &str, expected: &str) -> Option<(usize, String)> {
    let mut lines = found.split('\n');
    let own = |line: &str| line.starts_with("license: ");
    let mut expected = (1..).zip(expected.split('\n'));
    let missing = expected.find(|(_, line)| !lines.any(|found| found == *line || (own(line) && own(found))));
    missing.map(|(number, line)| (number, line.to_owned()))
}
