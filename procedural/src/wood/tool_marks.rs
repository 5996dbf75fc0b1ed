//! Marks that tools leave on the upper face: knives of a planer, a band or frame saw, a circular saw.
//!
//! Models: marks follow each other at a pitch; u counts them. Of a planer u = (y + q x) / pitch, and the face between
//! two cusps is the arc of the knives' circle, a parabola z = h m (3 v^2 - 1) sqrt(5)/2, v from -1 to 1 within a mark,
//! of root mean square h. The depth factor m of a mark drifts from mark to mark, since no two knives run alike, over
//! the root mean square of all factors. Of a band or frame saw u = (y + x tan slant) / pitch and of a circular saw u =
//! (y - sqrt(R^2 - (x - x0)^2)) / pitch, arcs whose centre x0 lies 0.3 to 0.8 R beside the board's middle. Both leave z
//! = h (0.8 sqrt(2) sin(2 pi u + p(u)) m(u, s) + 0.6 f(u, s)), where s runs along the marks, m is a depth that wanders
//! along and across them, p a phase that drifts and f are scores of single teeth (`Noise::fibres`). Source: planer cuts
//! 1 to 3 mm apart by feed over cuts a minute; all other numbers are engineering estimates. Limits: no washboarding, no
//! burnt arcs, no marks of chips pressed in; the hull is without marks.

use std::f32::consts::{PI, SQRT_2, TAU};

use base::{Stream, Surface, normal};
use glam::Vec2;
use rand::RngExt;

use super::{EDGE_MOST, Wood};
use crate::noise::Noise;

/// Spread of a planer's axis against the laser line [1].
const PLANER_SLANT: f64 = 0.004;
/// Unevenness of the depth from knife mark to knife mark, root mean square [1].
const KNIVES: f32 = 0.35;
/// Shares of the regular wave and of single scores in the root mean square of a saw; squares sum to 1 [1].
const SAW_SHARES: [f32; 2] = [0.8, 0.6];
/// Unevenness of a saw's depth, root mean square [1], and its cells: marks across, millimetres along.
const SAW_DEPTH: f32 = 0.45;
const SAW_DEPTH_CELLS: Vec2 = Vec2::new(3.5, 70.0);
/// Drift of a saw's phase, root mean square [rad], and its cell [marks].
const SAW_PHASE: [f32; 2] = [0.9, 5.0];
/// Half width of a score [marks], and the length over which its depth changes [mm].
const SCORE_CELLS: Vec2 = Vec2::new(0.45, 60.0);
/// Circular saws are at least so much larger than what they must reach [1].
const ARC_ROOM: f32 = 1.02;

/// How the count of marks depends on the place.
#[derive(Debug, Clone, Copy)]
enum Path {
    /// Straight, with this slope against the laser line [1].
    Straight(f32),
    /// Arcs of this radius about a centre beside the board's middle [mm].
    Arc { radius: f32, centre: f32 },
}

/// The marks of one tool.
#[derive(Debug, Clone)]
struct Marks {
    path: Path,
    /// Marks per millimetre [mm^-1].
    per_mm: f32,
    /// Root mean square of the height [mm].
    height: f32,
    /// Waves and scores of a saw, or cusps of knives.
    is_sawn: bool,
    depth: Noise,
    phase: Noise,
    scores: Noise,
}

/// All tool marks of a board.
#[derive(Debug, Clone)]
pub(super) struct ToolMarks(Vec<Marks>);

