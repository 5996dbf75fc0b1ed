//! Projection of the camera: where a point in space is seen on the sensor, and which point of the laser plane a pixel
//! sees.
//!
//! A thin lens at d (0, -sin a, cos a) looks at the origin; its sensor stands v0 behind it, tilted by beta about x. The
//! lens distorts normalised directions ([`optical_bench::lens`]) before they meet the tilted sensor, the order of
//! OpenCV's tilted model:
//!
//! ```text
//! Yc = y cos a + z sin a     Zc = d + y sin a - z cos a     (xn, yn) = (x, Yc) / Zc
//! (xd, yd) = distorted (xn, yn)
//! v = v0 / (1 - tan(beta) yd)     column = c_col + v xd / p     row = c_row - v yd / (p cos beta)
//! ```
//!
//! Exact for every point, off the laser plane too. Neglected: thick lenses, whose nodal points only move the camera,
//! and distortion that depends on the distance of the object.

use optical_bench::lens::Distortion;

/// Position and optics of the camera against the laser plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rig {
    /// Distance from the lens to the origin [mm].
    pub distance: f64,
    /// Angle between the optical axis and the laser plane [rad].
    pub tilt: f64,
    /// Focal length [mm].
    pub focal_length: f64,
    /// Distance from the lens to the sensor along the axis [mm].
    pub image_distance: f64,
    /// Tilt of the sensor about x [rad].
    pub sensor_tilt: f64,
    /// Distortion of the lens.
    pub distortion: Distortion,
    /// Pixel pitch [mm].
    pub pixel: f64,
    /// Sensor column of the optical axis [px].
    pub centre_col: f64,
    /// Sensor row of the optical axis [px].
    pub centre_row: f64,
}

impl Rig {
    /// Magnification at the origin, v0 / d [1].
    pub fn magnification(&self) -> f64 {
        self.image_distance / self.distance
    }

    /// Sensor position (column, row) of a point in space [px]; exact off the laser plane too.
    pub fn project(&self, x: f64, y: f64, z: f64) -> (f64, f64) {
        let (sin, cos) = libm::sincos(self.tilt);
        let yc = y * cos + z * sin;
        let zc = self.distance + y * sin - z * cos;
        let [xd, yd] = self.distortion.distort(x / zc, yc / zc).direction;
        let v = self.image_distance / (1.0 - libm::tan(self.sensor_tilt) * yd);
        let col = self.centre_col + v * xd / self.pixel;
        (col, self.centre_row - v * yd / libm::cos(self.sensor_tilt) / self.pixel)
    }

    /// Height of a point of the laser plane seen in `row`, in the column of the optical axis [mm].
    pub fn height(&self, row: f64) -> f64 {
        self.locate(self.centre_col, row)[1]
    }

    /// Lowest and highest point of the laser plane that a sensor of `columns` and `rows` pixels sees in its corners and
    /// in the middle of its edges [mm].
    pub fn heights(&self, columns: usize, rows: usize) -> (f64, f64) {
        let across = [-0.5, self.centre_col, columns as f64 - 0.5];
        let at = |row: f64| across.map(|col| self.locate(col, row)[1]);
        let (low, high) = (at(rows as f64 - 0.5), at(-0.5));
        (low.into_iter().fold(f64::INFINITY, f64::min), high.into_iter().fold(f64::NEG_INFINITY, f64::max))
    }

    /// The point of the laser plane seen at a position of the sensor: x along the line and height z [mm].
    pub fn locate(&self, col: f64, row: f64) -> [f64; 2] {
        self.back_projection().locate(col, row)
    }

    /// The inverse of [`Self::project`] on the laser plane; to be made once for many pixels.
    pub fn back_projection(&self) -> BackProjection {
        let (sin, cos) = libm::sincos(self.tilt);
        let (lean, upright) = libm::sincos(self.sensor_tilt);
        BackProjection { rig: *self, sin, cos, lean, upright }
    }

