//! The rows of the specimen that some profiles look at.

use super::row::Row;
use super::{ROWS, slow};

/// Rows of the specimen around some profiles of the scan.
#[derive(Debug, Default)]
pub struct Band {
    /// Profiles that can be exposed.
    pub profiles: std::ops::Range<usize>,
    /// Rows before the first profile.
    pub(super) halo: usize,
    pub(super) rows: Vec<Row>,
    /// Light from below by a slow model, a profile; empty where the kernel answers.
    pub(super) windows: Vec<slow::Window>,
    /// Offsets of the rows that let light out, a profile, for each row of the window [profiles]; empty where steps are even.
    pub(super) offsets: Vec<[isize; ROWS]>,
}

impl Band {
    /// The row under the laser in `profile`.
    pub fn row(&self, profile: usize) -> &Row {
        self.neighbour(profile, 0)
    }

    pub(super) fn window(&self, profile: usize) -> Option<&[f32]> {
        self.windows.get(profile - self.profiles.start).map(Vec::as_slice)
    }

    pub(super) fn neighbour(&self, profile: usize, offset: isize) -> &Row {
        let place = (profile - self.profiles.start + self.halo) as isize + offset;
        &self.rows[place as usize]
    }
}
