//! Clear film sealed to foil: what foil throws back at once, and what total reflection holds in the film.

use super::film::{FilmStack, PIGMENT_G};
use super::spectrum::{LambertTransfer, Spectrum};
use crate::fresnel::{ENTERS_FROM_ALL_SIDES, normal_reflectance};

/// How foil mirrors light in a clear film that is sealed to it.
#[derive(Debug, Clone, Copy)]
pub(super) struct SealedMirror {
    /// Share of what foil throws back first that leaves through the film's upper side [1].
    leaves: f32,
    /// How far beside the line that does [`lobe`].
    lobe: f32,
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
            lobe: lobe(stack.film.under.gloss.roughness, widest),
            stays: 1.0 - ENTERS_FROM_ALL_SIDES / (n * n),
            left: numerics::lanes::exp(-HOP * extinction),
        }
    }

    /// Spread of what leaves the first time, through a film of `thickness` and index `n`: as by Lambert's law near the
    /// line, and hardly beyond where total reflection begins.
    #[inline(always)]
    pub fn spread(&self, thickness: f32, n: f32, lambert: &LambertTransfer) -> Spectrum {
        let (near, far) = (thickness * self.lobe, thickness / (n * n - 1.0).sqrt());
        // Both fall with the cube of the distance, and cancel far from the line.
        let beyond = near * near / (far * far);
        let [inner, outer] = [near, far].map(|height| lambert.over(height));
        std::array::from_fn(|i| (inner[i] - beyond * outer[i]) / (1.0 - beyond))
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

/// Height over which Lambert light spreads along the motion as light from straight above does that foil throws up, over
/// the way from there: of roughness along the line and along the motion, by facets that lean less than `widest`.
///
/// Facets of slopes s along the line and t along the motion throw it 2 t / (1 - s^2 - t^2) of that way aside. By GGX's
/// law the line's middle is as bright as that of Lambert light from the height that this is [1].
pub(super) fn lobe([along, across]: [f32; 2], widest: f32) -> f32 {
    let (line, square) = (widest / along.max(1e-3), widest * widest);
    let (angle, part) = (libm::atanf(line), line / (1.0 + line * line));
    let thrown = square / ((square + along * along) * (square + across * across)).sqrt();
    std::f32::consts::PI * across * thrown / (angle + part - along * along * (angle - part))
}

/// How far light that is held between foil and the film's upper side comes along the film from foil to foil, as by
/// Lambert's law from this height, and how long its way is, over the film's thickness [1]. Light beyond the critical
/// angle goes 1.7 thicknesses and more.
pub(super) const HOP: f32 = 3.4;

/// Part that foil's roughness across the line has in how far light goes there, the rest being that along it [1]. This
/// and the root in [`across_share`] suited draws of four seeds of tests/reference/accepted.rs best, 101 among them, and
/// those of `drawn_packs` and `unlike_foil`.
const SPREADS_ACROSS: f32 = 0.8;

/// Roughness of foil alike in all directions that spreads what pigment turns as far across the line [1].
#[inline(always)]
pub(super) fn spreading([along, across]: [f32; 2]) -> f32 {
    along + SPREADS_ACROSS * (across - along)
}

/// Most that unlike roughness sends to the lens of what total reflection has held, over what even roughness does [1].
pub(super) const MOST_ASIDE: f32 = 3.0;

/// How far light goes across the line from foil to foil, over how far it goes where facets lean alike in all
/// directions: by the root of these slopes' ratio, since it takes other ways from hop to hop [1].
#[inline(always)]
pub(super) fn across_share([along, across]: [f32; 2]) -> f32 {
    (across / (0.5 * (along * along + across * across)).sqrt().max(f32::MIN_POSITIVE)).sqrt()
}

#[cfg(test)]
mod tests {
    use base::{Film, Gloss, Medium, Stream};
    use glam::Vec3;
    use rand::RngExt;

    use super::*;

    /// Facets drawn by GGX's law under a film, lit straight from above: as many throw light out of the film as are
    /// told, and it is as bright there close to the line.
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
            let mut slopes = || {
                let (part, turn) = (rng.random::<f32>(), std::f32::consts::TAU * rng.random::<f32>());
                let steep = (part / (1.0 - part)).sqrt();
                [steep * roughness[0] * turn.cos(), steep * roughness[1] * turn.sin()]
            };
            let leaves = |[s, t]: &[f32; 2]| (2.0 * libm::atanf(s.hypot(*t))).cos() > (1.0 - 1.0 / (n * n)).sqrt();
            let out: Vec<[f32; 2]> = (0..facets).map(|_| slopes()).filter(leaves).collect();
            let share = out.len() as f32 / facets as f32;
            let error = (share * (1.0 - share) / facets as f32).sqrt();
            assert!((share - told).abs() < 4.0 * error + 1e-5, "roughness {roughness:?}, {n}: {told} for {share}");
            // Of what leaves, as much lies close to the line as of Lambert light from the lobe's height.
            let is_near = |[s, t]: &&[f32; 2]| (2.0 * t / (1.0 - s * s - t * t)).abs() < 0.1 * mirror.lobe;
            let near = out.iter().filter(is_near).count() as f32 / out.len() as f32;
            let (told, error) = (0.1f32 / 1.01f32.sqrt(), 0.3 / (out.len() as f32).sqrt());
            assert!((near - told).abs() < 4.0 * error, "roughness {roughness:?}: {near} near, {told} told");
        }
    }
}
