//! Saw-teeth and parts against closed forms: heights, slopes, volume, places, and an effect of every number.

use std::collections::BTreeMap;

use base::{Body, BodyKind, Class, Mesh};
use glam::{DVec3, Vec3};
use procedural::solid::{Material, Part, Piece, Placing, Sawtooth};

fn piece() -> Piece {
    Piece::from_values(&mut |p| p.default)
}

fn placing() -> Placing {
    Placing::from_values(&mut |p| p.default)
}

fn metal() -> Material {
    Material::from_values(&mut |p| p.default)
}

/// A box from the origin.
fn cuboid(size: Vec3) -> Mesh {
    let corner = |i: u32| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) * size;
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    Mesh { positions: (0..8).map(corner).collect(), triangles }
}

/// Volume by Gauss' theorem, positive where triangles turn counter-clockwise from outside [mm^3].
fn volume(mesh: &Mesh) -> f64 {
    let at = |i: u32| mesh.positions[i as usize].as_dvec3();
    mesh.triangles.iter().map(|t| at(t[0]).dot(at(t[1]).cross(at(t[2]))) / 6.0).sum()
}

/// Every way along an edge has one back, by places: the mesh is closed.
fn is_closed(mesh: &Mesh) -> bool {
    let key = |i: u32| mesh.positions[i as usize].to_array().map(f32::to_bits);
    let mut ways = BTreeMap::new();
    for t in &mesh.triangles {
        for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
            *ways.entry((key(a), key(b))).or_insert(0) += 1;
            *ways.entry((key(b), key(a))).or_insert(0) -= 1;
        }
    }
    ways.values().all(|&balance| balance == 0)
}

/// Fifteen teeth of 20 mm: valleys, peaks and the middle of flanks are where the drawing says.
#[test]
fn the_saw_tooth_has_its_closed_form() {
    let mut piece = piece();
    piece.rise_share = 0.25;
    let body = Sawtooth::new(&piece, &metal());
    let slice = body.slice(20.0);
    for tooth in 0..15u16 {
        let start = -150.0 + 20.0 * f32::from(tooth);
        for (u, z, slope) in [(0.01, 10.02, 2.0), (2.5, 15.0, 2.0), (4.99, 19.98, 2.0), (12.5, 15.0, -2.0 / 3.0)] {
            let surface = slice.surface(start + u).expect("on the piece");
            assert!((surface.z - z).abs() < 1e-3 && (surface.slope_x - slope).abs() < 1e-4, "{tooth} {u} {surface:?}");
            assert_eq!(surface.slope_y, 0.0);
            let matter = slice.matter(start + u, 0.0);
            assert_eq!((matter.class, matter.instance), (Class::Tooth, tooth + 1));
        }
        let instance = body.instances()[usize::from(tooth)];
        assert_eq!(instance.id, tooth + 1);
        assert!((instance.x_mm - f64::from(start) - 10.0).abs() < 1e-4 && (instance.y_mm - 25.0).abs() < 1e-4);
    }
    assert!(slice.surface(150.1).is_none() && slice.surface(-150.1).is_none());
    assert!(body.slice(4.9).surface(0.0).is_none() && body.slice(45.1).surface(0.0).is_none());
}

/// Triangles, height and box tell of one piece, whatever its flanks and its turn; its volume is base and half the
/// teeth.
#[test]
fn triangles_are_the_closed_form() {
    for (rise_share, turn_deg) in [(0.5, 0.0), (0.0, 20.0), (1.0, -70.0), (0.8, 180.0)] {
        let piece = Piece { rise_share, turn_deg, length_mm: 60.0, teeth: 7.0, ..piece() };
        let sawtooth = Sawtooth::new(&piece, &metal());
        let mesh = sawtooth.hull();
        // Beside an upright flank a side is higher than its neighbour: their edges lie in one another.
        assert!([0.0, 1.0].contains(&rise_share) || is_closed(&mesh), "{piece:?}");
        let expected = 60.0 * piece.width_mm * (piece.base_mm + 0.5 * piece.depth_mm);
        assert!((volume(&mesh) / expected - 1.0).abs() < 1e-5, "{} of {expected}", volume(&mesh));
        let (low, high) = sawtooth.bounds();
        let fold = |f: fn(Vec3, Vec3) -> Vec3| mesh.positions.iter().copied().reduce(f).expect("corners");
        assert!(fold(Vec3::min).distance(low) < 1e-4 && fold(Vec3::max).distance(high) < 1e-4);
        assert!((f64::from(low.y) - piece.lead_in_mm).abs() < 1e-4);
        // The same triangles as a part that lies where they lie.
        let middle = 0.5 * (low.x + high.x);
        let placing = Placing { offset_mm: f64::from(middle), lead_in_mm: f64::from(low.y), ..placing() };
        let part = Part::new(&mesh, &placing, &metal());
        for (i, j) in (0..40).flat_map(|i| (0..40).map(move |j| (i as f32, j as f32))) {
            let (x, y) = (low.x + (high.x - low.x) * (i + 0.3) / 40.0, low.y + (high.y - low.y) * (j + 0.6) / 40.0);
            match (sawtooth.slice(y).surface(x), part.slice(y).surface(x)) {
                (Some(a), Some(b)) => {
                    // Over an upright flank both heights are right.
                    let upright = a.slope_x.abs() + a.slope_y.abs() > 50.0 || (a.z - b.z).abs() > 0.9 * 10.0;
                    assert!(upright || (a.z - b.z).abs() < 2e-3, "{x} {y}: {a:?} {b:?}");
                }
                (None, None) => {}
                other => panic!("{x} {y}: {other:?}"),
            }
        }
    }
}

