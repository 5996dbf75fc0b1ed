//! One photon's way through a body, and what each of its collisions sends to the lens.
//!
//! Free paths are drawn cell by cell: the optical depth of a path is drawn once and used up by the extinction of each
//! cell passed, mu_a + sigma_i + k. This is delta tracking (Woodcock 1965) with a majorant of each cell's own, which the
//! cell's matter cannot exceed; what is null is only the cylinder that shows less than its whole width.
//!
//! At surfaces Fresnel's law with the local index decides by chance. Light outside goes straight on; where it meets the
//! body again, across a crack for one, Fresnel's law decides again. So cracks need no rule of their own.
//!
//! Towards the lens each collision gives its share as in plane layers, times exp(-depth) along the straight way up, with
//! the mean extinction over fibre directions in each cell. The way inside is the view refracted at the surface's normal,
//! averaged over a mm: finer relief would only blur it. Radiance towards the lens goes with 1 / facing, facing the cosine
//! between view and normal, as in plane layers; so the factor of a collision is pi T / (n^2 cos), with the cosine of the
//! way inside, and a white Lambertian surface returns what entered however it is tilted. Where the way ends on a wall, or
//! the body stands between that place and the lens, the lens sees nothing. Which ways are followed is left to chance by
//! what they promise to bring, so that most of the time goes where light comes from.
//!
//! Neglected: bending of light where n_eff changes inside, light to the lens through walls and sides.

use std::f64::consts::PI;

use glam::DVec3;
use procedural::Medium;
use rand::Rng;

use super::super::LONGEST_MM;
use super::super::towards::mean_sine;
use super::super::walk::{Photon, ROULETTE, meet};
use super::relief::{Cell, Stop};
use super::voxels::{Voxels, axis, extinction};
use crate::transport::fresnel::fresnel_dielectric;
use crate::transport::phase::{cylinder_towards, dispersed, frame, uniform};
use crate::transport::stack::{CylinderPhase, WOOD_DISPERSION};

/// Meetings with surfaces after which light is given up: it is caught in a wedge.
const MEETINGS: u32 = 10_000;
/// Slope from which on a surface is a wall, through which the lens does not look [1].
const WALL: f64 = 2.0;
/// Surface that stands so far above a place nearby may hide it from the lens [mm].
const HIDES_MM: f64 = 0.1;
/// Light to the lens that is always followed, and depth below which no more is given up for depth [1], [mm].
const WORTH: f64 = 0.1;
const DEEP_MM: f64 = 1.0;
/// Optical depth from which on chance decides whether a way to the lens is followed on, and its chance.
const FAINT: f64 = 4.0;
const FOLLOWED: f64 = 0.25;

/// Where light went, for those who keep count.
pub(in crate::transport::path) trait Ledger {
    /// Light [1] that the lens sees at a place of the surface.
    fn see(&mut self, place: DVec3, light: f64);
    /// Weight that went this way; negative where roulette gives energy back.
    fn book(&mut self, fate: Fate, weight: f64);
}

/// What becomes of light.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::transport::path) enum Fate {
    /// Absorbed inside.
    Absorbed,
    /// Into the sky.
    Left,
    /// Onto the conveyor, through the bottom or from the sides.
    Dropped,
    /// Beyond the region that is followed.
    Astray,
}

/// A body to roam in.
#[derive(Debug)]
pub(super) struct Roam<'a> {
    pub voxels: Voxels<'a>,
    view: DVec3,
    sines: Sines,
}

impl<'a> Roam<'a> {
    pub fn new(voxels: Voxels<'a>, view: DVec3) -> Self {
        Self { voxels, view, sines: Sines::new() }
    }

