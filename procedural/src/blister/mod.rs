//! A blister pack: formed film over tablets, closed by foil.
//!
//! `Blister --form--> Pack --slice--> PackSlice --> Surface, Matter`.

pub mod parameters;
pub mod solid;

use glam::Vec3;

pub use self::parameters::{Blister, Card, Defects, Foil, Pocket, Tablet, Web};
pub use self::solid::Solid;
use crate::{Class, Film, Gloss, Instance, Matter, Medium, Mesh, Stream, Surface};

/// The film at a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sheet {
    /// Its upper side.
    pub surface: Surface,
    /// Thickness across it [mm].
    pub thickness_mm: f32,
    /// Whether the foil is sealed to it here, without air.
    pub sealed: bool,
    /// What it is made of.
    pub medium: Medium,
}

/// A blister pack.
#[derive(Debug, Clone)]
pub struct Pack {
    low: Vec3,
    high: Vec3,
    film: Medium,
    foil: Medium,
    thickness: f32,
    solids: Vec<Solid>,
    instances: Vec<Instance>,
}

/// A pack cut at one scan position.
#[derive(Debug, Clone, Copy)]
pub struct PackSlice<'a> {
    pack: &'a Pack,
    y: f32,
}

impl Pack {
    /// Forms and fills the pack; every part draws from its own child of `stream`.
    pub fn form(_stream: Stream, blister: &Blister) -> Self {
        let (card, web, foil) = (&blister.card, &blister.web, &blister.foil);
        let half = 0.5 * card.width_mm as f32;
        let r0 = ((web.n - 1.0) / (web.n + 1.0)).powi(2) as f32;
        let gloss = Gloss { share: 1.0, reflectance: r0, roughness: [web.roughness as f32; 2] };
        let metal = Gloss { share: 1.0, reflectance: foil.reflectance as f32, roughness: [0.3, 0.1] };
        Self {
            low: Vec3::new(card.offset_mm as f32 - half, card.lead_in_mm as f32, 0.0),
            high: Vec3::new(card.offset_mm as f32 + half, (card.lead_in_mm + card.length_mm) as f32, 5.0),
            film: Medium::isotropic(web.mu_a_per_mm as f32, web.sigma_per_mm as f32, web.n as f32, gloss),
            foil: Medium::opaque(metal),
            thickness: web.thickness_mm as f32,
            solids: Vec::new(),
            instances: Vec::new(),
        }
    }

    /// The cut at scan position `y` [mm].
    pub fn slice(&self, y: f32) -> PackSlice<'_> {
        PackSlice { pack: self, y }
    }

    /// The film above (x, y) [mm]; `None` where there is none: beside the card or in a hole.
    pub fn sheet(&self, x: f32, y: f32) -> Option<Sheet> {
        let inside = x > self.low.x && x < self.high.x && y > self.low.y && y < self.high.y;
        let surface = Surface { z: self.high.z, slope_x: 0.0, slope_y: 0.0 };
        inside.then_some(Sheet { surface, thickness_mm: self.thickness, sealed: false, medium: self.film })
    }

    /// The upper side of the foil at (x, y) [mm], and what it is made of.
    pub fn foil(&self, _x: f32, _y: f32) -> (Surface, Medium) {
        (Surface { z: 0.025, slope_x: 0.0, slope_y: 0.0 }, self.foil)
    }

    /// Everything between film and foil: convex solids, which may touch and do not overlap.
    pub fn solids(&self) -> &[Solid] {
        &self.solids
    }

    /// A closed coarse hull [mm].
    pub fn hull(&self) -> Mesh {
        Mesh::default()
    }

    /// Lowest and highest corner of a box around the pack [mm].
    pub fn bounds(&self) -> (Vec3, Vec3) {
        (self.low, self.high)
    }

    /// Its pockets first, then its defects.
    pub fn instances(&self) -> &[Instance] {
        &self.instances
    }
}

impl PackSlice<'_> {
    /// Upper surface above `x` [mm]: the film, or what lies open in a hole; `None` beside the card.
    pub fn surface(&self, x: f32) -> Option<Surface> {
        self.pack.sheet(x, self.y).map(|sheet| sheet.surface)
    }

    /// Medium and truth at `x` of the cut, as light from above meets them [mm].
    pub fn matter(&self, x: f32) -> Matter {
        let (foil, medium) = self.pack.foil(x, self.y);
        let gap = self.pack.high.z - self.pack.thickness - foil.z;
        let film = Film {
            thickness_mm: self.pack.thickness,
            gap_mm: Some(gap),
            under: medium,
            under_slope: [foil.slope_x, foil.slope_y],
        };
        Matter { medium: self.pack.film, film: Some(film), class: Class::Flange, instance: 0 }
    }
}
