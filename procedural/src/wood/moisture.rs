//! Wet places of the face: lumina that are full of water.
//!
//! Model: a patch is an ellipse along the grain with a wandering outline, fullest in its middle. A share s of the
//! lumina is full. Cylinder scattering is that of the lumina: what light is turned by at a wall goes with the square of
//! the step in index (a small angle at each wall). The step from wood's substance (1.55) to water (1.33) is 0.22 where
//! that to air is 0.55:
//!
//! ```text
//! k(s) = k (1 - s (1 - (0.22 / 0.55)^2)) = k (1 - 0.84 s)
//! ```
//!
//! Scattering between the fibres is half that of pores, half that of walls (a guess): sigma_i(s) = sigma_i (1 - 0.42
//! s). The effective index grows by that of water over air times the share of the volume that lumina take, 0.72 at 420
//! kg/m3:
//!
//! ```text
//! n_eff(s) = n_eff + 0.72 * 0.33 s, up to 1.55
//! ```
//!
//! Absorption stays: that of water is 0.0003 /mm at 660 nm (Pope and Fry 1997, *Appl. Opt.* 36, 8710). Sources: that
//! scattering at dry pores dominates in wood and moisture takes it away is Konagaya et al. 2016, *Opt. Express* 24,
//! 9561; the laws above are estimates from indices and have not been measured.
//!
//! A board that is wet all over has that share everywhere, and more in patches that are wetter. A film of water on a
//! share w of its face mirrors as water does, F0 = 0.0201, and hides the facets of the cell walls under it, of the
//! share g. Both are one lobe of the share w + (1 - w) g: its reflectance is their mean by shares, its roughness that
//! by what they reflect, so that it is exact for w = 0 and 1. Limits: no swelling; a patch is as deep as the board; one
//! law for all wood; the film has no thickness and takes no light from what enters.

use base::{Gloss, Stream, lognormal};
use glam::Vec2;
use rand::RngExt;

use super::Wood;
use super::board_face::BoardFace;
use super::coefficients::Coefficients;
use super::decay::LEAST_SIGMA_I;
use crate::noise::{Noise, smoothstep};

/// What full lumina take from scattering by cylinders and between them [1].
const LOSS: [f32; 2] = [0.84, 0.42];
/// What they add to the effective index [1], and its largest value [1].
const INDEX_GAIN: f32 = 0.72 * 0.33;
const LARGEST_INDEX: f32 = 1.55;
/// Reflectance of water at normal incidence, n = 1.33 [1].
const WATER_REFLECTANCE: f32 = 0.020_059_3;
/// Spread of the logarithm of a patch's size [1].
const LOG_SD: f64 = 0.4;
/// Wander of the outline over its size, root mean square [1], and cells of it in a half size [1].
const OUTLINE: [f32; 2] = [0.25, 1.7];
/// Where a patch begins to dry, over its size [1].
const FULL: f32 = 0.3;

#[derive(Debug, Clone, Copy)]
struct MoistPatch {
    centre: Vec2,
    /// Half its size across and along the grain [mm].
    half: Vec2,
    outline: Noise,
}

/// All wet places of a board.
#[derive(Debug, Clone)]
pub(super) struct WetPlaces {
    patches: Vec<MoistPatch>,
    /// Share of the lumina that is full in the middle of a patch [1].
    filled: f32,
    /// The same in the whole board [1].
    everywhere: f32,
    /// Share of the face under a film of water, and its roughness [1].
    film: [f32; 2],
    face: BoardFace,
}

impl WetPlaces {
    /// The wet places that the numbers ask for.
    pub fn grow(stream: Stream, wood: &Wood) -> Self {
        let (asked, face) = (&wood.moisture, BoardFace::of(wood));
        let count = if asked.filled > 0.0 { asked.patch_count.round() as u64 } else { 0 };
        let patches = (0..count).map(|index| {
            let own = stream.index(index);
            let mut rng = own.rng();
            let centre =
                face.middle + face.half * Vec2::new(2.0 * rng.random::<f32>() - 1.0, 2.0 * rng.random::<f32>() - 1.0);
            let long = 2.0 + 2.0 * rng.random::<f32>();
            let across = lognormal(&mut rng, asked.patch_mm, LOG_SD) as f32;
            MoistPatch { centre, half: 0.5 * across * Vec2::new(1.0, long), outline: Noise::new(own.child("outline")) }
        });
        let [filled, everywhere] = [asked.filled, asked.board_filled].map(|share| share as f32);
        let film = [asked.film, asked.film_roughness].map(|share| share as f32);
        Self { patches: patches.collect(), filled, everywhere, film, face }
    }

