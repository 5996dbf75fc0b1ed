//! Coherence: how much the spread of path lengths in matter reduces speckle contrast.
//!
//! Goodman's rule for partial coherence: C^2 = sum over pairs of path lengths of w w' exp(-D^2 / (2 ln 2)), with D = pi
//! (dlambda / lambda^2) n (tau - tau') and dlambda the full width at half maximum of a Gaussian spectrum. The paths are
//! those of the light that is seen in a row ([`transport::kernel::path_laws`]): light far from the line has taken
//! longer and more different ones, so Scatter's rows have less contrast than the line's own; those of packs, through
//! the air and tablets below the film too ([`transport::kernel::film_stack::paths`]).

use multiversion::multiversion;
use numerics::lanes::{exp, ln};
use transport::kernel::PathLaw;

/// Distances from the line for which contrasts are worked out, on both sides of it [px].
pub const CONTRAST_ROWS: [f32; 8] = [0.0, 0.4, 0.8, 1.2, 1.6, 3.0, 7.0, 16.0];
/// The same behind the line, where they are negative, after those ahead of it [px].
pub const CONTRAST_PLACES: [f32; 15] = {
    let mut places = [0.0; 15];
    let mut node = 0;
    while node < CONTRAST_ROWS.len() {
        places[place_of(1, node)] = -CONTRAST_ROWS[node];
        places[node] = CONTRAST_ROWS[node];
        node += 1;
    }
    places
};
/// Of these so many lie so near to the line that light changes within a row.
const NEAR_ROWS: usize = 4;
/// Weights of a place and of those on both sides of it for an integral over the row that it is in the middle of, exact
/// for squares [1].
const IN_ROW: [f32; 2] = [1.0 - 2.0 / (12.0 * 0.32), 1.0 / (12.0 * 0.32)];
/// Neighbouring columns that share their contrasts.
pub(crate) const CONTRAST_COLUMNS: usize = 16;

/// Contrasts of rows whose middles are [`CONTRAST_ROWS`] ahead of a line, and of those as far behind it [1].
pub type RowContrasts = [[f32; CONTRAST_ROWS.len()]; 2];

/// Which of [`CONTRAST_PLACES`] one of [`CONTRAST_ROWS`] is ahead of the line (0) or behind it (1).
const fn place_of(side: usize, node: usize) -> usize {
    if side == 0 || node == 0 { node } else { node + CONTRAST_ROWS.len() - 1 }
}

/// Contrasts of rows about a line, of what evenly lit rows have whose paths are alike; `laws` are the paths of the
/// light at [`CONTRAST_PLACES`] as the lens shows it, before pixels, and D grows by `per_mm` with their difference.
///
/// A pixel adds up grains that know nothing of each other, so its variance is the integral over it of that of its
/// light: C^2 = int I^2 c^2 / (int I)^2. Where a row holds the flank of the line fewer grains count.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
pub fn row_contrasts(per_mm: f32, laws: &[PathLaw; CONTRAST_PLACES.len()]) -> RowContrasts {
    let mut own = [0.0; CONTRAST_PLACES.len()];
    for (own, law) in own.iter_mut().zip(laws) {
        *own = path_contrast(per_mm, law);
    }
    [0, 1].map(|side| {
        std::array::from_fn(|node| {
            let here = place_of(side, node);
            if node >= NEAR_ROWS || laws[here].light <= 0.0 {
                return own[here];
            }
            let inwards = if node == 0 { place_of(1 - side, 1) } else { place_of(side, node - 1) };
            let parts = [(here, IN_ROW[0]), (inwards, IN_ROW[1]), (place_of(side, node + 1), IN_ROW[1])];
            // Light of matter that swallows nearly all of it is so little that its square is nothing.
            let most = parts.iter().fold(0.0f32, |most, &(place, _)| most.max(laws[place].light));
            let (mut light, mut squares) = (0.0, 0.0);
            for (place, weight) in parts {
                let part = laws[place].light / most;
                light += weight * part;
                squares += weight * (part * own[place]) * (part * own[place]);
            }
            squares.sqrt() / light
        })
    })
}

/// Coefficients of 1, t and t^2 of the contrast `from + t` rows from a line on one side of it, for t from 0 to 1.
#[inline(always)]
pub(crate) fn contrast_curve(at: &[f32; CONTRAST_ROWS.len()], from: usize) -> [f32; 3] {
    if from == 0 {
        // Through 0, 0.5, as the parabola through the first three places has it, and 1.
        let half = -0.09375 * at[0] + 0.9375 * at[1] + 0.15625 * at[2];
        let one = 0.5 * (at[2] + at[3]);
        return [at[0], 4.0 * half - 3.0 * at[0] - one, 2.0 * (at[0] + one) - 4.0 * half];
    }
    let [near, far] = [from, from + 1].map(|row| {
        let (node, part) = ROW_PLACES[row.min(ROW_PLACES.len() - 1)];
        at[node] + part * (at[node + 1] - at[node])
    });
    [near, far - near, 0.0]
}

