//! What a recipe fixes of the laser.

use std::sync::Arc;

use base::words;

words! {
    /// Lens that makes a sheet of a laser's beam.
    Fan {
        /// Even on a plane.
        Powell = "powell",
        /// With a hot spot in the middle.
        Cylindrical = "cylindrical",
    }
}

words! {
    /// What the laser looks like across its line.
    LineShape {
        /// A Gaussian beam.
        Gaussian = "gaussian",
        /// Even, with hard edges.
        Slit = "slit",
        /// A picture.
        Texture = "texture",
        /// A round Gaussian spot, stepped along the line.
        Point = "point",
    }
}

/// What of the laser is not drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct LaserLine {
    /// Its lens.
    pub fan: Fan,
    /// Its shape.
    pub shape: LineShape,
    /// What a texture shows; `None` for the thesis' line.
    pub picture: Option<TextureImage>,
}

/// Light of a picture; clones share it.
#[derive(Debug, Clone, PartialEq)]
pub struct TextureImage {
    /// Rows across the line, the first at the largest y [px].
    pub rows: usize,
    /// Columns along the line, the first at the smallest x [px].
    pub columns: usize,
    /// Light of each pixel, `[rows, columns]`, row-major; any unit.
    pub light: Arc<[f32]>,
}

impl LaserLine {
    /// A Gaussian beam behind a Powell lens.
    pub const PLAIN: Self = Self { fan: Fan::Powell, shape: LineShape::Gaussian, picture: None };
}
