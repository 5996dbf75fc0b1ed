//! Clearance about a point in a convex solid, so that light deep inside need not ask how far the surface is.
//!
//! A convex body holds the octahedron of the six points where it ends along the axes; with the nearer end a_i of each
//! axis, that holds a ball of radius (sum a_i^-2)^(-1/2).

use glam::{DVec3, Vec3};
use procedural::blister::Solid;

/// Optical radius under which a [`Clearance`] is not worth its making, and free paths until the next is tried.
const MIN_OPTICAL_RADIUS: f64 = 4.0;
const PATHS_TO_WAIT: u32 = 8;

/// A ball inside a solid: no surface is met in it.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Clearance {
    middle: DVec3,
    radius: f64,
    /// Free paths to wait until another is looked for.
    wait: u32,
}

impl Clearance {
    /// The largest about `middle` that the solid's reach along the axes, as it is convex, vouches for.
    fn about(middle: DVec3, solid: &Solid) -> Option<Self> {
        let mut flat = 0.0;
        for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
            let [near, far] = solid.span(middle.as_vec3(), axis)?;
            let reach = f64::from(far.min(-near).max(1e-6));
            flat += 1.0 / (reach * reach);
        }
        Some(Self { middle, radius: 1.0 / flat.sqrt(), wait: 0 })
    }

    /// Looks for the clearance about a point that is not in this one, unless there was too little not long ago.
    #[inline]
    pub(crate) fn renew(&mut self, position: DVec3, solid: &Solid, extinction: f64) {
        self.wait = self.wait.saturating_sub(1);
        if self.wait == 0 {
            *self = Self::about(position, solid).unwrap_or_default();
            self.wait = if self.radius * extinction < MIN_OPTICAL_RADIUS { PATHS_TO_WAIT } else { 0 };
        }
    }

    /// Distance that is free in all directions [mm].
    #[inline(always)]
    pub fn free(&self, position: DVec3) -> f64 {
        (self.radius - position.distance(self.middle)).max(0.0)
    }
}
