//! A point laser: a round Gaussian spot instead of a line, stepped along the line from profile to profile.
//!
//! The pencil comes from where the fan would, as from a mirror that turns: at height z it stands at x h / H, and is longer
//! along the line than across it where it comes in at a slant, by 1 / cos(theta) (4 % at 16 degrees). A column gets what of
//! the Gaussian falls on its own width, by the error function. All of the power is in the spot. Neglected: that its far half
//! is a little wider than its near one.

use crate::optics::parameters::Laser;

/// Standard deviations beyond which a column gets nothing.
const REACH: f32 = 6.5;

/// Where the spot stands.
#[derive(Debug, Clone, Copy)]
pub struct Spot {
    /// In profile 0 [mm], each further profile [mm], and the length that it goes round in [mm].
    start: f64,
    step: f64,
    span: f64,
}

impl Spot {
    /// The spot of a bench.
    pub fn new(bench: &Laser) -> Self {
        Self { start: bench.point_x_mm, step: bench.point_step_mm, span: bench.point_span_mm }
    }

    /// Where it stands at the conveyor in a profile [mm].
    pub fn x(&self, profile: isize) -> f64 {
        let way = 0.5 * self.span + profile as f64 * self.step;
        self.start + (way - (way / self.span).floor() * self.span) - 0.5 * self.span
    }

    /// Share of its light in a column `width` wide, `off` from its middle; `sigma` along the line [1].
    pub fn share(&self, off: f32, sigma: f32, width: f32) -> f32 {
        if off.abs() > REACH * sigma + width {
            return 0.0;
        }
        let per = std::f64::consts::FRAC_1_SQRT_2 / f64::from(sigma);
        let half = 0.5 * f64::from(width);
        (0.5 * (libm::erf((f64::from(off) + half) * per) - libm::erf((f64::from(off) - half) * per))) as f32
    }
}
