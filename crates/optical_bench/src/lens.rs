//! Lens formulae: image distance, Scheimpflug's condition, distortion.
//!
//! A thin lens of focal length f images a point at distance d sharply at v = f d / (d - f). Distortion (Conrady 1919,
//! Brown 1971) acts on normalised directions (x, y) = (X, Y) / Z in the frame of the lens; its inverse is found by
//! Newton's method from the undistorted direction. Neglected: thick lenses, distortion that depends on the distance of
//! the object.

/// Most steps of Newton's method; from the undistorted direction five reach the last bit.
const MAX_NEWTON_STEPS: usize = 12;
/// Step of a direction below which Newton's method ends [1].
const NEWTON_TOLERANCE: f64 = 1e-13;

/// Image distance: how far behind a lens of `focal_length` a point `distance` before it is sharp [mm].
pub fn image_distance(focal_length: f64, distance: f64) -> f64 {
    focal_length * distance / (distance - focal_length)
}

/// Scheimpflug's condition: tilt of a sensor whose plane of focus is the laser plane, tan(beta) = m cot(a) with
/// m = f / (d - f); `tilt` is the angle a between the optical axis and the laser plane [rad].
pub fn scheimpflug(focal_length: f64, distance: f64, tilt: f64) -> f64 {
    libm::atan(focal_length / (distance - focal_length) / libm::tan(tilt))
}

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

/// A distorted direction and its derivatives by the undistorted one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DistortedDirection {
    /// The distorted direction [1].
    pub direction: [f64; 2],
    /// dx'/dx, dx'/dy = dy'/dx, dy'/dy [1].
    pub slopes: [f64; 3],
}

impl Distortion {
    /// Whether the lens is free of distortion.
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }

    /// The direction that the lens makes of (x, y).
    #[inline]
    pub fn distort(&self, x: f64, y: f64) -> DistortedDirection {
        let ([k1, k2, k3], [p1, p2]) = (self.radial, self.tangential);
        let r2 = x * x + y * y;
        let gain = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
        let rise = k1 + r2 * (2.0 * k2 + r2 * 3.0 * k3);
        let direction = [
            x * gain + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
            y * gain + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y,
        ];
        let slopes = [
            gain + 2.0 * x * x * rise + 2.0 * p1 * y + 6.0 * p2 * x,
            2.0 * (x * y * rise + p1 * x + p2 * y),
            gain + 2.0 * y * y * rise + 6.0 * p1 * y + 2.0 * p2 * x,
        ];
        DistortedDirection { direction, slopes }
    }

    /// The x of the direction of height `y` [1] that a column looks at whose image of it lies at `wanted` [1] on a
    /// sensor that leans by the slope `lean`: x' / (1 - lean y') = wanted.
    pub fn seen_in_column(&self, wanted: f64, lean: f64, y: f64) -> f64 {
        // Without distortion the start is exact.
        let mut x = wanted * (1.0 - lean * y);
        if !self.is_none() {
            for _ in 0..MAX_NEWTON_STEPS {
                let DistortedDirection { direction: [xd, yd], slopes: [a, b, _] } = self.distort(x, y);
                let bottom = 1.0 - lean * yd;
                let step = (wanted - xd / bottom) / ((a * bottom + xd * lean * b) / (bottom * bottom));
                x += step;
                if step.abs() < NEWTON_TOLERANCE {
                    break;
                }
            }
        }
        x
    }

    /// The direction that the lens distorts to `distorted`.
    #[inline]
    pub fn undistort(&self, distorted: [f64; 2]) -> [f64; 2] {
        if self.is_none() {
            return distorted;
        }
        let [mut x, mut y] = distorted;
        for _ in 0..MAX_NEWTON_STEPS {
            let DistortedDirection { direction, slopes: [a, b, c] } = self.distort(x, y);
            let (off_x, off_y) = (distorted[0] - direction[0], distorted[1] - direction[1]);
            let determinant = a * c - b * b;
            let (step_x, step_y) = ((c * off_x - b * off_y) / determinant, (a * off_y - b * off_x) / determinant);
            (x, y) = (x + step_x, y + step_y);
            if step_x.abs() + step_y.abs() < NEWTON_TOLERANCE {
                break;
            }
        }
        [x, y]
    }

    /// Upper bound of the change of a distorted direction of length `r` with the undistorted one, whatever the signs of
    /// the coefficients; below 1 the distortion is invertible and [`Self::undistort`] converges [1].
    pub fn strain(&self, r: f64) -> f64 {
        let ([k1, k2, k3], [p1, p2]) = (self.radial.map(f64::abs), self.tangential.map(f64::abs));
        let r2 = r * r;
        r2 * (3.0 * k1 + r2 * (5.0 * k2 + r2 * 7.0 * k3)) + 8.0 * r * (p1 + p2)
    }
}
