//! Numbers of files that do not say what they are: a map, or a cloud of points, as the file holds them.

/// Most pixels of a file that are compared: a little more than the buffers of the real camera hold, 2560 x 16383. Each
/// takes some 20 bytes.
pub(super) const MAX_PIXELS: usize = 48 << 20;

/// What is read of a point, by the names that files give it: x, y, z, Reflectance, Scatter.
pub(super) const POINT_NAMES: [&[&str]; 5] = [&["x"], &["y"], &["z"], &["reflectance", "intensity"], &["scatter"]];

/// Which of these a name is.
pub(super) fn point_axis(name: &str) -> Option<usize> {
    POINT_NAMES.iter().position(|names| names.contains(&name))
}

/// A map, in the file's own numbers.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct MapNumbers {
    /// Columns.
    pub(super) cols: usize,
    /// Profiles.
    pub(super) rows: usize,
    /// Numbers `[rows, cols]`, row-major; NaN where the file has none.
    pub(super) numbers: Vec<f64>,
    /// Bits of whole numbers; `None` for floats and text.
    pub(super) bits: Option<u8>,
}

/// A cloud of points, in the file's own numbers.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ScanPoints {
    /// x, y, z; NaN where missing.
    pub(super) places: Vec<[f64; 3]>,
    /// Digital number at the peak of each point; NaN where missing.
    pub(super) reflectance: Option<Vec<f64>>,
    /// Sum of digital numbers beside it; NaN where missing.
    pub(super) scatter: Option<Vec<f64>>,
    /// Bits of the reflectance, where its type says so.
    pub(super) bits: Option<u64>,
    /// Columns and profiles, where the file says that it is stored profile by profile.
    pub(super) organised: Option<[usize; 2]>,
    /// The unit of x, y and z, where the file says it [mm].
    pub(super) unit_mm: Option<f64>,
}
