//! Output files of commands: what a path may be, the path is tried before the work, and the file is written atomically.

use std::fs;
use std::io::{Error, ErrorKind, IsTerminal, Write};
use std::path::{Component, Path, PathBuf};

use base::words;
use clap::builder::{PathBufValueParser, TypedValueParser};
use image::RgbImage;

use super::UsageError;
use dataset::atomic_file::{self, FileError};
use dataset::{enclosed, own_remedy};
use output_schema::file::{REPORTS, TEMPORARY};

/// A folder that a command fills with results.
#[derive(Debug, Clone, Copy)]
pub(super) enum ResultFolder<'a> {
    /// One that the user names.
    Named(&'a Path),
    /// `reports/` in the dataset at this path. No link there is followed: results never land outside of the dataset.
    Kept(&'a Path),
}

impl<'a> ResultFolder<'a> {
    fn parts(self) -> (&'a Path, &'static str) {
        match self {
            Self::Named(folder) => (folder, ""),
            Self::Kept(root) => (root, REPORTS),
        }
    }

    fn relative(self, name: &str) -> String {
        match self.parts() {
            (_, "") => name.into(),
            (_, below) => format!("{below}/{name}"),
        }
    }

    /// Where a result lies.
    pub(super) fn path(self, name: &str) -> PathBuf {
        self.parts().0.join(self.relative(name))
    }

    /// Makes the folder `reports/` where it is missing.
    pub(super) fn make(self, remedy: &str) -> Result<(), String> {
        match self {
            Self::Named(_) => Ok(()),
            Self::Kept(root) => enclosed::make_folder(root, REPORTS).map_err(|refused| told(&refused, remedy)),
        }
    }

    /// Refuses a folder in which nothing can be written, before hours are spent on its content.
    pub(super) fn check_writable(self, remedy: &str) -> Result<(), String> {
        let (root, below) = self.parts();
        let probe = format!("{TEMPORARY}{}-probe", std::process::id());
        let is_made = below.is_empty() || root.join(below).symlink_metadata().is_ok();
        let probe = if is_made { self.relative(&probe) } else { probe };
        enclosed::check_writable(root, &probe).map_err(|refused| told(&refused, remedy))
    }

    /// Writes a result as a whole or not at all.
    pub(super) fn write(self, name: &str, content: &[u8], remedy: &str) -> Result<(), String> {
        let partial = self.relative(&format!("{TEMPORARY}{}-{name}", std::process::id()));
        let written = enclosed::write_by(self.parts().0, &partial, &self.relative(name), content);
        written.map_err(|FileError { source, .. }| {
            let remedy = own_remedy(&source).unwrap_or(remedy);
            format!("cannot write {}: {source}; {remedy}", self.path(name).display())
        })
    }

    /// A result of at most `most` bytes that lies there; `None` where there is none that can be read.
    pub(super) fn read(self, name: &str, most: u64) -> Option<Vec<u8>> {
        enclosed::read(self.parts().0, &self.relative(name), most).ok()
    }

    /// Names of what lies there.
    pub(super) fn names(self) -> Result<Vec<String>, Error> {
        enclosed::names(self.parts().0, self.parts().1)
    }

    /// Removes a result.
    pub(super) fn remove(self, name: &str) -> Result<(), Error> {
        enclosed::remove(self.parts().0, &self.relative(name)).map_err(|refused| refused.source)
    }
}

fn told(FileError { operation, path, source }: &FileError, remedy: &str) -> String {
    let remedy = own_remedy(source).unwrap_or(remedy);
    format!("cannot {operation} {}: {source}; {remedy}", path.display())
}

/// What to do where a file cannot be written.
pub(super) const ELSEWHERE: &str = "give another place with --out";
/// How arguments name standard output.
const STANDARD_OUTPUT: &str = "-";
/// Endings of pictures that are no PNG.
const OTHER_PICTURES: [&str; 9] = ["jpg", "jpeg", "tif", "tiff", "bmp", "gif", "webp", "svg", "pdf"];

/// Parser of an argument that names a folder.
pub(super) fn folder() -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().try_map(|path: PathBuf| {
        if has_ending(&path, "png") || OTHER_PICTURES.iter().any(|picture| has_ending(&path, picture)) {
            let folder = path.with_extension("");
            return Err(format!(
                "this is a folder and no picture: name it without an ending, for instance {}",
                folder.display()
            ));
        }
        refuse_standard_output(path, "folder")
    })
}

