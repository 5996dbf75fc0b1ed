//! The wall between what is there and what is measured: the digitised frame and the calibration that reads it.
//!
//! Geometry of a lens with a tilted sensor (Scheimpflug), see docs/instrument.md:
//! the laser plane is y = 0, the lens stands at d (0, -sin a, cos a) and looks at the origin, the sensor is tilted by
//! beta about x with tan(beta) = m cot(a), m = f / (d - f), which puts the whole laser plane in focus.

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

/// Position and optics of the camera against the laser plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rig {
    /// Distance from the lens to the origin [mm].
    pub distance: f64,
    /// Angle between the optical axis and the laser plane [rad].
    pub tilt: f64,
    /// Focal length [mm].
    pub focal_length: f64,
    /// Pixel pitch [mm].
    pub pixel: f64,
    /// Sensor column of the optical axis [px].
    pub centre_col: f64,
    /// Sensor row of the optical axis [px].
    pub centre_row: f64,
}

impl Rig {
    /// Magnification at the origin [1].
    pub fn magnification(&self) -> f64 {
        self.focal_length / (self.distance - self.focal_length)
    }

    /// Sensor tilt that focuses the laser plane [rad].
    pub fn scheimpflug(&self) -> f64 {
        libm::atan(self.magnification() / libm::tan(self.tilt))
    }

    /// Sensor position (column, row) of a point in space [px]; exact off the laser plane too.
    pub fn project(&self, x: f64, y: f64, z: f64) -> (f64, f64) {
        let (sin, cos) = libm::sincos(self.tilt);
        let beta = self.scheimpflug();
        let v0 = self.focal_length * self.distance / (self.distance - self.focal_length);
        let yc = y * cos + z * sin;
        let zc = self.distance + y * sin - z * cos;
        let v = v0 / (1.0 - libm::tan(beta) * yc / zc);
        (self.centre_col + v * x / zc / self.pixel, self.centre_row - v * yc / zc / libm::cos(beta) / self.pixel)
    }

    /// Height of a point of the laser plane seen in `row` [mm].
    pub fn height(&self, row: f64) -> f64 {
        let (sin, cos) = libm::sincos(self.tilt);
        let s = (self.centre_row - row) * self.pixel * libm::cos(self.scheimpflug());
        s * (self.distance - self.focal_length) / (self.focal_length * sin + s * cos)
    }

    /// Where the laser plane is seen at a place of the sensor: x along the line and height z [mm].
    pub fn locate(&self, col: f64, row: f64) -> [f64; 2] {
        let z = self.height(row);
        [self.along(col, z), z]
    }

    /// Position along the laser line of a point of the laser plane at height `z` seen in `col` [mm].
    pub fn along(&self, col: f64, z: f64) -> f64 {
        let scale = (self.distance - self.focal_length - z * libm::cos(self.tilt)) / self.focal_length;
        (col - self.centre_col) * self.pixel * scale
    }
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
        let locator = Locator::new(columns, rows, |col, row| rig.locate(col, row));
        Self { rig, sensor_rows: rows as u32, dark_level, locator }
    }
}
