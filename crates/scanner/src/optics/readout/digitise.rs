//! Digitising: from the electrons of a window to digital numbers, by speckle, the pixels' own response, the signal
//! chain and noise.
//!
//! The pattern of speckle lies on the object and moves with it ([`crate::optics::speckle`]); noise has a counter and a
//! key for each pixel ([`numerics::lanes::normals`]). A second window has a key of its own, so what it holds changes
//! nothing in the first.

use std::ops::Range;

use multiversion::multiversion;

use super::SignalChain;
use super::fixed_pattern::{CodeSteps, FixedPattern, PixelCodes, UNIFORM_CODES, WindowRuns};
use crate::frame::Frame;
use crate::optics::light::{CENTRE, ROWS};
use crate::optics::speckle::coherence::{CONTRAST_COLUMNS, RowContrasts, contrast_curve};
use crate::optics::speckle::{AnchoredSpeckle, TILE, TileSpeckle};
use crate::optics::window::{Window, WindowSignal};
use numerics::lanes::{exp, normals, radius_uniform};

/// Largest number of columns of a sensor, for counters of noise.
const MAX_COLUMNS: u32 = 1 << 14;
/// Names of the noise of the first and of the second window.
const NOISE_STREAMS: [&str; 2] = ["pixels", "pixels_beside"];

/// By how much a bound on a digital number is raised for what rounding of floats may take from it, of the greatest
/// number [1].
const ROUNDING: f32 = 4e-5;
/// The same for hashes that make rare normals, as a factor [1].
const ROUNDING_OF_RARE: f32 = 1.001;

/// No light.
const DARK: [f32; TILE] = [0.0; TILE];

/// One exposure of one tile.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TileExposure<'a> {
    /// Which profile.
    pub profile: usize,
    /// Which tile of columns.
    pub tile: usize,
    /// Columns of it that the sensor has.
    pub columns: usize,
    /// Its middle in the laser plane, x and z [mm].
    pub place: [f64; 2],
    /// How far the object has moved there [mm].
    pub way: f64,
    /// Offsets of the sensor's rows [DN].
    pub offsets: &'a [f32],
}

/// From electrons to numbers, by one sensor.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Digitiser<'a> {
    /// Response, noise and converter of the sensor.
    pub chain: &'a SignalChain,
    /// Speckle of the sample.
    pub speckle: &'a AnchoredSpeckle,
    /// How much of it is left in light from below, beside the line.
    pub contrasts: &'a [RowContrasts],
    /// Sensor row of the line's centre, a column [px].
    pub centre: &'a [f32; TILE],
}

