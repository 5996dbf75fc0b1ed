//! The rows of the specimen that some profiles look at.

use super::film::RowView;
use super::row::{Row, RowScratch};
use super::{MAX_NEIGHBOURS, ROWS, Sensor, per_line};
use crate::specimen::Specimen;

/// Rows of the specimen around some profiles of the scan.
#[derive(Debug, Default)]
pub struct Band {
    /// Profiles that can be exposed.
    pub profiles: std::ops::Range<usize>,
    /// How often its rows were made.
    pub(super) made: usize,
    /// Rows before the first profile.
    pub(super) halo: usize,
    pub(super) rows: Vec<Row>,
    /// Light from below by a per_line model, a profile; empty where the kernel answers.
    pub(super) windows: Vec<per_line::Window>,
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

/// Whole profiles, within the farthest that is looked at.
pub(super) fn looks(profiles: f64) -> isize {
    (profiles.round() as isize).clamp(-(MAX_NEIGHBOURS as isize), MAX_NEIGHBOURS as isize)
}

impl Sensor {
    /// Rows of the specimen that a profile needs before and behind its own, and one for the front faces of the last.
    pub fn halo(&self) -> [usize; 2] {
        let window = self.most() as usize + 1 + usize::from(self.way > 0.0);
        let [before, behind] = self.second.map_or([0; 2], |second| second.reach());
        [window + before, window + behind]
    }

    /// Most profiles between one and another whose row lets its light out.
    fn most(&self) -> isize {
        self.encoder.within(self.away[0].max(-self.away[ROWS - 1])).min(MAX_NEIGHBOURS) as isize
    }

    /// Offsets of the rows that let light out in the profiles of a band and the next one.
    fn offsets(&self, band: &Band) -> Vec<[isize; ROWS]> {
        let nearest = |profile: usize| self.away.map(|away| self.encoder.nearest(profile as isize, away, self.most()));
        let profiles = band.profiles.start..band.profiles.end + 1;
        if self.encoder.even() { Vec::new() } else { profiles.map(nearest).collect() }
    }

    /// Profiles from its own to the one that a profile looks at `rows` above its line, as far as a band has rows.
    pub(super) fn looks(&self, rows: f32) -> isize {
        looks(f64::from(rows) * self.profiles_per_row).clamp(self.neighbours[ROWS - 1], self.neighbours[0])
    }

    /// Way that the image of a flat surface moves while it is exposed, along the rows [px].
    pub fn travel_px(&self) -> f64 {
        f64::from(self.way) / self.profiles_per_row
    }

    /// Works out the light at every position that `profiles` look at, in the room of a band that is no longer needed.
    pub fn band(&self, specimen: &Specimen, profiles: std::ops::Range<usize>, mut band: Band) -> Band {
        let [before, behind] = self.halo();
        (band.halo, band.profiles, band.made) = (before, profiles, band.made + 1);
        band.rows.resize_with(band.profiles.len() + before + behind, Row::default);
        let mut scratch = RowScratch::new(self.size.columns);
        for (place, row) in band.rows.iter_mut().enumerate() {
            let profile = (band.profiles.start + place) as isize - band.halo as isize;
            let y = self.position_of(profile) as f32;
            let view = RowView { specimen, camera: &self.camera, y, profile, faint: self.faint };
            self.maker.make(view, &mut scratch, row);
        }
        for place in (1..band.rows.len()).rev() {
            let (before, from) = band.rows.split_at_mut(place);
            before[place - 1].face(&from[0]);
        }
        band.offsets = self.offsets(&band);
        let per_line =
            per_line::PerLine { specimen, camera: &self.camera, transport: self.transport, stream: self.stream };
        let window = |profile: usize| per_line.window(band.row(profile), profile as u64, self.position(profile));
        // The light that a moving object has in the next profile counts too.
        let last = band.profiles.end + usize::from(self.way > 0.0);
        band.windows = (band.profiles.start..last).map_while(window).collect();
        band
    }
}
