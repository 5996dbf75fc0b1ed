//! The saw-tooth of a laser triangulation's calibration: teeth in a row along the laser line.
//!
//! Closed form. With u along the piece from its left end, pitch p = length / teeth and f = u / p - floor(u / p), the
//! height is base + depth f / r on the rising flank (f < r) and base + depth (1 - f) / (1 - r) on the falling one. The
//! number r is the share of the rising flank. At r = 1 the flank falls upright, at r = 0 it rises upright. The piece is
//! turned about the vertical and lies flat on the conveyor.
//!
//! Source: RCAL-300 of SICK, 300 mm long with 15 teeth (Kihl and Källberg 2021, figure 3.13). Depth, width and base are
//! estimates: no source gives them. Neglected: rounded edges, ends that are cut in the middle of a tooth.

use base::{BodyKind, Class, Instance, Matter, Medium, Mesh, Slice, Surface, parameters};
use glam::{Vec2, Vec3};

use super::Material;

parameters! {
    /// The saw-tooth, and how it lies on the conveyor.
    sawtooth: Piece {
        /// Length along the teeth, which lie in a row along the laser line.
        length_mm: 1.0, 1000.0, 300.0, "[T] RCAL-300", fixed;
        /// Teeth.
        teeth: 1.0, 200.0, 15.0, "[T] RCAL-300", fixed, count;
        /// Height of the teeth from valley to peak.
        depth_mm: 0.05, 50.0, 10.0, "[M] flanks of 45 degrees", fixed;
        /// Share of a tooth on which it rises; the rest falls. 0.5 for even flanks, 1 for an upright drop.
        rise_share: 0.0, 1.0, 0.5, "[M]", fixed;
        /// Width along the scan.
        width_mm: 1.0, 500.0, 40.0, "[M]", fixed;
        /// Height of the valleys above the conveyor.
        base_mm: 0.5, 100.0, 10.0, "[M]", fixed;
        /// Turn about the vertical.
        turn_deg: -180.0, 180.0, 0.0, "free", fixed;
        /// Centre of the piece along the laser line.
        offset_mm: -500.0, 500.0, 0.0, "free", fixed;
        /// Conveyor before the piece enters the laser.
        lead_in_mm: 0.0, 500.0, 5.0, "free", fixed;
    }
}

/// A saw-tooth that lies on the conveyor.
#[derive(Debug, Clone)]
pub struct Sawtooth {
    piece: Piece,
    medium: Medium,
    /// Along the piece, in the bench.
    along: Vec2,
    /// Middle of its foot [mm].
    middle: Vec2,
    instances: Vec<Instance>,
}

/// A saw-tooth cut at one scan position.
#[derive(Debug, Clone, Copy)]
struct SawtoothSlice<'a> {
    body: &'a Sawtooth,
    y: f32,
}

impl Sawtooth {
    /// The piece of those numbers.
    pub fn new(piece: &Piece, material: &Material) -> Self {
        let (sin, cos) = libm::sincos(piece.turn_deg.to_radians());
        let half_y = 0.5 * (piece.length_mm * sin.abs() + piece.width_mm * cos.abs());
        let along = Vec2::new(cos as f32, sin as f32);
        let middle = Vec2::new(piece.offset_mm as f32, (piece.lead_in_mm + half_y) as f32);
        let mut body = Self { piece: *piece, medium: material.medium(), along, middle, instances: Vec::new() };
        let pitch = piece.length_mm / piece.teeth;
        // At most 200 teeth.
        body.instances = (1..=piece.teeth as u16)
            .map(|id| {
                let place = body.place(((f64::from(id) - 0.5) * pitch) as f32, 0.0);
                let at = [place.x, place.y].map(f64::from);
                Instance::new(id, Class::Tooth, at, pitch, f64::NAN)
            })
            .collect();
        body
    }

    /// Where the point `u` from the left end along the piece, `v` from its middle across, lies in the bench [mm].
    fn place(&self, u: f32, v: f32) -> Vec2 {
        let u = u - 0.5 * self.piece.length_mm as f32;
        self.middle + self.along * u + Vec2::new(-self.along.y, self.along.x) * v
    }

    /// How far along the piece from its left end, and across from its middle, a place of the bench lies [mm].
    fn local(&self, x: f32, y: f32) -> Vec2 {
        let from = Vec2::new(x, y) - self.middle;
        Vec2::new(
            from.dot(self.along) + 0.5 * self.piece.length_mm as f32,
            from.y * self.along.x - from.x * self.along.y,
        )
    }

