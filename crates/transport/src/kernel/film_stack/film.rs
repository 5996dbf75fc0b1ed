//! A film over something, as light meets it: its geometry, ways in it, and what passes it unturned.

use base::{Film, Medium};
use glam::Vec3;

use crate::fresnel::fresnel_dielectric;
use crate::stack;

/// A film over something, as light from straight above meets it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FilmStack {
    /// The film's own matter.
    pub medium: Medium,
    /// Its thickness and what lies below.
    pub film: Film,
    /// Share of light that enters the film [1].
    pub enter: f32,
    /// Cosine of the view against the film's normal [1].
    pub view_up: f32,
    /// Cosine of the laser's light against it [1].
    pub light_up: f32,
    /// Unit vector to the lens; x along the line, y along the motion, z up.
    pub view: Vec3,
    /// Unit vector to the laser.
    pub light: Vec3,
    /// Unit normal of the film.
    pub normal: Vec3,
}

impl FilmStack {
    /// How far along the motion light that pigment turns on its way down, and that foil below mirrors, leaves the film
    /// beside where it met it: twice through the air below the film and, from half of its thickness on, as far through
    /// the film [mm].
    pub fn mirrored_beside(&self) -> f32 {
        mirrored_depth_mm(&self.medium, &self.film, self.view) * self.view.y / self.view.z
    }

    /// How far along the motion light from below that the film does not turn leaves it beside where it left what lies
    /// below: by the slant of the view in the air, and by that which refraction leaves of it in the film [mm].
    pub fn seen_beside(&self) -> f32 {
        let Film { thickness_mm, gap_mm, .. } = self.film;
        gap_mm.unwrap_or(0.0) * self.view.y / self.view.z + thickness_mm * in_film(self.medium.n_eff, self.view)
    }
}

/// How far below level film foil shows the film's lower side to a lens along `view` [mm].
pub fn mirrored_depth_mm(medium: &Medium, film: &Film, view: Vec3) -> f32 {
    let (_, up) = refracted(medium.n_eff, view.z);
    2.0 * film.gap_mm.unwrap_or(0.0) + 1.5 * film.thickness_mm * view.z / (medium.n_eff * up)
}

/// Slant along the motion inside a level film of index `n` of light that leaves it along `view` [1].
#[inline(always)]
pub(super) fn in_film(n: f32, view: Vec3) -> f32 {
    let (_, up) = refracted(n, view.z);
    view.y / (n * up)
}

/// Share of light from below that passes `film` of `medium` unturned towards a view under cosine `up` [1].
pub fn passed_unturned(medium: &Medium, film: &Film, up: f32) -> f32 {
    let extinction = (medium.sigma_i / (1.0 - PIGMENT_G) + medium.mu_a) * film.thickness_mm;
    seen_through(medium.n_eff, extinction, up)
}

/// Unit vector, downwards, along which light goes that what lies below `film` mirrors to a lens along `view`.
#[inline(always)]
pub fn mirrored_view(film: &Film, view: Vec3) -> Vec3 {
    let up = under_normal(film);
    view - up * (2.0 * view.dot(up))
}

/// Unit normal of what lies below a film.
#[inline(always)]
pub fn under_normal(film: &Film) -> Vec3 {
    Vec3::new(-film.under_slope[0], -film.under_slope[1], 1.0).normalize()
}

/// Standard deviation of a lobe's slopes over the roughness of the facets: these lean by 1 / sqrt(2) of it, and turn
/// light by twice that [1].
pub const FACET_TURN: f32 = std::f32::consts::SQRT_2;

/// Mean cosine of the pigment of films [1].
pub(super) const PIGMENT_G: f32 = stack::PIGMENT_G as f32;

/// Sine and cosine inside a film of index `n` of light that leaves it under cosine `up` [1].
#[inline(always)]
pub(super) fn refracted(n: f32, up: f32) -> (f32, f32) {
    let sin2 = (1.0 - up * up).max(0.0) / (n * n);
    (sin2.sqrt(), (1.0 - sin2).sqrt())
}

/// Share of radiance from below that passes a film unturned towards a lens under cosine `up` [1].
#[inline(always)]
pub(super) fn seen_through(n: f32, extinction: f32, up: f32) -> f32 {
    let (_, inside) = refracted(n, up);
    let left = numerics::lanes::exp(-extinction / inside);
    let thrown = fresnel_dielectric(1.0, n.into(), up.into()).0 as f32;
    (1.0 - thrown) * (1.0 - thrown) * left / (1.0 - thrown * thrown * left * left)
}

/// A direction in air as a level film of index `n` bends it.
#[inline(always)]
pub(super) fn inside(n: f32, way: Vec3) -> Vec3 {
    let flat = Vec3::new(way.x, way.y, 0.0) / n;
    flat + Vec3::Z * (1.0 - flat.length_squared()).max(0.0).sqrt()
}
