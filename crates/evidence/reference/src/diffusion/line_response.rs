//! Line response of a body by diffusion on voxels.
//!
//! The light of each column enters along the refracted laser and begins to diffuse at the end of the persistence vector
//! of the medium at the surface; across the line it has the laser's Gaussian. Light that begins above the middle of the
//! uppermost voxel is shared, as the resistances on either side say, between that voxel and the way straight out, so
//! shallow sources are right on coarse voxels too. What leaves at the surface is resampled by overlap to the columns
//! and rows asked for; it leaves as Lambert's law says.
//!
//! Voxel and row blur the answer by about pitch^2 / 12 each in variance. The size of the grid: eight decay lengths of
//! the lit media downwards and to each side, but no more than 6 and 8 mm and no fewer than eight voxels.
//! Exits of directions (cone light of fibres), gloss and light that crosses air from one part of the surface to another
//! are left out.

use base::{Medium, Slice};
use glam::{DMat3, DVec3};

use super::solver;
use super::tensor::{Diffusive, refracted, uniaxial};
use super::voxels::{Voxel, Voxels};
use crate::columns::column_edges;
use transport::fresnel::BoundaryTable;
use transport::kernel::diffusion;
use transport::line::{LineResponse, LineSource};
use transport::stack::{Layer, Scattering};

/// Decay lengths of the fluence that the grid holds.
const DECAY_LENGTHS: f64 = 8.0;
/// Fewest voxels downwards and to each side.
const MIN_VOXELS: f64 = 8.0;

/// Greatest depth of the grid below the surface, and greatest distance to each side of the lit places [mm].
const MAX_DEPTH_MM: f64 = 6.0;
const MAX_REACH_MM: f64 = 8.0;
/// Most steps of the solver.
const MAX_STEPS: usize = 2000;

/// Grid and solver of [`line_response`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DiffusionSettings {
    /// Edge of a voxel; with 0.1 mm a board of 94 mm takes 9 million voxels and 0.7 GB [mm].
    pub voxel_mm: f64,
    /// Residual over source at which the solver ends [1].
    pub tolerance: f64,
}

impl DiffusionSettings {
    /// Voxels of this size [mm], solved to 1e-6.
    pub fn new(voxel_mm: f64) -> Self {
        Self { voxel_mm, tolerance: 1e-6 }
    }
}

/// Where the light of a line went [unit of power].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LightBalance {
    /// Leaves at the surface, in or beside the rows and columns of the answer.
    pub left: f64,
    /// Leaves through sides and bottom or the ends of the grid, or entered beside matter.
    pub lost: f64,
    /// Absorbed.
    pub absorbed: f64,
}

/// Light that comes out around a line; see the head of the file.
pub fn line_response(line: &LineSource, settings: &DiffusionSettings) -> LineResponse {
    line_response_with_balance(line, settings).0
}

/// [`line_response`], and where all light went.
pub fn line_response_with_balance(line: &LineSource, settings: &DiffusionSettings) -> (LineResponse, LightBalance) {
    let rows = 2 * line.rows + 1;
    let columns = line.x.len();
    let mut light = vec![0.0; rows * columns];
    let mut balance = LightBalance::default();
    if let Some(grid) = VoxelGrid::new(line, settings) {
        let voxels = grid.voxels(line);
        let mut exits = vec![0.0; grid.shape[0] * grid.shape[1]];
        let source = grid.source(line, &voxels, &mut exits, &mut balance);
        let phi = solver::solve(&voxels, source, settings.tolerance, MAX_STEPS).phi;
        exits.iter_mut().zip(voxels.exits(&phi)).for_each(|(sum, own)| *sum += own);
        balance.left = exits.iter().sum();
        balance.lost += voxels.drained(&phi);
        balance.absorbed = voxels.absorbed(&phi);
        grid.resample(line, &exits, &mut light);
    }
    let light = light.into_iter().map(|v| v as f32).collect();
    (LineResponse { columns, rows: line.rows, light, error: Vec::new() }, balance)
}

/// A medium of a body as diffusion sees it.
fn diffusive(medium: &Medium) -> Option<Diffusive> {
    let scattering = Scattering::from(medium);
    let layer = Layer::new(f64::INFINITY, medium.n_eff.into(), medium.mu_a.into(), scattering);
    Diffusive::new(&layer, 0).ok()
}

/// Place and size of the voxels around a line.
pub(super) struct VoxelGrid {
    /// Lowest x and y of the grid [mm].
    origin: [f64; 2],
    pub shape: [usize; 3],
    pitch: f64,
    edges: Vec<f64>,
}