    /// Number of the tooth at `u` along the piece from 0, and how far `u` is on the way through it [1].
    fn tooth(&self, u: f32) -> (u16, f32) {
        let teeth = self.piece.teeth as f32;
        let at = u / self.piece.length_mm as f32 * teeth;
        let number = at.floor().clamp(0.0, teeth - 1.0);
        (number as u16, (at - number).clamp(0.0, 1.0))
    }

    /// Height of the upper surface at `u` along the piece, and its slope there [mm] [1].
    fn height(&self, u: f32) -> (f32, f32) {
        let (_, f) = self.tooth(u);
        let (base, depth, rise) = (self.piece.base_mm as f32, self.piece.depth_mm as f32, self.piece.rise_share as f32);
        let pitch = (self.piece.length_mm / self.piece.teeth) as f32;
        if f < rise || rise == 1.0 {
            (base + depth * f / rise, depth / (rise * pitch))
        } else {
            (base + depth * (1.0 - f) / (1.0 - rise), -depth / ((1.0 - rise) * pitch))
        }
    }
}

impl BodyKind for Sawtooth {
    fn slice(&self, y: f32) -> Box<dyn Slice + '_> {
        Box::new(SawtoothSlice { body: self, y })
    }

    /// Its teeth, by number.
    fn instances(&self) -> &[Instance] {
        &self.instances
    }

    /// The piece itself: its surface is flat between its edges.
    fn hull(&self) -> Mesh {
        let piece = &self.piece;
        let (base, top) = (piece.base_mm as f32, (piece.base_mm + piece.depth_mm) as f32);
        let pitch = piece.length_mm / piece.teeth;
        let mut profile = Vec::new();
        for tooth in 0..piece.teeth as usize {
            let start = tooth as f64 * pitch;
            profile.push((start as f32, base));
            profile.push(((start + piece.rise_share * pitch) as f32, top));
        }
        profile.push((piece.length_mm as f32, base));
        // Four corners a point: front and back, above and on the conveyor.
        let half = 0.5 * piece.width_mm as f32;
        let mut mesh = Mesh::default();
        for &(u, z) in &profile {
            for (v, z) in [(-half, z), (half, z), (-half, 0.0), (half, 0.0)] {
                mesh.positions.push(self.place(u, v).extend(z));
            }
        }
        let mut quad = |[a, b, c, d]: [u32; 4]| mesh.triangles.extend([[a, b, c], [a, c, d]]);
        for (i, pair) in profile.windows(2).enumerate() {
            let (a, b) = (4 * i as u32, 4 * (i as u32 + 1));
            quad([a, b, b + 1, a + 1]);
            if pair[0].0 < pair[1].0 {
                quad([a + 2, b + 2, b, a]);
                quad([a + 1, b + 1, b + 3, a + 3]);
                quad([a + 2, a + 3, b + 3, b + 2]);
            }
        }
        let last = 4 * (profile.len() as u32 - 1);
        quad([0, 1, 3, 2]);
        quad([last, last + 2, last + 3, last + 1]);
        mesh
    }

    fn bounds(&self) -> (Vec3, Vec3) {
        let half = 0.5 * Vec2::new(self.piece.length_mm as f32, self.piece.width_mm as f32);
        let (cos, sin) = (self.along.x.abs(), self.along.y.abs());
        let reach = Vec2::new(half.x * cos + half.y * sin, half.x * sin + half.y * cos);
        let top = (self.piece.base_mm + self.piece.depth_mm) as f32;
        ((self.middle - reach).extend(0.0), (self.middle + reach).extend(top))
    }

    fn is_its_hull(&self) -> bool {
        true
    }
}

impl Slice for SawtoothSlice<'_> {
    fn surface(&self, x: f32) -> Option<Surface> {
        let body = self.body;
        let at = body.local(x, self.y);
        let inside =
            (0.0..=body.piece.length_mm as f32).contains(&at.x) && 2.0 * at.y.abs() <= body.piece.width_mm as f32;
        let (z, slope) = body.height(at.x);
        inside.then_some(Surface { z, slope_x: slope * body.along.x, slope_y: slope * body.along.y })
    }

    /// The material, and the tooth that `x` belongs to.
    fn matter(&self, x: f32, _: f32) -> Matter {
        let (tooth, _) = self.body.tooth(self.body.local(x, self.y).x);
        Matter { medium: self.body.medium, film: None, class: Class::Tooth, instance: tooth + 1 }
    }
}
