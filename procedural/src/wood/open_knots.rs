//! Holes that dead knots have left, and loose knots.
//!
//! Models: the hole of a knot has the knot's own outline and walls that fall by [`STEEPEST`]. A loose knot has shrunk
//! more than the wood around: it lies lower, tilted about a drawn axis, and rests against one side of its hole, so that
//! the gap is g (1 + cos a) wide at the angle a from the other side, and wedge-shaped. Limits: holes stand upright;
//! loose knots sink and do not stand proud.

use std::sync::Arc;

use base::{Class, Instance};
use glam::Vec2;
use rand::RngExt;

use super::board_face::BoardFace;
use super::growth::wrap;
use super::knot::{Knot, KnotDistance, KnotSection};
use super::knot_placement::PlacedKnot;
use super::opening_floor::{FLOOR_MM, Floor};
use super::openings::{DEEPEST_WIDTHS, LABELLED_MM, OpenedBoard, Opening, OpeningForm, Openings, STEEPEST};
use super::pith::Trunk;
use crate::noise::smoothstep;

/// Tilt of a loose knot: change of its depth over a half width, over the mean depth [1].
const LOOSE_TILT: f32 = 0.7;

/// A hole with the outline of its knot.
#[derive(Debug)]
struct KnotHole {
    knot: Knot,
    depth: f32,
}

/// A loose knot in its hole.
#[derive(Debug)]
struct LooseKnot {
    knot: Knot,
    /// Mean width of the gap [mm], and its depth where it is widest [mm].
    gap: f32,
    depth: f32,
    /// Mean depth of the knot's face [mm].
    sunk: f32,
    /// Directions on the outline where the gap is widest and where the face lies deepest.
    wide: Vec2,
    low: Vec2,
}

/// Opens the holes of knots.
pub(super) fn holes(openings: &mut Openings, board: &mut OpenedBoard) {
    let depth = (board.wood.knots.hole_depth_mm as f32).min(openings.room());
    for placed in board.knots.iter().filter(|placed| placed.knot.class == Class::KnotHole) {
        let form = KnotHole { knot: placed.knot.clone(), depth };
        open(openings, placed, board.instances, |_| depth, Arc::new(form));
    }
}

/// Sinks the loose knots.
pub(super) fn loose(openings: &mut Openings, board: &mut OpenedBoard) {
    let room = openings.face.height - FLOOR_MM;
    let [gap, sunk] = [board.wood.knots.loose_gap_mm, board.wood.knots.loose_sunk_mm].map(|mm| mm as f32);
    let loose = board.knots.iter().filter(|placed| placed.knot.class == Class::LooseKnot);
    for (placed, index) in loose.zip(0..) {
        let mut rng = board.stream.child("loose").index(index).rng();
        let mut direction = || {
            let (sin, cos) = libm::sincosf(std::f32::consts::TAU * rng.random::<f32>());
            Vec2::new(cos, sin)
        };
        let (wide, low) = (direction(), direction());
        let depth = (DEEPEST_WIDTHS * 2.0 * gap).min(room).max(0.0);
        let sunk = sunk.min(room / (1.0 + LOOSE_TILT)).max(0.0);
        let deepest = |half_width: f32| {
            // A gap that is wider than the knot has no room for its deepest place.
            let open = depth * (half_width / gap.max(1.0e-3)).min(1.0);
            open.max(deepest_of_face(sunk, half_width))
        };
        let form = LooseKnot { knot: placed.knot.clone(), gap, depth, sunk, wide, low };
        open(openings, placed, board.instances, deepest, Arc::new(form));
    }
}

/// Opens a knot; `deepest` is the depth that its instance has, by half its width [mm].
fn open(
    openings: &mut Openings,
    placed: &PlacedKnot,
    instances: &mut [Instance],
    deepest: impl Fn(f32) -> f32,
    form: Arc<dyn OpeningForm>,
) {
    let (class, id) = (placed.knot.class, placed.knot.id);
    for instance in instances.iter_mut().filter(|instance| instance.id == id) {
        instance.depth_mm = f64::from(deepest(0.5 * instance.diameter_mm as f32));
    }
    let (low, high) = (Vec2::new(placed.x[0], placed.y[0]), Vec2::new(placed.x[1], placed.y[1]));
    openings.add(Opening { class, id, low, high, labelled: LABELLED_MM, form });
}

impl OpeningForm for KnotHole {
    fn depth(&self, face: &BoardFace, spot: Vec2, trunk: &Trunk) -> (f32, Floor) {
        let Self { knot, depth } = self;
        let (x, _, section) = in_knot(knot, face, spot, trunk);
        let wall = (depth / STEEPEST / section.half_width).min(0.7);
        (depth * (1.0 - smoothstep(1.0 - wall, 1.0, x)), Floor::Wood)
    }
}

impl OpeningForm for LooseKnot {
    fn depth(&self, face: &BoardFace, spot: Vec2, trunk: &Trunk) -> (f32, Floor) {
        let Self { knot, gap, depth, sunk, wide, low } = self;
        let (x, direction, section) = in_knot(knot, face, spot, trunk);
        if x >= 1.0 {
            return (0.0, Floor::Wood);
        }
        let width = gap * (1.0 + wide.dot(direction));
        // From the middle of the gap, in halves of its width.
        let aside = (2.0 * (1.0 - x) * section.half_width / width.max(1.0e-3) - 1.0).abs();
        let open = depth * width / (2.0 * gap) * (1.0 - aside).max(0.0);
        (open.max(loose_face(*sunk, section.half_width, x, low.dot(direction))), Floor::Wood)
    }
}

/// Distance of a spot from the axis of a knot in half widths of its outline [1], the direction on the outline
/// (around, along), and the knot there.
#[inline]
fn in_knot(knot: &Knot, face: &BoardFace, spot: Vec2, trunk: &Trunk) -> (f32, Vec2, KnotSection) {
    let place = trunk.place(spot.x, spot.y, face.height);
    let section = knot.section(&KnotDistance::new(place.r));
    let offset = Vec2::new(place.r * wrap(place.phi - section.phi), place.l - section.l);
    let offset = Vec2::new(offset.x, offset.y * knot.cos_slope);
    (knot.reach(offset, section.half_width).0, offset.normalize_or(Vec2::X), section)
}

/// How far the face of a loose knot lies below the board's [mm]: `x` half widths from its axis, where the cosine of the
/// angle from the direction of its lowest place is `towards`; it has sunk by `sunk` [mm].
#[inline]
fn loose_face(sunk: f32, half_width: f32, x: f32, towards: f32) -> f32 {
    let wall = (sunk / STEEPEST / half_width).min(0.7);
    sunk * (1.0 + LOOSE_TILT * x * towards) * (1.0 - smoothstep(1.0 - wall, 1.0, x))
}

/// The deepest place of such a face [mm].
fn deepest_of_face(sunk: f32, half_width: f32) -> f32 {
    const PLACES: u16 = 100;
    (0..=PLACES).map(|i| loose_face(sunk, half_width, f32::from(i) / f32::from(PLACES), 1.0)).fold(0.0, f32::max)
}
