//! What a format of scans is: the endings of its files, and what is read of one.

use std::path::Path;

use super::ScanMaps;
use super::gocator_frame::GocatorSurface;
use super::map_numbers::{MapNumbers, ScanPoints};
use dataset::Fault;

/// An ending of files: its letters; how a list of what can be read names such files, nothing where it names them by
/// another ending; whether a folder is looked through for them.
pub(super) type FileEnding = (&'static str, &'static str, bool);

/// A format of scans.
pub(super) trait ScanFormat: Sync {
    /// Endings of its files.
    fn endings(&self) -> &'static [FileEnding];

    /// What files of bare numbers are; nothing where they say themselves what their numbers are.
    fn stated(&self) -> Option<StatedForm> {
        None
    }

    /// Reads a file; `csv` is what the user says of lines of text.
    ///
    /// # Errors
    /// Where it cannot be read, is damaged, or holds no scan.
    fn read(&self, path: &Path, csv: Option<CsvForm>) -> Result<ScanContent, Fault>;
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
