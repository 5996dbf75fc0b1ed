//! What the camera sees of a line besides the line itself, and where its windows of rows stand for that.
//!
//! A column has its line on the upper surface, a second one through a film ([`super::film`]), and mirror images
//! ([`super::reflections`]). The first window of [`ROWS`] rows stands about the brighter of the two lines, as the camera will
//! take it for the peak; a second one, which never overlaps the first, about the brightest of what is left outside.
//! Neglected: anything outside of both.

use super::expose::{CENTRE, ROWS};
use super::film::{self, TransmittedLine};
use super::reflections::{LitRow, Reflection, ReflectionScratch};
use super::row::Row;
use super::speckle::TILE;
use crate::transport::kernel::film_stack::FilmStackKernel;
use crate::transport::kernel::{BASIS, SPREAD_MM};

/// Rows from a window's edge within which a line's foot and its reading are cut off [px].
const FOOT_ROWS: i32 = 16;

/// What else a row sends to the camera.
#[derive(Debug, Clone, Default)]
pub struct SecondaryLight {
    /// The line through the film.
    pub transmitted: TransmittedLine,
    /// Mirror images, by rising column.
    pub reflections: Vec<Reflection>,
    /// Sensor row of the first row of each window, a column [px].
    pub windows: [Vec<i32>; 2],
    /// Whether a tile of columns needs more than its line's own window.
    pub needs: Vec<WindowNeed>,
}

/// What a tile of columns needs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub enum WindowNeed {
    /// The line's own window holds all there is.
    #[default]
    Line,
    /// More light, in one window.
    One,
    /// More light, in two windows.
    Two,
}

/// Buffers in which these are made.
#[derive(Debug, Default)]
pub struct SecondaryScratch {
    /// For second lines.
    pub transmission: film::TransmissionScratch,
    /// What films do to light.
    pub covers: FilmStackKernel,
    reflections: ReflectionScratch,
}

/// First row of the window that stands about `row` [px].
pub fn window_start(row: f32) -> i32 {
    row.floor() as i32 - CENTRE as i32
}

impl SecondaryLight {
    /// Everything beside the line of `row`.
    pub fn make(&mut self, lit: &LitRow<'_>, row: &Row, scratch: &mut SecondaryScratch) {
        scratch.transmission.draw(lit.view.camera, &mut self.transmitted);
        scratch.reflections.images(lit, &mut self.reflections);
        let columns = row.centre.len();
        for window in &mut self.windows {
            window.resize(columns, 0);
        }
        self.needs.clear();
        self.needs.resize(columns / TILE, WindowNeed::Line);
        let mut reflections = self.reflections.iter().peekable();
        for column in 0..columns {
            let own = window_start(row.centre[column]);
            let (mut first, mut second) = (own, None);
            let mut need = WindowNeed::Line;
            // The brightest of what the first window does not hold.
            let mut left = lit.view.faint;
            if self.transmitted.columns.contains(&column) {
                let (line, through) = (line_peak(row, column), self.transmitted.peak(column));
                let other = window_start(self.transmitted.centre[column]);
                if through > lit.view.faint {
                    need = WindowNeed::One;
                    let (stand, weaker, rest) = if through > line { (other, own, line) } else { (own, other, through) };
                    first = stand;
                    if rest > left && needs_own_window(weaker, first) {
                        (second, left) = (Some(weaker), rest);
                    }
                }
            }
            while let Some(reflection) = reflections.next_if(|reflection| reflection.column <= column) {
                need = need.max(WindowNeed::One);
                let stand = window_start(reflection.row);
                if reflection.peak() > left && needs_own_window(stand, first) {
                    (second, left) = (Some(stand), reflection.peak());
                }
            }
            if second.is_some() {
                need = WindowNeed::Two;
            }
            self.windows[0][column] = first;
            self.windows[1][column] = without_overlap(second.unwrap_or(first - ROWS as i32), first);
            let tile = &mut self.needs[column / TILE];
            *tile = need.max(*tile);
        }
    }

    /// Mirror images in the columns of a tile.
    pub fn tile(&self, tile: usize) -> &[Reflection] {
        let at = |column: usize| self.reflections.partition_point(|reflection| reflection.column < column);
        &self.reflections[at(tile * TILE)..at((tile + 1) * TILE)]
    }
}

/// Whether a line whose own window starts at `stand` does not fit the window that starts at `first`.
pub fn needs_own_window(stand: i32, first: i32) -> bool {
    (stand - first).abs() > ROWS as i32 - CENTRE as i32 - FOOT_ROWS
}

/// `stand`, moved until its window does not overlap the one that starts at `first`.
pub fn without_overlap(stand: i32, first: i32) -> i32 {
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
    peak(row.surface_light[column], row.variance[column], rate, |j| row.source[j][column] * row.exit[j][column])
}

impl TransmittedLine {
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
