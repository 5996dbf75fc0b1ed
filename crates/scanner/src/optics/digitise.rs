//! Digitising: from the electrons of a window to digital numbers, by speckle, the pixels' own response, slopes, blooming
//! and noise.
//!
//! The pattern of speckle lies on the object and moves with it ([`super::speckle`]); noise has a counter and a key for each
//! pixel ([`numerics::lanes::normals`]). A second window has a key of its own, so what it holds changes nothing in the first.

use multiversion::multiversion;

use super::coherence::{CONTRAST_COLUMNS, CONTRAST_ROWS, RowContrasts};
use super::fixed_pattern::{CodeSteps, PixelCodes, UNIFORM_CODES, WindowRuns};
use super::signal_chain::SignalChain;
use super::speckle::{AnchoredSpeckle, TILE};
use super::window::{CENTRE, ROWS, Window, WindowSignal};
use crate::frame::Frame;
use numerics::lanes::normals;

/// Largest number of columns of a sensor, for counters of noise.
const MAX_COLUMNS: u32 = 1 << 14;
/// Names of the noise of the first and of the second window.
const NOISE_STREAMS: [&str; 2] = ["pixels", "pixels_beside"];

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
        frame.cols = columns;
        let drawn = window.drawn.clone();
        frame.rows = drawn.len();
        frame.first_col = tile * TILE;
        frame.first_row.clear();
        frame.first_row.extend(window.first_row[..columns].iter().map(|row| row + drawn.start as i32));
        frame.dn.resize(drawn.len() * columns, 0);
        let level = window.first_row[..columns].iter().all(|&row| row == window.first_row[0]);
        let keys = self.chain.keys(NOISE_STREAMS[number], profile);
        // Another part of the pattern for the second window, which lies elsewhere.
        let view = self.speckle.tile(tile, place, way, number * ROWS);
        let counter = tile as u32 * TILE as u32;
        // Rows are drawn in pairs, whose pixels share their noise's numbers.
        let pairs = drawn.start / 2..drawn.end.div_ceil(2);
        let rows_of = |pair: usize| [2 * pair, 2 * pair + 1];
        let [glint, grain] = self.speckle.scale();
        let pair_of = |pair: usize| {
            let rows = rows_of(pair);
            let patterns = rows.map(|k| view.row(k as i64 - CENTRE as i64));
            PairOfRows {
                electrons: rows.map(|k| [&window.surface[k], &window.volume[k]]),
                patterns,
                ambient: rows.map(|k| window.ambient.get(k).unwrap_or(&DARK)),
                shades: rows.map(|k| row_offsets(offsets, &window.first_row, k, level)),
                glint,
                // What a second window shows has crossed a film, or was mirrored.
                grain: rows.map(|k| if number == 0 { row_contrasts(self.contrasts, k, grain) } else { [grain; TILE] }),
                counter: pair as u32 * MAX_COLUMNS + counter,
                keys,
            }
        };
        let chain = self.chain;
        let out = |dn: &mut Vec<u16>, pair: usize, numbers: [[u16; TILE]; 2]| {
            for (row, numbers) in dn[(2 * pair - drawn.start) * columns..].chunks_exact_mut(columns).zip(numbers) {
                row.copy_from_slice(&numbers[..columns]);
            }
        };
        if chain.is_plain() {
            pairs.for_each(|pair| out(&mut frame.dn, pair, plain(&pair_of(pair), chain)));
            return;
        }
        let runs = WindowRuns::new(&window.first_row);
        for pair in pairs.clone() {
            let own = pair_of(pair);
            let codes = rows_of(pair)
                .map(|k| chain.pixels.as_ref().map_or(UNIFORM_CODES, |pixels| pixels.window_row(tile, &runs, k)));
            if chain.blooming == 0.0 {
                out(&mut frame.dn, pair, unlike(&own, &codes, chain));
                continue;
            }
            let developed = develop(&own, &codes, chain);
            for (row, k) in rows_of(pair).into_iter().enumerate() {
                (signal.level[k], signal.noisy[k], signal.offset[k]) =
                    (developed[0][row], developed[1][row], developed[2][row]);
            }
        }
        if chain.blooming > 0.0 {
            signal.bloom(chain.full, chain.blooming);
            for pair in pairs {
                let own = PairOfRows { shades: rows_of(pair).map(|k| signal.offset[k]), ..pair_of(pair) };
                let [level, noisy] = [&signal.level, &signal.noisy].map(|field| rows_of(pair).map(|k| field[k]));
                out(&mut frame.dn, pair, read(&own, [&level, &noisy], chain));
            }
        }
    }
}

