//! A stack of slices as wood: densities on a grid, and the board that is cut out of them.
//!
//! `DensityStack --push, finish--> WoodVolume --cut--> SlicedWood`, which a board is laid of
//! (`procedural::wood::Plank::lay`).
//!
//! Model: the density at a point is that of the eight voxels around it, each by its nearness along each axis
//! (trilinear), and the law of
//! [`crate::DensityLaw`] makes coefficients of it. Voxels finer than 0.05 mm, a little below the columns and profiles
//! of scans (0.06 to 0.1 mm), are put together as they come in. They become blocks of whole numbers of voxels along
//! each axis, each the mean of its voxels, so that lumina and walls count by their shares of the volume and nothing
//! finer than a column is sampled by chance. What fills no block at the end of an axis is left out, less than 0.05 mm.
//! Fibres run along one axis of the stack; the side of its first row (of its first slice, where fibres run in the
//! slices) lies up unless quarter turns about the fibres put another side there. Stacks are seen from their first
//! slice, and no wood is mirrored unless asked for. Limits: fibres are straight and parallel to the axis, knots and
//! rings are densities alone; nothing is labelled; the pith is assumed below the face.

mod air;

use std::sync::Arc;

pub use self::air::StackPlace;

use base::{Class, Instance, words};
use glam::{Vec2, Vec3};
use procedural::wood::{GivenMatter, GivenWood, Wood};

use crate::density_law::AIR_KG_PER_M3;
use crate::{DensityLaw, KindDensities, VolumeFault};

/// Voxels are no finer than this once they are put together [mm].
const FINEST_MM: f32 = 0.05;
/// Least side of what a stack shows [mm]: the thinnest board.
const LEAST_MM: f32 = 1.0;
/// Most voxels that are kept, 256 MiB.
const MOST_VOXELS: usize = 64 << 20;
/// Mean densities of wood, balsa to lignum vitae [kg/m^3].
const MEANS_KG_PER_M3: [f32; 2] = [100.0, 1300.0];
/// Least standard deviation of the densities over their mean [1]: earlywood and latewood differ by a factor of 2.
const LEAST_SPREAD: f32 = 0.01;
/// Most of the voxels that may be air [1]: the vessels of oak take a quarter.
const MOST_AIR: f32 = 0.3;

words! {
    /// Which axis of the stack the fibres run along.
    FibreAxis {
        /// From slice to slice: each shows a cross-section.
        Through = "through",
        /// Down the rows of each slice; the last row is the near end of boards.
        Down = "down",
        /// Along the rows of each slice.
        Across = "across",
    }
}

impl FibreAxis {
    /// The stack's axes (through, down, across) of a board's length, width and depth.
    fn order(self) -> [usize; 3] {
        match self {
            Self::Through => [0, 2, 1],
            Self::Down => [1, 2, 0],
            Self::Across => [2, 1, 0],
        }
    }
}

/// Slices that come in one by one.
#[derive(Debug, Clone, PartialEq)]
pub struct DensityStack {
    /// Voxels through, down and across the slices.
    size: [usize; 3],
    voxel_mm: [f32; 3],
    fibres: FibreAxis,
    /// Voxels that are put together along each axis.
    block: [usize; 3],
    /// Sums over blocks [kg/m^3].
    sums: Vec<f32>,
    pushed: usize,
}

impl DensityStack {
    /// A stack of so many slices, rows and columns, and the size of a voxel along the same axes.
    ///
    /// # Errors
    /// Too little wood, or more voxels than are kept.
    pub fn new(size: [usize; 3], voxel_mm: [f32; 3], fibres: FibreAxis) -> Result<Self, VolumeFault> {
        let extent_mm = [0, 1, 2].map(|i| size[i] as f32 * voxel_mm[i]);
        if extent_mm.iter().any(|side| *side < LEAST_MM) {
            return Err(VolumeFault::TooSmall { extent_mm, least_mm: LEAST_MM });
        }
        let block = voxel_mm.map(|side| ((FINEST_MM / side - 1.0e-3).ceil() as usize).max(1));
        let kept = [0, 1, 2].map(|i| size[i] / block[i]);
        let voxels = kept.iter().fold(1, |product: usize, count| product.saturating_mul(*count));
        if voxels > MOST_VOXELS {
            return Err(VolumeFault::Large { voxels, most: MOST_VOXELS });
        }
        Ok(Self { size, voxel_mm, fibres, block, sums: vec![0.0; voxels], pushed: 0 })
    }

