//! The judge on packs: Monte Carlo of light in film, air, tablets and foil in their true shape.
//!
//! Model: the film is a body of its own between two height fields, its upper side and its lower one ([`shape`]); light
//! walks in it as in a layer, leaves it by Fresnel's law through either side, flies straight through the air and meets
//! film, tablets and foil where they stand ([`roam`]). Tablets are walked in like layers. No plane layers, no diffuse gaps,
//! no tables: nothing is shared with the kernel but coefficients. What the lens sees: [`look`].
//!
//! A cell of the answer holds the light that leaves the *film* over it towards the lens (or whatever lies open, in a
//! hole). A ray is a ray: through clear film the lens sees that place of the film, wherever the light was last turned.
//!
//! Valid for shapes coarser than 0.1 mm. Neglected: polarisation and waves, roughness of film and tablets, mirror images
//! ([`look`]), light farther than 20 mm from the line's grid (booked as astray).

mod facets;
mod look;
mod march;
mod raster;
mod roam;
mod room;
mod shape;
mod spot;
#[cfg(test)]
mod tests;

use procedural::blister::Pack;

pub(super) use self::roam::Roam;
use self::shape::Shape;
use crate::transport::line::LineSource;

impl Roam {
    /// In `pack`, about `line`.
    pub(super) fn in_pack(pack: &Pack, line: &LineSource) -> Self {
        Self::new(Shape::of(pack, line), line.view)
    }
}
