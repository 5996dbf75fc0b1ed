//! Where the files are that a recipe names.
//!
//! A name is relative to the recipe's own file; a file that exists wins over one that is built in. A folder of pictures
//! is one file too, where a key allows it (`slice_tar`). A dataset keeps a copy of each, so that its samples
//! can be made again from the folder alone.

use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

use crate::asset::{Asset, AssetFault, BuiltIn, file_name, printable};
use crate::slice_tar;

/// Where the files are that a recipe names.
#[derive(Debug, Clone, PartialEq)]
pub enum AssetSource {
    /// Only built in: the recipe comes from no file.
    BuiltIn,
    /// In this folder, that of the recipe's file, or else built in.
    Beside(PathBuf),
    /// Copies that a dataset keeps.
    Kept(Vec<KeptAsset>),
}

/// A copy that a dataset keeps.
#[derive(Debug, Clone, PartialEq)]
pub struct KeptAsset {
    /// Key of the recipe that names it.
    pub key: String,
    /// Its name when it was read.
    pub name: String,
    /// Its content, or why it cannot be read.
    pub content: Result<Vec<u8>, String>,
}

/// What a recipe asks for.
#[derive(Debug, Clone, Copy)]
pub(crate) struct AssetRequest<'a> {
    /// Key of the recipe.
    pub key: &'a str,
    /// What it names.
    pub name: &'a str,
    /// SHA-256 that the content must have, where the recipe says.
    pub sha256: Option<&'a str>,
    /// Most bytes that it may have.
    pub max_bytes: usize,
    /// What could be meant beside files.
    pub built_in: &'a [BuiltIn],
    /// Whether a folder of that name stands for a tar of its PNG files.
    pub folders: bool,
}

impl AssetSource {
    /// The file that is `wanted`, or what is wrong with it and what to do.
    pub(crate) fn find(&self, wanted: &AssetRequest) -> Result<Asset, AssetFault> {
        let asset = self.locate(wanted)?;
        match wanted.sha256 {
            Some(sum) if sum != asset.sha256() => Err(AssetFault::new(
                format!("`{}` has SHA-256 {}, not {sum}", printable(wanted.name), asset.sha256()),
                "bring the file back, or give its name alone to take it as it is",
            )),
            _ => Ok(asset),
        }
    }

    fn locate(&self, wanted: &AssetRequest) -> Result<Asset, AssetFault> {
        let name = wanted.name;
        let known = || {
            let names: Vec<_> = wanted.built_in.iter().map(|(name, _)| *name).collect();
            if names.is_empty() { String::new() } else { format!(", or one that is built in: {}", names.join(", ")) }
        };
        let path = match self {
            Self::BuiltIn => None,
            Self::Beside(folder) => Some(folder.join(name)),
            Self::Kept(kept) => match kept.iter().find(|kept| kept.key == wanted.key) {
                Some(kept) => {
                    let bring_back = |problem| AssetFault::new(problem, "bring the copy back");
                    let bytes = kept.content.clone().map_err(bring_back)?;
                    return limited(&kept.name, &kept.name, bytes, wanted.max_bytes);
                }
                None => {
                    let problem = format!("the dataset keeps no copy of `{}`", printable(name));
                    return Err(AssetFault::new(problem, "bring dataset.json back from a copy"));
                }
            },
        };
        if let Some(path) = path.as_ref().filter(|path| path.exists()) {
            return if wanted.folders && path.is_dir() {
                slice_tar::of_folder(path, name, wanted.max_bytes)
            } else {
                read_file(path, name, wanted.max_bytes)
            };
        }
        let own = |(known, _): &&BuiltIn| *known == name || (wanted.sha256.is_some() && file_name(known) == name);
        if let Some((name, bytes)) = wanted.built_in.iter().find(own) {
            return Ok(Asset::new(name, bytes.to_vec()));
        }
        Err(match path {
            Some(path) => AssetFault::new(
                format!("there is no file `{}` (looked for {})", printable(name), printable(&path.to_string_lossy())),
                format!("give a name relative to the recipe's own file{}", known()),
            ),
            None => AssetFault::new(
                format!("there is no built-in file `{}`", printable(name)),
                format!("give a recipe that is a file, which can name files beside it{}", known()),
            ),
        })
    }
}

