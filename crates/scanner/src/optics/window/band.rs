//! Band: the rows of the specimen that some neighbouring profiles look at, made by [`crate::optics::Bands`].

use std::sync::atomic::{AtomicU64, Ordering};

use super::scan_geometry::ScanGeometry;
use crate::optics::light::{ROWS, Row};

/// Numbers given to bands so far. They only tell bands apart while light is kept from one exposure to the next; nothing
/// that is computed depends on them.
static NUMBERS_GIVEN: AtomicU64 = AtomicU64::new(1);

/// Rows of the specimen around some profiles of the scan.
#[derive(Debug, Default)]
pub struct Band {
    /// Profiles that can be exposed.
    pub profiles: std::ops::Range<usize>,
    /// A number that no other band of this run has; 0 for a band without rows.
    pub(crate) number: u64,
    /// Rows before the first profile.
    pub(crate) halo: usize,
    pub(crate) rows: Vec<Row>,
    /// Whether some rows are copies of others, so that no other band may keep them.
    pub(crate) is_sparse: bool,
    /// Electrons from below by a model that knows one line at a time, `[ROWS][columns]` for both windows of each profile, columns padded to
    /// whole tiles; empty where the kernel answers.
    pub(crate) volumes: Vec<[Vec<f32>; 2]>,
    /// Offsets of the rows that let light out, a profile, for each row of the window [profiles]; empty where steps are even.
    pub(crate) offsets: Vec<[isize; ROWS]>,
}

impl Band {
    /// The row under the laser in `profile`.
    pub fn row(&self, profile: usize) -> &Row {
        self.neighbour(profile, 0)
    }

    /// Makes a band of `profiles`, with `before` rows before the first and `behind` behind the last, under a number of its
    /// own. Rows that it holds already move to its beginning: their number; the others keep their memory alone.
    pub(crate) fn restart(&mut self, profiles: std::ops::Range<usize>, [before, behind]: [usize; 2]) -> usize {
        self.number = NUMBERS_GIVEN.fetch_add(1, Ordering::Relaxed);
        let forward =
            profiles.start.checked_sub(self.profiles.start).filter(|_| before == self.halo && !self.is_sparse);
        self.is_sparse = false;
        let kept = forward.map_or(0, |passed| self.rows.len().saturating_sub(passed));
        let passed = self.rows.len() - kept;
        self.rows.rotate_left(passed);
        (self.halo, self.profiles) = (before, profiles);
        let rows = self.profiles.len() + before + behind;
        self.rows.resize_with(rows, Row::default);
        kept.min(rows)
    }

    /// Electrons from below in `profile`; `None` where the kernel answers.
    pub(crate) fn volume(&self, profile: usize) -> Option<&[Vec<f32>; 2]> {
        self.volumes.get(profile - self.profiles.start)
    }

    /// Offsets of the rows that each row of a profile's window looks at [profiles].
    pub(crate) fn neighbours<'a>(&'a self, profile: usize, geometry: &'a ScanGeometry) -> &'a [isize; ROWS] {
        self.offsets.get(profile - self.profiles.start).unwrap_or(&geometry.neighbours)
    }

    pub(crate) fn neighbour(&self, profile: usize, offset: isize) -> &Row {
        let place = (profile - self.profiles.start + self.halo) as isize + offset;
        &self.rows[place as usize]
    }
}
