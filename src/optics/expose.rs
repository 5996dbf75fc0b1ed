//! The inner loops: one tile of columns in one exposure.
//!
//! For each fixed width j the line spread along the rows is source_j(column) G_j(row) exit_j(column, row), where the
//! source stands under the laser and the exit in the row of the specimen that this sensor row looks at. Gaussians on
//! whole rows follow by recursion from the middle outwards, g(d + 1) = g(d) q(d), q(d + 1) = q(d) exp(-1 / sigma^2),
//! whose relative error after 22 rows is under 1e-4. docs/performance.md counts operations and bytes. A narrow Gaussian
//! on whole rows sums to 1 + 2 exp(-2 pi^2 v) cos(2 pi d) + ... (Poisson's sum), by which it is divided. What is more than
//! one Gaussian across the line is drawn strand by strand ([`Section`]).

use multiversion::multiversion;

use super::film::Second;
use super::laser::{Level, Section};
use super::moved::{self, Ahead};
use super::overflow::Charge;
use super::row::Row;
use super::{Band, Sensor, TILE, arrange, disc, lamps, streak};
use crate::lanes::{exp, turn};
use crate::transport::kernel::{BASIS, SPREAD_MM};

/// Rows of the window around the line.
pub const ROWS: usize = 44;
/// Row of the window that holds the line's centre.
pub const CENTRE: usize = 22;
/// Standard deviations of a Gaussian beyond which it is left out: 1e-9 of its peak.
const REACH: f32 = 6.5;
/// Variance over which a Gaussian on whole rows sums to 1 within 1e-4 [px^2].
const NARROW: f32 = 0.5;
/// Exponent at which a Gaussian is too faint to be stepped from there.
const FAINT: f32 = 60.0;

/// Electrons of one window before noise, and where it lies.
#[derive(Debug, Clone)]
pub struct Window {
    /// Light from below `[ROWS][TILE]` [e-].
    pub volume: Box<[[f32; TILE]; ROWS]>,
    /// Light from the surface `[ROWS][TILE]` [e-].
    pub surface: Box<[[f32; TILE]; ROWS]>,
    /// Light of lamps and windows `[ROWS][TILE]`; empty without [e-].
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
    pub charge: Charge,
    /// The next profile's light, where the object moves while it is exposed.
    pub ahead: Option<Box<Ahead>>,
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
        moved::window(sensor, band, profile, tile, scratch);
    } else {
        still(sensor, band, profile, tile, scratch);
    }
    lamps::add(sensor, band, profile, tile, scratch);
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
            let line = Line { centre: load(&own.centre, start), blur: 0.0, section: sensor.camera.laser.section() };
            lines(own, start, &line, load(&own.variance, start), first);
            let padded = window.len() / ROWS;
            for (k, row) in first.volume.iter_mut().enumerate() {
                *row = *load(window, k * padded + start);
            }
        }
        None => {
            let offsets = band.offsets.get(profile - band.profiles.start).unwrap_or(&sensor.neighbours);
            let neighbours: [&Row; ROWS] = std::array::from_fn(|k| band.neighbour(profile, offsets[k]));
            let line = Line { centre: load(&own.centre, start), blur: 0.0, section: sensor.camera.laser.section() };
            spread(own, &neighbours, start, &line, first);
            if let Some(beside) = &own.beside {
                arrange::arrange(beside, tile, scratch);
            }
            streak::draw(own.streaks_of(tile), start, &mut scratch.windows[0]);
            if let Some(second) = &sensor.second {
                second.add(sensor, band, profile, tile, scratch);
            }
        }
    }
}

/// How the line of a row is drawn.
#[derive(Debug, Clone, Copy)]
pub struct Line<'a> {
    /// Sensor row of its middle, a column of the tile [px].
    pub centre: &'a [f32; TILE],
    /// Variance on top of the row's own [px^2].
    pub blur: f32,
    /// What it is across, where that is more than one Gaussian.
    pub section: Option<&'a Section>,
}

/// Light that the surface throws back, and where the windows lie; darkens the volume.
#[inline(always)]
fn lines(own: &Row, start: usize, line: &Line<'_>, variance: &[f32; TILE], window: &mut Window) -> [f32; TILE] {
    let phase = place(line.centre, window);
    let glare = load(&own.glare, start);
    let exit = |_| &EVERYWHERE;
    match line.section {
        None => one(&phase, variance, glare, exit, own.disc_of(start), &mut window.surface),
        Some(section) => {
            let across = Across { own, start, section, level: section.level(None) };
            across.add(&phase, variance, glare, exit, &mut window.surface);
        }
    }
    phase
}

