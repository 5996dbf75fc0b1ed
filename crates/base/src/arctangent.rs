//! The angle of a vector in plain arithmetic: fast, and the same bits on every CPU, which the system's is not.

use std::f32::consts::{FRAC_PI_2, PI};

/// Coefficients of t^2, t^4, ... in atan(t) / t on [-1, 1]; error 2e-8 (Abramowitz and Stegun 1964, 4.4.49).
const SERIES: [f32; 8] = [
    -0.333_331_45,
    0.199_935_51,
    -0.142_088_99,
    0.106_562_64,
    -0.075_289_64,
    0.042_909_614,
    -0.016_165_737,
    0.002_866_225_7,
];

/// Angle of (x, y) from the x axis, in (-pi, pi]; absolute error under 4e-7, and 0 or pi at the origin [rad].
#[inline]
pub fn atan2(y: f32, x: f32) -> f32 {
    let (across, along) = (y.abs(), x.abs());
    let t = across.min(along) / across.max(along).max(f32::MIN_POSITIVE);
    let q = t * t;
    let series = SERIES.iter().rev().fold(0.0, |sum, c| (sum + c) * q);
    let octant = t + t * series;
    let quadrant = if across > along { FRAC_PI_2 - octant } else { octant };
    let half = if x < 0.0 { PI - quadrant } else { quadrant };
    half.copysign(y)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_the_angle() {
        for i in -20_000..=20_000 {
            let angle = f64::from(i) * std::f64::consts::PI / 20_000.0;
            for radius in [1.0e-20, 0.3, 1.0, 250.0] {
                let (y, x) = ((radius * angle.sin()) as f32, (radius * angle.cos()) as f32);
                let truth = f64::from(y).atan2(f64::from(x));
                assert!((f64::from(atan2(y, x)) - truth).abs() < 4.0e-7, "{y} {x}");
            }
        }
        assert_eq!((atan2(0.0, 0.0), atan2(0.0, 1.0), atan2(0.0, -1.0)), (0.0, 0.0, PI));
        assert_eq!((atan2(1.0, 0.0), atan2(-1.0, 0.0)), (FRAC_PI_2, -FRAC_PI_2));
    }
}
