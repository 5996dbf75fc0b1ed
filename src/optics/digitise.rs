//! From electrons of a window to digital numbers: speckle and noise.
//!
//! The pattern of speckle lies on the object and moves with it ([`super::speckle`]); noise has a counter and a key for each
//! pixel ([`crate::lanes::normals`]). A second window has a key of its own, so what it holds changes nothing in the first.

use multiversion::multiversion;

use super::expose::{CENTRE, ROWS, Window};
use super::speckle::{self, FINE, TURN};
use super::{Sensor, TILE};
use crate::frame::Frame;
use crate::lanes::normals;

/// Largest number of columns of a sensor, for counters of noise.
const COUNTER_COLUMNS: u32 = 1 << 14;
/// Names of the noise of the first and of the second window.
const NOISE: [&str; 2] = ["pixels", "pixels_beside"];

/// No light.
const DARK: [f32; TILE] = [0.0; TILE];

/// One exposure of one tile.
#[derive(Debug, Clone, Copy)]
pub struct Shot<'a> {
    /// Which profile.
    pub profile: usize,
    /// Which tile of columns.
    pub tile: usize,
    /// Columns of it that the sensor has.
    pub columns: usize,
    /// Offsets of the sensor's rows [DN].
    pub offsets: &'a [f32],
}

/// Adds speckle and noise to the electrons of window `number` and writes them to `frame`.
pub fn digitise(sensor: &Sensor, shot: &Shot<'_>, number: usize, window: &Window, frame: &mut Frame) {
    let Shot { profile, tile, columns, offsets } = *shot;
    frame.cols = columns;
    frame.rows = ROWS;
    frame.first_col = tile * TILE;
    frame.first_row.clear();
    frame.first_row.extend_from_slice(&window.first_row[..columns]);
    frame.dn.resize(ROWS * columns, 0);
    let level = window.first_row[..columns].iter().all(|&row| row == window.first_row[0]);
    let keys = sensor.chain.keys(NOISE[number], profile);
    // Another part of the pattern for the second window, which stands elsewhere.
    let base = (sensor.position(profile) * sensor.drift).round() as i64 + number as i64 * (ROWS * FINE) as i64;
    let counter = tile as u32 * TILE as u32;
    for pair in 0..ROWS / 2 {
        let rows = [2 * pair, 2 * pair + 1];
        let patterns = rows.map(|k| {
            let fine = base - (k as i64 - CENTRE as i64) * FINE as i64;
            let place = fine + speckle::offset(sensor.speckle_key, tile, fine.div_euclid(TURN));
            [sensor.tiles[0].row(place), sensor.tiles[1].row(place + TURN / 2)]
        });
        let shades = rows.map(|k| row_offsets(offsets, &window.first_row, k, level));
        let (even, odd) = frame.dn[rows[0] * columns..][..2 * columns].split_at_mut(columns);
        let pixels = PairOfRows {
            electrons: rows.map(|k| [&window.surface[k], &window.volume[k]]),
            patterns,
            ambient: rows.map(|k| window.ambient.get(k).unwrap_or(&DARK)),
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
    /// Light without speckle of both rows [e-].
    ambient: [&'a [f32; TILE]; 2],
    shades: &'a [[f32; TILE]; 2],
    counter: u32,
    keys: [u32; 2],
}

impl PairOfRows<'_> {
    fn write(&self, sensor: &Sensor, even: &mut [u16], odd: &mut [u16]) {
        pair(self, sensor, even, odd);
    }
}

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn pair(pixels: &PairOfRows<'_>, sensor: &Sensor, even: &mut [u16], odd: &mut [u16]) {
    let (chain, [glint, grain]) = (&sensor.chain, sensor.contrast);
    let mut out = [[0u16; TILE]; 2];
    for c in 0..TILE {
        let (first, second) = normals(pixels.counter + c as u32, pixels.keys);
        let signal = |row: usize| {
            let [surface, volume] = pixels.electrons[row];
            let [bright, soft] = pixels.patterns[row];
            let light = surface[c] * (1.0 + glint * bright[c]) + volume[c] * (1.0 + grain * soft[c]);
            let light = light + pixels.ambient[row][c];
            (chain.gain * light).max(0.0)
        };
        out[0][c] = chain.digitise(signal(0), first, pixels.shades[0][c]);
        out[1][c] = chain.digitise(signal(1), second, pixels.shades[1][c]);
    }
    even.copy_from_slice(&out[0][..even.len()]);
    odd.copy_from_slice(&out[1][..odd.len()]);
}
