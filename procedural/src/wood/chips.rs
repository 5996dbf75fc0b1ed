//! Chipped arrises: a splinter is lost, half an ellipse on the face with an uneven outline, whose floor falls from it
//! to the side. Chips have no label and come after all other openings: they leave the label of what they cut.

use std::sync::Arc;

use base::{Class, lognormal};
use glam::Vec2;
use rand::RngExt;

use super::board_face::BoardFace;
use super::opening_floor::Floor;
use super::openings::{LOG_SD, OpenedBoard, Opening, OpeningForm, Openings};
use super::pith::Trunk;
use crate::noise::Noise;

/// Width across and depth of a chip over its length along the arris [1].
const CHIP_SHAPE: [f32; 2] = [0.25, 0.2];
/// Unevenness of a chip's outline and floor, root mean square [1], and its cells across and along [mm].
const CHIP_UNEVEN: f32 = 0.2;
/// Most of that unevenness [root mean squares].
const CHIP_MOST: f32 = 5.0;
const CHIP_CELL_MM: Vec2 = Vec2::new(1.2, 6.0);

/// A chip.
#[derive(Debug)]
struct Chip {
    /// Middle of the chip on the arris.
    arris: Vec2,
    /// -1 or 1.
    side: f32,
    half: Vec2,
    depth: f32,
    uneven: Noise,
}

/// Makes the chips that are asked for.
pub(super) fn grow(openings: &mut Openings, board: &mut OpenedBoard) {
    let (asked, face) = (&board.wood.marks, openings.face);
    for index in 0..asked.chip_count.round() as u64 {
        let own = board.stream.child("chip").index(index);
        let mut rng = own.rng();
        let side = if rng.random::<bool>() { 1.0 } else { -1.0 };
        let along = 2.0 * rng.random::<f32>() - 1.0;
        let length = lognormal(&mut rng, asked.chip_mm, LOG_SD) as f32;
        let depth = (CHIP_SHAPE[1] * length).min(0.5 * face.height).min(openings.room());
        let half = Vec2::new((CHIP_SHAPE[0] * length).min(0.5 * face.half.x), 0.5 * length);
        let arris = face.middle + face.half * Vec2::new(side, along);
        let room = (1.0 + CHIP_MOST * CHIP_UNEVEN) * half + Vec2::new(face.edge_room, 0.0);
        let form = Arc::new(Chip { arris, side, half, depth, uneven: Noise::new(own.child("uneven")) });
        let (low, high) = (arris - room, arris + room);
        openings.add(Opening { class: Class::Clear, id: 0, low, high, labelled: f32::INFINITY, form });
    }
}

impl OpeningForm for Chip {
    fn depth(&self, _: &BoardFace, spot: Vec2, _: &Trunk) -> (f32, Floor) {
        let Self { arris, side, half, depth, uneven } = self;
        let uneven = (1.0 + CHIP_UNEVEN * uneven.fibres((spot - arris) / CHIP_CELL_MM).0).max(0.2);
        let q = (spot - arris) / Vec2::new(half.x * uneven, half.y);
        // Inwards from the arris along a chord of the outline; where the edge wanders outwards nothing is left
        // beside it.
        let (chord, inwards) = ((1.0 - q.y * q.y).max(0.0).sqrt(), (-side * q.x).max(0.0));
        (depth * chord * (1.0 - inwards / chord.max(1.0e-3)).max(0.0), Floor::Wood)
    }
}
