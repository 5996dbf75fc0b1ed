//! The inner loops: one tile of columns in one exposure.
//!
//! For each fixed width j the line spread along the rows is source_j(column) G_j(row) exit_j(column, row), where the
//! source stands under the laser and the exit in the row of the specimen that this sensor row looks at. Gaussians on
//! whole rows follow by recursion from the middle outwards, g(d + 1) = g(d) q(d), q(d + 1) = q(d) exp(-1 / sigma^2),
//! whose relative error after 22 rows is under 1e-4. docs/performance.md counts operations and bytes.

use multiversion::multiversion;

use super::row::Row;
use super::speckle::{self, FINE, TURN};
use super::{Band, Sensor, TILE};
use crate::frame::Frame;
use crate::lanes::{exp, normals};
use crate::transport::kernel::{BASIS, SPREAD_MM};

/// Rows of the window around the line.
pub const ROWS: usize = 44;
/// Row of the window that holds the line's centre.
pub const CENTRE: usize = 22;
/// Standard deviations of a Gaussian beyond which it is left out: 1e-9 of its peak.
const REACH: f32 = 6.5;
/// Largest number of columns of a sensor, for counters of noise.
const COUNTER_COLUMNS: u32 = 1 << 14;

/// Electrons of a window before noise, and where it lies.
#[derive(Debug, Clone)]
pub struct Scratch {
    /// Light from below `[ROWS][TILE]` [e-].
    volume: Box<[[f32; TILE]; ROWS]>,
    /// Light from the surface `[ROWS][TILE]` [e-].
    surface: Box<[[f32; TILE]; ROWS]>,
    /// Sensor row of the window's first row, a column [px].
    first_row: [i32; TILE],
    columns: usize,
}

impl Default for Scratch {
    fn default() -> Self {
        let rows = || Box::new([[0.0; TILE]; ROWS]);
        Self { volume: rows(), surface: rows(), first_row: [0; TILE], columns: 0 }
    }
}

impl Scratch {
    /// Electrons without noise in row `k` of the window [e-].
    pub fn electrons(&self, k: usize, column: usize) -> f32 {
        self.volume[k][column] + self.surface[k][column]
    }
}

/// Columns `start..` of a row, which is padded to whole tiles.
#[inline(always)]
fn load(values: &[f32], start: usize) -> &[f32; TILE] {
    values[start..].first_chunk().expect("rows are padded to whole tiles")
}

/// Fills `scratch` with the electrons of one tile.
pub fn window(sensor: &Sensor, band: &Band, profile: usize, tile: usize, scratch: &mut Scratch) {
    let start = tile * TILE;
    let own = band.row(profile);
    scratch.columns = (own.hits.len() - start).min(TILE);
    match band.window(profile) {
        Some(window) => {
            lines(own, start, scratch);
            let padded = window.len() / ROWS;
            for (k, row) in scratch.volume.iter_mut().enumerate() {
                *row = *load(window, k * padded + start);
            }
        }
        None => {
            let neighbours: [&Row; ROWS] = std::array::from_fn(|k| band.neighbour(profile, sensor.neighbours[k]));
            spread(own, &neighbours, start, scratch);
        }
    }
}

/// Light that the surface throws back, and where the windows lie; darkens the volume.
#[inline(always)]
fn lines(own: &Row, start: usize, scratch: &mut Scratch) -> [f32; TILE] {
    let centre = load(&own.centre, start);
    let mut phase = [0.0f32; TILE];
    for c in 0..TILE {
        let whole = centre[c].floor();
        phase[c] = whole - centre[c];
        scratch.first_row[c] = whole as i32 - CENTRE as i32;
    }
    for k in 0..ROWS {
        scratch.volume[k] = [0.0; TILE];
        scratch.surface[k] = [0.0; TILE];
    }
    let (variance, glare) = (load(&own.variance, start), load(&own.glare, start));
    Walk::new(&phase, variance).add(glare, |_| &EVERYWHERE, &mut scratch.surface);
    phase
}

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn spread(own: &Row, neighbours: &[&Row; ROWS], start: usize, scratch: &mut Scratch) {
    let rows_per_mm = load(&own.rows_per_mm, start);
    let variance = load(&own.variance, start);
    let phase = lines(own, start, scratch);
    for j in 0..BASIS {
        let source = load(&own.source[j], start);
        if source.iter().all(|&s| s == 0.0) {
            continue;
        }
        let shift = load(&own.shift[j], start);
        let (mut wide, mut place) = (*variance, phase);
        for c in 0..TILE {
            let sigma = SPREAD_MM[j] * rows_per_mm[c];
            wide[c] += sigma * sigma;
            place[c] -= shift[c];
        }
        let exit = |k: usize| load(&neighbours[k].exit[j], start);
        Walk::new(&place, &wide).add(source, exit, &mut scratch.volume);
    }
}

/// The exit of light that the surface throws back.
const EVERYWHERE: [f32; TILE] = [1.0; TILE];

/// Gaussians of one tile, stepped from row to row.
struct Walk {
    middle: [f32; TILE],
    up: [f32; TILE],
    down: [f32; TILE],
    ratio: [f32; TILE],
    reach: usize,
}

