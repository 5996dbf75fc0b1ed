//! Projection of the camera without distortion, in single precision.
//!
//! With the depth Zc and the height Yc over the optical axis of a point (y, z), as in [`crate::frame::Rig`]:
//!
//! ```text
//! Zc = d + y sin a - z cos a,    Yc = y cos a + z sin a,    row = c_row - scale Yc / (Zc - tan(beta) Yc)
//! ```

/// Variance of a pixel's box along rows or columns [px^2].
pub(crate) const PIXEL_VARIANCE: f32 = 1.0 / 12.0;

/// Coefficients of the projection.
#[derive(Debug, Clone, Copy)]
pub(super) struct Projection {
    /// v0 / (cos(beta) pixel) [px].
    pub scale: f32,
    /// Sine of the angle a between optical axis and laser plane [1].
    pub sin: f32,
    /// Cosine of that angle [1].
    pub cos: f32,
    /// Tangent of the sensor's tilt [1].
    pub tan_beta: f32,
    /// From the lens to the origin, d [mm].
    pub distance: f32,
}

impl Projection {
    /// Depth Zc of a point before the lens, and Zc - tan(beta) Yc [mm].
    #[inline]
    pub fn depth(&self, y: f32, z: f32) -> [f32; 2] {
        let Self { sin, cos, tan_beta, distance, .. } = *self;
        let zc = distance + y * sin - z * cos;
        [zc, zc - tan_beta * (y * cos + z * sin)]
    }
}
