//! A blister pack: formed film over tablets, closed by foil.
//!
//! `Blister --form--> Pack --slice--> PackSlice --> Surface, Matter`.

mod fill;
mod formed;
mod hull;
mod lay;
mod outline;
pub mod parameters;
mod pose;
pub mod solid;
mod tablet;
mod texture;
mod web;

use glam::{Vec2, Vec3};

use self::lay::Lay;
pub use self::parameters::{Blister, Card, Defects, Foil, Pocket, Tablet, Web};
pub use self::solid::Solid;
use self::web::{FormedWeb, Leaf};
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
    lay: Lay,
    web: FormedWeb,
    foil: Medium,
    solids: Vec<Solid>,
    /// Solids that lie above the cell of each pocket.
    contents: Vec<Vec<usize>>,
    instances: Vec<Instance>,
    /// Height of a box around it [mm].
    height: f32,
}

/// A pack cut at one scan position.
#[derive(Debug, Clone, Copy)]
pub struct PackSlice<'a> {
    pack: &'a Pack,
    y: f32,
}

/// Reflectance of a smooth surface of matter with index `n` at normal incidence [1].
fn fresnel(n: f32) -> f32 {
    let r = (n - 1.0) / (n + 1.0);
    r * r
}

/// A place of the card and the film over it.
#[derive(Debug, Clone, Copy)]
struct Spot {
    p: Vec2,
    cell: Option<usize>,
    leaf: Leaf,
}

impl Pack {
    /// Forms and fills the pack; every part draws from its own child of `stream`.
    pub fn form(stream: Stream, blister: &Blister) -> Self {
        fill::form(stream, blister)
    }

    /// The cut at scan position `y` [mm].
    pub fn slice(&self, y: f32) -> PackSlice<'_> {
        PackSlice { pack: self, y }
    }

    /// The film above (x, y) [mm]; `None` where there is none: beside the card or in a hole.
    pub fn sheet(&self, x: f32, y: f32) -> Option<Sheet> {
        let spot = self.spot(x, y)?;
        Some(Sheet {
            surface: self.world(spot.p, spot.leaf.top, spot.leaf.slope),
            thickness_mm: spot.leaf.thickness,
            sealed: spot.leaf.inset <= 0.0,
            medium: self.web.medium(spot.leaf.drawn),
        })
    }

    /// The upper side of the foil at (x, y) [mm], and what it is made of.
    pub fn foil(&self, x: f32, y: f32) -> (Surface, Medium) {
        let p = self.lay.card(x, y);
        let cell = self.web.nearest(p);
        self.foil_at(p, self.web.leaf(p, cell).inset)
    }

    /// Everything between film and foil: convex solids, which may touch and do not overlap.
    pub fn solids(&self) -> &[Solid] {
        &self.solids
    }

    /// A closed coarse hull [mm].
    pub fn hull(&self) -> Mesh {
        hull::hull(&self.lay, |p| self.web.leaf(p, self.web.nearest(p)).top)
    }

    /// Lowest and highest corner of a box around the pack [mm].
    pub fn bounds(&self) -> (Vec3, Vec3) {
        let (reach, middle) = self.lay.reach();
        ((middle - reach).extend(0.0), (middle + reach).extend(self.height))
    }

    /// Its pockets first, then its defects.
    pub fn instances(&self) -> &[Instance] {
        &self.instances
    }

    fn spot(&self, x: f32, y: f32) -> Option<Spot> {
        let p = self.lay.card(x, y);
        if !self.lay.holds(p) {
            return None;
        }
        let cell = self.web.nearest(p);
        Some(Spot { p, cell, leaf: self.web.leaf(p, cell) })
    }

    /// A height over the flat card, and its slope there, on the conveyor.
    fn world(&self, p: Vec2, height: f32, slope: Vec2) -> Surface {
        let (rise, tilt) = self.lay.warp(p);
        let slope = self.lay.along(slope + tilt);
        Surface { z: height + rise, slope_x: slope.x, slope_y: slope.y }
    }

    fn foil_at(&self, p: Vec2, inset: f32) -> (Surface, Medium) {
        let (height, slope) = self.web.relief(p, inset);
        (self.world(p, self.web.foil_mm + height, slope), self.foil)
    }

    /// The highest solid over a place: its number and its upper side.
    fn highest(&self, cell: Option<usize>, x: f32, y: f32) -> Option<(usize, f32)> {
        let mut best = None;
        for &number in cell.map_or(&[][..], |cell| &self.contents[cell]) {
            let top = self.solids[number].column(x, y).map(|[_, top]| top);
            if let Some(top) = top.filter(|&top| best.is_none_or(|(_, other)| top > other)) {
                best = Some((number, top));
            }
        }
        best
    }
}

impl PackSlice<'_> {
    /// Upper surface above `x` [mm]: the film, or what lies open in a hole; `None` beside the card.
    pub fn surface(&self, x: f32) -> Option<Surface> {
        self.pack.spot(x, self.y).map(|spot| self.pack.world(spot.p, spot.leaf.top, spot.leaf.slope))
    }

    /// Medium and truth at `x` of the cut, as light from above meets them [mm].
    pub fn matter(&self, x: f32) -> Matter {
        let (pack, y) = (self.pack, self.y);
        let Some(Spot { p, cell, leaf }) = pack.spot(x, y) else {
            return Matter { medium: Medium::opaque(Gloss::NONE), film: None, class: Class::Background, instance: 0 };
        };
        let (foil, metal) = pack.foil_at(p, leaf.inset);
        let sealed = leaf.inset <= 0.0;
        let solid = if sealed { None } else { pack.highest(cell, x, y) };
        let (under, slope, top) = match solid {
            Some((number, top)) => {
                let solid = &pack.solids[number];
                let normal = solid.normal(Vec3::new(x, y, top));
                let up = normal.z.max(0.02);
                (solid.medium, [-normal.x / up, -normal.y / up], top)
            }
            None => (metal, [foil.slope_x, foil.slope_y], foil.z),
        };
        let low = leaf.low() + pack.lay.warp(p).0;
        let film = Film {
            thickness_mm: leaf.thickness,
            gap_mm: (!sealed).then(|| (low - top).max(0.0)),
            under,
            under_slope: slope,
        };
        let (class, instance) = match cell {
            Some(cell) if leaf.inset > 0.0 => (pack.instances[cell].class, pack.instances[cell].id),
            _ => (Class::Flange, 0),
        };
        Matter { medium: pack.web.medium(leaf.drawn), film: Some(film), class, instance }
    }
}
