//! The log that a board was cut from: its pith line and the cylinder coordinates around it.
//!
//! Models: a pith line, either one that tilts against the board and wanders smoothly, or that of a whole stem (`stem`).
//! Coordinates of a point are its distance `r`
//! from the pith in the plane across the log, its azimuth `phi`, and its place `l` along the log.
//! Equation: P = pith(l) + r e_r(phi) + l e_L, the same cut across the log that Larsson et al. (2022) use.
//! Source of the numbers: the scanned log of Larsson et al., whose pith tilts 2.8 deg over 10 mm and 0.6 deg over 1 m.
//! Limits: the cut stays across the mean axis, so a pith tilted by a degree makes rings oval by 0.02 percent.

use std::sync::Arc;

use base::{Stream, atan2};
use glam::{Vec2, Vec3};

use super::Wood;
use super::stem::Layers;
use crate::noise::Noise;

/// Spacing of the table of the pith line [mm]; its bends are hundred times longer.
const STEP_MM: f32 = 2.0;
/// Cells of the two octaves of wander along the log [mm], after the tilt over 10, 100 and 200 mm of the scanned log.
const WANDER_CELLS_MM: [f32; 2] = [130.0, 45.0];
/// Their shares of the root mean square; squares sum to 1 [1].
const WANDER_SHARES: [f32; 2] = [0.98, 0.2];
/// The table reaches this far beyond the board, for knots whose skeleton leaves it [mm].
const MARGIN_MM: f32 = 50.0;
/// Smallest distance from the pith at which directions are told apart [mm].
const NEAREST_MM: f32 = 1.0e-3;

/// Position and direction of the pith at one place along the log.
#[derive(Debug, Clone, Copy)]
pub(super) struct PithNode {
    /// Sideways and upwards [mm].
    pub place: Vec2,
    /// Their change along the log [1].
    pub slope: Vec2,
}

/// The log in the board's frame.
#[derive(Debug, Clone)]
pub(super) struct Trunk {
    /// Middle of the board [mm].
    middle: Vec2,
    /// Cosine and sine of the turn about the vertical [1].
    turn: Vec2,
    /// Direction of azimuth 0 across the log: from the pith to the board's middle [1].
    zenith: Vec2,
    /// First place of the table [mm].
    start: f32,
    nodes: Vec<PithNode>,
    /// How layers leave the pith's wander; `None` where all of them follow it.
    layers: Option<Arc<Layers>>,
}

/// A point in the log's coordinates, with the directions that belong to it.
#[derive(Debug, Clone, Copy)]
pub(super) struct LogPoint {
    /// Distance from the pith [mm].
    pub r: f32,
    /// Azimuth, from the pith-to-board direction, right-handed about the log [rad].
    pub phi: f32,
    /// Along the log, from the board's middle [mm].
    pub l: f32,
    /// Away from the pith: sideways and upwards [1].
    pub outward: Vec2,
    /// Slope of the pith line: sideways and upwards [1].
    pub pith_slope: Vec2,
}

impl LogPoint {
    /// Direction of growing azimuth: sideways and upwards [1].
    #[inline]
    pub fn around(&self) -> Vec2 {
        Vec2::new(self.outward.y, -self.outward.x)
    }
}

impl Trunk {
    /// The log of a board.
    pub fn grow(stream: Stream, wood: &Wood) -> Self {
        let (board, log) = (&wood.board, &wood.log);
        let tilt = libm::tan(log.pith_tilt_deg.to_radians()) as f32;
        let straight =
            Vec2::new(log.pith_offset_mm as f32, (board.thickness_mm - log.depth_mm(board.thickness_mm)) as f32);
        // The root mean square is that of the distance; sideways and upwards share it.
        let wander = log.pith_wander_mm as f32 * std::f32::consts::FRAC_1_SQRT_2;
        let bends = |name: &str| {
            let octaves = [0, 1].map(|i| Noise::new(stream.child(name).index(i)));
            move |l: f32| {
                (0..2).fold(Vec2::ZERO, |sum, i| {
                    let (value, slope) = octaves[i].line(l / WANDER_CELLS_MM[i]);
                    sum + wander * WANDER_SHARES[i] * Vec2::new(value, slope / WANDER_CELLS_MM[i])
                })
            }
        };
        let (sideways, upwards) = (bends("sideways"), bends("upwards"));
        Self::along(wood, MARGIN_MM, straight, |l| {
            let (x, z) = (sideways(l), upwards(l));
            PithNode { place: straight + Vec2::new(x.x, z.x - tilt * l), slope: Vec2::new(x.y, z.y - tilt) }
        })
    }