/// The contrast of a row whose middle is `away` rows ahead of a line, behind it where that is negative.
pub fn contrast_at(at: &RowContrasts, away: f32) -> f32 {
    let from = away.abs().floor();
    let [start, rise, bend] = contrast_curve(&at[usize::from(away < 0.0)], from as usize);
    let t = away.abs() - from;
    start + t * (rise + t * bend)
}

/// The place of [`CONTRAST_ROWS`] before each whole row, and the part of the way to the next one: contrasts are nearly
/// linear in 1 / (1 + distance). The first row is that of [`contrast_curve`]'s first stretch.
const ROW_PLACES: [(usize, f32); 17] = {
    let mut places = [(2, 0.5); 17];
    let mut row = 2;
    while row < places.len() {
        let mut node = NEAR_ROWS;
        while node + 2 < CONTRAST_ROWS.len() && CONTRAST_ROWS[node + 1] < row as f32 {
            node += 1;
        }
        let (start, end) = (1.0 / (1.0 + CONTRAST_ROWS[node]), 1.0 / (1.0 + CONTRAST_ROWS[node + 1]));
        places[row] = (node, (start - 1.0 / (1.0 + row as f32)) / (start - end));
        row += 1;
    }
    places
};

/// Coherence of a sample's light.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Coherence {
    /// D for paths that differ by 1 mm in matter of index 1 [mm^-1].
    pub per_mm: f32,
    /// Contrast of the patterns that light from below is given [1].
    pub patterns: f32,
}

impl Coherence {
    /// Contrasts of rows of light after such paths in matter of index `n`, of that of the patterns [1].
    pub fn relative(&self, paths: &[PathLaw; CONTRAST_PLACES.len()], n: f32) -> RowContrasts {
        row_contrasts(self.per_mm * n, paths).map(|side| side.map(|contrast| contrast / self.patterns))
    }
}

/// D for paths that differ by 1 mm in matter of index 1, for a wavelength and the full width of its line [mm^-1].
pub fn coherence_per_mm(wavelength_nm: f64, linewidth_nm: f64) -> f64 {
    // A wavelength in mm is 1e-6 of it in nm.
    std::f64::consts::PI * linewidth_nm / (wavelength_nm * wavelength_nm) * 1e6
}

