//! The matter of a body as light walks it: the medium at the middle of each cell, asked for when light first comes
//! there.
//!
//! A body of wood takes most of a microsecond to say what stands at a point, and light asks a hundred times a photon.
//! What it says is the same whoever asks first, so cells that threads fill together do not depend on their number.

use std::sync::OnceLock;

use base::{Medium, Slice};
use glam::DVec3;

use super::height_field::{CellIndex, HeightField};

/// Cells along a block's edge: blocks are only there where light has been.
const BLOCK_CELLS: usize = 4;

type Block = Box<[OnceLock<Medium>]>;

/// The media about a line of light.
#[derive(Debug)]
pub(super) struct MediumCache<'a> {
    heights: HeightField,
    cuts: Vec<Box<dyn Slice + 'a>>,
    blocks: Vec<OnceLock<Block>>,
    /// Share of light that passes the face's coat in each cell along x and y, x fastest [1].
    coats: Vec<OnceLock<f64>>,
    /// Blocks along x and y.
    side: [usize; 2],
}

impl<'a> MediumCache<'a> {
    /// No medium is known yet.
    pub fn new(heights: HeightField, cuts: Vec<Box<dyn Slice + 'a>>) -> Self {
        let [nx, ny, nz] = heights.cells.map(|cells| cells.div_ceil(BLOCK_CELLS));
        let coats = (0..heights.cells[0] * heights.cells[1]).map(|_| OnceLock::new()).collect();
        Self { heights, cuts, blocks: (0..nx * ny * nz).map(|_| OnceLock::new()).collect(), coats, side: [nx, ny] }
    }

    /// The shape of the body.
    #[inline(always)]
    pub fn heights(&self) -> &HeightField {
        &self.heights
    }

    /// Share of light that passes the coat of the face over a cell [1].
    pub fn coat(&self, cell: CellIndex) -> f64 {
        *self.coats[cell[1] * self.heights.cells[0] + cell[0]].get_or_init(|| {
            let middle = self.heights.middle(cell);
            let z = self.heights.above(middle).unwrap_or(middle.z);
            f64::from(self.cuts[cell[1]].matter(middle.x as f32, z as f32).medium.coat)
        })
    }

    /// The medium of a cell.
    #[inline(always)]
    pub fn at(&self, cell: CellIndex) -> &Medium {
        let [bx, by, bz] = cell.map(|c| c / BLOCK_CELLS);
        let [x, y, z] = cell.map(|c| c % BLOCK_CELLS);
        let block = &self.blocks[(bz * self.side[1] + by) * self.side[0] + bx];
        let block =
            block.get_or_init(|| (0..BLOCK_CELLS * BLOCK_CELLS * BLOCK_CELLS).map(|_| OnceLock::new()).collect());
        block[(z * BLOCK_CELLS + y) * BLOCK_CELLS + x].get_or_init(|| {
            let middle = self.heights.middle(cell);
            self.cuts[cell[1]].matter(middle.x as f32, middle.z as f32).medium
        })
    }
}

/// Extinction, null collisions included [mm^-1].
#[inline(always)]
pub(super) fn extinction(medium: &Medium) -> f64 {
    f64::from(medium.mu_a) + f64::from(medium.sigma_i) + f64::from(medium.k)
}

/// Dispersion of the fibres [rad].
#[inline(always)]
pub(super) fn dispersion(medium: &Medium) -> f64 {
    f64::from(medium.dispersion_deg).to_radians()
}

/// Axis of the fibres.
#[inline(always)]
pub(super) fn axis(medium: &Medium) -> DVec3 {
    medium.fibre.as_dvec3()
}
