//! Tiles and windows: columns are worked on in tiles, sensor rows in windows around the line.
//!
//! A tile is [`TILE`] neighbouring columns; a window is [`ROWS`] sensor rows of each, and starts where that column's
//! line is, so windows follow the line.

use crate::optics::speckle::TILE;

/// Rows of a window around the line.
pub const ROWS: usize = 44;
/// Row of a window that holds the line's centre.
pub const CENTRE: usize = 22;
/// Rows from a window's edge within which a line's foot and its reading are cut off [px].
const FOOT_ROWS: i32 = 16;
/// The exit of light that the surface throws back.
pub(crate) const UNIT_EXIT: [f32; TILE] = [1.0; TILE];
/// Smallest variance of a Gaussian that is drawn [px^2].
pub(crate) const MIN_VARIANCE: f32 = 0.05;

/// Columns `start..` of a tile from an array over all columns, which is padded to whole tiles.
#[inline(always)]
pub fn load(values: &[f32], start: usize) -> &[f32; TILE] {
    values[start..].first_chunk().expect("rows are padded to whole tiles")
}

/// First row of the window that stands about `row` [px].
pub(crate) fn window_start(row: f32) -> i32 {
    row.floor() as i32 - CENTRE as i32
}

/// Whether a line whose own window starts at `start` does not fit the window that starts at `first`.
pub(crate) fn needs_own_window(start: i32, first: i32) -> bool {
    (start - first).abs() > ROWS as i32 - CENTRE as i32 - FOOT_ROWS
}

/// `start`, moved until its window does not overlap the one that starts at `first`.
pub(crate) fn without_overlap(start: i32, first: i32) -> i32 {
    let rows = ROWS as i32;
    match start - first {
        d if d.abs() >= rows => start,
        d if d >= 0 => first + rows,
        _ => first - rows,
    }
}

/// Greatest magnitude; that of NaN is above all.
#[inline(always)]
pub(crate) fn greatest(values: &[f32; TILE]) -> f32 {
    values.iter().fold(0.0, |most, value| greater(most, *value))
}

/// The greater magnitude; that of NaN is above all.
#[inline(always)]
pub(crate) fn greater(a: f32, b: f32) -> f32 {
    // As whole numbers, whose order is that of positive floats: extremes of floats are not vector code.
    f32::from_bits((a.to_bits() & 0x7fff_ffff).max(b.to_bits() & 0x7fff_ffff))
}