impl Digitiser<'_> {
    /// Adds speckle and noise to the electrons of window `number` and writes them to `frame`; `signal` is a buffer.
    pub(crate) fn digitise(
        &self,
        exposure: &TileExposure<'_>,
        number: usize,
        window: &Window,
        signal: &mut WindowSignal,
        frame: &mut Frame,
    ) {
        let TileExposure { profile, tile, columns, place, way, offsets } = *exposure;
        let drawn = window.drawn.clone();
        (frame.cols, frame.rows, frame.first_col) = (columns, drawn.len(), tile * TILE);
        frame.first_row.clear();
        frame.first_row.extend(window.first_row[..columns].iter().map(|row| row + drawn.start as i32));
        frame.dn.resize(drawn.len() * columns, 0);
        let [glint, grain] = self.speckle.scale;
        let rows = WindowRows {
            window,
            level: window.first_row[..columns].iter().all(|&row| row == window.first_row[0]),
            offsets,
            // Another part of the pattern for the second window, which lies elsewhere.
            patterns: self.speckle.tile(tile, place, way, number * ROWS),
            // What a second window shows has crossed a film, or was mirrored.
            contrasts: (number == 0).then(|| LineContrasts::new(self.contrasts, self.centre)),
            glint,
            grain,
            noise: PairNoise {
                counter: tile as u32 * TILE as u32,
                keys: self.chain.keys(NOISE_STREAMS[number], profile),
            },
        };
        self.read(&rows, tile, signal, frame);
    }

    /// Reads the rows of a window of the tile with this number, pair by pair.
    fn read(&self, rows: &WindowRows<'_>, tile: usize, signal: &mut WindowSignal, frame: &mut Frame) {
        let chain = self.chain;
        // Filled in place for each pair of rows: half of the time of this step was the copying of rows.
        let (mut shades, mut grains, mut numbers) = ([[0.0; TILE]; 2], [[0.0; TILE]; 2], [[0u16; TILE]; 2]);
        let pixels = chain.pixels.as_ref().map(|pixels| (pixels, WindowRuns::new(&rows.window.first_row)));
        let mut codes = [UNIFORM_CODES; 2];
        for pair in rows.pairs() {
            let own = rows.pair(pair, &mut shades, &mut grains);
            if let Some((pixels, runs)) = &pixels {
                rows_of(pair).into_iter().zip(&mut codes).for_each(|(k, row)| pixels.window_row(tile, runs, k, row));
            }
            if chain.spreads() {
                let developed = develop(&own, &codes, chain);
                for (row, k) in rows_of(pair).into_iter().enumerate() {
                    (signal.level[k], signal.noisy[k], signal.offset[k]) =
                        (developed[0][row], developed[1][row], developed[2][row]);
                }
                continue;
            }
            if chain.is_plain() {
                plain(&own, chain, &mut numbers);
            } else {
                unlike(&own, &codes, chain, &mut numbers);
            }
            rows.write(pair, &numbers, frame);
        }
        if chain.spreads() {
            chain.spread(signal);
            for pair in rows.pairs() {
                let fields =
                    [&signal.level, &signal.noisy, &signal.offset].map(|field| rows_of(pair).map(|k| &field[k]));
                read(rows.noise(pair), fields, chain, &mut numbers);
                rows.write(pair, &numbers, frame);
            }
        }
    }

    /// Whether a pixel of the first window's rows that are not drawn can come to the digital number `level` of its
    /// column, where no more than `light` falls on it [e-]: by the noise, the row and the pixel that it has.
    ///
    /// Of two uniform numbers that make two pixels' normals (Box and Muller), the first says how far off they can be.
    /// It is drawn for all of these pixels, and the few pairs of rows where one may be far enough are looked at pixel
    /// by pixel.
    pub(crate) fn reaches_beyond(
        &self,
        exposure: &TileExposure<'_>,
        window: &Window,
        light: &[f32; TILE],
        level: &[f32; TILE],
    ) -> bool {
        let chain = self.chain;
        let keys = chain.keys(NOISE_STREAMS[0], exposure.profile);
        let rows = exposure.offsets.iter().fold(f32::NEG_INFINITY, |most, offset| most.max(*offset));
        let pixels = chain.pixels.as_ref().map_or(0.0, FixedPattern::greatest_offset);
        let Some(bounds) = NoiseBounds::new(chain, light, level, rows + pixels) else { return true };
        let before = 0..window.drawn.start / 2;
        let behind = window.drawn.end.div_ceil(2)..ROWS / 2;
        before.chain(behind).any(|pair| {
            let noise = PairNoise { counter: pair as u32 * MAX_COLUMNS + (exposure.tile * TILE) as u32, keys };
            rare_among(noise.counter, noise.keys, &bounds.rare)
                && bounds.reaches(noise, |row, c| {
                    let row = window.first_row[c] + (2 * pair + row) as i32;
                    let own = exposure.offsets[row.clamp(0, exposure.offsets.len() as i32 - 1) as usize];
                    own + chain
                        .pixels
                        .as_ref()
                        .map_or(0.0, |pixels| pixels.at(row.max(0) as usize, exposure.tile * TILE + c).1)
                })
        })
    }
}

/// How far noise may be off before a pixel comes to a level.
struct NoiseBounds {
    /// What is left to the level without noise and offsets [DN].
    left: [f32; TILE],
    /// Standard deviation of the noise [DN].
    sigma: [f32; TILE],
    /// Uniform numbers above this make normals that are near enough to 0 [1].
    rare: [f32; TILE],
}

impl NoiseBounds {
    /// For pixels with so much light and offsets up to `offset`; `None` where some need no noise.
    fn new(chain: &SignalChain, light: &[f32; TILE], level: &[f32; TILE], offset: f32) -> Option<Self> {
        let mut bounds = Self { left: [0.0; TILE], sigma: [0.0; TILE], rare: [0.0; TILE] };
        let mut all = true;
        for c in 0..TILE {
            let (most, sigma) = chain.greatest_level(light[c]);
            // Numbers are rounded to the nearest.
            let left = level[c] - 0.5 - ROUNDING * chain.max_dn - most;
            (bounds.left[c], bounds.sigma[c]) = (left, sigma);
            let far = (left - offset) / sigma;
            all &= far > 0.0;
            bounds.rare[c] = ROUNDING_OF_RARE * exp((-0.5 * far * far).max(-80.0));
        }
        all.then_some(bounds)
    }

