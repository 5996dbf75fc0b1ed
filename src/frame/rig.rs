//! Where a point in space is seen on the sensor, and where the laser plane is seen from a pixel.
//!
//! A lens without thickness at d (0, -sin a, cos a) looks at the origin; its sensor stands v0 behind it, tilted by beta
//! about x. Distortion (Brown 1971, Conrady 1919) bends the normalised directions before they meet the tilted sensor, the
//! order that OpenCV's tilted model has:
//!
//! ```text
//! Yc = y cos a + z sin a     Zc = d + y sin a - z cos a     (xn, yn) = (x, Yc) / Zc
//! (xd, yd) = distorted (xn, yn)
//! v = v0 / (1 - tan(beta) yd)     column = c_col + v xd / p     row = c_row - v yd / (p cos beta)
//! ```
//!
//! Exact for every point, off the laser plane too. Neglected: thick lenses, whose nodal points only move the stand, and
//! distortion that depends on the distance of the object.

/// Most steps of Newton's way; from the straight direction five reach the last bit.
const STEPS: usize = 12;
/// A step that ends it [1].
const STILL: f64 = 1e-13;

/// Distortion by Brown and Conrady of normalised directions (x, y), r^2 = x^2 + y^2.
///
/// x' = x (1 + k1 r^2 + k2 r^4 + k3 r^6) + 2 p1 x y + p2 (r^2 + 2 x^2), and y' with p1 and p2 in each other's place.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Distortion {
    /// k1, k2, k3: radial [1].
    pub radial: [f64; 3],
    /// p1, p2: tangential [1].
    pub tangential: [f64; 2],
}

/// A distorted direction and how it turns with the straight one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bent {
    /// The distorted direction [1].
    pub to: [f64; 2],
    /// dx'/dx, dx'/dy = dy'/dx, dy'/dy [1].
    pub slopes: [f64; 3],
}

impl Distortion {
    /// Whether nothing is bent.
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }

    /// Where the direction (x, y) goes.
    #[inline]
    pub fn bend(&self, x: f64, y: f64) -> Bent {
        let ([k1, k2, k3], [p1, p2]) = (self.radial, self.tangential);
        let r2 = x * x + y * y;
        let gain = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
        let rise = k1 + r2 * (2.0 * k2 + r2 * 3.0 * k3);
        let to = [
            x * gain + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
            y * gain + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y,
        ];
        let slopes = [
            gain + 2.0 * x * x * rise + 2.0 * p1 * y + 6.0 * p2 * x,
            2.0 * (x * y * rise + p1 * x + p2 * y),
            gain + 2.0 * y * y * rise + 6.0 * p1 * y + 2.0 * p2 * x,
        ];
        Bent { to, slopes }
    }

    /// The straight direction that is bent to `to`.
    #[inline]
    pub fn straighten(&self, to: [f64; 2]) -> [f64; 2] {
        if self.is_none() {
            return to;
        }
        let [mut x, mut y] = to;
        for _ in 0..STEPS {
            let Bent { to: at, slopes: [a, b, c] } = self.bend(x, y);
            let (off_x, off_y) = (to[0] - at[0], to[1] - at[1]);
            let whole = a * c - b * b;
            let (step_x, step_y) = ((c * off_x - b * off_y) / whole, (a * off_y - b * off_x) / whole);
            (x, y) = (x + step_x, y + step_y);
            if step_x.abs() + step_y.abs() < STILL {
                break;
            }
        }
        [x, y]
    }

    /// Most by which a direction of length `r` can be turned or stretched, the same for all of its coefficients' signs;
    /// below 1 no two directions meet, so that [`Self::straighten`] finds its way [1].
    pub fn strain(&self, r: f64) -> f64 {
        let ([k1, k2, k3], [p1, p2]) = (self.radial.map(f64::abs), self.tangential.map(f64::abs));
        let r2 = r * r;
        r2 * (3.0 * k1 + r2 * (5.0 * k2 + r2 * 7.0 * k3)) + 8.0 * r * (p1 + p2)
    }
}

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

/// How far behind a lens of `focal_length` what stands `distance` before it is sharp [mm].
pub fn image_distance(focal_length: f64, distance: f64) -> f64 {
    focal_length * distance / (distance - focal_length)
}

