//! The board in a picture that shows a dark belt around it.
//!
//! Model: pixels with four tenths of the light of the picture's bright half are board. Columns and then rows of which
//! less than half is board are belt as far as they reach from an edge; four thousandths of the picture go with them,
//! the board's rounded edge. Limits: boards lie along the picture; a board dark all along one edge loses it.

use crate::Encoding;
use crate::raster::quantile;

/// Least light of a board over the picture's bright half [1].
const LEAST_LIGHT: f32 = 0.4;
/// Light over that of the brightest twentieth above which the bright half is looked for [1].
const LIT: f32 = 0.25;
/// Least part of a column or row that is board [1].
const LEAST_SHARE: f32 = 0.5;
/// What goes with a belt of the picture's size [1].
const EDGE: f32 = 0.004;

/// The part of a picture that is board.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BoardPart {
    /// First row and column.
    pub first: [usize; 2],
    /// Rows and columns.
    pub size: [usize; 2],
}

impl BoardPart {
    /// The board in a picture of these numbers from 0 to 1 `[rows, cols]`.
    pub fn of(grey: &[f32], [rows, cols]: [usize; 2], encoding: Encoding) -> Self {
        let whole = Self { first: [0, 0], size: [rows, cols] };
        // Every fourth column and row is enough.
        let some = |row: usize, col: usize| encoding.light(grey[row * cols + col]);
        let places = |count: usize| (0..count).step_by(4);
        let mut light: Vec<f32> = places(rows).flat_map(|row| places(cols).map(move |col| some(row, col))).collect();
        if light.is_empty() || light.iter().any(|light| !light.is_finite()) {
            return whole;
        }
        let lit = LIT * quantile(&mut light, 0.95);
        light.retain(|light| *light > lit);
        if light.is_empty() {
            return whole;
        }
        let least = LEAST_LIGHT * quantile(&mut light, 0.5);
        let share = |on: &mut dyn Iterator<Item = bool>| {
            let (mut all, mut board) = (0.0_f32, 0.0_f32);
            on.for_each(|on| (all, board) = (all + 1.0, board + f32::from(on)));
            board >= LEAST_SHARE * all
        };
        let span = |count: usize, is_board: &dyn Fn(usize) -> bool| {
            let first = (0..count).find(|&at| is_board(at))?;
            let last = (0..count).rfind(|&at| is_board(at))?;
            let edge = (EDGE * count as f32) as usize + 1;
            let low = if first > 0 { first + edge } else { 0 };
            let high = if last + 1 < count { last.saturating_sub(edge) } else { last };
            (low < high).then_some((low, high + 1 - low))
        };
        let across = span(cols, &|col| share(&mut places(rows).map(|row| some(row, col) > least)));
        let Some((left, width)) = across else { return whole };
        let down = span(rows, &|row| share(&mut places(width).map(|col| some(row, left + col) > least)));
        let Some((top, height)) = down else { return whole };
        Self { first: [top, left], size: [height, width] }
    }

    /// Its pixels of a picture with so many columns.
    pub fn cut<T: Copy>(&self, pixels: &[T], cols: usize) -> Vec<T> {
        let rows = pixels.chunks(cols).skip(self.first[0]).take(self.size[0]);
        rows.flat_map(|row| &row[self.first[1]..self.first[1] + self.size[1]]).copied().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dark_belts_go_and_boards_stay() {
        let board = |row: usize, col: usize| 0.5 + 0.1 * ((row * 7 + col * 3) % 11) as f32 / 11.0;
        let picture = |belt: [usize; 4]| -> Vec<f32> {
            let [left, top, right, bottom] = belt;
            (0..300 * 400)
                .map(|i| {
                    let (row, col) = (i / 400, i % 400);
                    let is_belt = col < left || row < top || col >= 400 - right || row >= 300 - bottom;
                    if is_belt { 0.02 } else { board(row, col) }
                })
                .collect()
        };
        let part = |belt: [usize; 4]| BoardPart::of(&picture(belt), [300, 400], Encoding::Linear);
        assert_eq!(part([0; 4]), BoardPart { first: [0, 0], size: [300, 400] });
        let found = part([40, 0, 30, 80]);
        assert_eq!((found.first, found.size), ([0, 42], [218, 326]));
        let left = found.cut(&picture([40, 0, 30, 80]), 400);
        assert!(left.len() == 218 * 326 && left.iter().all(|light| *light > 0.4));
        assert_eq!(BoardPart::of(&[0.0; 120_000], [300, 400], Encoding::Linear).size, [300, 400]);
    }
}