impl Walk {
    /// `phase` is the distance from the line's centre to the window's middle row [px].
    #[inline(always)]
    fn new(phase: &[f32; TILE], variance: &[f32; TILE]) -> Self {
        let mut walk = Self { middle: [0.0; TILE], up: [0.0; TILE], down: [0.0; TILE], ratio: [0.0; TILE], reach: 0 };
        let mut widest = 0.0f32;
        for c in 0..TILE {
            let v = variance[c].max(0.05);
            let half = 0.5 / v;
            let d = phase[c];
            // 1 / sqrt(2 pi v)
            walk.middle[c] = 0.398_942_3 / v.sqrt() * exp(-d * d * half);
            walk.up[c] = exp(-(2.0 * d + 1.0) * half);
            walk.down[c] = exp((2.0 * d - 1.0) * half);
            walk.ratio[c] = exp(-2.0 * half);
            widest = widest.max(v);
        }
        walk.reach = (REACH * widest.sqrt() + 1.0).min(CENTRE as f32) as usize;
        walk
    }

    /// Adds source x Gaussian x exit to every row of the window in reach.
    #[inline(always)]
    fn add<'a>(&self, source: &[f32; TILE], exit: impl Fn(usize) -> &'a [f32; TILE], out: &mut [[f32; TILE]; ROWS]) {
        let (middle, row) = (exit(CENTRE), &mut out[CENTRE]);
        let mut start = [0.0f32; TILE];
        for c in 0..TILE {
            start[c] = source[c] * self.middle[c];
            row[c] += start[c] * middle[c];
        }
        let step = |g: &mut [f32; TILE], q: &mut [f32; TILE], exit: &[f32; TILE], row: &mut [f32; TILE]| {
            for c in 0..TILE {
                g[c] *= q[c];
                q[c] *= self.ratio[c];
                row[c] += g[c] * exit[c];
            }
        };
        let (mut g, mut q) = (start, self.up);
        for k in CENTRE + 1..(CENTRE + self.reach + 1).min(ROWS) {
            step(&mut g, &mut q, exit(k), &mut out[k]);
        }
        let (mut g, mut q) = (start, self.down);
        for k in (CENTRE - self.reach..CENTRE).rev() {
            step(&mut g, &mut q, exit(k), &mut out[k]);
        }
    }
}

/// Adds speckle and noise to the electrons in `scratch` and writes them to `frame`.
pub fn digitise(sensor: &Sensor, profile: usize, tile: usize, offsets: &[f32], scratch: &Scratch, frame: &mut Frame) {
    let columns = scratch.columns;
    frame.cols = columns;
    frame.rows = ROWS;
    frame.first_col = tile * TILE;
    frame.first_row.clear();
    frame.first_row.extend_from_slice(&scratch.first_row[..columns]);
    frame.dn.resize(ROWS * columns, 0);
    let level = scratch.first_row[..columns].iter().all(|&row| row == scratch.first_row[0]);
    let keys = sensor.chain.keys("pixels", profile);
    let base = (profile as f64 * sensor.drift).round() as i64;
    let counter = tile as u32 * TILE as u32;
    for pair in 0..ROWS / 2 {
        let rows = [2 * pair, 2 * pair + 1];
        let patterns = rows.map(|k| {
            let fine = base - (k as i64 - CENTRE as i64) * FINE as i64;
            let place = fine + speckle::offset(sensor.speckle_key, tile, fine.div_euclid(TURN));
            [sensor.tiles[0].row(place), sensor.tiles[1].row(place + TURN / 2)]
        });
        let shades = rows.map(|k| row_offsets(offsets, &scratch.first_row, k, level));
        let (even, odd) = frame.dn[rows[0] * columns..][..2 * columns].split_at_mut(columns);
        let pixels = PairOfRows {
            electrons: rows.map(|k| [&scratch.surface[k], &scratch.volume[k]]),
            patterns,
            shades: &shades,
            counter: pair as u32 * COUNTER_COLUMNS + counter,
            keys,
        };
        pixels.write(sensor, even, odd);
    }
}

/// Row offsets of a window row, a column; sensor rows beyond the edge take the edge's.
#[inline(always)]
fn row_offsets(offsets: &[f32], first_row: &[i32; TILE], k: usize, level: bool) -> [f32; TILE] {
    let last = offsets.len() as i32 - 1;
    let at = |row: i32| offsets[(row + k as i32).clamp(0, last) as usize];
    if level { [at(first_row[0]); TILE] } else { std::array::from_fn(|c| at(first_row[c])) }
}

struct PairOfRows<'a> {
    /// Surface and volume electrons of both rows [e-].
    electrons: [[&'a [f32; TILE]; 2]; 2],
    /// Surface and volume patterns of both rows.
    patterns: [[&'a [f32; TILE]; 2]; 2],
    shades: &'a [[f32; TILE]; 2],
    counter: u32,
    keys: [u32; 2],
}

impl PairOfRows<'_> {
    fn write(&self, sensor: &Sensor, even: &mut [u8], odd: &mut [u8]) {
        pair(self, sensor, even, odd);
    }
}

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn pair(pixels: &PairOfRows<'_>, sensor: &Sensor, even: &mut [u8], odd: &mut [u8]) {
    let (chain, [glint, grain]) = (&sensor.chain, sensor.contrast);
    let mut out = [[0u8; TILE]; 2];
    for c in 0..TILE {
        let (first, second) = normals(pixels.counter + c as u32, pixels.keys);
        let signal = |row: usize| {
            let [surface, volume] = pixels.electrons[row];
            let [bright, soft] = pixels.patterns[row];
            let light = surface[c] * (1.0 + glint * bright[c]) + volume[c] * (1.0 + grain * soft[c]);
            (chain.gain * light).max(0.0)
        };
        out[0][c] = chain.digitise(signal(0), first, pixels.shades[0][c]);
        out[1][c] = chain.digitise(signal(1), second, pixels.shades[1][c]);
    }
    even.copy_from_slice(&out[0][..even.len()]);
    odd.copy_from_slice(&out[1][..odd.len()]);
}
