//! Slant: surfaces that rise along the laser line.
//!
//! A column's ray sweeps over such a surface in a plane, from which brightness and scale follow. With dz = m dx + s dy
//! on the surface, k = cos(a) + tan(beta) sin(a), d' the lens's distance along its axis less tan(beta) times the height
//! over it, and q rows per mm of height:
//!
//! ```text
//! light        (1 + m tan(theta)) / e,     e = 1 + m x k / d'
//! rows per mm  + m q dx/dy,                dx/dy = x (sin(a) - tan(beta) cos(a) - s k) / (d' e)
//! variance     + r^2 (1/12 + blur),        r = m q width of the column / e
//! ```
//!
//! A column is as wide as a pixel and the lens blurs light of its neighbours into it; their lines lie r rows away,
//! which smears the column's own line by exactly that variance. And it looks along a slant, so that light before and
//! behind the line's middle comes from other heights. Held by tests/reference/expose_parts.rs. Neglected: distortion of
//! the lens; walls that end within a column, and what they smear beyond [`MAX_SMEAR_ROWS`].

use super::projection::{PIXEL_VARIANCE, Projection};
use crate::optics::laser::Laser;

/// Least foreshortening along the line of a surface that rises away from the lens [1].
const MIN_FORESHORTENING: f32 = 0.1;
/// Most rows from column to column that smear a line: 84 degrees in the middle of the default bench [px].
const MAX_SMEAR_ROWS: f32 = 4.0;

/// Effect of a slope along the line on the image of a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Slant {
    /// Light of the column over that on a level surface; nearly 1 where laser and lens are equally high [1].
    pub light: f32,
    /// Additional rows per mm along the motion [px/mm].
    pub rate: f32,
    /// Variance of the line per variance along the line [1].
    pub smear: f32,
}

impl Slant {
    const NONE: Self = Self { light: 1.0, rate: 0.0, smear: 0.0 };

    /// Variance by which a column with the blur `variance` along the line is smeared [px^2].
    #[inline]
    pub fn variance(&self, variance: f32) -> f32 {
        self.smear * (PIXEL_VARIANCE + variance)
    }

    /// At the point `x`, `z` of a surface that rises by `slope_x` along the line and `slope_y` along the motion, where
    /// a column is `column_mm` wide.
    #[inline]
    pub fn new(
        projection: &Projection,
        laser: &Laser,
        [x, z]: [f32; 2],
        [slope_x, slope_y]: [f32; 2],
        column_mm: f32,
    ) -> Self {
        if slope_x == 0.0 {
            return Self::NONE;
        }
        let Projection { scale, sin, cos, tan_beta, distance } = *projection;
        let bottom = distance - z * cos - tan_beta * z * sin;
        let up = cos + tan_beta * sin;
        let seen = (1.0 + slope_x * x * up / bottom).max(MIN_FORESHORTENING);
        let rise = slope_x / seen * scale * sin * distance / (bottom * bottom);
        let rows = (rise * column_mm).abs().min(MAX_SMEAR_ROWS);
        Self {
            light: laser.slope_factor(x, z, slope_x) / seen,
            rate: rise * x * (sin - tan_beta * cos - slope_y * up) / bottom,
            smear: rows * rows,
        }
    }
}