    /// Whether a pixel of two rows comes to the level, with the offsets [DN] that it has by row and column.
    fn reaches(&self, noise: PairNoise, offset: impl Fn(usize, usize) -> f32) -> bool {
        (0..TILE).any(|c| {
            let (first, second) = normals(noise.counter + c as u32, noise.keys);
            let farthest = first.max(second) * self.sigma[c];
            farthest > 0.0
                && [first, second]
                    .into_iter()
                    .enumerate()
                    .any(|(row, normal)| normal.max(0.0) * self.sigma[c] + offset(row, c) >= self.left[c])
        })
    }
}

/// Whether one of the uniform numbers that normals are made from is not above that of its column.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn rare_among(counter: u32, keys: [u32; 2], rare: &[f32; TILE]) -> bool {
    let mut found = 0u32;
    for c in 0..TILE {
        found |= u32::from(radius_uniform(counter + c as u32, keys) <= rare[c]);
    }
    found != 0
}

/// Rows from the line from which on its contrast changes so little that columns which share one share their place too.
const FAR_ROWS: usize = 3;
/// Most that the places of lines may differ among columns that do [px].
const SAME_PLACE: f32 = 0.5;

/// Where a tile's lines lie between rows, and how much of the patterns is left about them in light from below.
struct LineContrasts<'a> {
    contrasts: &'a [RowContrasts],
    /// How far each line's centre lies beyond row [`CENTRE`] [px].
    beyond: [f32; TILE],
    /// The same of the first of [`CONTRAST_COLUMNS`] columns; `None` where they differ.
    shared: [Option<f32>; TILE / CONTRAST_COLUMNS],
}

impl<'a> LineContrasts<'a> {
    fn new(contrasts: &'a [RowContrasts], centre: &[f32; TILE]) -> Self {
        let beyond = centre.map(|centre| centre - centre.floor());
        let (columns, _) = beyond.as_chunks::<CONTRAST_COLUMNS>();
        let shared = std::array::from_fn(|group| {
            let first = columns[group][0];
            columns[group].iter().all(|beyond| (beyond - first).abs() < SAME_PLACE).then_some(first)
        });
        Self { contrasts, beyond, shared }
    }
}

/// Factor on the pattern of light from below in a window row, a column: `grain` times what paths leave of it so far
/// ahead of the line, or behind it.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn row_contrasts(line: &LineContrasts<'_>, k: usize, grain: f32, out: &mut [f32; TILE]) {
    let ahead = k <= CENTRE;
    let from = if ahead { CENTRE - k } else { k - CENTRE - 1 };
    let ((out, _), (beyond, _)) =
        (out.as_chunks_mut::<CONTRAST_COLUMNS>(), line.beyond.as_chunks::<CONTRAST_COLUMNS>());
    for (((out, beyond), at), shared) in out.iter_mut().zip(beyond).zip(line.contrasts).zip(line.shared) {
        let [start, rise, bend] = contrast_curve(&at[usize::from(!ahead)], from);
        let (start, rise, bend) = (grain * start, grain * rise, grain * bend);
        // Columns that share a place share a contrast.
        let shared = shared.filter(|_| from >= FAR_ROWS);
        let beyond = shared.map_or(*beyond, |beyond| [beyond; CONTRAST_COLUMNS]);
        for c in 0..CONTRAST_COLUMNS {
            let t = if ahead { beyond[c] } else { 1.0 - beyond[c] };
            out[c] = start + t * (rise + t * bend);
        }
    }
}

/// Row offsets of a window row, a column; sensor rows beyond the edge take the edge's.
#[inline(always)]
fn row_offsets(offsets: &[f32], first_row: &[i32; TILE], k: usize, level: bool, out: &mut [f32; TILE]) {
    let last = offsets.len() as i32 - 1;
    let at = |row: i32| offsets[(row + k as i32).clamp(0, last) as usize];
    if level {
        out.fill(at(first_row[0]));
    } else {
        out.iter_mut().zip(first_row).for_each(|(out, &row)| *out = at(row));
    }
}

/// Two rows of a tile.
type RowPair<T> = [[T; TILE]; 2];

/// Where the noise of two rows comes from.
#[derive(Clone, Copy)]
struct PairNoise {
    counter: u32,
    keys: [u32; 2],
}

