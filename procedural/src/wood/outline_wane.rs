//! Wane where the outline of the stem leaves the board.
//!
//! Models: where the upper face lies beyond the outline (`stem`), the surface is the outline: the highest point z of
//! the column with
//! r(x, y, z) <= rho(phi, l), found between the face and the point of the column that is nearest to the pith. It is
//! rough, and bark or the bare surface below it, as the wane that is drawn. Where the whole column lies beyond the
//! outline, a thin sheet is left. Sources: geometry; roughness and patches as in `opening_floor`. Limits: bark has no
//! thickness of its own; the narrow sides and the lower face keep their straight edges; knots that would lie beyond the
//! outline keep their instances.

use std::sync::Arc;

use base::{Class, Instance, Stream};
use glam::Vec2;

use super::Wood;
use super::board_face::BoardFace;
use super::opening_floor::{BarkCover, FLOOR_MM, Floor};
use super::openings::{LABELLED_MM, Opening, OpeningForm, Openings};
use super::pith::Trunk;
use super::stem::StemCut;

/// Steps in which the face is looked at, across and along [mm].
const GRID_MM: Vec2 = Vec2::new(1.0, 8.0);
/// Most of them each way.
const GRID_MOST: f32 = 400.0;
/// Steps to the root, and how near is near enough [mm].
const ROOT_STEPS: usize = 24;
const ROOT_MM: f32 = 4.0e-6;

/// The outline beyond a board, and what its surface is like.
#[derive(Debug, Clone)]
pub(super) struct OutlineWane {
    cut: StemCut,
    height: f32,
    bark: BarkCover,
}

impl OutlineWane {
    /// Of a board.
    pub fn new(stream: Stream, wood: &Wood, cut: &StemCut) -> Self {
        Self { cut: cut.clone(), height: wood.board.thickness_mm as f32, bark: BarkCover::new(stream, wood.wane.bark) }
    }

    /// How far the outline lies below the face [mm]; 0 where the face is inside of it.
    fn below_face(&self, spot: Vec2, trunk: &Trunk) -> f32 {
        let beyond = |z: f32| {
            let place = trunk.place(spot.x, spot.y, z);
            place.r - self.cut.radius(place.phi, place.l)
        };
        let mut outside = (self.height, beyond(self.height));
        if outside.1 <= 0.0 {
            return 0.0;
        }
        let place = trunk.place(spot.x, spot.y, self.height);
        let nearest = (self.height - place.r * place.outward.y).clamp(FLOOR_MM.min(self.height), self.height);
        let mut inside = (nearest, beyond(nearest));
        if inside.1 > 0.0 {
            return (self.height - FLOOR_MM).max(0.0);
        }
        // Regula falsi; an end that stays twice counts half (Illinois).
        let mut kept = 0;
        for _ in 0..ROOT_STEPS {
            let z = (outside.0 * inside.1 - inside.0 * outside.1) / (inside.1 - outside.1);
            let at = (z, beyond(z));
            if at.1.abs() < ROOT_MM || inside.0 == outside.0 {
                return self.height - z;
            }
            if at.1 > 0.0 {
                outside = at;
                inside.1 *= if kept == 1 { 0.5 } else { 1.0 };
                kept = 1;
            } else {
                inside = at;
                outside.1 *= if kept == -1 { 0.5 } else { 1.0 };
                kept = -1;
            }
        }
        self.height - 0.5 * (inside.0 + outside.0)
    }

    /// Makes the wane of each half of the face that has some; `edges` says where the board's edges lie at a place along
    /// the scan, from its middle [mm].
    pub fn open(
        self,
        openings: &mut Openings,
        trunk: &Trunk,
        edges: impl Fn(f32) -> [f32; 2],
        instances: &mut Vec<Instance>,
    ) {
        let (face, class) = (openings.face, Class::Wane);
        let half = face.half + Vec2::new(face.edge_room, 0.0);
        let size = 2.0 * half;
        let count = (size / GRID_MM).ceil().clamp(Vec2::ONE, Vec2::splat(GRID_MOST));
        let step = size / count;
        let mut halves: [Vec<(Vec2, f32)>; 2] = [Vec::new(), Vec::new()];
        for j in 0..count.y as usize {
            let [left, right] = edges(face.middle.y - half.y + step.y * (j as f32 + 0.5));
            for i in 0..count.x as usize {
                let spot = face.middle - half + step * Vec2::new(i as f32 + 0.5, j as f32 + 0.5);
                if !(left..=right).contains(&(spot.x - face.middle.x)) {
                    continue;
                }
                let down = self.below_face(spot, trunk);
                if down > 0.0 {
                    halves[usize::from(spot.x > face.middle.x)].push((spot, down));
                }
            }
        }
        let form = Arc::new(self);
        for (side, found) in halves.into_iter().enumerate().filter(|(_, found)| !found.is_empty()) {
            let (mut low, mut high, mut spot, mut depth) = (Vec2::INFINITY, Vec2::NEG_INFINITY, Vec2::ZERO, 0.0f32);
            for (at, down) in &found {
                (low, high) = (low.min(*at - step), high.max(*at + step));
                spot += *at / found.len() as f32;
                depth = depth.max(*down);
            }
            // Each spot of the face is of one half alone, and the edge can lie anywhere in its room.
            if side == 0 {
                (low.x, high.x) = (low.x.min(face.middle.x - half.x), high.x.min(face.middle.x))
            } else {
                (low.x, high.x) = (low.x.max(face.middle.x), high.x.max(face.middle.x + half.x))
            }
            let width = found.len() as f32 * step.x * step.y / size.y;
            let id = openings.note(instances, class, spot, [width, depth], Some(width / (2.0 * face.half.x)));
            openings.add(Opening { class, id, low, high, labelled: LABELLED_MM, form: form.clone() });
        }
    }
}

impl OpeningForm for OutlineWane {
    fn depth(&self, _: &BoardFace, spot: Vec2, trunk: &Trunk) -> (f32, Floor) {
        let down = self.below_face(spot, trunk);
        if down <= 0.0 {
            return (0.0, Floor::Wood);
        }
        let (rough, floor) = self.bark.at(spot, down);
        ((down + rough).clamp(0.0, (self.height - FLOOR_MM).max(0.0)), floor)
    }
}
