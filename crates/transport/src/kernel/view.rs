//! Radiance factors towards a view, of cone light and of the rest.
//!
//! Cone light keeps its angle to the fibre. For light from above and fibres f that dive by d, with v' the direction
//! inside that refraction turns into the view v, it would leave where c = v' . f - sin(d) is 0; dispersion blurs that.
//! Fitted to what Monte Carlo measures, with s the part of v along the fibre's track (positive on its diving side), x the
//! part across it and u its height:
//!
//! ```text
//! cone light   exp( a0 + a1 c + a2 c^2 + a3 (1 - u) )
//! the rest     b0 + b1 s + b2 s^2 + b3 x^2
//! ```
//!
//! A Lambertian surface has 1 everywhere.

use super::table::VIEWS;

/// Logarithms of radiance factors of cone light are kept between these [1].
const CONE_LOGARITHM_RANGE: (f32, f32) = (-12.0, 2.5);

/// Coordinates of a view: (c, s, u).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// Change of the cosine to the fibre [1].
    pub cone: f32,
    /// Along the fibre's track, towards its diving end [1].
    pub along: f32,
    /// Cosine against the normal [1].
    pub up: f32,
}

impl View {
    /// A view with part `along` and `up` onto matter of index `n` with fibres of sine of dive `sin_dive`.
    #[inline(always)]
    pub fn new(along: f32, up: f32, n: f32, sin_dive: f32) -> Self {
        let inside = (1.0 - (1.0 - up * up) / (n * n)).max(0.0).sqrt();
        let cos_dive = (1.0 - sin_dive * sin_dive).max(0.0).sqrt();
        Self { cone: along / n * cos_dive - inside * sin_dive - sin_dive, along, up }
    }

    /// Terms that the coefficients of cone light multiply.
    #[inline(always)]
    pub fn cone_terms(self) -> [f32; 4] {
        [1.0, self.cone, self.cone * self.cone, 1.0 - self.up]
    }

    /// Terms that the coefficients of the rest multiply.
    #[inline(always)]
    pub fn rest_terms(self) -> [f32; 4] {
        let s2 = self.along * self.along;
        [1.0, self.along, s2, (1.0 - self.up * self.up - s2).max(0.0)]
    }

    /// Logarithm of the radiance factor of cone light, and radiance factor of the rest.
    #[inline(always)]
    pub(crate) fn factors(self, views: &[f32; VIEWS]) -> (f32, f32) {
        let sum = |from: usize, terms: [f32; 4]| {
            views[from] * terms[0]
                + views[from + 1] * terms[1]
                + views[from + 2] * terms[2]
                + views[from + 3] * terms[3]
        };
        (
            sum(0, self.cone_terms()).clamp(CONE_LOGARITHM_RANGE.0, CONE_LOGARITHM_RANGE.1),
            sum(4, self.rest_terms()).max(0.0),
        )
    }
}
