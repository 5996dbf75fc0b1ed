//! Orientation of texture about a first guess, with its error: windows as wide as they may be.
//!
//! Model: the doubled angles q of `texture` are turned back by twice the guessed azimuth, so that what is left varies little and
//! wide windows do not blunt it. In a Gaussian window of width W,
//!   z = sum K q,  delta = arg(z) / 2,  se(delta) = sqrt(A sum K^2 q_across^2) / (2 |z|),
//! with q_across the part of q across z and A the pixels that share their light. Windows grow from 0.75 to 12 mm while each estimate
//! agrees with those before within their errors (Lepski 1991). Among the textures (streaks at two scales, rings and all at one) the
//! one with the smallest error wins in each cell, to which each adds a part that no window averages out: that of rings is so large
//! that they only speak where streaks are lost.
//! Limits: A holds for noise; streaks are related over a fibre's length, which makes errors on boards 1.2 times what is told.

use crate::raster::{Beyond, smooth};
use crate::texture::{Cells, Texture};

/// Widths of the windows [mm].
const WINDOWS_MM: [f32; 5] = [0.75, 1.5, 3.0, 6.0, 12.0];
/// A wider window is taken while it agrees with narrower ones within this many of their errors [1].
const AGREEMENT: f32 = 2.0;
/// Largest error that is told [rad]: directions at random have a standard deviation of 52 degrees.
pub(crate) const LOST_RAD: f32 = 0.9;

/// Orientation of cells about a guess.
#[derive(Debug, Clone)]
pub(crate) struct Orientation {
    /// Azimuth less the guess [rad].
    pub delta: Vec<f32>,
    /// Its standard error [rad].
    pub error: Vec<f32>,
    /// |sum K q| over sum K |q|, 0 for noise and 1 for lines [1].
    pub coherence: Vec<f32>,
}

/// Doubled angle and its variance across itself in a window, for every cell.
struct Window {
    z: [Vec<f32>; 2],
    length: Vec<f32>,
    second: [Vec<f32>; 3],
    /// Factor on the second moments [1].
    factor: f32,
}

impl Window {
    fn new(texture: &Texture, turned: &[Vec<f32>; 6], cells: &Cells, width_mm: f32) -> Self {
        let width = width_mm / cells.side_mm;
        let over = |i: usize, width: f32| smooth(&turned[i], cells.size, [width; 2], Beyond::Zero);
        // The square of a Gaussian is one of width / sqrt 2, less high by 1 / (4 pi width^2).
        let narrow = width * std::f32::consts::FRAC_1_SQRT_2;
        Self {
            z: [over(1, width), over(2, width)],
            length: over(0, width),
            second: [over(3, narrow), over(4, narrow), over(5, narrow)],
            factor: texture.correlated / (4.0 * std::f32::consts::PI * width * width),
        }
    }

    /// Azimuth [rad], its standard error [rad] and the coherence [1] of a cell.
    fn at(&self, cell: usize) -> (f32, f32, f32) {
        let (re, im) = (self.z[0][cell], self.z[1][cell]);
        let length = libm::hypotf(re, im);
        if length <= 1.0e-12 {
            return (0.0, LOST_RAD, 0.0);
        }
        let (c, s) = ((re * re - im * im) / (length * length), 2.0 * re * im / (length * length));
        let across = 0.5 * (self.second[0][cell] - self.second[1][cell] * c - self.second[2][cell] * s);
        let error = (self.factor * across.max(0.0)).sqrt() / (2.0 * length);
        let azimuth = 0.5 * procedural::atan2(im, re);
        (azimuth, error.min(LOST_RAD), (length / self.length[cell].max(f32::MIN_POSITIVE)).min(1.0))
    }
}

/// A texture's sums with the doubled angle turned back by twice the guess.
fn turned(texture: &Texture, guess: &[f32]) -> [Vec<f32>; 6] {
    let mut sums = texture.sums.clone();
    for (cell, azimuth) in guess.iter().enumerate() {
        let (s, c) = libm::sincosf(2.0 * azimuth);
        let (re, im) = (sums[1][cell], sums[2][cell]);
        (sums[1][cell], sums[2][cell]) = (re * c + im * s, im * c - re * s);
        let (s, c) = (2.0 * s * c, c * c - s * s);
        let (re, im) = (sums[4][cell], sums[5][cell]);
        (sums[4][cell], sums[5][cell]) = (re * c + im * s, im * c - re * s);
    }
    sums
}

/// Azimuths [rad], errors [rad] and coherences [1] of every cell in one window.
pub(crate) fn in_window(texture: &Texture, cells: &Cells, width_mm: f32) -> Vec<(f32, f32, f32)> {
    let window = Window::new(texture, &texture.sums, cells, width_mm);
    (0..cells.count()).map(|cell| window.at(cell)).collect()
}

/// Orientation of every cell about `guess` [rad].
pub(crate) fn orientation(textures: &[Texture], cells: &Cells, guess: &[f32]) -> Orientation {
    let count = cells.count();
    let mut best = Orientation { delta: vec![0.0; count], error: vec![LOST_RAD; count], coherence: vec![0.0; count] };
    for texture in textures {
        let sums = turned(texture, guess);
        let windows = WINDOWS_MM.map(|width| Window::new(texture, &sums, cells, width));
        let bias = texture.bias_rad;
        for cell in 0..count {
            let mut taken: [(f32, f32, f32); WINDOWS_MM.len()] = [(0.0, LOST_RAD, 0.0); WINDOWS_MM.len()];
            let mut last = 0;
            for (i, window) in windows.iter().enumerate() {
                taken[i] = window.at(cell);
                let (delta, error, _) = taken[i];
                let agrees = taken[..i].iter().all(|&(before, spread, _)| {
                    wrap(delta - before).abs() <= AGREEMENT * (spread * spread + error * error).sqrt()
                });
                if !agrees {
                    break;
                }
                last = i;
            }
            let (delta, error, coherence) = taken[last];
            let error = (error * error + bias * bias).sqrt().min(LOST_RAD);
            if error < best.error[cell] {
                (best.delta[cell], best.error[cell], best.coherence[cell]) = (delta, error, coherence);
            }
        }
    }
    best
}

/// An azimuth as that of the same line in (-pi/2, pi/2] [rad].
pub(crate) fn wrap(azimuth: f32) -> f32 {
    use std::f32::consts::{FRAC_PI_2, PI};
    let turned = azimuth - PI * (azimuth / PI).round();
    if turned <= -FRAC_PI_2 { turned + PI } else { turned }
}
