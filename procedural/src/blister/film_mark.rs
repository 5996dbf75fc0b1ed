//! Places where the film is raised, dented or holed.
//!
//! Models: an ellipse or a strip with round ends, over which the height goes as s(t) = (1 - t^2)^2 from its middle to
//! its border, so that height and slope leave off smoothly. Film over a tablet on the flange follows the tablet's upper
//! side, with a crease over its edge.

use base::Class;
use glam::Vec2;

use super::outline::{Outline, OutlinePoint};
use super::texture::hump;

/// What a mark does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MarkKind {
    /// Film that has come off the foil.
    Raised,
    /// Film pressed in, until it meets what lies below.
    Dent,
    /// No film.
    Hole,
    /// No foil.
    Pinhole,
    /// Film drawn over a tablet on the flange.
    Tent,
}

/// A mark on the card.
#[derive(Debug, Clone, Copy)]
pub struct FilmMark {
    /// What it does.
    pub kind: MarkKind,
    /// Class of its pixels.
    pub class: Class,
    /// Instance of its pixels.
    pub instance: u16,
    /// Middle [mm].
    pub middle: Vec2,
    /// Direction of its length [1].
    pub axis: Vec2,
    /// Its outline.
    pub outline: Outline,
    /// Height or depth [mm].
    pub height: f32,
    /// Width of the slope around a tent [mm].
    pub skirt: f32,
    /// Share of its height that a tent is lower over the tablet's edge [1].
    pub sag: f32,
}

impl FilmMark {
    /// Half the box around it [mm].
    pub fn reach(&self) -> Vec2 {
        self.outline.reach(self.axis)
    }

    /// Share of its height at `p` [1] and the gradient [1/mm]; `None` outside.
    #[inline]
    pub fn at(&self, p: Vec2) -> Option<(f32, Vec2)> {
        let d = p - self.middle;
        let own = Vec2::new(self.axis.dot(d), self.axis.perp_dot(d));
        if (own.abs() - self.outline.half()).max_element() >= 0.0 {
            return None;
        }
        let (share, gradient) = if self.kind == MarkKind::Tent {
            match self.outline.place(own, self.skirt) {
                OutlinePoint::Roof(square, gradient) => (1.0 - self.sag * square, -self.sag * gradient),
                OutlinePoint::Wall(inset, _) if inset <= 0.0 => return None,
                OutlinePoint::Wall(inset, way) => {
                    let (share, slope) = hump(1.0 - inset / self.skirt);
                    let rim = 1.0 - self.sag;
                    (rim * share, -rim * slope / self.skirt * way)
                }
            }
        } else {
            let (t, way) = match self.outline {
                Outline::Stadium { segment, radius } => {
                    let away = Vec2::new(own.x - own.x.clamp(-segment, segment), own.y) / radius;
                    (away, Vec2::splat(1.0 / radius))
                }
                Outline::Ellipse { long, short } => {
                    let half = Vec2::new(long, short);
                    (own / half, 1.0 / half)
                }
            };
            let left = 1.0 - t.length_squared();
            if left <= 0.0 {
                return None;
            }
            (left * left, -4.0 * left * t * way)
        };
        Some((share, gradient.x * self.axis + gradient.y * self.axis.perp()))
    }
}
