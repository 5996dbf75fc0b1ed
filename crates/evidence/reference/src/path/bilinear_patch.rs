//! Bilinear patch: the surface between four nodes of a height field, a hyperbolic paraboloid.
//!
//! Height h + (x - h) u + (y - h) v + (h + xy - x - y) u v over the cell [0, 1]^2. A ray crosses it where a quadratic
//! equation in its length has a root. Height fields of bodies and of packs are made of these.

use glam::{DVec2, DVec3};

/// Heights of a cell's nodes: at its low corner, along x, along y, opposite [mm].
#[derive(Debug, Clone, Copy)]
pub(super) struct BilinearPatch(pub [f64; 4]);

impl BilinearPatch {
    /// Height at a place of the cell [mm].
    #[inline(always)]
    pub fn height(self, u: f64, v: f64) -> f64 {
        let [h, x, y, xy] = self.0;
        h + (x - h) * u + (y - h) * v + (h + xy - x - y) * u * v
    }

    /// Upward unit normal at a place of a cell of size `pitch` [mm].
    #[inline(always)]
    pub fn normal(self, u: f64, v: f64, pitch: DVec2) -> DVec3 {
        let [h, x, y, xy] = self.0;
        let twist = h + xy - x - y;
        DVec3::new(-((x - h) + twist * v) / pitch.x, -((y - h) + twist * u) / pitch.y, 1.0).normalize()
    }

    /// Length from a place of the cell, at height `z`, to where a ray comes above the patch (`side` 1) or below it
    /// (-1); infinite if it does not [mm].
    #[inline(always)]
    pub(crate) fn crossing(self, [u, v, z]: [f64; 3], direction: DVec3, pitch: DVec2, side: f64) -> f64 {
        let [h, x, y, xy] = self.0;
        let (du, dv) = (direction.x / pitch.x, direction.y / pitch.y);
        let (rise_x, rise_y, twist) = (x - h, y - h, h + xy - x - y);
        // Height over the patch along the ray: a t^2 + b t + c; it rises through 0 where light gets to the other side.
        let a = side * -twist * du * dv;
        let b = side * (direction.z - rise_x * du - rise_y * dv - twist * (u * dv + v * du));
        let c = side * (z - h - rise_x * u - rise_y * v - twist * u * v);
        if c >= 0.0 && b > 0.0 {
            // On the patch, or beyond it by rounding.
            return 0.0;
        }
        let d = b * b - 4.0 * a * c;
        if d < 0.0 {
            return f64::INFINITY;
        }
        let root = if b > 0.0 { -2.0 * c / (b + d.sqrt()) } else { (d.sqrt() - b) / (2.0 * a) };
        if root >= 0.0 { root } else { f64::INFINITY }
    }
}
