//! The outline of a stem: its radius at every azimuth and height.
//!
//! Models: a measured outline is a table of distances from the pith, linear between its entries. A grown one stands
//! about its own straight axis, o away from the pith, which wanders in it:
//!
//! ```text
//! radius = o e + sqrt(rho^2 - (o x e)^2),  e towards the azimuth
//! rho = R(h) (1 + b_0(h) + q cos(2 (azimuth - d(h))) + sum_k lobes of order 3 to 6)
//! ```
//!
//! with R falling along the stem (taper), q = (oval - 1) / (oval + 1), and b_0, d and the lobes as noise along the
//! stem. Source: Fourier terms of the scanned log of Larsson et al. (2022), root mean squares over its sections. They
//! are 6.1 percent of the mean radius at the first order (the pith off the middle, 4.7 percent on average and the rest
//! its wander), 2.5 at the second, whose direction stays, and 1.2, 0.8, 0.5 and 0.7 at the third to sixth. They change
//! over 200 to 400 mm. The mean radius leaves its line by 1.1 percent. Limits: no swelling at whorls or at the butt, no
//! scars.

use std::f64::consts::TAU;

use base::Stream;
use rand::RngExt;

use super::super::parameters::StemParameters;
use crate::noise::Noise;

/// Cell of the noise along the stem [mm].
const CELL_MM: f64 = 350.0;
/// Orders of the lobes.
const ORDERS: [f64; 4] = [3.0, 4.0, 5.0, 6.0];
/// Amplitudes of the lobes over their root mean square together, after the scanned log; squares sum to 2 [1].
const LOBES: [f64; 4] = [0.99, 0.68, 0.45, 0.57];
/// Variation of the mean radius over that of the lobes [1].
const BREADTH: f64 = 0.9;
/// Spread of the oval's direction [rad].
const OVAL_TURN: f64 = 0.15;
/// The outline is nowhere nearer than this to its axis, over the mean radius [1].
const LEAST: f64 = 0.3;

/// The outline of a stem.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum StemOutline {
    /// As a model says.
    Grown(Box<GrownOutline>),
    /// As a scanner saw it.
    Measured {
        /// Heights of the first and the last section [mm].
        ends: [f64; 2],
        /// Distances from the pith [mm], [section, falling azimuth].
        radii: Vec<Vec<f64>>,
    },
}

/// The outline of a grown stem.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct GrownOutline {
    radius: f64,
    /// Loss of radius with height [1].
    taper: f64,
    /// Height where the radius is the mean one [mm].
    middle: f64,
    /// Axis of the outline [mm].
    axis: [f64; 2],
    oval: f64,
    direction: f64,
    /// Root mean square of the lobes [1].
    lobes: f64,
    breadth: Noise,
    turn: Noise,
    waves: [[Noise; 2]; 4],
}

impl GrownOutline {
    /// The outline of a stem of those numbers.
    pub fn grow(stream: Stream, numbers: &StemParameters) -> Self {
        let side = |name: &str| TAU * stream.child(name).rng().random::<f64>();
        let (sin, cos) = libm::sincos(side("eccentricity"));
        let away = numbers.eccentricity * numbers.radius_mm;
        Self {
            radius: numbers.radius_mm,
            taper: 1.0e-3 * numbers.taper_mm_per_m,
            middle: 0.5 * numbers.length_mm,
            axis: [away * cos, away * sin],
            oval: (numbers.oval - 1.0) / (numbers.oval + 1.0),
            direction: side("oval"),
            lobes: numbers.lobes,
            breadth: Noise::new(stream.child("breadth")),
            turn: Noise::new(stream.child("turn")),
            waves: std::array::from_fn(|k| [0, 1].map(|i| Noise::new(stream.child("lobes").index(k as u64).index(i)))),
        }
    }

    fn radius(&self, azimuth: f64, height: f64, pith: [f64; 2]) -> f64 {
        let at = |noise: Noise| f64::from(noise.line((height / CELL_MM) as f32).0);
        let oval = self.oval * libm::cos(2.0 * (azimuth - self.direction - OVAL_TURN * at(self.turn)));
        let mut shape = 1.0 + BREADTH * self.lobes * at(self.breadth) + oval;
        for ((order, amplitude), [cosine, sine]) in ORDERS.into_iter().zip(LOBES).zip(self.waves) {
            let (sin, cos) = libm::sincos(order * azimuth);
            // Two parts of variance 1 have an amplitude of sqrt 2.
            shape += std::f64::consts::FRAC_1_SQRT_2 * self.lobes * amplitude * (at(cosine) * cos + at(sine) * sin);
        }
        let mean = (self.radius - self.taper * (height - self.middle)).max(LEAST * self.radius);
        let rho = mean * shape.max(LEAST);
        let (sin, cos) = libm::sincos(azimuth);
        let away = [self.axis[0] - pith[0], self.axis[1] - pith[1]];
        let (ahead, aside) = (away[0] * cos + away[1] * sin, away[0] * sin - away[1] * cos);
        (ahead + (rho * rho - aside * aside).max(0.0).sqrt()).max(LEAST * LEAST * self.radius)
    }
}

impl StemOutline {
    /// The outline of measured sections.
    pub fn measured(ends: [f64; 2], radii: &[Vec<f64>]) -> Self {
        Self::Measured { ends, radii: radii.to_vec() }
    }

    /// Distance from the pith, which lies at x and y [mm], to the outline at an azimuth [rad] and a height [mm], in mm.
    pub fn radius(&self, azimuth: f64, height: f64, pith: [f64; 2]) -> f64 {
        match self {
            Self::Grown(outline) => outline.radius(azimuth, height, pith),
            Self::Measured { ends, radii } => {
                let last = radii.len() - 1;
                let at = ((height - ends[0]) / (ends[1] - ends[0]) * last as f64).clamp(0.0, last as f64);
                let row = (at as usize).min(last - 1);
                let columns = radii[0].len();
                let round = (-azimuth / TAU).rem_euclid(1.0) * columns as f64;
                let (column, along) = ((round as usize).min(columns - 1), round - libm::floor(round));
                let section = |row: usize| {
                    let (a, b) = (radii[row][column], radii[row][(column + 1) % columns]);
                    a + along * (b - a)
                };
                section(row) + (at - row as f64) * (section(row + 1) - section(row))
            }
        }
    }
}
