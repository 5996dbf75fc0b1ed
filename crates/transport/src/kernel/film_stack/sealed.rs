//! Clear film sealed to foil: what foil throws back at once, and what total reflection holds in the film.

use super::film::{FilmStack, PIGMENT_G};
use crate::fresnel::{ENTERS_FROM_ALL_SIDES, normal_reflectance};

/// How foil mirrors light in a clear film that is sealed to it.
#[derive(Debug, Clone, Copy)]
pub(super) struct SealedMirror {
    /// Share of what foil throws back first that leaves through the film's upper side [1].
    leaves: f32,
    /// Median slope along the motion of the facets that throw it there [1].
    pub slope: f32,
    /// Share of the rest that total reflection sends down to the foil again, and share of that which is left after the
    /// way there [1].
    stays: f32,
    left: f32,
}

impl SealedMirror {
    /// Facets up to the slope w whose light still leaves, tan(c / 2) at the critical angle c, of GGX's law: the share
    /// w^2 / (r^2 + w^2) in a direction in which roughness is r, in the mean over all directions
    /// w^2 / sqrt((a^2 + w^2) (b^2 + w^2)) for roughnesses a and b.
    #[inline(always)]
    pub fn of(stack: &FilmStack) -> Self {
        let n = stack.medium.n_eff;
        let widest = n * (1.0 - (1.0 - 1.0 / (n * n)).sqrt());
        let within = |alpha: f32| widest * widest / (widest * widest + alpha * alpha);
        let [along, across] = stack.film.under.gloss.roughness.map(within);
        let extinction = stack.film.thickness_mm * (stack.medium.sigma_i / (1.0 - PIGMENT_G) + stack.medium.mu_a);
        Self {
            leaves: (along * across).sqrt(),
            slope: stack.film.under.gloss.roughness[1] * (across / (2.0 - across)).sqrt(),
            stays: 1.0 - ENTERS_FROM_ALL_SIDES / (n * n),
            left: numerics::lanes::exp(-HOP * extinction),
        }
    }

    /// What leaves sooner or later where foil has the reflectance `met`, of what reaches it first [1].
    #[inline(always)]
    pub fn out(&self, met: f32) -> f32 {
        let later = (1.0 - self.leaves) * self.left * met * (1.0 - self.stays);
        met * (self.leaves + later / (1.0 - met * self.stays * self.left))
    }
}

/// What foil throws back at once through clear film that is sealed to it.
#[derive(Debug, Clone, Copy)]
pub(super) struct SealedGlint {
    /// Leaves the film the first time that it meets its upper side [1].
    pub first: f32,
    /// Of the rest, which total reflection holds in the film, what foil throws back into it each time [1].
    pub again: f32,
}

/// Of the share `mirrored` that foil mirrors out of film sealed to it, which lets `left` through one way; with what
/// facets throw at each other.
#[inline(always)]
pub(super) fn sealed_glint(stack: &FilmStack, mirror: &SealedMirror, left: f32, mirrored: f32) -> SealedGlint {
    let gloss = &stack.film.under.gloss;
    let [along, across] = gloss.roughness;
    let out = gloss.reflectance * left * left * (1.0 - normal_reflectance(stack.medium.n_eff));
    SealedGlint {
        first: (out * mirror.leaves * (1.0 + along * across)).min(mirrored),
        again: gloss.reflectance * mirror.stays * mirror.left,
    }
}

/// How far light that is held between foil and the film's upper side comes along the film from foil to foil, as by
/// Lambert's law from this height, and how long its way is, over the film's thickness [1]. Light beyond the critical
/// angle goes 1.7 thicknesses and more.
pub(super) const HOP: f32 = 3.4;

/// Most that unlike roughness sends to the lens of what total reflection has held, over what even roughness does [1].
pub(super) const MOST_ASIDE: f32 = 3.0;

/// How far light goes across the line from foil to foil, by the slopes of its facets, over how far it goes where these
/// lean alike in all directions [1].
#[inline(always)]
pub(super) fn across_share([along, across]: [f32; 2]) -> f32 {
    across / (0.5 * (along * along + across * across)).sqrt().max(f32::MIN_POSITIVE)
}

#[cfg(test)]
mod tests {
    use base::{Film, Gloss, Medium, Stream};
    use glam::Vec3;
    use rand::RngExt;

    use super::*;

    /// Facets drawn by GGX's law under a film, lit straight from above: as many throw light out of the film as are
    /// told, and where roughness is even half of those lean by less than the median.
    #[test]
    fn steep_facets_keep_light_in_the_film() {
        let mut rng = Stream::root(52).rng();
        for case in 0..40 {
            let mut alpha = || libm::expf(rng.random_range(-3.5..0.0f32));
            let roughness = if case % 2 == 0 { [alpha(); 2] } else { [alpha(), alpha()] };
            let n = rng.random_range(1.4..1.6f32);
            let medium = Medium::isotropic(0.0, 0.0, n, Gloss::NONE);
            let under = Medium::opaque(Gloss { share: 1.0, reflectance: 1.0, roughness, matte: 0.0 });
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
            let mirror = SealedMirror::of(&stack);
            let glint = sealed_glint(&stack, &mirror, 1.0, 10.0);
            let told = glint.first / ((1.0 - normal_reflectance(n)) * (1.0 + roughness[0] * roughness[1]));
            let facets = 100_000;
            let mut slope = || {
                let (part, turn) = (rng.random::<f32>(), std::f32::consts::TAU * rng.random::<f32>());
                (part / (1.0 - part)).sqrt() * (roughness[0] * turn.cos()).hypot(roughness[1] * turn.sin())
            };
            let slopes: Vec<f32> = (0..facets).map(|_| slope()).collect();
            let turned = |slope: f32| 2.0 * libm::atanf(slope);
            let leaves = |slope: &f32| turned(*slope).cos() > (1.0 - 1.0 / (n * n)).sqrt();
            let out: Vec<f32> = slopes.into_iter().filter(leaves).collect();
            let share = out.len() as f32 / facets as f32;
            let error = (share * (1.0 - share) / facets as f32).sqrt();
            assert!((share - told).abs() < 4.0 * error + 1e-5, "roughness {roughness:?}, {n}: {told} for {share}");
            let below = out.iter().filter(|&&slope| slope < mirror.slope).count() as f32 / out.len() as f32;
            let error = 0.5 / (out.len() as f32).sqrt();
            assert!(case % 2 == 1 || (below - 0.5).abs() < 4.0 * error, "roughness {roughness:?}: {below} below");
        }
    }
}
