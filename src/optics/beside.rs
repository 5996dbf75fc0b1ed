//! What the camera sees of a line besides the line itself, and where its windows of rows stand for that.
//!
//! A column has its line on the upper surface, a second one through a film ([`super::film`]), and mirror images
//! ([`super::mirror`]). The first window of [`ROWS`] rows stands about the brighter of the two lines, as the camera will
//! take it for the peak; a second one, which never overlaps the first, about the brightest of what is left outside.
//! Neglected: anything outside of both.

use super::expose::{CENTRE, ROWS};
use super::film::{self, Second};
use super::mirror::{self, Lit, Splat};
use super::row::Row;
use super::speckle::TILE;
use crate::transport::kernel::layers::FilmStackKernel;
use crate::transport::kernel::{BASIS, SPREAD_MM};

/// Rows from a window's edge within which a line's foot and its reading are cut off [px].
const FOOT: i32 = 16;

/// What else a row sends to the camera.
#[derive(Debug, Clone, Default)]
pub struct Beside {
    /// The line through the film.
    pub second: Second,
    /// Mirror images, by rising column.
    pub splats: Vec<Splat>,
    /// Sensor row of the first row of each window, a column [px].
    pub windows: [Vec<i32>; 2],
    /// Whether a tile of columns needs more than its line's own window.
    pub needs: Vec<Need>,
}

/// What a tile of columns needs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub enum Need {
    /// The line's own window holds all there is.
    #[default]
    Line,
    /// More light, in one window.
    One,
    /// More light, in two windows.
    Two,
}

/// Room in which these are made.
#[derive(Debug, Default)]
pub struct Room {
    /// For second lines.
    pub second: film::Room,
    /// What films do to light.
    pub covers: FilmStackKernel,
    mirror: mirror::Room,
}

/// First row of the window that stands about `row` [px].
pub fn about(row: f32) -> i32 {
    row.floor() as i32 - CENTRE as i32
}

impl Beside {
    /// Everything beside the line of `row`.
    pub fn make(&mut self, lit: &Lit<'_>, row: &Row, room: &mut Room) {
        room.second.draw(lit.watch.camera, &mut self.second);
        room.mirror.images(lit, &mut self.splats);
        let columns = row.centre.len();
        for window in &mut self.windows {
            window.resize(columns, 0);
        }
        self.needs.clear();
        self.needs.resize(columns / TILE, Need::Line);
        let mut splats = self.splats.iter().peekable();
        for column in 0..columns {
            let own = about(row.centre[column]);
            let (mut first, mut second) = (own, None);
            let mut need = Need::Line;
            // The brightest of what the first window does not hold.
            let mut left = lit.watch.faint;
            if self.second.columns.contains(&column) {
                let (line, through) = (line_peak(row, column), self.second.peak(column));
                let other = about(self.second.centre[column]);
                if through > lit.watch.faint {
                    need = Need::One;
                    let (stand, weaker, rest) = if through > line { (other, own, line) } else { (own, other, through) };
                    first = stand;
                    if rest > left && outside(weaker, first) {
                        (second, left) = (Some(weaker), rest);
                    }
                }
            }
            while let Some(splat) = splats.next_if(|splat| splat.column <= column) {
                need = need.max(Need::One);
                let stand = about(splat.row);
                if splat.peak() > left && outside(stand, first) {
                    (second, left) = (Some(stand), splat.peak());
                }
            }
            if second.is_some() {
                need = Need::Two;
            }
            self.windows[0][column] = first;
            self.windows[1][column] = apart(second.unwrap_or(first - ROWS as i32), first);
            let tile = &mut self.needs[column / TILE];
            *tile = need.max(*tile);
        }
    }

    /// Mirror images in the columns of a tile.
    pub fn tile(&self, tile: usize) -> &[Splat] {
        let at = |column: usize| self.splats.partition_point(|splat| splat.column < column);
        &self.splats[at(tile * TILE)..at((tile + 1) * TILE)]
    }
}

/// Whether a line whose own window starts at `stand` does not fit the window that starts at `first`.
pub fn outside(stand: i32, first: i32) -> bool {
    (stand - first).abs() > ROWS as i32 - CENTRE as i32 - FOOT
}

/// `stand`, moved until its window does not overlap the one that starts at `first`.
pub fn apart(stand: i32, first: i32) -> i32 {
    let rows = ROWS as i32;
    match stand - first {
        d if d.abs() >= rows => stand,
        d if d >= 0 => first + rows,
        _ => first - rows,
    }
}

/// Light in the brightest row of a column's line [e-].
pub fn line_peak(row: &Row, column: usize) -> f32 {
    let rate = row.rows_per_mm[column];
    peak(row.glare[column], row.variance[column], rate, |j| row.source[j][column] * row.exit[j][column])
}

impl Second {
    /// Light in the brightest row of a column's second line [e-].
    pub fn peak(&self, column: usize) -> f32 {
        peak(0.0, self.variance[column], self.rows_per_mm[column], |j| self.source[j][column])
    }
}

/// Sum of Gaussians in their common middle: `glare` of the line's own variance, the rest on the fixed widths [e-].
fn peak(glare: f32, variance: f32, rows_per_mm: f32, light: impl Fn(usize) -> f32) -> f32 {
    let spread = |j: usize| {
        let sigma = SPREAD_MM[j] * rows_per_mm;
        light(j) / (variance + sigma * sigma).sqrt()
    };
    0.398_942_3 * (glare / variance.sqrt() + (0..BASIS).map(spread).sum::<f32>())
}