/// The line of a tile that is more than one Gaussian.
struct Across<'a> {
    own: &'a Row,
    start: usize,
    section: &'a Section,
    level: &'a Level,
}

impl Across<'_> {
    /// Adds all strands of a line whose middle has `phase` and `variance`.
    #[inline(always)]
    fn add<'a>(
        &self,
        phase: &[f32; TILE],
        variance: &[f32; TILE],
        source: &[f32; TILE],
        exit: impl Fn(usize) -> &'a [f32; TILE] + Copy,
        out: &mut [[f32; TILE]; ROWS],
    ) {
        let unit = load(&self.own.unit, self.start);
        for (number, strand) in self.level.strands.iter().enumerate() {
            let (mut place, mut wide, mut light) = (*phase, *variance, *source);
            for c in 0..TILE {
                place[c] += strand.offset * unit[c];
                wide[c] += (strand.variance - self.section.core()) * unit[c] * unit[c];
                light[c] *= strand.weight;
            }
            if self.level.varies() {
                let node = load(&self.own.node, self.start);
                for c in 0..TILE {
                    light[c] = source[c] * self.level.weight(number, node[c]);
                }
            }
            match self.own.disc_of(self.start) {
                None => anywhere(&place, &wide, &light, exit, out),
                Some(disc) => over(disc, &place, &wide, &light, exit, out),
            }
        }
    }
}

/// Adds a line that is one Gaussian, but for the disc that it is out of focus by.
#[inline(always)]
fn one<'a>(
    phase: &[f32; TILE],
    variance: &[f32; TILE],
    source: &[f32; TILE],
    exit: impl Fn(usize) -> &'a [f32; TILE] + Copy,
    disc: Option<&[f32; TILE]>,
    out: &mut [[f32; TILE]; ROWS],
) {
    match disc {
        None => Walk::new(phase, variance).add(source, exit, out),
        Some(disc) => over(disc, phase, variance, source, exit, out),
    }
}

/// Adds Gaussians blurred by discs, whose variance they have.
fn over<'a>(
    disc: &[f32; TILE],
    phase: &[f32; TILE],
    variance: &[f32; TILE],
    source: &[f32; TILE],
    exit: impl Fn(usize) -> &'a [f32; TILE] + Copy,
    out: &mut [[f32; TILE]; ROWS],
) {
    let strands = disc::strands(disc, variance);
    if strands.is_empty() {
        return anywhere(phase, variance, source, exit, out);
    }
    for [node, weight] in strands {
        let (mut place, mut rest, mut light) = (*phase, *variance, *source);
        for c in 0..TILE {
            place[c] += node * disc[c];
            rest[c] -= 0.25 * disc[c] * disc[c];
            light[c] *= weight;
        }
        anywhere(&place, &rest, &light, exit, out);
    }
}

/// Adds Gaussians whose middles may lie anywhere.
#[inline(always)]
fn anywhere<'a>(
    phase: &[f32; TILE],
    variance: &[f32; TILE],
    source: &[f32; TILE],
    exit: impl Fn(usize) -> &'a [f32; TILE],
    out: &mut [[f32; TILE]; ROWS],
) {
    match Walk::about(phase, variance) {
        Some(walk) => walk.add(source, exit, out),
        None => scattered(phase, variance, source, exit, out),
    }
}

