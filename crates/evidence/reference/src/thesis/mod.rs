//! Light that spreads in a picture: the method of Kihl and Källberg (2021), kept to compare with.
//!
//! Their model: a photograph of the surface is overlaid by a map of colours that say along which line the light of a
//! pixel spreads (Figure 3.9). The picture of the laser is spread along it, by drawing lines or by Stam's (2003)
//! diffusion with coefficients that depend on the pixel. What is absorbed is the map's alpha. Beside it stands what
//! such a diffusion in the plane should be, [`SpreadMethod::Conservative`]: a symmetric stencil with the tensor of
//! cylinder scattering, summed over the lengths of paths with which light comes back to the surface.
//!
//! Valid for looking at. The thesis' own methods work on pixels: reach and number of iterations are numbers of the
//! method and not of the matter, and the size of a pixel enters only as the caller gives it. They know no depth, no
//! surface, no direction of view and no level of light: what enters clear wood comes out of it. The thesis does not say
//! how coefficients follow from a direction, how wide its Gaussian is, nor what share a pixel of a line gets; where we
//! had to choose, the item says so.

mod conservative;
mod direction_map;
mod line_drawing;
mod line_response;
mod pixel_ground;
mod stam;
#[cfg(test)]
mod tests;

pub use self::direction_map::DirectionMap;
pub use self::line_drawing::LineRule;
pub use self::line_response::{LaserPoint, line_response, point};
pub use self::pixel_ground::{PixelGround, PlanarDiffusion, alpha};

/// How light is spread.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SpreadMethod {
    /// Along lines.
    Lines(LineRule),
    /// Stam's implicit diffusion with eight neighbours and coefficients of the receiving pixel alone.
    Diffusion {
        /// Time steps, alpha^(1 / iterations) after each; the thesis took 20 on clear wood and 10 on a knot.
        iterations: u32,
        /// Gauss-Seidel sweeps of a step. The thesis leaves open whether its 20 are steps or Stam's 20 sweeps of one.
        sweeps: u32,
    },
    /// Diffusion with the media's own tensor, which keeps energy, as a sum over path lengths.
    Conservative {
        /// Implicit steps from one path length to the next; 1 at least.
        steps: u32,
    },
}

impl SpreadMethod {
    /// Figure 4.23: 20 iterations.
    pub const ON_CLEAR_WOOD: Self = Self::diffusion(20);
    /// Figure 4.24: 10 iterations.
    pub const ON_A_KNOT: Self = Self::diffusion(10);
    /// With four steps each R is within 0.002 of its closed form.
    pub const CONSERVATIVE: Self = Self::Conservative { steps: 4 };

    /// The thesis' diffusion with this many iterations.
    pub const fn diffusion(iterations: u32) -> Self {
        Self::Diffusion { iterations, sweeps: 1 }
    }
}

/// What [`line_response`] needs beside the line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ThesisSettings {
    /// How light is spread.
    pub method: SpreadMethod,
    /// Size of the picture's square pixels [mm].
    pub pitch_mm: f64,
}

/// A picture of light on a surface.
#[derive(Debug, Clone, PartialEq)]
pub struct LightPicture {
    /// Rows along y, row 0 at the smallest y.
    pub rows: usize,
    /// Columns along x.
    pub cols: usize,
    /// Light of each pixel, `[rows, cols]`, row-major; any unit.
    pub light: Vec<f64>,
}

impl LightPicture {
    /// A dark picture.
    pub fn dark(rows: usize, cols: usize) -> Self {
        Self { rows, cols, light: vec![0.0; rows * cols] }
    }
}

/// The light of `picture` after it was spread on `ground`, which must have the picture's size.
///
/// # Panics
/// Where the sizes differ.
pub fn spread(picture: &LightPicture, ground: &PixelGround, method: SpreadMethod) -> LightPicture {
    let map = &ground.map;
    assert_eq!((picture.rows, picture.cols), (map.rows(), map.cols()), "picture and ground have one size");
    match method {
        SpreadMethod::Lines(rule) => line_drawing::spread(picture, map, rule),
        SpreadMethod::Diffusion { iterations, sweeps } => stam::spread(picture, map, iterations, sweeps),
        SpreadMethod::Conservative { steps } => conservative::spread(picture, ground, steps),
    }
}
