//! Exposure of one tile of columns: light gathers in windows of sensor rows, then becomes numbers.

use std::ops::Range;

use super::band::Band;
use super::digitise::{Digitiser, TileExposure};
use super::interreflections::Exchange;
use super::line_image::{LineShape, draw, surface_line};
use super::motion_blur::{self, MotionBlur};
use super::row::{Row, WindowNeed};
use super::rows_left_out::{greater, light_beyond, mix_bounds};
use super::second_line::LitProfile;
use super::seen_rows::SeenRows;
use super::sensor::Sensor;
use super::speckle::TILE;
use super::window::{CENTRE, ExposureKey, ROWS, Scratch, load};
use super::{ambient, compositing, mixed_columns, streak};
use crate::extract::{MeasuredProfile, extract, extract_tile, reach};
use crate::frame::{Calibration, Frame};
use crate::specimen::Hit;
use bench::settings::Extraction;
use transport::kernel::BASIS;

/// Rows by which a peak may lie beside the row of the line's centre and still be read from the rows about it [px].
const MAX_PEAK_SHIFT: usize = 2;

/// A tile of a profile, to be exposed.
#[derive(Debug, Clone, Copy)]
pub struct TileOfProfile<'a> {
    /// Rows of the specimen about the profile.
    pub band: &'a Band,
    /// Which profile.
    pub profile: usize,
    /// Which tile: the sensor's columns `tile * TILE ..`.
    pub tile: usize,
    /// Offsets of the sensor's rows in this exposure, from [`Sensor::row_offsets`] [DN].
    pub offsets: &'a [f32],
}

impl Sensor {
    /// Exposes the windows of a tile. The second frame has no rows where one window holds all light.
    pub fn expose(&self, part: &TileOfProfile<'_>, scratch: &mut Scratch, frames: &mut [Frame; 2]) {
        window(self, part.band, part.profile, part.tile, scratch);
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

    /// [`Self::expose`], but only the rows that `settings` read about the line, the same to the bit, where it can be told what the
    /// others hold. Returns the light that no pixel of these exceeds in each column, but for one in 10^12 [e-]; `None` where
    /// all rows are there.
    pub fn expose_to_read(
        &self,
        part: &TileOfProfile<'_>,
        settings: &Extraction,
        scratch: &mut Scratch,
        frames: &mut [Frame; 2],
    ) -> Option<[f32; TILE]> {
        let rows = reading_rows(settings);
        let beyond = (rows.len() < ROWS && self.is_line_alone(part)).then(|| self.light_beyond(part, &rows)).flatten();
        if beyond.is_none() {
            self.expose(part, scratch, frames);
            return None;
        }
        still(self, part.band, part.profile, part.tile, rows, scratch);
        scratch.windows.iter_mut().for_each(|window| window.ambient.clear());
        self.digitise(part, scratch, frames);
        beyond
    }

    /// Whether a tile shows nothing but a line that is one Gaussian and what spreads from it over a level surface, but for edges
    /// whose sides do not mix rows, on pixels that don't depend on each other.
    fn is_line_alone(&self, part: &TileOfProfile<'_>) -> bool {
        let TileOfProfile { band, profile, tile, .. } = *part;
        let row = band.row(profile);
        self.chain.rows_are_alone()
            && self.geometry.exposed_share == 0.0
            && self.camera.laser.line_profile().is_none()
            && !self.camera.has_ambient()
            && self.second.is_none()
            && band.volume(profile).is_none()
            && row.defocus_radius.is_empty()
            && !Exchange { geometry: &self.geometry, band, profile }.is_near(tile)
            && row.secondary.as_ref().is_none_or(|secondary| !secondary.pockets.reaches(&secondary.patches, tile))
            && row.secondary.as_ref().is_none_or(|secondary| secondary.needs[tile] == WindowNeed::Line)
            && mixed_columns::share_rows_or_none(&row.mixed, tile, load(&row.centre, tile * TILE))
            && streak::near_tile(&row.streaks, tile).is_empty()
            && !SeenRows::are_uneven(row, &self.neighbours(band, profile), tile * TILE)
    }

    /// The rows that a window of a profile looks at.
    fn neighbours<'a>(&self, band: &'a Band, profile: usize) -> [&'a Row; ROWS] {
        let offsets = band.neighbours(profile, &self.geometry);
        std::array::from_fn(|k| band.neighbour(profile, offsets[k]))
    }

