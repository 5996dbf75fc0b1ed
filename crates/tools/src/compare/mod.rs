//! Comparison of simulated with real scans: the same statistics of both sides, their distances, and a page of plots.
//!
//! ```text
//! path -> ScanSource -> ScanMaps, scan by scan -> StatisticsBuilder -> Statistics -> Comparison -> table, JSON, page
//! ```
//!
//! This module knows files and numbers but not how a scan was made, so both sides are treated alike. Each statistic is
//! a function of one scan in a file of its own, whose header states its assumptions.

mod comparison;
mod csv_frame;
mod dataset_frame;
mod distribution;
mod exr_frame;
mod formats;
mod gocator_frame;
mod grey_image;
mod icon_frame;
mod json_frame;
mod line_width;
mod map_numbers;
mod noise;
mod number_text;
mod plots;
mod ply_frame;
mod point_grid;
mod power_spectrum;
mod scan_format;
mod scan_part;
mod source;
mod speckle;
mod stated_frame;
mod stated_scale;
mod statistics;
pub mod summary;

pub use comparison::{Comparison, StatisticDistance};
pub(crate) use dataset_frame::frame_of;
pub use scan_format::{CsvForm, StatedForm};
pub use scan_part::{ScanMask, ScanRegion};
pub use source::ScanSource;
pub use stated_scale::{CountScale, MissingNumber, StatedScale};
pub use statistics::{ScanStatistics, StatisticsBuilder};

/// One exposure of the sensor.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct SensorFrame {
    /// Columns [px].
    pub cols: usize,
    /// Profile of the scan that it is of, where that is known.
    pub profile: Option<usize>,
    /// Digital numbers `[rows, cols]`, row-major [DN of 8 bits].
    pub dn: Vec<u8>,
}

impl SensorFrame {
    /// Most columns whose line is measured; more are left out evenly.
    const MOST_COLUMNS: usize = 4096;

    /// The columns whose line is measured, each from its first row to its last.
    pub(crate) fn columns(&self) -> impl Iterator<Item = Vec<u8>> {
        let step = self.cols.div_ceil(Self::MOST_COLUMNS).max(1);
        (0..self.cols).step_by(step).map(|x| self.dn.chunks_exact(self.cols).map(|row| row[x]).collect())
    }
}

/// What the numbers of Range are.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum RangeUnit {
    /// Heights [mm].
    #[default]
    Mm,
    /// Rows of a sensor that has that many [px].
    Px {
        /// Rows of the sensor, or of the region of it that was searched [px].
        sensor_rows: u32,
    },
}

impl RangeUnit {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mm => "mm",
            Self::Px { .. } => "px",
        }
    }

    /// Name of its thousandth, the unit of noise.
    pub fn thousandth(self) -> &'static str {
        match self {
            Self::Mm => "um",
            Self::Px { .. } => "mpx",
        }
    }
}

/// One scan, whatever file it came from.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ScanMaps {
    /// What it is called.
    pub name: String,
    /// Columns.
    pub cols: usize,
    /// Profiles.
    pub rows: usize,
    /// Distance between two columns, where the file says it [mm].
    pub col_mm: Option<f64>,
    /// Distance between two profiles, where the file says it [mm].
    pub row_mm: Option<f64>,
    /// What Range is.
    pub unit: RangeUnit,
    /// Place along the line of the middle of column 0, where columns are evenly apart and the file says it [mm].
    pub first_mm: Option<f64>,
    /// Place along the line of each height, where columns are not evenly apart and the file says it `[rows, cols]`
    /// [mm]; NaN where the height is missing.
    pub x: Option<Vec<f64>>,
    /// Heights, or sensor rows of uncalibrated scans, `[rows, cols]`, row-major [mm or px]; NaN where missing. In
    /// double precision, so that differences of steps of an instrument are equal where the steps are.
    pub range: Vec<f64>,
    /// Digital number at the peak `[rows, cols]` [DN of 8 bits]; 0 where missing.
    pub reflectance: Option<Vec<f32>>,
    /// Sum of digital numbers beside the peak `[rows, cols]` [DN of 8 bits]; 0 where missing.
    pub scatter: Option<Vec<f32>>,
    /// Exposures that were kept.
    pub exposures: Vec<SensorFrame>,
    /// Value of `base::Class` of each pixel `[rows, cols]`, where labels were asked for and are there.
    pub classes: Option<Vec<u8>>,
    /// What the file holds beside all this, by name.
    pub unused: Vec<String>,
    /// Bits of the numbers in the file, 0 where it does not say; here all are on the scale of 8 bits.
    pub bits: u64,
}

/// What a digital number of `bits` is on the scale of 8 bits [1].
pub fn to_eight_bits(bits: u64) -> f32 {
    if (9..=16).contains(&bits) { 255.0 / ((1u32 << bits) - 1) as f32 } else { 1.0 }
}
