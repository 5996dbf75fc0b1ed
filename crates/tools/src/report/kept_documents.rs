//! Kept results: documents that other commands keep beside a dataset, under `reports/`: documents of `gen validate
//! --save` and `gen check --save`, and the pictures that these name.

use std::path::Path;

use serde_json::Value;

use dataset::{DatasetSums, enclosed};

/// Folder of kept results in a dataset's folder.
pub(super) const FOLDER: &str = "reports";
/// Most bytes of a document; a larger one is left out.
const MAX_DOCUMENT_BYTES: u64 = 64 << 20;
/// Most bytes of a picture that a document names; a larger one is left out.
const MAX_PICTURE_BYTES: u64 = 2 << 20;
/// How PNG files begin.
const PNG_SIGNATURE: &[u8] = b"\x89PNG\r\n\x1a\n";

/// What a document of a kind says at least: its `format`, and fields that are what they should be.
pub(super) struct DocumentKind {
    format: &'static str,
    fields: &'static [RequiredField],
}

/// A key that a document must have, what its value should be in words, and whether it is.
type RequiredField = (&'static str, &'static str, fn(&Value) -> bool);

/// Of `gen validate --save`.
pub(super) const VALIDATION: DocumentKind = DocumentKind {
    format: "sheetlight-validation",
    fields: &[("clean", "true or false", Value::is_boolean), ("faults", "a list", Value::is_array)],
};
/// Of `gen check --save`.
const CHECK: DocumentKind = DocumentKind {
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

impl DocumentKind {
    /// What is wrong with a document that should be of this kind.
    fn fault(&self, document: &Value) -> Option<String> {
        if document["format"] != self.format {
            return Some(format!("its `format` is not \"{}\"", self.format));
        }
        let wrong = self.fields.iter().find(|(key, _, is_right)| !is_right(&document[*key]));
        wrong.map(|(key, wanted, _)| format!("its `{key}` is missing or not {wanted}"))
    }
}

/// A document.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct KeptDocument {
    /// Name of the file.
    pub name: String,
    /// What it says; why it cannot be read otherwise.
    pub document: Result<Value, String>,
    /// Whether it was made from the present state of the dataset; `None` where it does not say.
    pub is_current: Option<bool>,
}

/// The document of that name; `None` where there is none.
pub(super) fn kept(root: &Path, name: &str, kind: &DocumentKind, sums: &DatasetSums) -> Option<KeptDocument> {
    let path = format!("{FOLDER}/{name}");
    enclosed::length(root, &path).ok()?;
    let read = || {
        let text = enclosed::read(root, &path, MAX_DOCUMENT_BYTES).map_err(|e| e.to_string())?;
        let value: Value = serde_json::from_slice(&text).map_err(|e| e.to_string())?;
        kind.fault(&value).map_or(Ok(value), Err)
    };
    let document = read();
    let is_current = document.as_ref().ok().and_then(|document| {
        let same = |key: &str, now: &str| document[key].as_str().map(|then| then == now);
        Some(same("dataset_sha256", &sums.dataset)? && same("manifests_sha256", &sums.manifests)?)
    });
    Some(KeptDocument { name: name.into(), document, is_current })
}

/// The documents of checks, by name.
pub(super) fn checks(root: &Path, sums: &DatasetSums) -> Vec<KeptDocument> {
    let mut names = enclosed::names(root, FOLDER).unwrap_or_default();
    names.retain(|name| name.starts_with("check-") && name.ends_with(".json"));
    names.iter().filter_map(|name| kept(root, name, &CHECK, sums)).collect()
}

/// A picture beside the documents; `None` where the name leads elsewhere or to no PNG.
pub(super) fn picture(root: &Path, name: &str) -> Option<Vec<u8>> {
    let plain = name.ends_with(".png") && !name.contains(['/', '\\']) && !name.starts_with('.');
    let read = || enclosed::read(root, &format!("{FOLDER}/{name}"), MAX_PICTURE_BYTES).ok();
    plain.then(read)?.filter(|bytes| bytes.starts_with(PNG_SIGNATURE))
}
