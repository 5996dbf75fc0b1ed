//! Streaks: single fibres that guide light out of the line, drawn into the window of a tile.
//!
//! A uniform stretch of light along the fibre, narrower than a column, with the blur of lens and pixel at its sides and
//! at its ends. Neglected: light that fades along the fibre; what lies outside of its column's own window.

use super::speckle::TILE;
use super::window::{ROWS, Window};
use numerics::lanes::exp;

/// Most columns by which a streak may leave the tile that it starts in [px].
const MAX_LEAN_COLUMNS: f32 = 24.0;
/// Standard deviations beyond its ends to which a streak is drawn [1].
const END_REACH: f32 = 4.0;

/// A fibre that guides light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Streak {
    /// Sensor column where it crosses the line [px].
    pub column: f32,
    /// Sensor row of the line there [px].
    pub centre: f32,
    /// Columns that it moves aside per row [1].
    pub lean: f32,
    /// Its first row [px].
    pub first_row: f32,
    /// Its last row [px].
    pub last_row: f32,
    /// Light in each of its rows [e-].
    pub electrons: f32,
    /// Variance across the columns [px^2].
    pub column_variance: f32,
    /// Variance along the rows [px^2].
    pub row_variance: f32,
}

/// The streaks of a row, sorted by column, that may reach a tile.
pub(crate) fn near_tile(streaks: &[Streak], tile: usize) -> &[Streak] {
    let at = |column: f32| streaks.partition_point(|streak| streak.column < column);
    let start = (tile * TILE) as f32;
    &streaks[at(start - MAX_LEAN_COLUMNS)..at(start + TILE as f32 + MAX_LEAN_COLUMNS)]
}

/// Shares of a Gaussian of variance `v` in the five columns around the nearest one, which lies `off` from its mean;
/// they sum to 1.
pub fn columns(off: f32, v: f32) -> [(isize, f32); 5] {
    let part = |side: isize| {
        let d = side as f32 - off;
        exp(-0.5 * d * d / v.max(0.05))
    };
    let parts = [-2, -1, 0, 1, 2].map(|side| (side, part(side)));
    let sum: f32 = parts.iter().map(|(_, part)| part).sum();
    parts.map(|(side, part)| (side, part / sum.max(1e-20)))
}

/// Draws streaks into the columns `start..` of a window, as light from below.
pub fn draw(streaks: &[Streak], start: usize, window: &mut Window) {
    for streak in streaks {
        let sigma = streak.row_variance.sqrt();
        let (first, last) = (streak.first_row - END_REACH * sigma, streak.last_row + END_REACH * sigma);
        // The normal distribution function by the logistic one, within 1 %.
        let below = |row: f32| 1.0 / (1.0 + exp((-1.702 * row / sigma).clamp(-80.0, 80.0)));
        for row in first.ceil() as i32..=last.floor() as i32 {
            let light = streak.electrons * (below(row as f32 - streak.first_row) - below(row as f32 - streak.last_row));
            let position = streak.column + streak.lean * (row as f32 - streak.centre);
            let nearest = position.round();
            for (side, part) in columns(position - nearest, streak.column_variance) {
                let column = nearest as isize + side - start as isize;
                let Some(c) = usize::try_from(column).ok().filter(|&c| c < TILE) else { continue };
                let k = row - window.first_row[c];
                if (0..ROWS as i32).contains(&k) {
                    window.volume[k as usize][c] += part * light;
                }
            }
        }
    }
}
