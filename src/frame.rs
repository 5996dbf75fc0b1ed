//! The wall between what is there and what is measured: the digitised frame and the calibration that reads it.
//!
//! The laser plane is y = 0; [`Rig`] says where its points are seen, docs/instrument.md derives it.

mod rig;

pub use self::rig::{Bent, Columns, Distortion, Reading, Rig, Sightline, image_distance, scheimpflug};

mod locator;

pub use locator::Locator;

/// Columns of digital numbers around the laser line.
///
/// The window of each column starts at a sensor row of its own; rows outside of it hold dark level and noise alone.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Frame {
    /// Columns in the window.
    pub cols: usize,
    /// Rows in the window.
    pub rows: usize,
    /// Sensor column of the window's first column.
    pub first_col: usize,
    /// Sensor row of each column's first sample `[cols]`.
    pub first_row: Vec<i32>,
    /// Digital numbers `[rows, cols]`, row-major [DN].
    pub dn: Vec<u16>,
}

/// What an extraction must know to turn sensor rows into numbers; it knows nothing of the object.
#[derive(Debug, Clone, PartialEq)]
pub struct Calibration {
    /// The camera.
    pub rig: Rig,
    /// Rows of the sensor [px].
    pub sensor_rows: u32,
    /// Mean digital number without light [DN].
    pub dark_level: f32,
    /// The camera as a table.
    pub locator: Locator,
}

impl Calibration {
    /// For a sensor of that many columns and rows [px].
    pub fn new(rig: Rig, [columns, rows]: [usize; 2], dark_level: f32) -> Self {
        let reading = rig.reading();
        let locator = Locator::new(columns, rows, |col, row| reading.locate(col, row));
        Self { rig, sensor_rows: rows as u32, dark_level, locator }
    }
}