    /// Share of the lumina that is full at a spot of the face [1]; `None` where it is dry.
    #[inline]
    pub fn at(&self, spot: Vec2) -> Option<f32> {
        let mut most = 0.0f32;
        for patch in &self.patches {
            let q = self.face.in_log(spot - patch.centre) / patch.half;
            if q.length_squared() < 9.0 {
                let edge = (1.0 + OUTLINE[0] * patch.outline.plane(OUTLINE[1] * q).0).max(0.3);
                most = most.max(1.0 - smoothstep(FULL, 1.0, q.length() / edge));
            }
        }
        let filled = (self.filled * most).max(self.everywhere);
        (filled > 0.0).then_some(filled)
    }

    /// What a film of water makes of the gloss of dry wood.
    #[inline]
    pub fn film(&self, dry: Gloss) -> Gloss {
        let [film, rough] = self.film;
        if film == 0.0 {
            return dry;
        }
        let bare = (1.0 - film) * dry.share;
        let share = film + bare;
        let [water, wood] = [film * WATER_REFLECTANCE, bare * dry.reflectance];
        let roughness = dry.roughness.map(|dry| (water * rough + wood * dry) / (water + wood));
        Gloss { share, reflectance: (water + wood) / share, roughness, ..dry }
    }
}

/// Wood with a share of its lumina full of water.
#[inline]
pub(super) fn wetted(dry: Coefficients, filled: f32) -> Coefficients {
    Coefficients {
        mu_a: dry.mu_a,
        sigma_i: (dry.sigma_i * (1.0 - LOSS[1] * filled)).max(LEAST_SIGMA_I),
        k: dry.k * (1.0 - LOSS[0] * filled),
        n_eff: (dry.n_eff + INDEX_GAIN * filled).min(LARGEST_INDEX).max(dry.n_eff),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use base::Parameter;

    fn wet(change: impl Fn(&mut Wood)) -> WetPlaces {
        let mut wood = Wood::from_values(&mut |p: &'static Parameter| p.default);
        change(&mut wood);
        WetPlaces::grow(Stream::root(2), &wood)
    }

    /// A board that is wet all over has its share at every spot, and patches that are wetter show above it.
    #[test]
    fn boards_are_wet_all_over() {
        let spots = || (0..40).flat_map(|i| (0..200).map(move |j| Vec2::new(-45.0 + 2.3 * i as f32, 1.1 * j as f32)));
        assert!(spots().all(|spot| wet(|_| ()).at(spot).is_none()));
        let even = wet(|wood| wood.moisture.board_filled = 0.6);
        assert!(spots().all(|spot| even.at(spot) == Some(0.6)));
        let patched = |base: f64| {
            wet(|wood| {
                let moisture = &mut wood.moisture;
                (moisture.patch_count, moisture.filled, moisture.board_filled) = (4.0, 0.9, base);
            })
        };
        let (dry, damp) = (patched(0.0), patched(0.3));
        assert!(spots().any(|spot| dry.at(spot).is_some_and(|filled| filled > 0.3)));
        assert!(spots().all(|spot| damp.at(spot) == Some(dry.at(spot).unwrap_or(0.0).max(0.3))));
    }

    /// A film over nothing leaves the gloss of dry wood, over all of the face it is water, and between them the lobe
    /// throws back what both do.
    #[test]
    fn films_of_water_shine() {
        let dry = Gloss::wood(0.3);
        let film = |share: f64| wet(|wood| (wood.moisture.film, wood.moisture.film_roughness) = (share, 0.1)).film(dry);
        assert_eq!(film(0.0), dry);
        let all = film(1.0);
        assert!((all.share - 1.0).abs() < 1e-6 && (all.reflectance - (0.33f32 / 2.33).powi(2)).abs() < 1e-6);
        assert!(all.roughness.iter().all(|rough| (rough - 0.1).abs() < 1e-6));
        let half = film(0.5);
        let both = 0.5 * WATER_REFLECTANCE + 0.5 * 0.3 * dry.reflectance;
        assert!((half.share * half.reflectance - both).abs() < 1e-7 && half.roughness[0] < dry.roughness[0]);
    }
}
