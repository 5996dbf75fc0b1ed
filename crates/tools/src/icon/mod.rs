//! iCon file format: what a Ranger3 or Ruler3000 camera's own tools write and read, as a `.dat` with numbers and an
//! `.xml` that describes their layout.
//!
//! ```text
//! Scan --ScanWriter, rows by rows--> NAME.dat, then NAME.xml --open--> Content::Scan(ScanReader) --rows--> Scan
//! SensorImage --write_image--------> NAME.dat, then NAME.xml --open--> Content::Image(SensorImage)
//! ```
//!
//! Numbers are little-endian. A scan is planar (layout SUBCOMPONENT): all rows of Range, then all of Intensity or
//! Reflectance, then Scatter, then Mark; a sensor image goes line by line (layout SCAN). Readers take both. A scan in
//! memory may hold some rows of a file only, so files of any length pass through in little memory.
//!
//! A damaged file gives an [`Fault`](dataset::Fault), never a panic, and takes no more memory than its own size.
//! [docs/guide/icon.md](../../docs/guide/icon.md) tells what every element means.

mod layout;
mod read;
mod traits;
mod write;
mod xml;

pub use read::{Content, ScanReader, open};
pub use traits::{SensorTraits, Traits, WorldTraits};
pub use write::{ScanWriter, write_image};

/// Heights of a scan, `[rows, width]`, row-major.
#[derive(Debug, Clone, PartialEq)]
pub enum RangeValues {
    /// WORD: steps of [`Traits::height`]; 0 where missing.
    Steps(Vec<u16>),
    /// FLOAT: heights; 0 or NaN where missing [mm].
    World(Vec<f32>),
}

/// Light at the peak, one number for each height, 0 where it is missing `[rows, width]` [DN].
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum PeakLight {
    /// As the camera names it in uncalibrated scans.
    Intensity(Vec<u8>),
    /// As it names it beside laser scatter.
    Reflectance(Vec<u8>),
}

/// Light beside the peak `[rows, width]` [DN].
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Scatter {
    /// Scaled down to 8 bits by the camera.
    Byte(Vec<u8>),
    /// Sums as they are.
    Word(Vec<u16>),
}

/// What the camera notes about one profile.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ProfileMark {
    /// Value of the encoder's counter.
    pub encoder: i32,
    /// Bits of inputs and triggers; see [`ProfileMark::overtriggered`].
    pub status: u32,
    /// When the exposure was taken, in ticks of the camera's clock; wraps.
    pub timestamp: u32,
    /// When the encoder pulsed; RangerE only, else 0.
    pub pulse: u32,
    /// Number of the scan; RangerE only, else 0.
    pub scan: u32,
}

impl ProfileMark {
    /// Trigger signals between this profile and the one before that came too early to be used.
    pub fn overtriggered(self) -> u32 {
        self.status >> 16 & 0xff
    }
}

/// A scan, or some rows of one.
#[derive(Debug, Clone, PartialEq)]
pub struct IconScan {
    /// Columns.
    pub width: usize,
    /// Profiles.
    pub rows: usize,
    /// What columns and steps of Range mean.
    pub traits: Traits,
    /// Place along the line of each height of a calibrated scan, where the file holds it `[rows, width]`, row-major
    /// [mm].
    pub x: Option<Vec<f32>>,
    /// Heights.
    pub range: RangeValues,
    /// Light at the peak.
    pub light: Option<PeakLight>,
    /// Light beside the peak.
    pub scatter: Option<Scatter>,
    /// Notes of each profile `[rows]`.
    pub marks: Option<Vec<ProfileMark>>,
}

impl IconScan {
    /// Height of every pixel `[rows, width]` [mm], in an uncalibrated scan the sensor row [px]; NaN where missing.
    pub fn heights(&self) -> Vec<f64> {
        match &self.range {
            RangeValues::Steps(steps) => steps.iter().map(|&n| self.traits.height(n)).collect(),
            RangeValues::World(heights) => {
                heights.iter().map(|&z| if z == 0.0 { f64::NAN } else { f64::from(z) }).collect()
            }
        }
    }

    /// Place along the line of every pixel, where the file holds it `[rows, width]` [mm]; NaN where the height is
    /// missing.
    pub fn places(&self) -> Option<Vec<f64>> {
        let x = self.x.as_ref().filter(|_| matches!(self.traits, Traits::World(_)))?;
        let places = x.iter().zip(self.heights());
        Some(places.map(|(&x, z)| if z.is_nan() { f64::NAN } else { f64::from(x) }).collect())
    }

    /// Distance between two columns of a calibrated scan [mm]: the middle one of all distances between neighbours where
    /// the file holds places, else that of an even grid in the bounds.
    pub fn col_mm(&self) -> Option<f64> {
        let Traits::World(world) = self.traits else { return None };
        let Some(places) = self.places() else { return Some(world.col_mm(self.width)) };
        let pairs = places.chunks_exact(self.width.max(1)).flat_map(|row| row.windows(2));
        let mut steps: Vec<f64> = pairs.map(|pair| (pair[1] - pair[0]).abs()).filter(|mm| mm.is_finite()).collect();
        let middle = steps.len() / 2;
        (!steps.is_empty()).then(|| *steps.select_nth_unstable_by(middle, f64::total_cmp).1)
    }

    /// Light at the peak, under either name `[rows, width]` [DN].
    pub fn light_dn(&self) -> Option<&[u8]> {
        self.light.as_ref().map(|light| match light {
            PeakLight::Intensity(dn) | PeakLight::Reflectance(dn) => dn.as_slice(),
        })
    }
}

/// One exposure as the sensor saw it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SensorImage {
    /// Columns [px].
    pub cols: usize,
    /// Rows [px].
    pub rows: usize,
    /// Where the region begins on the sensor: column, row [px].
    pub offset: [u32; 2],
    /// Digital numbers `[rows, cols]`, row-major [DN].
    pub dn: Vec<u8>,
}
