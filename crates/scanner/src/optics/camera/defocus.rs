//! Defocus: the circle of confusion of a point that is out of focus.
//!
//! Thin lens, geometrical optics: light of a point at depth Zc meets at v_img = f Zc / (Zc - f) behind the lens; on the
//! way it fills a cone over the pupil D, from which the sensor at v cuts a disc of
//!
//! ```text
//! c = D |v_img - v| / v_img,     variance of its projection c^2 / 16 along every direction
//! ```
//!
//! (Born and Wolf 1999, section 4.8), the circle of confusion. A tilted sensor stretches the disc along the rows by v /
//! (v0 cos beta), exact to first order in c. A laser plane in focus has c = 0; light that leaves matter a mm off the
//! plane has 3 um, which is 1e-4 of what its own spread takes on the sensor and is left out. The line's profile takes
//! the disc as it is (`circle_of_confusion`), and by its variance where it is small. Neglected: the lens's mounts cut
//! the disc at the field's edge (cat's eye); colour.

/// Lens and sensor as far as defocus depends on them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Defocus {
    /// Diameter of the pupil [mm].
    pub pupil: f32,
    /// Focal length [mm].
    pub focal_length: f32,
    /// From the lens to the sensor along the axis [mm].
    pub image_distance: f32,
    /// Cosine of the sensor's tilt [1].
    pub upright: f32,
    /// Pixel pitch [mm].
    pub pixel: f32,
}

impl Defocus {
    /// Diameter of the circle of confusion, at right angles to the axis, of a point at depth `zc` whose light meets the
    /// sensor at `stretch` times the image distance on the axis [mm].
    #[inline]
    pub fn circle_of_confusion(&self, zc: f32, stretch: f32) -> f32 {
        let f = self.focal_length;
        self.pupil * (1.0 - self.image_distance * stretch * (zc - f) / (f * zc)).abs()
    }

    /// Variances of the circle of confusion along columns and along rows [px^2].
    #[inline]
    pub fn variances(&self, zc: f32, stretch: f32) -> [f32; 2] {
        let c = self.circle_of_confusion(zc, stretch) / (4.0 * self.pixel);
        let rows = c * stretch / self.upright;
        [c * c, rows * rows]
    }
}
