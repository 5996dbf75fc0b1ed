//! Rectification: profiles resampled onto an even grid along the line.
//!
//! Model: each column sees a point (x, z) of the laser plane. Between two neighbouring columns that both have a height,
//! Range, Reflectance and Scatter are linear in x; where the two heights lie further apart than a slope of
//! [`MAX_SURFACE_SLOPE`], there is an edge between them, and a point of the grid takes the nearer one. Where x goes
//! back, as it does beside a step seen at a slant, the upper surface hides the lower one. A gap wider than
//! [`MAX_GAP_COLUMNS`] columns of the grid is missing, as is what lies beside a missing column. This is what the
//! makers' rectification does in words; its details are not published.
//!
//! Neglected: the area that a column gathers from (a column wider than the grid's pitch is not sharpened, a narrower
//! one not averaged); movement along y, since all of a profile lies at one y.

use super::block::MeasuredProfile;
use crate::frame::{Calibration, Rig};

/// Steepest slope along the line over which two heights are one surface [1].
pub const MAX_SURFACE_SLOPE: f32 = 4.0;
/// Widest gap between two columns that is filled, in columns of the grid.
const MAX_GAP_COLUMNS: f32 = 2.0;

/// Even positions along the line: column j stands at `first_mm + j * pitch_mm`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RectifiedGrid {
    /// Position of column 0 [mm].
    pub first_mm: f64,
    /// Distance of two columns [mm].
    pub pitch_mm: f64,
    /// Columns.
    pub columns: usize,
}

impl RectifiedGrid {
    /// As many columns as the sensor has, about what its middle sees at z = 0, as far apart as asked for or as those of
    /// the sensor are there.
    pub fn new(rig: &Rig, columns: usize, pitch_mm: Option<f64>) -> Self {
        let row = rig.project(0.0, 0.0, 0.0).1;
        let middle = 0.5 * (columns as f64 - 1.0);
        let [left, right] = [-0.5, 0.5].map(|side| rig.locate(middle + side, row)[0]);
        let pitch_mm = pitch_mm.unwrap_or(right - left);
        Self { first_mm: 0.5 * (left + right) - middle * pitch_mm, pitch_mm, columns }
    }

    /// Where x lies between the columns of the grid.
    fn column(&self, x: f32) -> f32 {
        ((f64::from(x) - self.first_mm) / self.pitch_mm) as f32
    }
}

/// Points of the laser plane that the columns of a profile measured [mm].
#[derive(Debug, Clone, Default)]
struct ColumnPoints {
    x: Vec<f32>,
    z: Vec<f32>,
}

/// Turns a whole profile of sensor rows into heights on the grid [mm], in place.
pub fn rectify(calibration: &Calibration, grid: &RectifiedGrid, profile: MeasuredProfile<'_>) {
    let MeasuredProfile { range, reflectance, scatter } = profile;
    let mut points = ColumnPoints { x: range.to_vec(), z: range.to_vec() };
    calibration.locator.alongs(0, &mut points.x);
    calibration.locator.heights(0, &mut points.z);
    let (dn, sum) = (reflectance.to_vec(), scatter.to_vec());
    range.fill(f32::NAN);
    reflectance.fill(0.0);
    scatter.fill(0.0);
    let positions: Vec<f32> = points.x.iter().map(|&x| grid.column(x)).collect();
    let last = grid.columns.min(range.len()) as f32 - 1.0;
    for (i, pair) in positions.windows(2).enumerate() {
        let [from, to] = [pair[0], pair[1]];
        // NaN fails as well.
        if !(to > from && to - from <= MAX_GAP_COLUMNS) {
            continue;
        }
        let heights = [points.z[i], points.z[i + 1]];
        let edge = (heights[1] - heights[0]).abs() > MAX_SURFACE_SLOPE * (to - from) * grid.pitch_mm as f32;
        let (first, end) = (from.ceil().max(0.0), to.floor().min(last));
        let mut column = first;
        while column <= end {
            let t = (column - from) / (to - from);
            let t = if edge { t.round() } else { t };
            let mix = |[a, b]: [f32; 2]| a + t * (b - a);
            let (j, z) = (column as usize, mix(heights));
            if range[j].is_nan() || z > range[j] {
                (range[j], reflectance[j], scatter[j]) = (z, mix([dn[i], dn[i + 1]]), mix([sum[i], sum[i + 1]]));
            }
            column += 1.0;
        }
    }
}
