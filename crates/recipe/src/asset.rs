//! Assets, the files that a recipe names, read once and known by their content.
//!
//! A setting of the type `File` names such a file, or by its form a folder of pictures that becomes one tar
//! (`slice_tar.rs`). What it must hold is asked where the recipe is read, so that faults name line and key. Its hash,
//! its copy in the dataset, `gen validate` and `gen --recipe FOLDER` follow by themselves.

use std::sync::Arc;

use sha2::{Digest, Sha256};

/// Longest name that a copy keeps [bytes].
const MAX_NAME_BYTES: usize = 64;

/// The content of a file, and what it is called; clones share the content.
#[derive(Clone, PartialEq, Eq)]
pub struct Asset {
    name: String,
    sha256: String,
    bytes: Arc<[u8]>,
}

impl std::fmt::Debug for Asset {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(f, "Asset({}, {} bytes, {})", self.name, self.bytes.len(), self.sha256)
    }
}

impl Asset {
    /// The file `name`, of which the last part counts.
    pub fn new(name: &str, bytes: Vec<u8>) -> Self {
        Self { name: file_name(name).to_owned(), sha256: hex(&Sha256::digest(&bytes)), bytes: bytes.into() }
    }

    /// Its name without folders.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// SHA-256 of its content, hexadecimal.
    pub fn sha256(&self) -> &str {
        &self.sha256
    }

    /// Its content.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Its name as the copy in a dataset has it: of letters, digits, `.`, `-` and `_`.
    pub fn plain_name(&self) -> String {
        let plain = |c: char| if c.is_ascii_alphanumeric() || matches!(c, '.' | '-' | '_') { c } else { '_' };
        let plain: String = self.name.chars().map(plain).collect();
        plain[plain.len().saturating_sub(MAX_NAME_BYTES)..].to_owned()
    }
}

/// A file that is built in: its name and its content.
pub(crate) type BuiltIn = (&'static str, &'static [u8]);

/// What is wrong with a file that a recipe names.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct AssetFault {
    /// What is wrong.
    pub problem: String,
    /// What to do.
    pub remedy: String,
}

impl AssetFault {
    /// The fault `problem`, which `remedy` mends.
    pub fn new(problem: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { problem: problem.into(), remedy: remedy.into() }
    }

    /// What an error says of the file `name`: what is wrong stands before its first semicolon, what to do behind it, or
    /// is `otherwise`.
    pub(crate) fn told(name: &str, error: &impl std::fmt::Display, otherwise: &str) -> Self {
        let words = error.to_string();
        let (problem, remedy) = words.split_once("; ").unwrap_or((&words, otherwise));
        Self::new(format!("`{name}`: {problem}"), remedy)
    }
}

/// Bytes in hexadecimal.
pub(crate) fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The last part of a path.
pub(crate) fn file_name(name: &str) -> &str {
    name.rsplit(['/', '\\']).next().filter(|last| !last.is_empty()).unwrap_or("file")
}

/// A text short enough for a message, without control characters.
pub(crate) fn printable(text: &str) -> String {
    text.chars().take(200).map(|c| if c.is_control() { ' ' } else { c }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A copy's name leads nowhere else and keeps the ending by which a reader knows the kind of file.
    #[test]
    fn plain_names_stay_in_their_folder() {
        let plain = |name: &str| Asset::new(name, Vec::new()).plain_name();
        assert_eq!(plain("../parts/hook v2.obj"), "hook_v2.obj");
        assert_eq!(plain("c:\\parts\\naïve.stl"), "na_ve.stl");
        assert_eq!(plain(".."), "..");
        assert_eq!(plain("a/"), "file");
        let long = format!("{}.ply", "x".repeat(300));
        assert!(plain(&long).len() == 64 && plain(&long).ends_with(".ply"));
    }
}
