//! List of the formats of scans, and which of them a file is of.

use std::path::{Path, PathBuf};

use super::scan_format::{FileEnding, ScanFormat, StatedForm};
use super::{csv_frame, exr_frame, grey_image, icon_frame, json_frame, ply_frame};

/// Every format, in the order in which lists name them.
const FORMATS: [&ScanFormat; 6] = [
    &exr_frame::FORMAT,
    &icon_frame::FORMAT,
    &json_frame::FORMAT,
    &grey_image::FORMAT,
    &csv_frame::FORMAT,
    &ply_frame::FORMAT,
];

/// Every ending with its format.
fn endings() -> impl Iterator<Item = (FileEnding, &'static ScanFormat)> {
    FORMATS.into_iter().flat_map(|format| format.endings.iter().map(move |ending| (*ending, format)))
}

/// The format of a file by its ending; a name without one may stand for the two files of the camera.
pub(super) fn format_of(path: &Path) -> Option<&'static ScanFormat> {
    let letters = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
    let known = endings().find(|((known, ..), _)| known.eq_ignore_ascii_case(letters));
    known.map(|(_, format)| format).or_else(|| described_by(path).is_file().then_some(&icon_frame::FORMAT))
}

/// What a file of bare numbers is.
pub(super) fn stated_form(path: &Path) -> Option<StatedForm> {
    format_of(path)?.stated
}

/// The format of a map beside Range: one of bare numbers, grey images unless its ending says else.
pub(super) fn map_format(path: &Path) -> &'static ScanFormat {
    format_of(path).filter(|format| format.stated.is_some()).unwrap_or(&grey_image::FORMAT)
}

/// `NAME.xml` of a file of the camera that is given as `NAME`.
pub(super) fn described_by(path: &Path) -> PathBuf {
    PathBuf::from(format!("{}.xml", path.display()))
}

/// Whether a folder is looked through for files with this ending, of bare numbers or of such as say what these are.
pub(super) fn is_looked_for(letters: &str, is_stated: bool) -> bool {
    endings().any(|((known, _, is_looked_for), format)| {
        is_looked_for && format.stated.is_some() == is_stated && letters.eq_ignore_ascii_case(known)
    })
}

/// The endings of all files that can be read, in words; of folders those that are looked for in them.
pub(super) fn readable(in_folders: bool) -> String {
    words(|is_looked_for, _| is_looked_for || !in_folders)
}

/// The endings of files of bare numbers, in words.
pub(super) fn stated_words() -> String {
    words(|_, format| format.stated.is_some())
}

fn words(is_named: impl Fn(bool, &ScanFormat) -> bool) -> String {
    let named = endings().filter(|((_, words, looked), format)| !words.is_empty() && is_named(*looked, format));
    named.map(|((_, words, _), _)| words).collect::<Vec<_>>().join(", ")
}
