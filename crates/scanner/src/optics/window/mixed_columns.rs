//! Mixed pixels: a column is as wide as its pixels, and where the surface jumps within that width it sees both sides.
//!
//! What a column shows follows from the point in its middle. The column that an edge cuts ([`MixedColumn`]) sees its
//! own side with the rest of its width, and the other side, with the light of its neighbour there, with what the edge
//! cuts off. Where both lines lie within a window they merge, as far as they are apart; beyond, the cut column's line
//! loses the light that is not its own, and the other line, fainter than half, is not drawn.
//!
//! Heights, classes and truth of a column stay those of its middle. Neglected: edges exactly between two tiles.

use super::electrons::Window;
use crate::optics::light::{MixedColumn, ROWS, window_start};
use crate::optics::speckle::TILE;

/// Whether the windows about lines at `centre` are such that each mixed column of the tile takes light of its neighbour
/// row by row, or none of it, and is cut once. No row then needs one that stands elsewhere in a window, and none is
/// brighter than the brighter of both columns.
pub(crate) fn share_rows_or_none(mixed: &[MixedColumn], tile: usize, centre: &[f32; TILE]) -> bool {
    let first = tile * TILE;
    let mixed = MixedColumn::of_tile(mixed, tile);
    // A column narrower than its pixels are wide takes light of both sides, which is not bounded by either.
    let cut_once = mixed.windows(2).all(|pair| pair[0].column != pair[1].column);
    cut_once
        && mixed.iter().all(|m| {
            let Some(beside) = m.beside.checked_sub(first).and_then(|beside| centre.get(beside)) else { return true };
            let off = window_start(centre[m.column - first]).abs_diff(window_start(*beside));
            off == 0 || off as usize >= ROWS
        })
}

/// Gives the mixed columns of a tile the light of both sides, in the rows that are drawn.
pub(crate) fn mix(mixed: &[MixedColumn], tile: usize, window: &mut Window) {
    let first = tile * TILE;
    let mixed = MixedColumn::of_tile(mixed, tile);
    let within = |m: &&MixedColumn| (first..first + TILE).contains(&m.beside);
    // Both sides as they are before any is mixed.
    let others: Vec<[[f32; ROWS]; 2]> = mixed
        .iter()
        .filter(within)
        .map(|m| {
            let beside = m.beside - first;
            let off = window.first_row[m.column - first] - window.first_row[beside];
            let at = |field: &[[f32; TILE]; ROWS], k: usize| {
                let there = k as i32 + off;
                usize::try_from(there).ok().and_then(|there| field.get(there)).map_or(0.0, |row| m.share * row[beside])
            };
            [&window.volume, &window.surface].map(|field| std::array::from_fn(|k| at(field, k)))
        })
        .collect();
    let drawn = window.drawn.clone();
    for m in mixed {
        for k in drawn.clone() {
            window.volume[k][m.column - first] *= 1.0 - m.share;
            window.surface[k][m.column - first] *= 1.0 - m.share;
        }
    }
    for (m, [volume, surface]) in mixed.iter().filter(within).zip(&others) {
        for k in drawn.clone() {
            window.volume[k][m.column - first] += volume[k];
            window.surface[k][m.column - first] += surface[k];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A column with an edge keeps its own part and takes the neighbour's in the rows where that stands.
    #[test]
    fn a_cut_column_sees_both_sides() {
        let mut window = Window { first_row: [100; TILE], ..Window::default() };
        window.first_row[8] = 97;
        (window.volume[20][7], window.volume[20][8], window.surface[22][8]) = (1000.0, 500.0, 200.0);
        let mixed =
            [MixedColumn { column: 7, beside: 8, share: 0.25 }, MixedColumn { column: 200, beside: 201, share: 0.5 }];
        mix(&mixed, 0, &mut window);
        // Row 20 of the neighbour's window is sensor row 117: row 17 of this one.
        assert_eq!((window.volume[20][7], window.volume[17][7], window.surface[19][7]), (750.0, 125.0, 50.0));
        assert_eq!((window.volume[20][8], window.surface[22][8]), (500.0, 200.0));
    }

    /// Windows that are shifted against each other by part of their rows are told, columns cut on both sides too.
    #[test]
    fn columns_that_need_other_rows_are_told() {
        let mut centre = [50.5; TILE];
        (centre[8], centre[9], centre[11]) = (50.9, 53.0, 50.5 + ROWS as f32);
        let cut = |column: usize, beside: usize| MixedColumn { column, beside, share: 0.3 };
        let told = |mixed: &[MixedColumn]| share_rows_or_none(mixed, 0, &centre);
        // In the same row, three rows away, a window away, and in another tile.
        assert!(told(&[]) && told(&[cut(7, 8)]) && !told(&[cut(9, 8)]) && told(&[cut(10, 11)]));
        assert!(told(&[cut(TILE - 1, TILE)]) && told(&[cut(TILE, TILE + 1), cut(TILE, TILE - 1)]));
        assert!(!told(&[cut(7, 6), cut(7, 8)]) && told(&[cut(6, 7), cut(7, 8)]));
    }

    /// An edge on a tile's border takes the light that is not the column's own, though nothing comes in its place.
    #[test]
    fn an_edge_between_tiles_dims() {
        let mut window = Window::default();
        window.volume[20][TILE - 1] = 100.0;
        mix(&[MixedColumn { column: TILE - 1, beside: TILE, share: 0.5 }], 0, &mut window);
        assert_eq!(window.volume[20][TILE - 1], 50.0);
    }
}