    /// Follows a photon inside until it is gone.
    pub fn follow(&self, mut photon: Photon, ledger: &mut impl Ledger, rng: &mut impl Rng) {
        let mut meetings = 0;
        loop {
            let mut depth = -libm::log(uniform(rng));
            let mut medium = None;
            let stop = self.voxels.relief().march(photon.place, photon.way, true, |cell, length| {
                let here = self.voxels.at(cell);
                let (extinction, passed) = (extinction(here), extinction(here) * length);
                if passed < depth {
                    depth -= passed;
                    return None;
                }
                medium = Some((here, cell));
                Some(if extinction > 0.0 { depth / extinction } else { 0.0 })
            });
            let (Stop::Taken(length) | Stop::Surface(length, _) | Stop::Ground(length) | Stop::Beyond(length)) = stop;
            photon.place += photon.way * length;
            photon.path += length;
            if photon.path > LONGEST_MM || meetings > MEETINGS {
                return ledger.book(Fate::Astray, photon.weight);
            }
            match (stop, medium) {
                (Stop::Taken(_), Some((medium, cell))) => {
                    self.collide(&mut photon, medium, cell, ledger, rng);
                    if photon.weight == 0.0 {
                        return;
                    }
                }
                (Stop::Surface(_, cell), _) => {
                    meetings += 1;
                    let normal = self.voxels.relief().normal(cell, photon.place);
                    if self.emerge(&mut photon, normal, rng)
                        && let Some(fate) = self.fly(&mut photon, &mut meetings, rng)
                    {
                        return ledger.book(fate, photon.weight);
                    }
                }
                (Stop::Ground(_), _) => {
                    meetings += 1;
                    // Back into the lowest cells by the sign of the way, whatever rounding did to the height.
                    photon.place.z = 0.0;
                    if self.emerge(&mut photon, DVec3::NEG_Z, rng) {
                        return ledger.book(Fate::Dropped, photon.weight);
                    }
                }
                _ => return ledger.book(Fate::Astray, photon.weight),
            }
        }
    }

    fn collide(&self, photon: &mut Photon, medium: &Medium, cell: Cell, ledger: &mut impl Ledger, rng: &mut impl Rng) {
        self.look(photon, medium, cell, ledger, rng);
        let lost = photon.weight * f64::from(medium.mu_a) / extinction(medium);
        ledger.book(Fate::Absorbed, lost);
        photon.weight -= lost;
        let axis = axis(medium);
        let fibre = |rng: &mut _| dispersed(axis, frame(axis), WOOD_DISPERSION, rng);
        let (sigma_i, k) = (f64::from(medium.sigma_i), f64::from(medium.k));
        if sigma_i + k > 0.0 {
            meet(photon.way, sigma_i, k, rng, fibre).apply(photon, CylinderPhase::Cauchy(0.0), rng);
        }
        if photon.weight < ROULETTE {
            ledger.book(Fate::Absorbed, photon.gamble(rng));
        }
    }

    /// Takes a photon on the surface out of the body or back into it; whether it is out.
    fn emerge(&self, photon: &mut Photon, normal: DVec3, rng: &mut impl Rng) -> bool {
        let n = f64::from(self.voxels.at(self.voxels.relief().cell(photon.place)).n_eff);
        let mu = photon.way.dot(normal).clamp(0.0, 1.0);
        let (reflectance, cosine) = fresnel_dielectric(n, 1.0, mu);
        let out = uniform(rng) > reflectance;
        photon.way = if out { photon.way * n + normal * (cosine - n * mu) } else { photon.way - normal * (2.0 * mu) };
        photon.way = photon.way.normalize();
        out
    }

    /// Takes a photon through the air; where it went, or `None` once it is inside again.
    fn fly(&self, photon: &mut Photon, meetings: &mut u32, rng: &mut impl Rng) -> Option<Fate> {
        while *meetings <= MEETINGS {
            match self.voxels.relief().march(photon.place, photon.way, false, |_, _| None) {
                Stop::Surface(length, cell) => {
                    *meetings += 1;
                    photon.place += photon.way * length;
                    let n = f64::from(self.voxels.at(self.voxels.relief().cell(photon.place)).n_eff);
                    let normal = self.voxels.relief().normal(cell, photon.place);
                    let mu = (-photon.way.dot(normal)).clamp(0.0, 1.0);
                    let (reflectance, cosine) = fresnel_dielectric(1.0, n, mu);
                    if uniform(rng) > reflectance {
                        photon.way = (photon.way / n + normal * (mu / n - cosine)).normalize();
                        return None;
                    }
                    photon.way = (photon.way + normal * (2.0 * mu)).normalize();
                }
                Stop::Ground(_) => return Some(Fate::Dropped),
                // Beside the body the region ends; what sinks there meets the conveyor farther off.
                Stop::Beyond(_) | Stop::Taken(_) if photon.way.z < 0.0 => return Some(Fate::Dropped),
                Stop::Beyond(_) | Stop::Taken(_) => return Some(Fate::Left),
            }
        }
        Some(Fate::Astray)
    }

