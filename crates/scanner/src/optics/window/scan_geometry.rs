//! Which scan line each sensor row of a window looks at, while the specimen moves on from profile to profile.
//!
//! On a flat surface a sensor row above the line's looks one row's distance along the motion further. The scan
//! line that stands there lets the light out; it is the line of the profile that is nearest, found exactly where the
//! encoder's steps are not even.

use crate::optics::encoder::Encoder;
use crate::optics::light::{CENTRE, ROWS};

/// Greatest distance of a scan line that lets light out from the profile's own [profiles]; for steps under 0.035 mm the
/// light that leaves further away is let out by the last of them.
const MAX_NEIGHBOURS: usize = 64;

/// Geometry of one scan: positions of the profiles, and the scan lines that each of them looks at.
#[derive(Debug, Clone)]
pub(crate) struct ScanGeometry {
    /// Positions of the profiles.
    pub encoder: Encoder,
    /// Share of a step that the object moves while it is exposed [1].
    pub exposed_share: f32,
    /// Offset of the scan line that lets light out, for each row of the window, where steps are even [profiles].
    pub neighbours: [isize; ROWS],
    /// Distance along the motion of the same lines [mm].
    distances: [f64; ROWS],
    /// Profiles by row, on a flat surface as high as the object.
    profiles_per_row: f64,
}

impl ScanGeometry {
    /// The geometry of a scan in steps of `step` [mm] whose image has `rows_per_mm` rows along the motion on a flat
    /// surface as high as the object; a specimen that turns lets light out by the matter of its own line alone.
    pub fn new(encoder: Encoder, step: f64, rows_per_mm: f64, exposed_share: f64, turns: bool) -> Self {
        let away: [f64; ROWS] = std::array::from_fn(|k| (CENTRE as f64 - k as f64) / rows_per_mm);
        let (distances, neighbours) =
            if turns { ([0.0; ROWS], [0; ROWS]) } else { (away, away.map(|away| whole_profiles(away / step))) };
        let profiles_per_row = 1.0 / (rows_per_mm * step);
        Self { encoder, exposed_share: exposed_share as f32, neighbours, distances, profiles_per_row }
    }

    /// Scan position under the laser in a profile, which may lie before the first [mm].
    pub fn position(&self, profile: isize) -> f64 {
        self.encoder.position(profile)
    }

    /// Scan lines on either side that a profile's window looks at, and one for the front faces of the last.
    pub fn halo(&self) -> usize {
        self.max_neighbour() as usize + 1 + usize::from(self.exposed_share > 0.0)
    }

    /// Most profiles between one and another whose line lets its light out.
    fn max_neighbour(&self) -> isize {
        self.encoder.within(self.distances[0].max(-self.distances[ROWS - 1])).min(MAX_NEIGHBOURS) as isize
    }

    /// Offsets of the lines that let light out, for each row of the window, in each of `profiles` [profiles]; empty
    /// where steps are even, since [`Self::neighbours`] holds for all of them.
    pub(crate) fn uneven_neighbours(&self, profiles: std::ops::Range<usize>) -> Vec<[isize; ROWS]> {
        let nearest = |profile: usize| {
            self.distances.map(|away| self.encoder.nearest(profile as isize, away, self.max_neighbour()))
        };
        if self.encoder.even() { Vec::new() } else { profiles.map(nearest).collect() }
    }

    /// Offset of the scan line that a profile looks at `rows` above its own, as far as a band has lines [profiles].
    pub(crate) fn neighbour_at(&self, rows: f32) -> isize {
        whole_profiles(f64::from(rows) * self.profiles_per_row).clamp(self.neighbours[ROWS - 1], self.neighbours[0])
    }

    /// Distance that the image of a flat surface moves along the rows while it is exposed [px].
    pub(crate) fn exposed_px(&self) -> f64 {
        f64::from(self.exposed_share) / self.profiles_per_row
    }
}

/// Whole profiles, within the farthest that is looked at.
fn whole_profiles(profiles: f64) -> isize {
    (profiles.round() as isize).clamp(-(MAX_NEIGHBOURS as isize), MAX_NEIGHBOURS as isize)
}
