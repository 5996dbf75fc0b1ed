//! Rough metal: microfacets of the GGX law (Walter et al. 2007) that light meets as it sees them.
//!
//! Model: light from l meets a facet whose normal is drawn among those it sees (Heitz 2018), and the facet
//! throws it back like a mirror; what would go on into the surface goes up instead, as after a second facet. So the
//! share thrown back is the facets' reflectance, under every angle, and the density towards v is
//! D(h) / (2 (cos_l + sqrt(a_x^2 l_x^2 + a_y^2 l_y^2 + cos_l^2))), once for v and once for its image below.
//!
//! What is no metal but lies on the foil, powder, is taken as a matt surface: facets of roughness 1 with the spherical
//! albedo of a half space, (1 - s) (1 - 0.139 s) / (1 + 1.17 s), s^2 the share absorbed per meeting (van de Hulst
//! 1980).
//!
//! Valid for roughness up to about 0.4. Neglected: reflectance that changes with the angle (aluminium: under 3 % below
//! 70 degrees), light that a second facet takes, and with it reciprocity at grazing angles; light below a powder's
//! surface.

use std::f64::consts::PI;

use base::{Gloss, Medium};
use glam::DVec3;
use rand::Rng;

use crate::phase::disc;

/// The facets of what lies below all: foil, or powder on it.
pub(super) fn bottom(medium: &Medium) -> Gloss {
    if medium.gloss.is_metal() {
        return medium.gloss;
    }
    let s = (medium.mu_a / (medium.mu_a + medium.sigma_i)).sqrt();
    Gloss { share: 1.0, reflectance: (1.0 - s) * (1.0 - 0.139 * s) / (1.0 + 1.17 * s), roughness: [1.0; 2], matte: 0.0 }
}

/// A piece of rough metal.
#[derive(Debug, Clone, Copy)]
pub(super) struct Microfacets {
    /// Tangents nearest to x and y, and the normal.
    frame: [DVec3; 3],
    roughness: [f64; 2],
    /// Share that comes back [1].
    pub reflectance: f64,
}

impl Microfacets {
    pub fn new(gloss: &Gloss, normal: DVec3) -> Self {
        let along = (DVec3::X - normal * normal.x).normalize();
        Self {
            frame: [along, normal.cross(along), normal],
            roughness: gloss.roughness.map(f64::from),
            reflectance: f64::from(gloss.share * gloss.reflectance),
        }
    }

    fn local(&self, direction: DVec3) -> DVec3 {
        DVec3::from(self.frame.map(|axis| axis.dot(direction)))
    }

    /// Direction into which light that travels along `direction` is thrown back.
    pub fn sample(&self, direction: DVec3, rng: &mut impl Rng) -> DVec3 {
        let [ax, ay] = self.roughness;
        let light = -self.local(direction);
        // The half ball that the facets become when stretched, seen from the light.
        let seen = DVec3::new(ax * light.x, ay * light.y, light.z).normalize();
        let flat = seen.x * seen.x + seen.y * seen.y;
        let across = if flat > 0.0 { DVec3::new(-seen.y, seen.x, 0.0) / flat.sqrt() } else { DVec3::X };
        let up = seen.cross(across);
        let (x, y, _) = disc(rng);
        let lift = 0.5 * (1.0 + seen.z);
        let y = (1.0 - lift) * (1.0 - x * x).sqrt() + lift * y;
        let facet = across * x + up * y + seen * (1.0 - x * x - y * y).max(0.0).sqrt();
        let facet = DVec3::new(ax * facet.x, ay * facet.y, facet.z.max(1e-9)).normalize();
        let back = facet * (2.0 * light.dot(facet)) - light;
        (self.frame[0] * back.x + self.frame[1] * back.y + self.frame[2] * back.z.abs()).normalize()
    }

    /// Density of that direction towards `view` [sr^-1].
    pub fn density(&self, direction: DVec3, view: DVec3) -> f64 {
        let [ax, ay] = self.roughness;
        let (light, view) = (-self.local(direction), self.local(view));
        if view.z <= 0.0 || light.z <= 0.0 {
            return 0.0;
        }
        let (lx, ly) = (ax * light.x, ay * light.y);
        let shown = light.z + (lx * lx + ly * ly + light.z * light.z).sqrt();
        let towards = |view: DVec3| {
            let half = (light + view).normalize_or_zero();
            if half.z <= 0.0 {
                return 0.0;
            }
            let (hx, hy) = (half.x / ax, half.y / ay);
            let d = hx * hx + hy * hy + half.z * half.z;
            1.0 / (PI * ax * ay * d * d * 2.0 * shown)
        };
        towards(view) + towards(DVec3::new(view.x, view.y, -view.z))
    }
}
