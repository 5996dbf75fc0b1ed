//! A blister pack: formed film over tablets, closed by foil.
//!
//! `Blister --form--> Pack --slice--> PackSlice --> Surface, Matter`.
//!
//! A new defect is told in `defects`.

mod card_placement;
mod defects;
mod fill;
mod film_mark;
mod formed_pocket;
mod hull;
mod outline;
mod pack_point;
mod parameters;
mod pose;
pub mod solid;
mod tablet;
mod tablet_face;
mod tablet_placement;
mod texture;
mod web;

use base::{BodyKind, Class, Gloss, Instance, Matter, Medium, Mesh, Relief, Slice, Stream, Surface};
use glam::Vec3;

use self::card_placement::CardPlacement;
use self::defects::contaminants::Powder;
pub use self::defects::{Defects, exclusive_counts, pocket_counts};
use self::film_mark::FilmMark;
use self::pack_point::TabletDamage;
pub use self::parameters::{Card, Foil, Pocket, Tablet, Web};
pub use self::solid::Solid;
use self::tablet_face::TabletFace;
use self::web::FormedWeb;

base::parameter_groups! {
    /// Everything that makes a pack.
    Blister {
        /// Card.
        card: Card;
        /// Pockets.
        pocket: Pocket;
        /// Tablets.
        tablet: Tablet;
        /// Film.
        web: Web;
        /// Foil.
        foil: Foil;
        /// Defects.
        defects: Defects;
    }
}

/// The film at a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CardFilm {
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
    lay: CardPlacement,
    web: FormedWeb,
    foil: Medium,
    solids: Vec<Solid>,
    /// Solids that lie above the cell of each pocket.
    contents: Vec<Vec<usize>>,
    /// Marks of the film that reach into the cell of each pocket.
    marks: Vec<Vec<FilmMark>>,
    wounds: Vec<Option<TabletDamage>>,
    powders: Vec<Option<Powder>>,
    face: TabletFace,
    instances: Vec<Instance>,
    /// What the warp may take of the room around a tablet [mm].
    slack: f32,
    /// Height of a box around it [mm].
    height: f32,
}

/// A pack cut at one scan position.
#[derive(Debug, Clone, Copy)]
struct PackSlice<'a> {
    pack: &'a Pack,
    y: f32,
}

/// Where the hull asks for heights, over where its corners are [1].
const INWARDS: f32 = 0.99999;

/// Reflectance of a smooth surface of matter with index `n` at normal incidence [1].
fn fresnel(n: f32) -> f32 {
    let r = (n - 1.0) / (n + 1.0);
    r * r
}

/// How much of its surroundings a pack takes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PackExtent {
    /// Room that each pocket takes across and along the card, with the flange to its neighbours [mm].
    ///
    /// Pockets that a card has no room for are left out; [`RIM_MM`] stays free around all of them together.
    pub room_mm: [f64; 2],
    /// Height that no place of the pack exceeds, however it is filled [mm].
    pub height_mm: f64,
}

/// The extent of packs of these numbers.
pub fn extent(blister: &Blister) -> PackExtent {
    let (room, height) = fill::extent_mm(blister);
    PackExtent { room_mm: room.to_array().map(f64::from), height_mm: f64::from(height) }
}

/// Flange beyond the room of the outermost pockets, both sides together [mm].
pub const RIM_MM: f64 = web::FLANGE_MM as f64;

impl Pack {
    /// Forms and fills the pack; every part draws from its own child of `stream`.
    pub fn form(stream: Stream, blister: &Blister) -> Self {
        fill::form(stream, blister)
    }

    /// The film above (x, y) [mm]; `None` where there is none: beside the card or in a hole.
    pub fn sheet(&self, x: f32, y: f32) -> Option<CardFilm> {
        self.film(&self.spot(x, y)?)
    }

    /// The upper side of the foil at (x, y) of the card [mm], or of powder on it, and what that is made of.
    pub fn foil(&self, x: f32, y: f32) -> (Surface, Medium) {
        match self.spot(x, y) {
            Some(spot) => {
                let (surface, medium, _) = self.ground(&spot);
                (surface, medium)
            }
            None => (Surface { z: self.web.foil_mm, slope_x: 0.0, slope_y: 0.0 }, self.foil),
        }
    }

    /// Everything between film and foil: convex solids, which may touch and do not overlap.
    pub fn solids(&self) -> &[Solid] {
        &self.solids
    }
}

impl BodyKind for Pack {
    fn slice(&self, y: f32) -> Box<dyn Slice + '_> {
        Box::new(PackSlice { pack: self, y })
    }

    fn hull(&self) -> Mesh {
        hull::hull(&self.lay, |p| {
            // A little inwards, so that no corner falls off the card by rounding.
            let at = self.lay.conveyor(INWARDS * p);
            self.spot(at.x, at.y).map_or(self.web.foil_mm, |spot| spot.leaf.top)
        })
    }

    fn bounds(&self) -> (Vec3, Vec3) {
        let (reach, middle) = self.lay.reach();
        ((middle - reach).extend(0.0), (middle + reach).extend(self.height))
    }

    /// Its pockets first, then its defects.
    fn instances(&self) -> &[Instance] {
        &self.instances
    }

    fn relief(&self) -> Relief {
        Relief::Film { clearest: self.web.medium(1.0).sigma_i * self.web.thinnest_mm() }
    }
}

impl Slice for PackSlice<'_> {
    /// The film, or what lies open in a hole.
    fn surface(&self, x: f32) -> Option<Surface> {
        self.pack.spot(x, self.y).map(|spot| self.pack.surface_at(&spot))
    }

    /// Medium and truth as light from above meets them.
    fn matter(&self, x: f32, _: f32) -> Matter {
        match self.pack.spot(x, self.y) {
            Some(spot) => self.pack.matter_at(&spot),
            None => Matter { medium: Medium::opaque(Gloss::NONE), film: None, class: Class::Background, instance: 0 },
        }
    }
}
