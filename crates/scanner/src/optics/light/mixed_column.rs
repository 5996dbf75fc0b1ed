//! Mixed column: a column that an edge of the surface cuts.

use crate::optics::speckle::TILE;

/// A column that sees past an edge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MixedColumn {
    /// Sensor column.
    pub column: usize,
    /// Its neighbour on the other side of the edge.
    pub beside: usize,
    /// Part of the column's width on that side, at most a half [1].
    pub share: f32,
}

impl MixedColumn {
    /// Those of a tile, among all of a line by rising column.
    pub(crate) fn of_tile(mixed: &[Self], tile: usize) -> &[Self] {
        let first = tile * TILE;
        &mixed[mixed.partition_point(|m| m.column < first)..mixed.partition_point(|m| m.column < first + TILE)]
    }
}
