//! Light behind a round pupil of random phases: fully developed speckle on a grid.
//!
//! A disc of D cells with unit amplitude and even random phase, seen in a Fourier transform of side Q, has the intensity
//!
//! ```text
//! p(I) = exp(-I),    <I I'> - 1 = [2 J1(pi r / L) / (pi r / L)]^2,    L = Q / D samples = lambda N (1 + m)
//! ```
//!
//! with Q >= 2 D (Duncan and Kirkpatrick 2008; Goodman 2007). L is not the size 1.22 L of the first zero, which is the
//! quoted grain. The grid's sides may differ: the disc is then an ellipse in cells, round on the sensor. The phases go on
//! behind the disc for two diameters, in a ring: shifted against the disc by s diameters they give the pattern of a pupil
//! that has moved as far ([`super`]).
//!
//! Valid for a rough, resting surface and polarised light of one wavelength. The mean over the grid is made exactly 1 by who
//! uses it.

use procedural::Stream;
use procedural::stream::mix;
use rustfft::FftPlannerScalar;
use rustfft::num_complex::Complex32;

use crate::lanes;

/// A pupil of random phases.
#[derive(Debug, Clone)]
pub struct Pupil {
    /// Samples of the grid along columns and rows.
    side: [usize; 2],
    /// Cells of the disc along both.
    diameter: [f64; 2],
    key: u64,
}

/// The field half way: transformed along the rows.
#[derive(Debug)]
pub struct Half {
    side: [usize; 2],
    columns: usize,
    /// `[columns of the disc][rows of the grid]`.
    lines: Vec<Complex32>,
}

impl Pupil {
    /// For a grid of `side` samples and grains L of `grain` samples, at least 2.
    pub fn new(side: [usize; 2], grain: f64, stream: Stream) -> Self {
        Self { side, diameter: side.map(|side| side as f64 / grain), key: stream.child("phases").key() }
    }

    /// Samples of the grid along columns and rows.
    pub fn side(&self) -> [usize; 2] {
        self.side
    }

    /// Rows of phases after which they come again: two diameters.
    pub fn round(&self) -> usize {
        (2.0 * self.diameter[1]).round() as usize
    }

    /// The field of the phases moved by `shift` rows, transformed along the rows.
    pub fn half(&self, shift: usize) -> Half {
        let [columns, rows] = self.diameter.map(|d| d.ceil() as usize);
        let mut lines = vec![Complex32::default(); columns * self.side[1]];
        let off = |at: usize, d: f64| (at as f64 + 0.5) / (0.5 * d) - 1.0;
        for (column, line) in lines.chunks_exact_mut(self.side[1]).enumerate() {
            let key = mix(self.key ^ mix(column as u64)) as u32;
            let across = off(column, self.diameter[0]);
            for (row, cell) in line[..rows].iter_mut().enumerate() {
                let down = off(row, self.diameter[1]);
                if across * across + down * down <= 1.0 {
                    let place = (row + shift) % self.round();
                    let (cos, sin) = lanes::turn((lanes::hash(place as u32 ^ key) >> 8) as f32 / 16_777_216.0);
                    *cell = Complex32::new(cos, sin);
                }
            }
        }
        // The other planners pick instructions by the CPU, and with them the last bits.
        FftPlannerScalar::new().plan_fft_forward(self.side[1]).process(&mut lines);
        Half { side: self.side, columns, lines }
    }
}

impl Half {
    /// Intensity of the rows from `first` on, as many as `light` has room for; `[rows][columns of the grid]`.
    pub fn rows(
        &self,
        first: usize,
        light: &mut [f32],
        room: &mut Vec<Complex32>,
        planner: &mut FftPlannerScalar<f32>,
    ) {
        let [across, down] = self.side;
        let rows = light.len() / across;
        room.clear();
        room.resize(light.len(), Complex32::default());
        for column in 0..self.columns {
            for (row, value) in self.lines[column * down + first..][..rows].iter().enumerate() {
                room[row * across + column] = *value;
            }
        }
        planner.plan_fft_forward(across).process(room);
        for (light, value) in light.iter_mut().zip(room) {
            *light = value.norm_sqr();
        }
    }
}
