//! Where the upper face lies lower: cracks, holes, wane, dents, skipped places, chips.
//!
//! Models: each opening lowers the face by a depth of its own, from a file of its own ([`OpeningForm`]). Where several
//! meet, the deepest counts. Sources: widths and depths in docs/theory/wood.md. Limits: light that falls between walls
//! is thrown back once and does not light the other wall from the air; no opening passes into another.

use std::fmt::Debug;
use std::sync::Arc;

use base::{Class, Instance, Stream, Surface};
use glam::Vec2;

use super::Wood;
use super::board_face::BoardFace;
use super::knot_placement::PlacedKnot;
use super::opening_floor::{FLOOR_MM, Floor};
use super::pith::Trunk;

/// Steepest wall of a hole [1].
pub(super) const STEEPEST: f32 = 20.0;
/// Deepest place of a crack that can be found, over its width [1]: walls are lit and seen at grazing angles, and light
/// gets out by scattering alone.
pub(super) const DEEPEST_WIDTHS: f32 = 25.0;
/// Spread of the logarithms of an opening's sizes [1].
pub(super) const LOG_SD: f64 = 0.4;
/// Depth from which on a place has the opening's label [mm].
pub(super) const LABELLED_MM: f32 = 0.03;
/// Step of the differences that give slopes [mm].
const DIFFERENCE_MM: f32 = 0.004;

/// The form of an opening.
pub(super) trait OpeningForm: Debug + Send + Sync {
    /// How far a spot of the face lies lower [mm], and what is at its floor.
    fn depth(&self, face: &BoardFace, spot: Vec2, trunk: &Trunk) -> (f32, Floor);
}

/// What openings are made for.
pub(super) struct OpenedBoard<'a> {
    /// What they draw from.
    pub stream: Stream,
    /// The board's numbers.
    pub wood: &'a Wood,
    /// Where it lay in the log.
    pub trunk: &'a Trunk,
    /// Its knots.
    pub knots: &'a [PlacedKnot],
    /// Its instances so far.
    pub instances: &'a mut Vec<Instance>,
}

/// An opening at a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Opened {
    /// How far it lies below the face [mm].
    pub depth: f32,
    /// Its class and instance.
    pub class: Class,
    pub id: u16,
    /// Whether the place has its label.
    pub is_labelled: bool,
    /// What is at its floor.
    pub floor: Floor,
}

/// One opening.
#[derive(Debug, Clone)]
pub(super) struct Opening {
    /// Its class and instance.
    pub class: Class,
    pub id: u16,
    /// Box on the face: from, to [mm].
    pub low: Vec2,
    pub high: Vec2,
    /// Depth from which on a place has the label; infinite where none has [mm].
    pub labelled: f32,
    /// Its form.
    pub form: Arc<dyn OpeningForm>,
}

/// All openings of a board.
#[derive(Debug, Clone)]
pub(super) struct Openings {
    all: Vec<Opening>,
    /// The face that they lower.
    pub face: BoardFace,
}

impl Openings {
    /// None yet.
    pub fn new(wood: &Wood) -> Self {
        Self { all: Vec::new(), face: BoardFace::of(wood) }
    }

    /// Adds one; those without a label come after all others.
    pub fn add(&mut self, opening: Opening) {
        let end = match opening.labelled {
            f32::INFINITY => self.all.len(),
            _ => self.all.partition_point(|one| one.labelled < f32::INFINITY),
        };
        self.all.insert(end, opening);
    }

    /// Deepest that the board has wood for [mm].
    pub fn room(&self) -> f32 {
        (self.face.height - FLOOR_MM).max(0.0)
    }

    /// Notes an instance and returns its number; its severity is the part of the board's thickness that it takes unless
    /// another is given.
    pub fn note(
        &self,
        instances: &mut Vec<Instance>,
        class: Class,
        spot: Vec2,
        [size, depth]: [f32; 2],
        severity: Option<f32>,
    ) -> u16 {
        let id = instances.len() as u16 + 1;
        let at = [f64::from(spot.x), f64::from(spot.y)];
        let severity = f64::from(severity.unwrap_or(depth / self.face.height).min(1.0));
        let depth_mm = f64::from(depth);
        instances.push(Instance { depth_mm, ..Instance::new(id, class, at, f64::from(size), severity) });
        id
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.all.is_empty()
    }

    /// The openings that the profile at `y` crosses [mm].
    pub fn near(&self, y: f32) -> Vec<&Opening> {
        self.all.iter().filter(|one| one.low.y <= y && y <= one.high.y).collect()
    }

    /// The deepest of `near` openings at a spot of the face.
    #[inline]
    pub fn at(&self, near: &[&Opening], spot: Vec2, trunk: &Trunk) -> Option<Opened> {
        let mut deepest: Option<Opened> = None;
        for one in near {
            if spot.x < one.low.x || spot.x > one.high.x || spot.y < one.low.y || spot.y > one.high.y {
                continue;
            }
            let (depth, floor) = one.form.depth(&self.face, spot, trunk);
            if depth > deepest.map_or(0.0, |other| other.depth) {
                let is_labelled = depth > one.labelled;
                deepest = Some(match deepest {
                    // What has no label leaves that of what it cuts.
                    Some(other) if one.labelled == f32::INFINITY => Opened { depth, floor, ..other },
                    _ => Opened { depth, class: one.class, id: one.id, is_labelled, floor },
                });
            }
        }
        deepest
    }

    /// Lowers the face at a spot.
    #[inline]
    pub fn lower(&self, near: &[&Opening], spot: Vec2, trunk: &Trunk, face: Surface) -> Surface {
        let Some(opened) = self.at(near, spot, trunk) else { return face };
        let depth =
            |dx: f32, dy: f32| self.at(near, spot + Vec2::new(dx, dy), trunk).map_or(0.0, |opened| opened.depth);
        let h = DIFFERENCE_MM;
        let slope_x = (depth(h, 0.0) - depth(-h, 0.0)) / (2.0 * h);
        let slope_y = (depth(0.0, h) - depth(0.0, -h)) / (2.0 * h);
        Surface { z: face.z - opened.depth, slope_x: face.slope_x - slope_x, slope_y: face.slope_y - slope_y }
    }
}
