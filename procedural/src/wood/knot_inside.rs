//! What a cut knot shows inside: its pith, compression wood, years that differ, fibres, and checks.
//!
//! Models: factors on the absorption of the knot's wood. The branch has a dark pith of its own; conifers form
//! compression wood on its lower side, darker in proportion to the depth under the axis. Its years differ; its fibres
//! vary like the stem's, in lanes along its axis; and knots check as they dry, in radial cracks that begin at the pith
//! and end within. A crack takes up light: it is a wedge of strong absorption. Sources: compression wood on the lower
//! side of conifer branches is textbook knowledge (Timell 1986); checks in nearly every dried knot, their number and
//! widths, and all strengths here are engineering estimates. Limits: cracks have no depth in Range; their walls don't
//! guide light; no resin.

use base::Stream;
use glam::{Vec2, Vec3};
use rand::RngExt;

use crate::noise::{Noise, smoothstep};

/// Radius of a branch's pith [mm], and the absorption in its middle over that of the wood [1].
const PITH: [f32; 2] = [0.9, 2.5];
/// Absorption at the lower edge over that on the axis, less one [1].
const COMPRESSION: f32 = 0.35;
/// Mean width of a run of like years [mm], and the spread of their absorption [1].
const YEARS: [f32; 2] = [0.7, 0.15];
/// Cells of the fibres across and along the branch [mm], and the spread of their absorption [1].
const FIBRES: [f32; 3] = [0.3, 5.0, 0.12];
/// Most cracks in a knot.
const CHECKS: usize = 3;
/// Width of a crack at its widest over the half width of the knot [1], and the most it may be [mm].
const CHECK_WIDTH: [f32; 2] = [0.05, 0.35];
/// Where a crack may end, in half widths from the axis [1].
const CHECK_END: [f32; 2] = [0.45, 0.95];
/// Absorption in a crack over that of the wood, less one [1].
const CHECK_ABSORPTION: f32 = 6.0;

/// A radial crack.
#[derive(Debug, Clone, Copy)]
struct Check {
    direction: Vec2,
    /// Where it ends [half widths]; 0 is no crack.
    end: f32,
    /// Its width at a third of its length over the half width [1].
    width: f32,
}

/// The inside of one knot.
#[derive(Debug, Clone, Copy)]
pub(super) struct KnotInside {
    years: Noise,
    fibres: Noise,
    checks: [Check; CHECKS],
}

impl KnotInside {
    /// The draws of one knot's own stream.
    pub fn grow(stream: Stream) -> Self {
        let mut rng = stream.child("checks").rng();
        let count = (rng.random::<f32>() * (CHECKS + 1) as f32) as usize;
        let first = std::f64::consts::TAU * rng.random::<f64>();
        let checks = std::array::from_fn(|i| {
            // About evenly around: a crack relieves the wood beside it.
            let jitter = 0.8 * (rng.random::<f64>() - 0.5);
            let (sin, cos) = libm::sincos(first + (i as f64 + jitter) * std::f64::consts::TAU / CHECKS as f64);
            let (length, width) = (rng.random::<f32>(), rng.random::<f32>());
            Check {
                direction: Vec2::new(cos as f32, sin as f32),
                end: if i < count { CHECK_END[0] + (CHECK_END[1] - CHECK_END[0]) * length } else { 0.0 },
                width: CHECK_WIDTH[0] * (0.4 + 1.2 * width),
            }
        });
        Self { years: Noise::new(stream.child("years")), fibres: Noise::new(stream.child("fibres")), checks }
    }

    /// Absorption over that of the knot's wood [1]: `offset` from the axis [mm], `x` its length in half widths and
    /// `distance` in mm, `below` the cosine of its angle from down the stem, `r` the distance from the log's pith [mm].
    #[inline]
    pub fn absorption(&self, offset: Vec2, x: f32, distance: f32, below: f32, r: f32) -> f32 {
        let pith = 1.0 + (PITH[1] - 1.0) * (1.0 - smoothstep(0.4 * PITH[0], PITH[0], distance));
        let compression = 1.0 + COMPRESSION * (x * below).max(0.0);
        let years = 1.0 + YEARS[1] * self.years.line(distance / YEARS[0]).0;
        let place = Vec3::new(offset.x / FIBRES[0], offset.y / FIBRES[0], r / FIBRES[1]);
        let fibres = 1.0 + FIBRES[2] * self.fibres.bundles(place);
        pith * compression * years * fibres * (1.0 + CHECK_ABSORPTION * self.cracked(offset, x, distance))
    }

    /// How much of a place lies in a crack [1].
    #[inline]
    fn cracked(&self, offset: Vec2, x: f32, distance: f32) -> f32 {
        let half_width = distance / x.max(1.0e-3);
        let direction = offset / distance.max(1.0e-3);
        let mut most = 0.0_f32;
        for check in &self.checks {
            let ahead = direction.dot(check.direction);
            if x >= check.end || ahead <= 0.0 {
                continue;
            }
            let share = x / check.end;
            // Widest at a third of its length, closed at both ends.
            let taper = 6.75 * share * (1.0 - share) * (1.0 - share);
            let half = 0.5 * taper * (check.width * half_width).min(CHECK_WIDTH[1]);
            let aside = direction.perp_dot(check.direction).abs() * distance;
            most = most.max(1.0 - smoothstep(0.5 * half, 1.5 * half + 1.0e-3, aside));
        }
        most
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Mean absorption and the share of places over twice it, over discs of many knots.
    fn disc(half_width: f32) -> (f64, f64) {
        let (mut sum, mut dark, mut n) = (0.0, 0, 0);
        for knot in 0..200 {
            let inside = KnotInside::grow(Stream::root(4).index(knot));
            for i in 0..400 {
                let (distance, angle) = (((i as f32 + 0.5) / 400.0).sqrt(), 2.399_963 * i as f32);
                let offset = half_width * distance * Vec2::new(angle.cos(), angle.sin());
                let value = inside.absorption(offset, distance, half_width * distance, -angle.sin(), 60.0);
                assert!(value > 0.3 && value.is_finite());
                sum += f64::from(value);
                dark += u32::from(value > 3.0);
                n += 1;
            }
        }
        (sum / f64::from(n), f64::from(dark) / f64::from(n))
    }

    #[test]
    fn a_knot_is_wood_with_a_few_cracks() {
        for half_width in [4.0, 10.0] {
            let (mean, dark) = disc(half_width);
            // Compression adds 0.35 * 4/(3 pi) / 2 = 0.07; pith and cracks a few per cent of the area each.
            assert!((1.03..1.25).contains(&mean), "mean {mean}");
            assert!((0.002..0.04).contains(&dark), "cracks take {dark} of the area");
        }
    }

    #[test]
    fn the_lower_side_is_darker() {
        let inside = KnotInside {
            checks: [Check { direction: Vec2::X, end: 0.0, width: 0.0 }; CHECKS],
            ..KnotInside::grow(Stream::root(1))
        };
        let at = |below: f32| {
            let n = 2000;
            (0..n)
                .map(|i| inside.absorption(Vec2::new(0.3 * i as f32, -4.0 * below), 0.8, 4.0, below, 7.0 * i as f32))
                .sum::<f32>()
                / n as f32
        };
        assert!((at(1.0) / at(-1.0) - 1.0 - 0.8 * COMPRESSION).abs() < 0.03);
    }
}
