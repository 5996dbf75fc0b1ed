//! Height field of a body on square cells, and rays through it.
//!
//! Model: heights at the nodes of a grid, bilinear between them (a hyperbolic paraboloid a cell), 0 beside the body;
//! the body is what lies between the conveyor and that surface. So the walls of cracks and the body's sides are surface
//! like the rest, upright but for one cell's width, and stand on average where they should: nodes lie half a cell off
//! the body's border.
//!
//! A ray is followed from cell to cell, and crosses the surface within each as [`BilinearPatch`] says. Nothing is
//! skipped, however long the ray: no gap that the grid holds can be jumped. Gaps under two cells are not held.

use base::Slice;
use glam::DVec3;

use super::super::bilinear_patch::BilinearPatch;
use super::super::height_cells::{HeightCells, TARGET_PITCH_MM};
use super::WALL_SLOPE;
use transport::line::LineSource;

/// Cells over which slopes are averaged for light towards the lens.
const LEAN_CELLS: usize = 10;

/// Cell numbers along x, y, z.
pub(super) type CellIndex = [usize; 3];

/// The height field about a line of light.
#[derive(Debug)]
pub(super) struct HeightField {
    /// Place of the first node, on the conveyor [mm].
    low: DVec3,
    /// Size of cells [mm].
    pub pitch: DVec3,
    /// Cells along x, y, z.
    pub cells: CellIndex,
    /// Heights of nodes, x fastest [mm].
    height: Vec<f64>,
    /// Lowest node of each cell [mm].
    floor: Vec<f64>,
    /// Highest node [mm].
    top: f64,
    /// Mean normals over squares of [`LEAN_CELLS`] cells.
    lean: Vec<DVec3>,
    /// Highest node within one square of each square [mm].
    around: Vec<f64>,
}

/// What ended a direction, and its length [mm].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum RayEnd {
    /// The visitor.
    Taken(f64),
    /// The surface of this cell.
    Surface(f64, CellIndex),
    /// The conveyor.
    Ground(f64),
    /// The region's end, or the open sky.
    Beyond(f64),
}

