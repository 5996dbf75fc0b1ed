//! Speckle as square pixels gather it.
//!
//! A pixel takes the mean of the intensity over its box. On samples that hold the intensity (two a grain) the mean over
//! the box is a product in the Fourier domain, sinc(f_x) sinc(f_y) for frequencies in cycles a pixel, and exact for boxes
//! anywhere; a sum of samples is not: six a pixel give neighbours 9 % too little in common. Columns are wanted a pixel
//! apart alone, rows at every sample. Two patterns share the transforms, one as the real, one as the imaginary part.
//!
//! For the thesis' law the square root of the intensity is gathered; its spectrum does not end, and what lies beyond the grid's is
//! folded back. Neglected: dead zones between pixels, crosstalk.

use std::f64::consts::PI;

use rustfft::FftPlannerScalar;
use rustfft::num_complex::Complex32;

use super::TILE;
use super::field::Pupil;
use crate::settings::SpeckleLaw;

/// Rows of the grid that are worked on at a time.
const BLOCK: usize = 16;

/// The patterns of `pupil` moved by two `shifts`, in pixels of `fine` samples: less their mean of 1, `[samples, TILE]`.
pub fn gather(pupil: &Pupil, shifts: [usize; 2], law: SpeckleLaw, fine: usize) -> [Vec<f32>; 2] {
    let [across, down] = pupil.side();
    let mut planner = FftPlannerScalar::new();
    let halves = shifts.map(|shift| pupil.half(shift));
    let along = boxes(across, fine);
    let mut columns = vec![Complex32::default(); TILE * down];
    let (mut room, mut lights) = (Vec::new(), [0, 1].map(|_| vec![0.0f32; BLOCK * across]));
    for first in (0..down).step_by(BLOCK) {
        let rows = BLOCK.min(down - first);
        for (half, light) in halves.iter().zip(&mut lights) {
            half.rows(first, &mut light[..rows * across], &mut room, &mut planner);
            if law == SpeckleLaw::Rayleigh {
                light.iter_mut().for_each(|light| *light = light.sqrt());
            }
        }
        room.clear();
        let [one, other] = &lights;
        room.extend(one.iter().zip(other).take(rows * across).map(|(one, other)| Complex32::new(*one, *other)));
        planner.plan_fft_forward(across).process(&mut room);
        let mut folded = vec![Complex32::default(); rows * TILE];
        for (line, folded) in room.chunks_exact(across).zip(folded.chunks_exact_mut(TILE)) {
            for (part, along) in line.chunks_exact(TILE).zip(along.chunks_exact(TILE)) {
                for ((sum, value), weight) in folded.iter_mut().zip(part).zip(along) {
                    *sum += value * weight;
                }
            }
        }
        planner.plan_fft_inverse(TILE).process(&mut folded);
        for (row, line) in folded.chunks_exact(TILE).enumerate() {
            for (column, value) in line.iter().enumerate() {
                columns[column * down + first + row] = *value;
            }
        }
    }
    planner.plan_fft_forward(down).process(&mut columns);
    let weights = boxes(down, fine);
    for line in columns.chunks_exact_mut(down) {
        line.iter_mut().zip(&weights).for_each(|(value, weight)| *value *= weight);
    }
    planner.plan_fft_inverse(down).process(&mut columns);
    [|v: &Complex32| v.re, |v: &Complex32| v.im].map(|part| {
        let mean = columns.iter().map(|value| f64::from(part(value))).sum::<f64>() / columns.len() as f64;
        let scale = (1.0 / mean) as f32;
        let mut pattern = vec![0.0; columns.len()];
        for (column, line) in columns.chunks_exact(down).enumerate() {
            for (row, value) in line.iter().enumerate() {
                pattern[row * TILE + column] = part(value) * scale - 1.0;
            }
        }
        pattern
    })
}

/// What a box of `fine` samples leaves of each frequency of `side` samples.
fn boxes(side: usize, fine: usize) -> Vec<f32> {
    let weight = |place: usize| {
        let cycles = if 2 * place > side { place as f64 - side as f64 } else { place as f64 };
        let angle = PI * cycles * fine as f64 / side as f64;
        if place == 0 { 1.0 } else { (libm::sin(angle) / angle) as f32 }
    };
    (0..side).map(weight).collect()
}
