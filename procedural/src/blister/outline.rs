//! Outlines of pockets: stadium and ellipse with the curves parallel to them.
//!
//! Models: a stadium's parallel curves are stadiums again. Those of an ellipse with semi-axes (a, b) are taken as the
//! ellipses (a - e, b - e): exact on both axes, and exact everywhere for a circle. Beyond the roof's rim the place is
//! told by q = 1 on the rim and 0 in the middle, q^2 being a square of a distance, so that all of it is smooth.

use glam::Vec2;

/// An outline about the origin, its long axis along x.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Outline {
    /// All places within `radius` of a straight segment; a circle where that has no length [mm].
    Stadium {
        /// Half the length of the segment.
        segment: f32,
        /// Radius.
        radius: f32,
    },
    /// An ellipse with these semi-axes [mm].
    Ellipse {
        /// Half of its length.
        long: f32,
        /// Half of its width.
        short: f32,
    },
}

/// Where a place lies with respect to an outline.
#[derive(Debug, Clone, Copy)]
pub enum OutlinePoint {
    /// Outside the roof's rim: distance inwards from the outline and its gradient [mm].
    Wall(f32, Vec2),
    /// Within the rim: q^2 and its gradient [1].
    Roof(f32, Vec2),
}

impl Outline {
    /// Half of its length and of its width [mm].
    pub fn half(&self) -> Vec2 {
        match *self {
            Self::Stadium { segment, radius } => Vec2::new(segment + radius, radius),
            Self::Ellipse { long, short } => Vec2::new(long, short),
        }
    }

    /// The outline `by` further out [mm].
    pub fn grown(&self, by: f32) -> Self {
        match *self {
            Self::Stadium { segment, radius } => Self::Stadium { segment, radius: radius + by },
            Self::Ellipse { long, short } => Self::Ellipse { long: long + by, short: short + by },
        }
    }

    /// Half the box around it when its long axis is turned to `axis`, a unit vector [mm].
    pub fn reach(&self, axis: Vec2) -> Vec2 {
        match *self {
            Self::Stadium { segment, radius } => segment * axis.abs() + radius,
            Self::Ellipse { long, short } => {
                let (l, s) = (long * axis, short * axis.perp());
                Vec2::new((l.x * l.x + s.x * s.x).sqrt(), (l.y * l.y + s.y * s.y).sqrt())
            }
        }
    }

    /// Where `p` lies, with the rim of the roof at `rim` inwards [mm].
    #[inline]
    pub fn place(&self, p: Vec2, rim: f32) -> OutlinePoint {
        match *self {
            Self::Stadium { segment, radius } => {
                let away = Vec2::new(p.x - p.x.clamp(-segment, segment), p.y);
                let (square, inner) = (away.length_squared(), radius - rim);
                if square <= inner * inner {
                    return OutlinePoint::Roof(square / (inner * inner), 2.0 * away / (inner * inner));
                }
                let distance = square.sqrt();
                OutlinePoint::Wall(radius - distance, -away / distance)
            }
            Self::Ellipse { long, short } => {
                let inner = Vec2::new(long - rim, short - rim);
                let share = p / inner;
                let square = share.length_squared();
                if square <= 1.0 {
                    return OutlinePoint::Roof(square, 2.0 * share / inner);
                }
                // f(e) = (x / (a - e))^2 + (y / (b - e))^2 - 1 is convex and rises: Newton from the right stays there.
                let mut inset = (long - p.x.abs()).min(short - p.y.abs()).min(rim);
                for _ in 0..4 {
                    let axes = Vec2::new(long - inset, short - inset);
                    let s = (p / axes) * (p / axes);
                    inset -= (s.x + s.y - 1.0) / (2.0 * (s.x / axes.x + s.y / axes.y));
                }
                let axes = Vec2::new(long - inset, short - inset);
                let pull = p / (axes * axes);
                OutlinePoint::Wall(inset, -pull / (pull * pull * axes).element_sum())
            }
        }
    }

