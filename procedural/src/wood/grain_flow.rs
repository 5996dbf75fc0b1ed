//! How fibres run around a knot: the flow-grain analogy with a Rankine oval.
//!
//! Models: fibres as streamlines of a plane potential flow, in the tangential plane, around an obstacle made of a
//! source and a sink in a uniform stream. In units of the obstacle's half width, with the source at -b and the sink at
//! +b:
//!
//! ```text
//! v_along  = 1 + m [(x + b)/A - (x - b)/B],  v_across = m y [1/A - 1/B],  A, B = (x +- b)^2 + y^2
//! psi = y + m [atan2(y, x + b) - atan2(y, x - b)],  m = 1 / (2 atan b)
//! ```
//!
//! and the oval ends at sqrt(b^2 + 2 m b). As b falls to 0 it becomes the circle with a doublet. Sources: Goodman and
//! Bodig (1978) for the analogy; Foley (2001) for its use in growth surfaces; the strength for a given half width
//! follows from psi = 0 at (0, 1). Limits: plane and without swirl; between the knot and the tips of the oval fibres
//! are interpolated.

use base::atan2;
use glam::Vec2;

/// Entries of the table of the outline.
const STEPS: usize = 64;
/// Slowest speed along the fibre [1]: sharpens the blunt nose of the oval to the spindle that wood shows, where fibres
/// part at about 60 deg, and keeps the direction defined at the tips.
pub(super) const SLOWEST: f32 = 0.35;

/// Half width of the seam along the oval's axis where fibres that parted come together again [half width]: a point
/// would turn them within less than a fibre's width.
const SEAM: f32 = 0.7;

/// A Rankine oval of half width 1.
#[derive(Debug, Clone)]
pub(super) struct RankineOval {
    /// Half distance of source and sink [half width].
    b: f32,
    /// Their strength over 2 pi [half width].
    m: f32,
    /// Half length [half width].
    tip: f32,
    /// Half width of the outline from the middle to the tip, in equal steps [half width].
    outline: [f32; STEPS + 1],
}

/// What an obstacle adds to the uniform stream at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Disturbance {
    /// Along and across the stream [1].
    pub velocity: Vec2,
    /// Of the stream function: how far the streamline was pushed aside, negative outwards [half width].
    pub psi: f32,
}

impl RankineOval {
    /// The oval whose source and sink lie `ratio` half widths from its middle.
    pub fn new(ratio: f32) -> Self {
        let m = 0.5 / libm::atanf(ratio);
        let tip = (ratio * ratio + 2.0 * m * ratio).sqrt();
        let mut oval = Self { b: ratio, m, tip, outline: [0.0; STEPS + 1] };
        for i in 0..STEPS {
            let x = tip * i as f32 / STEPS as f32;
            let (mut low, mut high) = (1.0e-6_f32, 1.0_f32);
            for _ in 0..40 {
                let y = 0.5 * (low + high);
                // Inside the outline the stream function has the other sign.
                if y + oval.outside(Vec2::new(x, y)).psi < 0.0 { low = y } else { high = y }
            }
            oval.outline[i] = 0.5 * (low + high);
        }
        oval
    }

    /// The disturbance outside the oval; `p` is (along, across) [half width].
    #[inline]
    pub fn outside(&self, p: Vec2) -> Disturbance {
        let (before, after) = (p.x + self.b, p.x - self.b);
        let square = p.y * p.y;
        let (a, c) = (1.0 / (before * before + square), 1.0 / (after * after + square));
        let velocity = self.m * Vec2::new(before * a - after * c, p.y * (a - c));
        // Both angles in one: the angle between the directions to source and sink.
        let angle = atan2(-2.0 * self.b * p.y, p.length_squared() - self.b * self.b);
        Disturbance { velocity, psi: self.m * angle }
    }

    /// The disturbance anywhere, with the seam behind the tips made as wide as [`SEAM`].
    #[inline]
    pub fn disturb(&self, p: Vec2) -> Disturbance {
        let y = (p.y * p.y + SEAM * SEAM).sqrt();
        let (side, beside) = (p.y / y, self.parted(Vec2::new(p.x, y)));
        Disturbance { velocity: Vec2::new(beside.velocity.x, beside.velocity.y * side), psi: beside.psi * side }
    }

