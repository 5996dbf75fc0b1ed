//! Clear film sealed to foil: what foil throws back at once, and what total reflection holds in the film.

use super::film::{FilmStack, PIGMENT_G};
use crate::fresnel::{ENTERS_FROM_ALL_SIDES, normal_reflectance};

/// What foil throws back at once through clear film that is sealed to it.
#[derive(Debug, Clone, Copy)]
pub(super) struct SealedGlint {
    /// Leaves the film the first time that it meets its upper side [1].
    pub first: f32,
    /// Median slope of the facets that throw it there, as wide as across the line [1].
    pub slope: f32,
    /// Of the rest, which total reflection holds in the film, what foil throws back into it each time [1].
    pub again: f32,
}

/// Of the share `mirrored` that foil mirrors out of film sealed to it, which lets `left` through one way: facets up to
/// the slope whose light still leaves, tan(c / 2) at the critical angle c, of GGX's law s^2 / (alpha^2 + s^2); with
/// what these throw at each other.
#[inline(always)]
pub(super) fn sealed_glint(stack: &FilmStack, left: f32, mirrored: f32) -> SealedGlint {
    let (gloss, n) = (&stack.film.under.gloss, stack.medium.n_eff);
    let [along, across] = gloss.roughness;
    let alpha2 = along * across;
    let widest = n * (1.0 - (1.0 - 1.0 / (n * n)).sqrt());
    let share = widest * widest / (widest * widest + alpha2);
    let out = gloss.reflectance * left * left * (1.0 - normal_reflectance(n));
    let extinction = stack.film.thickness_mm * (stack.medium.sigma_i / (1.0 - PIGMENT_G) + stack.medium.mu_a);
    let stays = 1.0 - ENTERS_FROM_ALL_SIDES / (n * n);
    SealedGlint {
        first: (out * share * (1.0 + alpha2)).min(mirrored),
        slope: across * (share / (2.0 - share)).sqrt(),
        again: gloss.reflectance * stays * numerics::lanes::exp(-HOP * extinction),
    }
}

/// How far light that is held between foil and the film's upper side comes along the film from foil to foil, as by
/// Lambert's law from this height, and how long its way is, over the film's thickness [1]. Light beyond the critical
/// angle goes 1.7 thicknesses and more.
pub(super) const HOP: f32 = 3.4;

#[cfg(test)]
mod tests {
    use base::{Film, Gloss, Medium, Stream};
    use glam::Vec3;
    use rand::RngExt;

    use super::*;

    /// Facets drawn by GGX's law under a film, lit straight from above: as many throw light out of the film as are
    /// told, and half of those lean by less than the median.
    #[test]
    fn steep_facets_keep_light_in_the_film() {
        let mut rng = Stream::root(52).rng();
        for _ in 0..20 {
            let (alpha, n) = (libm::expf(rng.random_range(-3.5..0.0f32)), rng.random_range(1.4..1.6f32));
            let medium = Medium::isotropic(0.0, 0.0, n, Gloss::NONE);
            let under = Medium::opaque(Gloss { share: 1.0, reflectance: 1.0, roughness: [alpha; 2], matte: 0.0 });
            let film =
                Film { thickness_mm: 0.2, gap_mm: None, room_mm: [f32::INFINITY; 2], under, under_slope: [0.0; 2] };
            let stack = FilmStack {
                medium,
                film,
                enter: 0.96,
                view_up: 1.0,
                light_up: 1.0,
                view: Vec3::Z,
                light: Vec3::Z,
                normal: Vec3::Z,
            };
            let glint = sealed_glint(&stack, 1.0, 10.0);
            let told = glint.first / ((1.0 - normal_reflectance(n)) * (1.0 + alpha * alpha));
            let facets = 100_000;
            let slopes = (0..facets).map(|_| rng.random::<f32>()).map(|part| alpha * (part / (1.0 - part)).sqrt());
            let turned = |slope: f32| 2.0 * libm::atanf(slope);
            let out: Vec<f32> = slopes.filter(|&slope| turned(slope).cos() > (1.0 - 1.0 / (n * n)).sqrt()).collect();
            let share = out.len() as f32 / facets as f32;
            let error = (share * (1.0 - share) / facets as f32).sqrt();
            assert!((share - told).abs() < 4.0 * error + 1e-5, "roughness {alpha}, index {n}: {told} for {share}");
            let below = out.iter().filter(|&&slope| slope < glint.slope).count() as f32 / out.len() as f32;
            assert!((below - 0.5).abs() < 4.0 * 0.5 / (out.len() as f32).sqrt(), "roughness {alpha}: {below} below");
        }
    }
}