/// Contrast of speckle in light whose paths follow `law`, D growing by `per_mm` with their difference [1].
///
/// Where the paths differ much, C^2 is sqrt(2 pi ln 2) times the integral of the square of D's density; where they
/// differ little, 1. In between (1 + (1 / C^2)^q)^(-1/q) with q = 2 / (1 + 0.55 s^1.63) is within 2 % of the double sum
/// for paths whose logarithm is normal with a deviation s from 0.2 to 1.8. Of light whose paths are of one length C^2
/// is never less than the square of its share.
#[inline(always)]
pub fn path_contrast(per_mm: f32, law: &PathLaw) -> f32 {
    // sqrt(2 pi ln 2).
    let rest = (1.0 - law.equal).max(1e-6);
    let wide = 2.086_934 * law.crowding / (rest * per_mm.max(1e-9));
    let q = 2.0 / (1.0 + 0.55 * exp(1.63 * ln(law.deviation.max(0.05))));
    let power = exp((-q * ln(wide.max(1e-30))).clamp(-80.0, 80.0));
    (law.equal + rest * exp(-1.0 / q * ln(1.0 + power))).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::scan_line::surface_point;
    use base::{Gloss, Medium};
    use glam::Vec3;
    use rand::RngExt;
    use transport::kernel::path_laws;

    /// Paths whose logarithm is normal: the closed form against the double sum over dense quantiles, over all that
    /// paths and lasers may be.
    #[test]
    fn closed_form_is_the_double_sum() {
        let mut rng = base::Stream::root(6).child("paths").rng();
        let mut draw = |low: f64, high: f64| low * (high / low).powf(rng.random::<f64>());
        for _ in 0..60 {
            let (median, deviation, per_mm) = (draw(0.05, 20.0), draw(0.2, 1.8), draw(0.05, 20.0));
            let steps = 4001;
            // Even in the logarithm, five deviations to either side.
            let point = |i: usize| -5.0 + 10.0 * i as f64 / (steps - 1) as f64;
            let weights: Vec<f64> = (0..steps).map(|i| libm::exp(-0.5 * point(i).powi(2))).collect();
            let paths: Vec<f64> = (0..steps).map(|i| per_mm * median * libm::exp(deviation * point(i))).collect();
            let total: f64 = weights.iter().sum();
            let mut sum = 0.0;
            for i in 0..steps {
                // Paths beyond six units of D are as good as incoherent.
                for j in (0..i).rev().take_while(|&j| paths[i] - paths[j] < 6.0) {
                    let d = paths[i] - paths[j];
                    sum += 2.0 * weights[i] * weights[j] * libm::exp(-d * d / (2.0 * std::f64::consts::LN_2));
                }
                // What lies within the point's own step.
                let step = if i + 1 < steps { paths[i + 1] - paths[i] } else { paths[i] - paths[i - 1] };
                let own = (1.0 + step * step / (6.0 * std::f64::consts::LN_2)).sqrt().recip();
                sum += weights[i] * weights[i] * own;
            }
            let expected = sum.sqrt() / total;
            let crowding =
                libm::exp(0.25 * deviation * deviation) / (2.0 * deviation * std::f64::consts::PI.sqrt() * median);
            let law = PathLaw { crowding: crowding as f32, deviation: deviation as f32, equal: 0.0, light: 1.0 };
            let got = f64::from(path_contrast(per_mm as f32, &law));
            assert!((got / expected - 1.0).abs() < 0.02, "{median} {deviation} {per_mm}: {got} for {expected}");
        }
    }

    /// Light of which a part has paths of one length: the closed form against the double sum, where the rest's lie far
    /// from these and several coherence lengths from each other.
    #[test]
    fn equal_paths_keep_their_contrast() {
        let mut rng = base::Stream::root(7).child("equal").rng();
        for _ in 0..60 {
            let (share, deviation) = (rng.random_range(0.1..0.9f64), rng.random_range(0.3..1.0f64));
            let (median, per_mm) = (2.0, libm::exp(rng.random_range(1.0..4.0f64)));
            let steps = 3001;
            let z = |i: usize| -5.0 + 10.0 * i as f64 / (steps - 1) as f64;
            let weights: Vec<f64> = (0..steps).map(|i| libm::exp(-0.5 * z(i) * z(i))).collect();
            let total: f64 = weights.iter().sum();
            let paths: Vec<f64> = (0..steps).map(|i| median * libm::exp(deviation * z(i))).collect();
            let near = |d: f64| libm::exp(-d * d / (2.0 * std::f64::consts::LN_2));
            // Far from all of the rest's paths.
            let pairs: f64 = (0..steps)
                .flat_map(|i| (0..steps).map(move |j| (i, j)))
                .filter(|&(i, j)| per_mm * (paths[i] - paths[j]).abs() < 6.0)
                .map(|(i, j)| weights[i] * weights[j] * near(per_mm * (paths[i] - paths[j])))
                .sum();
            let rest = 1.0 - share;
            let expected = (share * share + rest * rest * pairs / (total * total)).sqrt();
            let crowding =
                libm::exp(0.25 * deviation * deviation) / (2.0 * deviation * std::f64::consts::PI.sqrt() * median);
            let law = PathLaw {
                crowding: (rest * rest * crowding) as f32,
                deviation: deviation as f32,
                equal: (share * share) as f32,
                light: 1.0,
            };
            let got = f64::from(path_contrast(per_mm as f32, &law));
            assert!((got / expected - 1.0).abs() < 0.01, "{share} {deviation} {per_mm}: {got} for {expected}");
        }
    }

    /// Whatever matter a recipe may have, the contrast is a number above 0 and at most 1, also where no light comes
    /// back.
    #[test]
    fn all_matter_has_a_contrast() {
        let mut rng = base::Stream::root(5).child("matter").rng();
        let mut draw = |low: f64, high: f64| low * (high / low).powf(rng.random::<f64>());
        for _ in 0..200 {
            let (mu_a, sigma_i, k) = (draw(1e-4, 1e3), draw(0.01, 200.0), draw(1e-3, 200.0));
            let (n, width) = (draw(1.0, 2.0), draw(1e-4, 10.0));
            let medium =
                Medium { k: k as f32, ..Medium::isotropic(mu_a as f32, sigma_i as f32, n as f32, Gloss::NONE) };
            let view = Vec3::new(0.0, -0.42, 0.91).normalize();
            let point = surface_point(&medium, Vec3::Z, Vec3::NEG_Z, view);
            for law in path_laws(&point, 0.003, [0.0, 0.3, 3.0]) {
                let contrast = path_contrast(coherence_per_mm(660.0, width) as f32 * medium.n_eff, &law);
                assert!(contrast > 0.0 && contrast <= 1.0 + 1e-6, "{mu_a} {sigma_i} {k} {n} {width}: {contrast}");
            }
        }
    }
}
