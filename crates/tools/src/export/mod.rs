//! Dataset export: the layouts of other programs, without rendering again.
//!
//! ```text
//! Source --rows of chosen samples, one after the other--> Sample --a format's work, on all cores--> ExportFolder
//! ```
//!
//! What goes into every file follows from the dataset and the options alone, never from threads or time. An `ExportFolder` folder
//! is marked as unfinished until the last file is there; the same command again finishes it. Memory does not grow with the
//! number of samples: rows are read one by one, as many at a time as there are threads.

pub mod coco;
pub mod icon;
pub mod mvtec;
pub mod png;
pub mod webdataset;

mod classes;
mod export_folder;
mod map_scale;
mod picture;
mod run_length;
mod sample;
mod source;

pub(crate) use export_folder::EXPORT_DOCUMENT;
pub(crate) use export_folder::ExportFolder;
pub use export_folder::ExportSummary;
pub use map_scale::GivenEnds;
pub(crate) use map_scale::MapScales;
pub use picture::PictureContent;
pub(crate) use run_length::RunLengthMask;
pub use sample::Sample;
pub use source::{Selection, Source};

/// A part of an image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Region {
    /// First row [px].
    pub top: usize,
    /// First column [px].
    pub left: usize,
    /// Rows [px].
    pub rows: usize,
    /// Columns [px].
    pub cols: usize,
}

/// Called with samples done and samples in all; first for those that scales are found from, where they are, and then for
/// those that are written.
pub type ExportProgress<'a> = &'a (dyn Fn(u64, u64) + Sync);

/// The name of a sample's files: its index, with as many digits for all, so that names sort as numbers do.
fn key(index: u64) -> String {
    format!("{index:08}")
}
