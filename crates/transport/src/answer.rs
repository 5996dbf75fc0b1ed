//! Answers of the transport models: reflectance, transmittance, absorption and spreads of a stack under a thin vertical
//! beam or line of unit energy.

use serde::Serialize;

/// A number and its standard error; 0 where the model has no statistical error.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Estimate {
    /// Best value.
    pub value: f64,
    /// Standard error of it.
    pub error: f64,
}

impl Estimate {
    /// A number without statistical error.
    pub fn exact(value: f64) -> Self {
        Self { value, error: 0.0 }
    }

    /// Mean and standard error of the mean of `parts`, which are independent and alike.
    pub fn of(parts: impl ExactSizeIterator<Item = f64> + Clone) -> Self {
        let n = parts.len() as f64;
        let mean = parts.clone().sum::<f64>() / n;
        let spread = parts.map(|part| (part - mean).powi(2)).sum::<f64>();
        Self { value: mean, error: (spread / (n * (n - 1.0)).max(1.0)).sqrt() }
    }
}

/// What is asked: incidence, view and the grids of the answer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Question {
    /// Angle of incidence against the normal [rad]; `None` for diffuse light (Lambert's law).
    pub incidence: Option<f64>,
    /// Azimuth of the incident light's travel, 0 towards +x, a quarter turn towards +y [rad].
    pub incidence_azimuth: f64,
    /// Unit vector towards the lens, outside; z < 0 for a lens below the last layer.
    pub view: glam::DVec3,
    /// Standard deviation of the laser line along y [mm]; blurs the line spread alone.
    pub line_mm: f64,
    /// Pitch of the line spread [mm].
    pub row_mm: f64,
    /// Rows of the line spread on either side of the central one.
    pub rows: usize,
    /// Pitch of the point spread [mm].
    pub cell_mm: f64,
    /// Cells of the point spread on either side of the central one; 0 for none.
    pub cells: usize,
    /// Bins of the cosine of the angle of exit, even in the angle.
    pub angles: usize,
}

impl Default for Question {
    /// Normal incidence, a camera at 25 degrees on the side of small y, rows as the reference camera sees them.
    fn default() -> Self {
        let (sin, cos) = libm::sincos(25f64.to_radians());
        Self {
            incidence: Some(0.0),
            incidence_azimuth: 0.0,
            view: glam::DVec3::new(0.0, -sin, cos),
            line_mm: 0.05,
            row_mm: 0.101,
            rows: 40,
            cell_mm: 0.1,
            cells: 30,
            angles: 30,
        }
    }
}

/// Light into a range of angles.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct AngleBin {
    /// Ends of the bin against the normal [deg].
    pub from_deg: f64,
    /// The other end [deg].
    pub to_deg: f64,
    /// Diffusely reflected light into the bin, over its solid angle [sr^-1].
    pub reflected: Estimate,
    /// Transmitted light that was scattered, over the solid angle [sr^-1].
    pub transmitted: Estimate,
}

/// Everything that a model says; shares are of the incident energy.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Answer {
    /// Which model: path, diffusion or kernel.
    pub model: String,
    /// Thrown back by the first surface [1].
    pub specular: f64,
    /// Diffuse reflectance, without `specular` [1].
    pub reflectance: Estimate,
    /// Leaves at the bottom, scattered or not [1].
    pub transmittance: Estimate,
    /// Part of it that was never scattered [1].
    pub unscattered: Estimate,
    /// Absorbed in each layer [1].
    pub absorbed: Vec<Estimate>,
    /// Radiance factor towards the lens, pi L / E [1]; `None` where the model has none.
    pub towards_lens: Option<Estimate>,
    /// The same from light counted in a cone of 5 degrees about the lens [1]; `None` where the model has none.
    pub cone: Option<Estimate>,
    /// Exit angles; empty where the model has none.
    pub angles: Vec<AngleBin>,
    /// Pitch of `line` [mm].
    pub row_mm: f64,
    /// Share of a line's energy that leaves in each row along y, `[2 rows + 1]`, row 0 at the smallest y [1].
    pub line: Vec<Estimate>,
    /// Radiance factor of each row of a line, `[2 rows + 1]` [1]; empty where the model has none. Monte Carlo estimates
    /// it at each collision; where planes inside mirror light it counts what leaves within 5 degrees of the lens, at
    /// all azimuths where they are alike.
    pub seen: Vec<Estimate>,
    /// Pitch of `point` [mm].
    pub cell_mm: f64,
    /// Share of a beam's energy that leaves in each cell, `[2 cells + 1, 2 cells + 1]`, row-major, rows along y [1].
    pub point: Vec<Estimate>,
}

impl Answer {
    /// Sum of rows `from..=to` of the line spread on both sides, or of one side alone [1].
    pub fn rows(&self, from: usize, to: usize, side: LineSide) -> f64 {
        let centre = self.line.len() / 2;
        let at = |i: usize| self.line.get(i).map_or(0.0, |e| e.value);
        let row = |k: usize| match side {
            LineSide::Both if k == 0 => at(centre),
            LineSide::Both => at(centre + k) + at(centre - k),
            LineSide::Ahead => at(centre + k),
            LineSide::Behind => at(centre - k),
        };
        (from..=to.min(centre)).map(row).sum()
    }
}

/// Rows of which side of the line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LineSide {
    /// Both.
    Both,
    /// At larger y.
    Ahead,
    /// At smaller y.
    Behind,
}
