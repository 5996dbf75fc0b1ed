//! Page data: everything that the page is made from.

use std::path::Path;

use output_schema::DatasetHead;

use super::dataset_counts::DatasetCounts;
use super::exposed_profile::ExposedProfile;
use super::folder::DatasetFolder;
use super::sheet_sample::SheetSample;
use dataset::DatasetSums;
use recipe::Recipe;

/// How long a sample took.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RenderTiming {
    /// The sample that was rendered.
    pub index: u64,
    /// To render and encode it [s].
    pub seconds: f64,
    /// Threads that worked on it.
    pub threads: usize,
}

/// Everything that the page is made from.
pub(super) struct PageData<'a> {
    pub root: &'a Path,
    pub head: &'a DatasetHead,
    pub folder: DatasetFolder,
    pub counts: DatasetCounts,
    pub samples: Vec<SheetSample>,
    pub exposures: Vec<(usize, ExposedProfile)>,
    pub timing: Option<RenderTiming>,
    pub recipe: &'a Result<&'a Recipe, String>,
    pub sums: DatasetSums,
}
