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
