//! What a format of scans is: the endings of its files, and what is read of one.

use std::path::Path;

use super::ScanMaps;
use super::gocator_frame::GocatorSurface;
use super::map_numbers::{MapNumbers, ScanPoints};
use dataset::{Fault, atomic_file};

/// An ending of files: its letters; how a list of what can be read names such files, nothing where it names them by
/// another ending; whether a folder is looked through for them.
pub(super) type FileEnding = (&'static str, &'static str, bool);

/// A format of scans.
pub(super) struct ScanFormat {
    /// Endings of its files.
    pub(super) endings: &'static [FileEnding],
    /// What files of bare numbers are; nothing where they say themselves what their numbers are.
    pub(super) stated: Option<StatedForm>,
    /// Reads a file with what the user says of lines of text; fails where it cannot be read, is damaged, or holds no
    /// scan.
    pub(super) read: fn(&Path, Option<CsvForm>) -> Result<ScanContent, Fault>,
}

/// The bytes of a file, of which there are `most` at most.
pub(super) fn read_file(path: &Path, most: u64, remedy: &'static str) -> Result<Vec<u8>, Fault> {
    atomic_file::read(path, most).map_err(|e| Fault::at(path, format!("it cannot be read: {e}"), remedy))
}

/// What a file holds.
#[derive(Debug, PartialEq)]
pub(super) enum ScanContent {
    /// A scan that says what its numbers are.
    Scan(Box<ScanMaps>),
    /// Heights, or another map.
    Grid(MapNumbers),
    /// Points.
    Points(ScanPoints),
    /// A surface that says its scale itself.
    Surface(GocatorSurface),
}

/// What the lines of a CSV file are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CsvForm {
    /// A profile each, a number for each column.
    Grid,
    /// A point each: x, y, z.
    Points,
}

/// What files of bare numbers are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StatedForm {
    /// Grey PNG or TIFF.
    Image,
    /// Numbers as text.
    Csv,
    /// A cloud of points.
    Ply,
}