/// Gaussians whose middles lie too far apart for one walk, row by row.
fn scattered<'a>(
    phase: &[f32; TILE],
    variance: &[f32; TILE],
    source: &[f32; TILE],
    exit: impl Fn(usize) -> &'a [f32; TILE],
    out: &mut [[f32; TILE]; ROWS],
) {
    for (k, row) in out.iter_mut().enumerate() {
        let exit = exit(k);
        for c in 0..TILE {
            let d = phase[c] + k as f32 - CENTRE as f32;
            let v = variance[c].max(LEAST);
            row[c] += source[c] * exit[c] * 0.398_942_3 / v.sqrt() * exp(-0.5 * d * d / v);
        }
    }
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
pub fn spread(own: &Row, neighbours: &[&Row; ROWS], start: usize, line: &Line<'_>, window: &mut Window) {
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
        let exit = |k: usize| load(&neighbours[k].exit[j], start);
        match line.section {
            None => one(&place, &wide, source, exit, own.disc_of(start), &mut window.volume),
            Some(section) => {
                let across = Across { own, start, section, level: section.level(Some(j)) };
                across.add(&place, &wide, source, exit, &mut window.volume);
            }
        }
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

/// Least variance that is drawn [px^2].
pub const LEAST: f32 = 0.05;

/// Gaussians of one tile, stepped from row to row.
struct Walk {
    middle: [f32; TILE],
    up: [f32; TILE],
    down: [f32; TILE],
    ratio: [f32; TILE],
    /// Row of the window that they are stepped from, and how far.
    from: usize,
    reach: usize,
}

impl Walk {
    /// `phase` is the distance from the line's centre to the window's middle row [px].
    #[inline(always)]
    fn new(phase: &[f32; TILE], variance: &[f32; TILE]) -> Self {
        let mut walk = Self {
            middle: [0.0; TILE],
            up: [0.0; TILE],
            down: [0.0; TILE],
            ratio: [0.0; TILE],
            from: CENTRE,
            reach: 0,
        };
        let (mut widest, mut narrowest) = (0.0f32, NARROW);
        for c in 0..TILE {
            let v = variance[c].max(LEAST);
            let half = 0.5 / v;
            let d = phase[c];
            // 1 / sqrt(2 pi v)
            walk.middle[c] = 0.398_942_3 / v.sqrt() * exp(-d * d * half);
            walk.up[c] = exp(-(2.0 * d + 1.0) * half);
            walk.down[c] = exp((2.0 * d - 1.0) * half);
            walk.ratio[c] = exp(-2.0 * half);
            (widest, narrowest) = (widest.max(v), narrowest.min(v));
        }
        if narrowest < NARROW {
            for c in 0..TILE {
                walk.middle[c] /= on_rows(phase[c], variance[c].max(LEAST));
            }
        }
        walk.reach = (REACH * widest.sqrt() + 1.0).min(CENTRE as f32) as usize;
        walk
    }

    /// The same for lines whose centres lie anywhere; `None` where they lie too far apart.
    #[inline(always)]
    fn about(phase: &[f32; TILE], variance: &[f32; TILE]) -> Option<Self> {
        let (mut least, mut most, mut narrowest) = (f32::MAX, f32::MIN, f32::MAX);
        for c in 0..TILE {
            (least, most) = (least.min(phase[c]), most.max(phase[c]));
            narrowest = narrowest.min(variance[c].max(LEAST));
        }
        let from = (CENTRE as f32 - (0.5 * (least + most)).round()).clamp(0.0, ROWS as f32 - 1.0);
        let moved = from - CENTRE as f32;
        let far = (least + moved).abs().max((most + moved).abs());
        if 0.5 * far * far > FAINT * narrowest {
            return None;
        }
        let mut walk = Self::new(&phase.map(|phase| phase + moved), variance);
        walk.from = from as usize;
        walk.reach = (walk.reach + far.ceil() as usize).min(ROWS);
        Some(walk)
    }

    /// Adds source x Gaussian x exit to every row of the window in reach.
    #[inline(always)]
    fn add<'a>(&self, source: &[f32; TILE], exit: impl Fn(usize) -> &'a [f32; TILE], out: &mut [[f32; TILE]; ROWS]) {
        let (middle, row) = (exit(self.from), &mut out[self.from]);
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
        for k in self.from + 1..(self.from + self.reach + 1).min(ROWS) {
            step(&mut g, &mut q, exit(k), &mut out[k]);
        }
        let (mut g, mut q) = (start, self.down);
        for k in (self.from.saturating_sub(self.reach)..self.from).rev() {
            step(&mut g, &mut q, exit(k), &mut out[k]);
        }
    }
}

/// Sum over whole rows of a Gaussian of variance `v` that lies `d` beside one of them [1].
#[inline(always)]
fn on_rows(d: f32, v: f32) -> f32 {
    const TWO_PI2: f32 = 19.739_209;
    let (cos, _) = turn(d - d.floor().min(d));
    let first = exp(-TWO_PI2 * v);
    1.0 + 2.0 * first * (cos + first * first * first * (2.0 * cos * cos - 1.0))
}