/// The rows of a window with their light, patterns and offsets. They are read in pairs, whose pixels share their
/// noise's numbers.
struct WindowRows<'a> {
    window: &'a Window,
    /// Whether the window begins in one sensor row in all columns.
    level: bool,
    /// Offsets of the sensor's rows [DN].
    offsets: &'a [f32],
    patterns: TileSpeckle<'a>,
    /// How much of the patterns is left in light from below, beside the line; `None` where all is.
    contrasts: Option<LineContrasts<'a>>,
    /// Factors on the surface and the volume patterns [1].
    glint: f32,
    grain: f32,
    /// Of the first pair.
    noise: PairNoise,
}

/// The rows of a pair.
fn rows_of(pair: usize) -> [usize; 2] {
    [2 * pair, 2 * pair + 1]
}

impl WindowRows<'_> {
    /// The pairs that are drawn.
    fn pairs(&self) -> Range<usize> {
        self.window.drawn.start / 2..self.window.drawn.end.div_ceil(2)
    }

    /// A pair, whose rows' offsets and factors on its volume patterns are filled in here.
    #[inline(always)]
    fn pair<'b>(&'b self, pair: usize, shades: &'b mut RowPair<f32>, grains: &'b mut RowPair<f32>) -> PairOfRows<'b> {
        let (rows, window) = (rows_of(pair), self.window);
        for ((k, shades), grains) in rows.into_iter().zip(shades.iter_mut()).zip(grains.iter_mut()) {
            row_offsets(self.offsets, &window.first_row, k, self.level, shades);
            match &self.contrasts {
                Some(line) => row_contrasts(line, k, self.grain, grains),
                None => *grains = [self.grain; TILE],
            }
        }
        PairOfRows {
            electrons: rows.map(|k| [&window.surface[k], &window.volume[k]]),
            patterns: rows.map(|k| self.patterns.row(k as i64 - CENTRE as i64)),
            ambient: rows.map(|k| window.ambient.get(k).unwrap_or(&DARK)),
            glint: self.glint,
            shades,
            grains,
            noise: self.noise(pair),
        }
    }

    /// Where the noise of a pair comes from.
    fn noise(&self, pair: usize) -> PairNoise {
        PairNoise { counter: pair as u32 * MAX_COLUMNS + self.noise.counter, ..self.noise }
    }

    /// Writes the numbers of a pair to the frame of the window.
    #[inline(always)]
    fn write(&self, pair: usize, numbers: &RowPair<u16>, frame: &mut Frame) {
        let rows = frame.dn[(2 * pair - self.window.drawn.start) * frame.cols..].chunks_exact_mut(frame.cols);
        for (row, numbers) in rows.zip(numbers) {
            row.copy_from_slice(&numbers[..row.len()]);
        }
    }
}

/// Light of two rows, and what their pixels make of it.
struct PairOfRows<'a> {
    /// Surface and volume electrons of both rows [e-].
    electrons: [[&'a [f32; TILE]; 2]; 2],
    /// Surface and volume patterns of both rows.
    patterns: [[&'a [f32; TILE]; 2]; 2],
    /// Light without speckle of both rows [e-].
    ambient: [&'a [f32; TILE]; 2],
    /// Factor on the surface patterns [1].
    glint: f32,
    /// Offsets of both rows, a column [DN].
    shades: &'a RowPair<f32>,
    /// Factor on the volume patterns of both rows, a column [1].
    grains: &'a RowPair<f32>,
    noise: PairNoise,
}

impl PairNoise {
    /// Digital numbers of level, noisy part and offset.
    #[inline(always)]
    fn numbers(self, chain: &SignalChain, developed: impl Fn(usize, usize) -> [f32; 3], out: &mut RowPair<u16>) {
        for c in 0..TILE {
            let (first, second) = normals(self.counter + c as u32, self.keys);
            for (row, normal) in [first, second].into_iter().enumerate() {
                out[row][c] = chain.digitise(developed(row, c), normal);
            }
        }
    }
}

impl PairOfRows<'_> {
    /// Light of a pixel with its speckle [e-].
    #[inline(always)]
    fn light(&self, row: usize, c: usize) -> f32 {
        let Self { electrons, patterns, ambient, glint, .. } = self;
        let [surface, volume] = electrons[row];
        let [bright, soft] = patterns[row];
        let grain = self.grains[row][c];
        surface[c] * (1.0 + glint * bright[c]) + volume[c] * (1.0 + grain * soft[c]) + ambient[row][c]
    }

    /// Level, the part of it that makes photon noise, and offset of a pixel [DN over dark, DN, DN].
    #[inline(always)]
    fn developed(
        &self,
        codes: &[PixelCodes; 2],
        steps: CodeSteps,
        chain: &SignalChain,
        row: usize,
        c: usize,
    ) -> [f32; 3] {
        let (response, shift) = steps.decode(&codes[row], c);
        chain.develop((chain.gain * response * self.light(row, c)).max(0.0), self.shades[row][c] + shift)
    }
}

/// Gain and noise alone.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn plain(pixels: &PairOfRows<'_>, chain: &SignalChain, out: &mut RowPair<u16>) {
    let developed = |row: usize, c: usize| {
        let signal = (chain.gain * pixels.light(row, c)).max(0.0);
        [signal, signal, pixels.shades[row][c]]
    };
    pixels.noise.numbers(chain, developed, out);
}

/// Pixels with a response and an offset of their own, and slopes.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn unlike(pixels: &PairOfRows<'_>, codes: &[PixelCodes; 2], chain: &SignalChain, out: &mut RowPair<u16>) {
    let steps = chain.steps();
    pixels.noise.numbers(chain, |row, c| pixels.developed(codes, steps, chain, row, c), out);
}

/// The same without noise, for charge to overflow.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn develop(pixels: &PairOfRows<'_>, codes: &[PixelCodes; 2], chain: &SignalChain) -> [RowPair<f32>; 3] {
    let (steps, mut out) = (chain.steps(), [[[0.0; TILE]; 2]; 3]);
    for row in 0..2 {
        for c in 0..TILE {
            [out[0][row][c], out[1][row][c], out[2][row][c]] = pixels.developed(codes, steps, chain, row, c);
        }
    }
    out
}

