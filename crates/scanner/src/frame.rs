//! Digitised frame and the calibration that reads it: the wall between what is there and what is measured.
//!
//! The laser plane is y = 0; [`Rig`] projects points onto the sensor, docs/theory/instrument.md derives it.

mod locator;
mod rig;

pub use self::locator::Locator;
pub use self::rig::{BackProjection, Rig, Sightline, Sightlines};

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

/// What an extraction needs to turn sensor rows into heights; it knows nothing of the object.
#[derive(Debug, Clone, PartialEq)]
pub struct Calibration {
    /// The camera.
    pub rig: Rig,
    /// Rows of the sensor [px].
    pub sensor_rows: u32,
    /// Mean digital number without light [DN].
    pub dark_level: f32,
    /// [`BackProjection`] as a table.
    pub locator: Locator,
}

impl Calibration {
    /// For a sensor of that many columns and rows [px].
    pub fn new(rig: Rig, [columns, rows]: [usize; 2], dark_level: f32) -> Self {
        let back = rig.back_projection();
        let locator = Locator::new(columns, rows, |col, row| back.locate(col, row));
        Self { rig, sensor_rows: rows as u32, dark_level, locator }
    }
}
