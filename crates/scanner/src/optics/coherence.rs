//! Coherence: how much the spread of path lengths in matter reduces speckle contrast.
//!
//! Goodman's rule for partial coherence over the path lengths of quantised diffusion (see
//! [`transport::kernel`]). Neglected: light scattered by cylinders alone has shorter paths than diffusion gives
//! it.

use procedural::Medium;

use transport::kernel::diffusion;

/// Shortest path [mm].
const MIN_PATH_MM: f64 = 0.003;
/// Longest path [mm].
const MAX_PATH_MM: f64 = 200.0;
/// Path lengths between the two, evenly spaced in their logarithm.
const PATH_LENGTHS: usize = 200;

/// Contrast of speckle in light from below after paths of different lengths, for a Gaussian spectrum of the laser [1].
///
/// C^2 = sum over pairs of path lengths of w w' exp(-(pi (dlambda / lambda^2) n (tau - tau'))^2 / (2 ln 2)), Goodman's
/// rule for partial coherence; `linewidth_nm` is the full width at half maximum. `boundary` is A(n).
pub fn coherence_contrast(medium: &Medium, boundary: f64, wavelength_nm: f64, linewidth_nm: f64) -> f64 {
    let (a, s, k) = (f64::from(medium.mu_a), f64::from(medium.sigma_i), f64::from(medium.k));
    let (_, d_perp) = diffusion(s, k);
    let z0 = 1.0 / (s + k);
    let z2 = z0 + 4.0 * boundary * d_perp;
    // Logarithms: matter that lets hardly any light out still has a contrast.
    let logarithms: Vec<(f64, f64)> = (0..PATH_LENGTHS)
        .map(|i| {
            let tau = MIN_PATH_MM * libm::pow(MAX_PATH_MM / MIN_PATH_MM, i as f64 / (PATH_LENGTHS as f64 - 1.0));
            let term = |z: f64| libm::log(z) - z * z / (4.0 * d_perp * tau);
            let (near, far) = (term(z0), term(z2));
            let both = near.max(far) + libm::log1p(libm::exp(-(near - far).abs()));
            (tau, both - a * tau - 0.5 * libm::log(tau))
        })
        .collect();
    let most = logarithms.iter().map(|(_, w)| *w).fold(f64::NEG_INFINITY, f64::max);
    let weights: Vec<(f64, f64)> = logarithms.into_iter().map(|(tau, w)| (tau, libm::exp(w - most))).collect();
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

#[cfg(test)]
mod tests {
    use super::*;
    use procedural::Gloss;
    use rand::RngExt;
    use transport::fresnel::boundary_factor;

    /// Whatever matter a recipe may have, the contrast is a number above 0 and at most 1, also where no light comes back.
    #[test]
    fn all_matter_has_a_contrast() {
        let mut rng = procedural::Stream::root(5).child("matter").rng();
        let mut draw = |low: f64, high: f64| low * (high / low).powf(rng.random::<f64>());
        for _ in 0..200 {
            let (mu_a, sigma_i, k) = (draw(1e-4, 1e3), draw(0.01, 200.0), draw(1e-3, 200.0));
            let (n, width) = (draw(1.0, 2.0), draw(1e-4, 10.0));
            let medium =
                Medium { k: k as f32, ..Medium::isotropic(mu_a as f32, sigma_i as f32, n as f32, Gloss::NONE) };
            let contrast = coherence_contrast(&medium, boundary_factor(n), 660.0, width);
            assert!(contrast > 0.0 && contrast <= 1.0 + 1e-12, "{mu_a} {sigma_i} {k} {n} {width}: {contrast}");
        }
    }

    /// Matter without fibres is the limit of few fibres, and the further light travels in it, the less speckle is left.
    #[test]
    fn matter_without_fibres_washes_speckle_out_by_how_far_light_runs() {
        let contrast = |sigma: f32, k: f32| {
            let medium = Medium { k, ..Medium::isotropic(0.005, sigma, 1.5, Gloss::NONE) };
            coherence_contrast(&medium, boundary_factor(1.5), 660.0, 0.5)
        };
        let few: Vec<f64> = [12.0, 40.0, 400.0].map(|sigma| contrast(sigma, 1e-4)).to_vec();
        let none: Vec<f64> = [12.0, 40.0, 400.0].map(|sigma| contrast(sigma, 0.0)).to_vec();
        for (few, none) in few.iter().zip(&none) {
            assert!((few - none).abs() < 1e-3, "{few} with few fibres, {none} without");
        }
        assert!(none[0] > 0.0 && none[0] < none[1] && none[1] < none[2] && none[2] < 1.0, "{none:?}");
    }
}
