//! What a pack is at one place.

use glam::DVec3;
use procedural::blister::Sheet;
use procedural::{Medium, Surface};

/// What a pack is at one place, from above.
#[derive(Debug, Clone, Copy)]
pub(super) struct Spot {
    /// The film, unless there is a hole.
    pub sheet: Option<Sheet>,
    /// The foil below.
    pub foil: (Surface, Medium),
}

/// The film's matter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Slab {
    /// Refractive index [1].
    pub n: f64,
    /// Absorption [mm^-1].
    pub mu_a: f64,
    /// Scattering [mm^-1].
    pub mu_s: f64,
}

impl Slab {
    /// Extinction [mm^-1].
    #[inline(always)]
    pub fn extinction(&self) -> f64 {
        self.mu_a + self.mu_s
    }
}

/// Upward normal of a surface.
pub(super) fn normal(surface: &Surface) -> DVec3 {
    DVec3::new(-f64::from(surface.slope_x), -f64::from(surface.slope_y), 1.0).normalize()
}

/// The number of a value in a list without repetitions.
pub(super) fn number<T: PartialEq>(list: &mut Vec<T>, value: T) -> u16 {
    let at = list.iter().rposition(|other| *other == value).unwrap_or_else(|| {
        list.push(value);
        list.len() - 1
    });
    u16::try_from(at).unwrap_or(u16::MAX)
}
