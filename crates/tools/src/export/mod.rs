//! Dataset export: the layouts of other programs, without rendering again.
//!
//! ```text
//! Source --rows of chosen samples, one after the other--> Sample --a format's work, on all cores--> ExportFolder
//! ```
//!
//! What goes into every file follows from the dataset and the options alone, never from threads or time. An
//! `ExportFolder` folder is marked as unfinished until the last file is there; the same command again finishes it.
//! Memory does not grow with the number of samples: rows are read one by one, as many at a time as there are threads.

mod anomaly;
mod classes;
mod coco;
mod export_folder;
mod format;
mod icon;
mod map_scale;
mod mvtec;
mod mvtec3d;
mod objects;
mod picture;
mod picture_options;
mod png;
mod polygon;
mod run_length;
mod sample;
mod source;
mod webdataset;
mod yolo;

pub(crate) use export_folder::EXPORT_DOCUMENT;
pub use export_folder::ExportSummary;
pub use format::{Export, ExportFormat};
pub use source::{ExportProgress, ExportSource, Selection};

/// Every export, in the order of the help.
pub const EXPORTS: &[ExportFormat] =
    &[coco::FORMAT, yolo::FORMAT, mvtec::FORMAT, mvtec3d::FORMAT, webdataset::FORMAT, png::FORMAT, icon::FORMAT];
