//! The operator of [`Voxels`] on a fluence: fluxes out of each voxel, and the light that leaves at the surface.
//!
//! Planes of x are worked on in blocks of a fixed number, with the cross terms of one more plane on either side, so
//! that nothing depends on threads. Units: the operator times the pitch is power per voxel.

use rayon::prelude::*;

use super::voxels::Voxels;

/// Planes of x that one task takes on.
pub(super) const BLOCK_PLANES: usize = 16;

/// Cross terms of one plane: a quarter of sum rho u of each axis, and the fluence on the surface.
#[derive(Debug, Clone, Default)]
struct CrossTerms {
    terms: [Vec<f64>; 3],
    surface: Vec<f64>,
}

impl Voxels {
    /// What leaves each voxel: `out` = A `phi`.
    pub fn apply(&self, phi: &[f64], out: &mut [f64]) {
        let plane = self.shape[1] * self.shape[2];
        out.par_chunks_mut(BLOCK_PLANES * plane).enumerate().for_each(|(block, out)| {
            let first = block * BLOCK_PLANES;
            let mut last = CrossTerms::default();
            let mut here = if first > 0 { self.cross(first - 1, phi) } else { CrossTerms::default() };
            let mut next = self.cross(first, phi);
            for (n, out) in out.chunks_exact_mut(plane).enumerate() {
                let i = first + n;
                std::mem::swap(&mut last, &mut here);
                std::mem::swap(&mut here, &mut next);
                next = if i + 1 < self.shape[0] { self.cross(i + 1, phi) } else { CrossTerms::default() };
                self.balance(i, phi, [&last, &here, &next], out);
            }
        });
    }

    /// Power that leaves each column at the surface, `[nx, ny]` [unit of phi times mm^2].
    pub fn exits(&self, phi: &[f64]) -> Vec<f64> {
        let [_, ny, _] = self.shape;
        let mut out = vec![0.0; self.top.len()];
        out.par_chunks_mut(ny).enumerate().for_each(|(i, out)| {
            let cross = self.cross(i, phi);
            let top = &self.top[i * ny..(i + 1) * ny];
            for (out, (surface, top)) in out.iter_mut().zip(cross.surface.iter().zip(top)) {
                *out = self.pitch * f64::from(top.1) * surface;
            }
        });
        out
    }

    /// Steps across the faces of plane `i`, times sqrt(T), summed over the two faces of each voxel and axis; then the
    /// cross terms. Rows run along y.
    fn cross(&self, i: usize, phi: &[f64]) -> CrossTerms {
        let [nx, ny, nz] = self.shape;
        let plane = ny * nz;
        let mut cross = CrossTerms { terms: std::array::from_fn(|_| vec![0.0; plane]), surface: vec![0.0; ny] };
        let (mut ax, mut ay, mut az) = (vec![0.0; ny], vec![0.0; ny], vec![0.0; ny]);
        let mut steps = vec![0.0; ny];
        for k in 0..nz {
            let c = i * plane + k * ny;
            let row = &phi[c..c + ny];
            ax.fill(0.0);
            ay.fill(0.0);
            az.fill(0.0);
            for (axis, sum, stride, goes_on, began) in
                [(0, &mut ax, plane, i + 1 < nx, i > 0), (2, &mut az, ny, k + 1 < nz, k > 0)]
            {
                if goes_on {
                    step(&self.face[axis][c..c + ny], row, &phi[c + stride..c + stride + ny], sum);
                }
                if began {
                    let before = c - stride..c - stride + ny;
                    step(&self.face[axis][before.clone()], &phi[before], row, sum);
                }
            }
            steps.fill(0.0);
            step(&self.face[1][c..c + ny - 1], &row[..ny - 1], &row[1..], &mut steps);
            for j in 0..ny {
                ay[j] += steps[j];
            }
            for j in 1..ny {
                ay[j] += steps[j - 1];
            }
            let [xy, xz, yz] = [0, 1, 2].map(|t| &self.twist[t][c..c + ny]);
            if k == 0 {
                for j in 0..ny {
                    let (d, leak) = self.top[i * ny + j];
                    if d > 0.0 {
                        let (d, leak) = (f64::from(d), f64::from(leak));
                        let root = d.sqrt();
                        let sideways = 0.5 * root * (f64::from(xz[j]) * ax[j] + f64::from(yz[j]) * ay[j]);
                        cross.surface[j] = (2.0 * d * row[j] + sideways) / (2.0 * d + leak);
                        az[j] += 2.0 * root * (row[j] - cross.surface[j]);
                    }
                }
            }
            let [mx, my, mz] = &mut cross.terms;
            let own = k * ny..(k + 1) * ny;
            let (mx, my, mz) = (&mut mx[own.clone()], &mut my[own.clone()], &mut mz[own]);
            for j in 0..ny {
                let (xy, xz, yz) = (f64::from(xy[j]), f64::from(xz[j]), f64::from(yz[j]));
                mx[j] = 0.25 * (xy * ay[j] + xz * az[j]);
                my[j] = 0.25 * (xy * ax[j] + yz * az[j]);
                mz[j] = 0.25 * (xz * ax[j] + yz * ay[j]);
            }
        }
        cross
    }

