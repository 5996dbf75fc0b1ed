//! A second line, parallel to the first: the same sheet of light again, moved along the motion.
//!
//! It lights the row of the object that stands below it, whose light is worked out already for another position of the
//! scan, and is seen off the first one's plane: where the camera's exact projection puts it. Columns look at other places
//! there, by 0.5 % of x at 5 mm; a tile takes the columns that come nearest, within a column, and heights to first order of
//! what is left. A thin lens that has the first one in focus has not the second, and blurs it along the rows. It stands in
//! the second window of rows where the first does not hold it. Neglected: that the second line meets what it lights from,
//! and the lens sees it at, an angle that differs by offset over distance; its blur along the line, streaks, mirror images, interreflections
//! and lines through films, what pockets let out of its light; what falls outside of both windows.

use std::ops::RangeInclusive;

use super::compositing;
use super::electrons::Scratch;
use super::line_image::{LineShape, draw};
use super::lit_profile::LitProfile;
use crate::optics::camera::Camera;
use crate::optics::light::{ROWS, Row, without_overlap};
use crate::optics::speckle::TILE;
use bench::parameters::LaserParameters;

/// Rows beyond those that even steps would ask for, for steps that are not.
pub(crate) const SPARE_ROWS: usize = 4;

/// The second line.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SecondLine {
    /// How far along the motion it lies [mm].
    offset: f64,
    /// Its light over the first line's [1].
    ratio: f32,
    /// The row that stands below it, from the profile's own.
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

    /// Rows before and behind a profile's own that it stands on.
    pub fn reach(&self) -> [usize; 2] {
        let ahead = self.ahead.unsigned_abs() + SPARE_ROWS;
        if self.ahead < 0 { [ahead, SPARE_ROWS] } else { [SPARE_ROWS, ahead] }
    }

    /// Rows that it may stand on, from a profile's own.
    pub fn rows(&self) -> RangeInclusive<isize> {
        let spare = SPARE_ROWS as isize;
        self.ahead - spare..=self.ahead + spare
    }

    /// Adds it to the windows of a tile.
    pub fn add(&self, lit: &LitProfile<'_>, tile: usize, scratch: &mut Scratch) {
        let LitProfile { camera, geometry, band, profile } = *lit;
        let here = geometry.position(profile as isize) + self.offset;
        let off = |ahead: isize| here - geometry.position(profile as isize + ahead);
        let ahead = self.rows().min_by(|&a, &b| off(a).abs().total_cmp(&off(b).abs())).unwrap_or(self.ahead);
        let row = band.neighbour(profile, ahead);
        let start = tile * TILE;
        let from = self.columns(camera, row, start, scratch.columns);
        let centre = std::array::from_fn(|c| {
            let own = from + c;
            if own < row.hits.len() { self.centre(camera, row, own, start + c, off(ahead) as f32) } else { 0.0 }
        });
        let neighbours: [&Row; ROWS] = std::array::from_fn(|k| band.neighbour(profile, ahead + geometry.neighbours[k]));
        let Scratch { windows, spare, used, .. } = scratch;
        let middle = &row.hits[(from + TILE / 2).min(row.hits.len() - 1)];
        let disc = |y: f32| camera.off_plane_defocus(y, middle.surface.z);
        let blur = disc(self.offset as f32) - disc(0.0);
        let line = LineShape { centre: &centre, blur, profile: camera.laser.line_profile() };
        draw(row, &neighbours, from, &line, spare);
        if *used == 1 && spare.first_row != windows[0].first_row {
            *used = 2;
            windows[1].darken();
            let places: [i32; TILE] =
                std::array::from_fn(|c| without_overlap(spare.first_row[c], windows[0].first_row[c]));
            windows[1].first_row = places;
        }
        compositing::add_shifted(spare, &mut windows[..*used], &[], self.ratio);
    }

    /// First of the columns of the lit row that are seen in the columns `start..` of the sensor.
    fn columns(&self, camera: &Camera, row: &Row, start: usize, columns: usize) -> usize {
        let middle = start + columns / 2;
        let hit = &row.hits[middle];
        let seen = camera.project(hit.x, self.offset as f32, hit.surface.z)[0];
        let from = start as f32 + (middle as f32 - seen).round();
        (from.max(0.0) as usize).min(row.centre.len() - TILE)
    }

    /// Sensor row of the line in column `column`, which takes the light of column `own` of the lit row; `rest` is how far
    /// beyond that row the line stands [mm].
    fn centre(&self, camera: &Camera, row: &Row, own: usize, column: usize, rest: f32) -> f32 {
        let hit = &row.hits[own];
        let surface = &hit.surface;
        let z = surface.z + surface.slope_y * rest;
        let y = self.offset as f32;
        let seen = camera.project(hit.x, y, z)[0];
        let x = (column as f32 - seen) * camera.sight(hit.x, z, 0.0).column_mm;
        let place = camera.project(hit.x + x, y, z + surface.slope_x * x)[1];
        place - camera.laser.at(hit.x, z).bow * row.rows_per_mm[own]
    }
}
