//! A laser line on a body by diffusion on voxels.
//!
//! The light of each column enters along the refracted laser and begins to diffuse at the end of the persistence vector
//! of the medium at the surface; across the line it has the laser's Gaussian. Light that begins above the middle of the
//! uppermost voxel is shared, as the resistances on either side say, between that voxel and the way straight out, so
//! shallow sources are right on coarse voxels too. What leaves at the surface is resampled by overlap to the columns and
//! rows asked for; it leaves as Lambert's law says.
//!
//! Voxel and row blur the answer by about pitch^2 / 12 each in variance. The size of the grid: eight decay lengths
//! of the lit media downwards and to each side, but no more than [`DiffusionSettings`] say and no fewer than eight voxels.
//! Exits of directions (cone light of fibres), gloss and light that crosses air from one part of the surface to another
//! are left out.

use super::grid::Grid;
use super::solver::{self, Solution};
use crate::transport::line::{LineResponse, LineSource};

/// Grid and solver of [`glow`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DiffusionSettings {
    /// Edge of a voxel [mm].
    pub voxel_mm: f64,
    /// Greatest depth below the surface [mm].
    pub depth_mm: f64,
    /// Greatest distance to each side of the lit places [mm].
    pub reach_mm: f64,
    /// Residual over source at which the solver ends [1].
    pub tolerance: f64,
    /// Most steps of the solver.
    pub iterations: usize,
}

impl Default for DiffusionSettings {
    /// Voxels of 0.1 mm, 6 mm deep and 8 mm to each side, to 1e-6: 9 million voxels and 0.7 GB for a board of 94 mm.
    fn default() -> Self {
        Self { voxel_mm: 0.1, depth_mm: 6.0, reach_mm: 8.0, tolerance: 1e-6, iterations: 2000 }
    }
}

/// Where the light of a line went, and what it took to find out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Account {
    /// Light that entered [unit of power].
    pub entered: f64,
    /// Leaves at the surface, in or beside the rows and columns of the answer [unit of power].
    pub left: f64,
    /// Leaves through sides and bottom or the ends of the grid, or entered beside matter [unit of power].
    pub lost: f64,
    /// Absorbed [unit of power].
    pub absorbed: f64,
    /// Voxels of the grid.
    pub voxels: usize,
    /// Steps of the solver.
    pub iterations: usize,
    /// Residual over source [1].
    pub residual: f64,
}

/// Light that comes out around a line; see the head of the file.
pub fn glow(line: &LineSource, settings: &DiffusionSettings) -> LineResponse {
    glow_with_account(line, settings).0
}

/// [`glow`], and where all light went.
pub fn glow_with_account(line: &LineSource, settings: &DiffusionSettings) -> (LineResponse, Account) {
    let rows = 2 * line.rows + 1;
    let columns = line.x.len();
    let mut light = vec![0.0; rows * columns];
    let mut account =
        Account { entered: 0.0, left: 0.0, lost: 0.0, absorbed: 0.0, voxels: 0, iterations: 0, residual: 0.0 };
    if let Some(grid) = Grid::new(line, settings) {
        let voxels = grid.voxels(line);
        let mut exits = vec![0.0; grid.shape[0] * grid.shape[1]];
        let source = grid.source(line, &voxels, &mut exits, &mut account);
        let Solution { phi, iterations, residual } =
            solver::solve(&voxels, source, settings.tolerance, settings.iterations);
        exits.iter_mut().zip(voxels.exits(&phi)).for_each(|(sum, own)| *sum += own);
        account.left = exits.iter().sum();
        account.lost += voxels.drained(&phi);
        account.absorbed = voxels.absorbed(&phi);
        (account.voxels, account.iterations, account.residual) = (voxels.len(), iterations, residual);
        grid.resample(line, &exits, &mut light);
    }
    let light = light.into_iter().map(|v| v as f32).collect();
    (LineResponse { columns, rows: line.rows, light, error: Vec::new() }, account)
}
