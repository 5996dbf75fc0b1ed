//! Light that pigment turns once: single scattering in a slab (Chandrasekhar 1960) between refracting sides, by Henyey
//! and Greenstein's law.
//!
//! It keeps its angle to the lens however the film leans, and leaves from its own depth. What has been turned more
//! often is the table's ([`super::table`]).

use super::film::{FilmStack, PIGMENT_G, mirrored_view, refracted};
use crate::fresnel::{fresnel_dielectric, normal_reflectance};

/// Share of what pigment turns once that leaves the film's other side [1].
const TURNED_AHEAD: f32 = 0.78;

/// Radiance factor towards the lens of light that pigment turns once, over what it would be for light that meets the
/// film straight and leaves it under the same angle, as the table has it [1].
#[inline(always)]
pub(super) fn turned_once_aslant(stack: &FilmStack) -> f32 {
    let FilmStack { light_up, view_up, .. } = *stack;
    let between = stack.light.dot(stack.view);
    turned_once(stack, light_up, between) - turned_once(stack, 1.0, view_up)
}

/// Radiance factor of light that pigment turns once: light of a direction under cosine `light_up` against the film's
/// normal, `between` that and the lens [1]. Single scattering in a slab (Chandrasekhar 1960) between refracting sides,
/// by Henyey and Greenstein's law.
#[inline(always)]
pub(super) fn turned_once(stack: &FilmStack, light_up: f32, between: f32) -> f32 {
    let (medium, view_up, n) = (&stack.medium, stack.view_up, stack.medium.n_eff);
    let scattering = medium.sigma_i / (1.0 - PIGMENT_G);
    let extinction = scattering + medium.mu_a;
    if scattering == 0.0 {
        return 0.0;
    }
    let ((_, down), (_, up)) = (refracted(n, light_up), refracted(n, view_up));
    // Against the light's way inside: both directions keep what they have along the film, divided by the index.
    let back = (between - light_up * view_up) / (n * n) + down * up;
    let base = 1.0 + PIGMENT_G * PIGMENT_G + 2.0 * PIGMENT_G * back;
    let phase = (1.0 - PIGMENT_G * PIGMENT_G) / (base * base.sqrt());
    let left = numerics::lanes::exp(-extinction * stack.film.thickness_mm * (1.0 / down + 1.0 / up));
    let out = (1.0 - fresnel_dielectric(1.0, n.into(), view_up.max(0.0).into()).0 as f32) / (n * n);
    0.25 * scattering / extinction * phase * (1.0 - left) / (down + up) * out
}

/// Mean [mm] and variance [mm^2] of the depth at which pigment turns light that it turns once, back towards the lens:
/// they fall off exponentially down to the film's end.
#[inline(always)]
pub(super) fn turned_depth(stack: &FilmStack) -> [f32; 2] {
    let (medium, n, thickness) = (&stack.medium, stack.medium.n_eff, stack.film.thickness_mm);
    let ((_, down), (_, up)) = (refracted(n, stack.light_up), refracted(n, stack.view_up));
    let extinction = medium.sigma_i / (1.0 - PIGMENT_G) + medium.mu_a;
    let x = extinction * thickness * (1.0 / down + 1.0 / up);
    let [mean, variance] = if x < 0.1 {
        [0.5 - x / 12.0, 1.0 / 12.0]
    } else {
        let left = numerics::lanes::exp(-x.min(80.0));
        let lost = 1.0 - left;
        [1.0 / x - left / lost, 1.0 / (x * x) - left / (lost * lost)]
    };
    [thickness * mean, thickness * thickness * variance]
}

/// Radiance factor towards the lens' mirror image below of light that pigment has turned on its way down, of which the
/// share `all` is [1]: once by single scattering in a slab (Chandrasekhar 1960), more often by Lambert's law.
#[inline(always)]
pub(super) fn turned_down(stack: &FilmStack, all: f32) -> f32 {
    let (medium, n) = (&stack.medium, stack.medium.n_eff);
    let scattering = medium.sigma_i / (1.0 - PIGMENT_G);
    let extinction = scattering + medium.mu_a;
    if scattering == 0.0 {
        return 0.0;
    }
    let mirrored = mirrored_view(&stack.film, stack.view);
    let mirrored_up = -mirrored.dot(stack.normal);
    if mirrored_up <= 0.0 {
        return 0.0;
    }
    let flat = stack.light.dot(mirrored) + stack.light_up * mirrored_up;
    let once = turned_ahead(stack, stack.light_up, mirrored_up, flat);
    let (_, down) = refracted(n, stack.light_up);
    let thick = extinction * stack.film.thickness_mm;
    let once_in_all = TURNED_AHEAD * scattering / extinction * thick * numerics::lanes::exp(-thick / down);
    once + (all - once_in_all).max(0.0)
}