impl VoxelGrid {
    /// `None` where no light enters.
    pub fn new(line: &LineSource, settings: &DiffusionSettings) -> Option<Self> {
        let pitch = settings.voxel_mm;
        let slice = line.body.slice(line.y as f32);
        let mut lengths = DVec3::ZERO;
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for (&x, _) in line.x.iter().zip(line.power).filter(|&(_, &power)| power > 0.0) {
            let Some(surface) = slice.surface(x) else { continue };
            (low, high) = (low.min(x.into()), high.max(x.into()));
            if let Some(medium) = diffusive(&slice.matter(x, surface.z - pitch as f32).medium) {
                let (plane, d) = (medium.sheared(), medium.d.z_axis.z);
                let squares = DVec3::new(plane.x_axis.x, plane.y_axis.y, d) / medium.mu_a.max(1e-9);
                lengths = lengths.max(DVec3::new(squares.x.sqrt(), squares.y.sqrt(), squares.z.sqrt()));
            }
        }
        if low > high {
            return None;
        }
        let fewest = MIN_VOXELS * pitch;
        let far = |length: f64, most: f64| (DECAY_LENGTHS * length).min(most).max(fewest);
        let sideways = far(lengths.x, MAX_REACH_MM);
        let window = (line.rows as f64 + 0.5) * line.row_mm + pitch;
        let along = far(lengths.y, MAX_REACH_MM).max(window);
        let cells = |length: f64| (length / pitch).ceil() as usize;
        let half = cells(along - 0.5 * pitch).max(4);
        let edges = column_edges(line.x, pitch);
        let wide = cells(high - low + 2.0 * sideways);
        let shape = [wide, 2 * half + 1, cells(far(lengths.z, MAX_DEPTH_MM))];
        let middle = 0.5 * (low + high);
        let origin = [middle - 0.5 * wide as f64 * pitch, line.y - (half as f64 + 0.5) * pitch];
        Some(Self { origin, shape, pitch, edges })
    }

    fn centre(&self, axis: usize, i: usize) -> f64 {
        self.origin[axis] + (i as f64 + 0.5) * self.pitch
    }

    /// The matter of the body.
    pub fn voxels(&self, line: &LineSource) -> Voxels {
        let ny = self.shape[1];
        let floor = f64::from(line.body.bounds().0.z);
        let slices: Vec<_> = (0..ny).map(|j| line.body.slice(self.centre(1, j) as f32)).collect();
        let table = BoundaryTable::new();
        let surface = |i: usize, j: usize| slices[j].surface(self.centre(0, i) as f32);
        let matter = |[i, j, k]: [usize; 3]| {
            let top = surface(i, j)?;
            let z = f64::from(top.z) - (k as f64 + 0.5) * self.pitch;
            if z < floor {
                return None;
            }
            let medium = slices[j].matter(self.centre(0, i) as f32, z as f32).medium;
            let (along, across) = diffusion(f64::from(medium.sigma_i).max(1e-3), medium.k.into());
            let d = uniaxial(along, across, medium.fibre.as_dvec3());
            let map = flattening(top.slope_x.into(), top.slope_y.into());
            let d = map * d * map.transpose();
            Some(Voxel { mu_a: medium.mu_a.into(), d, leak: 0.5 / f64::from(table.at(medium.n_eff)) })
        };
        let stretch = |i: usize, j: usize| {
            let slopes = surface(i, j).map_or((0.0, 0.0), |s| (f64::from(s.slope_x), f64::from(s.slope_y)));
            (1.0 + slopes.0 * slopes.0 + slopes.1 * slopes.1).sqrt()
        };
        Voxels::new(self.shape, self.pitch, matter, stretch)
    }

    /// Power that begins to diffuse in each voxel; what goes straight out is added to `exits`.
    pub fn source(
        &self,
        line: &LineSource,
        voxels: &Voxels,
        exits: &mut [f64],
        balance: &mut LightBalance,
    ) -> Vec<f64> {
        let mut source = vec![0.0; voxels.count()];
        let slice = line.body.slice(line.y as f32);
        for (column, (&x, &power)) in line.x.iter().zip(line.power).enumerate() {
            let power = f64::from(power);
            if power <= 0.0 {
                continue;
            }
            let Some((shift, depth)) = diffusion_start(&*slice, x, self.pitch) else {
                balance.lost += power;
                continue;
            };
            let mut placed = 0.0;
            let ends = [self.edges[column] + shift.x, self.edges[column + 1] + shift.x];
            for (i, x_share) in overlaps(ends, self.origin[0], self.pitch, self.shape[0]) {
                for j in 0..self.shape[1] {
                    let from = self.origin[1] + j as f64 * self.pitch - line.y - shift.y;
                    let share = x_share * gaussian(from, from + self.pitch, line.line_mm);
                    if share > 0.0 {
                        placed += self.put(share * power, [i, j], depth, voxels, exits, &mut source);
                    }
                }
            }
            balance.lost += power - placed;
        }
        source
    }

