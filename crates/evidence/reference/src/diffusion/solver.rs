//! Conjugate gradients (Hestenes and Stiefel 1952) with an incomplete factorisation, for the operator of [`Voxels`].
//!
//! The preconditioner is the diagonal-based incomplete Cholesky factorisation of the seven-point part, cut into blocks
//! of a fixed number of planes, so that blocks run in parallel and the result does not depend on threads. Sums are
//! taken plane by plane in a fixed order. Memory: five vectors of f64 and one of f32, 44 bytes a voxel.
//!
//! Ends when the residual has fallen to `tolerance` of the source in the mean square, or after `iterations`.

use rayon::prelude::*;

use super::operator::BLOCK_PLANES;
use super::voxels::Voxels;

/// A fluence and how well it solves.
#[derive(Debug, Clone, PartialEq)]
pub struct Solution {
    /// Fluence of each voxel [unit of the source over mm^2].
    pub phi: Vec<f64>,
    /// Steps that were made.
    pub iterations: usize,
    /// Norm of the residual over that of the source [1].
    pub residual: f64,
}

/// Fluence in `voxels` for the power `source` in each.
pub fn solve(voxels: &Voxels, source: Vec<f64>, tolerance: f64, iterations: usize) -> Solution {
    let chunk = voxels.shape[1] * voxels.shape[2];
    let factor = IncompleteCholesky::new(voxels);
    let mut phi = vec![0.0; voxels.count()];
    let mut rest = source;
    rest.iter_mut().for_each(|s| *s /= voxels.pitch);
    let size = dot(&rest, &rest, chunk).sqrt();
    let solution = |phi, iterations, norm: f64| Solution { phi, iterations, residual: norm / size };
    if size == 0.0 {
        return Solution { phi, iterations: 0, residual: 0.0 };
    }
    let mut near = vec![0.0; voxels.count()];
    factor.solve(voxels, &rest, &mut near);
    let mut direction = near.clone();
    let mut image = vec![0.0; voxels.count()];
    let mut slope = dot(&rest, &near, chunk);
    let mut norm = size;
    for step in 0..iterations {
        if norm <= tolerance * size {
            return solution(phi, step, norm);
        }
        voxels.apply(&direction, &mut image);
        let length = slope / dot(&direction, &image, chunk);
        add(&mut phi, length, &direction, chunk);
        add(&mut rest, -length, &image, chunk);
        factor.solve(voxels, &rest, &mut near);
        let next = dot(&rest, &near, chunk);
        let keep = next / slope;
        direction.par_chunks_mut(chunk).zip(near.par_chunks(chunk)).for_each(|(direction, near)| {
            direction.iter_mut().zip(near).for_each(|(direction, near)| *direction = near + keep * *direction);
        });
        slope = next;
        norm = dot(&rest, &rest, chunk).sqrt();
    }
    solution(phi, iterations, norm)
}

fn dot(a: &[f64], b: &[f64], chunk: usize) -> f64 {
    let own = |(a, b): (&[f64], &[f64])| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let parts: Vec<f64> = a.par_chunks(chunk).zip(b.par_chunks(chunk)).map(own).collect();
    parts.into_iter().sum()
}

fn add(a: &mut [f64], factor: f64, b: &[f64], chunk: usize) {
    a.par_chunks_mut(chunk).zip(b.par_chunks(chunk)).for_each(|(a, b)| {
        a.iter_mut().zip(b).for_each(|(a, b)| *a += factor * b);
    });
}

/// Reciprocal pivots of the incomplete factorisation.
struct IncompleteCholesky(Vec<f32>);

impl IncompleteCholesky {
    fn new(voxels: &Voxels) -> Self {
        let [_, ny, nz] = voxels.shape;
        let plane = ny * nz;
        let square = |axis: usize, c: usize| f64::from(voxels.face[axis][c]) * f64::from(voxels.face[axis][c]);
        let mut pivots = vec![0.0f32; voxels.count()];
        pivots.par_chunks_mut(BLOCK_PLANES * plane).enumerate().for_each(|(block, pivots)| {
            for own in 0..pivots.len() {
                let c = block * BLOCK_PLANES * plane + own;
                let (i, k, j) = (c / plane, (c % plane) / ny, c % ny);
                let mut sum = f64::from(voxels.absorb[c]) + f64::from(voxels.drain[c]);
                if k == 0 {
                    let (d, leak) = voxels.top[i * ny + j];
                    sum += f64::from(if d > 0.0 { 2.0 * d * leak / (2.0 * d + leak) } else { 0.0 });
                }
                sum += (0..3).map(|axis| square(axis, c)).sum::<f64>();
                let before = [(0, i > 0, plane), (1, j > 0, 1), (2, k > 0, ny)];
                for (axis, inside, stride) in before {
                    if inside {
                        let t = square(axis, c - stride);
                        sum += t;
                        if own >= stride {
                            sum -= t * t * f64::from(pivots[own - stride]);
                        }
                    }
                }
                pivots[own] = if sum > 0.0 { (1.0 / sum) as f32 } else { 0.0 };
            }
        });
        Self(pivots)
    }

    /// `out` = M^-1 `rest`, forwards and backwards through each block.
    fn solve(&self, voxels: &Voxels, rest: &[f64], out: &mut [f64]) {
        let [_, ny, nz] = voxels.shape;
        let plane = ny * nz;
        out.par_chunks_mut(BLOCK_PLANES * plane).enumerate().for_each(|(block, out)| {
            let first = block * BLOCK_PLANES * plane;
            let faces = [0, 1, 2].map(|axis| &voxels.face[axis][first..first + out.len()]);
            let pivots = &self.0[first..first + out.len()];
            let rest = &rest[first..first + out.len()];
            let t = |axis: usize, c: usize| f64::from(faces[axis][c]) * f64::from(faces[axis][c]);
            for row in (0..out.len()).step_by(ny) {
                let mut sums: Vec<f64> = rest[row..row + ny].to_vec();
                if row >= plane {
                    (0..ny).for_each(|j| sums[j] += t(0, row + j - plane) * out[row + j - plane]);
                }
                if row % plane > 0 {
                    (0..ny).for_each(|j| sums[j] += t(2, row + j - ny) * out[row + j - ny]);
                }
                let mut carried = 0.0;
                for j in 0..ny {
                    let value = f64::from(pivots[row + j]) * (sums[j] + carried);
                    out[row + j] = value;
                    carried = t(1, row + j) * value;
                }
            }
            for row in (0..out.len()).step_by(ny).rev() {
                let mut sums = vec![0.0; ny];
                if row + plane < out.len() {
                    (0..ny).for_each(|j| sums[j] += t(0, row + j) * out[row + j + plane]);
                }
                if row % plane + ny < plane {
                    (0..ny).for_each(|j| sums[j] += t(2, row + j) * out[row + j + ny]);
                }
                let mut next = 0.0;
                for j in (0..ny).rev() {
                    let value = out[row + j] + f64::from(pivots[row + j]) * (sums[j] + t(1, row + j) * next);
                    out[row + j] = value;
                    next = value;
                }
            }
        });
    }
}
