//! From the judge's measurements of a half space to what the table keeps of it.
//!
//! Bins that were not walked follow from diffusion: weight falls like path^-3/2 from what was still inside, variances grow
//! by 2 D per path, the shift stays.

use super::table::{BINS, CONE, LANES, NODE, VIEWS};
use super::tensor::diffusion;
use super::view::View;
use crate::transport::path::paths::{AZIMUTHS_DEG, Bin, FIRST, Paths, RATIO, TILTS_DEG, WALKED};

/// Cone light under this share has no measured directions of its own [1].
const FAINT: f64 = 3e-3;

/// How much each tilt of [`TILTS_DEG`] counts: triangulation cameras stand between 15 and 45 degrees [1].
const SEEN_FROM: [f64; 4] = [1.0, 3.0, 1.0, 0.3];

/// What the table keeps of `paths`.
pub fn condense(paths: &Paths) -> [f32; NODE] {
    let mut node = [0.0; NODE];
    let mut put = |lane: usize, values: [f64; 5]| {
        for (field, value) in values.into_iter().enumerate() {
            node[field * LANES + lane] = value as f32;
        }
    };
    for lane in 0..WALKED {
        put(lane, walked(&paths.bins[0][lane], lane));
        put(CONE + lane, walked(&paths.bins[1][lane], lane));
    }
    let (along, across) = spreading(paths);
    let last = walked(&paths.bins[1][WALKED - 1], WALKED - 1);
    let edge = |bin: usize| FIRST * libm::pow(RATIO, bin as f64);
    let start = edge(WALKED);
    for bin in WALKED..BINS - CONE {
        let (low, high) = (edge(bin), edge(bin + 1));
        let inside = |path: f64| (start / path).sqrt();
        let beyond = if bin + 1 == BINS - CONE { 0.0 } else { inside(high) };
        let path = (low * high).sqrt();
        let grown = 2.0 * (path - last[1]);
        let weight = paths.left * (inside(low) - beyond);
        put(CONE + bin, [weight, path, last[2], last[3] + along * grown, last[4] + across * grown]);
    }
    // Padding is never read; a path of 1 and a variance of 1 keep it finite.
    for lane in BINS..LANES {
        put(lane, [0.0, 1.0, 0.0, 1.0, 1.0]);
    }
    node[NODE - VIEWS..].copy_from_slice(&views(paths));
    node
}

/// Weight, mean path, mean displacement, variances of one bin; a bin without light has its middle path.
fn walked(bin: &Bin, place: usize) -> [f64; 5] {
    if bin.weight <= 0.0 {
        let middle = FIRST * libm::pow(RATIO, place as f64 + 0.5);
        return [0.0, middle, 0.0, 0.0, 0.0];
    }
    let mean = |sum: f64| sum / bin.weight;
    let along = mean(bin.along);
    [bin.weight, mean(bin.path), along, (mean(bin.along2) - along * along).max(0.0), mean(bin.across2)]
}

/// Diffusion along the fibres' track and across it [mean free paths].
fn spreading(paths: &Paths) -> (f64, f64) {
    let (d_par, d_perp) = diffusion(paths.of.rho, 1.0 - paths.of.rho);
    let sin = libm::sin(paths.of.dive_deg.to_radians());
    (d_perp * d_par / (d_perp + (d_par - d_perp) * sin * sin), d_perp)
}

/// Coefficients of the radiance factors by weighted least squares.
fn views(paths: &Paths) -> [f32; VIEWS] {
    let sin_dive = libm::sin(paths.of.dive_deg.to_radians()) as f32;
    let faint = paths.bins[0].iter().map(|bin| bin.weight).sum::<f64>() < FAINT;
    let (mut cone, mut rest) = (Fit::default(), Fit::default());
    for (i, tilt) in TILTS_DEG.iter().enumerate() {
        for (j, azimuth) in AZIMUTHS_DEG.iter().enumerate() {
            let (up, flat) = libm::sincos(tilt.to_radians());
            let along = up * libm::cos(azimuth.to_radians());
            let view = View::new(along as f32, flat as f32, paths.of.n as f32, sin_dive);
            let [guided, turned] = [paths.views[0][i][j], paths.views[1][i][j]];
            // Flux that the view stands for, and how much cameras look from there.
            let solid = up * flat * SEEN_FROM[i];
            if guided > 0.0 {
                // The error of a logarithm is that of the factor over it.
                cone.add(view.cone_terms(), libm::log(guided), solid * guided * guided);
            }
            rest.add(view.rest_terms(), turned, solid);
        }
    }
    let cone = if faint { [0.0; 4] } else { cone.solve() };
    let rest = rest.solve();
    std::array::from_fn(|i| if i < 4 { cone[i] } else { rest[i - 4] } as f32)
}

/// Normal equations of a least-squares fit of four coefficients.
#[derive(Default)]
struct Fit {
    matrix: [[f64; 4]; 4],
    right: [f64; 4],
}

impl Fit {
    fn add(&mut self, terms: [f32; 4], value: f64, weight: f64) {
        let terms = terms.map(f64::from);
        for i in 0..4 {
            self.right[i] += weight * terms[i] * value;
            for j in 0..4 {
                self.matrix[i][j] += weight * terms[i] * terms[j];
            }
        }
    }

    /// By Gauss and Jordan; a touch of ridge keeps terms at 0 that the views do not tell apart.
    fn solve(mut self) -> [f64; 4] {
        let scale = self.matrix[0][0].max(1e-12);
        for i in 0..4 {
            self.matrix[i][i] += 1e-6 * scale;
        }
        for i in 0..4 {
            let pivot = self.matrix[i][i];
            for j in 0..4 {
                self.matrix[i][j] /= pivot;
            }
            self.right[i] /= pivot;
            for row in (0..4).filter(|&row| row != i) {
                let factor = self.matrix[row][i];
                for j in 0..4 {
                    self.matrix[row][j] -= factor * self.matrix[i][j];
                }
                self.right[row] -= factor * self.right[i];
            }
        }
        self.right
    }
}
