//! Fully developed speckle: light behind a pupil of random phases, gathered by square pixels.
//!
//! A disc of D cells with unit amplitude and uniform random phase, seen in a Fourier transform of side Q, has the
//! intensity
//!
//! ```text
//! p(I) = exp(-I),    <I I'> - 1 = [2 J1(pi r / L) / (pi r / L)]^2,    L = Q / D samples = lambda N (1 + m)
//! ```
//!
//! with Q >= 2 D (Duncan and Kirkpatrick 2008; Goodman 2007). L is not the size 1.22 L of the first zero, which is
//! often quoted as the grain. The grid's sides may differ: the disc is then an ellipse in cells, round on the sensor.
//! The phases continue behind the disc for two diameters, in a ring: shifted against the disc by s diameters they give
//! the pattern of a pupil that has moved as far ([`super::stack`]).
//!
//! A pixel takes the mean of the intensity over its box. On samples that resolve the intensity (two a grain) the mean
//! over the box is a product in the Fourier domain, sinc(f_x) sinc(f_y) for frequencies in cycles a pixel, and exact
//! for box_spectrum anywhere; a sum of samples is not: six a pixel give neighbours 9 % too little correlation. Columns
//! are needed at pixel distance alone, rows at every sample. Two patterns share the transforms, one as the real, one as
//! the imaginary part.
//!
//! For the thesis' law the square root of the intensity is gathered; its spectrum is not limited, and what lies beyond
//! the grid's is aliased. Valid for a rough, resting surface and polarised light of one wavelength. Neglected: dead
//! zones between pixels, crosstalk.

use std::f64::consts::PI;
use std::ops::Range;

use base::{Stream, mix};
use multiversion::multiversion;
use rustfft::FftPlannerScalar;
use rustfft::num_complex::Complex;
use rustfft::num_traits::Zero;

use super::transform_lanes::{LANES, Lanes};
use numerics::lanes;
use optical_bench::settings::SpeckleLaw;

/// Pixels along the line after which a pattern repeats.
pub const TILE: usize = 128;
/// Groups of [`LANES`] rows of the grid that are transformed at a time.
const BLOCK_GROUPS: usize = 4;

/// A pupil of random phases.
#[derive(Debug, Clone)]
pub struct Pupil {
    /// Samples of the grid along columns and rows.
    side: [usize; 2],
    /// Cells of the disc along both.
    diameter: [f64; 2],
    key: u64,
}

/// The field after the first of its two transforms: along the rows.
#[derive(Debug)]
struct RowTransform {
    side: [usize; 2],
    /// `[columns of the disc / LANES][rows of the grid]`, lanes for columns.
    lines: Vec<Complex<Lanes>>,
}

impl Pupil {
    /// For a grid of `side` samples, whose rows are a multiple of 4, and grains L of `grain` samples, at least 2.
    pub fn new(side: [usize; 2], grain: f64, stream: Stream) -> Self {
        assert!(side[1].is_multiple_of(LANES), "{} rows do not fill lanes", side[1]);
        Self { side, diameter: side.map(|side| side as f64 / grain), key: stream.child("phases").key() }
    }

    /// Rows of phases after which they repeat: two diameters.
    pub(crate) fn phase_rows(&self) -> usize {
        (2.0 * self.diameter[1]).round() as usize
    }

    /// Intensity of the whole grid for the phases moved by `shift` rows, `[rows][columns]`.
    pub fn intensity(&self, shift: usize) -> Vec<f32> {
        let [across, down] = self.side;
        let transform = self.row_transform(shift);
        let mut planner = FftPlannerScalar::new();
        let (mut intensity, mut scratch) = (vec![0.0; across * down], Vec::new());
        let mut light = vec![Lanes::zero(); across];
        for (group, rows) in intensity.chunks_exact_mut(across * LANES).enumerate() {
            transform.groups(group, &mut light, &mut scratch, &mut planner);
            for (lane, row) in rows.chunks_exact_mut(across).enumerate() {
                row.iter_mut().zip(&light).for_each(|(row, light)| *row = light.0[lane]);
            }
        }
        intensity
    }

