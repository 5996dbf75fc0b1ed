//! Score line and debossed mark of a tablet's marked face.
//!
//! Models: a groove across the tablet and two digits of dots, as depths below the face that is seen from above. They
//! lower what light from above meets and tilt it; the solids themselves stay convex and do not have them.

use base::Stream;
use glam::{Vec2, Vec3};

use super::parameters::Tablet;
use super::solid::{Solid, SolidShape};
use super::tablet::TabletForm;
use super::texture::{digit, digits, hump};

/// Half the width of the score over its depth, and the least one [1, mm].
const SCORE: [f32; 2] = [1.2, 0.3];
/// Size of a dot over half the tablet's width [1].
const DOT: f32 = 0.11;

/// How far off the marked face a place may be [mm].
const ON_FACE_MM: f32 = 0.003;

/// The marked face of a pack's tablets.
#[derive(Debug, Clone)]
pub struct TabletFace {
    score: f32,
    deboss: f32,
    dot: f32,
    digits: [u16; 2],
    scale: Vec3,
    shape: SolidShape,
}

impl TabletFace {
    /// The face of these tablets.
    pub fn new(stream: Stream, tablet: &Tablet, form: &TabletForm) -> Self {
        let key = stream.child("deboss").key();
        Self {
            score: tablet.score_mm as f32,
            deboss: tablet.deboss_mm as f32,
            dot: DOT * form.outline().half().y,
            digits: [digit(key >> 32), digit(key >> 40)],
            scale: form.scale,
            shape: form.shape,
        }
    }

    /// Depth at a place of a tablet's upper side [mm], and its slope along x and y [1].
    pub fn depth(&self, solid: &Solid, at: Vec3) -> (f32, Vec2) {
        let own = solid.own(at);
        let away = Vec2::new(own.x - own.x.clamp(-self.shape.segment, self.shape.segment), own.y);
        // Faces of fracture, sides and the other face have no mark.
        if own.z < self.shape.top(away.length()) - ON_FACE_MM {
            return (0.0, Vec2::ZERO);
        }
        let p = (own * self.scale).truncate();
        let half = (SCORE[0] * self.score).max(SCORE[1]);
        let (groove, steep) = hump((p.x / half).clamp(-1.0, 1.0));
        let mut depth = self.score * groove;
        let mut slope = Vec2::new(self.score * steep / half, 0.0);
        let corner = Vec2::new(-3.5, -2.5) * self.dot;
        let dots = (p - corner) / self.dot;
        if self.deboss > 0.0 && dots.min_element() > -1.0 && dots.x < 8.0 && dots.y < 6.0 {
            const H: f32 = 0.05;
            let height = |d: Vec2| self.deboss * digits(&self.digits, d);
            depth += height(dots);
            let rise = |step: Vec2| (height(dots + step) - height(dots - step)) / (2.0 * H * self.dot);
            slope += Vec2::new(rise(H * Vec2::X), rise(H * Vec2::Y));
        }
        (depth, solid.slope(self.scale, slope))
    }
}
