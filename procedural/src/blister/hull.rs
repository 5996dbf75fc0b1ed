//! A closed mesh of the pack: upper side of the film, lower side on the card's bottom, a wall around.

use base::Mesh;
use glam::Vec2;

use super::card_placement::CardPlacement;

/// Distance between corners [mm].
const PITCH_MM: f32 = 0.5;

/// The hull under `top`, the upper side over a flat card [mm].
pub fn hull(lay: &CardPlacement, top: impl Fn(Vec2) -> f32) -> Mesh {
    let [columns, rows] = [lay.half.x, lay.half.y].map(|half| (2.0 * half / PITCH_MM) as u32 + 1);
    let mut positions = Vec::with_capacity(2 * ((columns + 1) * (rows + 1)) as usize);
    // Rows along the laser line, each as wide as the rounded card is there.
    for upper in [true, false] {
        for j in 0..=rows {
            let v = lay.half.y * (2.0 * j as f32 / rows as f32 - 1.0);
            let half = lay.half_width(v);
            for i in 0..=columns {
                let p = Vec2::new(half * (2.0 * i as f32 / columns as f32 - 1.0), v);
                let height = if upper { top(p) } else { 0.0 };
                positions.push(lay.conveyor(p).extend(height + lay.warp(p).0));
            }
        }
    }
    let wide = columns + 1;
    let lower = wide * (rows + 1);
    let mut triangles = Vec::with_capacity(4 * (columns * rows + columns + rows) as usize);
    for j in 0..rows {
        for i in 0..columns {
            let a = j * wide + i;
            let (b, c, d) = (a + 1, a + wide + 1, a + wide);
            triangles.extend([[a, b, c], [a, c, d]]);
            triangles.extend([[a, c, b], [a, d, c]].map(|t| t.map(|i| i + lower)));
        }
    }
    let mut wall = |a: u32, b: u32| triangles.extend([[a, a + lower, b + lower], [a, b + lower, b]]);
    for i in 0..columns {
        wall(i, i + 1);
        wall(rows * wide + i + 1, rows * wide + i);
    }
    for j in 0..rows {
        wall((j + 1) * wide, j * wide);
        wall(j * wide + columns, (j + 1) * wide + columns);
    }
    Mesh { positions, triangles }
}

/// Triangles of a mesh enclose this volume [mm^3].
#[cfg(test)]
fn volume(mesh: &Mesh) -> f64 {
    let corner = |i: u32| -> glam::DVec3 { mesh.positions[i as usize].as_dvec3() };
    mesh.triangles.iter().map(|t| corner(t[0]).dot(corner(t[1]).cross(corner(t[2]))) / 6.0).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::blister::parameters::Card;

    #[test]
    fn a_plate_has_the_volume_of_a_plate() {
        let mut card = Card::from_values(&mut |p| p.default);
        card.turn_deg = 30.0;
        let mesh = hull(&CardPlacement::new(&card), |_| 2.0);
        let corners = (4.0 - std::f64::consts::PI) * card.corner_mm * card.corner_mm;
        let expected = 2.0 * (card.width_mm * card.length_mm - corners);
        assert!((volume(&mesh) / expected - 1.0).abs() < 2.0e-3, "{} for {expected}", volume(&mesh));
    }
}
