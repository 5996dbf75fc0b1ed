//! Steady diffusion on voxels: -div(D grad Phi) + mu_a Phi = S by finite volumes, full tensor, any mixture of media.
//!
//! Grid: x, y and the depth below the surface, straight down. A surface of height z(x, y) with slopes is made flat by
//! depth = z(x, y) - z. With the Jacobian J of that map, of determinant 1, the equation keeps its form with J D J^T in
//! place of D, and a mm^2 of the plan has |N| = sqrt(1 + slopes^2) of surface. So slopes cost no staircase.
//!
//! Faces: with Delta the step of Phi across a face and T the harmonic mean of D along its normal in the two voxels, let
//! u = sqrt(T) Delta. A voxel's tensor is T and the correlations rho_ij = D_ij / sqrt(D_ii D_jj); the energy of a
//! voxel's corner is u^T (1 + rho) u / 2, an eighth of the voxel each. Summed, the flux across an x face is
//!
//! ```text
//! sqrt(T) [u + 1/4 sum_(both voxels) (rho_xy (u_north + u_south) + rho_xz (u_above + u_below))]
//! ```
//!
//! which is consistent of second order in smooth media, conserves light, keeps the flux across borders of unlike media,
//! and is symmetric and positive definite for any tensors, since each 1 + rho is.
//!
//! Surface: half a voxel of matter, then Robin's condition J = |N| Phi / (2 A), with z_e = 2 A D_zz; the fluence on the
//! surface is eliminated, cross terms included. Sides and bottom of a body: the same without cross terms. Where the
//! grid ends inside matter: J = sqrt(mu_a D) Phi, what a wave that dies out in one dimension does.
//!
//! Neglected: Fresnel's law between voxels of unlike index. Coefficients are kept in f32, 32 bytes a voxel.

use glam::DMat3;
use rayon::prelude::*;

/// A voxel of matter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Voxel {
    /// Absorption [mm^-1].
    pub mu_a: f64,
    /// Diffusion tensor on the grid's axes, the third one being depth [mm].
    pub d: DMat3,
    /// Light that leaves through a surface over the fluence there, 1 / (2 A) [1].
    pub leak: f64,
}

/// Voxels with their faces. Place of voxel (i, j, k) along x, y and depth: (i nz + k) ny + j.
#[derive(Debug, Clone)]
pub struct Voxels {
    /// Voxels along x, y and depth.
    pub shape: [usize; 3],
    /// Edge of a voxel [mm].
    pub pitch: f64,
    /// Square roots of T of the face towards the next voxel along x, y, depth; 0 for none.
    pub(super) face: [Vec<f32>; 3],
    /// Correlations xy, xz, yz.
    pub(super) twist: [Vec<f32>; 3],
    /// mu_a times the square of the pitch.
    pub(super) absorb: Vec<f32>,
    /// What leaves through sides and bottom, over Phi.
    pub(super) drain: Vec<f32>,
    /// Of each column: D along depth in its uppermost voxel, and what leaves over the fluence on the surface; `[nx,
    /// ny]`.
    pub(super) top: Vec<(f32, f32)>,
}

impl Voxels {
    /// A grid of `shape` voxels of `pitch` mm. `matter` says what is at (i, j, k), `stretch` gives |N| of column (i,
    /// j).
    pub fn new(
        shape: [usize; 3],
        pitch: f64,
        matter: impl Fn([usize; 3]) -> Option<Voxel> + Sync,
        stretch: impl Fn(usize, usize) -> f64 + Sync,
    ) -> Self {
        let [nx, ny, nz] = shape;
        let plane = ny * nz;
        let blank = || vec![0.0f32; nx * plane];
        let mut grid = Self {
            shape,
            pitch,
            face: [blank(), blank(), blank()],
            twist: [blank(), blank(), blank()],
            absorb: blank(),
            drain: blank(),
            top: vec![(0.0, 0.0); nx * ny],
        };
        let mut leak = blank();
        {
            let [fx, fy, fz] = &mut grid.face;
            let [xy, xz, yz] = &mut grid.twist;
            let planes = fx.par_chunks_mut(plane).zip(fy.par_chunks_mut(plane)).zip(fz.par_chunks_mut(plane));
            let twists = xy.par_chunks_mut(plane).zip(xz.par_chunks_mut(plane)).zip(yz.par_chunks_mut(plane));
            let rest =
                grid.absorb.par_chunks_mut(plane).zip(leak.par_chunks_mut(plane)).zip(grid.top.par_chunks_mut(ny));
            planes.zip(twists).zip(rest).enumerate().for_each(|(i, ((faces, twists), rest))| {
                let ((fx, fy), fz) = faces;
                let ((xy, xz), yz) = twists;
                let ((absorb, leak), top) = rest;
                for k in 0..nz {
                    for j in 0..ny {
                        let Some(voxel) = matter([i, j, k]) else { continue };
                        let (c, d) = (k * ny + j, voxel.d);
                        let (dx, dy, dz) = (d.x_axis.x, d.y_axis.y, d.z_axis.z);
                        (fx[c], fy[c], fz[c]) = (dx as f32, dy as f32, dz as f32);
                        xy[c] = (d.x_axis.y / (dx * dy).sqrt()) as f32;
                        xz[c] = (d.x_axis.z / (dx * dz).sqrt()) as f32;
                        yz[c] = (d.y_axis.z / (dy * dz).sqrt()) as f32;
                        absorb[c] = (voxel.mu_a * pitch * pitch) as f32;
                        leak[c] = (voxel.leak * pitch) as f32;
                        if k == 0 {
                            top[j] = (dz as f32, (voxel.leak * pitch * stretch(i, j)) as f32);
                        }
                    }
                }
            });
        }
        grid.close(&leak);
        grid.join();
        grid
    }

