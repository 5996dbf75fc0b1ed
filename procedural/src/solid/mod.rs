//! Solid pieces of one material: the saw-tooth of a calibration, and parts from files of triangles.

pub mod material;
pub mod part;
pub mod sawtooth;

pub use material::Material;
pub use part::{Part, Placing};
pub use sawtooth::{Piece, Sawtooth};