    /// Puts `power` at `depth` of a column; returns what found matter.
    fn put(
        &self,
        power: f64,
        [i, j]: [usize; 2],
        depth: f64,
        voxels: &Voxels,
        exits: &mut [f64],
        source: &mut [f64],
    ) -> f64 {
        let column = i * self.shape[1] + j;
        let (d, leak) = voxels.top[column];
        if d == 0.0 {
            return 0.0;
        }
        let place = depth / self.pitch - 0.5;
        if place < 0.0 {
            let (d, leak) = (f64::from(d), f64::from(leak));
            let inside = (1.0 / leak + (place + 0.5) / d) / (1.0 / leak + 0.5 / d);
            source[voxels.place([i, j, 0])] += power * inside;
            exits[column] += power * (1.0 - inside);
            return power;
        }
        let k = (place as usize).min(self.shape[2] - 1);
        let share = if k + 1 < self.shape[2] { (place - k as f64).min(1.0) } else { 0.0 };
        for (k, share) in [(k, 1.0 - share), (k + 1, share)] {
            if share > 0.0 {
                source[voxels.place([i, j, k])] += power * share;
            }
        }
        power
    }

    /// Adds the light that left each column of voxels to the rows and columns of the answer.
    pub(crate) fn resample(&self, line: &LineSource, exits: &[f64], light: &mut [f64]) {
        let rows = 2 * line.rows + 1;
        let columns = line.x.len();
        let start = line.y - (line.rows as f64 + 0.5) * line.row_mm;
        let shares: Vec<Vec<(usize, f64)>> = (0..self.shape[1])
            .map(|j| {
                let from = self.centre(1, j) - 0.5 * self.pitch;
                overlaps([from, from + self.pitch], start, line.row_mm, rows)
            })
            .collect();
        for column in 0..columns {
            let (from, to) = (self.edges[column], self.edges[column + 1]);
            for (i, _) in overlaps([from, to], self.origin[0], self.pitch, self.shape[0]) {
                let left = self.origin[0] + i as f64 * self.pitch;
                let inside = ((to.min(left + self.pitch) - from.max(left)) / self.pitch).max(0.0);
                for (j, shares) in shares.iter().enumerate() {
                    let exit = inside * exits[i * self.shape[1] + j];
                    for &(row, share) in shares {
                        light[row * columns + column] += exit * share;
                    }
                }
            }
        }
    }
}

/// J of the map that makes a surface with these slopes flat and counts depth downwards.
fn flattening(slope_x: f64, slope_y: f64) -> DMat3 {
    DMat3::from_cols(DVec3::new(1.0, 0.0, slope_x), DVec3::new(0.0, 1.0, slope_y), DVec3::new(0.0, 0.0, -1.0))
}

/// Where light that comes down at `x` begins to diffuse: place beside the entry and depth [mm].
fn diffusion_start(slice: &dyn Slice, x: f32, pitch: f64) -> Option<(DVec3, f64)> {
    let surface = slice.surface(x)?;
    let (sx, sy) = (f64::from(surface.slope_x), f64::from(surface.slope_y));
    let medium = diffusive(&slice.matter(x, surface.z - 0.5 * pitch as f32).medium)?;
    let normal = DVec3::new(-sx, -sy, 1.0).normalize();
    let inside = refracted(DVec3::NEG_Z, normal, medium.n)?;
    let h = medium.persistence(inside);
    Some((h, (sx * h.x + sy * h.y - h.z).max(0.0)))
}

/// Shares of the interval in the cells of `pitch` from `origin` that it overlaps.
fn overlaps([from, to]: [f64; 2], origin: f64, pitch: f64, count: usize) -> Vec<(usize, f64)> {
    let first = ((from - origin) / pitch).floor().max(0.0) as usize;
    let last = (((to - origin) / pitch).ceil().max(0.0) as usize).min(count);
    (first..last)
        .map(|i| {
            let low = origin + i as f64 * pitch;
            (i, ((to.min(low + pitch) - from.max(low)) / (to - from)).max(0.0))
        })
        .collect()
}

/// Share of a Gaussian of standard deviation `sigma` about 0 in an interval.
fn gaussian(from: f64, to: f64, sigma: f64) -> f64 {
    if sigma <= 0.0 {
        return if from <= 0.0 && 0.0 < to { 1.0 } else { 0.0 };
    }
    let scale = 1.0 / (sigma * std::f64::consts::SQRT_2);
    0.5 * (libm::erf(to * scale) - libm::erf(from * scale))
}