    /// A bound on the light of the line in the rows of a tile's window that are not among `rows`, a column [e-]; `None` where front
    /// faces let some of it out.
    fn light_beyond(&self, part: &TileOfProfile<'_>, rows: &Range<usize>) -> Option<[f32; TILE]> {
        let TileOfProfile { band, profile, tile, .. } = *part;
        let (start, own) = (tile * TILE, band.row(profile));
        let neighbours = self.neighbours(band, profile);
        let mut exits = [0.0f32; BASIS];
        for k in (0..rows.start).chain(rows.end..ROWS) {
            if neighbours[k].front_of(start).is_some() {
                return None;
            }
            let greatest = neighbours[k].greatest_exits[tile];
            exits.iter_mut().zip(greatest).for_each(|(most, exit)| *most = greater(*most, exit));
        }
        // Light of short paths, as from knots, keeps more contrast than that of the wood that the patterns are made for.
        let contrasts = own.contrasts_of(tile).as_flattened();
        let brightest = self.speckle.brightest(contrasts.iter().fold(1.0, |most: f32, contrast| most.max(*contrast)));
        let mut light = light_beyond(own, start, rows, &exits, brightest);
        mix_bounds(mixed_columns::of_tile(&own.mixed, tile), start, load(&own.centre, start), &mut light);
        Some(light)
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
        let row = band.row(profile);
        let hits = &row.hits[tile * TILE..][..columns];
        let place = [hits[columns / 2].x, median_height(hits)].map(f64::from);
        // Speckle moves as far as the object does here.
        let way = self.position(profile) * self.turn.map_or(1.0, |turn| turn.share(place[0]));
        let exposure = TileExposure { profile, tile, columns, place, way, offsets };
        (Digitiser { chain: &self.chain, speckle: &self.speckle, contrasts: row.contrasts_of(tile) }, exposure)
    }
}

/// Fills `scratch` with the electrons of one tile, as they are when the shutter closes.
pub fn window(sensor: &Sensor, band: &Band, profile: usize, tile: usize, scratch: &mut Scratch) {
    if sensor.geometry.exposed_share > 0.0 {
        let blur = MotionBlur { share: 0.5 * sensor.geometry.exposed_share, faint: sensor.faint };
        let key = ExposureKey { band: band.number, profile, tile };
        motion_blur::window(blur, key, scratch, |profile, scratch| {
            still(sensor, band, profile, tile, 0..ROWS, scratch)
        });
    } else {
        still(sensor, band, profile, tile, 0..ROWS, scratch);
    }
    ambient::add(&sensor.camera, &sensor.geometry, band, profile, tile, scratch);
}

/// Rows of a window that are enough to read a line in its middle.
fn reading_rows(settings: &Extraction) -> Range<usize> {
    let reach = reach(settings) + MAX_PEAK_SHIFT;
    // Whole pairs of rows; the line's centre lies between two rows of the window.
    let (first, end) = (CENTRE.saturating_sub(reach), (CENTRE + 1 + reach + 1).min(ROWS));
    first / 2 * 2..end.next_multiple_of(2)
}

/// Light of an object that stands still under the laser alone, in these rows of the first window.
fn still(sensor: &Sensor, band: &Band, profile: usize, tile: usize, rows: Range<usize>, scratch: &mut Scratch) {
    let start = tile * TILE;
    let own = band.row(profile);
    scratch.columns = (own.hits.len() - start).min(TILE);
    scratch.used = 1;
    let first = &mut scratch.windows[0];
    first.drawn = rows;
    let line = LineShape { centre: load(&own.centre, start), blur: 0.0, profile: sensor.camera.laser.line_profile() };
    match band.volume(profile) {
        Some(volume) => {
            surface_line(own, start, &line, load(&own.variance, start), first);
            if let Some(secondary) = &own.secondary {
                compositing::stand(secondary, tile, scratch);
            }
            for (window, volume) in scratch.windows.iter_mut().take(scratch.used).zip(volume) {
                let padded = volume.len() / ROWS;
                for (k, row) in window.volume.iter_mut().enumerate() {
                    *row = *load(volume, k * padded + start);
                }
            }
            if let Some(secondary) = &own.secondary {
                compositing::add_surface_reflections(secondary, tile, &mut scratch.windows[..scratch.used]);
            }
        }
        None => {
            let neighbours = sensor.neighbours(band, profile);
            draw(own, &neighbours, start, &line, first);
            let exchange = Exchange { geometry: &sensor.geometry, band, profile };
            exchange.add(tile, first);
            if let Some(secondary) = &own.secondary {
                compositing::composite(own, &neighbours, secondary, tile, scratch);
                let used = scratch.used;
                scratch.windows[..used].iter_mut().for_each(|window| exchange.add_pocket_light(tile, window));
            }
            streak::draw(streak::near_tile(&own.streaks, tile), start, &mut scratch.windows[0]);
            if let Some(second) = &sensor.second {
                let lit = LitProfile { camera: &sensor.camera, geometry: &sensor.geometry, band, profile };
                second.add(&lit, tile, scratch);
            }
        }
    }
    mixed_columns::mix(&own.mixed, tile, &mut scratch.windows[0]);
}

/// Median height of every fourth column of a tile, of those that laser and lens reach where there are some [mm]; a narrow
/// ridge in the middle of a tile does not change what the rest of it sees.
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
