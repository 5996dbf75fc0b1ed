//! Everything about one sample that leaves the simulator.

use procedural::Instance;

/// Which part of the dataset a sample belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Split {
    /// For training.
    Train,
    /// For choosing.
    Validation,
    /// For the last word.
    Test,
}

impl Split {
    /// Every split in the order of files.
    pub const ALL: [Self; 3] = [Self::Train, Self::Validation, Self::Test];

    /// Name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Train => "train",
            Self::Validation => "validation",
            Self::Test => "test",
        }
    }
}

/// What the instrument measured, `[rows = profiles, cols]`, row-major.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Maps {
    /// Height [mm]; NaN where missing.
    pub range: Vec<f32>,
    /// Digital number at the peak [DN]; 0 where missing. Whole numbers unless binned.
    pub reflectance: Vec<f32>,
    /// Sum of digital numbers in the side windows [DN]; 0 where missing. Whole numbers unless binned.
    pub scatter: Vec<f32>,
}

/// What is true on the same grid as [`Maps`].
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Labels {
    /// Value of `procedural::Class` of each pixel.
    pub class: Vec<u8>,
    /// Number of the [`Instance`] of each pixel; 0 for none.
    pub instance: Vec<u16>,
}

/// Noise-free truth on the same grid; NaN off the object.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct TruthMaps {
    /// Height of the surface [mm].
    pub height: Vec<f32>,
    /// Angle of the fibre in the surface against the scan direction, positive towards +x [deg], in (-90, 90].
    pub fibre_azimuth: Vec<f32>,
    /// Angle of the fibre against the surface [deg], in [0, 90].
    pub fibre_dive: Vec<f32>,
}

/// One defect as it appears in the written images.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Object {
    /// Its numbers.
    pub instance: Instance,
    /// Pixels that it covers.
    pub area_px: u64,
    /// Area that it covers [mm^2].
    pub area_mm2: f64,
    /// Smallest box around it: first column, first row, columns, rows [px].
    pub bbox: [u32; 4],
}

/// One exposure kept as the sensor saw it, `[sensor rows, cols]`, row-major.
#[derive(Debug, Clone, PartialEq)]
pub struct StackFrame {
    /// Profile number in the scan.
    pub profile: u32,
    /// Digital numbers [DN].
    pub dn: Vec<u8>,
}

/// One sample.
#[derive(Debug, Clone, PartialEq)]
pub struct Record {
    /// Number in the dataset.
    pub index: u64,
    /// UUID v5 of (recipe, seed, index).
    pub id: String,
    /// Part of the dataset.
    pub split: Split,
    /// Name of the recipe's class.
    pub class: String,
    /// Columns of the images.
    pub cols: usize,
    /// Rows of the images (profiles).
    pub rows: usize,
    /// Distance between two rows [mm].
    pub row_mm: f64,
    /// Distance between two columns at the upper surface's height [mm].
    pub col_mm: f64,
    /// Integer range r > 0 means `range_offset_mm + r * range_scale_mm`.
    pub range_offset_mm: f64,
    /// See `range_offset_mm`.
    pub range_scale_mm: f64,
    /// Every drawn number, by its path.
    pub draws: Vec<(String, f64)>,
    /// Numbers that follow from the draws: effective physics, by name with unit.
    pub physics: Vec<(&'static str, f64)>,
    /// Images as measured.
    pub maps: Maps,
    /// Images as true.
    pub labels: Labels,
    /// Noise-free truth, where the recipe asks for it.
    pub truth: Option<TruthMaps>,
    /// Defects that at least one pixel shows, by number.
    pub objects: Vec<Object>,
    /// Sensor frames that the recipe keeps, by profile.
    pub stack: Vec<StackFrame>,
}
