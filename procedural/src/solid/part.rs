//! A part from a file of triangles, laid on the conveyor.
//!
//! The file's corners are scaled to mm, turned about x, then y, then z, and moved: the middle of the part's box to the
//! offset along the line, its front to the lead-in, its lowest corner to the conveyor or above. The facets are the
//! surface: nothing smooths them. A part may overhang, have holes and consist of several pieces.

use std::sync::Arc;

use base::{BodyKind, Class, Instance, Matter, Medium, Mesh, Slice, Surface, parameters};
use glam::{DVec3, Vec3};

use super::Material;

parameters! {
    /// How the part of the file lies on the conveyor.
    mesh: Placing {
        /// Length of a unit of the file.
        unit_mm: 0.000001, 1000000.0, 1.0, "free; 1 for mm, 25.4 for inches, 1000 for m", fixed;
        /// First turn, about the laser line.
        rotate_x_deg: -180.0, 180.0, 0.0, "free", fixed;
        /// Second turn, about the scan direction.
        rotate_y_deg: -180.0, 180.0, 0.0, "free", fixed;
        /// Third turn, about the vertical.
        rotate_z_deg: -180.0, 180.0, 0.0, "free", fixed;
        /// Middle of the part along the laser line.
        offset_mm: -500.0, 500.0, 0.0, "free", fixed;
        /// Conveyor before the part enters the laser.
        lead_in_mm: 0.0, 500.0, 5.0, "free", fixed;
        /// Height of its lowest corner above the conveyor.
        lift_mm: 0.0, 200.0, 0.0, "free; it lies on the conveyor", fixed;
    }
}

impl Placing {
    /// The corners of `mesh` scaled and turned, not moved yet [mm].
    fn turned(&self, mesh: &Mesh) -> impl Iterator<Item = DVec3> {
        let [x, y, z] =
            [self.rotate_x_deg, self.rotate_y_deg, self.rotate_z_deg].map(|turn| libm::sincos(turn.to_radians()));
        let unit = self.unit_mm;
        mesh.positions.iter().map(move |corner| {
            let p = corner.as_dvec3() * unit;
            let p = DVec3::new(p.x, p.y * x.1 - p.z * x.0, p.y * x.0 + p.z * x.1);
            let p = DVec3::new(p.x * y.1 + p.z * y.0, p.y, p.z * y.1 - p.x * y.0);
            DVec3::new(p.x * z.1 - p.y * z.0, p.x * z.0 + p.y * z.1, p.z)
        })
    }

    /// Size of the part as it lies [mm].
    pub fn extent(&self, mesh: &Mesh) -> DVec3 {
        let (low, high) = ends(self.turned(mesh));
        high - low
    }
}

/// Lowest and highest corner of a box.
fn ends(corners: impl Iterator<Item = DVec3>) -> (DVec3, DVec3) {
    let none = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let ends = corners.fold(none, |(low, high), corner| (low.min(corner), high.max(corner)));
    if ends.0.x <= ends.1.x { ends } else { (DVec3::ZERO, DVec3::ZERO) }
}

/// A part that lies on the conveyor; clones share the triangles.
#[derive(Debug, Clone)]
pub struct Part {
    mesh: Arc<Mesh>,
    medium: Medium,
    low: Vec3,
    high: Vec3,
    instance: [Instance; 1],
}

/// A part cut at one scan position.
#[derive(Debug, Clone, Copy)]
struct PartSlice<'a> {
    part: &'a Part,
    y: f32,
}

impl Part {
    /// The triangles of `mesh` where `placing` lays them.
    pub fn new(mesh: &Mesh, placing: &Placing, material: &Material) -> Self {
        let (low, high) = ends(placing.turned(mesh));
        let to =
            DVec3::new(placing.offset_mm - 0.5 * (low.x + high.x), placing.lead_in_mm - low.y, placing.lift_mm - low.z);
        let positions = placing.turned(mesh).map(|corner| (corner + to).as_vec3()).collect();
        let middle = 0.5 * (low + high) + to;
        let size = high - low;
        let instance = Instance::new(1, Class::Object, [middle.x, middle.y], size.x.max(size.y), f64::NAN);
        Self {
            mesh: Arc::new(Mesh { positions, triangles: mesh.triangles.clone() }),
            medium: material.medium(),
            low: (low + to).as_vec3(),
            high: (high + to).as_vec3(),
            instance: [instance],
        }
    }
}

impl BodyKind for Part {
    fn slice(&self, y: f32) -> Box<dyn Slice + '_> {
        Box::new(PartSlice { part: self, y })
    }

    /// The part, as one thing.
    fn instances(&self) -> &[Instance] {
        &self.instance
    }

    /// Its triangles.
    fn hull(&self) -> Mesh {
        Mesh::clone(&self.mesh)
    }

    /// The conveyor belongs to its box.
    fn bounds(&self) -> (Vec3, Vec3) {
        (self.low.with_z(0.0), self.high)
    }

    fn is_its_hull(&self) -> bool {
        true
    }
}

impl Slice for PartSlice<'_> {
    /// The highest surface above `x`. Goes through all triangles: a scan asks rays
    /// instead.
    fn surface(&self, x: f32) -> Option<Surface> {
        let mesh = &self.part.mesh;
        let at = |corner: u32| mesh.positions[corner as usize];
        let above = |[a, b, c]: &[u32; 3]| {
            let (a, b, c) = (at(*a), at(*b), at(*c));
            let normal = (b - a).cross(c - a);
            let inside = |from: Vec3, to: Vec3| (to.x - from.x) * (self.y - from.y) - (to.y - from.y) * (x - from.x);
            let turns = [inside(a, b), inside(b, c), inside(c, a)];
            let covers = turns.iter().all(|&t| t >= 0.0) || turns.iter().all(|&t| t <= 0.0);
            (covers && normal.z != 0.0).then(|| {
                let (slope_x, slope_y) = (-normal.x / normal.z, -normal.y / normal.z);
                Surface { z: a.z + slope_x * (x - a.x) + slope_y * (self.y - a.y), slope_x, slope_y }
            })
        };
        mesh.triangles.iter().filter_map(above).max_by(|a, b| a.z.total_cmp(&b.z))
    }

    fn matter(&self, _: f32, _: f32) -> Matter {
        Matter { medium: self.part.medium, film: None, class: Class::Object, instance: 1 }
    }
}
