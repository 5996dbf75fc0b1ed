//! What machines leave lower: dents of a feed roller's teeth at a pitch, and places that the planer missed, where the
//! sawn face lies lower and is rough. Teeth are worn each in its own way and come round again with the roller, whose
//! pressure comes and goes: a dent is an oval that is smaller where it is shallower. Sizes are engineering estimates.

use std::sync::Arc;

use base::{Class, lognormal};
use glam::Vec2;
use rand::RngExt;

use super::board_face::BoardFace;
use super::opening_floor::Floor;
use super::openings::{LOG_SD, OpenedBoard, Opening, OpeningForm, Openings};
use super::pith::Trunk;
use crate::noise::{Noise, smoothstep};

/// Teeth around a roller.
const ROLLER_TEETH: i32 = 61;
/// Most depth that a tooth has lost, that pressure takes or adds, root mean square [1], and the pressure's cell [mm].
const TOOTH_WEAR: f32 = 0.8;
const PRESSURE: f32 = 0.35;
const PRESSURE_MM: f32 = 30.0;
/// Half size of a whole dent: of the row's width and of the pitch; how far teeth stand aside, of the same [1].
const DENT: Vec2 = Vec2::new(0.85, 0.3);
const TOOTH_ASIDE: Vec2 = Vec2::new(0.3, 0.2);
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
    teeth: Noise,
    pressure: Noise,
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
    let own = board.stream.child("roller");
    let x = face.spot([own.rng().random(), 0.5]).x;
    let [teeth, pressure] = ["teeth", "pressure"].map(|name| Noise::new(own.child(name)));
    let (half_width, depth) = (0.5 * asked.roller_width_mm as f32, 1.0e-3 * asked.roller_um as f32);
    let middle = Vec2::new(x, face.middle.y);
    let id = openings.note(board.instances, class, middle, [2.0 * face.half.y, depth], None);
    let form = Arc::new(Roller { x, half_width, pitch: asked.roller_pitch_mm as f32, depth, teeth, pressure });
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
        let Self { x, half_width, pitch, depth, teeth, pressure } = self;
        let aside = (spot.x - x) / half_width;
        // Teeth stand in two staggered rows.
        let row = i32::from(aside < 0.0);
        let turn = spot.y / pitch + 0.5 * row as f32;
        let tooth = turn.floor();
        let [wear, left, before, _] = teeth.cell((tooth as i32).rem_euclid(ROLLER_TEETH), row);
        let pressed = 1.0 + PRESSURE * pressure.line(spot.y / PRESSURE_MM).0;
        let much = pressed * (1.0 - TOOTH_WEAR * wear * wear);
        let off =
            Vec2::new(2.0 * aside.abs() - 1.0, turn - tooth - 0.5) - TOOTH_ASIDE * (Vec2::new(left, before) - 0.5);
        // The deeper a tooth goes, the more of it goes in.
        let reach = (off / DENT).length_squared() / much.clamp(0.1, 1.0);
        (depth * much.clamp(0.0, 1.0) * (1.0 - reach).max(0.0), Floor::Wood)
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
