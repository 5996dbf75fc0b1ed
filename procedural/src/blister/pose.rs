//! How a tablet lies in its pocket.
//!
//! Models: a turn about the upright axis, a tilt about a level one, and an offset, all drawn and then taken back by
//! bisection until the tablet, resting on the foil, lies inside the cavity. Exact in the sense that every probe of its
//! surface keeps a margin to the film; how it came to rest there is not modelled.

use glam::{Mat3, Vec2, Vec3};

use super::tablet::TabletForm;

/// Distance between a tablet and what it rests on [mm].
const REST_MM: f32 = 0.001;
/// Halvings of what is too much.
const HALVINGS: usize = 7;

/// The pose that was drawn.
#[derive(Debug, Clone, Copy)]
pub struct DrawnPose {
    /// Turn of its long axis from the pocket's [rad].
    pub yaw: f32,
    /// Tilt [rad].
    pub tilt: f32,
    /// Direction of the axis of the tilt [rad].
    pub about: f32,
    /// Offset from the pocket's middle [mm].
    pub offset: Vec2,
    /// Whether its other face is up.
    pub flipped: bool,
    /// Whether it stands on its long edge.
    pub on_edge: bool,
}

/// A pose in the card's coordinates.
#[derive(Debug, Clone, Copy)]
pub struct Pose {
    /// From the tablet's axes to the card's.
    pub turn: Mat3,
    /// Middle of the tablet [mm].
    pub middle: Vec3,
}

impl DrawnPose {
    /// Lying flat in the middle.
    pub const FLAT: Self = Self { yaw: 0.0, tilt: 0.0, about: 0.0, offset: Vec2::ZERO, flipped: false, on_edge: false };

    /// This part of the turn, the tilt and the offset.
    fn part(self, share: f32, free: bool) -> Self {
        let yaw = if free { self.yaw } else { share * self.yaw };
        Self { yaw, tilt: share * self.tilt, offset: share * self.offset, ..self }
    }

    /// The pose of a form that rests on the level `floor`, with its pocket's middle and long axis.
    pub fn pose(self, form: &TabletForm, middle: Vec2, axis: Vec2, floor: f32) -> Pose {
        let face = if self.on_edge {
            quarter()
        } else if self.flipped {
            Mat3::from_diagonal(Vec3::new(1.0, -1.0, -1.0))
        } else {
            Mat3::IDENTITY
        };
        let along = Mat3::from_cols(axis.extend(0.0), axis.perp().extend(0.0), Vec3::Z);
        let turn = upright(self.about) * level(self.tilt) * upright(self.yaw - self.about) * along * face;
        let rest = floor + REST_MM + form.support(turn, -Vec3::Z);
        Pose { turn, middle: (middle + self.offset).extend(rest) }
    }
}

/// Turn by a quarter about x.
fn quarter() -> Mat3 {
    Mat3::from_cols(Vec3::X, Vec3::Z, -Vec3::Y)
}

/// Turn about z.
fn upright(angle: f32) -> Mat3 {
    let (sine, cosine) = libm::sincosf(angle);
    Mat3::from_cols(Vec3::new(cosine, sine, 0.0), Vec3::new(-sine, cosine, 0.0), Vec3::Z)
}

/// Turn about x.
fn level(angle: f32) -> Mat3 {
    let (sine, cosine) = libm::sincosf(angle);
    Mat3::from_cols(Vec3::X, Vec3::new(0.0, cosine, sine), Vec3::new(0.0, -sine, cosine))
}

/// A cavity and what lies in it.
pub struct TabletRoom<'a> {
    /// Middle of the pocket [mm].
    pub middle: Vec2,
    /// Its long axis [1].
    pub axis: Vec2,
    /// Level that the tablet rests on [mm].
    pub floor: f32,
    /// Lower side of the film over a place of the card [mm].
    pub ceiling: &'a dyn Fn(Vec2) -> f32,
    /// Distance that is kept from it [mm].
    pub margin: f32,
}

impl TabletRoom<'_> {
    /// Whether a pose lies inside.
    pub fn holds(&self, pose: &Pose, probes: &[Vec3]) -> bool {
        probes.iter().all(|&probe| {
            let p = pose.middle + pose.turn * probe;
            p.z + self.margin <= (self.ceiling)(p.truncate())
        })
    }

    /// The pose closest to the wish that lies inside; `None` where even a flat one does not. Round tablets turn freely.
    pub fn settle(&self, form: &TabletForm, probes: &[Vec3], wish: DrawnPose) -> Option<Pose> {
        let free = form.shape.segment == 0.0 && form.scale.x == 1.0;
        let pose = |share: f32| wish.part(share, free).pose(form, self.middle, self.axis, self.floor);
        let whole = pose(1.0);
        if self.holds(&whole, probes) {
            return Some(whole);
        }
        let mut best = pose(0.0);
        if !self.holds(&best, probes) {
            let lying = DrawnPose { on_edge: false, ..wish };
            return if wish.on_edge { self.settle(form, probes, lying) } else { None };
        }
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            let candidate = pose(middle);
            if self.holds(&candidate, probes) {
                (low, best) = (middle, candidate);
            } else {
                high = middle;
            }
        }
        Some(best)
    }
}
