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

use glam::DVec2;

mod conservative;
mod direction_map;
mod line_drawing;
mod line_response;
mod pixel_ground;
mod stam;
#[cfg(test)]
mod tests;

pub use self::direction_map::DirectionMap;
pub(crate) use self::line_drawing::LineRule;
pub use self::line_response::{LaserPoint, line_response, point};
pub use self::pixel_ground::{PixelGround, PlanarDiffusion, alpha};

/// How light is spread. The defaults of each are [`SpreadMethod::BRESENHAM`] and its kin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SpreadMethod {
    /// Along y = k x + m, with steps of one pixel in x.
    LinearEquation {
        /// Length of the line on either side of a lit pixel where alpha is 1 [px].
        reach: u32,
    },
    /// Along lines that share each step between two pixels.
    AntiAliased {
        /// As above [px].
        reach: u32,
    },
    /// Along Bresenham's lines.
    Bresenham {
        /// As above [px].
        reach: u32,
    },
    /// Stam's implicit diffusion with eight neighbours and coefficients of the receiving pixel alone.
    Diffusion {
        /// Time steps, alpha^(1 / iterations) after each; the thesis took 20 on clear wood and 10 on a knot.
        iterations: u32,
        /// Gauss-Seidel sweeps of a step. The thesis leaves open whether its 20 are steps or Stam's 20 sweeps of one.
        sweeps: u32,
        /// Sum of a pixel's eight coefficients [1].
        rate: f64,
        /// Power p of the squared cosine between neighbour and fibre to which coefficients are proportional.
        sharpness: u32,
    },
    /// Diffusion with the media's own tensor, which keeps energy, as a sum over path lengths.
    Conservative {
        /// Path lengths, in equal ratios from 0.003 to 200 mm; 2 at least.
        paths: u32,
        /// Implicit steps from one path length to the next; 1 at least.
        steps: u32,
    },
}

impl SpreadMethod {
    /// Straight lines with a reach of 20 pixels (our choice).
    pub const LINEAR_EQUATION: Self = Self::LinearEquation { reach: 20 };
    /// Smooth lines with a reach of 20 pixels (our choice).
    pub const ANTI_ALIASED: Self = Self::AntiAliased { reach: 20 };
    /// Bresenham's lines with a reach of 20 pixels (our choice).
    pub const BRESENHAM: Self = Self::Bresenham { reach: 20 };
    /// Figure 4.23: 20 iterations. With cos^6 the variances along and across fibres in line with the pixels are as 5 to
    /// 1, like clear wood's diffusion; the sum of coefficients, 8, is eight times one (our choices).
    pub const ON_CLEAR_WOOD: Self = Self::Diffusion { iterations: 20, sweeps: 1, rate: 8.0, sharpness: 3 };
    /// Figure 4.24: 10 iterations.
    pub const ON_A_KNOT: Self = Self::Diffusion { iterations: 10, sweeps: 1, rate: 8.0, sharpness: 3 };
    /// The thesis' diffusion with this many iterations.
    pub fn diffusion(iterations: u32) -> Self {
        Self::Diffusion { iterations, sweeps: 1, rate: 8.0, sharpness: 3 }
    }

    /// The conservative stencil with this many implicit steps from one path length to the next.
    pub fn conservative(steps: u32) -> Self {
        Self::Conservative { paths: 16, steps }
    }

    /// With 16 path lengths and four steps each R is within 0.002 of its closed form.
    pub const CONSERVATIVE: Self = Self::Conservative { paths: 16, steps: 4 };
}

/// What [`line_response`] needs beside the line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ThesisSettings {
    /// How light is spread.
    pub method: SpreadMethod,
    /// Size of the picture's square pixels [mm].
    pub pitch_mm: f64,
    /// What the picture shows beyond the wanted cells, on each side [mm].
    pub margin_mm: f64,
    /// Light that clear wood returns of what entered, for all methods but [`SpreadMethod::Conservative`], which knows
    /// it [1].
    pub returned: f64,
}

impl Default for ThesisSettings {
    /// The thesis' diffusion on pixels of 0.05 mm, half a row of the reference camera; all light comes back.
    fn default() -> Self {
        Self { method: SpreadMethod::ON_CLEAR_WOOD, pitch_mm: 0.05, margin_mm: 2.0, returned: 1.0 }
    }
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

    /// All light together.
    pub fn sum(&self) -> f64 {
        self.light.iter().sum()
    }

    /// Centre of the light as (column, row) [px].
    pub fn centre(&self) -> DVec2 {
        self.mean(|at| at)
    }

    /// Variances along x and y, and the covariance between them [px^2].
    pub fn variance(&self) -> (DVec2, f64) {
        let centre = self.centre();
        let squares = self.mean(|at| (at - centre) * (at - centre));
        let product = self.mean(|at| DVec2::new((at.x - centre.x) * (at.y - centre.y), 0.0));
        (squares, product.x)
    }

    fn mean(&self, of: impl Fn(DVec2) -> DVec2) -> DVec2 {
        let place = |i: usize| DVec2::new((i % self.cols) as f64, (i / self.cols) as f64);
        let sum = self.light.iter().enumerate().fold(DVec2::ZERO, |sum, (i, &light)| sum + of(place(i)) * light);
        sum / self.sum()
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
        SpreadMethod::LinearEquation { reach } => line_drawing::spread(picture, map, LineRule::LinearEquation, reach),
        SpreadMethod::AntiAliased { reach } => line_drawing::spread(picture, map, LineRule::AntiAliased, reach),
        SpreadMethod::Bresenham { reach } => line_drawing::spread(picture, map, LineRule::Bresenham, reach),
        SpreadMethod::Diffusion { iterations, sweeps, rate, sharpness } => {
            stam::spread(picture, map, iterations, sweeps, &stam::coefficients(map, rate, sharpness))
        }
        SpreadMethod::Conservative { paths, steps } => {
            conservative::spread(picture, ground, paths.max(2), steps.max(1))
        }
    }
}
