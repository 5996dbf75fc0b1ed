//! From waves back to places: line and point spread of plane layers.
//!
//! The light that leaves at place r is the Fourier integral over waves k of sum_s share_s T_s(k) e^(i k . (r -
//! exit_s)), with the transfer T_s of [`super::transmission_line`]. Each row or cell takes the mean of its width (a
//! sinc), the laser line its Gaussian. Integrals by Gauss and Legendre's rule on panels, which shrink by halves towards
//! k = 0, where T has a kink when nothing absorbs. Waves end where T has fallen to 1e-13 in the line and 1e-8 in the
//! point, or at 48 waves a row and 12 a cell; that is the only error that matters, and only within a source depth of
//! much less than a cell.

use std::f64::consts::PI;

use glam::DVec2;
use rayon::prelude::*;

use super::transmission_line::{DiffuseSource, TransmissionLine};
use numerics::quadrature::composite;
use transport::answer::Question;

/// Waves that one task takes on; fixed, so that sums do not depend on threads.
const CHUNK_WAVES: usize = 64;

/// sin(x) / x.
fn sinc(x: f64) -> f64 {
    if x.abs() < 1e-4 { 1.0 - x * x / 6.0 } else { libm::sin(x) / x }
}

/// Nodes on [0, `end`]: panels that double from a tiny one up to `width`.
fn positive(end: f64, width: f64, count: usize) -> Vec<(f64, f64)> {
    let mut edges = vec![0.0];
    let mut edge = (1e-5 * width).min(end);
    while edge < end {
        edges.push(edge);
        edge += edge.min(width);
    }
    edges.push(end);
    composite(&edges, count)
}

/// The wave number along the axis with unit vector `axis` at which the shallowest source has fallen to e^-`decay`, the
/// other component being as good as it can; `free` lets it be anything but 0.
fn last_wave(line: &TransmissionLine, sources: &[DiffuseSource], axis: DVec2, decay: f64, free: bool) -> f64 {
    let rate = |i: usize| {
        let medium = &line.sections[i].medium;
        let plane = line.sections[i].plane;
        let along = if free { 1.0 / axis.dot(plane.inverse() * axis) } else { axis.dot(plane * axis) };
        (along / medium.d.z_axis.z).sqrt()
    };
    let depth = |source: &DiffuseSource| {
        let above: f64 = (0..source.layer).map(|i| rate(i) * line.sections[i].thickness).sum();
        above + rate(source.layer) * source.depth
    };
    decay / sources.iter().map(depth).fold(f64::INFINITY, f64::min)
}

/// Share of a line's light in each row across it, `[2 rows + 1]`.
pub(super) fn line_spread(line: &TransmissionLine, sources: &[DiffuseSource], question: &Question) -> Vec<f64> {
    let count = 2 * question.rows + 1;
    if sources.is_empty() {
        return vec![0.0; count];
    }
    let row = question.row_mm;
    let reach = row * (question.rows as f64 + 1.0) + sources.iter().map(|s| s.exit.y.abs()).fold(0.0, f64::max);
    let mut end = last_wave(line, sources, DVec2::Y, 30.0, false).min(96.0 * PI / row);
    if question.line_mm > 0.0 {
        end = end.min(8.0 / question.line_mm);
    }
    let mut waves = Vec::new();
    let mut spread = vec![0.0; count];
    for (k, w) in positive(end, PI / reach, 10) {
        line.wave(DVec2::new(0.0, k), &mut waves);
        let blur = k * question.line_mm;
        let weight = w * row / PI * libm::exp(-0.5 * blur * blur) * sinc(0.5 * k * row);
        let (mut even, mut odd) = (0.0, 0.0);
        for source in sources {
            let part = source.share * weight * line.exit(source, &waves);
            let (sin, cos) = libm::sincos(k * source.exit.y);
            even += part * cos;
            odd += part * sin;
        }
        for (j, out) in spread.iter_mut().enumerate() {
            let (sin, cos) = libm::sincos(k * row * (j as f64 - question.rows as f64));
            *out += even * cos + odd * sin;
        }
    }
    spread
}

/// Share of a beam's light in each cell, `[2 cells + 1, 2 cells + 1]`, row-major, rows along y; empty for 0 cells.
pub(super) fn point_spread(line: &TransmissionLine, sources: &[DiffuseSource], question: &Question) -> Vec<f64> {
    if question.cells == 0 {
        return Vec::new();
    }
    let side = 2 * question.cells + 1;
    let cell = question.cell_mm;
    if sources.is_empty() {
        return vec![0.0; side * side];
    }
    let shift = sources.iter().map(|s| s.exit.abs().max_element()).fold(0.0, f64::max);
    let width = 6.0 / (cell * (question.cells as f64 + 0.5) + shift);
    let nodes = |axis: DVec2| positive(last_wave(line, sources, axis, 20.0, true).min(24.0 * PI / cell), width, 8);
    // One half of the plane of waves: the other half is its conjugate.
    let half: Vec<(f64, f64)> = nodes(DVec2::X);
    let across: Vec<(f64, f64)> = half.iter().rev().map(|&(k, w)| (-k, w)).chain(half.iter().copied()).collect();
    let along = nodes(DVec2::Y);
    let place = |i: usize| cell * (i as f64 - question.cells as f64);
    let turns: Vec<(f64, f64)> = across
        .iter()
        .flat_map(|&(k, w)| {
            let weight = w * sinc(0.5 * k * cell);
            (0..side).map(move |i| {
                let (sin, cos) = libm::sincos(k * place(i));
                (weight * cos, weight * sin)
            })
        })
        .collect();
    let scale = 2.0 * cell * cell / (4.0 * PI * PI);
    let parts: Vec<Vec<f64>> = along
        .par_chunks(CHUNK_WAVES)
        .map(|chunk| {
            let (mut waves, mut part) = (Vec::new(), vec![0.0; side * side]);
            for &(ky, w) in chunk {
                let mut row = vec![(0.0, 0.0); side];
                for (&(kx, _), turns) in across.iter().zip(turns.chunks_exact(side)) {
                    let k = DVec2::new(kx, ky);
                    line.wave(k, &mut waves);
                    let (mut real, mut imaginary) = (0.0, 0.0);
                    for source in sources {
                        let part = source.share * line.exit(source, &waves);
                        let (sin, cos) = libm::sincos(k.dot(source.exit));
                        real += part * cos;
                        imaginary -= part * sin;
                    }
                    for (sum, &(cos, sin)) in row.iter_mut().zip(turns) {
                        sum.0 += real * cos - imaginary * sin;
                        sum.1 += real * sin + imaginary * cos;
                    }
                }
                let weight = scale * w * sinc(0.5 * ky * cell);
                for (j, out) in part.chunks_exact_mut(side).enumerate() {
                    let (sin, cos) = libm::sincos(ky * place(j));
                    out.iter_mut().zip(&row).for_each(|(sum, r)| *sum += weight * (r.0 * cos - r.1 * sin));
                }
            }
            part
        })
        .collect();
    let mut spread = vec![0.0; side * side];
    for part in parts {
        spread.iter_mut().zip(part).for_each(|(sum, part)| *sum += part);
    }
    spread
}