/// Reads a file that has at most `max_bytes`.
fn read_file(path: &Path, name: &str, max_bytes: usize) -> Result<Asset, AssetFault> {
    let shown = printable(&path.to_string_lossy());
    let bytes = files::read_start(path, max_bytes as u64 + 1);
    limited(&shown, name, bytes.map_err(|error| unreadable(&shown, &error))?, max_bytes)
}

/// Why a file that is there cannot be read.
fn unreadable(shown: &str, error: &io::Error) -> AssetFault {
    let remedy = if error.kind() == ErrorKind::Other { "name a file" } else { "make it readable" };
    AssetFault::new(format!("`{shown}` cannot be read: {error}"), remedy)
}

/// The file `name` with this content of at most `max_bytes`; `shown` is what a fault calls it.
fn limited(shown: &str, name: &str, bytes: Vec<u8>, max_bytes: usize) -> Result<Asset, AssetFault> {
    if bytes.len() > max_bytes {
        let problem = format!("`{shown}` has more than {max_bytes} bytes");
        return Err(AssetFault::new(problem, format!("give a file of at most {} MB", max_bytes >> 20)));
    }
    Ok(Asset::new(name, bytes))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Content decides: the sum is that of FIPS 180-2's example, and another content is refused where a sum is given.
    #[test]
    fn files_are_known_by_content() {
        let sum = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        let built_in: &[BuiltIn] = &[("parts/abc.txt", b"abc")];
        let wanted =
            |name, sha256| AssetRequest { key: "mesh.file", name, sha256, max_bytes: 10, built_in, folders: false };
        let found = AssetSource::BuiltIn.find(&wanted("parts/abc.txt", None)).expect("built in");
        assert_eq!((found.name(), found.sha256(), found.bytes()), ("abc.txt", sum, &b"abc"[..]));
        assert_eq!(AssetSource::BuiltIn.find(&wanted("abc.txt", Some(sum))), Ok(found));
        let refused = |files: &AssetSource, name, sum| files.find(&wanted(name, sum)).expect_err("refused").problem;
        assert!(refused(&AssetSource::BuiltIn, "abc.txt", Some("00")).contains("not 00"));
        assert!(refused(&AssetSource::BuiltIn, "abc.txt", None).contains("no built-in file"));

        let folder = tempfile::tempdir().expect("a folder");
        let beside = AssetSource::Beside(folder.path().to_owned());
        assert!(beside.find(&wanted("parts/abc.txt", None)).is_ok(), "built in where no file is");
        assert!(refused(&beside, "none.txt", None).contains("there is no file"));
        assert!(refused(&beside, ".", None).contains("no plain file"));
        std::fs::write(folder.path().join("large.txt"), [0; 11]).expect("written");
        assert!(refused(&beside, "large.txt", None).contains("more than 10 bytes"));
        std::fs::create_dir(folder.path().join("parts")).expect("made");
        std::fs::write(folder.path().join("parts/abc.txt"), b"own").expect("written");
        assert_eq!(beside.find(&wanted("parts/abc.txt", None)).expect("a file wins").bytes(), b"own");
        let kept = |key: &str| {
            AssetSource::Kept(vec![KeptAsset { key: key.into(), name: "abc.txt".into(), content: Ok(vec![0; 11]) }])
        };
        assert!(refused(&kept("mesh.file"), "abc.txt", None).contains("more than"));
        assert!(refused(&kept("laser.texture"), "abc.txt", None).contains("keeps no copy"));
    }
}
