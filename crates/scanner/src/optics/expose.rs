//! Exposure of one tile of columns: light gathers in windows of sensor rows, then becomes numbers.

use std::ops::Range;

use super::band::Band;
use super::digitise::{Digitiser, TileExposure};
use super::interreflections::Exchange;
use super::line_image::{LineShape, draw, surface_line};
use super::motion_blur::{self, MotionBlur};
use super::row::{Row, WindowNeed};
use super::second_line::LitProfile;
use super::sensor::Sensor;
use super::speckle::TILE;
use super::window::{CENTRE, ExposureKey, ROWS, Scratch, load};
use super::{ambient, compositing, mixed_columns, streak};
use crate::extract::{MeasuredProfile, extract, reach};
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
        let left_out = self.expose_to_read(part, settings, scratch, frames);
        let peaks = extract(frames, calibration, settings, out);
        if left_out.is_some_and(|greatest| !peaks.outshine(greatest, settings)) {
            self.expose(part, scratch, frames);
            extract(frames, calibration, settings, out);
        }
    }

    /// [`Self::expose`], but only the rows that `settings` read about the line, the same to the bit, where they tell what
    /// the others can hold. Returns the digital number that no pixel of these exceeds, but for one in 10^12; `None` where all
    /// rows are there.
    pub fn expose_to_read(
        &self,
        part: &TileOfProfile<'_>,
        settings: &Extraction,
        scratch: &mut Scratch,
        frames: &mut [Frame; 2],
    ) -> Option<f32> {
        let rows = reading_rows(settings);
        let beyond = (rows.len() < ROWS && self.is_line_alone(part)).then(|| self.light_beyond(part, &rows)).flatten();
        let Some(beyond) = beyond else {
            self.expose(part, scratch, frames);
            return None;
        };
        still(self, part.band, part.profile, part.tile, rows, scratch);
        scratch.windows.iter_mut().for_each(|window| window.ambient.clear());
        self.digitise(part, scratch, frames);
        let [surface, volume] = self.speckle.contrast();
        // Light of short paths, as from knots, keeps more contrast than that of the wood that the patterns are made for.
        let contrasts = part.band.row(part.profile).contrasts_of(part.tile);
        let most = contrasts.as_flattened().iter().fold(1.0, |most: f32, contrast| most.max(*contrast));
        Some(self.chain.greatest_dn(beyond * brightest_speckle(surface.max(most * volume))))
    }

    /// Whether a tile shows nothing but a line that is one Gaussian and what spreads from it, on pixels that don't depend on
    /// each other.
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
            && mixed_columns::of_tile(&row.mixed, tile).is_empty()
            && streak::near_tile(&row.streaks, tile).is_empty()
    }

    /// A bound on the light of the line in the rows of a tile's window that are not among `rows` [e-]; `None` where front faces
    /// let some of it out.
    fn light_beyond(&self, part: &TileOfProfile<'_>, rows: &Range<usize>) -> Option<f32> {
        let TileOfProfile { band, profile, tile, .. } = *part;
        let offsets = band.neighbours(profile, &self.geometry);
        let mut exits = [0.0; BASIS];
        for k in (0..rows.start).chain(rows.end..ROWS) {
            let row = band.neighbour(profile, offsets[k]);
            if row.front_of(tile * TILE).is_some() {
                return None;
            }
            row.extremes[tile].raise(&mut exits);
        }
        // The line's centre lies up to a row behind the window's middle row.
        let away = (CENTRE + 1 - rows.start).min(rows.end - CENTRE - 1);
        Some(band.row(profile).extremes[tile].light_beyond(away as f32, &exits))
    }

    /// Makes numbers of the light in `scratch`.
    fn digitise(&self, part: &TileOfProfile<'_>, scratch: &mut Scratch, frames: &mut [Frame; 2]) {
        let TileOfProfile { band, profile, tile, offsets } = *part;
        let row = band.row(profile);
        let hits = &row.hits[tile * TILE..][..scratch.columns];
        let place = [hits[scratch.columns / 2].x, median_height(hits)].map(f64::from);
        // Speckle moves as far as the object does here.
        let way = self.position(profile) * self.turn.map_or(1.0, |turn| turn.share(place[0]));
        let exposure = TileExposure { profile, tile, columns: scratch.columns, place, way, offsets };
        let digitiser = Digitiser { chain: &self.chain, speckle: &self.speckle, contrasts: row.contrasts_of(tile) };
        frames[1].rows = 0;
        for number in 0..scratch.used {
            let window = &scratch.windows[number];
            digitiser.digitise(&exposure, number, window, &mut scratch.signal, &mut frames[number]);
        }
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

/// Factor on light that speckle of this contrast exceeds once in 10^12: a fully developed pattern, 27 above its mean of 1, of which paths
/// or pixels leave that contrast. Means over pixels or looks have thinner tails.
fn brightest_speckle(contrast: f32) -> f32 {
    1.0 + 27.0 * contrast
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
            let offsets = band.neighbours(profile, &sensor.geometry);
            let neighbours: [&Row; ROWS] = std::array::from_fn(|k| band.neighbour(profile, offsets[k]));
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
