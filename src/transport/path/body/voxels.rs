//! The matter of a body as light walks it: the medium at the middle of each cell, asked for when light first comes there.
//!
//! A body of wood takes most of a microsecond to say what stands at a point, and light asks a hundred times a photon.
//! What it says is the same whoever asks first, so cells that threads fill together do not depend on their number.

use std::sync::OnceLock;

use glam::DVec3;
use procedural::Medium;
use procedural::body::Slice;

use super::relief::{Cell, Relief};

/// Cells along a block's edge: blocks are only there where light has been.
const BLOCK: usize = 4;

type Block = Box<[OnceLock<Medium>]>;

/// The media about a line of light.
#[derive(Debug)]
pub(super) struct Voxels<'a> {
    relief: Relief,
    cuts: Vec<Slice<'a>>,
    blocks: Vec<OnceLock<Block>>,
    /// Blocks along x and y.
    side: [usize; 2],
}

impl<'a> Voxels<'a> {
    /// No medium is known yet.
    pub fn new(relief: Relief, cuts: Vec<Slice<'a>>) -> Self {
        let [nx, ny, nz] = relief.cells.map(|cells| cells.div_ceil(BLOCK));
        Self { relief, cuts, blocks: (0..nx * ny * nz).map(|_| OnceLock::new()).collect(), side: [nx, ny] }
    }

    /// The shape of the body.
    #[inline(always)]
    pub fn relief(&self) -> &Relief {
        &self.relief
    }

    /// The medium of a cell.
    #[inline(always)]
    pub fn at(&self, cell: Cell) -> &Medium {
        let [bx, by, bz] = cell.map(|c| c / BLOCK);
        let [x, y, z] = cell.map(|c| c % BLOCK);
        let block = &self.blocks[(bz * self.side[1] + by) * self.side[0] + bx];
        let block = block.get_or_init(|| (0..BLOCK * BLOCK * BLOCK).map(|_| OnceLock::new()).collect());
        block[(z * BLOCK + y) * BLOCK + x].get_or_init(|| {
            let middle = self.relief.middle(cell);
            self.cuts[cell[1]].matter(middle.x as f32, middle.z as f32).medium
        })
    }
}

/// Extinction, null collisions included [mm^-1].
#[inline(always)]
pub(super) fn extinction(medium: &Medium) -> f64 {
    f64::from(medium.mu_a) + f64::from(medium.sigma_i) + f64::from(medium.k)
}

/// Axis of the fibres.
#[inline(always)]
pub(super) fn axis(medium: &Medium) -> DVec3 {
    medium.fibre.as_dvec3()
}