    /// Distances from `p` to where the line along the unit vector `way` leaves the outline, against it and along it; 0
    /// outside [mm].
    pub fn ends(&self, p: Vec2, way: Vec2) -> [f32; 2] {
        // Between the roots of a t^2 + 2 b t + c.
        let between = |a: f32, b: f32, c: f32| {
            let root = (b * b - a * c).max(0.0).sqrt();
            [(-b - root) / a, (-b + root) / a]
        };
        let inside = |[from, to]: [f32; 2]| (from < 0.0 && to > 0.0).then_some([from, to]);
        match *self {
            Self::Ellipse { long, short } => {
                let axes = Vec2::new(long, short);
                let (p, way) = (p / axes, way / axes);
                let cut = between(way.length_squared(), p.dot(way), p.length_squared() - 1.0);
                inside(cut).map_or([0.0; 2], |[from, to]| [-from, to])
            }
            Self::Stadium { segment, radius } => {
                // The stadium is a band between two discs: a line's part in it begins and ends on one of the three.
                let disc = |x: f32| {
                    let p = p - Vec2::new(x, 0.0);
                    between(1.0, p.dot(way), p.length_squared() - radius * radius)
                };
                let slab = |p: f32, way: f32, half: f32| match way.abs() {
                    flat if flat < 1e-6 && p.abs() > half => [0.0; 2],
                    flat if flat < 1e-6 => [f32::NEG_INFINITY, f32::INFINITY],
                    _ => {
                        let (a, b) = ((-half - p) / way, (half - p) / way);
                        [a.min(b), a.max(b)]
                    }
                };
                let (along, across) = (slab(p.x, way.x, segment), slab(p.y, way.y, radius));
                let band = [along[0].max(across[0]), along[1].min(across[1])];
                let parts = [disc(-segment), disc(segment), band].into_iter().filter(|[from, to]| to > from);
                let all = parts.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]);
                all.and_then(inside).map_or([0.0; 2], |[from, to]| [-from, to])
            }
        }
    }

    /// Places that share the area within the outline: each with its share of the area [mm, mm^2].
    pub fn areas(&self, rim: f32) -> Vec<(Vec2, f32)> {
        const RINGS: usize = 40;
        const ANGLES: usize = 16;
        let half = self.half();
        let (core, round) = match *self {
            Self::Stadium { segment, radius } => (segment, Vec2::splat(radius)),
            Self::Ellipse { .. } => (0.0, half),
        };
        let mut areas = Vec::with_capacity(2 * RINGS * (ANGLES + 1));
        // Rings between outline and rim, then rings of the roof shrinking to the middle.
        for ring in 0..2 * RINGS {
            let share = |k: usize| k as f32 / RINGS as f32;
            let inner = round - rim;
            let axes = |k: usize| if k <= RINGS { round - rim * share(k) } else { inner * (2.0 - share(k)) };
            let (outer, inner) = (axes(ring), axes(ring + 1));
            let (middle, step) = (0.5 * (outer + inner), outer - inner);
            for angle in 0..ANGLES {
                let turn = std::f32::consts::TAU * (angle as f32 + 0.5) / ANGLES as f32;
                let (sine, cosine) = libm::sincosf(turn);
                let area = (step.x * middle.y * cosine * cosine + step.y * middle.x * sine * sine)
                    * (std::f32::consts::TAU / ANGLES as f32);
                areas.push((Vec2::new(middle.x * cosine + core * cosine.signum(), middle.y * sine), area));
            }
            if core > 0.0 {
                areas.push((Vec2::new(0.0, middle.y), 4.0 * core * step.y));
            }
        }
        areas
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use base::Stream;
    use rand::RngExt;

    /// Ends of random lines, against a walk in steps of 0.01 mm.
    #[test]
    fn lines_end_on_the_outline() {
        let mut rng = Stream::root(11).rng();
        let mut even = |from: f32, to: f32| from + (to - from) * rng.random::<f32>();
        for round in 0..400 {
            let outline = match round % 3 {
                0 => Outline::Stadium { segment: even(0.0, 5.0), radius: even(1.0, 4.0) },
                1 => Outline::Stadium { segment: 0.0, radius: even(1.0, 4.0) },
                _ => Outline::Ellipse { long: even(3.0, 8.0), short: even(2.0, 3.0) },
            };
            let way = match round % 5 {
                0 => Vec2::Y,
                1 => Vec2::X,
                _ => Vec2::from_angle(even(0.0, 6.3)),
            };
            let p = outline.half() * Vec2::new(even(-1.2, 1.2), even(-1.2, 1.2));
            let holds = |p: Vec2| match outline.place(p, 0.5) {
                OutlinePoint::Wall(inset, _) => inset > 0.0,
                OutlinePoint::Roof(..) => true,
            };
            let step = 0.01;
            let walk = |way: Vec2| (0..4000).take_while(|&i| holds(p + way * (step * i as f32))).count() as f32;
            let truth = [-way, way].map(|way| if holds(p) { step * (walk(way) - 0.5) } else { 0.0 });
            let ends = outline.ends(p, way);
            let whole: f32 = truth.iter().sum();
            // Ellipses inside ellipses are not quite its parallel curves.
            let meets = |i: usize| (ends[i] - truth[i]).abs() < 0.03 + 0.02 * whole;
            assert!(meets(0) && meets(1), "{outline:?} {p} {way}: {ends:?}, not {truth:?}");
        }
    }
}
