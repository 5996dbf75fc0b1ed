//! Boards from pictures: fibres and absorption of the wood that a photograph or a Reflectance map shows, and
//! coefficients of the wood in a stack of slices.
//!
//! `grey --fibre_map--> FibreMap --absorption_map--> AbsorptionMap`
//!
//! `BoardPicture --cut--> PicturedWood`, which a board is laid of (`procedural::wood::Plank::lay`).
//!
//! `densities --DensityStack--> WoodVolume --cut--> SlicedWood`, likewise.
//!
//! Plain arrays in and out; whoever calls reads files. docs/theory/boards-from-pictures.md has the method,
//! its sources and the figures measured.
//!
//! Frame: x along a row, y down the rows, z out of the face; row 0 is at the smallest y. Units: mm, mm^-1, rad.

mod absorption;
mod background;
mod belt;
mod board;
mod components;
mod density_law;
mod fault;
mod fibre;
mod grain_scale;
mod half_space;
mod knots;
mod length;
mod marks;
mod orientation;
mod picture;
mod raster;
mod rings;
mod ripple;
mod texture;
mod tone;
mod volume;

use base::words;

pub use absorption::{AbsorptionMap, absorption_map, face_absorption};
pub use belt::BoardPart;
pub use board::{BoardPicture, Depth, PicturedWood};
pub use density_law::{DensityLaw, KindDensities};
pub use fault::{PictureFault, VolumeFault};
pub use fibre::{FibreMap, Findings, analyse, fibre_map};
pub use half_space::HalfSpace;
pub use knots::PictureKnot;
pub use marks::SawMarks;
pub use picture::{Encoding, red_channel};
pub use volume::{DensityStack, FibreAxis, SlicedWood, StackPlace, WoodVolume};

words! {
    /// Which side of the board the picture shows.
    Face {
        /// The pith lies below it.
        Bark = "bark",
        /// The pith lies above it.
        Pith = "pith",
    }
}

/// What the picture itself does not say.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PictureAnalysis {
    /// How its numbers go with light.
    pub encoding: Encoding,
    /// Its number at the end of the scale: 1, 255 or 65535.
    pub full_scale: f32,
    /// Length (down the rows) and width of the board, if the picture shows all of it [mm].
    pub board_mm: Option<[f32; 2]>,
    /// Whether the board's length lies along the rows, not down them.
    pub lies_across: bool,
    /// Which side of the board it shows.
    pub face: Face,
    /// Least width of a knot [mm].
    pub least_knot_mm: f32,
    /// Half distance of source and sink over a knot's half width, as `knots.flow_ratio` of recipes [1].
    pub flow_ratio: f32,
}

impl Default for PictureAnalysis {
    /// A picture to 1 whose encoding was not stated (which is refused), of the bark's side, with knots from 2 mm.
    fn default() -> Self {
        Self {
            encoding: Encoding::Unknown,
            full_scale: 1.0,
            board_mm: None,
            lies_across: false,
            face: Face::Bark,
            least_knot_mm: 2.0,
            flow_ratio: 1.0,
        }
    }
}