/// A box of 1 x 2 x 3 inches, tipped and turned, has the size and place that its turns give it.
#[test]
fn parts_lie_where_they_are_laid() {
    let mesh = cuboid(Vec3::new(1.0, 2.0, 3.0));
    let inches = Placing { unit_mm: 25.4, offset_mm: 7.0, lead_in_mm: 4.0, lift_mm: 2.0, ..placing() };
    for (turns, size) in [
        ([0.0, 0.0, 0.0], [1.0, 2.0, 3.0]),
        ([90.0, 0.0, 0.0], [1.0, 3.0, 2.0]),
        ([0.0, 90.0, 0.0], [3.0, 2.0, 1.0]),
        ([0.0, 0.0, 90.0], [2.0, 1.0, 3.0]),
        // x, y, z become x, -z, y, then y, -z, -x: the order of turns counts.
        ([90.0, 0.0, 90.0], [3.0, 1.0, 2.0]),
    ] {
        let [rotate_x_deg, rotate_y_deg, rotate_z_deg] = turns;
        let placing = Placing { rotate_x_deg, rotate_y_deg, rotate_z_deg, ..inches };
        let size = DVec3::from(size) * 25.4;
        assert!(placing.extent(&mesh).distance(size) < 1e-4, "{turns:?}: {}", placing.extent(&mesh));
        let part = Part::new(&mesh, &placing, &metal());
        let (low, high) = part.bounds();
        assert!(low.distance(Vec3::new(7.0 - 0.5 * size.x as f32, 4.0, 0.0)) < 1e-4, "{low}");
        assert!(high.distance(Vec3::new(7.0 + 0.5 * size.x as f32, 4.0 + size.y as f32, 2.0 + size.z as f32)) < 1e-4);
        assert!((volume(&part.hull()) / (6.0 * 25.4f64.powi(3)) - 1.0).abs() < 1e-5, "no mirror image");
        let top = part.slice(4.0 + 0.4 * size.y as f32).surface(7.1).expect("on it");
        assert!((top.z - high.z).abs() < 1e-4 && top.slope_x.abs() < 1e-5);
    }
    let part = Body::new(Part::new(&mesh, &inches, &metal()));
    assert_eq!((part.instances().len(), part.slice(10.0).matter(7.0, 10.0).class), (1, Class::Object));
}

/// Each number moves a corner or a height.
#[test]
fn every_number_has_an_effect() {
    let bent = |p: &base::Parameter| if p.integer { p.default + 1.0 } else { p.default + 0.3 };
    let hull = Sawtooth::new(&piece(), &metal()).hull();
    for changed in Piece::PARAMETERS {
        let piece = Piece::from_values(&mut |p| if p == changed { bent(p) } else { p.default });
        assert_ne!(Sawtooth::new(&piece, &metal()).hull(), hull, "{}", changed.name);
    }
    let mesh = cuboid(Vec3::new(1.0, 2.0, 3.0));
    let hull = Part::new(&mesh, &placing(), &metal()).hull();
    for changed in Placing::PARAMETERS {
        let placing = Placing::from_values(&mut |p| if p == changed { bent(p) } else { p.default });
        assert_ne!(Part::new(&mesh, &placing, &metal()).hull(), hull, "{}", changed.name);
    }
}
