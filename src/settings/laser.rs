//! What a recipe fixes of the laser.

use std::sync::Arc;

/// Lens that makes a sheet of a laser's beam.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fan {
    /// Even on a plane.
    Powell,
    /// With a hot spot in the middle.
    Cylindrical,
}

impl Fan {
    /// Every lens in the order of [`Self::NAMES`].
    pub const ALL: [Self; 2] = [Self::Powell, Self::Cylindrical];
    /// Names in recipes and files.
    pub const NAMES: [&str; 2] = ["powell", "cylindrical"];
}

/// What the laser looks like across its line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    /// A Gaussian beam.
    Gaussian,
    /// Even, with hard edges.
    Slit,
    /// A picture.
    Texture,
    /// A round Gaussian spot, stepped along the line.
    Point,
}

impl Shape {
    /// Every shape in the order of [`Self::NAMES`].
    pub const ALL: [Self; 4] = [Self::Gaussian, Self::Slit, Self::Texture, Self::Point];
    /// Names in recipes and files.
    pub const NAMES: [&str; 4] = ["gaussian", "slit", "texture", "point"];
}

/// What of the laser is not drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// Its lens.
    pub fan: Fan,
    /// Its shape.
    pub shape: Shape,
    /// What a texture shows; `None` for the thesis' line.
    pub picture: Option<Picture>,
}

/// Light of a picture; clones share it.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// Rows across the line, the first at the largest y [px].
    pub rows: usize,
    /// Columns along the line, the first at the smallest x [px].
    pub columns: usize,
    /// Light of each pixel, `[rows, columns]`, row-major; any unit.
    pub light: Arc<[f32]>,
}

impl Line {
    /// A Gaussian beam behind a Powell lens.
    pub const PLAIN: Self = Self { fan: Fan::Powell, shape: Shape::Gaussian, picture: None };
}
