//! `dataset.json`, read once: there, of a version that this program knows, consistent in itself, written as the program
//! writes it. The rules of reading it are one file.

use std::path::Path;

use output_schema::file::DATASET;
use output_schema::{DatasetHead, FORMAT, SCHEMA_VERSION, SUBJECTS, label_values, pixel_classes, refuse_version};
use serde_json::Value;

use super::files::unread;
use super::{Code, Rule, ValidationReport};
use crate::{enclosed, largest, to_document};

pub(super) const MISSING: Rule =
    Rule { meaning: "`dataset.json` is not there.", remedy: "name the folder that holds dataset.json" };
pub(super) const UNREADABLE: Rule = Rule {
    meaning: "`dataset.json` is no document of this format.",
    remedy: "bring dataset.json back from a copy, or make the dataset again",
};
pub(super) const VERSION_UNKNOWN: Rule = Rule {
    meaning: "The dataset was written with a schema that this program does not read.",
    remedy: "use the program version that the message names",
};
pub(super) const VERSION_DIFFERS: Rule = Rule {
    meaning: "The dataset was written with another minor version of the schema: much of it cannot be compared.",
    remedy: "validate with the program version that wrote the dataset; it stays readable",
};

/// Reads the head; `None` where nothing else can be checked.
pub(in crate::validate) fn read(folder: &Path, report: &mut ValidationReport) -> Option<DatasetHead> {
    let mut fault = |code, what: String| {
        report.fault(code, DATASET, what);
        None
    };
    let text = match enclosed::read(folder, DATASET, largest::DOCUMENT_BYTES) {
        Ok(text) => text,
        Err(e) => return fault(unread(&e, Code::DatasetMissing), format!("cannot be read: {e}")),
    };
    let value: Value = match serde_json::from_slice(&text) {
        Ok(value) => value,
        Err(e) => return fault(Code::DatasetUnreadable, e.to_string()),
    };
    let format = value["format"].as_str().unwrap_or("").to_string();
    // The version first: a newer document may have other keys.
    let version = serde_json::from_value(value["schema_version"].clone()).unwrap_or([0, 0]);
    if let Some(reason) = refuse_version(&format, version) {
        let code = if format == FORMAT { Code::VersionUnknown } else { Code::DatasetUnreadable };
        return fault(code, reason);
    }
    let head: DatasetHead = match serde_json::from_value(value) {
        Ok(head) => head,
        Err(e) => return fault(Code::DatasetUnreadable, e.to_string()),
    };
    if let Some(what) = inconsistent(&head) {
        return fault(Code::DatasetUnreadable, what);
    }
    if head.schema_version != SCHEMA_VERSION {
        let [[major, minor], [_, own]] = [head.schema_version, SCHEMA_VERSION];
        let what = format!(
            "it was written with schema {major}.{minor}, this program writes {major}.{own}: comparisons with \
                the recipe, the \
             documents' bytes and the tables' metadata are left out"
        );
        fault(Code::VersionDiffers, what);
    } else if to_document(&head) != text {
        fault(Code::DatasetDiffers, "it is not written as the program writes it: keys, order, blanks".into());
    }
    Some(head)
}

/// In what a head contradicts itself.
fn inconsistent(head: &DatasetHead) -> Option<String> {
    let refused = head.refuse();
    if refused.is_some() {
        return refused;
    }
    let subject = head.subject.as_str();
    if !SUBJECTS.contains(&subject) {
        return Some(format!("its subject is `{subject}`"));
    }
    // Later minor versions may have added classes; values keep their meaning in all.
    let told = (&head.pixel_classes, &head.label_values);
    let known = |minor: u32| told == (&pixel_classes(subject, minor), &label_values(subject, minor));
    let [own, minor] = [SCHEMA_VERSION[1], head.schema_version[1]];
    (minor <= own && !(0..=own).any(known))
        .then(|| format!("its pixel classes are {:?}, its labels {:?}", head.pixel_classes, head.label_values))
}
