//! Exposed profile: a sensor frame and what extraction reads from it. The caller renders it for the page.

/// A sensor frame, cut to the rows around the laser line, and what extraction reads from it.
#[derive(Debug, Clone, PartialEq)]
pub struct ExposedProfile {
    /// Number of the profile in the scan.
    pub profile: usize,
    /// Profiles in the scan.
    pub profiles: usize,
    /// Position of the profile along the scan [mm].
    pub y_mm: f64,
    /// Columns of the sensor [px].
    pub cols: usize,
    /// First sensor row of the cut [px].
    pub first_row: usize,
    /// Digital numbers `[rows, cols]`, row-major [DN].
    pub dn: Vec<u16>,
    /// Greatest digital number that the sensor can give [DN].
    pub max_dn: u16,
    /// Sensor row of the line in each column; NaN where none is found [px].
    pub line: Vec<f32>,
    /// Position along the laser line and height of each column; NaN where none is found [mm].
    pub points: Vec<[f64; 2]>,
}
