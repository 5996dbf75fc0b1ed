//! Wane that is asked for along one edge: the log's surface, a slope from a wandering line on the face down to the
//! side, bent as the ring there is. Wane of a board that is sawn from a stem is in `outline_wane`.

use std::sync::Arc;

use base::Need::{Amount, Any};
use base::{Class, parameters};
use glam::Vec2;

use super::board_face::BoardFace;
use super::opening_floor::{BarkCover, FLOOR_MM, Floor};
use super::openings::{LABELLED_MM, OpenedBoard, Opening, OpeningForm, Openings};
use super::pith::Trunk;
use crate::noise::Noise;

/// Wander of the wane's line over its width, root mean square [1], and its cell along the board [mm].
const WANE_WANDER: [f32; 2] = [0.3, 70.0];

parameters! {
    /// Wane: the log's own surface where the board has no arris.
    wane: Wane {
        /// How far it reaches over the face, mean; 0 for none.
        width_mm: 0.0, 500.0, 0.0, "[L] 5 to 30", fixed;
        /// Which long edge: -1 or 1.
        edge: -1.0, 1.0, 1.0, "free", one_of(-1.0, 1.0), of [Amount("wane.width_mm")];
        /// Slope of the log's surface against the face.
        angle_deg: 5.0, 80.0, 35.0, "[E]", uniform(25.0, 45.0), of [Amount("wane.width_mm")];
        /// Share of it that still has bark.
        bark: 0.0, 1.0, 0.5, "free; spread [M]", uniform(0.0, 1.0), of [Any(&["wane.width_mm", "stem.outline_wane"])];
    }
}

/// The surface of the log.
#[derive(Debug)]
struct Slope {
    /// -1 or 1.
    side: f32,
    width: f32,
    slope: f32,
    /// One over twice the radius of the log [mm^-1].
    bend: f32,
    line: Noise,
    bark: BarkCover,
}

/// Makes the wane that is asked for.
pub(super) fn grow(openings: &mut Openings, board: &mut OpenedBoard) {
    let (asked, face, stream) = (&board.wood.wane, openings.face, board.stream.child("wane"));
    if asked.width_mm == 0.0 {
        return;
    }
    let class = Class::Wane;
    let side = if asked.edge < 0.0 { -1.0 } else { 1.0 };
    let corner = face.middle + Vec2::new(side * face.half.x, 0.0);
    let radius = board.trunk.place(corner.x, corner.y, face.height).r.max(20.0);
    let width = asked.width_mm as f32;
    let spot = corner - Vec2::new(side * 0.5 * width, 0.0);
    let (slope, bend) = (libm::tan(asked.angle_deg.to_radians()) as f32, 0.5 / radius);
    // At the side of the board, where it is as wide as its mean.
    let depth = (slope * width + bend * width * width).min(openings.room());
    let id = openings.note(board.instances, class, spot, [width, depth], Some(width / (2.0 * face.half.x)));
    let form = Arc::new(Slope {
        side,
        width,
        slope,
        bend,
        line: Noise::new(stream.child("line")),
        bark: BarkCover::new(stream, asked.bark),
    });
    let reach = width * (1.0 + 4.0 * WANE_WANDER[0]);
    let (inner, outer) = (Vec2::new(side * reach, 0.0), Vec2::new(side * face.edge_room, 0.0));
    let (low, high) = ((corner - inner).min(corner + outer), (corner - inner).max(corner + outer));
    let long = Vec2::new(0.0, face.half.y);
    openings.add(Opening { class, id, low: low - long, high: high + long, labelled: LABELLED_MM, form });
}

impl OpeningForm for Slope {
    fn depth(&self, face: &BoardFace, spot: Vec2, _: &Trunk) -> (f32, Floor) {
        let Self { side, width, slope, bend, line, bark } = self;
        let along = spot.y - face.middle.y;
        let inwards = face.half.x - side * (spot.x - face.middle.x);
        let edge = width * (1.0 + WANE_WANDER[0] * line.line(along / WANE_WANDER[1]).0).max(0.0);
        let down = edge - inwards;
        if down <= 0.0 {
            return (0.0, Floor::Wood);
        }
        let (rough, floor) = bark.at(spot, down);
        let depth = slope * down + bend * down * down + rough;
        (depth.clamp(0.0, (face.height - FLOOR_MM).max(0.0)), floor)
    }
}
