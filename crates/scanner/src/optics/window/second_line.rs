//! A second line, parallel to the first: the same sheet of light again, moved along the motion.
//!
//! It lights the scan line that stands below it, whose light is worked out already for another position of the scan,
//! and is seen off the first one's plane: where the camera's exact projection puts it. Columns look at other places
//! there, by 0.5 % of x at 5 mm; a tile takes the columns that come nearest, within a column, and heights to first
//! order of what is left. A thin lens that has the first one in focus has not the second, and blurs it along the rows.
//! It stands in the second window of rows where the first does not hold it. Neglected: that the second line meets what
//! it lights from, and the lens sees it at, an angle that differs by offset over distance; its blur along the line,
//! streaks, mirror images, interreflections and lines through films, what pockets let out of its light; what falls
//! outside of both windows.

use std::ops::RangeInclusive;

use super::compositing;
use super::electrons::Scratch;
use super::line_image::{LineShape, draw};
use super::lit_profile::LitProfile;
use crate::optics::camera::Camera;
use crate::optics::light::{ROWS, ScanLine, without_overlap};
use crate::optics::speckle::TILE;
use optical_bench::parameters::LaserParameters;

/// Lines beyond those that even steps would ask for, for steps that are not.
pub(crate) const SPARE_LINES: usize = 4;

/// The second line.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SecondLine {
    /// How far along the motion it lies [mm].
    offset: f64,
    /// Its light over the first line's [1].
    ratio: f32,
    /// The line that stands below it, from the profile's own.
    ahead: isize,
}

impl SecondLine {
    /// The second line of a bench whose profiles are `step` apart [mm]; `None` for one line.
    pub fn new(bench: &LaserParameters, step: f64) -> Option<Self> {
        let offset = bench.second_line_mm;
        let ratio = bench.second_line_share / (1.0 - bench.second_line_share);
        let lit = offset != 0.0 && ratio > 0.0;
        lit.then(|| Self { offset, ratio: ratio as f32, ahead: (offset / step).round() as isize })
    }

    /// Lines before and behind a profile's own that it stands on.
    pub fn reach(&self) -> [usize; 2] {
        let ahead = self.ahead.unsigned_abs() + SPARE_LINES;
        if self.ahead < 0 { [ahead, SPARE_LINES] } else { [SPARE_LINES, ahead] }
    }

    /// Lines that it may stand on, from a profile's own.
    pub fn lines(&self) -> RangeInclusive<isize> {
        let spare = SPARE_LINES as isize;
        self.ahead - spare..=self.ahead + spare
    }

    /// Adds it to the windows of a tile.
    pub fn add(&self, lit: &LitProfile<'_>, tile: usize, scratch: &mut Scratch) {
        let LitProfile { camera, geometry, band, profile } = *lit;
        let here = geometry.position(profile as isize) + self.offset;
        let off = |ahead: isize| here - geometry.position(profile as isize + ahead);
        let ahead = self.lines().min_by(|&a, &b| off(a).abs().total_cmp(&off(b).abs())).unwrap_or(self.ahead);
        let line = band.neighbour(profile, ahead);
        let start = tile * TILE;
        let from = self.columns(camera, line, start, scratch.columns);
        let moved = lit.line().moved_px;
        let centre = std::array::from_fn(|c| {
            let own = from + c;
            if own < line.hits.len() {
                moved + self.centre(camera, line, own, start + c, off(ahead) as f32)
            } else {
                0.0
            }
        });
        let neighbours: [&ScanLine; ROWS] =
            std::array::from_fn(|k| band.neighbour(profile, ahead + geometry.neighbours[k]));
        let Scratch { windows, spare, used, .. } = scratch;
        let middle = &line.hits[(from + TILE / 2).min(line.hits.len() - 1)];
        let disc = |y: f32| camera.off_plane_defocus(y, middle.surface.z);
        let blur = disc(self.offset as f32) - disc(0.0);
        let shape = LineShape { centre: &centre, blur, profile: camera.laser.line_profile() };
        draw(line, &neighbours, from, &shape, spare);
        if *used == 1 && spare.first_row != windows[0].first_row {
            *used = 2;
            windows[1].darken();
            let places: [i32; TILE] =
                std::array::from_fn(|c| without_overlap(spare.first_row[c], windows[0].first_row[c]));
            windows[1].first_row = places;
        }
        compositing::add_shifted(spare, &mut windows[..*used], &[], self.ratio);
    }

    /// First of the columns of the lit line that are seen in the columns `start..` of the sensor.
    fn columns(&self, camera: &Camera, line: &ScanLine, start: usize, columns: usize) -> usize {
        let middle = start + columns / 2;
        let hit = &line.hits[middle];
        let seen = camera.project(hit.x, self.offset as f32, hit.surface.z)[0];
        let from = start as f32 + (middle as f32 - seen).round();
        (from.max(0.0) as usize).min(line.centre.len() - TILE)
    }

    /// Sensor row of the line in column `column`, which takes the light of column `own` of the lit row; `rest` is how
    /// far beyond that line the line stands [mm].
    fn centre(&self, camera: &Camera, line: &ScanLine, own: usize, column: usize, rest: f32) -> f32 {
        let hit = &line.hits[own];
        let surface = &hit.surface;
        let z = surface.z + surface.slope_y * rest;
        let y = self.offset as f32;
        let seen = camera.project(hit.x, y, z)[0];
        let x = (column as f32 - seen) * camera.sight(hit.x, z, 0.0).column_mm;
        let place = camera.project(hit.x + x, y, z + surface.slope_x * x)[1];
        place - camera.laser.at(hit.x, z).bow * line.rows_per_mm[own]
    }
}