/// Radiance factor under cosine `out_up` of light under cosine `light_up` that pigment turns ahead once, where both
/// have the product `flat` along the film [1].
#[inline(always)]
fn turned_ahead(stack: &FilmStack, light_up: f32, out_up: f32, flat: f32) -> f32 {
    let (medium, n) = (&stack.medium, stack.medium.n_eff);
    let scattering = medium.sigma_i / (1.0 - PIGMENT_G);
    let extinction = scattering + medium.mu_a;
    let ((_, down), (_, leaves)) = (refracted(n, light_up), refracted(n, out_up));
    let ahead = down * leaves - flat / (n * n);
    let base = 1.0 + PIGMENT_G * PIGMENT_G - 2.0 * PIGMENT_G * ahead;
    let phase = (1.0 - PIGMENT_G * PIGMENT_G) / (base * base.sqrt());
    let thick = extinction * stack.film.thickness_mm;
    let (straight, slant) = (numerics::lanes::exp(-thick / down), numerics::lanes::exp(-thick / leaves));
    // Both ways are next to equally long.
    let apart = down - leaves;
    let left = if apart.abs() < 1e-3 { straight * thick / (down * down) } else { (straight - slant) / apart };
    let out = (1.0 - fresnel_dielectric(1.0, n.into(), out_up.into()).0 as f32) / (n * n);
    0.25 * scattering / extinction * phase * left * out
}

/// Radiance factor under cosine `view_up`, of light from straight above, of what pigment turns once and leaves where it
/// came in: turned back; or turned ahead, and mirrored by the film's other side before or after [1].
#[inline(always)]
pub(super) fn turned_once_level(stack: &FilmStack, view_up: f32) -> f32 {
    let stack = FilmStack { view_up, ..*stack };
    if stack.medium.sigma_i == 0.0 {
        return 0.0;
    }
    let n = stack.medium.n_eff;
    let thick = stack.film.thickness_mm * (stack.medium.sigma_i / (1.0 - PIGMENT_G) + stack.medium.mu_a);
    let (_, up) = refracted(n, view_up);
    // The other way through is straight.
    let before = normal_reflectance(n) * numerics::lanes::exp(-thick);
    let after = fresnel_dielectric(1.0, n.into(), view_up.into()).0 as f32 * numerics::lanes::exp(-thick / up);
    turned_once(&stack, 1.0, view_up) + (before + after) * turned_ahead(&stack, 1.0, view_up, 0.0)
}

/// Nodes and weights of Gauss's rule for the square of a sine between 0 and 1 [1].
const SQUARES: [[f32; 2]; 4] =
    [[0.069_432, 0.173_927], [0.330_009, 0.326_073], [0.669_991, 0.326_073], [0.930_568, 0.173_927]];

/// Share of that light towards all sides [1].
#[inline(always)]
pub(super) fn turned_once_in_all(stack: &FilmStack) -> f32 {
    SQUARES.map(|[square, weight]| weight * turned_once_level(stack, (1.0 - square).sqrt())).into_iter().sum()
}

#[cfg(test)]
mod tests {
    use base::{Film, Gloss, Medium, Stream};
    use glam::Vec3;
    use rand::RngExt;

    use super::*;