/// The noise of what has overflown: of level, noisy part and offset of both rows.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn read(noise: PairNoise, signal: [[&[f32; TILE]; 2]; 3], chain: &SignalChain, out: &mut RowPair<u16>) {
    noise.numbers(chain, |row, c| signal.map(|field| field[row][c]), out);
}

#[cfg(test)]
mod tests {
    use base::{Parameter, Stream};
    use optical_bench::parameters::{Bench, ExposureParameters};
    use optical_bench::settings::{Hdr, Readout, Size, SpeckleLaw};
    use rand::RngExt;

    use super::*;
    use crate::optics::speckle::coherence::{CONTRAST_ROWS, contrast_at};
    use crate::optics::speckle::{PatternCache, SpeckleConditions};

    /// Each row has the contrast of its own distance from the line, wherever the line lies between rows: as many rows
    /// ahead as behind it the same, where light on both sides is alike.
    #[test]
    fn rows_have_the_contrast_of_their_place() {
        let mut rng = Stream::root(78).rng();
        let mut side = [0.0; CONTRAST_ROWS.len()];
        for at in side.iter_mut().rev().scan(0.1, |at, node| {
            *at += rng.random_range(0.02..0.2);
            Some((*at, node))
        }) {
            *at.1 = at.0;
        }
        let contrasts = [[side, side.map(|at| 0.8 * at)]; TILE / CONTRAST_COLUMNS];
        let centre: [f32; TILE] = std::array::from_fn(|_| rng.random_range(-50.0..50.0f32));
        let mirrored = centre.map(|centre| -centre);
        let factor = |contrasts, k, centre| {
            let mut out = [0.0; TILE];
            row_contrasts(&LineContrasts::new(contrasts, centre), k, 2.0, &mut out);
            out
        };
        let alike = [[side; 2]; TILE / CONTRAST_COLUMNS];
        for k in 0..ROWS - 1 {
            let (found, here) = (factor(&contrasts, k, &centre), factor(&alike, k, &centre));
            let there = factor(&alike, 2 * CENTRE + 1 - k, &mirrored);
            for c in 0..TILE {
                let away = centre[c] - centre[c].floor() + CENTRE as f32 - k as f32;
                let known = 2.0 * contrast_at(&contrasts[0], away);
                assert!((found[c] - known).abs() < 1e-4, "row {k}, {away} rows: {} for {known}", found[c]);
                assert!((here[c] / there[c] - 1.0).abs() < 1e-3, "row {k}: {} and {}", here[c], there[c]);
            }
        }
    }

