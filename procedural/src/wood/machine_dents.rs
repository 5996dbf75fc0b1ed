//! What machines leave lower: dents of a feed roller's teeth at a pitch, and places that the planer missed, where the
//! sawn face lies lower and is rough. Sizes are engineering estimates.

use std::sync::Arc;

use base::{Class, lognormal};
use glam::Vec2;
use rand::RngExt;

use super::board_face::BoardFace;
use super::opening_floor::Floor;
use super::openings::{LOG_SD, OpenedBoard, Opening, OpeningForm, Openings};
use super::pith::Trunk;
use crate::noise::{Noise, smoothstep};

/// Wander of the outline of a place that the planer missed, over its size, root mean square [1].
const SKIP_OUTLINE: f32 = 0.15;
/// Strands of the rough wood there, across and along [mm], and their height over the depth, root mean square [1].
const SKIP_STRAND_MM: Vec2 = Vec2::new(0.5, 5.0);
const SKIP_ROUGH: f32 = 0.15;

/// The dents of a roller.
#[derive(Debug)]
struct Roller {
    /// Middle of the band across the board [mm].
    x: f32,
    half_width: f32,
    pitch: f32,
    depth: f32,
}

/// A place that the planer missed.
#[derive(Debug)]
struct Skip {
    centre: Vec2,
    half: Vec2,
    depth: f32,
    outline: Noise,
    rough: Noise,
}

/// Makes the marks of a roller.
pub(super) fn roll(openings: &mut Openings, board: &mut OpenedBoard) {
    let (asked, face, class) = (&board.wood.marks, openings.face, Class::RollerMark);
    if asked.roller_um == 0.0 {
        return;
    }
    let x = face.spot([board.stream.child("roller").rng().random(), 0.5]).x;
    let (half_width, depth) = (0.5 * asked.roller_width_mm as f32, 1.0e-3 * asked.roller_um as f32);
    let middle = Vec2::new(x, face.middle.y);
    let id = openings.note(board.instances, class, middle, [2.0 * face.half.y, depth], None);
    let form = Arc::new(Roller { x, half_width, pitch: asked.roller_pitch_mm as f32, depth });
    let room = Vec2::new(half_width, face.half.y);
    let (low, high) = (middle - room, middle + room);
    openings.add(Opening { class, id, low, high, labelled: 0.25 * depth, form });
}

/// Leaves the places that the planer missed.
pub(super) fn skip(openings: &mut Openings, board: &mut OpenedBoard) {
    let (asked, face, class) = (&board.wood.marks, openings.face, Class::PlanerSkip);
    for index in 0..asked.skip_count.round() as u64 {
        let own = board.stream.child("skip").index(index);
        let mut rng = own.rng();
        let centre = face.spot([rng.random(), rng.random()]);
        let length = lognormal(&mut rng, asked.skip_mm, LOG_SD) as f32;
        let depth = 1.0e-3 * asked.skip_um as f32;
        let half = 0.5 * length * Vec2::new(1.0 / 3.0, 1.0);
        let id = openings.note(board.instances, class, centre, [length, depth], None);
        let [outline, rough] = ["outline", "rough"].map(|name| Noise::new(own.child(name)));
        let form = Arc::new(Skip { centre, half, depth, outline, rough });
        let room = 1.6 * half;
        let (low, high) = (centre - room, centre + room);
        openings.add(Opening { class, id, low, high, labelled: 0.5 * depth, form });
    }
}

impl OpeningForm for Roller {
    fn depth(&self, _: &BoardFace, spot: Vec2, _: &Trunk) -> (f32, Floor) {
        let Self { x, half_width, pitch, depth } = self;
        let aside = (spot.x - x) / half_width;
        // Teeth stand in two staggered rows.
        let turn = spot.y / pitch + if aside < 0.0 { 0.5 } else { 0.0 };
        let (along, across) = (4.0 * (turn - (turn + 0.5).floor()), 2.0 * aside.abs() - 1.0);
        let inside = (1.0 - along * along).max(0.0) * (1.0 - across * across).max(0.0);
        (depth * inside, Floor::Wood)
    }
}

impl OpeningForm for Skip {
    fn depth(&self, face: &BoardFace, spot: Vec2, _: &Trunk) -> (f32, Floor) {
        let Self { centre, half, depth, outline, rough } = self;
        let q = (spot - centre) / half;
        let edge = 1.0 + SKIP_OUTLINE * outline.plane(2.0 * q).0;
        let share = 1.0 - smoothstep(edge - 0.15, edge + 0.15, q.length());
        if share == 0.0 {
            return (0.0, Floor::Wood);
        }
        let torn = rough.fibres(face.log_place(spot) / SKIP_STRAND_MM).0;
        ((depth * share * (1.0 + SKIP_ROUGH * torn)).max(0.0), Floor::Wood)
    }
}