    /// Blocks along each axis.
    fn kept(&self) -> [usize; 3] {
        [0, 1, 2].map(|i| self.size[i] / self.block[i])
    }

    /// Takes the densities of the next slice, row by row [kg/m^3].
    ///
    /// # Panics
    /// Where it has another number of voxels than a slice of the stack.
    pub fn push(&mut self, slice: &[f32]) {
        let [_, rows, cols] = self.size;
        assert_eq!(slice.len(), rows * cols, "a density for each voxel");
        let [kept, kept_rows, kept_cols] = self.kept();
        let layer = self.pushed / self.block[0];
        self.pushed += 1;
        if layer >= kept {
            return;
        }
        for (row, line) in slice.chunks_exact(cols).take(kept_rows * self.block[1]).enumerate() {
            let first = (layer * kept_rows + row / self.block[1]) * kept_cols;
            let sums = &mut self.sums[first..first + kept_cols];
            for (sum, voxels) in sums.iter_mut().zip(line.chunks_exact(self.block[2])) {
                *sum += voxels.iter().sum::<f32>();
            }
        }
    }

    /// The wood of the whole stack.
    ///
    /// # Errors
    /// Densities that are none of wood.
    ///
    /// # Panics
    /// Where slices are missing.
    pub fn finish(self, kinds: KindDensities) -> Result<WoodVolume, VolumeFault> {
        let volume = self.volume(kinds);
        volume.check()?;
        Ok(volume)
    }

    fn volume(self, kinds: KindDensities) -> WoodVolume {
        assert_eq!(self.pushed, self.size[0], "all slices");
        let share = 1.0 / self.block.iter().product::<usize>() as f32;
        WoodVolume {
            size: self.kept(),
            voxel_mm: [0, 1, 2].map(|i| self.voxel_mm[i] * self.block[i] as f32),
            densities: self.sums.into_iter().map(|sum| sum * share).collect(),
            fibres: self.fibres,
            kinds,
        }
    }
}

/// Wood as densities on a grid.
#[derive(Debug, Clone, PartialEq)]
pub struct WoodVolume {
    /// Voxels through, down and across the slices.
    size: [usize; 3],
    voxel_mm: [f32; 3],
    /// Across fastest, then down, then through [kg/m^3].
    densities: Vec<f32>,
    fibres: FibreAxis,
    kinds: KindDensities,
}

impl WoodVolume {
    /// Whether its densities are those of wood.
    fn check(&self) -> Result<(), VolumeFault> {
        let count = self.densities.len() as f64;
        let mean = (self.densities.iter().map(|density| f64::from(*density)).sum::<f64>() / count) as f32;
        let [least, most] = MEANS_KG_PER_M3;
        if !(least..=most).contains(&mean) {
            return Err(VolumeFault::Mean { mean, least, most });
        }
        let air = self.densities.iter().filter(|density| **density < AIR_KG_PER_M3).count();
        let share = (air as f64 / count) as f32;
        if share > MOST_AIR {
            return Err(VolumeFault::Air { share, density: AIR_KG_PER_M3, wood_mm: self.wood_in_slices_mm() });
        }
        let squares = self.densities.iter().map(|density| f64::from(density - mean).powi(2)).sum::<f64>();
        let spread = (squares / count).sqrt() as f32 / mean;
        if spread < LEAST_SPREAD {
            return Err(VolumeFault::Even { spread });
        }
        Ok(())
    }

    /// Length along the fibres, width and depth of the wood as it lies without quarter turns [mm].
    pub fn extent_mm(&self) -> [f32; 3] {
        self.fibres.order().map(|axis| self.size[axis] as f32 * self.voxel_mm[axis])
    }

