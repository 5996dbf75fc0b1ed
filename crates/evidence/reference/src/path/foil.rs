//! Foil: a rough mirror of metal below the last layer.
//!
//! Light is mirrored about a facet's normal m. Facets follow the GGX law (Walter et al. 2007), in both directions of
//! the plane its own roughness: D(m) = 1 / (pi a_x a_y (m_x^2 / a_x^2 + m_y^2 / a_y^2 + m_z^2)^2); those that light in
//! direction -v sees are drawn by the spherical cap of Dupuy and Benyoub (2023) after Heitz (2018). The share
//! `reflectance` of light is thrown back, whatever its direction. Where a facet would throw it into the foil another
//! one is drawn: light between facets is not lost.
//!
//! Valid for facets larger than the wavelength. Neglected: change of reflectance with angle, light that meets facets
//! more than once other than through that draw, texture of the roll.

use glam::DVec3;
use rand::Rng;

use crate::phase::{disc, uniform};
use transport::stack::Foil;

/// Draws before light is mirrored about the foil's own normal.
const MAX_DRAWS: usize = 32;

/// Direction of light that met the foil travelling along `direction`, downwards, drawn.
pub(super) fn mirror(foil: &Foil, direction: DVec3, rng: &mut impl Rng) -> DVec3 {
    let back = -direction;
    for _ in 0..MAX_DRAWS {
        let facet = facet(foil, back, rng);
        let out = facet * (2.0 * back.dot(facet)) - back;
        if out.z > 1e-9 {
            return out.normalize();
        }
    }
    DVec3::new(direction.x, direction.y, -direction.z)
}

/// Normal of a facet among those that are seen from direction `v`, upwards.
fn facet(foil: &Foil, v: DVec3, rng: &mut impl Rng) -> DVec3 {
    let [ax, ay] = foil.roughness;
    // As if seen on a sphere of unit roughness.
    let v = DVec3::new(ax * v.x, ay * v.y, v.z).normalize();
    let z = (1.0 - uniform(rng)) * (1.0 + v.z) - v.z;
    let sin = (1.0 - z * z).max(0.0).sqrt();
    let (x, y, s) = disc(rng);
    let scale = sin / s.sqrt();
    let h = DVec3::new(x * scale, y * scale, z) + v;
    DVec3::new(ax * h.x, ay * h.y, h.z.max(0.0)).normalize()
}
