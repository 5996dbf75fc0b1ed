//! Stam's implicit diffusion with coefficients of the receiving pixel, as the thesis used it.
//!
//! Each iteration is a time step from u0 = u, by Gauss-Seidel sweeps in the order of rows (Stam 2003):
//!
//! ```text
//! u_i <- (u0_i + sum_k a_k u_k) / (1 + sum_k a_k)          k over eight neighbours, a_k of pixel i
//! u_i <- alpha_i^(1 / iterations) u_i                      after each iteration
//! ```
//!
//! The thesis says that a_k follows the direction, and not how: here a_k is proportional to cos^2p of the angle between
//! fibre and neighbour. Where alpha is below 1, and where there is no direction, all are equal, which is its rule for
//! knots. Beyond the border stands a copy of the border, as in Stam's paper.
//!
//! Fails: where neighbours differ, what i takes from k is not what k gives to i, so light is made or lost. The number
//! of iterations takes the place of the matter; an unfinished solution has its long tail where the sweeps run to
//! (skewness 0.4 with one sweep a step). Two neighbours share a direction between them and pull the axis to the
//! diagonal: with p = 3 a fibre at 22.5 degrees spreads light along 32, and the variances along and across are as 5 to
//! 1 on the pixels' axes and as 17 to 1 on their diagonals.

use rayon::prelude::*;

use super::{DirectionMap, LightPicture};

/// Neighbours E, NE, N, NW as (columns, rows); the other four lie opposite.
const HALF_NEIGHBOURS: [(i64, i64); 4] = [(1, 0), (1, 1), (0, 1), (-1, 1)];

/// Sum of a pixel's eight coefficients, eight times one (our choice) [1].
const RATE: f64 = 8.0;

/// Coefficients of each pixel for both neighbours on each of the lines W-E, SW-NE, S-N, SE-NW; they sum to [`RATE`].
/// They go with cos^6 of the angle between fibre and neighbour (our choice): so the variances along and across fibres
/// in line with the pixels are as 5 to 1, like clear wood's diffusion.
fn coefficients(map: &DirectionMap) -> Vec<[f64; 4]> {
    let of = |i: usize| {
        let weights = match map.direction(i) {
            Some(along) if map.alpha(i) == 1.0 => HALF_NEIGHBOURS.map(|(x, y)| {
                let (x, y) = (x as f64, y as f64);
                let dot = along.x * x + along.y * y;
                let cos2 = dot * dot / (x * x + y * y);
                cos2 * cos2 * cos2
            }),
            _ => [1.0; 4],
        };
        let scale = RATE / (2.0 * weights.iter().sum::<f64>());
        weights.map(|weight| weight * scale)
    };
    (0..map.rows() * map.cols()).into_par_iter().map(of).collect()
}

/// `picture` after `iterations` time steps of `sweeps` sweeps.
pub(super) fn spread(picture: &LightPicture, map: &DirectionMap, iterations: u32, sweeps: u32) -> LightPicture {
    let coefficients = coefficients(map);
    let (rows, cols) = (picture.rows as i64, picture.cols as i64);
    let root = 1.0 / f64::from(iterations.max(1));
    let left: Vec<f64> = (0..picture.light.len()).map(|i| libm::pow(map.alpha(i), root)).collect();
    let mut light = picture.light.clone();
    for _ in 0..iterations {
        let start = light.clone();
        for _ in 0..sweeps {
            for row in 0..rows {
                for col in 0..cols {
                    let i = (row * cols + col) as usize;
                    let at = |x: i64, y: i64| {
                        light[((row + y).clamp(0, rows - 1) * cols + (col + x).clamp(0, cols - 1)) as usize]
                    };
                    let (mut sum, mut total) = (start[i], 1.0);
                    for (&a, (x, y)) in coefficients[i].iter().zip(HALF_NEIGHBOURS) {
                        sum += a * (at(x, y) + at(-x, -y));
                        total += 2.0 * a;
                    }
                    light[i] = sum / total;
                }
            }
        }
        for (light, left) in light.iter_mut().zip(&left) {
            *light *= left;
        }
    }
    LightPicture { rows: picture.rows, cols: picture.cols, light }
}
