//! Defects of the film and the foil of a pocket: dents, holes, channels through its seal.
//!
//! Models: each is a [`FilmMark`] whose size grows with the severity; docs/theory/blister.md has the ranges.

use glam::Vec2;
use rand::RngExt;
use rand_xoshiro::Xoshiro256PlusPlus;

use super::{PlannedDefect, graded};
use crate::blister::Pack;
use crate::blister::film_mark::{FilmMark, MarkKind};
use crate::blister::outline::Outline;
use crate::blister::solid::Solid;
use crate::blister::web::PocketCell;

/// What the marks of a pocket draw from.
pub struct MarkDraw<'a> {
    pack: &'a Pack,
    planned: &'a PlannedDefect,
    cell: PocketCell,
    instance: u16,
    /// The first solid in the pocket, with half the width of its tablet [mm].
    tablet: Option<(&'a Solid, f32)>,
    rng: Xoshiro256PlusPlus,
    /// A direction, and how far along it a place is that is even over a disc [1].
    pub way: Vec2,
    far: f32,
}

impl<'a> MarkDraw<'a> {
    /// Of a planned defect that gets this number.
    pub fn new(pack: &'a Pack, planned: &'a PlannedDefect, instance: u16, tablet: Option<(&'a Solid, f32)>) -> Self {
        let mut rng = planned.stream.child("mark").rng();
        let (sine, cosine) = libm::sincosf(std::f32::consts::TAU * rng.random::<f32>());
        let (way, far) = (Vec2::new(cosine, sine), rng.random::<f32>().sqrt());
        Self { pack, planned, cell: pack.web.cells[planned.cell], instance, tablet, rng, way, far }
    }

    /// An even number below 1 [1].
    pub fn even(&mut self) -> f32 {
        self.rng.random()
    }

    /// `from` at severity 0 and `to` at severity 1.
    pub fn graded(&self, from: f32, to: f32) -> f32 {
        graded(self.planned.severity, from, to)
    }

    /// The drawn place within this share of the pocket [mm].
    pub fn place(&self, share: f32) -> Vec2 {
        let formed = &self.pack.web.formed;
        let p = share * self.far * formed.outline.half() * self.way;
        self.cell.middle + p.x * formed.axis + p.y * formed.axis.perp()
    }

    /// The mark that it makes.
    pub fn mark(&self, kind: MarkKind, middle: Vec2, axis: Vec2, outline: Outline, height: f32) -> FilmMark {
        let (class, instance) = (self.planned.kind.class, self.instance);
        FilmMark { kind, class, instance, middle, axis, outline, height, skirt: 0.0, sag: 0.0 }
    }
}

/// An ellipse of that length, `slim` times as wide [mm].
fn ellipse(size: f32, slim: f32) -> Outline {
    Outline::Ellipse { long: 0.5 * size, short: 0.5 * size * slim }
}

/// A dent; over a tablet it stays within its outline, so that the film can rest on it.
pub fn collapsed(draw: &mut MarkDraw) -> FilmMark {
    let (middle, room) = match draw.tablet {
        Some((solid, short)) => {
            let middle = 0.5 * (solid.bounds[0] + solid.bounds[1]);
            (draw.pack.lay.card(middle.x, middle.y), 1.7 * short)
        }
        None => (draw.place(0.2), 1.2 * draw.pack.web.formed.outline.half().y),
    };
    let outline = ellipse(draw.graded(3.0, 8.0).min(room), 0.8 + 0.2 * draw.even());
    draw.mark(MarkKind::Dent, middle, draw.way, outline, draw.graded(0.5, 3.0))
}

/// A hole in the film.
pub fn punctured(draw: &mut MarkDraw) -> FilmMark {
    let outline = ellipse(draw.graded(0.2, 2.0), 0.6 + 0.4 * draw.even());
    draw.mark(MarkKind::Hole, draw.place(0.85), draw.way.perp(), outline, 0.0)
}

/// A hole in the foil.
pub fn pinhole(draw: &mut MarkDraw) -> FilmMark {
    let outline = ellipse(draw.graded(0.02, 0.3), 0.7 + 0.3 * draw.even());
    draw.mark(MarkKind::Pinhole, draw.place(0.9), draw.way.perp(), outline, 0.0)
}

/// A channel through the seal, which leaves the pocket along one of its axes.
pub fn channel(draw: &mut MarkDraw) -> FilmMark {
    let formed = &draw.pack.web.formed;
    let half = formed.outline.half();
    let (side, reach) = if draw.even() < 0.5 { (formed.axis, half.x) } else { (formed.axis.perp(), half.y) };
    let side = if draw.even() < 0.5 { side } else { -side };
    let (width, length) = (draw.graded(0.5, 3.0), 2.0 + 4.0 * draw.even());
    let outline = Outline::Stadium { segment: 0.5 * length, radius: 0.5 * width };
    let middle = draw.cell.middle + (reach + 0.5 * length) * side;
    draw.mark(MarkKind::Raised, middle, side, outline, draw.graded(0.03, 0.15))
}
