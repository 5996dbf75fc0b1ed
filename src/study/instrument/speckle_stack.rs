//! Patterns of the stack before pixels gather them, against the law of fully developed speckle.
//!
//! A grid of 512 samples behind a pupil of 256: the law of points four grains apart against exp(-I), and the correlation of
//! patterns u steps apart of Bergmann's M = 16, whose pupils stand s = sin(pi u / 32) diameters apart.

use procedural::Stream;
use rustfft::FftPlannerScalar;

use super::pattern::overlap;
use super::{Figure, chance, each};
use crate::optics::speckle::field::Pupil;

/// Steps of the stack between the patterns that are compared.
pub(super) const STEPS: [f64; 5] = [1.0, 2.0, 4.0, 8.0, 12.0];
/// Samples along a side, and samples a grain.
const SIDE: usize = 512;
const GRAIN: f64 = 2.0;

pub(super) struct Found {
    /// Light of mean 1 in independent points [1].
    points: Vec<f64>,
    /// Correlation by [`STEPS`] [1].
    pub alike: Vec<f64>,
}

/// Distance between pupils u steps apart, in diameters.
pub(super) fn chord(u: f64) -> f64 {
    libm::sin(std::f64::consts::PI * u / 32.0)
}

pub(super) fn found(own: Stream) -> Found {
    let pupil = Pupil::new([SIDE; 2], GRAIN, own);
    let light = |shift: usize| -> Vec<f64> {
        let mut light = vec![0.0f32; SIDE * SIDE];
        pupil.half(shift).rows(0, &mut light, &mut Vec::new(), &mut FftPlannerScalar::new());
        let mean = light.iter().map(|v| f64::from(*v)).sum::<f64>() / light.len() as f64;
        light.iter().map(|v| f64::from(*v) / mean - 1.0).collect()
    };
    let first = light(0);
    let product = |other: &[f64]| first.iter().zip(other).map(|(a, b)| a * b).sum::<f64>() / first.len() as f64;
    let shift = |u: &f64| (chord(*u) * SIDE as f64 / GRAIN).round() as usize;
    let points = first.iter().enumerate().filter(|(i, _)| (i / SIDE).is_multiple_of(8) && i.is_multiple_of(8));
    Found {
        points: points.map(|(_, v)| 1.0 + v).collect(),
        alike: STEPS.iter().map(|u| product(&light(shift(u)))).collect(),
    }
}

pub(super) fn figures(found: &[&Found]) -> Vec<Figure> {
    let mut all: Vec<f64> = found.iter().flat_map(|f| f.points.iter().copied()).collect();
    let distance = chance::distance(&mut all, |x| 1.0 - libm::exp(-x));
    let mut figures = vec![Figure::distance("distance to exp(-I), a point [1]", distance, all.len())];
    for (i, u) in STEPS.iter().enumerate() {
        let name = format!("correlation of patterns {u} of 32 apart, a point [1]");
        figures.push(Figure::of(&name, &each(found, |f| f.alike[i]), overlap(chord(*u)).powi(2)));
    }
    figures
}
