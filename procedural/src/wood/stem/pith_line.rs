//! The pith line of a stem.
//!
//! Models: x and y of the pith at given heights, joined by cubics that pass each point with the mean slope of its two
//! neighbours (Catmull and Rom 1974, for uneven distances), so that position and slope are continuous. A grown pith
//! wanders about a straight line by value noise of three lengths. Source: the scanned log of Larsson et al. (2022): its
//! pith leaves its mean line by 5.3 mm rms, with correlations of 0.6 to 0.7 over 100 mm and 0.2 to 0.4 over 200 mm, and
//! tilts by 2.8 deg over 10 mm, 2.1 deg over 100 mm and 0.6 deg over 1 m. Limits: beyond its ends the line goes on
//! straight across the sections; no sweep and no crook.

use base::Stream;

use super::super::parameters::StemParameters;
use crate::noise::Noise;

/// Distance of the points of a grown pith [mm], that of the scanned log.
const STEP_MM: f64 = 10.0;
/// Cells of the wander [mm], after the correlation and the tilts of the scanned log.
const CELLS_MM: [f64; 3] = [300.0, 130.0, 45.0];
/// Their shares of the root mean square; squares sum to 1 [1].
const SHARES: [f64; 3] = [0.9, 0.41, 0.148];

/// A pith line.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct PithLine {
    /// x, y and height, with rising heights [mm].
    points: Vec<[f64; 3]>,
}

impl PithLine {
    /// The line through measured points, whose heights rise.
    pub fn through(points: &[[f64; 3]]) -> Self {
        Self { points: points.to_vec() }
    }

    /// The pith of a grown stem, about x = y = 0.
    pub fn grow(stream: Stream, numbers: &StemParameters) -> Self {
        // The root mean square is that of the distance; x and y share it.
        let wander = numbers.pith_wander_mm * std::f64::consts::FRAC_1_SQRT_2;
        let noise = ["x", "y"].map(|name| [0, 1, 2].map(|i| Noise::new(stream.child(name).index(i))));
        let count = (numbers.length_mm / STEP_MM).ceil() as usize;
        let points = (0..=count).map(|i| {
            let height = numbers.length_mm * i as f64 / count as f64;
            let [x, y] = noise.map(|octaves| {
                let value = |n: usize| SHARES[n] * f64::from(octaves[n].line((height / CELLS_MM[n]) as f32).0);
                wander * (value(0) + value(1) + value(2))
            });
            [x, y, height]
        });
        Self { points: points.collect() }
    }

    /// Place [mm] and slope [1] at a height [mm].
    pub fn at(&self, height: f64) -> ([f64; 2], [f64; 2]) {
        let points = &self.points;
        let last = points.len() - 1;
        if height <= points[0][2] {
            return ([points[0][0], points[0][1]], [0.0; 2]);
        }
        if height >= points[last][2] {
            return ([points[last][0], points[last][1]], [0.0; 2]);
        }
        let i = points.partition_point(|p| p[2] <= height) - 1;
        let (a, b) = (points[i], points[i + 1]);
        let length = b[2] - a[2];
        let u = (height - a[2]) / length;
        let slope = |i: usize, axis: usize| {
            let (before, after) = (points[i.saturating_sub(1)], points[(i + 1).min(last)]);
            // Level at the ends, where the line goes on straight.
            if i == 0 || i == last { 0.0 } else { (after[axis] - before[axis]) / (after[2] - before[2]) }
        };
        let along = |axis: usize| {
            let (from, to) = (length * slope(i, axis), length * slope(i + 1, axis));
            let rise = b[axis] - a[axis];
            let (square, cube) = (3.0 * rise - 2.0 * from - to, from + to - 2.0 * rise);
            (a[axis] + u * (from + u * (square + u * cube)), (from + u * (2.0 * square + 3.0 * u * cube)) / length)
        };
        let (x, y) = (along(0), along(1));
        ([x.0, y.0], [x.1, y.1])
    }
}
