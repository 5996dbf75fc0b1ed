//! A flat target of one medium: the calibration plane.
//!
//! Height is linear: z = height + slope_x x + slope_y y, over a rectangle that starts at y = 0 and is centred on x = 0.

use base::{BodyKind, Class, Matter, Medium, Mesh, Slice, Surface};
use glam::Vec3;

/// A tilted plane of one medium.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Flat {
    /// Height at the origin [mm].
    pub height_mm: f32,
    /// dz/dx [1].
    pub slope_x: f32,
    /// dz/dy [1].
    pub slope_y: f32,
    /// Size along the laser line [mm].
    pub width_mm: f32,
    /// Size along the scan [mm].
    pub length_mm: f32,
    /// What it is made of.
    pub medium: Medium,
}

/// A flat target cut at one scan position.
#[derive(Debug, Clone, Copy)]
struct FlatSlice<'a> {
    flat: &'a Flat,
    y: f32,
}

impl Flat {
    fn height(&self, x: f32, y: f32) -> f32 {
        self.height_mm + self.slope_x * x + self.slope_y * y
    }
}

impl BodyKind for Flat {
    fn slice(&self, y: f32) -> Box<dyn Slice + '_> {
        Box::new(FlatSlice { flat: self, y })
    }

    fn bounds(&self) -> (Vec3, Vec3) {
        let half = 0.5 * self.width_mm;
        let near = self.height(-half, 0.0).max(self.height(half, 0.0));
        let far = self.height(-half, self.length_mm).max(self.height(half, self.length_mm));
        (Vec3::new(-half, 0.0, 0.0), Vec3::new(half, self.length_mm, near.max(far)))
    }

    fn has_ends(&self) -> bool {
        false
    }

    /// The plate down to the conveyor.
    fn hull(&self) -> Mesh {
        let half = 0.5 * self.width_mm;
        let corners = [(-half, 0.0), (half, 0.0), (half, self.length_mm), (-half, self.length_mm)];
        let mut positions: Vec<Vec3> = corners.iter().map(|&(x, y)| Vec3::new(x, y, self.height(x, y))).collect();
        positions.extend(corners.iter().map(|&(x, y)| Vec3::new(x, y, 0.0)));
        let mut triangles = vec![[0, 1, 2], [0, 2, 3], [4, 6, 5], [4, 7, 6]];
        for side in 0..4u32 {
            let next = (side + 1) % 4;
            triangles.push([side, side + 4, next + 4]);
            triangles.push([side, next + 4, next]);
        }
        Mesh { positions, triangles }
    }
}

impl Slice for FlatSlice<'_> {
    fn surface(&self, x: f32) -> Option<Surface> {
        let flat = self.flat;
        let inside = x.abs() <= 0.5 * flat.width_mm && (0.0..=flat.length_mm).contains(&self.y);
        inside.then(|| Surface { z: flat.height(x, self.y), slope_x: flat.slope_x, slope_y: flat.slope_y })
    }

    fn matter(&self, _: f32, _: f32) -> Matter {
        Matter { medium: self.flat.medium, film: None, class: Class::Clear, instance: 0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use base::Gloss;

    #[test]
    fn the_box_touches_the_highest_corner_of_a_tilted_plate() {
        let medium = Medium::opaque(Gloss::wood(0.5));
        let flat = Flat { height_mm: 5.0, slope_x: -0.1, slope_y: 0.02, width_mm: 40.0, length_mm: 50.0, medium };
        let (low, high) = flat.bounds();
        assert_eq!(low, Vec3::new(-20.0, 0.0, 0.0));
        assert!(high.distance(Vec3::new(20.0, 50.0, 8.0)) < 1.0e-5);
        assert_eq!(flat.slice(50.0).surface(-20.0).map(|s| s.z), Some(high.z));
    }
}
