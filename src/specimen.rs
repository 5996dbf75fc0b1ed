//! A body made ready for light: which point each sensor column sees in the laser plane, and whether the laser and the
//! camera reach it. The only file that names obvhs.
//!
//! The upper surface is asked directly, since a board is a height field; the hull in the ray tracer serves for shadows
//! on the conveyor next to the body. Neglected: light that a body throws onto the conveyor or onto itself.

use std::time::Duration;

use glam::Vec3A;
use obvhs::BvhBuildParams;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::builder::build_cwbvh_from_tris;
use obvhs::ray::Ray;
use obvhs::triangle::Triangle;
use procedural::{Body, Class, Matter, Medium, Surface};

use crate::frame::Rig;

/// What one sensor column sees at one position of the scan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Along the laser line [mm].
    pub x: f32,
    /// The surface there.
    pub surface: Surface,
    /// What it is; the conveyor has class `Background`.
    pub matter: Matter,
    /// Whether the laser reaches it.
    pub lit: bool,
    /// Whether the camera reaches it.
    pub seen: bool,
}

/// A body ready for rays.
#[derive(Debug)]
pub struct Specimen {
    body: Body,
    hull: CwBvh,
    triangles: Vec<Triangle>,
    /// Corners of the box around the hull [mm].
    low: Vec3A,
    high: Vec3A,
    rig: Rig,
    /// Height of the point that the laser fan comes from [mm].
    fan_height: f32,
}

/// Start of a shadow ray off the surface that it leaves [mm]; above obvhs' absolute epsilon of 1e-4.
const LEAVE_MM: f32 = 0.01;

impl Specimen {
    /// Puts `body` under a camera and a laser fan from `fan_height` [mm].
    pub fn new(body: Body, rig: Rig, fan_height: f64) -> Self {
        let mesh = body.hull();
        let corner = |i: u32| Vec3A::from(mesh.positions[i as usize]);
        let soup: Vec<Triangle> =
            mesh.triangles.iter().map(|t| Triangle { v0: corner(t[0]), v1: corner(t[1]), v2: corner(t[2]) }).collect();
        let hull = build_cwbvh_from_tris(&soup, BvhBuildParams::medium_build(), &mut Duration::default());
        let triangles = hull.primitive_indices.iter().map(|&i| soup[i as usize]).collect();
        let fold = |pick: fn(Vec3A, Vec3A) -> Vec3A| {
            mesh.positions.iter().map(|&p| Vec3A::from(p)).reduce(pick).unwrap_or(Vec3A::ZERO)
        };
        let (low, high) = (fold(Vec3A::min), fold(Vec3A::max));
        Self { body, hull, triangles, low, high, rig, fan_height: fan_height as f32 }
    }

    /// The body.
    pub fn body(&self) -> &Body {
        &self.body
    }

    /// Height of the body's highest point [mm].
    pub fn top(&self) -> f32 {
        self.high.z
    }

    /// What columns `0..hits.capacity` see with the laser at scan position `y` [mm]; fills `hits`, one a column.
    pub fn look(&self, y: f32, columns: usize, conveyor: Medium, hits: &mut Vec<Hit>) {
        hits.clear();
        let slice = self.body.slice(y);
        let shadow = self.high.z * libm::tan(self.rig.tilt) as f32 * 1.2 + 1.0;
        let near_y = y > self.low.y - LEAVE_MM && y < self.high.y + shadow;
        // x of a column is linear in height.
        let scale = self.rig.pixel * (self.rig.distance - self.rig.focal_length) / self.rig.focal_length;
        let drop = self.rig.pixel * libm::cos(self.rig.tilt) / self.rig.focal_length;
        let mut guess = self.high.z;
        for column in 0..columns {
            let offset = column as f64 - self.rig.centre_col;
            let along = |z: f32| (offset * (scale - drop * f64::from(z))) as f32;
            let mut found = slice.surface(along(guess)).map(|s| (along(guess), s));
            if let Some((_, first)) = found
                && (first.z - guess).abs() > 0.05
            {
                // The guess was from another part of the body: look again where this column really meets it.
                found = slice.surface(along(first.z)).map(|s| (along(first.z), s));
            }
            let hit = match found {
                Some((x, surface)) => {
                    guess = surface.z;
                    let matter = slice.matter(x, surface.z);
                    Hit { x, surface, matter, lit: true, seen: true }
                }
                None => self.conveyor(along(0.0), y, near_y, conveyor),
            };
            hits.push(hit);
        }
    }

    fn conveyor(&self, x: f32, y: f32, near_y: bool, medium: Medium) -> Hit {
        let surface = Surface { z: 0.0, slope_x: 0.0, slope_y: 0.0 };
        let matter = Matter { medium, film: None, class: Class::Background, instance: 0 };
        let point = Vec3A::new(x, y, 0.0);
        let (sin, cos) = libm::sincos(self.rig.tilt);
        let lens = Vec3A::new(0.0, y - (self.rig.distance * sin) as f32, (self.rig.distance * cos) as f32);
        // Shadows reach no further than the lower of fan and lens throws them over the body's top, and a margin.
        let over = (self.fan_height.min(lens.z) - self.high.z).max(1.0);
        let reach = self.high.z * x.abs() / over * 1.2 + 0.5;
        let near = near_y && x > self.low.x - reach && x < self.high.x + reach;
        let lit = !near || self.free(point, Vec3A::new(0.0, y, self.fan_height));
        let seen = !near || self.free(point, lens);
        Hit { x, surface, matter, lit, seen }
    }

    /// Whether nothing of the hull stands between two points.
    pub fn free(&self, from: Vec3A, to: Vec3A) -> bool {
        let way = to - from;
        let length = way.length();
        let ray = Ray::new(from, way / length, LEAVE_MM, length);
        self.hull.ray_traverse_miss(ray, |ray, id| self.triangles[id].intersect(ray))
    }
}