    /// Fluxes out of the voxels of plane `i`, given the cross terms of the planes around it.
    fn balance(&self, i: usize, phi: &[f64], cross: [&CrossTerms; 3], out: &mut [f64]) {
        let [nx, ny, nz] = self.shape;
        let plane = ny * nz;
        let [last, here, next] = cross;
        for k in 0..nz {
            let (own, c) = (k * ny, i * plane + k * ny);
            let row = &phi[c..c + ny];
            let out = &mut out[own..own + ny];
            let (absorb, drain) = (&self.absorb[c..c + ny], &self.drain[c..c + ny]);
            for j in 0..ny {
                out[j] = (f64::from(absorb[j]) + f64::from(drain[j])) * row[j];
            }
            let [mx, my, mz] = &here.terms;
            if i + 1 < nx {
                let (face, beyond) = (&self.face[0][c..c + ny], &phi[c + plane..c + plane + ny]);
                flow(face, row, beyond, &mx[own..own + ny], &next.terms[0][own..own + ny], -1.0, out);
            }
            if i > 0 {
                let (face, before) = (&self.face[0][c - plane..c - plane + ny], &phi[c - plane..c - plane + ny]);
                flow(face, before, row, &last.terms[0][own..own + ny], &mx[own..own + ny], 1.0, out);
            }
            if k + 1 < nz {
                let (face, beyond) = (&self.face[2][c..c + ny], &phi[c + ny..c + 2 * ny]);
                flow(face, row, beyond, &mz[own..own + ny], &mz[own + ny..own + 2 * ny], -1.0, out);
            }
            if k > 0 {
                let (face, before) = (&self.face[2][c - ny..c], &phi[c - ny..c]);
                flow(face, before, row, &mz[own - ny..own], &mz[own..own + ny], 1.0, out);
            } else {
                for j in 0..ny {
                    out[j] += f64::from(self.top[i * ny + j].1) * here.surface[j];
                }
            }
            let (face, my) = (&self.face[1][c..c + ny - 1], &my[own..own + ny]);
            flow(face, &row[..ny - 1], &row[1..], &my[..ny - 1], &my[1..], -1.0, &mut out[..ny - 1]);
            flow(face, &row[..ny - 1], &row[1..], &my[..ny - 1], &my[1..], 1.0, &mut out[1..]);
        }
    }
}

/// Adds sqrt(T) times the step of Phi.
#[inline(always)]
fn step(face: &[f32], here: &[f64], next: &[f64], out: &mut [f64]) {
    for (((out, &face), &here), &next) in out.iter_mut().zip(face).zip(here).zip(next) {
        *out += f64::from(face) * (next - here);
    }
}

/// Adds `sign` times the flux against a face, with the cross terms of both sides.
#[inline(always)]
fn flow(face: &[f32], here: &[f64], next: &[f64], own: &[f64], other: &[f64], sign: f64, out: &mut [f64]) {
    for j in 0..out.len() {
        let root = f64::from(face[j]);
        out[j] += sign * root * (root * (next[j] - here[j]) + own[j] + other[j]);
    }
}
