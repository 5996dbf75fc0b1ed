//! What a place of film and what lies below it do to light, wherever that goes: shares of what arrives, for radiosity
//! in pockets.

use base::{Film, Medium};
use numerics::lanes::exp;

use super::FilmStackKernel;
use super::film::PIGMENT_G;
use crate::fresnel::normal_reflectance;

/// Shares of light that film, and what lies below it, throw back and let through [1].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FilmShares {
    /// Straight light that entered the film and leaves it downwards, turned.
    pub turned_down: f32,
    /// The same, not turned.
    pub straight_down: f32,
    /// Straight light from below that the film throws down again, turned.
    pub straight_held: f32,
    /// Straight light from below that leaves the film upwards, turned.
    pub straight_out: f32,
    /// Light from all sides below that the film throws down again.
    pub held: f32,
    /// Light from all sides below that leaves the film upwards, turned.
    pub out: f32,
    /// Light from all sides that what lies below throws up again.
    pub below: f32,
    /// Straight light that it does.
    pub straight_below: f32,
    /// Light from all sides that entered what lies below, and leaves it again; of foil, what it mirrors.
    pub seen_below: f32,
}

impl FilmStackKernel {
    /// Shares of light at a place of `film` of this medium; both sides of the film meet air.
    pub fn shares(&mut self, medium: &Medium, film: &Film) -> FilmShares {
        self.tables.remember(medium, &film.under);
        let (turns, absorbed) = (medium.sigma_i * film.thickness_mm, medium.mu_a * film.thickness_mm);
        let of = self.tables.films.at(turns, absorbed);
        let fresnel = normal_reflectance(medium.n_eff);
        let left = exp(-(turns / (1.0 - PIGMENT_G) + absorbed));
        let inner = 1.0 / (1.0 - fresnel * fresnel * left * left);
        let [mirrors, mirrors_straight] = self.tables.under.mirrors;
        let body = self.tables.under.body[0];
        let [back, on, held, out] = [of.back, of.on, of.diffuse_back, of.diffuse_on].map(|part| part.lowest());
        FilmShares {
            turned_down: on,
            straight_down: (1.0 - fresnel) * left * inner,
            straight_held: (1.0 - fresnel) * back,
            straight_out: (1.0 - fresnel) * on,
            held,
            out,
            below: mirrors + (1.0 - mirrors) * body,
            straight_below: mirrors_straight + (1.0 - mirrors_straight) * body,
            seen_below: if film.under.gloss.is_metal() { mirrors } else { (1.0 - mirrors) * body },
        }
    }
}

#[cfg(test)]
mod tests {
    use base::{Gloss, Stream};
    use rand::RngExt;

    use super::*;

    /// Nothing comes out of nothing: of what arrives at random films, no more leaves on both sides together, and all of
    /// it where nothing absorbs.
    #[test]
    fn shares_add_up() {
        let mut rng = Stream::root(61).rng();
        let mut kernel = FilmStackKernel::new();
        for round in 0..300 {
            let mu_a = if round % 2 == 0 { 0.0 } else { rng.random_range(0.0..3.0f32) };
            let sigma = exp(rng.random_range(-3.0..5.0f32));
            let medium = Medium::isotropic(mu_a, sigma, rng.random_range(1.42..1.62), Gloss::NONE);
            let foil = Gloss { share: 1.0, reflectance: rng.random_range(0.5..0.95), roughness: [0.2; 2], matte: 0.0 };
            let film = Film {
                thickness_mm: rng.random_range(0.1..0.6),
                gap_mm: Some(1.0),
                room_mm: [3.0; 2],
                under: Medium::opaque(foil),
                under_slope: [0.0; 2],
            };
            let of = kernel.shares(&medium, &film);
            let fresnel = normal_reflectance(medium.n_eff);
            let left = exp(-film.thickness_mm * (sigma / (1.0 - PIGMENT_G) + mu_a));
            let straight_back = (1.0 - fresnel) * fresnel * left * left / (1.0 - fresnel * fresnel * left * left);
            let straight = of.turned_down + of.straight_down + straight_back + of.straight_held / (1.0 - fresnel);
            let diffuse = of.held
                + of.out
                + kernel.tables.films.at(sigma * film.thickness_mm, mu_a * film.thickness_mm).diffuse_straight;
            for all in [straight, diffuse] {
                assert!(all < 1.02 && (mu_a > 0.0 || all > 0.97), "{all} of {medium:?}, {} mm", film.thickness_mm);
            }
            assert!((of.below - foil.reflectance).abs() < 1e-6 && of.straight_below == of.below);
        }
    }
}