/// Parser of an argument that names a file with this ending, or without one.
pub(super) fn file(ending: &'static str) -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new()
        .try_map(move |path: PathBuf| refuse_standard_output(path, "such file").and_then(|path| ends(path, ending)))
}

/// Parser of an argument that names a file with this ending, or without one, or standard output.
pub(super) fn file_or_standard_output(ending: &'static str) -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().try_map(move |path: PathBuf| ends(path, ending))
}

/// Parser of an argument that names a folder, or a picture in it.
pub(super) fn folder_or_picture() -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().try_map(|path: PathBuf| {
        let is_other = OTHER_PICTURES.iter().any(|other| has_ending(&path, other));
        let path = if is_other { ends(path, "png")? } else { path };
        refuse_standard_output(path, "folder")
    })
}

/// Whether a path stands for standard output.
pub(super) fn is_standard_output(path: &Path) -> bool {
    path == Path::new(STANDARD_OUTPUT)
}

/// Writes `content`, which is no text, to standard output; not to a terminal. A reader that has gone away is no fault.
pub(super) fn write_standard_output(content: &[u8]) -> Result<(), String> {
    if std::io::stdout().is_terminal() {
        return Err("--out -: a terminal cannot show it; send it on with `| ` or `> `, or name a file".into());
    }
    let mut out = std::io::stdout().lock();
    super::printed(out.write_all(content).and_then(|()| out.flush())).map_err(|error| error.to_string())
}

fn refuse_standard_output(path: PathBuf, what: &str) -> Result<PathBuf, String> {
    if is_standard_output(&path) {
        return Err(format!("standard output takes no {what}; give a name, `./-` for one of that name"));
    }
    Ok(path)
}

fn has_ending(path: &Path, ending: &str) -> bool {
    path.extension().is_some_and(|found| found.eq_ignore_ascii_case(ending))
}

/// Refuses a name that says of the file what it is not.
fn ends(path: PathBuf, ending: &str) -> Result<PathBuf, String> {
    if path.extension().is_none() || has_ending(&path, ending) {
        return Ok(path);
    }
    let (upper, renamed) = (ending.to_uppercase(), path.with_extension(ending));
    Err(format!("the file is {upper}: choose a name that ends in .{ending}, for instance {}", renamed.display()))
}

/// Writes `content` to `path`, which `--out` names.
pub(super) fn write(path: &Path, content: &[u8]) -> Result<(), String> {
    write_or(path, content, ELSEWHERE)
}

/// The same for a path that follows from other arguments; `remedy` is what to do where it cannot be written.
pub(super) fn write_or(path: &Path, content: &[u8], remedy: &str) -> Result<(), String> {
    let error_text = |error: Error, first: &str| {
        let remedy = own_remedy(&error).map_or_else(|| format!("{first}{remedy}"), str::to_owned);
        format!("cannot write {}: {error}; {remedy}", path.display())
    };
    let Some(name) = path.file_name().filter(|_| !path.is_dir()) else {
        return Err(error_text(Error::from(ErrorKind::IsADirectory), "a folder has that name: "));
    };
    let partial = path.with_file_name(format!(".tmp-{}-{}", std::process::id(), name.to_string_lossy()));
    atomic_file::write(&partial, path, content).map_err(|refused| match refused.source.kind() {
        ErrorKind::NotFound => error_text(refused.source, "make the folder first, or "),
        _ => error_text(refused.source, ""),
    })
}

/// A picture as the bytes of a PNG file.
pub(super) fn png(picture: &RgbImage) -> Result<Vec<u8>, image::ImageError> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    picture.write_to(&mut bytes, image::ImageFormat::Png)?;
    Ok(bytes.into_inner())
}

/// The path without links and `..`, as far as it exists.
pub(super) fn resolve(path: &Path) -> Option<PathBuf> {
    let mut resolved = PathBuf::new();
    for part in std::path::absolute(path).ok()?.components() {
        match part {
            Component::ParentDir => _ = resolved.pop(),
            part => resolved.push(part),
        }
        resolved = resolved.canonicalize().unwrap_or(resolved);
    }
    Some(resolved)
}

