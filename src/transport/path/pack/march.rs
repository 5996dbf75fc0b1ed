//! Straight ways through a pack, from cell to cell, as in a body of wood.
//!
//! Within a cell the crossing of a way with a face, a hyperbolic paraboloid, is the root of a quadratic equation.

use glam::{DVec2, DVec3};

use super::shape::{Face, Shape};

/// A little over a cell's border, so that the next way begins beyond it [mm].
const OVER_MM: f64 = 1e-9;

/// Where light is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Realm {
    /// In the air above the film.
    Above,
    /// In the film.
    Film,
    /// In the air below the film, in a hole or beside the card.
    Under,
    /// In the solid of this number.
    Solid(usize),
}

/// What ends a straight way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Stop {
    /// Its given length.
    Length,
    /// A face in this cell.
    Face(Face, usize),
    /// Another realm, without a surface between.
    Realm(Realm),
    /// The conveyor.
    Ground,
    /// The open sky, or the region's end in the open.
    Beyond,
    /// The region's end, in or under the film.
    Astray,
}

impl Shape {
    /// Follows a way outside of solids from `place` for at most `length` [mm]: how far it goes [mm], and what ends it.
    #[inline]
    pub fn march(&self, place: DVec3, way: DVec3, realm: Realm, length: f64) -> (f64, Stop) {
        let local = (DVec2::new(place.x, place.y) - self.low) / self.pitch;
        let mut cell = [local.x.floor() as i64, local.y.floor() as i64];
        let mut next: [f64; 2] = std::array::from_fn(|axis| match way[axis] {
            0.0 => f64::INFINITY,
            along => {
                let border = (cell[axis] + i64::from(along > 0.0)) as f64 - local[axis];
                border * self.pitch[axis] / along
            }
        });
        let step: [f64; 2] = std::array::from_fn(|axis| (self.pitch[axis] / way[axis]).abs());
        let (mut gone, mut open) = (0.0f64, false);
        loop {
            if (0..2).any(|axis| cell[axis] < 0 || cell[axis] >= self.size[axis] as i64) {
                let covered = realm == Realm::Film || (realm == Realm::Under && !open && gone > 0.0);
                return (gone, if covered { Stop::Astray } else { Stop::Beyond });
            }
            let number = cell[1] as usize * self.size[0] + cell[0] as usize;
            let here = &self.cells[number];
            let axis = usize::from(next[1] < next[0]);
            let end = next[axis].max(gone).min(length);
            let start = place + way * gone;
            let far = place.z + way.z * end;
            let (low, high) = (start.z.min(far), start.z.max(far));
            let mut stop = (end - gone, None);
            let mut meet = |face: Face, side: f64| {
                let length = self.crossing(number, face, start, way, side);
                if length <= stop.0 {
                    stop = (length, Some(Stop::Face(face, number)));
                }
            };
            match realm {
                Realm::Film => {
                    if !here.film {
                        return (gone + OVER_MM, Stop::Realm(Realm::Under));
                    }
                    if high >= here.low[0] {
                        meet(Face::Upper, 1.0);
                    }
                    if low <= here.high[1] {
                        meet(Face::Lower, -1.0);
                    }
                }
                Realm::Above => {
                    if !here.film {
                        return (gone + OVER_MM, Stop::Realm(Realm::Under));
                    }
                    if way.z >= 0.0 && start.z > self.top {
                        return (gone, Stop::Beyond);
                    }
                    if low <= here.high[0] {
                        meet(Face::Upper, -1.0);
                    }
                }
                Realm::Under | Realm::Solid(_) => {
                    if here.film {
                        if open && start.z > self.height(number, Face::Upper, start) {
                            return (gone + OVER_MM, Stop::Realm(Realm::Above));
                        }
                        if high >= here.low[1] {
                            meet(Face::Lower, 1.0);
                        }
                    } else if way.z >= 0.0 && start.z > self.top {
                        return (gone, Stop::Beyond);
                    }
                    if here.foil {
                        if low <= here.high[2] {
                            meet(Face::Foil, -1.0);
                        }
                    } else if low < 0.0 && way.z < 0.0 {
                        let down = (-start.z / way.z).max(0.0);
                        if down <= stop.0 {
                            stop = (down, Some(Stop::Ground));
                        }
                    }
                    open = !here.film;
                }
            }
            if let (length, Some(what)) = stop {
                return (gone + length, what);
            }
            if end >= length {
                return (length, Stop::Length);
            }
            gone = end;
            cell[axis] += if way[axis] > 0.0 { 1 } else { -1 };
            next[axis] += step[axis];
        }
    }

    /// Whether a way in the film that ends at `end` meets nothing: it ends in the cell where it began, between all that
    /// bounds the film there.
    #[inline(always)]
    pub fn stays(&self, end: DVec3, cell: usize) -> bool {
        let here = &self.cells[cell];
        let half = 0.5 * self.pitch;
        (end.x - here.middle.x).abs() < half.x
            && (end.y - here.middle.y).abs() < half.y
            && end.z > here.high[1]
            && end.z < here.low[0]
    }

    /// Length from `start` to where a way comes above a face in this cell (`side` 1) or below it (-1); infinite if it
    /// does not [mm].
    #[inline]
    fn crossing(&self, cell: usize, face: Face, start: DVec3, way: DVec3, side: f64) -> f64 {
        let [h, x, y, xy] = self.corners(cell, face);
        let at = self.within(cell, start);
        let (du, dv) = (way.x / self.pitch.x, way.y / self.pitch.y);
        let (rise_x, rise_y, twist) = (x - h, y - h, h + xy - x - y);
        // Height over the face along the way: a t^2 + b t + c; it rises through 0 where light gets to the other side.
        let a = side * -twist * du * dv;
        let b = side * (way.z - rise_x * du - rise_y * dv - twist * (at.x * dv + at.y * du));
        let c = side * (start.z - h - rise_x * at.x - rise_y * at.y - twist * at.x * at.y);
        if c >= 0.0 && b > 0.0 {
            // On the face, or beyond it by rounding.
            return 0.0;
        }
        let d = b * b - 4.0 * a * c;
        if d < 0.0 {
            return f64::INFINITY;
        }
        let root = if b > 0.0 { -2.0 * c / (b + d.sqrt()) } else { (d.sqrt() - b) / (2.0 * a) };
        if root >= 0.0 { root } else { f64::INFINITY }
    }

    /// The next solid along a way, but for one: its number and how far it is [mm].
    #[inline]
    pub fn solid(&self, place: DVec3, way: DVec3, but: Option<usize>) -> Option<(usize, f64)> {
        let mut next = None;
        let (from, along) = (place.as_vec3(), way.as_vec3());
        for (number, solid) in self.solids.iter().enumerate() {
            let (low, high) = ((solid.bounds[0] - from) / along, (solid.bounds[1] - from) / along);
            let (near, far) = (low.min(high).max_element(), low.max(high).min_element());
            if Some(number) == but || near > far || far < 0.0 || next.is_some_and(|(_, best)| f64::from(near) > best) {
                continue;
            }
            // Light that begins on or a little inside a solid it touches enters only if it goes inwards.
            if let Some([near, far]) = solid.span(from, along)
                && far > 0.0
                && (near > 0.0 || solid.normal(from).dot(along) < 0.0)
            {
                let near = f64::from(near).max(0.0);
                if next.is_none_or(|(_, best)| near < best) {
                    next = Some((number, near));
                }
            }
        }
        next
    }
}
