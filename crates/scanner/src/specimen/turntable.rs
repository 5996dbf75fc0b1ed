//! Turntable: the pose of a body that turns about an upright axis under the line.
//!
//! The axis stands in the laser plane at x = `axis[0]`; the body's point (`axis[0]`, `axis[1]`) is on it. When the
//! points at the table's `radius` have travelled s, the body has turned by s / radius from x towards the scan's y, and
//! column x looks at the body's point
//!
//! ```text
//! axis + R(-s / radius) (x - axis[0], 0)
//! ```
//!
//! Slopes and fibres are turned into the frame of laser and camera, rays for shadows into the body's. A full turn sees
//! each point twice where the line reaches over the axis. For all bodies but packs, whose surface grid is made for one
//! direction of view. Neglected: that an uneven gloss turns with the body.

use glam::{Vec2, Vec3};

/// Axis and radius of a turntable.
#[derive(Debug, Clone, Copy)]
pub struct Turntable {
    /// The point of the body that stands on the axis, x and y before it has turned; the axis is at the same x [mm].
    pub axis: [f64; 2],
    /// Distance from the axis at which profiles are a step apart [mm].
    pub radius: f64,
}

/// Pose of a body: turned about an axis, or moved along the scan.
#[derive(Debug, Clone, Copy)]
pub(super) struct BodyPose {
    /// Point of the laser's frame about which it has turned [mm].
    axis: Vec2,
    /// Point of the body that is there [mm].
    part: Vec2,
    cos: f32,
    sin: f32,
}

impl Turntable {
    /// Travel of the object at `x` [mm] of the line over that at the table's radius, positive against the scan's y as
    /// in a straight scan; negative right of the axis [1].
    pub fn share(&self, x: f64) -> f64 {
        (self.axis[0] - x) / self.radius
    }

    /// Pose after a travel of the points at the table's radius [mm].
    pub(super) fn pose(&self, travel: f64) -> BodyPose {
        let (sin, cos) = libm::sincos(travel / self.radius);
        let part = Vec2::new(self.axis[0] as f32, self.axis[1] as f32);
        BodyPose { axis: Vec2::new(part.x, 0.0), part, cos: cos as f32, sin: sin as f32 }
    }
}

impl BodyPose {
    /// Moved along the scan by `y` [mm].
    pub fn moved(y: f32) -> Self {
        Self { axis: Vec2::ZERO, part: Vec2::new(0.0, y), cos: 1.0, sin: 0.0 }
    }

    /// A point of the laser's frame, y from its plane, in the body's.
    pub(crate) fn point_into_body(self, point: Vec3) -> Vec3 {
        let off = point.truncate() - self.axis;
        let (x, y) = (self.cos * off.x + self.sin * off.y, self.cos * off.y - self.sin * off.x);
        Vec3::new(self.part.x + x, self.part.y + y, point.z)
    }

    /// A point of the body in the laser's frame.
    pub(crate) fn point_from_body(self, point: Vec3) -> Vec3 {
        let off = self.direction_from_body(Vec3::new(point.x - self.part.x, point.y - self.part.y, 0.0));
        Vec3::new(self.axis.x + off.x, self.axis.y + off.y, point.z)
    }

    /// A direction of the body in the laser's frame.
    pub(crate) fn direction_from_body(self, direction: Vec3) -> Vec3 {
        let (x, y) = (direction.x, direction.y);
        Vec3::new(self.cos * x - self.sin * y, self.sin * x + self.cos * y, direction.z)
    }
}
