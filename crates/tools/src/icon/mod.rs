//! iCon file format: what a Ranger3 or Ruler3000 camera's own tools write and read, as a `.dat` with numbers and an
//! `.xml` that describes their layout.
//!
//! ```text
//! Scan --files--------> NAME.dat, NAME.xml --open--> Content::Scan(ScanReader) --rows--> Scan
//! SensorImage --files-> NAME.dat, NAME.xml --open--> Content::Image(SensorImage)
//! ```
//!
//! Numbers are little-endian. A scan is planar (layout SUBCOMPONENT): all rows of Range, then all of Intensity or
//! Reflectance, then Scatter, then Mark; a sensor image goes line by line (layout SCAN). Readers take both. A scan in
//! memory may hold some rows of a file only, so files of any length are read in little memory.
//!
//! A damaged file gives an [`Fault`](dataset::Fault), never a panic, and takes no more memory than its own size.
//! [docs/guide/icon.md](../../docs/guide/icon.md) tells what every element means.

mod layout;
mod read;
mod traits;
mod xml;

use self::layout::FileLayout;

pub use layout::{NumberType, PlaneContent};
pub use read::{Content, ScanReader, open};
pub use traits::{SensorTraits, Traits, WorldTraits};

/// What a scan or a sensor image is on disk.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct IconFiles {
    /// `NAME.dat`: the numbers.
    pub data: Vec<u8>,
    /// `NAME.xml`: what they are.
    pub description: String,
}

/// Numbers of a plane, row after row.
#[derive(Debug, Clone, PartialEq)]
pub enum PlaneNumbers {
    /// BYTE.
    Byte(Vec<u8>),
    /// WORD.
    Word(Vec<u16>),
    /// INT.
    Int(Vec<u32>),
    /// FLOAT.
    Float(Vec<f32>),
}

impl PlaneNumbers {
    /// Numbers of a type.
    fn read(kind: NumberType, bytes: Vec<u8>) -> Self {
        let fours = || bytes.as_chunks::<4>().0.iter();
        match kind {
            NumberType::Byte => Self::Byte(bytes),
            NumberType::Word => Self::Word(bytes.as_chunks::<2>().0.iter().map(|n| u16::from_le_bytes(*n)).collect()),
            NumberType::Int => Self::Int(fours().map(|n| u32::from_le_bytes(*n)).collect()),
            NumberType::Float => Self::Float(fours().map(|n| f32::from_le_bytes(*n)).collect()),
        }
    }

    /// Their bytes.
    fn bytes(&self) -> Vec<u8> {
        match self {
            Self::Byte(numbers) => numbers.clone(),
            Self::Word(numbers) => numbers.iter().flat_map(|n| n.to_le_bytes()).collect(),
            Self::Int(numbers) => numbers.iter().flat_map(|n| n.to_le_bytes()).collect(),
            Self::Float(numbers) => numbers.iter().flat_map(|n| n.to_le_bytes()).collect(),
        }
    }

    /// Their type.
    pub fn kind(&self) -> NumberType {
        match self {
            Self::Byte(_) => NumberType::Byte,
            Self::Word(_) => NumberType::Word,
            Self::Int(_) => NumberType::Int,
            Self::Float(_) => NumberType::Float,
        }
    }
}

/// What the camera notes about one profile.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ProfileMark {
    /// Value of the encoder's counter.
    pub encoder: i32,
    /// Bits of inputs and triggers; bits 16 to 23 count trigger signals that came too early to be used.
    pub status: u32,
    /// When the exposure was taken, in ticks of the camera's clock; wraps.
    pub timestamp: u32,
    /// When the encoder pulsed; RangerE only, else 0.
    pub pulse: u32,
    /// Number of the scan; RangerE only, else 0.
    pub scan: u32,
}

impl ProfileMark {
    /// From the numbers of a row: standard marks have two, extended ones five.
    fn read(numbers: &[u32]) -> Self {
        let number = |i: usize| numbers.get(i).copied().unwrap_or(0);
        let (encoder, status) = (number(0).cast_signed(), number(1));
        Self { encoder, status, timestamp: number(2), pulse: number(3), scan: number(4) }
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
    /// What the file holds, in its order; all but marks `[rows, width]`, row-major. Range is WORD, steps of
    /// [`Traits::height`] and 0 where missing, or FLOAT, heights and 0 or NaN where missing [mm].
    pub planes: Vec<(PlaneContent, PlaneNumbers)>,
}

impl IconScan {
    /// The files of the scan, plane after plane.
    pub fn files(&self) -> IconFiles {
        let mut data = Vec::new();
        self.planes.iter().for_each(|(_, numbers)| data.extend(numbers.bytes()));
        IconFiles { data, description: FileLayout::of(self).write() }
    }

    /// A plane, where the file holds it.
    pub fn plane(&self, part: PlaneContent) -> Option<&PlaneNumbers> {
        self.planes.iter().find(|(known, _)| *known == part).map(|(_, numbers)| numbers)
    }

    /// Height of every pixel `[rows, width]` [mm], in an uncalibrated scan the sensor row [px]; NaN where missing.
    pub fn heights(&self) -> Vec<f64> {
        let height = |z: &f32| if *z == 0.0 { f64::NAN } else { f64::from(*z) };
        match self.plane(PlaneContent::Range) {
            Some(PlaneNumbers::Word(steps)) => steps.iter().map(|&n| self.traits.height(n)).collect(),
            Some(PlaneNumbers::Float(heights)) => heights.iter().map(height).collect(),
            _ => Vec::new(),
        }
    }

    /// Place along the line of every pixel, where the file holds it `[rows, width]` [mm]; NaN where the height is
    /// missing.
    pub fn places(&self) -> Option<Vec<f64>> {
        let (Some(PlaneNumbers::Float(x)), Traits::World(_)) = (self.plane(PlaneContent::RangeX), self.traits) else {
            return None;
        };
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

    /// Light at the peak, under either name, 0 where it is missing `[rows, width]` [DN].
    pub fn light_dn(&self) -> Option<&[u8]> {
        match self.plane(PlaneContent::Intensity).or_else(|| self.plane(PlaneContent::Reflectance))? {
            PlaneNumbers::Byte(dn) => Some(dn),
            _ => None,
        }
    }

    /// Notes of each profile.
    pub fn marks(&self) -> Option<Vec<ProfileMark>> {
        match self.plane(PlaneContent::Mark)? {
            PlaneNumbers::Int(numbers) => {
                let width = numbers.len() / self.rows.max(1);
                Some(numbers.chunks(width.max(1)).map(ProfileMark::read).collect())
            }
            _ => None,
        }
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

impl SensorImage {
    /// The files of the image.
    pub fn files(&self) -> IconFiles {
        IconFiles { data: self.dn.clone(), description: FileLayout::of_image(self).write() }
    }
}