    /// For skipped rows the hash alone decides whether any pixel would reach the level, as often as when they are drawn
    /// in even light. Sensors and levels, from among the noise to far above, are drawn at random; a column is asked for
    /// at a time.
    #[test]
    fn noise_is_told_without_its_numbers() {
        let mut rng = Stream::root(77).rng();
        let size = Size { columns: 2 * TILE, rows: 300, profiles: 1 };
        let (mut reached, mut missed, mut wrong, mut asked, mut kneed) = (0, 0, 0, [0; 2], 0);
        for round in 0..480u64 {
            let mut exposure = ExposureParameters::from_values(&mut |p: &'static Parameter| p.default);
            exposure.dark_level_dn = rng.random_range(4.0..30.0);
            exposure.dark_noise_dn = rng.random_range(1.0..2.5);
            exposure.row_noise_dn = rng.random_range(0.0..0.5);
            exposure.row_pattern_dn = rng.random_range(0.0..0.5);
            if round % 4 != 0 {
                (exposure.dsnu_dn, exposure.column_pattern_dn) =
                    (rng.random_range(0.0..0.4), rng.random_range(0.0..0.2));
            }
            // Of pixels that respond alike and have one slope the greatest level is that of each.
            let alike = round % 2 == 0;
            let hdr = if alike { Hdr::None } else { Hdr::ALL[round as usize / 2 % Hdr::ALL.len()] };
            exposure.prnu = if alike { 0.0 } else { rng.random_range(0.0..0.02) };
            let bits = [8, 10, 12][round as usize / 8 % 3];
            let chain = SignalChain::new(&exposure, Readout { bits, hdr }, &size, Stream::root(round));
            let speckle = AnchoredSpeckle::new(
                &Bench {
                    speckle: optical_bench::parameters::SpeckleParameters { strength: 0.0, ..Bench::default().speckle },
                    ..Bench::default()
                },
                &SpeckleConditions { grain: 0.4, rows_per_mm: 10.0, height: 0.0, paths: 1.0, travel: 0.0 },
                SpeckleLaw::Exponential,
                &PatternCache::repeating(0),
                0,
            );
            let contrasts = [RowContrasts::default(); TILE / CONTRAST_COLUMNS];
            let digitiser = Digitiser { chain: &chain, speckle: &speckle, contrasts: &contrasts, centre: &DARK };
            let (mut offsets, profile) = (Vec::new(), round as usize);
            chain.row_offsets(profile, &mut offsets);
            let exposure =
                TileExposure { profile, tile: 1, columns: TILE, place: [0.0; 2], way: 0.0, offsets: &offsets };
            // None, faint, or any that the sensor takes, behind its knee too.
            let light = match round / 2 % 4 {
                0 => 0.0,
                1 => rng.random_range(0.0..400.0f32),
                _ => rng.random_range(0.0..0.9f32) * hdr.gain() as f32 * chain.full / chain.gain,
            };
            let mut window = Window::default();
            let slope = rng.random_range(0.0..2.0f32);
            window.first_row = std::array::from_fn(|c| -30 + (c as f32 * 2.5 * slope) as i32);
            window.volume.iter_mut().for_each(|row| *row = [light; TILE]);
            let mut frame = Frame::default();
            digitiser.digitise(&exposure, 0, &window, &mut WindowSignal::default(), &mut frame);
            let from = 2 * rng.random_range(3..10usize);
            window.drawn = from..2 * rng.random_range(12..19usize);
            let sigma = chain.greatest_level(light).1;
            let (developed, _) = chain.slopes.respond(chain.gain * light);
            kneed += usize::from(chain.gain * light > chain.slopes.knee);
            let middle = exposure.offsets[0] + developed;
            for c in (0..TILE).step_by(9) {
                let level = (middle + sigma * rng.random_range(1.0..6.0f32)).round();
                let of_column = std::array::from_fn(|other| if other == c { level } else { f32::INFINITY });
                let told = digitiser.reaches_beyond(&exposure, &window, &[light; TILE], &of_column);
                let left_out = (0..window.drawn.start).chain(window.drawn.end..ROWS);
                let truth = left_out.into_iter().any(|k| f32::from(frame.dn[k * TILE + c]) >= level);
                asked[usize::from(alike)] += 1;
                reached += usize::from(truth);
                missed += usize::from(truth && !told);
                wrong += usize::from(alike && told && !truth);
            }
        }
        println!(
            "{reached} of {asked:?} columns reach their level, {wrong} are said to; {kneed} exposures behind the knee"
        );
        assert!(missed == 0 && reached > asked.iter().sum::<usize>() / 10, "{missed} of {reached} are missed");
        assert!(kneed > 20, "{kneed} exposures are behind the knee");
        // Levels that the greatest offsets alone could reach are said to be, and a little more for what rounding may
        // take.
        assert!(20 * wrong < asked[1], "{wrong} of {} are said to reach it and do not", asked[1]);
    }
}
