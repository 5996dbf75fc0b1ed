//! Band: the scan lines that some neighbouring profiles look at, made by [`crate::optics::Bands`].

use std::sync::atomic::{AtomicU64, Ordering};

use super::scan_geometry::ScanGeometry;
use crate::optics::light::{GlarePart, ROWS, ScanLine};

/// Numbers given to bands so far. They only tell bands apart while light is kept from one exposure to the next; nothing
/// that is computed depends on them.
static NUMBERS_GIVEN: AtomicU64 = AtomicU64::new(1);

/// Scan lines around some profiles of the scan.
#[derive(Debug, Default)]
pub struct Band {
    /// Profiles that can be exposed.
    pub profiles: std::ops::Range<usize>,
    /// A number that no other band of this run has; 0 for a band without lines.
    pub(crate) number: u64,
    /// Lines before the first profile.
    pub(crate) halo: usize,
    pub(crate) lines: Vec<ScanLine>,
    /// Whether some lines are copies of others, so that no other band may keep them.
    pub(crate) is_sparse: bool,
    /// Electrons from below by a model that knows one line at a time, `[ROWS][columns]` for both windows of each
    /// profile, columns padded to whole tiles; empty where the kernel answers.
    pub(crate) volumes: Vec<[Vec<f32>; 2]>,
    /// Glare about the line of each profile; empty without.
    pub(crate) glare: Vec<Vec<GlarePart>>,
    /// Offsets of the lines that let light out, a profile, for each row of the window [profiles]; empty where steps are
    /// even.
    pub(crate) offsets: Vec<[isize; ROWS]>,
}

impl Band {
    /// The line under the laser in `profile`.
    pub fn line(&self, profile: usize) -> &ScanLine {
        self.neighbour(profile, 0)
    }

    /// Makes a band of `profiles`, with `before` lines before the first and `behind` behind the last, under a number of
    /// its own. Lines that it holds already move to its beginning: their number; the others keep their memory alone.
    pub(crate) fn restart(&mut self, profiles: std::ops::Range<usize>, [before, behind]: [usize; 2]) -> usize {
        self.number = NUMBERS_GIVEN.fetch_add(1, Ordering::Relaxed);
        let forward =
            profiles.start.checked_sub(self.profiles.start).filter(|_| before == self.halo && !self.is_sparse);
        self.is_sparse = false;
        let kept = forward.map_or(0, |passed| self.lines.len().saturating_sub(passed));
        let passed = self.lines.len() - kept;
        self.lines.rotate_left(passed);
        (self.halo, self.profiles) = (before, profiles);
        let lines = self.profiles.len() + before + behind;
        self.lines.resize_with(lines, ScanLine::default);
        kept.min(lines)
    }

    /// Electrons from below in `profile`; `None` where the kernel answers.
    pub(crate) fn volume(&self, profile: usize) -> Option<&[Vec<f32>; 2]> {
        self.volumes.get(profile - self.profiles.start)
    }

    /// Glare about the line of `profile`, of each width; none without.
    pub(crate) fn glare_about(&self, profile: usize) -> &[GlarePart] {
        self.glare.get(profile - self.profiles.start).map_or(&[], Vec::as_slice)
    }

    /// Offsets of the lines that each row of a profile's window looks at [profiles].
    pub(crate) fn neighbours<'a>(&'a self, profile: usize, geometry: &'a ScanGeometry) -> &'a [isize; ROWS] {
        self.offsets.get(profile - self.profiles.start).unwrap_or(&geometry.neighbours)
    }

    pub(crate) fn neighbour(&self, profile: usize, offset: isize) -> &ScanLine {
        let place = (profile - self.profiles.start + self.halo) as isize + offset;
        &self.lines[place as usize]
    }
}
