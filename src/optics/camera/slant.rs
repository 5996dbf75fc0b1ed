//! Surfaces that rise along the line.

use super::Camera;

/// A surface that rises away from the lens is never seen more stretched along the line than this [1].
const LEAST_SEEN: f32 = 0.1;

impl Camera {
    /// Light of a column on a surface that rises by `slope_x` along the line over that on a level one: the fan meets it
    /// more or less straight, and the column sees more or less of it. Nearly 1 where laser and lens are equally high [1].
    #[inline]
    pub fn slant(&self, x: f32, z: f32, slope_x: f32) -> f32 {
        let [_, sin, cos, tan_beta, distance] = self.row;
        let bottom = distance - z * cos - tan_beta * z * sin;
        let seen = 1.0 + slope_x * x * (cos + tan_beta * sin) / bottom;
        self.laser.slant(x, z, slope_x) / seen.max(LEAST_SEEN)
    }
}
