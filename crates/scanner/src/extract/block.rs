//! Blocks of columns that are processed together, and where their numbers go.

use std::ops::Range;

use crate::frame::Frame;

/// Columns that are processed together.
pub(super) const LANES: usize = 128;

/// Output of one profile, one number per column of the frame.
#[derive(Debug)]
pub struct MeasuredProfile<'a> {
    /// Height [mm] where Range is calibrated, else the sensor row [px]; NaN where missing.
    pub range: &'a mut [f32],
    /// Digital number at the peak [DN]; 0 where missing.
    pub reflectance: &'a mut [f32],
    /// Sum of the side windows [DN]; 0 where missing.
    pub scatter: &'a mut [f32],
}

/// A row of some columns of a frame.
#[inline(always)]
pub(super) fn load_row(frame: &Frame, columns: &Range<usize>, k: usize) -> [u16; LANES] {
    let mut lanes = [0u16; LANES];
    lanes[..columns.len()].copy_from_slice(&frame.dn[k * frame.cols + columns.start..][..columns.len()]);
    lanes
}
