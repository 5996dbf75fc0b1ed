//! Triangles in space, and what a ray meets first.

use std::time::Duration;

use glam::{DVec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::builder::build_cwbvh_from_tris;
use obvhs::ray::{Ray, RayHit};
use obvhs::triangle::Triangle;

/// A triangle of one matte colour.
#[derive(Debug, Clone, Copy)]
pub struct Facet {
    pub corners: [DVec3; 3],
    /// Unit vector outwards.
    pub normal: DVec3,
    /// Share of light thrown back evenly; 0 is black [1].
    pub matte: f64,
}

impl Facet {
    /// Corners counter-clockwise from outside [mm].
    pub fn new(corners: [DVec3; 3], matte: f64) -> Self {
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
        Self { corners, normal, matte }
    }

    /// Both halves of a quadrilateral.
    pub fn quad(corners: [DVec3; 4], matte: f64) -> [Self; 2] {
        let [a, b, c, d] = corners;
        [Self::new([a, b, c], matte), Self::new([a, c, d], matte)]
    }
}

/// Triangles ready for rays.
pub struct Object {
    tree: CwBvh,
    triangles: Vec<Triangle>,
    facets: Vec<Facet>,
}

impl Object {
    /// Over at least one triangle.
    pub fn new(facets: Vec<Facet>) -> Self {
        let single = |v: DVec3| Vec3A::new(v.x as f32, v.y as f32, v.z as f32);
        let soup: Vec<Triangle> = facets
            .iter()
            .map(|f| Triangle { v0: single(f.corners[0]), v1: single(f.corners[1]), v2: single(f.corners[2]) })
            .collect();
        let tree = build_cwbvh_from_tris(&soup, BvhBuildParams::medium_build(), &mut Duration::default());
        let order = &tree.primitive_indices;
        let triangles = order.iter().map(|&i| soup[i as usize]).collect();
        let facets = order.iter().map(|&i| facets[i as usize]).collect();
        Self { tree, triangles, facets }
    }

    /// Where a ray along the unit vector `way` first meets a triangle, exact on its plane.
    pub fn first(&self, from: DVec3, way: DVec3) -> Option<(DVec3, &Facet)> {
        let ray = Ray::new_inf(single(from), single(way));
        let mut hit = RayHit::none();
        let met = self.tree.ray_traverse(ray, &mut hit, |ray, id| self.triangles[id].intersect(ray));
        met.then(|| {
            let facet = &self.facets[hit.primitive_id as usize];
            let t = (facet.corners[0] - from).dot(facet.normal) / way.dot(facet.normal);
            (from + way * t, facet)
        })
    }

    /// Whether nothing stands between two points.
    pub fn free(&self, from: DVec3, to: DVec3) -> bool {
        let way = to - from;
        let length = way.length();
        let ray = Ray::new(single(from), single(way / length), 1e-3, length as f32);
        self.tree.ray_traverse_miss(ray, |ray, id| self.triangles[id].intersect(ray))
    }
}

fn single(v: DVec3) -> Vec3A {
    Vec3A::new(v.x as f32, v.y as f32, v.z as f32)
}