    /// The log around a pith line, asked up to `margin` beyond the board [mm]; azimuth 0 points from `straight`,
    /// sideways and upwards [mm], to the board's middle.
    pub fn along(wood: &Wood, margin: f32, straight: Vec2, pith: impl Fn(f32) -> PithNode) -> Self {
        let (board, log) = (&wood.board, &wood.log);
        let (sin, cos) = libm::sincos(log.turn_deg().to_radians());
        let turn = Vec2::new(cos as f32, sin as f32);
        let half = 0.5 * Vec2::new(board.width_mm as f32, board.length_mm as f32);
        let reach = half.x * turn.y.abs() + half.y * turn.x.abs() + margin;
        let count = (2.0 * reach / STEP_MM).ceil() as usize + 2;
        let nodes = (0..count).map(|i| pith(i as f32 * STEP_MM - reach));
        let middle = Vec2::new(board.offset_mm as f32, (board.lead_in_mm + 0.5 * board.length_mm) as f32);
        Self { middle, turn, zenith: zenith(wood, straight), start: -reach, nodes: nodes.collect(), layers: None }
    }

    /// The same with layers that leave the pith's wander.
    pub fn with_layers(self, layers: Arc<Layers>) -> Self {
        Self { layers: Some(layers), ..self }
    }

    /// How layers leave the pith's wander.
    pub fn layers(&self) -> Option<&Arc<Layers>> {
        self.layers.as_ref()
    }

    /// Which layer a place belongs to, without waviness and branches: its distance from the pith, or from what of the
    /// pith's wander is left there [mm].
    pub fn layer(&self, place: &LogPoint) -> f32 {
        self.layers.as_ref().map_or(place.r, |layers| layers.at(place).t)
    }

    /// The youngest layer within the distance `r` of the pith, without waviness and branches [mm].
    pub fn youngest(&self, r: f32) -> f32 {
        self.layers.as_ref().map_or(r, |layers| layers.most(r))
    }

    #[inline]
    fn pith(&self, l: f32) -> PithNode {
        let at = ((l - self.start) / STEP_MM).clamp(0.0, (self.nodes.len() - 2) as f32);
        let i = at as usize;
        let w = at - i as f32;
        let (a, b) = (self.nodes[i], self.nodes[i + 1]);
        PithNode { place: a.place + w * (b.place - a.place), slope: a.slope + w * (b.slope - a.slope) }
    }

    /// Log coordinates of a point of the unwarped board [mm].
    #[inline]
    pub fn place(&self, x: f32, y: f32, z: f32) -> LogPoint {
        let (dx, dy) = (x - self.middle.x, y - self.middle.y);
        let (sideways, l) = (dx * self.turn.x - dy * self.turn.y, dx * self.turn.y + dy * self.turn.x);
        let pith = self.pith(l);
        let offset = Vec2::new(sideways, z) - pith.place;
        let r = offset.length().max(NEAREST_MM);
        let outward = offset / r;
        let phi = atan2(outward.perp_dot(self.zenith), outward.dot(self.zenith));
        LogPoint { r, phi, l, outward, pith_slope: pith.slope }
    }

    /// Point of the unwarped board at log coordinates [mm].
    pub fn point(&self, r: f32, phi: f32, l: f32) -> Vec3 {
        let (sin, cos) = libm::sincosf(phi);
        let across = Vec2::new(self.zenith.y, -self.zenith.x);
        let spot = self.pith(l).place + r * (cos * self.zenith + sin * across);
        let level = self.vector(Vec2::new(spot.x, 0.0), l);
        Vec3::new(self.middle.x + level.x, self.middle.y + level.y, spot.y)
    }

    /// Scan-frame vector of a part across the log (sideways, upwards) and a part along it.
    #[inline]
    pub fn vector(&self, across: Vec2, along: f32) -> Vec3 {
        let (cos, sin) = (self.turn.x, self.turn.y);
        Vec3::new(across.x * cos + along * sin, along * cos - across.x * sin, across.y)
    }

