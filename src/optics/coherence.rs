//! How far the spread of path lengths in matter washes speckle out.
//!
//! Goodman's rule for partial coherence over the path lengths of quantised diffusion (see [`crate::transport::kernel`]).
//! Neglected: light that met cylinders alone has shorter paths than the diffusion gives it.

use procedural::Medium;

use crate::transport::kernel::diffusion;

/// Shortest and longest path [mm].
const PATHS_MM: (f64, f64) = (0.003, 200.0);

/// Contrast of speckle in light from below after paths of different lengths, for a Gaussian laser line [1].
///
/// C^2 = sum over pairs of path lengths of w w' exp(-(pi (dlambda / lambda^2) n (tau - tau'))^2 / (2 ln 2)), Goodman's
/// rule for partial coherence; `linewidth_nm` is the full width at half maximum. `boundary` is A(n).
pub fn coherence_contrast(medium: &Medium, boundary: f64, wavelength_nm: f64, linewidth_nm: f64) -> f64 {
    const STEPS: usize = 200;
    let (a, s, k) = (f64::from(medium.mu_a), f64::from(medium.sigma_i), f64::from(medium.k));
    let (_, d_perp) = diffusion(s, k);
    let z0 = 1.0 / (s + k);
    let z2 = z0 + 4.0 * boundary * d_perp;
    let weights: Vec<(f64, f64)> = (0..STEPS)
        .map(|i| {
            let tau = PATHS_MM.0 * libm::pow(PATHS_MM.1 / PATHS_MM.0, i as f64 / (STEPS as f64 - 1.0));
            let term = |z: f64| z * libm::exp(-z * z / (4.0 * d_perp * tau));
            (tau, (term(z0) + term(z2)) * libm::exp(-a * tau) / tau.sqrt())
        })
        .collect();
    let total: f64 = weights.iter().map(|(_, w)| w).sum();
    // Wave numbers per mm: wavelength in mm is 1e-6 of it in nm.
    let band = std::f64::consts::PI * linewidth_nm / (wavelength_nm * wavelength_nm) * 1e6 * f64::from(medium.n_eff);
    let mut sum = 0.0;
    for &(t, w) in &weights {
        for &(t2, w2) in &weights {
            let phase = band * (t - t2);
            sum += w * w2 * libm::exp(-phase * phase / (2.0 * std::f64::consts::LN_2));
        }
    }
    (sum / (total * total)).sqrt()
}
