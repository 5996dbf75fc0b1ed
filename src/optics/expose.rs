//! The inner loops: one tile of columns in one exposure.
//!
//! For each fixed width j the line spread along the rows is source_j(column) G_j(row) exit_j(column, row), where the
//! source stands under the laser and the exit in the row of the specimen that this sensor row looks at (`super::gaussian_stepper`).
//! docs/performance.md counts operations and bytes.

use multiversion::multiversion;

use super::blooming::WindowSignal;
use super::film::TransmittedLine;
use super::gaussian_stepper::{CompositeLine, GaussianStepper, UNIT_EXIT, add_line};
use super::laser::LineProfile;
use super::motion_blur::{self, NextProfile};
use super::row::Row;
use super::{Band, Sensor, TILE, ambient, compositing, streak};
use crate::transport::kernel::{BASIS, SPREAD_MM};

/// Rows of the window around the line.
pub const ROWS: usize = 44;
/// Row of the window that holds the line's centre.
pub const CENTRE: usize = 22;

/// Electrons of one window before noise, and where it lies.
#[derive(Debug, Clone)]
pub struct Window {
    /// Light from below `[ROWS][TILE]` [e-].
    pub volume: Box<[[f32; TILE]; ROWS]>,
    /// Light from the surface `[ROWS][TILE]` [e-].
    pub surface: Box<[[f32; TILE]; ROWS]>,
    /// Light of ambient and windows `[ROWS][TILE]`; empty without [e-].
    pub ambient: Vec<[f32; TILE]>,
    /// Sensor row of the window's first row, a column [px].
    pub first_row: [i32; TILE],
}

impl Default for Window {
    fn default() -> Self {
        let rows = || Box::new([[0.0; TILE]; ROWS]);
        Self { volume: rows(), surface: rows(), ambient: Vec::new(), first_row: [0; TILE] }
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
    /// Room for signals on their way to numbers.
    pub signal: WindowSignal,
    /// The next profile's light, where the object moves while it is exposed.
    pub next: Option<Box<NextProfile>>,
}

impl Scratch {
    /// Electrons of the laser without noise in row `k` of the first window [e-].
    pub fn electrons(&self, k: usize, column: usize) -> f32 {
        self.windows[0].volume[k][column] + self.windows[0].surface[k][column]
    }
}

/// Columns `start..` of a row, which is padded to whole tiles.
#[inline(always)]
pub fn load(values: &[f32], start: usize) -> &[f32; TILE] {
    values[start..].first_chunk().expect("rows are padded to whole tiles")
}

/// Fills `scratch` with the electrons of one tile, as they are when the shutter closes.
pub fn window(sensor: &Sensor, band: &Band, profile: usize, tile: usize, scratch: &mut Scratch) {
    if sensor.way > 0.0 {
        motion_blur::window(sensor, band, profile, tile, scratch);
    } else {
        still(sensor, band, profile, tile, scratch);
    }
    ambient::add(sensor, band, profile, tile, scratch);
}

/// The same of an object that stands still under the laser alone.
pub fn still(sensor: &Sensor, band: &Band, profile: usize, tile: usize, scratch: &mut Scratch) {
    let start = tile * TILE;
    let own = band.row(profile);
    scratch.columns = (own.hits.len() - start).min(TILE);
    scratch.used = 1;
    let first = &mut scratch.windows[0];
    match band.window(profile) {
        Some(window) => {
            let line =
                LineShape { centre: load(&own.centre, start), blur: 0.0, section: sensor.camera.laser.line_profile() };
            lines(own, start, &line, load(&own.variance, start), first);
            let padded = window.len() / ROWS;
            for (k, row) in first.volume.iter_mut().enumerate() {
                *row = *load(window, k * padded + start);
            }
        }
        None => {
            let offsets = band.offsets.get(profile - band.profiles.start).unwrap_or(&sensor.neighbours);
            let neighbours: [&Row; ROWS] = std::array::from_fn(|k| band.neighbour(profile, offsets[k]));
            let line =
                LineShape { centre: load(&own.centre, start), blur: 0.0, section: sensor.camera.laser.line_profile() };
            spread(own, &neighbours, start, &line, first);
            if let Some(secondary) = &own.secondary {
                compositing::composite(secondary, tile, scratch);
            }
            streak::draw(streak::near_tile(&own.streaks, tile), start, &mut scratch.windows[0]);
            if let Some(second) = &sensor.second {
                second.add(sensor, band, profile, tile, scratch);
            }
        }
    }
}

/// How the line of a row is drawn.
#[derive(Debug, Clone, Copy)]
pub struct LineShape<'a> {
    /// Sensor row of its middle, a column of the tile [px].
    pub centre: &'a [f32; TILE],
    /// Variance on top of the row's own [px^2].
    pub blur: f32,
    /// What it is across, where that is more than one Gaussian.
    pub section: Option<&'a LineProfile>,
}

/// Light that the surface throws back, and where the windows lie; darkens the volume.
#[inline(always)]
fn lines(own: &Row, start: usize, line: &LineShape<'_>, variance: &[f32; TILE], window: &mut Window) -> [f32; TILE] {
    let phase = place(line.centre, window);
    let glare = load(&own.surface_light, start);
    let exit = |_| &UNIT_EXIT;
    match line.section {
        None => add_line(&phase, variance, glare, exit, own.defocus_radius_of(start), &mut window.surface),
        Some(section) => {
            let across = CompositeLine { own, start, section, level: section.mixture(None) };
            across.add(&phase, variance, glare, exit, &mut window.surface);
        }
    }
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

/// Draws the line of `own` and what `neighbours`, a row of the window each, let out of its light.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
pub fn spread(own: &Row, neighbours: &[&Row; ROWS], start: usize, line: &LineShape<'_>, window: &mut Window) {
    let rows_per_mm = load(&own.rows_per_mm, start);
    let mut variance = *load(&own.variance, start);
    for c in 0..TILE {
        variance[c] += line.blur;
    }
    let phase = lines(own, start, line, &variance, window);
    for j in 0..BASIS {
        let source = load(&own.source[j], start);
        if source.iter().all(|&s| s == 0.0) {
            continue;
        }
        let shift = load(&own.shift[j], start);
        let (mut wide, mut place) = (variance, phase);
        for c in 0..TILE {
            let sigma = SPREAD_MM[j] * rows_per_mm[c];
            wide[c] += sigma * sigma;
            place[c] -= shift[c];
        }
        let exit = |k: usize| neighbours[k].leaves(j, start, k > CENTRE);
        match line.section {
            None => add_line(&place, &wide, source, exit, own.defocus_radius_of(start), &mut window.volume),
            Some(section) => {
                let across = CompositeLine { own, start, section, level: section.mixture(Some(j)) };
                across.add(&place, &wide, source, exit, &mut window.volume);
            }
        }
    }
}

/// Draws the line that is seen through a film in a window of its own.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
pub fn through(second: &TransmittedLine, start: usize, window: &mut Window) {
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
        GaussianStepper::new(&phase, &wide).add(source, |_| &UNIT_EXIT, &mut window.volume);
    }
}
