//! Streaks: single fibres that guide light out of the line, drawn into the window of a tile.
//!
//! A uniform stretch of light along the fibre, narrower than a column, with the blur of lens and pixel at its sides and
//! at its ends. Neglected: light that fades along the fibre; what lies outside of its column's own window.

use super::electrons::Window;
use crate::optics::light::{ROWS, Streak, column_shares};
use crate::optics::speckle::TILE;
use numerics::lanes::exp;

/// Standard deviations beyond its ends to which a streak is drawn [1].
const END_REACH: f32 = 4.0;

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
            for (side, part) in column_shares(position - nearest, streak.column_variance) {
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
