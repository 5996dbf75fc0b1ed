//! The diffusion tensor of a bundle of fibres.
//!
//! D_par = 1 / (3 sigma_i) along the fibre, D_perp = 1/4 int sin^3 / (sigma_i + k sin) across it
//! (docs/theory/physics.md).

/// Sines and weights of a 6-point Gauss-Legendre rule on [0, pi/2].
const SINES: [f64; 6] = [0.053_013_46, 0.262_956_75, 0.562_980_01, 0.826_470_51, 0.964_807_62, 0.998_593_8];
const WEIGHTS: [f64; 6] = [0.134_557_94, 0.283_341_48, 0.367_498_74, 0.367_498_74, 0.283_341_48, 0.134_557_94];

/// Diffusion coefficients along and across the fibre [mm], for `sigma_i` and `k` in mm^-1; exact to 1e-5.
pub fn diffusion(sigma_i: f64, k: f64) -> (f64, f64) {
    let term = |(sine, weight): (f64, f64)| 0.5 * weight * sine * sine * sine / (sigma_i + k * sine);
    (1.0 / (3.0 * sigma_i), SINES.into_iter().zip(WEIGHTS).map(term).sum())
}