impl HeightField {
    /// The region about `line`, and the body's cuts through the middle of its cells, one for each along y.
    pub fn new<'a>(line: &LineSource<'a>) -> (Self, Vec<Box<dyn Slice + 'a>>) {
        let (low, high) = line.body.bounds();
        let (low, high) = (low.as_dvec3(), high.as_dvec3());
        let grid = HeightCells::about(line, [low.truncate(), high.truncate()]);
        let [nx, ny] = grid.size;
        let y = |j: f64| (grid.low.y + j * grid.pitch.y) as f32;
        let mut heights = Self {
            low: grid.low.extend(0.0),
            pitch: grid.pitch.extend(TARGET_PITCH_MM),
            cells: [nx, ny, (high.z / TARGET_PITCH_MM).ceil().max(1.0) as usize + 1],
            height: Vec::with_capacity((nx + 1) * (ny + 1)),
            floor: Vec::with_capacity(nx * ny),
            top: 0.0,
            lean: Vec::new(),
            around: Vec::new(),
        };
        let mut slopes = Vec::with_capacity((nx + 1) * (ny + 1));
        for j in 0..=ny {
            let slice = line.body.slice(y(j as f64));
            for i in 0..=nx {
                let surface = slice.surface((grid.low.x + i as f64 * grid.pitch.x) as f32);
                heights.height.push(surface.map_or(0.0, |s| f64::from(s.z).max(0.0)));
                slopes.push(surface.map(|s| [f64::from(s.slope_x), f64::from(s.slope_y)]));
            }
        }
        heights.top = heights.height.iter().copied().fold(0.0, f64::max);
        for cell in 0..nx * ny {
            heights.floor.push(heights.patch(cell % nx, cell / nx).0.into_iter().fold(f64::INFINITY, f64::min));
        }
        heights.summarise(&slopes);
        let cuts = (0..ny).map(|j| line.body.slice(y(j as f64 + 0.5))).collect();
        (heights, cuts)
    }

    /// Mean normals and heights over squares. Walls do not count, neither those between nodes nor the steep ones of a
    /// wedge: beside a crack they would have the face lean by tens of degrees.
    fn summarise(&mut self, slopes: &[Option<[f64; 2]>]) {
        let [nx, ny, _] = self.cells;
        let (sx, sy) = (nx / LEAN_CELLS + 1, ny / LEAN_CELLS + 1);
        let nodes = |s: usize, n: usize| s * LEAN_CELLS..=((s + 1) * LEAN_CELLS).min(n);
        let mut tops = Vec::with_capacity(sx * sy);
        for square in 0..sx * sy {
            let (mut sum, mut count, mut top) = ([0.0; 2], 0.0, 0f64);
            for j in nodes(square / sx, ny) {
                for i in nodes(square % sx, nx) {
                    top = top.max(self.height[j * (nx + 1) + i]);
                    let face = |[x, y]: &[f64; 2]| libm::hypot(*x, *y) <= WALL_SLOPE;
                    if let Some(slope) = slopes[j * (nx + 1) + i].filter(face) {
                        sum = [sum[0] + slope[0], sum[1] + slope[1]];
                        count += 1.0;
                    }
                }
            }
            let n = f64::max(count, 1.0);
            self.lean.push(DVec3::new(-sum[0] / n, -sum[1] / n, 1.0).normalize());
            tops.push(top);
        }
        let near = |s: usize, n: usize| s.saturating_sub(1)..=(s + 1).min(n - 1);
        for square in 0..sx * sy {
            let rows = near(square / sx, sy).flat_map(|j| near(square % sx, sx).map(move |i| j * sx + i));
            self.around.push(rows.map(|at| tops[at]).fold(0.0, f64::max));
        }
    }

    /// The surface of a cell.
    #[inline(always)]
    fn patch(&self, i: usize, j: usize) -> BilinearPatch {
        let (at, row) = (j * (self.cells[0] + 1) + i, self.cells[0] + 1);
        BilinearPatch([self.height[at], self.height[at + 1], self.height[at + row], self.height[at + row + 1]])
    }

    /// The cell that holds a point; the nearest one outside the region.
    #[inline]
    pub fn cell(&self, position: DVec3) -> CellIndex {
        let local = (position - self.low) / self.pitch;
        // Casts of negative numbers give 0.
        std::array::from_fn(|axis| (local[axis] as usize).min(self.cells[axis] - 1))
    }

    /// Middle of a cell [mm].
    pub fn middle(&self, cell: CellIndex) -> DVec3 {
        self.low + (DVec3::new(cell[0] as f64, cell[1] as f64, cell[2] as f64) + 0.5) * self.pitch
    }

    fn square(&self, cell: CellIndex) -> usize {
        (cell[1] / LEAN_CELLS) * (self.cells[0] / LEAN_CELLS + 1) + cell[0] / LEAN_CELLS
    }

    /// Normal of the body's own surface, averaged over about a mm.
    #[inline]
    pub fn lean(&self, cell: CellIndex) -> DVec3 {
        self.lean[self.square(cell)]
    }

    /// Highest surface within a mm or more [mm].
    #[inline]
    pub fn around(&self, cell: CellIndex) -> f64 {
        self.around[self.square(cell)]
    }

    /// Surface above a point [mm]; `None` beside the body or the region.
    pub fn above(&self, position: DVec3) -> Option<f64> {
        let local = (position - self.low) / self.pitch;
        let inside = |axis: usize| local[axis] >= 0.0 && local[axis] < self.cells[axis] as f64;
        if !inside(0) || !inside(1) {
            return None;
        }
        let (i, j) = (local.x as usize, local.y as usize);
        let (u, v) = (local.x - i as f64, local.y - j as f64);
        let height = self.patch(i, j).height(u, v);
        (height > 0.0).then_some(height)
    }

    /// Where the body begins along y in each cell along x; `None` where it does so before the rows that are asked for,
    /// or nowhere [mm].
    pub fn fronts(&self, line: &LineSource) -> Vec<Option<f64>> {
        let first_row = line.y - line.row_mm * (line.rows as f64 + 0.5);
        let nodes = self.cells[0] + 1;
        let front = |i: usize| {
            let first = (0..=self.cells[1]).find(|j| self.height[j * nodes + i] > 0.0).filter(|&j| j > 0)?;
            Some(self.low.y + (first as f64 - 0.5) * self.pitch.y).filter(|&front| front > first_row)
        };
        (0..self.cells[0]).map(front).collect()
    }

    /// Outward normal of a cell's surface above a point.
    pub fn normal(&self, cell: CellIndex, position: DVec3) -> DVec3 {
        let local = (position - self.low) / self.pitch;
        let (u, v) = (local.x - cell[0] as f64, local.y - cell[1] as f64);
        self.patch(cell[0], cell[1]).normal(u, v, self.pitch.truncate())
    }

    /// Follows a ray from `position`, `inside` the body or through the air, until it meets the surface, ends, or
    /// `visit` takes it: that is told of each cell and the length in it [mm], and may answer how far on it stops [mm].
    #[inline(always)]
    pub(crate) fn march(
        &self,
        position: DVec3,
        direction: DVec3,
        inside: bool,
        mut visit: impl FnMut(CellIndex, f64) -> Option<f64>,
    ) -> RayEnd {
        let start = position - self.low;
        let local = start / self.pitch;
        // Rounding down without a call.
        let mut cell: [i64; 3] =
            std::array::from_fn(|axis| local[axis] as i64 - i64::from(local[axis] < (local[axis] as i64) as f64));
        let ahead = |axis: usize| i64::from(direction[axis] > 0.0);
        let mut next: [f64; 3] = std::array::from_fn(|axis| match direction[axis] {
            0.0 => f64::INFINITY,
            along => ((cell[axis] + ahead(axis)) as f64 * self.pitch[axis] - start[axis]) / along,
        });
        let step: [f64; 3] = std::array::from_fn(|axis| (self.pitch[axis] / direction[axis]).abs());
        let mut gone = 0.0;
        loop {
            if cell[2] < 0 {
                return RayEnd::Ground(gone);
            }
            let height = start.z + direction.z * gone;
            let out = |axis: usize| cell[axis] < 0 || cell[axis] >= self.cells[axis] as i64;
            if out(0) || out(1) || (!inside && direction.z >= 0.0 && height > self.top) {
                return RayEnd::Beyond(gone);
            }
            let axis =
                if next[0] < next[1] { 2 * usize::from(next[2] < next[0]) } else { 1 + usize::from(next[2] < next[1]) };
            let end = next[axis].max(gone);
            let here = [cell[0] as usize, cell[1] as usize, (cell[2] as usize).min(self.cells[2] - 1)];
            let mut length = end - gone;
            let floor = self.floor[here[1] * self.cells[0] + here[0]];
            let mut met = false;
            if height.max(start.z + direction.z * end) >= floor {
                let from = start + direction * gone;
                let (u, v) = (from.x / self.pitch.x - here[0] as f64, from.y / self.pitch.y - here[1] as f64);
                let side = if inside { 1.0 } else { -1.0 };
                let hit = self.patch(here[0], here[1]).crossing([u, v, from.z], direction, self.pitch.truncate(), side);
                met = hit <= length;
                length = length.min(hit);
            }
            if inside && let Some(taken) = visit(here, length) {
                return RayEnd::Taken(gone + taken);
            }
            if met {
                return RayEnd::Surface(gone + length, here);
            }
            gone = end;
            cell[axis] += 2 * ahead(axis) - 1;
            next[axis] += step[axis];
        }
    }
}
