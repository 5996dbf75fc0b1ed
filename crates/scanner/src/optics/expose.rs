//! Exposure of one tile of columns: light gathers in windows of sensor rows, then becomes numbers.

use std::ops::Range;

use super::light::{CENTRE, ROWS, load};
use super::readout::{Digitiser, TileExposure};
use super::sensor::Sensor;
use super::speckle::TILE;
use super::window::{Band, Drawing, LitProfile, Scratch};
use crate::extract::{MeasuredProfile, extract, extract_tile, reach};
use crate::frame::{Calibration, Frame};
use crate::specimen::Hit;
use optical_bench::settings::Extraction;

/// Rows by which a peak may lie beside the row of the line's centre and still be read from the rows about it [px].
const MAX_PEAK_SHIFT: usize = 2;

/// A tile of a profile, to be exposed.
#[derive(Debug, Clone, Copy)]
pub struct TileOfProfile<'a> {
    /// Scan lines about the profile.
    pub band: &'a Band,
    /// Which profile.
    pub profile: usize,
    /// Which tile: the sensor's columns `tile * TILE ..`.
    pub tile: usize,
    /// Offsets of the sensor's rows in this exposure, from [`Sensor::row_offsets`] [DN].
    pub offsets: &'a [f32],
}

impl Sensor {
    /// Fills `scratch` with the electrons of one tile, as they are when the shutter closes.
    pub fn window(&self, band: &Band, profile: usize, tile: usize, scratch: &mut Scratch) {
        self.drawing(band, profile).draw(tile, scratch);
    }

    /// What is drawn of a profile.
    pub(super) fn drawing<'a>(&'a self, band: &'a Band, profile: usize) -> Drawing<'a> {
        let lit = LitProfile { camera: &self.camera, geometry: &self.geometry, band, profile };
        Drawing { lit, second: self.second.as_ref(), faint: self.faint }
    }

    /// Exposes the windows of a tile. The second frame has no rows where one window holds all light.
    pub fn expose(&self, part: &TileOfProfile<'_>, scratch: &mut Scratch, frames: &mut [Frame; 2]) {
        self.window(part.band, part.profile, part.tile, scratch);
        self.digitise(part, scratch, frames);
    }

    /// Exposes a tile and reads its columns into `out`, as from whole windows; `scratch` and `frames` are buffers.
    pub fn measure(
        &self,
        part: &TileOfProfile<'_>,
        calibration: &Calibration,
        settings: &Extraction,
        (scratch, frames): (&mut Scratch, &mut [Frame; 2]),
        out: &mut MeasuredProfile<'_>,
    ) {
        let Some(light) = self.expose_to_read(part, settings, scratch, frames) else {
            return extract(frames, calibration, settings, out);
        };
        let peaks = extract_tile(&frames[0], calibration, settings, out);
        let (digitiser, exposure) = self.digitising(part, scratch.columns);
        if peaks.at_an_end || digitiser.reaches_beyond(&exposure, &scratch.windows[0], &light, &peaks.to_outshine) {
            self.expose(part, scratch, frames);
            extract(frames, calibration, settings, out);
        }
    }

    /// [`Self::expose`], but only the rows that `settings` read about the line, the same to the bit, where it can be
    /// told what the others hold. Returns the light that no pixel of these exceeds in each column, but for one in 10^12
    /// [e-]; `None` where all rows are there.
    pub fn expose_to_read(
        &self,
        part: &TileOfProfile<'_>,
        settings: &Extraction,
        scratch: &mut Scratch,
        frames: &mut [Frame; 2],
    ) -> Option<[f32; TILE]> {
        let rows = reading_rows(settings);
        let drawing = self.drawing(part.band, part.profile);
        // Where pixels don't depend on each other.
        let alone = rows.len() < ROWS && self.chain.rows_are_alone() && drawing.is_line_alone(part.tile);
        let beyond = alone.then(|| drawing.light_beyond(part.tile, &rows, &self.speckle)).flatten();
        if beyond.is_none() {
            self.expose(part, scratch, frames);
            return None;
        }
        drawing.draw_still(part.tile, rows, scratch);
        scratch.windows.iter_mut().for_each(|window| window.ambient.clear());
        self.digitise(part, scratch, frames);
        beyond
    }

    /// Makes numbers of the light in `scratch`.
    fn digitise(&self, part: &TileOfProfile<'_>, scratch: &mut Scratch, frames: &mut [Frame; 2]) {
        let (digitiser, exposure) = self.digitising(part, scratch.columns);
        frames[1].rows = 0;
        for number in 0..scratch.used {
            let window = &scratch.windows[number];
            digitiser.digitise(&exposure, number, window, &mut scratch.signal, &mut frames[number]);
        }
    }

    /// What digitises a tile, of which the sensor has so many columns.
    fn digitising<'a>(&'a self, part: &TileOfProfile<'a>, columns: usize) -> (Digitiser<'a>, TileExposure<'a>) {
        let TileOfProfile { band, profile, tile, offsets } = *part;
        let line = band.line(profile);
        let hits = &line.hits[tile * TILE..][..columns];
        let place = [hits[columns / 2].x, median_height(hits)].map(f64::from);
        // Speckle moves as far as the object does here.
        let way = self.position(profile) * self.turn.map_or(1.0, |turn| turn.share(place[0]));
        let exposure = TileExposure { profile, tile, columns, place, way, offsets };
        let (contrasts, centre) = (line.contrasts_of(tile), load(&line.centre, tile * TILE));
        (Digitiser { chain: &self.chain, speckle: &self.speckle, contrasts, centre }, exposure)
    }
}

/// Rows of a window that are enough to read a line in its middle.
fn reading_rows(settings: &Extraction) -> Range<usize> {
    let reach = reach(settings) + MAX_PEAK_SHIFT;
    // Whole pairs of rows; the line's centre lies between two rows of the window.
    let (first, end) = (CENTRE.saturating_sub(reach), (CENTRE + 1 + reach + 1).min(ROWS));
    first / 2 * 2..end.next_multiple_of(2)
}

/// Median height of every fourth column of a tile, of those that laser and lens reach where there are some [mm]; a
/// narrow ridge in the middle of a tile does not change what the rest of it sees.
fn median_height(hits: &[Hit]) -> f32 {
    let (mut heights, mut count) = ([0.0f32; TILE], 0);
    let reached = |hit: &&Hit| hit.lit && hit.seen;
    for hit in hits.iter().step_by(4).filter(reached) {
        heights[count] = hit.surface.z;
        count += 1;
    }
    if count == 0 {
        return hits[hits.len() / 2].surface.z;
    }
    *heights[..count].select_nth_unstable_by(count / 2, f32::total_cmp).1
}
