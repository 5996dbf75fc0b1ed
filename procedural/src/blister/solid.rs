//! Convex solids below the film: tablets, pieces of them, particles.

use glam::Vec3;

use crate::{Class, Medium};

/// A convex solid in the pack's coordinates.
#[derive(Debug, Clone, PartialEq)]
pub struct Solid {
    /// Lowest and highest corner of a box around it [mm].
    pub bounds: [Vec3; 2],
    /// Class of its visible pixels where that is not the pocket's own.
    pub class: Class,
    /// What it is made of.
    pub medium: Medium,
}

impl Solid {
    /// Where the straight way `from + t way` is inside: t of entry and of exit, in units of `way`'s length; either may
    /// be negative.
    pub fn span(&self, from: Vec3, way: Vec3) -> Option<[f32; 2]> {
        let (low, high) = ((self.bounds[0] - from) / way, (self.bounds[1] - from) / way);
        let (near, far) = (low.min(high).max_element(), low.max(high).min_element());
        (near < far).then_some([near, far])
    }

    /// Outward unit normal of its surface nearest to `at` [1].
    pub fn normal(&self, at: Vec3) -> Vec3 {
        let middle = 0.5 * (self.bounds[0] + self.bounds[1]);
        let d = (at - middle) / (self.bounds[1] - self.bounds[0]);
        let a = d.abs();
        if a.z >= a.x && a.z >= a.y {
            Vec3::Z * d.z.signum()
        } else if a.x >= a.y {
            Vec3::X * d.x.signum()
        } else {
            Vec3::Y * d.y.signum()
        }
    }
}