    /// Shows the lens what a collision sends its way.
    #[inline(never)]
    fn look(&self, photon: &Photon, medium: &Medium, cell: Cell, ledger: &mut impl Ledger, rng: &mut impl Rng) {
        let relief = self.voxels.relief();
        let (normal, n) = (relief.lean(cell), f64::from(medium.n_eff));
        let facing = self.view.dot(normal);
        let cosine = (1.0 - (1.0 - facing * facing) / (n * n)).max(0.0).sqrt();
        if facing <= 0.0 || cosine <= 0.0 {
            return;
        }
        let way = ((self.view - normal * facing) / n + normal * cosine).normalize();
        let share = f64::from(medium.sigma_i) / (4.0 * PI)
            + f64::from(medium.k)
                * cylinder_towards(photon.way, way, axis(medium), CylinderPhase::Cauchy(0.0), WOOD_DISPERSION, rng);
        let factor = PI * (1.0 - fresnel_dielectric(n, 1.0, cosine).0) / (n * n * cosine);
        let mut light = photon.weight * share / extinction(medium) * factor;
        // Chance decides which of the many dim or deep ones are worth the way up; the depth need not be right for that.
        let below = (relief.around(cell) - photon.place.z).min(DEEP_MM);
        let worth = light / WORTH * libm::exp(-0.5 * below * extinction(medium));
        if worth < 1.0 {
            if uniform(rng) > worth {
                return;
            }
            light /= worth;
        }
        let (mut depth, mut faint) = (0.0, FAINT);
        let stop = relief.march(photon.place, way, true, |cell, length| {
            let here = self.voxels.at(cell);
            let sine = self.sines.at(axis(here).dot(way));
            depth += length * (f64::from(here.mu_a) + f64::from(here.sigma_i) + f64::from(here.k) * sine);
            while depth > faint {
                if uniform(rng) > FOLLOWED {
                    return Some(0.0);
                }
                light /= FOLLOWED;
                faint -= libm::log(FOLLOWED);
            }
            None
        });
        let Stop::Surface(length, cell) = stop else { return };
        let place = photon.place + way * length;
        let upright = relief.normal(cell, place).z;
        if upright * upright * (1.0 + WALL * WALL) < 1.0 || self.hidden(place, cell) {
            return;
        }
        ledger.see(place, light * libm::exp(-depth));
    }

    /// Whether the body stands between a place on it and the lens.
    #[inline]
    fn hidden(&self, place: DVec3, cell: Cell) -> bool {
        let relief = self.voxels.relief();
        relief.around(cell) > place.z + HIDES_MM
            && !matches!(relief.march(place, self.view, false, |_, _| None), Stop::Beyond(_))
    }
}

/// Mean sine between light and wood's fibres, from a table: linear in the root of 1 - |cos|, good to 3e-4.
#[derive(Debug)]
struct Sines(Vec<f64>);

impl Sines {
    const STEPS: f64 = 512.0;

    fn new() -> Self {
        let along = |i: usize| 1.0 - (i as f64 / Self::STEPS).powi(2);
        Self((0..=Self::STEPS as usize + 1).map(|i| mean_sine(along(i).max(0.0), WOOD_DISPERSION)).collect())
    }

    #[inline(always)]
    fn at(&self, along: f64) -> f64 {
        let place = (1.0 - along.abs()).max(0.0).sqrt() * Self::STEPS;
        let i = place as usize;
        self.0[i] + (self.0[i + 1] - self.0[i]) * (place - i as f64)
    }
}
