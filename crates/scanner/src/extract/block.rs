//! Blocks of columns that are processed together, and where their numbers go.

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

/// Columns of a frame that are processed together.
#[derive(Debug, Clone, Copy)]
pub(super) struct ColumnBlock<'a> {
    /// The frame.
    pub frame: &'a Frame,
    /// The first of them.
    pub first: usize,
    /// How many there are.
    pub columns: usize,
}

impl ColumnBlock<'_> {
    /// A row of them.
    #[inline(always)]
    pub fn row(self, k: usize) -> [u16; LANES] {
        let mut lanes = [0u16; LANES];
        let from = k * self.frame.cols + self.first;
        lanes[..self.columns].copy_from_slice(&self.frame.dn[from..][..self.columns]);
        lanes
    }
}