    /// Light that thin film turns once leaves where it came in as often as photons do that are walked through it:
    /// straight down, turned once before or after the lower side mirrors it by Fresnel's law, and out; over films that
    /// turn up to a third of the light.
    #[test]
    fn light_turned_once_leaves_as_often_as_photons_do() {
        let mut rng = Stream::root(54).rng();
        for _ in 0..12 {
            let n = rng.random_range(1.42..1.55f32);
            let (turns, thickness_mm) = (rng.random_range(0.02..0.15f32), rng.random_range(0.1..0.4f32));
            let medium = Medium::isotropic(0.0, turns / thickness_mm, n, Gloss::NONE);
            let under = Medium::opaque(Gloss::NONE);
            let film =
                Film { thickness_mm, gap_mm: Some(1.0), room_mm: [f32::INFINITY; 2], under, under_slope: [0.0; 2] };
            let up = Vec3::Z;
            let stack =
                FilmStack { medium, film, enter: 1.0, view_up: 1.0, light_up: 1.0, view: up, light: up, normal: up };
            let thick = f64::from(turns / (1.0 - PIGMENT_G));
            let mirrors = |cos: f64| fresnel_dielectric(f64::from(n), 1.0, cos).0;
            let photons = 400_000;
            let mut out = 0.0;
            for _ in 0..photons {
                // Weighted: what is turned before the lower side, or after it was mirrored there.
                let (g, part) = (f64::from(PIGMENT_G), rng.random::<f64>());
                let ahead = 1.0 + g * g - ((1.0 - g * g) / (1.0 - g + 2.0 * g * part)).powi(2);
                let cos = (ahead / (2.0 * g)).clamp(-1.0, 1.0);
                let depth = rng.random::<f64>() * thick;
                for (upwards, share) in
                    [(-1.0, libm::exp(-depth)), (1.0, mirrors(1.0) * libm::exp(-2.0 * thick + depth))]
                {
                    let rises = upwards * cos;
                    let (steep, left) = (rises.abs().max(1e-6), thick * share);
                    let out_above = 1.0 - mirrors(steep);
                    out += left
                        * match rises > 0.0 {
                            true => libm::exp(-depth / steep) * out_above,
                            false => libm::exp(-(2.0 * thick - depth) / steep) * mirrors(steep) * out_above,
                        };
                }
            }
            let (told, counted) = (f64::from(turned_once_in_all(&stack)), out / f64::from(photons));
            // Left out: turned back and mirrored on either way, and mirrored more often.
            assert!((told / counted - 1.0).abs() < 0.06, "turns {turns}: {told} for {counted}");
        }
    }

    /// Depths of single scattering against sums over thin sheets, films and directions drawn over all that recipes
    /// accept.
    #[test]
    fn depths_of_light_turned_once_are_those_of_thin_sheets() {
        let mut rng = Stream::root(51).rng();
        let mut draw = |from: f32, to: f32| from + (to - from) * rng.random::<f32>();
        for _ in 0..200 {
            let sigma = libm::expf(draw(libm::logf(0.01), libm::logf(200.0)));
            let mu_a = libm::expf(draw(libm::logf(5e-4), libm::logf(10.0)));
            let (thickness_mm, tilt) = (draw(0.05, 1.0), draw(0.1, 0.8));
            let medium = Medium::isotropic(mu_a, sigma, draw(1.4, 1.55), Gloss::NONE);
            let film = Film {
                thickness_mm,
                gap_mm: Some(1.0),
                room_mm: [f32::INFINITY; 2],
                under: Medium::opaque(Gloss::NONE),
                under_slope: [0.0; 2],
            };
            let view = Vec3::new(0.0, -libm::sinf(tilt), libm::cosf(tilt));
            let light_up = draw(0.6, 1.0);
            let light = Vec3::new(0.0, (1.0 - light_up * light_up).sqrt(), light_up);
            let stack =
                FilmStack { medium, film, enter: 0.95, view_up: view.z, light_up, view, light, normal: Vec3::Z };
            let inside = |up: f32| f64::from((1.0 - (1.0 - up * up) / (medium.n_eff * medium.n_eff)).sqrt());
            let lost = f64::from(sigma / (1.0 - PIGMENT_G) + mu_a) * (1.0 / inside(light_up) + 1.0 / inside(view.z));
            // Even in what is lost, so that thick films have sheets where their light is.
            let sheets = 20_000;
            let all = 1.0 - libm::exp(-lost * f64::from(thickness_mm));
            let depth = |i: i32| -libm::log1p(-all * (f64::from(i) + 0.5) / f64::from(sheets)) / lost;
            let mean = (0..sheets).map(depth).sum::<f64>() / f64::from(sheets);
            let variance = (0..sheets).map(|i| (depth(i) - mean).powi(2)).sum::<f64>() / f64::from(sheets);
            let [got, spread] = turned_depth(&stack).map(f64::from);
            assert!((got / mean - 1.0).abs() < 0.002, "{sigma} {mu_a} {thickness_mm}: {got} for {mean}");
            assert!((spread / variance - 1.0).abs() < 0.01, "{sigma} {mu_a} {thickness_mm}: {spread} for {variance}");
            assert!(super::super::film_beside(&stack).iter().all(|beside| beside.is_finite() && *beside <= 0.0));
        }
    }
}
