//! Ray tracing of triangles through a bounding volume hierarchy. The only file that names obvhs.

use std::time::Duration;

use base::Mesh;
use glam::{Vec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::builder::build_cwbvh_from_tris;
use obvhs::ray::{Ray, RayHit};
use obvhs::triangle::Triangle;

/// Start of a ray off the surface that it leaves [mm]; above obvhs' absolute epsilon of 1e-4.
pub(crate) const LEAVE_MM: f32 = 0.01;

/// Bounding volume hierarchy of a body's triangles.
#[derive(Debug)]
pub(crate) struct TriangleBvh {
    tree: CwBvh,
    triangles: Vec<Triangle>,
    /// Lowest corner of the box around them [mm].
    pub low: Vec3,
    /// Highest corner of the box around them [mm].
    pub high: Vec3,
}

/// Intersection of a ray with a triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Intersection {
    /// From the start of the ray [mm].
    pub distance: f32,
    /// Unit normal of the triangle, of either sign.
    pub normal: Vec3,
}

impl TriangleBvh {
    /// The hierarchy of the triangles of `mesh`.
    pub fn new(mesh: &Mesh) -> Self {
        let corner = |i: u32| Vec3A::from(mesh.positions[i as usize]);
        let soup: Vec<Triangle> =
            mesh.triangles.iter().map(|t| Triangle { v0: corner(t[0]), v1: corner(t[1]), v2: corner(t[2]) }).collect();
        let tree = build_cwbvh_from_tris(&soup, BvhBuildParams::medium_build(), &mut Duration::default());
        let triangles = tree.primitive_indices.iter().map(|&i| soup[i as usize]).collect();
        let fold = |pick: fn(Vec3, Vec3) -> Vec3| mesh.positions.iter().copied().reduce(pick).unwrap_or(Vec3::ZERO);
        Self { tree, triangles, low: fold(Vec3::min), high: fold(Vec3::max) }
    }

    /// Whether no triangle stands between two points.
    pub(crate) fn unobstructed(&self, from: Vec3, to: Vec3) -> bool {
        let (ray, _) = segment(from, to, LEAVE_MM);
        self.triangles.is_empty() || self.tree.ray_traverse_miss(ray, |ray, id| self.triangles[id].intersect(ray))
    }

    /// The first triangle on the segment from `from` to `to`, beyond a distance `start` [mm].
    pub(crate) fn first_hit(&self, from: Vec3, to: Vec3, start: f32) -> Option<Intersection> {
        let (ray, length) = segment(from, to, start);
        if self.triangles.is_empty() || start >= length {
            return None;
        }
        let mut hit = RayHit::none();
        let met = self.tree.ray_traverse(ray, &mut hit, |ray, id| self.triangles[id].intersect(ray));
        met.then(|| {
            let Triangle { v0, v1, v2 } = self.triangles[hit.primitive_id as usize];
            let normal = Vec3::from((v1 - v0).cross(v2 - v0).normalize_or_zero());
            Intersection { distance: hit.t, normal }
        })
    }
}

/// The ray between two points from `start` on, and their distance [mm].
fn segment(from: Vec3, to: Vec3, start: f32) -> (Ray, f32) {
    let ray = to - from;
    let length = ray.length();
    (Ray::new(from.into(), (ray / length).into(), start, length), length)
}