impl ToolMarks {
    /// The marks that the numbers ask for; none where all heights are 0.
    pub fn grow(stream: Stream, wood: &Wood) -> Self {
        let asked = &wood.machining;
        // Edges that wander lie beyond the nominal half width.
        let half = 0.5 * wood.board.width_mm as f32 + EDGE_MOST * wood.board.edge_wander_mm as f32;
        let marks = |name: &str, um: f64, pitch: f64, is_sawn: bool, path: &dyn Fn(Stream) -> Path| {
            let own = stream.child(name);
            (um > 0.0).then(|| Marks {
                path: path(own),
                per_mm: (1.0 / pitch) as f32,
                height: 1.0e-3 * um as f32,
                is_sawn,
                depth: Noise::new(own.child("depth")),
                phase: Noise::new(own.child("phase")),
                scores: Noise::new(own.child("scores")),
            })
        };
        let all = [
            marks("planer", asked.planer_um, asked.planer_pitch_mm, false, &|own| {
                Path::Straight((PLANER_SLANT * normal(&mut own.child("slant").rng())) as f32)
            }),
            marks("band", asked.band_um, asked.band_pitch_mm, true, &|_| {
                Path::Straight(libm::tan(asked.band_slant_deg.to_radians()) as f32)
            }),
            marks("circular", asked.circular_um, asked.circular_pitch_mm, true, &|own| {
                let mut rng = own.child("centre").rng();
                let side = if rng.random::<f32>() < 0.5 { -1.0 } else { 1.0 };
                let share = 0.3 + 0.5 * rng.random::<f32>();
                let radius = asked.circular_radius_mm as f32;
                // A saw that is too small for the board is as large as it must be.
                let radius = radius.max(ARC_ROOM * half / (1.0 - share));
                Path::Arc { radius, centre: side * share * radius }
            }),
        ];
        Self(all.into_iter().flatten().collect())
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// How far they leave the face [mm], but for the rarest.
    pub fn relief(&self) -> f32 {
        4.0 * self.0.iter().map(|marks| marks.height).sum::<f32>()
    }

    /// Height of the marks [mm] and slopes at a place from the board's middle [mm].
    #[inline]
    pub fn at(&self, d: Vec2) -> Surface {
        let mut sum = Surface { z: 0.0, slope_x: 0.0, slope_y: 0.0 };
        for marks in &self.0 {
            let (z, slope) = marks.at(d);
            sum.z += z;
            sum.slope_x += slope.x;
            sum.slope_y += slope.y;
        }
        sum
    }
}

impl Marks {
    #[inline]
    fn at(&self, d: Vec2) -> (f32, Vec2) {
        // Count of marks, with its gradient; along a mark the board's width is a good measure of length.
        let (u, across) = match self.path {
            Path::Straight(slope) => (d.y + slope * d.x, Vec2::new(slope, 1.0)),
            Path::Arc { radius, centre } => {
                let aside = d.x - centre;
                let high = (radius * radius - aside * aside).max(1.0).sqrt();
                (d.y - high, Vec2::new(aside / high, 1.0))
            }
        };
        let (u, across) = (u * self.per_mm, across * self.per_mm);
        let (z, along_u, along_x) = if self.is_sawn { self.sawn(u, d.x) } else { self.planed(u) };
        (self.height * z, self.height * (along_u * across + Vec2::new(along_x, 0.0)))
    }

    /// Cusps of knives over their root mean square, with the slope by mark.
    #[inline]
    fn planed(&self, u: f32) -> (f32, f32, f32) {
        let knife = u.floor();
        let v = 2.0 * (u - knife) - 1.0;
        // Marks meet at their cusps only where the depths are alike; the line of the noise lets neighbours differ
        // little.
        let (depth, depth_slope) = self.depth.line(u / 2.3);
        let m = (1.0 + KNIVES * depth).max(0.2);
        let m_slope = if m > 0.2 { KNIVES * depth_slope / 2.3 } else { 0.0 };
        // Uneven depths have more root mean square than even ones.
        let scale = 1.118_034 / (1.0 + KNIVES * KNIVES).sqrt();
        let shape = scale * (3.0 * v * v - 1.0);
        (m * shape, m * scale * 12.0 * v + m_slope * shape, 0.0)
    }

    /// Waves and scores of a saw over their root mean square, with slopes by mark and along the marks.
    #[inline]
    fn sawn(&self, u: f32, x: f32) -> (f32, f32, f32) {
        let (drift, drift_slope) = self.phase.line(u / SAW_PHASE[1]);
        // Reduced before the sum, so that far marks lose no digits.
        let turn = TAU * (u - u.floor()) - PI + SAW_PHASE[0] * drift;
        let rate = TAU + SAW_PHASE[0] * drift_slope / SAW_PHASE[1];
        let (sin, cos) = sin_cos(turn);
        let place = Vec2::new(u, x);
        let (depth, depth_slope) = self.depth.plane(place / SAW_DEPTH_CELLS);
        let m = 1.0 + SAW_DEPTH * depth;
        let m_slope = SAW_DEPTH * depth_slope / SAW_DEPTH_CELLS;
        let (score, score_slope) = self.scores.fibres(place / SCORE_CELLS);
        let score_slope = score_slope / SCORE_CELLS;
        let wave = SAW_SHARES[0] * SQRT_2 / (1.0 + SAW_DEPTH * SAW_DEPTH).sqrt();
        (
            wave * m * sin + SAW_SHARES[1] * score,
            wave * (m * cos * rate + m_slope.x * sin) + SAW_SHARES[1] * score_slope.x,
            wave * m_slope.y * sin + SAW_SHARES[1] * score_slope.y,
        )
    }
}

/// Sine and cosine, good to 1e-5 [1]: the series of the half angle within a quarter turn, doubled.
#[inline]
pub(super) fn sin_cos(angle: f32) -> (f32, f32) {
    let turns = angle * (1.0 / TAU);
    let nearest = (turns + 0.5_f32.copysign(turns)) as i32 as f32;
    let half = 0.5 * (angle - TAU * nearest);
    let q = half * half;
    let sin = half * (1.0 - q / 6.0 * (1.0 - q / 20.0 * (1.0 - q / 42.0 * (1.0 - q / 72.0))));
    let cos = 1.0 - q / 2.0 * (1.0 - q / 12.0 * (1.0 - q / 30.0 * (1.0 - q / 56.0 * (1.0 - q / 90.0))));
    (2.0 * sin * cos, cos * cos - sin * sin)
}
