//! The inner loops: one tile of columns in one exposure.
//!
//! For each fixed width j the line spread along the rows is source_j(column) G_j(row) exit_j(column, row), where the
//! source stands under the laser and the exit in the row of the specimen that this sensor row looks at. Gaussians on
//! whole rows follow by recursion from the middle outwards, g(d + 1) = g(d) q(d), q(d + 1) = q(d) exp(-1 / sigma^2),
//! whose relative error after 22 rows is under 1e-4. docs/performance.md counts operations and bytes.

use multiversion::multiversion;

use super::film::Second;
use super::row::Row;
use super::{Band, Sensor, TILE, arrange};
use crate::lanes::exp;
use crate::transport::kernel::{BASIS, SPREAD_MM};

/// Rows of the window around the line.
pub const ROWS: usize = 44;
/// Row of the window that holds the line's centre.
pub const CENTRE: usize = 22;
/// Standard deviations of a Gaussian beyond which it is left out: 1e-9 of its peak.
const REACH: f32 = 6.5;
/// Electrons of one window before noise, and where it lies.
#[derive(Debug, Clone)]
pub struct Window {
    /// Light from below `[ROWS][TILE]` [e-].
    pub volume: Box<[[f32; TILE]; ROWS]>,
    /// Light from the surface `[ROWS][TILE]` [e-].
    pub surface: Box<[[f32; TILE]; ROWS]>,
    /// Sensor row of the window's first row, a column [px].
    pub first_row: [i32; TILE],
}

impl Default for Window {
    fn default() -> Self {
        let rows = || Box::new([[0.0; TILE]; ROWS]);
        Self { volume: rows(), surface: rows(), first_row: [0; TILE] }
    }
}

impl Window {
    /// Takes all light away.
    #[inline(always)]
    pub fn darken(&mut self) {
        for k in 0..ROWS {
            self.volume[k] = [0.0; TILE];
            self.surface[k] = [0.0; TILE];
        }
    }
}

/// Electrons of a tile's windows.
#[derive(Debug, Clone, Default)]
pub struct Scratch {
    /// About the line that the camera will read, and beside it.
    pub windows: [Window; 2],
    /// How many of them hold light.
    pub used: usize,
    /// Columns of the tile that the sensor has.
    pub columns: usize,
    /// Room for a line in a window of its own.
    pub spare: Window,
}

impl Scratch {
    /// Electrons without noise in row `k` of the first window [e-].
    pub fn electrons(&self, k: usize, column: usize) -> f32 {
        self.windows[0].volume[k][column] + self.windows[0].surface[k][column]
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
    scratch.used = 1;
    let first = &mut scratch.windows[0];
    match band.window(profile) {
        Some(window) => {
            lines(own, start, first);
            let padded = window.len() / ROWS;
            for (k, row) in first.volume.iter_mut().enumerate() {
                *row = *load(window, k * padded + start);
            }
        }
        None => {
            let offsets = band.offsets.get(profile - band.profiles.start).unwrap_or(&sensor.neighbours);
            let neighbours: [&Row; ROWS] = std::array::from_fn(|k| band.neighbour(profile, offsets[k]));
            spread(own, &neighbours, start, first);
            if let Some(beside) = &own.beside {
                arrange::arrange(beside, tile, scratch);
            }
        }
    }
}

/// Light that the surface throws back, and where the windows lie; darkens the volume.
#[inline(always)]
fn lines(own: &Row, start: usize, window: &mut Window) -> [f32; TILE] {
    let phase = place(load(&own.centre, start), window);
    let (variance, glare) = (load(&own.variance, start), load(&own.glare, start));
    Walk::new(&phase, variance).add(glare, |_| &EVERYWHERE, &mut window.surface);
    phase
}

/// Puts a dark window about lines at `centre`; the distance from each line to the window's middle row [px].
#[inline(always)]
fn place(centre: &[f32; TILE], window: &mut Window) -> [f32; TILE] {
    let mut phase = [0.0f32; TILE];
    for c in 0..TILE {
        let whole = centre[c].floor();
        phase[c] = whole - centre[c];
        window.first_row[c] = whole as i32 - CENTRE as i32;
    }
    window.darken();
    phase
}

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn spread(own: &Row, neighbours: &[&Row; ROWS], start: usize, window: &mut Window) {
    let rows_per_mm = load(&own.rows_per_mm, start);
    let variance = load(&own.variance, start);
    let phase = lines(own, start, window);
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
        Walk::new(&place, &wide).add(source, exit, &mut window.volume);
    }
}

/// Draws the line that is seen through a film in a window of its own.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
pub fn through(second: &Second, start: usize, window: &mut Window) {
    let phase = place(load(&second.centre, start), window);
    let (rows_per_mm, variance) = (load(&second.rows_per_mm, start), load(&second.variance, start));
    for j in 0..BASIS {
        let source = load(&second.source[j], start);
        if source.iter().all(|&s| s == 0.0) {
            continue;
        }
        let mut wide = *variance;
        for c in 0..TILE {
            let sigma = SPREAD_MM[j] * rows_per_mm[c];
            wide[c] += sigma * sigma;
        }
        Walk::new(&phase, &wide).add(source, |_| &EVERYWHERE, &mut window.volume);
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
