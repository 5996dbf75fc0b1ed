//! Insect holes.
//!
//! Models: a hole is round across its axis, stands upright and has walls that fall by [`STEEPEST`]. It shows the
//! darkened wall of a gallery, or is full of frass almost to the face. Sources: sizes in docs/theory/wood.md.

use std::sync::Arc;

use base::{Class, Need::Amount, lognormal, parameters};
use glam::Vec2;
use rand::RngExt;

use super::board_face::BoardFace;
use super::opening_floor::Floor;
use super::openings::{LABELLED_MM, LOG_SD, OpenedBoard, Opening, OpeningForm, Openings, STEEPEST};
use super::pith::Trunk;
use crate::noise::smoothstep;

parameters! {
    /// Insect holes.
    holes: Holes {
        /// Holes in the upper surface.
        count: 0.0, 200.0, 0.0, "per board", fixed, count;
        /// Median diameter.
        diameter_mm: 0.5, 20.0, 1.6, "[L] pin holes to 2, longhorn beetles 4 to 10; spread [M]", log_uniform(1.0, 8.0),
            of [Amount("holes.count")];
        /// Depth.
        depth_mm: 0.3, 50.0, 6.0, "[E]", log_uniform(3.0, 12.0), of [Amount("holes.count")];
        /// Share of the holes that are full of frass almost to the face.
        frass: 0.0, 1.0, 0.2, "[E]", uniform(0.05, 0.5), of [Amount("holes.count")];
    }
}

/// A hole.
#[derive(Debug)]
struct Hole {
    centre: Vec2,
    /// Half its size along and across the log [mm].
    half: Vec2,
    depth: f32,
    frass: bool,
}

/// Makes the holes that are asked for.
pub(super) fn grow(openings: &mut Openings, board: &mut OpenedBoard) {
    let (asked, face) = (&board.wood.holes, openings.face);
    let class = Class::InsectHole;
    for index in 0..asked.count.round() as u64 {
        let mut rng = board.stream.child("hole").index(index).rng();
        let spot = face.spot([rng.random(), rng.random()]);
        let lean = 1.0 + rng.random::<f32>();
        let frass = rng.random::<f64>() < asked.frass;
        let diameter = lognormal(&mut rng, asked.diameter_mm, LOG_SD) as f32;
        let half = 0.5 * diameter * Vec2::new(1.0, lean);
        let full = if frass { 0.15 } else { 1.0 };
        let depth = (asked.depth_mm as f32 * full).min(openings.room());
        let id = openings.note(board.instances, class, spot, [2.0 * half.y, depth], None);
        let form = Arc::new(Hole { centre: face.log_place(spot), half, depth, frass });
        let room = Vec2::splat(half.max_element());
        openings.add(Opening { class, id, low: spot - room, high: spot + room, labelled: LABELLED_MM, form });
    }
}

impl OpeningForm for Hole {
    fn depth(&self, face: &BoardFace, spot: Vec2, _: &Trunk) -> (f32, Floor) {
        let Self { centre, half, depth, frass } = self;
        let Vec2 { x: across, y: along } = face.log_place(spot);
        let q = ((across - centre.x) / half.x).powi(2) + ((along - centre.y) / half.y).powi(2);
        let wall = (depth / STEEPEST / half.x).min(0.9);
        let depth = depth * (1.0 - smoothstep(1.0 - wall, 1.0, q.sqrt()));
        (depth, if *frass { Floor::Frass } else { Floor::Gallery })
    }
}