    /// Largest distance from the pith that a box of that half size and height reaches [mm].
    pub fn reach(&self, half: Vec2, height: f32) -> f32 {
        let level = half.length();
        self.nodes.iter().fold(0.0_f32, |most, node| {
            let up = (height - node.place.y).abs().max(node.place.y.abs());
            most.max(Vec2::new(node.place.x.abs() + level, up).length())
        })
    }
}

/// Direction across the log from the pith to the middle of the board: sideways and upwards [1].
pub(super) fn zenith(wood: &Wood, pith: Vec2) -> Vec2 {
    let to_board = Vec2::new(0.0, 0.5 * wood.board.thickness_mm as f32) - pith;
    to_board.try_normalize().unwrap_or(Vec2::Y)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn place_and_point_are_inverse() {
        let mut wood = Wood::from_values(&mut |p| p.default);
        wood.log.grain_angle_deg = 25.0;
        let trunk = Trunk::grow(Stream::root(1), &wood);
        for i in 0..200 {
            let p = Vec3::new((i % 17) as f32 * 5.0 - 40.0, 20.0 + i as f32, (i % 7) as f32 * 3.0);
            let place = trunk.place(p.x, p.y, p.z);
            let back = trunk.point(place.r, place.phi, place.l);
            assert!(p.distance(back) < 1.0e-3, "{p} {back}");
        }
    }

    /// Turned end for end a board is the same wood rotated about its middle: places, distances and directions.
    #[test]
    fn a_turned_board_is_the_same_wood() {
        for seed in 0..20 {
            let mut wood = Wood::from_values(&mut |p| p.default);
            wood.log.grain_angle_deg = 4.0 * seed as f64 - 40.0;
            wood.board.offset_mm = seed as f64;
            let plain = Trunk::grow(Stream::root(seed), &wood);
            wood.log.turned = 1.0;
            let turned = Trunk::grow(Stream::root(seed), &wood);
            let middle = Vec2::new(wood.board.offset_mm as f32, 20.0 + 0.5 * wood.board.length_mm as f32);
            for i in 0..40 {
                let p = Vec3::new(3.0 * i as f32 - 50.0, 20.0 + 4.0 * i as f32, (i % 7) as f32 * 3.0);
                let rotated = (2.0 * middle - p.truncate()).extend(p.z);
                let (a, b) = (plain.place(p.x, p.y, p.z), turned.place(rotated.x, rotated.y, rotated.z));
                assert!(
                    (a.r - b.r).abs() < 1e-3 && (a.l - b.l).abs() < 1e-3 && (a.phi - b.phi).abs() < 1e-4,
                    "{a:?} {b:?}"
                );
                let across = Vec2::new(0.3, 0.5);
                let (v, w) = (plain.vector(across, 0.8), turned.vector(across, 0.8));
                assert!(v.distance(Vec3::new(-w.x, -w.y, w.z)) < 1e-5, "{v} {w}");
            }
        }
    }

    #[test]
    fn the_pith_lies_where_it_was_asked() {
        let mut wood = Wood::from_values(&mut |p| p.default);
        wood.log.pith_wander_mm = 0.0;
        wood.log.pith_tilt_deg = 0.0;
        let trunk = Trunk::grow(Stream::root(1), &wood);
        let top = wood.board.thickness_mm as f32;
        let place = trunk.place(10.0, 60.0, top);
        assert!((place.r - 70.0).abs() < 1.0e-4 && place.outward.distance(Vec2::Y) < 1.0e-4);
        wood.log.pith_tilt_deg = 1.0;
        let deeper = Trunk::grow(Stream::root(1), &wood).place(10.0, 125.0 + 100.0, top).r;
        assert!((deeper - 70.0 - 100.0 * 1.0_f32.to_radians().tan()).abs() < 1.0e-3);
        (wood.log.pith_tilt_deg, wood.log.flipped) = (0.0, 1.0);
        let place = Trunk::grow(Stream::root(1), &wood).place(10.0, 60.0, top);
        assert!((place.r - (70.0 - top)).abs() < 1.0e-4 && place.outward.distance(-Vec2::Y) < 1.0e-4);
    }
}
