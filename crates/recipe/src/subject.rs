//! Subject: what the objects of a recipe are, and the numbers that one draw gives such an object.

use base::{Parameter, words};
use procedural::blister::Blister;
use procedural::solid::{Material, Piece, Placing};
use procedural::wood::Wood;

words! {
    /// What the objects are.
    Subject {
        /// Boards of wood.
        Wood = "wood",
        /// Blister packs, film up.
        Blister = "blister",
        /// Saw-tooth pieces for calibration.
        Sawtooth = "sawtooth",
        /// A part from a file of triangles.
        Mesh = "mesh",
    }
}

/// The numbers that one object is made from.
#[derive(Debug, Clone, Copy, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "there is one for a sample, whose maps are a thousand times larger")]
pub enum Plan {
    /// Of a board and the log that it was cut from.
    Wood(Wood),
    /// Of a blister pack.
    Blister(Blister),
    /// Of a saw-tooth piece.
    Sawtooth(Piece, Material),
    /// Of a part, whose triangles the scene has.
    Mesh(Placing, Material),
}

impl Plan {
    /// Fills every number of `subject` from `value`, asked once for each declaration in order.
    pub fn from_values(subject: Subject, value: &mut dyn FnMut(&'static Parameter) -> f64) -> Self {
        match subject {
            Subject::Wood => Self::Wood(Wood::from_values(value)),
            Subject::Blister => Self::Blister(Blister::from_values(value)),
            Subject::Sawtooth => Self::Sawtooth(Piece::from_values(value), Material::from_values(value)),
            Subject::Mesh => Self::Mesh(Placing::from_values(value), Material::from_values(value)),
        }
    }

    /// What the object is.
    pub fn subject(&self) -> Subject {
        match self {
            Self::Wood(_) => Subject::Wood,
            Self::Blister(_) => Subject::Blister,
            Self::Sawtooth(..) => Subject::Sawtooth,
            Self::Mesh(..) => Subject::Mesh,
        }
    }

    /// Every number with its declaration, in their order.
    pub fn values(&self) -> Vec<(&'static Parameter, f64)> {
        match self {
            Self::Wood(wood) => wood.values(),
            Self::Blister(blister) => blister.values(),
            Self::Sawtooth(piece, material) => [piece.values(), material.values()].concat(),
            Self::Mesh(placing, material) => [placing.values(), material.values()].concat(),
        }
    }

    /// The numbers of a board; `None` for anything else.
    pub fn wood(&self) -> Option<&Wood> {
        match self {
            Self::Wood(wood) => Some(wood),
            _ => None,
        }
    }

    /// The numbers of a blister pack; `None` for anything else.
    pub fn blister(&self) -> Option<&Blister> {
        match self {
            Self::Blister(blister) => Some(blister),
            _ => None,
        }
    }
}
