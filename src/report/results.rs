//! Results that other commands keep beside a dataset, under `reports/`: documents of `gen validate --save` and
//! `gen check --save`, and the pictures that these name.

use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::dataset::DatasetSums;

/// Folder of kept results in a dataset's folder.
pub(super) const FOLDER: &str = "reports";
/// Most bytes of a document, and of a picture that it names; larger ones are left out.
const MOST: (u64, u64) = (64 << 20, 2 << 20);
/// How PNG files begin.
const PNG: &[u8] = b"\x89PNG\r\n\x1a\n";

/// What a document of a kind says at least: its `format`, and fields that are what they should be.
pub(super) struct Kind {
    format: &'static str,
    fields: &'static [Field],
}

/// A key, what it should be in words, and whether it is.
type Field = (&'static str, &'static str, fn(&Value) -> bool);

/// Of `gen validate --save`.
pub(super) const VALIDATION: Kind = Kind {
    format: "sheetlight-validation",
    fields: &[("clean", "true or false", Value::is_boolean), ("faults", "a list", Value::is_array)],
};
/// Of `gen check --save`.
const CHECK: Kind = Kind {
    format: "sheetlight-check",
    fields: &[
        ("model", "an object", Value::is_object),
        ("task", "a text", Value::is_string),
        ("split", "a text", Value::is_string),
        ("accuracy", "an object", Value::is_object),
        ("classes", "a list", Value::is_array),
        ("confusion", "a list", Value::is_array),
        ("calibration", "an object", Value::is_object),
    ],
};

impl Kind {
    /// What is wrong with a document that should be of this kind.
    fn fault(&self, document: &Value) -> Option<String> {
        if document["format"] != self.format {
            return Some(format!("its `format` is not \"{}\"", self.format));
        }
        let wrong = self.fields.iter().find(|(key, _, is_right)| !is_right(&document[*key]));
        wrong.map(|(key, what, _)| format!("its `{key}` is missing or not {what}"))
    }
}

/// A document.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Kept {
    /// Name of the file.
    pub name: String,
    /// What it says; why it cannot be read otherwise.
    pub document: Result<Value, String>,
    /// Whether it was made from the dataset as it is now; `None` where it does not say.
    pub is_current: Option<bool>,
}

/// The document of that name; `None` where there is none.
pub(super) fn kept(root: &Path, name: &str, kind: &Kind, sums: &DatasetSums) -> Option<Kept> {
    let path = root.join(FOLDER).join(name);
    let length = fs::metadata(&path).ok().filter(|file| file.is_file())?.len();
    let read = || {
        if length > MOST.0 {
            return Err(format!("it has {length} bytes, more than any document of this kind"));
        }
        let text = fs::read(&path).map_err(|e| e.to_string())?;
        let value: Value = serde_json::from_slice(&text).map_err(|e| e.to_string())?;
        kind.fault(&value).map_or(Ok(value), Err)
    };
    let document = read();
    let is_current = document.as_ref().ok().and_then(|document| {
        let same = |key: &str, now: &str| document[key].as_str().map(|then| then == now);
        Some(same("dataset_sha256", &sums.dataset)? && same("manifests_sha256", &sums.manifests)?)
    });
    Some(Kept { name: name.into(), document, is_current })
}

/// The documents of checks, by name.
pub(super) fn checks(root: &Path, sums: &DatasetSums) -> Vec<Kept> {
    let entries = fs::read_dir(root.join(FOLDER)).into_iter().flatten().flatten();
    let mut names: Vec<String> = entries.filter_map(|entry| entry.file_name().into_string().ok()).collect();
    names.retain(|name| name.starts_with("check-") && name.ends_with(".json"));
    names.sort_unstable();
    names.iter().filter_map(|name| kept(root, name, &CHECK, sums)).collect()
}

/// A picture beside the documents; `None` where the name leads elsewhere or to no PNG.
pub(super) fn picture(root: &Path, name: &str) -> Option<Vec<u8>> {
    let plain = name.ends_with(".png") && !name.contains(['/', '\\']) && !name.starts_with('.');
    let path = plain.then(|| root.join(FOLDER).join(name))?;
    let small = fs::metadata(&path).is_ok_and(|file| file.is_file() && file.len() <= MOST.1);
    small.then(|| fs::read(&path).ok())?.filter(|bytes| bytes.starts_with(PNG))
}
