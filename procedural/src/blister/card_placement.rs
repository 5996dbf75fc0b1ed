//! The card as it lies: from the conveyor to the card's own coordinates, and its warp.
//!
//! Models: a rounded rectangle, turned about its middle, over which the height w of everything is raised by
//! bow (1 - a^2) + curl a b / 2 with a = 2u / width, b = 2v / length, so that its lowest place lies on the conveyor.
//! Neglected: the card is not shortened by its warp. Solids follow the tangent plane of the warp under their middle,
//! and [`CardPlacement::slack`] bounds what that leaves out.

use glam::{Mat3, Vec2, Vec3};

use super::parameters::Card;

/// Position and warp of a card.
#[derive(Debug, Clone, Copy)]
pub struct CardPlacement {
    /// Middle of the card on the conveyor [mm].
    middle: Vec2,
    /// Cosine and sine of its turn [1].
    turn: Vec2,
    /// Half its width and length [mm].
    pub half: Vec2,
    /// Radius of its corners [mm].
    corner: f32,
    bow: f32,
    curl: f32,
    /// What keeps the lowest place of the warp on the conveyor [mm].
    lift: f32,
}

impl CardPlacement {
    /// The card of these numbers.
    pub fn new(card: &Card) -> Self {
        let (sine, cosine) = libm::sincos(card.turn_deg.to_radians());
        let half = Vec2::new(0.5 * card.width_mm as f32, 0.5 * card.length_mm as f32);
        let turn = Vec2::new(cosine as f32, sine as f32);
        let reach = half.x * turn.y.abs() + half.y * turn.x.abs();
        let (bow, curl) = (card.bow_mm as f32, card.curl_mm as f32);
        // Along an edge a the warp is a parabola: lowest at its ends, or at its vertex where it opens upwards.
        let along = |a: f32| bow * (1.0 - a * a) - 0.5 * curl.abs() * a;
        let vertex = if bow < 0.0 { (-0.25 * curl.abs() / bow).min(1.0) } else { 1.0 };
        Self {
            middle: Vec2::new(card.offset_mm as f32, card.lead_in_mm as f32 + reach),
            turn,
            half,
            corner: (card.corner_mm as f32).min(half.min_element()),
            bow,
            curl,
            lift: -along(vertex).min(along(1.0)),
        }
    }

    /// Card coordinates of a place on the conveyor [mm].
    #[inline]
    pub fn card(&self, x: f32, y: f32) -> Vec2 {
        self.across(Vec2::new(x, y) - self.middle)
    }

    /// The place on the conveyor of card coordinates [mm].
    pub fn conveyor(&self, p: Vec2) -> Vec2 {
        self.middle + self.along(p)
    }

    /// A vector of the card, or a slope, in the axes of the conveyor.
    #[inline]
    pub fn along(&self, p: Vec2) -> Vec2 {
        let t = self.turn;
        Vec2::new(t.x * p.x - t.y * p.y, t.y * p.x + t.x * p.y)
    }

    /// A vector of the conveyor, or a slope, in the axes of the card.
    #[inline]
    pub fn across(&self, p: Vec2) -> Vec2 {
        let t = self.turn;
        Vec2::new(t.x * p.x + t.y * p.y, t.x * p.y - t.y * p.x)
    }

    /// Rise of everything at a place of the card [mm], and its slope in the axes of the card [1].
    #[inline]
    pub fn warp(&self, p: Vec2) -> (f32, Vec2) {
        let (a, b) = (p.x / self.half.x, p.y / self.half.y);
        let rise = self.lift + self.bow * (1.0 - a * a) + 0.5 * self.curl * a * b;
        let slope =
            Vec2::new((0.5 * self.curl * b - 2.0 * self.bow * a) / self.half.x, 0.5 * self.curl * a / self.half.y);
        (rise, slope)
    }

    /// Highest rise of the warp on the card [mm].
    pub fn highest(&self) -> f32 {
        self.lift + self.bow.max(0.0) + 0.5 * self.curl.abs()
    }

    /// Largest departure of the warp from its tangent plane within `reach` of a place [mm].
    pub fn slack(&self, reach: f32) -> f32 {
        let square = reach * reach;
        self.bow.abs() * square / (self.half.x * self.half.x)
            + 0.25 * self.curl.abs() * square / (self.half.x * self.half.y)
    }

    /// How much more than their thickness films of thickness 1 take upright where the warp is steepest [1].
    pub fn steepest(&self) -> f32 {
        let (bow, curl) = (2.0 * self.bow.abs(), 0.5 * self.curl.abs());
        let slope = Vec2::new(curl + bow, curl) / self.half;
        (1.0 + slope.length_squared()).sqrt() - 1.0
    }

    /// Whether a place is on the card.
    #[inline]
    pub fn holds(&self, p: Vec2) -> bool {
        let beyond = p.abs() - (self.half - self.corner);
        beyond.max_element() <= self.corner && beyond.max(Vec2::ZERO).length_squared() <= self.corner * self.corner
    }

    /// Half the width of the card at `v` along it [mm].
    pub fn half_width(&self, v: f32) -> f32 {
        let beyond = (v.abs() - (self.half.y - self.corner)).clamp(0.0, self.corner);
        self.half.x - self.corner + (self.corner * self.corner - beyond * beyond).sqrt()
    }

    /// Linear part and origin of the map from the card's (u - at, w) to the conveyor, with the warp's tangent plane
    /// [mm].
    pub fn tangent(&self, at: Vec2) -> (Mat3, Vec3) {
        let (rise, slope) = self.warp(at);
        let (u, v) = (self.along(Vec2::X), self.along(Vec2::Y));
        let linear = Mat3::from_cols(u.extend(slope.x), v.extend(slope.y), Vec3::Z);
        (linear, self.conveyor(at).extend(rise))
    }

    /// Half the box around the card on the conveyor, and its middle [mm].
    pub fn reach(&self) -> (Vec2, Vec2) {
        let (h, t) = (self.half, self.turn.abs());
        (Vec2::new(h.x * t.x + h.y * t.y, h.x * t.y + h.y * t.x), self.middle)
    }
}