    /// The disturbance with a sharp seam: inside the oval that of the nearest outline point across, in proportion.
    #[inline]
    fn parted(&self, p: Vec2) -> Disturbance {
        let at = p.x.abs() / self.tip * STEPS as f32;
        if at >= STEPS as f32 || p.y.abs() >= 1.0 {
            return self.outside(p);
        }
        let i = at as usize;
        let edge = self.outline[i] + (at - i as f32) * (self.outline[i + 1] - self.outline[i]);
        if p.y.abs() >= edge {
            return self.outside(p);
        }
        let rim = self.outside(Vec2::new(p.x, edge));
        let share = p.y / edge;
        Disturbance { velocity: Vec2::new(rim.velocity.x, rim.velocity.y * share), psi: rim.psi * share }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_flows_through_the_outline() {
        for ratio in [0.1, 0.5, 1.0, 1.5, 4.0] {
            let oval = RankineOval::new(ratio);
            assert!((oval.outline[0] - 1.0).abs() < 1.0e-4, "half width {}", oval.outline[0]);
            for i in 1..STEPS {
                let x = oval.tip * i as f32 / STEPS as f32;
                let p = Vec2::new(x, oval.outline[i]);
                let h = 2.0e-3;
                let across = |x: f32| {
                    // Newton on psi = 0 from the tabulated width; d psi / d y is the speed along.
                    let mut y = oval.outline[i];
                    for _ in 0..20 {
                        let here = oval.outside(Vec2::new(x, y));
                        y -= (y + here.psi) / (1.0 + here.velocity.x);
                    }
                    y
                };
                if x + h >= oval.tip || x > 0.95 * oval.tip {
                    continue;
                }
                let tangent = Vec2::new(2.0 * h, across(x + h) - across(x - h)).normalize();
                let velocity = Vec2::X + oval.outside(p).velocity;
                let normal = tangent.perp_dot(velocity) / velocity.length();
                assert!(normal.abs() < 5.0e-3, "ratio {ratio}, x {x}: normal share {normal}");
            }
            let stagnant = Vec2::X + oval.outside(Vec2::new(oval.tip, 0.0)).velocity;
            assert!(stagnant.length() < 1.0e-4, "ratio {ratio}: speed at the tip {stagnant}");
        }
    }

    #[test]
    fn a_short_oval_is_a_circle_with_a_doublet() {
        let oval = RankineOval::new(0.01);
        assert!((oval.tip - 1.0).abs() < 1.0e-3);
        for i in 0..100 {
            let angle = i as f32 * 0.0628;
            let rho = 1.0 + 0.05 * i as f32;
            let p = rho * Vec2::new(angle.cos(), angle.sin());
            let fourth = rho.powi(4);
            let doublet = Vec2::new(-(p.x * p.x - p.y * p.y) / fourth, -2.0 * p.x * p.y / fourth);
            // The next order of the expansion is b^2/rho^2 = 1e-4; the rest is the rounding of 1/A - 1/B over 2 b.
            assert!(oval.outside(p).velocity.distance(doublet) < 3.0e-4, "at {p}");
        }
    }

    #[test]
    fn the_disturbance_is_continuous_across_the_outline() {
        let oval = RankineOval::new(1.0);
        for i in 1..60 {
            let x = oval.tip * (i as f32 / 60.0) * 0.97;
            let edge = (0..=4000)
                .map(|j| j as f32 / 4000.0)
                .find(|&y| oval.parted(Vec2::new(x, y)) == oval.outside(Vec2::new(x, y)));
            let edge = edge.expect("the outline is no wider than 1");
            let (inner, outer) = (oval.parted(Vec2::new(x, edge - 1.0e-3)), oval.parted(Vec2::new(x, edge + 1.0e-3)));
            assert!(inner.velocity.distance(outer.velocity) < 0.05, "at {x}: {inner:?} {outer:?}");
        }
    }
}