    /// Whether there is matter; to be asked before [`Self::join`].
    fn solid(&self, c: usize) -> bool {
        self.face[2][c] > 0.0
    }

    /// Fills `drain` from the diagonals of D, which still stand in `face`.
    fn close(&mut self, leak: &[f32]) {
        let [nx, ny, nz] = self.shape;
        let mut drain = std::mem::take(&mut self.drain);
        drain.par_chunks_mut(ny * nz).enumerate().for_each(|(i, drain)| {
            for k in 0..nz {
                for j in 0..ny {
                    let (own, c) = (k * ny + j, (i * nz + k) * ny + j);
                    if !self.solid(c) {
                        continue;
                    }
                    // Axis, whether the grid goes on there, and the neighbour.
                    let sides = [
                        (0, i > 0, c.wrapping_sub(ny * nz)),
                        (0, i + 1 < nx, c + ny * nz),
                        (1, j > 0, c.wrapping_sub(1)),
                        (1, j + 1 < ny, c + 1),
                        (2, k + 1 < nz, c + ny),
                    ];
                    for (axis, inside, next) in sides {
                        let d = self.face[axis][c];
                        let out = match inside {
                            true if self.solid(next) => continue,
                            true => leak[c],
                            false => (self.absorb[c] * d).sqrt(),
                        };
                        drain[own] += 2.0 * d * out / (2.0 * d + out);
                    }
                }
            }
        });
        self.drain = drain;
    }

    /// Turns the diagonals of D into the square roots of harmonic means between neighbours.
    fn join(&mut self) {
        let [nx, ny, nz] = self.shape;
        let root = |here: f32, next: f32| {
            let sum = here + next;
            if sum > 0.0 { (2.0 * here * next / sum).sqrt() } else { 0.0 }
        };
        // From low to high, so that the next voxel still holds its own coefficient.
        let [fx, fy, fz] = &mut self.face;
        let plane = ny * nz;
        for c in 0..nx * plane {
            fx[c] = if c + plane < nx * plane { root(fx[c], fx[c + plane]) } else { 0.0 };
        }
        fy.par_chunks_mut(ny).for_each(|row| {
            for j in 0..ny {
                row[j] = if j + 1 < ny { root(row[j], row[j + 1]) } else { 0.0 };
            }
        });
        fz.par_chunks_mut(plane).for_each(|slab| {
            for c in 0..plane {
                slab[c] = if c + ny < plane { root(slab[c], slab[c + ny]) } else { 0.0 };
            }
        });
    }

    /// Voxels in all.
    pub fn count(&self) -> usize {
        self.absorb.len()
    }

    /// Place of voxel (i, j, k) in an array.
    pub fn place(&self, [i, j, k]: [usize; 3]) -> usize {
        (i * self.shape[2] + k) * self.shape[1] + j
    }

    /// Power that the voxels absorb in the fluence `phi` [unit of phi times mm^2].
    pub fn absorbed(&self, phi: &[f64]) -> f64 {
        self.over(&self.absorb, phi)
    }

    /// Power that leaves through sides and bottom, the ends of the grid included [unit of phi times mm^2].
    pub fn drained(&self, phi: &[f64]) -> f64 {
        self.over(&self.drain, phi)
    }

    fn over(&self, rate: &[f32], phi: &[f64]) -> f64 {
        let chunk = self.shape[1] * self.shape[2];
        let own = |(rate, phi): (&[f32], &[f64])| rate.iter().zip(phi).map(|(&r, p)| f64::from(r) * p).sum::<f64>();
        let parts: Vec<f64> = rate.par_chunks(chunk).zip(phi.par_chunks(chunk)).map(own).collect();
        self.pitch * parts.into_iter().sum::<f64>()
    }
}
