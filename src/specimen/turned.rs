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
//! each place twice where the line reaches over the axis. For all bodies but packs, whose grid of what hides what is made for
//! one direction. Neglected: that an uneven gloss turns with the body.

use glam::{Vec2, Vec3};
use procedural::{Class, Matter, Medium, Surface};

use super::{Hit, Specimen, lens};
use crate::frame::Sightlines;

/// Where a body turns.
#[derive(Debug, Clone, Copy)]
pub struct Turn {
    /// Where the axis stands, and which part of the body stands on it: x and y of the body before it has turned [mm].
    pub axis: [f64; 2],
    /// Distance from the axis at which profiles are a step apart [mm].
    pub radius: f64,
}

/// How a body stands: turned by an angle, or moved.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pose {
    /// Point of the laser's frame about which it has turned, and the point of the body that is there.
    axis: Vec2,
    part: Vec2,
    cos: f32,
    sin: f32,
}

impl Turn {
    /// Way that the object goes at `x` [mm] of the line, against the scan's y as on a straight way, over that at the
    /// radius: right of the axis it goes along y [1].
    pub fn share(&self, x: f64) -> f64 {
        (self.axis[0] - x) / self.radius
    }

    fn pose(&self, way: f64) -> Pose {
        let (sin, cos) = libm::sincos(way / self.radius);
        let part = Vec2::new(self.axis[0] as f32, self.axis[1] as f32);
        Pose { axis: Vec2::new(part.x, 0.0), part, cos: cos as f32, sin: sin as f32 }
    }
}

impl Pose {
    /// Moved along the scan by `y` [mm].
    pub fn moved(y: f32) -> Self {
        Self { axis: Vec2::ZERO, part: Vec2::new(0.0, y), cos: 1.0, sin: 0.0 }
    }

    /// A point of the laser's frame, y from its plane, in the body's.
    pub fn into_body(self, point: Vec3) -> Vec3 {
        let way = point.truncate() - self.axis;
        let (x, y) = (self.cos * way.x + self.sin * way.y, self.cos * way.y - self.sin * way.x);
        Vec3::new(self.part.x + x, self.part.y + y, point.z)
    }

    /// A point of the body in the laser's frame.
    pub fn place(self, point: Vec3) -> Vec3 {
        let way = self.out(Vec3::new(point.x - self.part.x, point.y - self.part.y, 0.0));
        Vec3::new(self.axis.x + way.x, self.axis.y + way.y, point.z)
    }

    /// A direction of the body in the laser's frame.
    pub fn out(self, way: Vec3) -> Vec3 {
        Vec3::new(self.cos * way.x - self.sin * way.y, self.sin * way.x + self.cos * way.y, way.z)
    }
}

impl Specimen {
    /// What `columns` see after a way [mm] at the table's radius; fills `hits`, one a column.
    pub(super) fn look_turned(
        &self,
        turn: &Turn,
        way: f32,
        columns: &Sightlines,
        conveyor: Medium,
        hits: &mut Vec<Hit>,
    ) {
        let pose = turn.pose(f64::from(way));
        let stands = [Vec3::new(0.0, 0.0, self.fan_height), lens(&self.rig, 0.0)].map(|place| pose.into_body(place));
        let bare = |x: f32| {
            let point = pose.into_body(Vec3::new(x, 0.0, 0.0));
            let surface = Surface { z: 0.0, slope_x: 0.0, slope_y: 0.0 };
            let matter = Matter { medium: conveyor, film: None, class: Class::Background, instance: 0 };
            let [lit, seen] = stands.map(|stand| self.clear(point, stand));
            Hit { x, surface, matter, lit, seen }
        };
        if self.body.is_its_hull() {
            return self.look_at_triangles(&pose, columns, bare, hits);
        }
        let mut guess = self.rays.high.z;
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
                None => bare(line.at(0.0)),
            });
        }
    }

    /// Whether nothing of the body stands between a point of the table and `stand`.
    fn clear(&self, point: Vec3, stand: Vec3) -> bool {
        // The body's top throws its shadow no further than that of the way to the stand.
        let way = stand - point;
        let over = (way.z - self.rays.high.z).max(1.0);
        let reach = self.rays.high.z / over * (way.x * way.x + way.y * way.y).sqrt() * 1.2 + 0.5;
        let near = point.x > self.rays.low.x - reach
            && point.x < self.rays.high.x + reach
            && point.y > self.rays.low.y - reach
            && point.y < self.rays.high.y + reach;
        !near || self.rays.free(point, stand)
    }
}