    /// The wood of a board as large as `wood` says, at the place that it says, with its media. A board that is larger
    /// than the stack gets the voxels at its sides beyond them.
    pub fn cut(self: &Arc<Self>, wood: &Wood) -> SlicedWood {
        let (board, place) = (&wood.board, &wood.slices);
        let quarter_turns = place.quarter_turns.round() as u8;
        let [along, across, depth] = self.corner_mm(&StackPlace {
            board_mm: [board.length_mm, board.width_mm, board.thickness_mm],
            shares: [place.along, place.across, place.depth],
            quarter_turns,
        });
        let turned = place.turned > 0.5;
        SlicedWood {
            volume: Arc::clone(self),
            law: DensityLaw::new(&wood.media, self.kinds),
            n_eff: wood.media.clear_n_eff as f32,
            board_mm: Vec2::new(board.width_mm as f32, board.length_mm as f32),
            corner: Vec3::new(across, along, depth),
            quarter_turns,
            turned,
            flipped: (place.mirrored > 0.5) != turned,
        }
    }

    /// Density at a place (length, width, depth) of the wood as it lies without quarter turns [mm] [kg/m^3].
    fn density(&self, [along, across, depth]: [f32; 3]) -> f32 {
        let along = if self.fibres == FibreAxis::Down { self.extent_mm()[0] - along } else { along };
        let mut at = [0.0; 3];
        for (axis, mm) in self.fibres.order().into_iter().zip([along, across, depth]) {
            at[axis] = mm / self.voxel_mm[axis] - 0.5;
        }
        let near = |axis: usize| {
            let last = self.size[axis] - 1;
            let at = at[axis].clamp(0.0, last as f32);
            let low = at as usize;
            [(low, 1.0 - (at - low as f32)), ((low + 1).min(last), at - low as f32)]
        };
        let [_, rows, cols] = self.size;
        let mut density = 0.0;
        for (slice, through) in near(0) {
            for (row, down) in near(1) {
                for (col, along) in near(2) {
                    density += through * down * along * self.densities[(slice * rows + row) * cols + col];
                }
            }
        }
        density
    }
}

/// The wood of one board from a stack of slices.
#[derive(Debug, Clone, PartialEq)]
pub struct SlicedWood {
    volume: Arc<WoodVolume>,
    law: DensityLaw,
    n_eff: f32,
    /// Width and length [mm].
    board_mm: Vec2,
    /// The board's near left corner in the stack as it is turned (across, along, depth) [mm].
    corner: Vec3,
    quarter_turns: u8,
    /// Whether the near end is the stack's far one.
    turned: bool,
    /// Whether the left side is the stack's right one.
    flipped: bool,
}

impl SlicedWood {
    /// Density at a place from the board's near left corner and a depth below its face [mm] [kg/m^3].
    pub fn density(&self, place: Vec2, depth_mm: f32) -> f32 {
        let x = if self.flipped { self.board_mm.x - place.x } else { place.x };
        let y = if self.turned { self.board_mm.y - place.y } else { place.y };
        let Vec3 { x: across, y: along, z: depth } = self.corner + Vec3::new(x, y, depth_mm);
        self.volume.turned_density(self.quarter_turns, [along, across, depth])
    }
}

impl GivenWood for SlicedWood {
    fn at(&self, place: Vec2, depth_mm: f32) -> GivenMatter {
        let [mu_a, sigma_i, k] = self.law.at(self.density(place, depth_mm));
        let (n_eff, fibre) = (self.n_eff, Vec3::Y);
        GivenMatter { mu_a, sigma_i, k, n_eff, fibre, disturbed: 0.0, class: Class::Clear, instance: 0 }
    }

    fn instances(&self) -> Vec<Instance> {
        Vec::new()
    }

    fn azimuth_deg(&self) -> f32 {
        0.0
    }

    fn pith_is_above(&self) -> bool {
        false
    }
}

#[cfg(test)]
mod tests;
