//! A body on a turntable: what the columns see when it turns about an upright axis under the line.
//!
//! The axis stands in the laser plane at x = `axis[0]`; the body's point (`axis[0]`, `axis[1]`) is on it. After a way s of
//! the points at the table's `radius` the body has turned by s / radius from x towards the scan's y, and column x looks at the body's point
//!
//! ```text
//! axis + R(-s / radius) (x - axis[0], 0)
//! ```
//!
//! Slopes and fibres are turned into the frame of laser and camera, rays for shadows into the body's. A full turn sees
//! each place twice where the line reaches over the axis. For bodies that do not hide themselves; neglected: that an uneven gloss
//! turns with the body.

use glam::{Vec2, Vec3, Vec3A};
use procedural::{Class, Matter, Medium, Surface};

use super::{Hit, Specimen, lens};
use crate::frame::Columns;

/// Where a body turns.
#[derive(Debug, Clone, Copy)]
pub struct Turn {
    /// Where the axis stands, and which part of the body stands on it: x and y of the body before it has turned [mm].
    pub axis: [f64; 2],
    /// Distance from the axis at which profiles are a step apart [mm].
    pub radius: f64,
}

/// A body turned by an angle.
#[derive(Debug, Clone, Copy)]
struct Pose {
    axis: Vec2,
    cos: f32,
    sin: f32,
}

impl Turn {
    /// Way of the point at `x` [mm] of the line, along the motion, over that at the radius [1].
    pub fn share(&self, x: f64) -> f64 {
        (x - self.axis[0]) / self.radius
    }

    fn pose(&self, way: f64) -> Pose {
        let (sin, cos) = libm::sincos(way / self.radius);
        Pose { axis: Vec2::new(self.axis[0] as f32, self.axis[1] as f32), cos: cos as f32, sin: sin as f32 }
    }
}

impl Pose {
    /// A point of the laser's frame, y from its plane, in the body's.
    fn into_body(self, point: Vec3) -> Vec3 {
        let (x, y) = (point.x - self.axis.x, point.y);
        let (x, y) = (self.cos * x + self.sin * y, self.cos * y - self.sin * x);
        Vec3::new(self.axis.x + x, self.axis.y + y, point.z)
    }

    /// A direction of the body in the laser's frame.
    fn out(self, way: Vec3) -> Vec3 {
        Vec3::new(self.cos * way.x - self.sin * way.y, self.sin * way.x + self.cos * way.y, way.z)
    }
}

impl Specimen {
    /// What `columns` see after a way [mm] at the table's radius; fills `hits`, one a column.
    pub(super) fn look_turned(&self, turn: &Turn, way: f32, columns: &Columns, conveyor: Medium, hits: &mut Vec<Hit>) {
        let pose = turn.pose(f64::from(way));
        let stands = [Vec3::new(0.0, 0.0, self.fan_height), lens(&self.rig, 0.0)].map(|place| pose.into_body(place));
        let mut guess = self.high.z;
        for column in 0..columns.len() {
            let line = columns.of(column);
            let at = |z: f32| (line.at(z), pose.into_body(Vec3::new(line.at(z), 0.0, z)));
            let look = |z: f32| {
                let (x, point) = at(z);
                self.body.slice(point.y).surface(point.x).map(|surface| (x, point, surface))
            };
            let mut found = look(guess);
            if let Some((.., first)) = found
                && (first.z - guess).abs() > 0.05
            {
                found = look(first.z);
            }
            hits.push(match found {
                Some((x, point, surface)) => {
                    guess = surface.z;
                    let mut matter = self.body.slice(point.y).matter(point.x, surface.z);
                    matter.medium.fibre = pose.out(matter.medium.fibre);
                    let slope = pose.out(Vec3::new(surface.slope_x, surface.slope_y, 0.0));
                    let surface = Surface { z: surface.z, slope_x: slope.x, slope_y: slope.y };
                    Hit { x, surface, matter, lit: true, seen: true }
                }
                None => {
                    let (x, point) = at(0.0);
                    let surface = Surface { z: 0.0, slope_x: 0.0, slope_y: 0.0 };
                    let matter = Matter { medium: conveyor, film: None, class: Class::Background, instance: 0 };
                    let [lit, seen] = stands.map(|stand| self.clear(Vec3A::from(point), Vec3A::from(stand)));
                    Hit { x, surface, matter, lit, seen }
                }
            });
        }
    }

    /// Whether nothing of the body stands between a point of the table and `stand`.
    fn clear(&self, point: Vec3A, stand: Vec3A) -> bool {
        // The body's top throws its shadow no further than that of the way to the stand.
        let way = stand - point;
        let over = (way.z - self.high.z).max(1.0);
        let reach = self.high.z / over * (way.x * way.x + way.y * way.y).sqrt() * 1.2 + 0.5;
        let near = point.x > self.low.x - reach
            && point.x < self.high.x + reach
            && point.y > self.low.y - reach
            && point.y < self.high.y + reach;
        !near || self.free(point, stand)
    }
}
