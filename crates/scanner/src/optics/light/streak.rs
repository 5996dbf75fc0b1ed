//! Streak: a single fibre that guides light out of the line.

use crate::optics::speckle::TILE;
use numerics::lanes::exp;

/// Most columns by which a streak may leave the tile that it starts in [px].
const MAX_LEAN_COLUMNS: f32 = 24.0;

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

impl Streak {
    /// Those that may reach a tile, among all of a line by rising column.
    pub(crate) fn near_tile(streaks: &[Self], tile: usize) -> &[Self] {
        let at = |column: f32| streaks.partition_point(|streak| streak.column < column);
        let start = (tile * TILE) as f32;
        &streaks[at(start - MAX_LEAN_COLUMNS)..at(start + TILE as f32 + MAX_LEAN_COLUMNS)]
    }
}

/// Shares of a Gaussian of variance `v` in the five columns around the nearest one, which lies `off` from its mean;
/// they sum to 1.
pub(crate) fn column_shares(off: f32, v: f32) -> [(isize, f32); 5] {
    let part = |side: isize| {
        let d = side as f32 - off;
        exp(-0.5 * d * d / v.max(0.05))
    };
    let parts = [-2, -1, 0, 1, 2].map(|side| (side, part(side)));
    let sum: f32 = parts.iter().map(|(_, part)| part).sum();
    parts.map(|(side, part)| (side, part / sum.max(1e-20)))
}
