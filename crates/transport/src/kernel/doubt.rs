//! Where the kernel's answer is known to be poor: windows of rows were seen to be a tenth to half, or more, off the
//! reference Monte Carlo.
//!
//! Bounds are those of draws over all that recipes accept (`tests/reference/accepted.rs`); beyond them figures are
//! mostly within a tenth. Within them not every answer is off. Valid for level surfaces.

use base::{Film, Medium};
use glam::Vec3;

use super::film_stack;
use super::half_space::{self, KernelError};
use crate::answer::Question;
use crate::stack::{Stack, Substrate};

/// Scattering below which light that met single fibres is seen as such, one free path beside the line [mm^-1].
const WEAK_SCATTERING: f32 = 2.3;
/// Dispersion of fibres below which it keeps to its cone [deg].
const STRAIGHT_DEG: f32 = 5.5;
/// Index below which the surface lets it out nearly as it comes [1].
const LOW_INDEX: f32 = 1.2;
/// Absorption over scattering from which on hardly anything else comes from there [1].
const MUCH_ABSORBED: f32 = 0.15;
/// Greatest sine of the angle between fibres and face, and least cosine of that between their track and the motion, at
/// which the cone stands towards the lens: 20 and 35 degrees [1].
const FLAT_DIVE: f32 = 0.342;
const ALONG_MOTION: f32 = 0.819;
/// Least cosine of the tilt of a lens in this cone: 50 degrees [1].
const CONE_VIEW_UP: f32 = 0.643;
/// Scattering below which most light that the lens sees near the line was turned once [mm^-1].
const LONG_PATHS: f32 = 0.75;
/// Reduced scattering times thickness below which a film is clear, above foil and on it [1].
const CLEAR_FILM: f32 = 0.05;
const CLEAR_SEALED: f32 = 0.2;
/// The same from which on pigment turns what total reflection holds in film that is sealed to foil [1].
const TINTED: f32 = 0.01;
/// Roughness of foil, in either direction, from which on its facets throw light far aside; the same of near foil [1].
const ROUGH: f32 = 0.6;
const ROUGH_AND_NEAR: f32 = 0.45;
/// Height of the air under a film up to which foil is near [mm].
const NEAR_MM: f32 = 1.0;
/// Roughnesses below and above which foil is smooth in one direction and rough in the other [1].
const SMOOTH_ONE_WAY: f32 = 0.11;
const ROUGH_OTHER_WAY: f32 = 0.33;

/// Why an answer of the kernel is in doubt.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum Doubt {
    /// Matter in which the lens sees light that met single fibres.
    #[error(
        "fibres lie along the motion, hardly dispersed, in matter that absorbs much and scatters little: rows \
         0.7 mm beside the line are up to 50 % too bright"
    )]
    StraightFibres,
    /// Matter whose free paths are longer than the window of a line.
    #[error(
        "matter scatters less than 0.75/mm: rows beside the line show light that was turned once, those towards the \
         lens up to a third too dark, those on the other side up to two thirds too bright, the line's middle up to \
         0.6 rows off"
    )]
    LongPaths,
    /// Foil that throws light far below clear film.
    #[error(
        "clear film lies over rough foil: reflectance is up to 0.05 off, light of rows beside the line up to a fifth, \
         that of dark ones 0.7 mm beside it up to half"
    )]
    RoughFoil,
    /// Foil that keeps the direction of light one way and not the other, on clear film.
    #[error(
        "clear film is sealed to foil that is smooth one way and rough the other: light of rows 0.7 mm beside the \
         line, dark ones, is off by a third to twice"
    )]
    RolledFoil,
}

impl Doubt {
    /// Of matter without film, its face level, seen along `view` (unit vector to the lens).
    pub fn of_matter(medium: &Medium, view: Vec3) -> Option<Self> {
        let scattering = medium.sigma_i + medium.k;
        let Vec3 { y, z, .. } = medium.fibre;
        let is_in_cone = z.abs() < FLAT_DIVE && y.abs() > ALONG_MOTION * (1.0 - z * z).sqrt() && view.z > CONE_VIEW_UP;
        let is_straight = medium.k > 0.0 && medium.dispersion_deg < STRAIGHT_DEG && medium.n_eff < LOW_INDEX;
        let is_weak = scattering < WEAK_SCATTERING && medium.mu_a > MUCH_ABSORBED * scattering;
        match scattering < LONG_PATHS {
            true => Some(Self::LongPaths),
            false => (is_in_cone && is_straight && is_weak).then_some(Self::StraightFibres),
        }
    }

    /// Of a level `film` of `medium`.
    pub fn of_film(medium: &Medium, film: &Film) -> Option<Self> {
        let gloss = &film.under.gloss;
        let ([along, across], turns) = (gloss.roughness, medium.sigma_i * film.thickness_mm);
        if !gloss.is_metal() {
            return None;
        }
        match film.gap_mm {
            Some(gap) => {
                let rough = if gap < NEAR_MM { ROUGH_AND_NEAR } else { ROUGH };
                (along.max(across) > rough && turns < CLEAR_FILM).then_some(Self::RoughFoil)
            }
            None => {
                let is_rolled = along.min(across) < SMOOTH_ONE_WAY && along.max(across) > ROUGH_OTHER_WAY;
                (is_rolled && (TINTED..CLEAR_SEALED).contains(&turns)).then_some(Self::RolledFoil)
            }
        }
    }

    /// Of what [`super::solve`] answers about `stack`.
    ///
    /// # Errors
    /// As [`super::solve`].
    pub fn of(stack: &Stack, question: &Question) -> Result<Option<Self>, KernelError> {
        if stack.layers.len() > 1 || matches!(stack.below, Substrate::Foil(_)) {
            let film_stack = film_stack::film_stack(stack, question)?;
            Ok(Self::of_film(&film_stack.medium, &film_stack.film))
        } else {
            Ok(Self::of_matter(&half_space::medium(stack, question)?, question.view.as_vec3()))
        }
    }
}