    /// The field of the phases moved by `shift` rows, transformed along the rows.
    fn row_transform(&self, shift: usize) -> RowTransform {
        let [columns, rows] = self.diameter.map(|d| d.ceil() as usize);
        let mut lines = vec![Complex::new(Lanes::zero(), Lanes::zero()); columns.div_ceil(LANES) * self.side[1]];
        for (group, line) in lines.chunks_exact_mut(self.side[1]).enumerate() {
            self.phases(group * LANES..columns.min((group + 1) * LANES), shift, &mut line[..rows]);
        }
        // The other planners pick instructions by the CPU, and with them the last bits.
        FftPlannerScalar::new().plan_fft_forward(self.side[1]).process(&mut lines);
        RowTransform { side: self.side, lines }
    }

    /// The phases of some neighbouring columns, moved by `shift` rows; lanes for columns.
    fn phases(&self, columns: Range<usize>, shift: usize, line: &mut [Complex<Lanes>]) {
        let off = |at: usize, d: f64| (at as f64 + 0.5) / (0.5 * d) - 1.0;
        let square = |x: f64| x * x;
        let (mut keys, mut across2) = ([0; LANES], [f64::INFINITY; LANES]);
        for (lane, column) in columns.enumerate() {
            keys[lane] = mix(self.key ^ mix(column as u64)) as u32;
            across2[lane] = square(off(column, self.diameter[0]));
        }
        let down2: Vec<f64> = (0..line.len()).map(|row| square(off(row, self.diameter[1]))).collect();
        let mut start = 0;
        while start < line.len() {
            // Phases repeat.
            let first = (start + shift) % self.phase_rows();
            let end = line.len().min(start + self.phase_rows() - first);
            turn(&keys, &across2, first as u32, &down2[start..end], &mut line[start..end]);
            start = end;
        }
    }
}

/// Unit fields in the disc, with the phases of rows `first` on.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn turn(keys: &[u32; LANES], across2: &[f64; LANES], first: u32, down2: &[f64], line: &mut [Complex<Lanes>]) {
    for (row, (cell, down2)) in line.iter_mut().zip(down2).enumerate() {
        for lane in 0..LANES {
            let drawn = lanes::hash((first + row as u32) ^ keys[lane]) >> 8;
            let (cos, sin) = lanes::cos_sin_turns(drawn as i32 as f32 / 16_777_216.0);
            let inside = across2[lane] + down2 <= 1.0;
            cell.re.0[lane] = if inside { cos } else { 0.0 };
            cell.im.0[lane] = if inside { sin } else { 0.0 };
        }
    }
}

impl RowTransform {
    /// Intensity of the groups of rows from `first` on, as many as fit in `light`: `[groups][columns of the grid]`,
    /// lanes for rows.
    fn groups(
        &self,
        first: usize,
        light: &mut [Lanes],
        scratch: &mut Vec<Complex<Lanes>>,
        planner: &mut FftPlannerScalar<Lanes>,
    ) {
        let [across, down] = self.side;
        scratch.clear();
        scratch.resize(light.len(), Complex::zero());
        for (columns, line) in self.lines.chunks_exact(down).enumerate() {
            for (group, field) in scratch.chunks_exact_mut(across).enumerate() {
                let rows = &line[(first + group) * LANES..][..LANES];
                let to = &mut field[columns * LANES..];
                for (column, to) in to.iter_mut().take(LANES).enumerate() {
                    to.re = Lanes(std::array::from_fn(|row| rows[row].re.0[column]));
                    to.im = Lanes(std::array::from_fn(|row| rows[row].im.0[column]));
                }
            }
        }
        planner.plan_fft_forward(across).process(scratch);
        for (light, value) in light.iter_mut().zip(scratch) {
            *light = value.norm_sqr();
        }
    }
}

