//! Secondary light: what the camera sees of a line besides the line itself, and where windows of rows lie for that.
//!
//! A column has its line on the upper surface, another one seen through a film ([`super::film`]), and mirror images
//! ([`super::reflections`]). The first window of [`ROWS`] rows lies about the brighter of the two lines, which the
//! camera will take for the peak; a second one, which never overlaps the first, about the brightest of what the first
//! does not hold. Neglected: light outside of both.

use super::film;
use super::pockets::PocketColumn;
use super::reflections::ReflectionScratch;
use super::view::LitLine;
use crate::optics::light::{
    ROWS, ScanLine, SecondaryLight, WindowNeed, needs_own_window, window_start, without_overlap,
};
use crate::optics::speckle::TILE;
use transport::kernel::film_stack::FilmStackKernel;
use transport::kernel::film_stack::paths::FilmPaths;

/// Buffers in which these are made.
#[derive(Debug, Default)]
pub struct SecondaryScratch {
    /// For transmitted lines.
    pub transmission: film::TransmissionScratch,
    /// What films do to light.
    pub films: FilmStackKernel,
    /// How long its paths are.
    pub paths: FilmPaths,
    /// What each column's film over a pocket lets in and out.
    pub(crate) pockets: Vec<PocketColumn>,
    /// For mirror images.
    pub(crate) reflections: ReflectionScratch,
    /// Light in the brightest row of each column's transmitted line [e-].
    pub(crate) peaks: Vec<f32>,
}

impl SecondaryLight {
    /// Works out all light of `line` besides its line.
    pub(crate) fn make(&mut self, lit: &LitLine<'_>, line: &ScanLine, scratch: &mut SecondaryScratch) {
        scratch.transmission.draw(lit.view.camera, &mut self.transmitted);
        scratch.reflections.images(lit, &mut self.reflections);
        self.patches.find(lit, line, &mut scratch.films);
        self.pockets.find(lit, &scratch.pockets);
        self.transmitted.peaks(&mut scratch.peaks);
        let columns = line.centre.len();
        for window in &mut self.windows {
            window.resize(columns, 0);
        }
        self.needs.clear();
        self.needs.resize(columns / TILE, WindowNeed::Line);
        let mut reflections = self.reflections.iter().peekable();
        for column in 0..columns {
            let own = window_start(line.centre[column]);
            let (mut first, mut second) = (own, None);
            let mut need = WindowNeed::Line;
            // The brightest of what the first window does not hold.
            let mut left = lit.view.faint;
            if self.transmitted.columns.contains(&column) {
                let through = scratch.peaks[column - self.transmitted.columns.start];
                if through > lit.view.faint {
                    let direct = line.line_peak(column);
                    let other = window_start(self.transmitted.centre[column]);
                    need = WindowNeed::One;
                    let (stand, weaker, rest) =
                        if through > direct { (other, own, direct) } else { (own, other, through) };
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
}
