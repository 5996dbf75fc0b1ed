//! Exposure of one tile of columns: light gathers in windows of sensor rows, then becomes numbers.

use super::band::Band;
use super::digitise::{Digitiser, TileExposure};
use super::line_image::{LineShape, draw, surface_line};
use super::motion_blur::{self, MotionBlur};
use super::row::Row;
use super::second_line::LitProfile;
use super::sensor::Sensor;
use super::speckle::TILE;
use super::window::{ExposureKey, ROWS, Scratch, load};
use super::{ambient, compositing, mixed_columns, streak};
use crate::frame::Frame;
use crate::specimen::Hit;

impl Sensor {
    /// Exposes columns `tile * TILE ..` of `profile`; `offsets` come from [`Self::row_offsets`]. The second frame has no
    /// rows where one window holds all light.
    pub fn expose(
        &self,
        band: &Band,
        profile: usize,
        tile: usize,
        offsets: &[f32],
        scratch: &mut Scratch,
        frames: &mut [Frame; 2],
    ) {
        window(self, band, profile, tile, scratch);
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
        motion_blur::window(blur, key, scratch, |profile, scratch| still(sensor, band, profile, tile, scratch));
    } else {
        still(sensor, band, profile, tile, scratch);
    }
    ambient::add(&sensor.camera, &sensor.geometry, band, profile, tile, scratch);
}

/// The same of an object that stands still under the laser alone.
fn still(sensor: &Sensor, band: &Band, profile: usize, tile: usize, scratch: &mut Scratch) {
    let start = tile * TILE;
    let own = band.row(profile);
    scratch.columns = (own.hits.len() - start).min(TILE);
    scratch.used = 1;
    let first = &mut scratch.windows[0];
    let line = LineShape { centre: load(&own.centre, start), blur: 0.0, profile: sensor.camera.laser.line_profile() };
    match band.volume(profile) {
        Some(volume) => {
            surface_line(own, start, &line, load(&own.variance, start), first);
            let padded = volume.len() / ROWS;
            for (k, row) in first.volume.iter_mut().enumerate() {
                *row = *load(volume, k * padded + start);
            }
        }
        None => {
            let offsets = band.offsets.get(profile - band.profiles.start).unwrap_or(&sensor.geometry.neighbours);
            let neighbours: [&Row; ROWS] = std::array::from_fn(|k| band.neighbour(profile, offsets[k]));
            draw(own, &neighbours, start, &line, first);
            if let Some(secondary) = &own.secondary {
                compositing::composite(secondary, tile, scratch);
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
