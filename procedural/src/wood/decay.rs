//! Rot that grew in from one long edge of the board.
//!
//! Models: a front at the asked distance from the edge that wanders with elongated noise; severity rises across the front
//! along a smooth step. With severity s and v = 2 s, absorption is mu_a,clear (mu_a,rot / mu_a,clear)^v, every other
//! coefficient is clear + v (rot - clear): at s = 1/2 the medium is that of the class table. Before the front lies a
//! rim of reaction that absorbs half as much again. A point is decayed where at least half of the front has passed.
//! Sources: class table and sizes in docs/wood.md.
//! Limits: one strip along the whole edge; no cubical cracks, no loss of height, no zone lines inside.

use glam::Vec3;

use super::coefficients::Coefficients;
use super::parameters::Wood;
use crate::Stream;
use crate::medium::KERNEL_INDICES;
use crate::noise::{Noise, smoothstep};

/// Cell of the front's noise across the fibre [mm].
const CELL_MM: f32 = 12.0;
/// The noise stays within this many root mean squares: three octaves of uniform lattice values reach 3.9 [1].
const NOISE_LIMIT: f32 = 4.0;
/// Absorption in the rim over that of clear wood [1].
const RIM_FACTOR: f32 = 1.5;

/// Isotropic scattering stays above this where severity goes beyond the class table [mm^-1].
pub const LEAST_SIGMA_I: f32 = 0.01;
/// Effective indices lie between those of air and of the cell wall [1].
const INDICES: [f32; 2] = KERNEL_INDICES;

/// Decay of a board.
#[derive(Debug, Clone)]
pub(super) struct Decay {
    /// Middle of the board along the laser line [mm].
    middle: f32,
    /// Half the board's width [mm].
    half_width: f32,
    /// -1 or 1: the edge that it came from.
    pub side: f32,
    /// Mean distance of the front from the edge [mm].
    reach: f32,
    /// Severity behind the front, 0 to 1 [1].
    pub severity: f32,
    /// Half width of the front [mm].
    half_transition: f32,
    /// Root mean square of the front's wandering [mm].
    wander: f32,
    /// Width of the rim before the front [mm].
    rim: f32,
    noise: Noise,
    /// One over the cell of the noise across the fibre [mm^-1].
    across: f32,
    /// One over the cell of the noise along the fibre [mm^-1].
    along: f32,
    /// The class table's medium.
    rot: Coefficients,
}

/// Decay at a point.
#[derive(Debug, Clone, Copy)]
pub(super) struct Decayed {
    /// How much of the front has passed, 0 to 1 [1].
    pub passed: f32,
    /// Factor on the absorption of clear wood [1].
    rim: f32,
}

impl Decay {
    /// The decay that a recipe asks for; none without reach or without severity.
    pub fn grow(stream: Stream, wood: &Wood, rot: Coefficients) -> Option<Self> {
        let asked = &wood.rot;
        (asked.reach_mm > 0.0 && asked.severity > 0.0).then(|| Self {
            middle: wood.board.offset_mm as f32,
            half_width: 0.5 * wood.board.width_mm as f32,
            side: if asked.edge < 0.0 { -1.0 } else { 1.0 },
            reach: asked.reach_mm as f32,
            severity: asked.severity as f32,
            half_transition: 0.5 * asked.transition_mm as f32,
            wander: asked.front_mm as f32,
            rim: asked.rim_mm as f32,
            noise: Noise::new(stream.child("front")),
            across: 1.0 / CELL_MM,
            along: 1.0 / (CELL_MM * asked.elongation as f32),
            rot,
        })
    }

    /// Decay at `x` [mm] of the scan frame, with `log` the same point sideways, along and upwards in the log [mm].
    #[inline]
    pub fn at(&self, x: f32, log: Vec3) -> Option<Decayed> {
        let ahead = self.half_width - self.side * (x - self.middle) - self.reach;
        if ahead > NOISE_LIMIT * self.wander + self.half_transition + self.rim {
            return None;
        }
        let ahead = if ahead < -NOISE_LIMIT * self.wander - self.half_transition {
            ahead
        } else {
            ahead + self.wander * self.noise.fractal(log * Vec3::new(self.across, self.along, self.across))
        };
        let passed = 1.0 - smoothstep(-self.half_transition, self.half_transition, ahead);
        let middle = 0.5 * (self.half_transition + self.rim);
        let q = (ahead - middle) / (middle + 1.0e-6);
        let bump = (1.0 - q * q).max(0.0);
        let rim = if self.rim > 0.0 { 1.0 + (RIM_FACTOR - 1.0) * bump * bump } else { 1.0 };
        Some(Decayed { passed, rim })
    }

    /// What decay makes of clear wood.
    #[inline]
    pub fn change(&self, clear: Coefficients, decayed: Decayed) -> Coefficients {
        let v = 2.0 * self.severity * decayed.passed;
        let mu_a = clear.mu_a * decayed.rim;
        let along = |from: f32, to: f32| from + v * (to - from);
        Coefficients {
            mu_a: mu_a * libm::powf(self.rot.mu_a / mu_a, v),
            sigma_i: along(clear.sigma_i, self.rot.sigma_i).max(LEAST_SIGMA_I),
            k: along(clear.k, self.rot.k).max(0.0),
            n_eff: along(clear.n_eff, self.rot.n_eff).clamp(INDICES[0], INDICES[1]),
        }
    }
}