/// Factor on the pattern of light from below in a window row, a column: `grain` times what paths leave of it there.
#[inline(always)]
fn row_contrasts(contrasts: &[RowContrasts], k: usize, grain: f32) -> [f32; TILE] {
    let rows = k.abs_diff(CENTRE) as f32;
    let last = CONTRAST_ROWS.len() - 1;
    let next = CONTRAST_ROWS.iter().position(|&at| at >= rows).unwrap_or(last).max(1);
    let (from, to) = (CONTRAST_ROWS[next - 1], CONTRAST_ROWS[next]);
    let part = ((rows - from) / (to - from)).min(1.0);
    let mut out = [0.0; TILE];
    for (columns, at) in out.chunks_exact_mut(CONTRAST_COLUMNS).zip(contrasts) {
        columns.fill(grain * (at[next - 1] + part * (at[next] - at[next - 1])));
    }
    out
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
    /// Light without speckle of both rows [e-].
    ambient: [&'a [f32; TILE]; 2],
    /// Offsets of both rows, a column [DN].
    shades: RowPair<f32>,
    /// Factor on the surface patterns [1].
    glint: f32,
    /// Factor on the volume patterns of both rows, a column [1].
    grain: RowPair<f32>,
    counter: u32,
    keys: [u32; 2],
}

/// Two rows of a tile.
type RowPair<T> = [[T; TILE]; 2];

impl PairOfRows<'_> {
    /// Light of a pixel with its speckle [e-].
    #[inline(always)]
    fn light(&self, row: usize, c: usize) -> f32 {
        let [surface, volume] = self.electrons[row];
        let [bright, soft] = self.patterns[row];
        let (glint, grain) = (self.glint, self.grain[row][c]);
        surface[c] * (1.0 + glint * bright[c]) + volume[c] * (1.0 + grain * soft[c]) + self.ambient[row][c]
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
        let light = self.light(row, c);
        let (level, noisy) = chain.slopes.respond((chain.gain * response * light).max(0.0));
        [level, noisy, self.shades[row][c] + shift]
    }

    /// Digital numbers of level, noisy part and offset.
    #[inline(always)]
    fn numbers(&self, chain: &SignalChain, developed: impl Fn(usize, usize) -> [f32; 3]) -> RowPair<u16> {
        let mut out = [[0u16; TILE]; 2];
        for c in 0..TILE {
            let (first, second) = normals(self.counter + c as u32, self.keys);
            for (row, normal) in [first, second].into_iter().enumerate() {
                let [level, noisy, offset] = developed(row, c);
                out[row][c] = chain.digitise(level, noisy, normal, offset);
            }
        }
        out
    }
}

/// Gain and noise alone.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn plain(pixels: &PairOfRows<'_>, chain: &SignalChain) -> RowPair<u16> {
    pixels.numbers(chain, |row, c| {
        let signal = (chain.gain * pixels.light(row, c)).max(0.0);
        [signal, signal, pixels.shades[row][c]]
    })
}

/// Pixels with a response and an offset of their own, and slopes.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn unlike(pixels: &PairOfRows<'_>, codes: &[PixelCodes; 2], chain: &SignalChain) -> RowPair<u16> {
    let steps = chain.steps();
    pixels.numbers(chain, |row, c| pixels.developed(codes, steps, chain, row, c))
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

/// The noise of what has overflown.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn read(pixels: &PairOfRows<'_>, [level, noisy]: [&RowPair<f32>; 2], chain: &SignalChain) -> RowPair<u16> {
    pixels.numbers(chain, |row, c| [level[row][c], noisy[row][c], pixels.shades[row][c]])
}