/// The patterns of `pupil` moved by two `shifts`, in pixels of `fine` samples: less their mean of 1, `[samples, TILE]`.
pub(super) fn gather(pupil: &Pupil, shifts: [usize; 2], law: SpeckleLaw, fine: usize) -> [Vec<f32>; 2] {
    let [across, down] = pupil.side;
    let mut planner = FftPlannerScalar::new();
    let transforms = shifts.map(|shift| pupil.row_transform(shift));
    let along = box_spectrum(across, fine);
    // `[TILE / LANES][rows]`, lanes for columns.
    let mut columns: Vec<Complex<Lanes>> = vec![Complex::zero(); TILE / LANES * down];
    let (mut scratch, mut lights) = (Vec::new(), [0, 1].map(|_| vec![Lanes::zero(); BLOCK_GROUPS * across]));
    let groups = down / LANES;
    for first in (0..groups).step_by(BLOCK_GROUPS) {
        let block = BLOCK_GROUPS.min(groups - first);
        for (transform, light) in transforms.iter().zip(&mut lights) {
            let light = &mut light[..block * across];
            transform.groups(first, light, &mut scratch, &mut planner);
            if law == SpeckleLaw::Rayleigh {
                light.iter_mut().for_each(|light| *light = light.map(f32::sqrt));
            }
        }
        scratch.clear();
        let [one, other] = &lights;
        scratch.extend(one.iter().zip(other).take(block * across).map(|(one, other)| Complex::new(*one, *other)));
        planner.plan_fft_forward(across).process(&mut scratch);
        let mut folded: Vec<Complex<Lanes>> = vec![Complex::zero(); block * TILE];
        for (line, folded) in scratch.chunks_exact(across).zip(folded.chunks_exact_mut(TILE)) {
            for (part, along) in line.chunks_exact(TILE).zip(along.chunks_exact(TILE)) {
                for ((sum, value), weight) in folded.iter_mut().zip(part).zip(along) {
                    *sum = *sum + *value * Lanes::of(*weight);
                }
            }
        }
        planner.plan_fft_inverse(TILE).process(&mut folded);
        for (group, line) in folded.chunks_exact(TILE).enumerate() {
            for (to, from) in columns.chunks_exact_mut(down).zip(line.chunks_exact(LANES)) {
                for (row, to) in to[(first + group) * LANES..][..LANES].iter_mut().enumerate() {
                    to.re = Lanes(std::array::from_fn(|column| from[column].re.0[row]));
                    to.im = Lanes(std::array::from_fn(|column| from[column].im.0[row]));
                }
            }
        }
    }
    planner.plan_fft_forward(down).process(&mut columns);
    let weights = box_spectrum(down, fine);
    for line in columns.chunks_exact_mut(down) {
        line.iter_mut().zip(&weights).for_each(|(value, weight)| *value = *value * Lanes::of(*weight));
    }
    planner.plan_fft_inverse(down).process(&mut columns);
    [|v: &Complex<Lanes>| v.re, |v: &Complex<Lanes>| v.im].map(|part| {
        let column = |number: usize| {
            let line = &columns[number / LANES * down..][..down];
            line.iter().map(move |value| f64::from(part(value).0[number % LANES]))
        };
        let mean = (0..TILE).flat_map(column).sum::<f64>() / (TILE * down) as f64;
        let scale = (1.0 / mean) as f32;
        let mut pattern = vec![0.0; TILE * down];
        for (columns, line) in columns.chunks_exact(down).enumerate() {
            for (row, value) in line.iter().enumerate() {
                let to = &mut pattern[row * TILE + columns * LANES..][..LANES];
                to.iter_mut().zip(part(value).0).for_each(|(to, value)| *to = value * scale - 1.0);
            }
        }
        pattern
    })
}

/// Amplitude that a box of `fine` samples leaves of each frequency of `side` samples [1].
fn box_spectrum(side: usize, fine: usize) -> Vec<f32> {
    let weight = |index: usize| {
        let cycles = if 2 * index > side { index as f64 - side as f64 } else { index as f64 };
        let angle = PI * cycles * fine as f64 / side as f64;
        if index == 0 { 1.0 } else { (libm::sin(angle) / angle) as f32 }
    };
    (0..side).map(weight).collect()
}
