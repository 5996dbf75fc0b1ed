//! Per-line models: light from below by a model that answers one line at a time, laid on the sensor.
//!
//! The pipeline hands the model in as a [`LineSolver`]. It answers on cells of the body around the line, columns of the
//! sensor times rows along the scan ([`LineResponse`]). Each cell is laid on the sensor's rows where the body's surface
//! there is seen, with the blur of lens and pixel; the laser's width is in the answer already. The lens blurs along the
//! line too. Neglected: light stays in its column, and one direction of view serves the whole line, that of its middle.

use crate::optics::camera::Camera;
use crate::optics::light::{ROWS, ScanLine, WindowNeed, blur_varying, window_start};
use crate::optics::speckle::TILE;
use crate::specimen::Specimen;
use numerics::lanes::exp;
use transport::line::{LineResponse, LineSolver, LineSource};

/// Pitch of the answer along the scan, about half a sensor row [mm].
const ROW_MM: f64 = 0.05;
/// Standard deviations of lens and pixel beyond which light is left out.
const REACH_SIGMAS: f32 = 5.0;

/// A model that answers one line at a time, over one body.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PerLine<'a> {
    /// The body under camera and laser.
    pub specimen: &'a Specimen,
    /// Camera and laser.
    pub camera: &'a Camera,
    /// The model.
    pub solver: &'a dyn LineSolver,
}

impl PerLine<'_> {
    /// Electrons from below in both windows of every column of `profile`, `[ROWS][columns]` each, columns padded to
    /// whole tiles, the second empty where one is enough; the profile stands at scan position `y` [mm], on the scan
    /// line `line`.
    pub fn volume(&self, line: &ScanLine, profile: u64, y: f64) -> [Vec<f32>; 2] {
        let columns = line.hits.len();
        let height = line.hits.iter().map(|hit| hit.surface.z).fold(0.0, f32::max);
        // Bare columns stand where they would see the body.
        let mut x: Vec<f32> = Vec::with_capacity(columns);
        for (column, hit) in line.hits.iter().enumerate() {
            let bare = self.camera.rig.along(column as f64, f64::from(height)) as f32;
            let own = if line.entered_light[column] > 0.0 { hit.x } else { bare };
            let floor = x.last().map_or(f32::NEG_INFINITY, |last| last + 1e-3);
            x.push(own.max(floor));
        }
        let middle = self.camera.sight(0.0, height, 0.0);
        let line_mm = f64::from(middle.laser_variance.sqrt() / middle.rows_per_mm);
        // As far as the windows lie beside the line's own.
        let away = |column: usize| {
            let own = window_start(line.centre[column]);
            window_starts(line, column).into_iter().flatten().map(|start| start.abs_diff(own)).max().unwrap_or(0)
        };
        let aside = (0..columns).map(away).max().unwrap_or(0);
        let reach = (ROWS as f64 / 2.0 + f64::from(aside)) / f64::from(middle.rows_per_mm) + 3.0 * line_mm;
        let source = LineSource {
            body: self.specimen.body(),
            y,
            line_mm,
            x: &x,
            power: &line.entered_light,
            view: middle.view.as_dvec3(),
            row_mm: ROW_MM,
            rows: (reach / ROW_MM).ceil() as usize,
        };
        self.project(&self.solver.solve(&source, profile), line, &source)
    }

    /// Lays an answer on the sensor.
    fn project(&self, response: &LineResponse, line: &ScanLine, of: &LineSource) -> [Vec<f32>; 2] {
        let columns = response.columns;
        let padded = columns.next_multiple_of(TILE);
        let second = if line.secondary.is_some() { ROWS * padded } else { 0 };
        let mut windows = [vec![0.0; ROWS * padded], vec![0.0; second]];
        let (mut cells, mut buffer) = (vec![0.0; columns], Vec::new());
        let defocus: Vec<f32> = line.hits.iter().map(|hit| self.camera.defocus(0.0, hit.surface.z)[0]).collect();
        for (i, light) in response.light.chunks_exact(columns).enumerate() {
            cells.copy_from_slice(light);
            blur_varying(&mut cells, self.camera.blur_variance, &defocus, [1.0; 2], &mut buffer);
            let y = (i as f64 - response.rows as f64) * ROW_MM;
            let cut = of.body.slice((of.y + y) as f32);
            for (column, &electrons) in cells.iter().enumerate() {
                if electrons == 0.0 {
                    continue;
                }
                // Beside the body light is seen as if the line's height went on.
                let (place, z) = match cut.surface(of.x[column]) {
                    Some(surface) => {
                        (self.camera.project(of.x[column], y as f32, surface.z)[1] + line.moved_px, surface.z)
                    }
                    None => (line.centre[column] - y as f32 * line.rows_per_mm[column], line.hits[column].surface.z),
                };
                let variance = self.camera.lens_variance() + self.camera.defocus(y as f32, z)[1];
                let scale = 0.398_942_3 / variance.sqrt() * electrons;
                let reach = REACH_SIGMAS * variance.sqrt();
                for (window, start) in windows.iter_mut().zip(window_starts(line, column)) {
                    let Some(start) = start else { continue };
                    let place = place - start as f32;
                    let (low, high) = ((place - reach).ceil().max(0.0), (place + reach).floor().min(ROWS as f32 - 1.0));
                    for k in low as usize..(high + 1.0).max(0.0) as usize {
                        let d = k as f32 - place;
                        window[k * padded + column] += scale * exp(-0.5 * d * d / variance);
                    }
                }
            }
        }
        windows
    }
}

/// First rows of the windows of a column, as [`super::compositing::stand`] puts them [px].
fn window_starts(line: &ScanLine, column: usize) -> [Option<i32>; 2] {
    let own = [Some(window_start(line.centre[column])), None];
    line.secondary.as_ref().map_or(own, |secondary| match secondary.needs[column / TILE] {
        WindowNeed::Line => own,
        WindowNeed::One => [Some(secondary.windows[0][column]), None],
        WindowNeed::Two => secondary.windows.each_ref().map(|window| Some(window[column])),
    })
}
