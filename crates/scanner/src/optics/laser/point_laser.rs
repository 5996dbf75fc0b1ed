//! Point laser: a round Gaussian spot instead of a line, stepped along the line from profile to profile.
//!
//! The pencil comes from the apex of the fan, as from a scanning mirror: at height z it stands at x h / H, and is
//! longer along the line than across it where it comes in at a slant, by 1 / cos(theta) (4 % at 16 degrees). A column
//! gets the part of the Gaussian that falls on its own width, by the error function. All of the power is in the spot.
//! Neglected: that its far half is a little wider than its near one.

use optical_bench::parameters::LaserParameters;

/// Standard deviations of the spot beyond which a column gets no light [1].
const REACH_SIGMAS: f32 = 6.5;

/// Position of the spot by profile.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PointLaser {
    /// Position in profile 0 [mm].
    start: f64,
    /// Advance per profile [mm].
    step: f64,
    /// Length within which the position wraps around [mm].
    span: f64,
}

impl PointLaser {
    /// The point laser of a bench.
    pub fn new(bench: &LaserParameters) -> Self {
        Self { start: bench.point_x_mm, step: bench.point_step_mm, span: bench.point_span_mm }
    }

    /// Position at the conveyor in a profile [mm].
    pub fn x(&self, profile: isize) -> f64 {
        let travelled = 0.5 * self.span + profile as f64 * self.step;
        self.start + (travelled - (travelled / self.span).floor() * self.span) - 0.5 * self.span
    }

    /// Share of the light in a column `width` wide whose middle lies `off` from the spot's; `sigma` along the line [1].
    pub fn share(&self, off: f32, sigma: f32, width: f32) -> f32 {
        if off.abs() > REACH_SIGMAS * sigma + width {
            return 0.0;
        }
        let per = std::f64::consts::FRAC_1_SQRT_2 / f64::from(sigma);
        let half = 0.5 * f64::from(width);
        (0.5 * (libm::erf((f64::from(off) + half) * per) - libm::erf((f64::from(off) - half) * per))) as f32
    }
}