words! {
    /// What a command writes to the path that `--out` names, by the ending of its name.
    Written {
        /// A picture.
        Png = "png",
        /// A document.
        Json = "json",
        /// A page.
        Html = "html",
        /// Maps.
        Exr = "exr",
    }
}

impl Written {
    /// Whether a file that begins so can be one that was written before.
    fn begins(self, start: &[u8]) -> bool {
        match self {
            Self::Png => start.starts_with(b"\x89PNG\r\n\x1a\n"),
            Self::Json => start.starts_with(b"{"),
            Self::Html => start.starts_with(b"<!DOCTYPE html>"),
            Self::Exr => start.starts_with(&[0x76, 0x2f, 0x31, 0x01]),
        }
    }
}

/// Refuses to write over what is none of this command's: a name with another ending, a file with other content, or any
/// file of a dataset but under reports/.
pub(super) fn check_replaceable(path: &Path, written: Written) -> Result<(), UsageError> {
    let refuse = |what: String| Err(UsageError(format!("--out {}: {what}", path.display())));
    let extension = written.name();
    if path.extension().is_some() && !has_ending(path, extension) && !path.is_dir() {
        return refuse(format!("give a name that ends in .{extension}"));
    }
    if let Some(dataset) = dataset_around(path) {
        let remedy = "nothing else may lie there but under reports/; choose another place";
        return refuse(format!("it lies in the dataset {}: {remedy}", dataset.display()));
    }
    // A link is replaced, whatever it leads to; what is written never goes through it.
    let start = match files::read_start(path, 16) {
        _ if path.is_symlink() => Vec::new(),
        Ok(start) => start,
        Err(error) if error.kind() == ErrorKind::Other && !path.is_dir() => {
            return refuse(format!("{error}; name a file"));
        }
        // A file that cannot be read is told where it is written.
        Err(_) => Vec::new(),
    };
    if !start.is_empty() && !written.begins(&start) {
        return refuse(format!("the file that is there is no .{extension}; choose another name, or remove it"));
    }
    Ok(())
}

/// Refuses a folder in a dataset, however deep and whatever leads there: a file that no manifest names is a fault of
/// the dataset. The folder itself `may_be_one`.
pub(super) fn check_outside_datasets(out: &Path, may_be_one: bool) -> Result<(), UsageError> {
    let Some(folder) = resolve(out) else { return Ok(()) };
    match folder.ancestors().skip(may_be_one.into()).find(|folder| dataset::is_dataset(folder)) {
        None => Ok(()),
        Some(root) => Err(UsageError(format!(
            "--out {}: it lies in the dataset {}, where nothing else may lie; choose a folder elsewhere",
            out.display(),
            root.display()
        ))),
    }
}

/// The dataset among whose own files a path lies.
fn dataset_around(path: &Path) -> Option<PathBuf> {
    // A file takes the place of a link, not of what that leads to.
    let folder = resolve(&path.parent()?.join("."))?;
    let root = folder.ancestors().find(|folder| dataset::is_dataset(folder))?;
    (!folder.starts_with(root.join(REPORTS))).then(|| root.to_path_buf())
}

/// Refuses a path that cannot be written, before hours are spent on its content; `--out` names it.
pub(super) fn check_writable(path: &Path) -> Result<(), String> {
    let remedy = ELSEWHERE;
    let error_text = |what: String, remedy: String| Err(format!("cannot write {}: {what}; {remedy}", path.display()));
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if path.is_dir() || path.file_name().is_none() {
        return error_text("it is a folder".into(), format!("name a file: {remedy}"));
    }
    if !folder.is_dir() {
        return error_text(format!("there is no folder {}", folder.display()), format!("make it first, or {remedy}"));
    }
    let probe = folder.join(format!(".tmp-{}-probe", std::process::id()));
    // What is there under that name is not ours: it is neither written through nor kept.
    let made = atomic_file::create(&probe).map(|_| ());
    let _ = fs::remove_file(&probe);
    made.or_else(|refused| {
        let remedy = own_remedy(&refused.source).unwrap_or(remedy);
        error_text(refused.source.to_string(), remedy.into())
    })
}
