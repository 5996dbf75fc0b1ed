//! Scenes and scans that the black-box tests share.

use base::{BodyKind, Class, Matter, Stream};
use procedural::wood::Plank;
use procedural::wood::Wood;

/// The default board with that many sound and dead knots.
pub fn wood(sound: f64, dead: f64) -> Wood {
    let mut wood = Wood::from_values(&mut |p| p.default);
    wood.knots.sound_count = sound;
    wood.knots.dead_count = dead;
    wood
}

/// The board of a seed.
pub fn grow(seed: u64, wood: &Wood) -> Plank {
    Plank::grow(Stream::root(seed), wood)
}

/// What lies at the upper surface, every `step` mm both ways: x [mm], y [mm] and matter.
pub fn face(plank: &Plank, step: f32) -> Vec<(f32, f32, Matter)> {
    let (low, high) = plank.bounds();
    let mut face = Vec::new();
    for j in 0..((high.y - low.y) / step) as usize {
        let y = low.y + (j as f32 + 0.5) * step;
        let slice = plank.slice(y);
        for i in 0..((high.x - low.x) / step) as usize {
            let x = low.x + (i as f32 + 0.5) * step;
            let surface = slice.surface(x).expect("inside the board");
            face.push((x, y, slice.matter(x, surface.z)));
        }
    }
    face
}

/// Angle between fibre and the horizontal [deg].
pub fn dive_deg(matter: &Matter) -> f32 {
    matter.medium.fibre.z.abs().min(1.0).asin().to_degrees()
}

/// Whether it is a knot.
pub fn is_knot(class: Class) -> bool {
    matches!(class, Class::SoundKnot | Class::DeadKnot)
}