    /// Position along the laser line of a point of the laser plane at height `z` seen in `col` [mm].
    pub fn along(&self, col: f64, z: f64) -> f64 {
        let (sin, cos) = libm::sincos(self.tilt);
        let zc = self.distance - z * cos;
        let yn = z * sin / zc;
        let lean = libm::tan(self.sensor_tilt);
        let wanted = (col - self.centre_col) * self.pixel / self.image_distance;
        self.distortion.seen_in_column(wanted, lean, yn) * zc
    }

    /// Lines of sight of `columns` columns in the laser plane between the conveyor and `top` [mm].
    pub(crate) fn sightlines(&self, columns: usize, top: f64) -> Sightlines {
        // Cubic through the exact positions at Chebyshev's four heights, by divided differences.
        let (middle, half) = (0.5 * top, 0.55 * top.abs().max(1.0));
        let heights = [1.0, 3.0, 5.0, 7.0].map(|i| middle + half * libm::cos(std::f64::consts::PI * i / 8.0));
        let lines = (0..columns).map(|column| cubic(heights, heights.map(|z| self.along(column as f64, z)))).collect();
        Sightlines(lines)
    }
}

/// The coefficients of 1, z, z^2 and z^3 of the polynomial through four points.
fn cubic(z: [f64; 4], x: [f64; 4]) -> [f64; 4] {
    let mut d = x;
    for order in 1..4 {
        for i in (order..4).rev() {
            d[i] = (d[i] - d[i - 1]) / (z[i] - z[i - order]);
        }
    }
    // From Newton's form to powers.
    let mut c = [d[3], 0.0, 0.0, 0.0];
    for i in (0..3).rev() {
        c = [d[i] - z[i] * c[0], c[0] - z[i] * c[1], c[1] - z[i] * c[2], c[2] - z[i] * c[3]];
    }
    c
}

/// From pixels of the sensor to points of the laser plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BackProjection {
    rig: Rig,
    sin: f64,
    cos: f64,
    lean: f64,
    upright: f64,
}

impl BackProjection {
    /// The point of the laser plane seen at a position of the sensor: x along the line and height z [mm].
    #[inline]
    pub fn locate(&self, col: f64, row: f64) -> [f64; 2] {
        let rig = &self.rig;
        let s = (rig.centre_row - row) * rig.pixel;
        let v = rig.image_distance + s * self.lean;
        let distorted = [(col - rig.centre_col) * rig.pixel / v, s * self.upright / v];
        let [xn, yn] = rig.distortion.undistort(distorted);
        let z = yn * rig.distance / (self.sin + yn * self.cos);
        [xn * (rig.distance - z * self.cos), z]
    }
}

/// Line of sight of each column in the laser plane: x as a cubic of the height, exact for a lens without distortion.
#[derive(Debug, Clone, PartialEq)]
pub struct Sightlines(Vec<[f64; 4]>);

impl Sightlines {
    /// Number of columns.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Lines of sight between each of `places`, a column and how far on the way to the next one it is.
    pub(crate) fn between(&self, places: impl Iterator<Item = (usize, f32)>) -> Self {
        let part = |(column, part): (usize, f32)| {
            let (from, to, part) = (self.0[column], self.0[column + 1], f64::from(part));
            std::array::from_fn(|i| from[i] + part * (to[i] - from[i]))
        };
        Self(places.map(part).collect())
    }

    /// The line of sight of `column`.
    #[inline(always)]
    pub fn of(&self, column: usize) -> Sightline {
        Sightline(self.0[column])
    }
}

/// x along the laser line that one column sees, by height.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sightline([f64; 4]);

impl Sightline {
    /// x at height `z` [mm].
    #[inline(always)]
    pub fn at(&self, z: f32) -> f32 {
        let ([a, b, c, d], z) = (self.0, f64::from(z));
        (a + z * (b + z * (c + z * d))) as f32
    }

    /// dx/dz at height `z` [1].
    #[inline(always)]
    pub fn lean(&self, z: f32) -> f32 {
        let ([_, b, c, d], z) = (self.0, f64::from(z));
        (b + z * (2.0 * c + z * 3.0 * d)) as f32
    }
}
