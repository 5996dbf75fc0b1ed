//! Lamp line: what lamps beside the laser find at one position of the scan, before shadows, spread and the lens.

use transport::kernel::DIFFUSE_GROUPS;

/// Numbers of one position of the scan, structure of arrays over sensor columns.
#[derive(Debug, Clone, Default)]
pub(crate) struct LampLine {
    /// Height of the surface [mm].
    pub height: Vec<f32>,
    /// Its slope along the motion [1].
    pub slope: Vec<f32>,
    /// Cosine between its normal and upright [1].
    pub up: Vec<f32>,
    /// Radiance factor of the surface itself under the lamps, where no shadow falls [1].
    pub surface: Vec<f32>,
    /// Square root of the diffuse reflectance of each group of widths [1].
    pub roots: [Vec<f32>; DIFFUSE_GROUPS],
    /// Whether the lens sees the column's point.
    pub seen: Vec<bool>,
}
