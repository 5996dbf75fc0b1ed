//! A plate of strips side by side: a target with borders, and with cracks.
//!
//! Strips follow each other along x and run along y through the whole plate, which starts at y = 0 and is centred on x
//! = 0. The surface is level; a strip that is sunk is a crack, with upright walls and the strip's matter as its floor.

use base::{BodyKind, Class, Gloss, Matter, Medium, Mesh, Slice, Surface};
use glam::Vec3;

/// One strip of a plate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Strip {
    /// Size along the laser line [mm].
    pub width_mm: f32,
    /// How far its surface lies below the plate's; above 0 in a crack [mm].
    pub sunk_mm: f32,
    /// What it is made of.
    pub medium: Medium,
    /// What it is called.
    pub class: Class,
}

/// A plate of strips.
#[derive(Debug, Clone, PartialEq)]
pub struct Strips {
    /// Height of the plate [mm].
    pub height_mm: f32,
    /// Size along the scan [mm].
    pub length_mm: f32,
    /// The strips from the smallest x on; at least one.
    pub strips: Vec<Strip>,
}

/// A plate of strips cut at one scan position.
#[derive(Debug, Clone, Copy)]
struct StripsSlice<'a> {
    plate: &'a Strips,
    y: f32,
}

impl Strips {
    fn half(&self) -> f32 {
        0.5 * self.strips.iter().map(|strip| strip.width_mm).sum::<f32>()
    }

    /// Strips with their ends along x [mm].
    fn spans(&self) -> impl Iterator<Item = (f32, f32, &Strip)> {
        let mut end = -self.half();
        self.strips.iter().map(move |strip| {
            let start = end;
            end += strip.width_mm;
            (start, end, strip)
        })
    }

    /// The strip at `x`; the outermost ones go on beyond the plate.
    fn at(&self, x: f32) -> Option<&Strip> {
        self.spans().find(|&(_, end, _)| x < end).map(|(.., strip)| strip).or(self.strips.last())
    }
}

impl BodyKind for Strips {
    fn slice(&self, y: f32) -> Box<dyn Slice + '_> {
        Box::new(StripsSlice { plate: self, y })
    }

    fn bounds(&self) -> (Vec3, Vec3) {
        let half = self.half();
        (Vec3::new(-half, 0.0, 0.0), Vec3::new(half, self.length_mm, self.height_mm))
    }

    /// The strips as boxes down to the conveyor.
    fn hull(&self) -> Mesh {
        let mut mesh = Mesh::default();
        for (start, end, strip) in self.spans() {
            let first = mesh.positions.len() as u32;
            for z in [self.height_mm - strip.sunk_mm, 0.0] {
                let corners = [(start, 0.0), (end, 0.0), (end, self.length_mm), (start, self.length_mm)];
                mesh.positions.extend(corners.map(|(x, y)| Vec3::new(x, y, z)));
            }
            let mut triangles = vec![[0, 1, 2], [0, 2, 3], [4, 6, 5], [4, 7, 6]];
            for side in 0..4u32 {
                let next = (side + 1) % 4;
                triangles.push([side, side + 4, next + 4]);
                triangles.push([side, next + 4, next]);
            }
            mesh.triangles.extend(triangles.iter().map(|corners| corners.map(|corner| corner + first)));
        }
        mesh
    }
}

impl Slice for StripsSlice<'_> {
    fn surface(&self, x: f32) -> Option<Surface> {
        let plate = self.plate;
        let inside = x.abs() <= plate.half() && (0.0..=plate.length_mm).contains(&self.y);
        let strip = plate.at(x).filter(|_| inside)?;
        Some(Surface { z: plate.height_mm - strip.sunk_mm, slope_x: 0.0, slope_y: 0.0 })
    }

    /// Medium and class of the strip.
    fn matter(&self, x: f32, _: f32) -> Matter {
        let (medium, class) = match self.plate.at(x) {
            Some(strip) => (strip.medium, strip.class),
            None => (Medium::opaque(Gloss::NONE), Class::Background),
        };
        Matter { medium, film: None, class, instance: 0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plate() -> Strips {
        let strip =
            |width_mm, sunk_mm, class| Strip { width_mm, sunk_mm, medium: Medium::opaque(Gloss::wood(0.5)), class };
        let strips = vec![strip(4.0, 0.0, Class::Clear), strip(1.0, 3.0, Class::Rot), strip(5.0, 0.0, Class::DeadKnot)];
        Strips { height_mm: 8.0, length_mm: 20.0, strips }
    }

    #[test]
    fn strips_stand_side_by_side_and_cracks_are_sunk() {
        let plate = plate();
        assert_eq!(plate.bounds(), (Vec3::new(-5.0, 0.0, 0.0), Vec3::new(5.0, 20.0, 8.0)));
        let slice = plate.slice(3.0);
        let look = |x: f32| (slice.surface(x).map(|s| s.z), slice.matter(x, 0.0).class);
        assert_eq!(look(-4.9), (Some(8.0), Class::Clear));
        assert_eq!(look(-0.5), (Some(5.0), Class::Rot));
        assert_eq!(look(0.5), (Some(8.0), Class::DeadKnot));
        assert_eq!(look(5.1), (None, Class::DeadKnot));
        assert_eq!(plate.slice(-0.1).surface(0.0), None);
    }

    /// The divergence theorem: a closed hull with all faces outwards holds the strips' volume.
    #[test]
    fn the_hull_holds_the_volume_of_the_strips() {
        let mesh = plate().hull();
        let corner = |i: u32| mesh.positions[i as usize];
        let volume: f32 = mesh.triangles.iter().map(|t| corner(t[0]).dot(corner(t[1]).cross(corner(t[2]))) / 6.0).sum();
        assert!((volume - 20.0 * (4.0 * 8.0 + 5.0 + 5.0 * 8.0)).abs() < 1e-3, "volume {volume}");
    }
}