/// Tilt of a sensor whose plane of focus is the laser plane, tan(beta) = m cot(a) with m = f / (d - f): the rule of
/// Scheimpflug; `tilt` and the answer in rad.
pub fn scheimpflug(focal_length: f64, distance: f64, tilt: f64) -> f64 {
    libm::atan(focal_length / (distance - focal_length) / libm::tan(tilt))
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
        let [xd, yd] = self.distortion.bend(x / zc, yc / zc).to;
        let v = self.image_distance / (1.0 - libm::tan(self.sensor_tilt) * yd);
        let col = self.centre_col + v * xd / self.pixel;
        (col, self.centre_row - v * yd / libm::cos(self.sensor_tilt) / self.pixel)
    }

    /// Height of a point of the laser plane seen in `row`, in the column of the optical axis [mm].
    pub fn height(&self, row: f64) -> f64 {
        self.locate(self.centre_col, row)[1]
    }

    /// Lowest and highest point of the laser plane that a sensor of `columns` and `rows` pixels sees in its corners and in
    /// the middle of its edges [mm].
    pub fn heights(&self, columns: usize, rows: usize) -> (f64, f64) {
        let across = [-0.5, self.centre_col, columns as f64 - 0.5];
        let at = |row: f64| across.map(|col| self.locate(col, row)[1]);
        let (low, high) = (at(rows as f64 - 0.5), at(-0.5));
        (low.into_iter().fold(f64::INFINITY, f64::min), high.into_iter().fold(f64::NEG_INFINITY, f64::max))
    }

    /// Where the laser plane is seen at a place of the sensor: x along the line and height z [mm].
    pub fn locate(&self, col: f64, row: f64) -> [f64; 2] {
        self.reading().locate(col, row)
    }

    /// What [`Self::locate`] works with; to be made once for many places.
    pub fn reading(&self) -> Reading {
        let (sin, cos) = libm::sincos(self.tilt);
        let (lean, upright) = libm::sincos(self.sensor_tilt);
        Reading { rig: *self, sin, cos, lean, upright }
    }

    /// Position along the laser line of a point of the laser plane at height `z` seen in `col` [mm].
    pub fn along(&self, col: f64, z: f64) -> f64 {
        let (sin, cos) = libm::sincos(self.tilt);
        let zc = self.distance - z * cos;
        let yn = z * sin / zc;
        let lean = libm::tan(self.sensor_tilt);
        let wanted = (col - self.centre_col) * self.pixel / self.image_distance;
        // Newton's way to the direction whose distorted x the column looks at; without distortion it is there at once.
        let mut xn = wanted * (1.0 - lean * yn);
        if !self.distortion.is_none() {
            for _ in 0..STEPS {
                let Bent { to: [xd, yd], slopes: [a, b, _] } = self.distortion.bend(xn, yn);
                let bottom = 1.0 - lean * yd;
                let step = (wanted - xd / bottom) / ((a * bottom + xd * lean * b) / (bottom * bottom));
                xn += step;
                if step.abs() < STILL {
                    break;
                }
            }
        }
        xn * zc
    }

    /// What `columns` columns look at between the conveyor and `top` [mm].
    pub fn columns(&self, columns: usize, top: f64) -> Columns {
        // Cubic through the exact places at Chebyshev's four heights, by divided differences.
        let (middle, half) = (0.5 * top, 0.55 * top.abs().max(1.0));
        let heights = [1.0, 3.0, 5.0, 7.0].map(|i| middle + half * libm::cos(std::f64::consts::PI * i / 8.0));
        let lines = (0..columns).map(|column| cubic(heights, heights.map(|z| self.along(column as f64, z)))).collect();
        Columns(lines)
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

/// Places of the sensor turned into places of the laser plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    rig: Rig,
    sin: f64,
    cos: f64,
    lean: f64,
    upright: f64,
}

impl Reading {
    /// Where the laser plane is seen at a place of the sensor: x along the line and height z [mm].
    #[inline]
    pub fn locate(&self, col: f64, row: f64) -> [f64; 2] {
        let rig = &self.rig;
        let s = (rig.centre_row - row) * rig.pixel;
        let v = rig.image_distance + s * self.lean;
        let bent = [(col - rig.centre_col) * rig.pixel / v, s * self.upright / v];
        let [xn, yn] = rig.distortion.straighten(bent);
        let z = yn * rig.distance / (self.sin + yn * self.cos);
        [xn * (rig.distance - z * self.cos), z]
    }

    /// Numbers A, B, C with z = A s / (B + C s), s = centre row - row: heights for a lens without distortion.
    pub fn straight(&self) -> [f64; 3] {
        let rig = &self.rig;
        let (rise, pitch) = (self.upright * self.cos + self.lean * self.sin, rig.pixel);
        [pitch * self.upright * rig.distance, rig.image_distance * self.sin, pitch * rise]
    }
}

/// Where each column looks in the laser plane: x as a cubic of the height, exact for a lens without distortion.
#[derive(Debug, Clone, PartialEq)]
pub struct Columns(Vec<[f64; 4]>);

impl Columns {
    /// Number of columns.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
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
