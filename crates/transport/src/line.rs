//! Line source on a body, and the response to it that a lens sees: what the models without tables are asked in a scan.

use std::fmt::Debug;

use base::Body;
use glam::DVec3;

/// Cosine towards the lens that film counts with at least: [`LineSource::power`] holds it, and what light of film that
/// looks away is worth to the lens is its inverse [1].
pub const LEAST_FACING: f32 = 0.5;

/// A line on a body, and the grid on which the answer is wanted.
#[derive(Debug, Clone, Copy)]
pub struct LineSource<'a> {
    /// What the line falls on.
    pub body: &'a Body,
    /// Scan position of the line [mm].
    pub y: f64,
    /// Standard deviation of the line's irradiance across it [mm].
    pub line_mm: f64,
    /// Where each column looks at the line, rising [mm].
    pub x: &'a [f32],
    /// Light that enters below the surface in each column; unit of the answer, 0 where none does.
    pub power: &'a [f32],
    /// Unit vector towards the lens.
    pub view: DVec3,
    /// Pitch of the answer's rows along the scan [mm].
    pub row_mm: f64,
    /// Rows on either side of the central one.
    pub rows: usize,
}

/// Light that comes out around a line, as the lens sees it.
#[derive(Debug, Clone, PartialEq)]
pub struct LineResponse {
    /// Columns of the line.
    pub columns: usize,
    /// Rows on either side of the central one; row 0 at the smallest y.
    pub rows: usize,
    /// Light of each cell in units of `power`, times the radiance factor towards the lens,
    /// `[2 rows + 1, columns]`, row-major. A white Lambertian surface returns what entered.
    pub light: Vec<f32>,
    /// Its standard errors, or empty for a model that has none.
    pub error: Vec<f32>,
}

/// A model that answers one line at a time.
pub trait LineSolver: Debug + Send + Sync {
    /// Light around the line of the profile of that number.
    fn solve(&self, line: &LineSource<'_>, profile: u64) -> LineResponse;
}
