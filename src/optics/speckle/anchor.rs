//! Which row of which pattern a pixel sees: the pattern is anchored to the object.
//!
//! A place of the object that stands `position` mm behind the line's zero has the pattern's row position * rows per mm, so the
//! pattern moves with the object's image, 0.673 rows a profile on the default bench. It is entered at another place by
//! each tile of columns, and again each time around. What the place was worth in the pupil when it passed the line
//! is where its stack coordinate starts: in window row k it has moved on by (k - centre) rows, which [`Boil`] turns into
//! diameters of the pupil. A surface dz higher starts elsewhere. Which of two patterns of the stack a place shows between whole steps
//! goes evenly over the places.

use std::sync::Arc;

use procedural::stream::mix;

use super::boil::Boil;
use super::goodman::pixel_contrast;
use super::{SLICES, Stack, TILE, Tiles};
use crate::optics::parameters::Bench;
use crate::settings::SpeckleLaw;

/// Rows over which places go from one pattern of the stack to the next, one after the other [px].
const RAMP: usize = 64;

/// Speckle of one sample.
#[derive(Debug, Clone)]
pub struct Speckle {
    stack: Arc<Stack>,
    /// What the patterns are multiplied with, for light from the surface and from below [1].
    scale: [f32; 2],
    /// Contrast in one pixel that follows [1].
    contrast: [f32; 2],
    /// Movement of the pattern with the object [px/mm].
    rows_per_mm: f64,
    /// Height at which stacks start at their first pattern [mm].
    height: f64,
    boil: Boil,
    key: u64,
}

/// What decides the speckle of a sample beside its bench.
#[derive(Debug, Clone, Copy)]
pub struct Ground {
    /// Grain L = lambda times the working f-number [px].
    pub grain: f64,
    /// Movement of the image with the object [px/mm].
    pub rows_per_mm: f64,
    /// Height of the object [mm].
    pub height: f64,
    /// Contrast that is left after paths of unlike length below the surface [1].
    pub paths: f64,
    /// Way of the image over the sensor while the shutter is open [px].
    pub way: f64,
}

impl Speckle {
    /// Under a bench; `key` belongs to the sample.
    pub fn new(bench: &Bench, ground: &Ground, law: SpeckleLaw, tiles: &Tiles, key: u64) -> Self {
        let (speckle, grain) = (&bench.speckle, ground.grain);
        // Equal independent patterns as far as the contrast says so: 1 / C^2 of them.
        let below = speckle.volume_patterns / (ground.paths * ground.paths);
        let patterns = [speckle.surface_patterns, below];
        let stack = tiles.get(grain, law, patterns);
        let own = pixel_contrast(stack.grain(), law, 0.0);
        let developed = pixel_contrast(grain, law, ground.way) * speckle.strength;
        let contrast = patterns.map(|n| developed / n.sqrt());
        let scale = [0, 1].map(|i| (contrast[i] / own * (stack.looks()[i] as f64).sqrt()) as f32);
        Self {
            stack,
            scale,
            contrast: contrast.map(|c| c as f32),
            rows_per_mm: ground.rows_per_mm,
            height: ground.height,
            boil: Boil::new(bench),
            key,
        }
    }

    /// Contrast in one pixel of light from the surface and from below [1].
    pub fn contrast(&self) -> [f32; 2] {
        self.contrast
    }

    /// What the patterns are multiplied with, for light from the surface and from below [1].
    pub fn scale(&self) -> [f32; 2] {
        self.scale
    }

    /// What tile `tile` sees around `place` (x, z) [mm] of the laser plane when the object has moved by `position` [mm];
    /// `rows_aside` enters the pattern elsewhere [px].
    pub fn view(&self, tile: usize, place: [f64; 2], position: f64, rows_aside: usize) -> View<'_> {
        let pupil = SLICES as f64 / 2.0;
        let (fine, round) = (self.stack.fine(), self.stack.rows());
        let base = (position * self.rows_per_mm * fine as f64).round() as i64 + (rows_aside * fine) as i64;
        let (turn, key) = (base.div_euclid(round as i64), mix(self.key ^ mix(tile as u64)));
        let offset = |turn: i64| (mix(key ^ turn as u64) % round as u64) as usize;
        let start = (pupil * self.boil.rise(place[1] - self.height)).rem_euclid(SLICES as f64);
        View {
            stack: &self.stack,
            row: base.rem_euclid(round as i64) as usize,
            offsets: [-1, 0, 1].map(|next| offset(turn + next)),
            // Whole rounds of the stack keep it above 0.
            start: (start + (64 * SLICES) as f64) as f32,
            slices_per_row: (pupil * self.boil.diameters(place, [0.0, 1.0 / self.rows_per_mm])) as f32,
            per_fine: 1.0 / (RAMP * fine) as f32,
        }
    }
}

/// The speckle of one tile in one exposure.
#[derive(Debug, Clone, Copy)]
pub struct View<'a> {
    stack: &'a Stack,
    /// Fine row of the pattern on the line.
    row: usize,
    /// Where the pattern is entered the time around before, this one and the next [fine rows].
    offsets: [usize; 3],
    /// Stack coordinate on the line, and its growth from row to row [1, 1/px].
    start: f32,
    slices_per_row: f32,
    /// Share of a step of the stack from one fine row to the next [1].
    per_fine: f32,
}

impl View<'_> {
    /// The pattern less its mean of 1, `rows` of the window behind the line, no more than a round of it: of light from
    /// the surface and from below.
    #[inline(always)]
    pub fn row(&self, rows: i64) -> [&[f32; TILE]; 2] {
        let (fine, round) = (self.stack.fine(), self.stack.rows());
        // A round ahead, so that it is above 0.
        let row = (self.row + round).wrapping_add_signed(-(rows as isize) * fine as isize);
        let (turn, row) = if row < round {
            (0, row)
        } else if row < 2 * round {
            (1, row - round)
        } else {
            (2, row - 2 * round)
        };
        let ramp = if row < RAMP * fine { row } else { row - RAMP * fine };
        let slice = (self.start + self.slices_per_row * rows as f32 + ramp as f32 * self.per_fine) as usize;
        let place = row + self.offsets[turn];
        self.stack.at(slice % SLICES, if place < round { place } else { place - round })
    }
}
