//! Everything about one sample that leaves the simulator.

use std::ops::Range;

use base::{Class, Instance};
use optical_bench::settings::RangeForm;
use optical_bench::split::{SampleGroups, Split};

/// What the instrument measured, `[rows = profiles, cols]`, row-major.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Maps {
    /// Height [mm] or sensor row [px]; NaN where missing.
    pub range: Vec<f32>,
    /// Digital number at the peak [DN]; 0 where missing. Whole numbers unless binned or rectified.
    pub reflectance: Vec<f32>,
    /// Sum of digital numbers in the side windows [DN]; 0 where missing. Whole numbers unless binned, rectified or less
    /// the dark level.
    pub scatter: Vec<f32>,
    /// Digital number under lamps [DN]; NaN where the lens does not see the pixel's point. Empty without lamps. Whole
    /// numbers unless binned.
    pub grey: Vec<f32>,
}

/// What is true on the same grid as [`Maps`].
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Labels {
    /// Value of `base::Class` of each pixel.
    pub class: Vec<u8>,
    /// Number of the [`Instance`] of each pixel; 0 for none.
    pub instance: Vec<u16>,
}

/// Noise-free truth on the same grid; NaN off the object.
#[derive(Debug, Clone, PartialEq)]
pub struct TruthMaps {
    /// Height of the surface [mm].
    pub height: Vec<f32>,
    /// What lies below it.
    pub below: Below,
}

/// What lies below a surface, by subject.
#[derive(Debug, Clone, PartialEq)]
pub enum Below {
    /// Wood.
    Fibre {
        /// Angle of the fibre in the surface against the scan direction, positive towards +x [deg], in (-90, 90].
        azimuth: Vec<f32>,
        /// Angle by which its end towards the scan direction runs below the surface [deg], in [-90, 90].
        dive: Vec<f32>,
    },
    /// A pack.
    Film {
        /// Thickness of the film [mm]; 0 where there is none.
        thickness: Vec<f32>,
        /// Air between the film and what it covers [mm]; 0 where there is none.
        gap: Vec<f32>,
    },
    /// A solid piece, alike all through; its subject.
    Solid(&'static str),
}

impl Below {
    /// The subject that it belongs to, by its name in files.
    pub fn subject(&self) -> &'static str {
        match self {
            Self::Fibre { .. } => "wood",
            Self::Film { .. } => "blister",
            Self::Solid(subject) => subject,
        }
    }
}

impl TruthMaps {
    /// Every map: height, then what lies below in the order of its fields.
    pub fn maps_mut(&mut self) -> Vec<&mut Vec<f32>> {
        let height = &mut self.height;
        match &mut self.below {
            Below::Fibre { azimuth, dive } => vec![height, azimuth, dive],
            Below::Film { thickness, gap } => vec![height, thickness, gap],
            Below::Solid(_) => vec![height],
        }
    }
}

/// One defect or pocket as it appears in the written images.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Object {
    /// Its numbers.
    pub instance: Instance,
    /// Pixels that it covers, those of what lies in it included.
    pub area_px: u64,
    /// Area that it covers [mm^2].
    pub area_mm2: f64,
    /// Smallest box around it: first column, first row, columns, rows [px].
    pub bbox: [u32; 4],
    /// Extents of its pixels along the board and across it [mm]; NaN on a turntable.
    pub extent_mm: [f64; 2],
}

/// One exposure kept as the sensor saw it, `[sensor rows, cols]`, row-major.
#[derive(Debug, Clone, PartialEq)]
pub struct StackFrame {
    /// Profile number in the scan.
    pub profile: u32,
    /// Digital numbers [DN].
    pub dn: Vec<u16>,
}

/// One row of the label image with the body's heights there, as far as both follow without light.
#[derive(Debug, Clone, PartialEq)]
pub struct TrueRow {
    /// Row of the image.
    pub row: usize,
    /// Class of each pixel, `[cols]`.
    pub class: Vec<u8>,
    /// Instance of each pixel, `[cols]`; 0 for none.
    pub instance: Vec<u16>,
    /// The truth maps there, `[cols]`.
    pub truth: TruthMaps,
    /// Height of what lies below a film; of the surface where there is none, NaN off the body [mm].
    pub lower: Vec<f32>,
}

/// What of one sample is to be exposed again.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct AskedRows {
    /// Neighbouring rows of the images.
    pub strips: Vec<Range<usize>>,
    /// Rows of the label image that are made again without light, beside those that the body gives.
    pub unlit: Vec<usize>,
    /// The profiles of sensor frames, rising.
    pub frames: Vec<usize>,
}

impl AskedRows {
    /// Whether nothing is asked for.
    pub fn is_empty(&self) -> bool {
        self.strips.is_empty() && self.frames.is_empty()
    }
}

/// Neighbouring rows of the images of one sample, exposed again.
#[derive(Debug, Clone, PartialEq)]
pub struct ExposedRows {
    /// The first row.
    pub first: usize,
    /// Columns of the images.
    pub cols: usize,
    /// What the instrument measures there, `[rows, cols]`.
    pub maps: Maps,
    /// What is true there.
    pub labels: Labels,
    /// Noise-free truth, where the recipe asks for it.
    pub truth: Option<TruthMaps>,
}

/// One sample.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Record {
    /// Number in the dataset.
    pub index: u64,
    /// UUID v5 of (recipe, seed, index).
    pub id: String,
    /// Part of the dataset.
    pub split: Split,
    /// Name of the recipe's class.
    pub class: String,
    /// What it has in common with other samples.
    pub groups: SampleGroups,
    /// Columns of the images.
    pub cols: usize,
    /// Rows of the images (profiles).
    pub rows: usize,
    /// Distance between two rows [mm].
    pub row_mm: f64,
    /// Distance between two columns at the upper surface's height [mm].
    pub col_mm: f64,
    /// What Range is.
    pub range: RangeForm,
    /// Integer range r > 0 means `range_offset + r * range_scale`, in the unit of [`Record::range`].
    pub range_offset: f64,
    /// See `range_offset`.
    pub range_scale: f64,
    /// Rows of the sensor [px].
    pub sensor_rows: usize,
    /// Camera against laser plane, by name with unit; NaN where a number has no meaning.
    pub calibration: Vec<(&'static str, f64)>,
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
    /// Defects, pockets, teeth and parts of which at least one pixel shows something, by number.
    pub objects: Vec<Object>,
    /// Classes of the defects among [`Record::objects`], by number.
    pub defects: Vec<Class>,
    /// Classes of the other defects that the object has, which no pixel shows, by number.
    pub unseen: Vec<Class>,
    /// Share of the object's convex outline, seen from above, that lies within the field of the images; NaN on a
    /// turntable [1].
    pub object_in_view: f64,
    /// Sensor frames that the recipe keeps, by profile.
    pub stack: Vec<StackFrame>,
}

/// What of one sample follows from its scene without rendering it whole.
#[derive(Debug, Clone, PartialEq)]
pub struct DerivedSample {
    /// Its numbers, of which those hold that need no images; its maps are empty.
    pub record: Record,
    /// Every instance of the body, by number from 1, seen or not.
    pub instances: Vec<Instance>,
    /// Some rows of the label image, and the body's heights there, by rising row.
    pub rows: Vec<TrueRow>,
    /// The rows that were asked for, exposed.
    pub exposed: Vec<ExposedRows>,
}
