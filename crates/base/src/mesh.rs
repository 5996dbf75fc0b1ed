//! A triangle mesh: the coarse hull of a body, or the surface of a part.

use glam::Vec3;

/// Triangles over shared corners.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Mesh {
    /// Corners [mm].
    pub positions: Vec<Vec3>,
    /// Three corner numbers a triangle, counter-clockwise from outside.
    pub triangles: Vec<[u32; 3]>,
}
