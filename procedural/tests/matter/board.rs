//! Boards from outside: determinism, the surface, the hull, rot, and that every parameter does something.

use crate::boards::{face, grow, wood};
use crate::wood_defects::KINDS;
use base::{BodyKind, Class, Parameter};
use procedural::wood::Plank;
use procedural::wood::Wood;

/// Everything that a board answers, sampled coarsely, as words to compare.
fn answers(plank: &Plank) -> Vec<u32> {
    let mut words: Vec<u32> = Vec::new();
    for j in 0..60 {
        let slice = plank.slice(15.0 + 4.03 * j as f32);
        for i in 0..120 {
            let x = -60.0 + i as f32;
            if let Some(s) = slice.surface(x) {
                words.extend([s.z, s.slope_x, s.slope_y].map(f32::to_bits));
            }
            let m = slice.matter(x, 21.7);
            let (o, f) = (m.medium, m.medium.fibre);
            let gloss = [o.gloss.share, o.gloss.roughness[0]];
            let numbers =
                [o.mu_a, o.sigma_i, o.k, o.n_eff, o.dispersion_deg, gloss[0], gloss[1], o.coat, f.x, f.y, f.z];
            words.extend(numbers.map(f32::to_bits));
            words.extend([m.class as u32, u32::from(m.instance)]);
        }
    }
    words.extend(plank.hull().positions.iter().flat_map(|p| p.to_array()).map(f32::to_bits));
    words.extend(format!("{:?}", plank.instances()).bytes().map(u32::from));
    words
}

/// A board on which every parameter has something to act on.
fn rich() -> Wood {
    let mut wood = wood(2.0, 2.0);
    wood.rot.reach_mm = 25.0;
    wood.rot.severity = 0.6;
    wood.log.grain_angle_deg = 2.0;
    wood
}

/// The same with every defect.
fn full() -> Wood {
    let mut wood = rich();
    KINDS.iter().for_each(|kind| (kind.ask)(&mut wood));
    (wood.log, wood.rot) = (rich().log, rich().rot);
    wood.log.heartwood_mm = 25.0;
    wood.log.pith_mm = 9.5;
    wood.log.pith_depth_mm = 9.0;
    wood.log.pith_offset_mm = -38.0;
    wood.knots.hole_count = 2.0;
    wood.knots.loose_count = 2.0;
    wood.rot.heart_mm = 8.0;
    wood.rot.pocket_count = 3.0;
    wood.rot.incipient_mm = 6.0;
    wood.compression.severity = 0.8;
    wood.stain.severity = 0.7;
    wood.inclusions.resin_pocket_count = 4.0;
    wood.inclusions.resin_streak_count = 2.0;
    wood.inclusions.bark_pocket_count = 3.0;
    wood.cracks.check_count = 12.0;
    wood.cracks.shake_count = 4.0;
    wood.cracks.split_count = 4.0;
    wood.cracks.width_mm = 1.5;
    wood.holes.count = 60.0;
    wood.holes.diameter_mm = 4.0;
    wood.wane.width_mm = 15.0;
    wood.wane.edge = -1.0;
    wood.marks.dirt_count = 6.0;
    wood.marks.roller_um = 200.0;
    wood.marks.skip_count = 2.0;
    wood.marks.burn_count = 2.0;
    wood.marks.chip_count = 8.0;
    wood.marks.chip_mm = 20.0;
    wood.moisture.patch_count = 3.0;
    wood.moisture.film = 0.4;
    wood.board.edge_wander_mm = 0.5;
    wood.log.ring_width_pith_ratio = 1.5;
    wood.log.juvenile_rings = 40.0;
    wood.rot.loss_mm = 0.5;
    wood.grain.torn_um = 80.0;
    wood.grain.fuzzy_um = 30.0;
    wood.anatomy.canals_per_mm2 = 5.0;
    wood.anatomy.pores_per_mm2 = 20.0;
    wood.anatomy.pore_ring = 0.5;
    wood.anatomy.ray_share = 0.1;
    wood.machining.planer_um = 5.0;
    wood.machining.band_um = 30.0;
    wood.machining.teeth_um = 8.0;
    wood.machining.circular_um = 20.0;
    wood.machining.circular_radius_mm = 400.0;
    wood
}

fn with(base: &Wood, changed: &Parameter, value: f64) -> Wood {
    let mut values = base.values().into_iter();
    Wood::from_values(&mut |p| {
        let (same, old) = values.next().expect("as many values as declarations");
        assert_eq!(same.path(), p.path());
        if p.path() == changed.path() { value } else { old }
    })
}

#[test]
fn every_parameter_has_an_effect() {
    let base = full();
    let before = answers(&grow(5, &base));
    // Of the stem `stem.rs` asks, of places in pictures and stacks of slices the tests of the crate wood_picture.
    let grown = |group: &str| !["stem", "picture", "slices"].contains(&group);
    for (parameter, value) in base.values().into_iter().filter(|(parameter, _)| grown(parameter.group)) {
        // A tenth of the way to the farther end of the range, or one more; the side of the edge and cracks of few knots
        // need the far end.
        let end = if parameter.max - value > value - parameter.min { parameter.max } else { parameter.min };
        let step = if ["edge", "crack_share"].contains(&parameter.name) { 1.0 } else { 0.1 };
        let mut other = value + step * (end - value);
        if parameter.integer {
            other = value + 1.0;
        }
        let after = answers(&grow(5, &with(&base, parameter, other)));
        assert!(before != after, "{} does nothing from {value} to {other}", parameter.path());
    }
}

#[test]
fn a_board_is_a_function_of_its_stream_and_numbers() {
    let base = rich();
    let (a, b) = (grow(5, &base), grow(5, &base));
    assert!(answers(&a) == answers(&b));
    assert!(answers(&a) != answers(&grow(6, &base)));
    // The order of questions does not matter.
    let forward: Vec<_> = (0..200).map(|i| a.slice(30.0 + i as f32).matter(i as f32 * 0.4 - 40.0, 20.0)).collect();
    let mut backward: Vec<_> =
        (0..200).rev().map(|i| a.slice(30.0 + i as f32).matter(i as f32 * 0.4 - 40.0, 20.0)).collect();
    backward.reverse();
    assert!(forward == backward);
}

#[test]
fn the_saw_does_not_change_the_tree() {
    let base = rich();
    let mut rough = base;
    rough.board.saw_ripple_um = 80.0;
    rough.board.saw_pitch_mm = 7.0;
    rough.board.roughness_um = 40.0;
    let (a, b) = (grow(5, &base), grow(5, &rough));
    assert_eq!(format!("{:?}", a.instances()), format!("{:?}", b.instances()));
    for j in 0..100 {
        let y = 21.0 + 2.0 * j as f32;
        for i in 0..90 {
            let x = i as f32 - 45.0;
            assert_eq!(a.slice(y).matter(x, 21.0), b.slice(y).matter(x, 21.0));
        }
    }
}

#[test]
fn slopes_match_finite_differences() {
    let mut wood = rich();
    wood.board.saw_ripple_um = 60.0;
    wood.board.cup_mm = 1.0;
    wood.board.twist_deg = 1.0;
    wood.log.grain_angle_deg = 20.0;
    let plank = grow(2, &wood);
    // f32 gives z to 2e-6 mm, so the difference to 3e-4. The third derivative of the fine roughness is at most that of
    // the quintic, 60, times a step of 2 sqrt 3 between unit lattice values, normalised: 100 mm^-2 at 12 um.
    let h = 0.008_f32;
    let bound = 3.0e-4 + h * h / 6.0 * 100.0;
    let height = |x: f32, y: f32| plank.slice(y).surface(x).expect("inside").z;
    for i in 0..4000 {
        let (x, y) = (-44.0 + (i as f32 * 0.618_034).fract() * 88.0, 24.0 + i as f32 * 0.05);
        let s = plank.slice(y).surface(x).expect("inside");
        let slope_x = (height(x + h, y) - height(x - h, y)) / (2.0 * h);
        let slope_y = (height(x, y + h) - height(x, y - h)) / (2.0 * h);
        assert!((slope_x - s.slope_x).abs() < bound, "x at {x}, {y}: {slope_x} against {}", s.slope_x);
        assert!((slope_y - s.slope_y).abs() < bound, "y at {x}, {y}: {slope_y} against {}", s.slope_y);
    }
}

#[test]
fn ripple_and_roughness_have_the_asked_size() {
    let mut wood = wood(0.0, 0.0);
    wood.board.length_mm = 6000.0;
    wood.board.cup_mm = 0.0;
    wood.board.twist_deg = 0.0;
    let mut rms = |ripple: f64, roughness: f64| {
        wood.board.saw_ripple_um = ripple;
        wood.board.roughness_um = roughness;
        let plank = grow(1, &wood);
        let n = 200_000_u32;
        let (mut heights, mut slopes) = (0.0, 0.0);
        for i in 0..n {
            let (x, y) = (-46.0 + (i as f32 * 0.618_034).fract() * 92.0, 20.0 + i as f32 * 0.03);
            let s = plank.slice(y).surface(x).expect("inside");
            heights += f64::from(s.z - 22.0).powi(2);
            slopes += f64::from(s.slope_x).powi(2) + f64::from(s.slope_y).powi(2);
        }
        (1.0e3 * (heights / f64::from(n)).sqrt(), (slopes / f64::from(n)).sqrt())
    };
    // The amplitude drifts by 1/4 over 200 cells: its square has a standard error of 0.5/sqrt(200), the rms half of it.
    let (ripple, _) = rms(30.0, 0.0);
    assert!((ripple / 30.0 - 1.0).abs() < 3.3 * 0.018, "ripple {ripple} um");
    // Samples 0.03 mm apart in y land at scattered x: 200 000 values, the coarse cells shared by a few: 1 percent.
    let (roughness, slope) = rms(0.0, 12.0);
    assert!((roughness / 12.0 - 1.0).abs() < 3.3 * 0.01, "roughness {roughness} um");
    assert!(slope < 0.09, "slope of the roughness {slope}");
}

#[test]
fn the_board_ends_where_it_was_asked() {
    let mut wood = wood(0.0, 0.0);
    wood.board.offset_mm = 7.0;
    let plank = grow(0, &wood);
    for (x, y, inside) in
        [(-39.9, 100.0, true), (-40.1, 100.0, false), (53.9, 100.0, true), (54.1, 100.0, false), (0.0, 19.9, false)]
    {
        assert_eq!(plank.slice(y).surface(x).is_some(), inside, "at {x}, {y}");
    }
    assert!(plank.slice(229.9).surface(0.0).is_some() && plank.slice(230.1).surface(0.0).is_none());
}

#[test]
fn the_hull_is_closed_and_follows_the_surface() {
    let mut wood = rich();
    wood.board.cup_mm = 2.0;
    wood.board.twist_deg = 2.0;
    let plank = grow(3, &wood);
    let hull = plank.hull();
    let mut edges = std::collections::BTreeMap::new();
    let mut volume = 0.0_f64;
    for t in &hull.triangles {
        for side in 0..3 {
            *edges.entry((t[side], t[(side + 1) % 3])).or_insert(0) += 1;
        }
        let [a, b, c] = t.map(|i| hull.positions[i as usize].as_dvec3());
        volume += a.dot(b.cross(c)) / 6.0;
    }
    assert!(edges.iter().all(|(&(a, b), &n)| n == 1 && edges.get(&(b, a)) == Some(&1)), "each edge has two sides");
    assert!((volume / (94.0 * 210.0 * 22.0) - 1.0).abs() < 5.0e-3, "volume {volume} mm3");
    for p in hull.positions.iter().filter(|p| p.z > 1.0) {
        if let Some(surface) = plank.slice(p.y).surface(p.x) {
            assert!((surface.z - p.z).abs() < 0.2, "hull at {p}, surface at {}", surface.z);
        }
    }
}

#[test]
fn rot_is_the_class_table_at_half_severity() {
    let mut wood = wood(0.0, 0.0);
    (wood.rot.reach_mm, wood.rot.mottle) = (40.0, 0.0);
    let plank = grow(1, &wood);
    let mut seen = 0;
    for (x, _, matter) in face(&plank, 1.0) {
        if x > 47.0 - 20.0 {
            let m = matter.medium;
            assert_eq!((matter.class, matter.instance), (Class::Rot, 1));
            for (value, asked) in [
                (m.mu_a, wood.media.rot_mu_a_ratio * wood.media.earlywood_mu_a_per_mm),
                (m.sigma_i, wood.media.rot_sigma_i_ratio * wood.media.earlywood_sigma_i_per_mm),
                (m.k, wood.media.rot_k_ratio * wood.media.earlywood_k_per_mm),
                (m.n_eff, wood.media.rot_n_eff),
            ] {
                assert!((f64::from(value) / asked - 1.0).abs() < 1.0e-6, "{value} against {asked}");
            }
            seen += 1;
        } else if x < -10.0 {
            assert_eq!(matter.class, Class::Clear);
        }
    }
    assert!(seen > 4000);
    let share = face(&plank, 0.5).iter().filter(|(_, _, m)| m.class == Class::Rot).count() as f64 / (188.0 * 420.0);
    // The front wanders by 3 mm over about 2 cells of 96 mm: the mean reach is good to 3.3 * 3/sqrt 2 mm.
    assert!((share * 94.0 - 40.0).abs() < 7.0, "rot reaches {} mm", share * 94.0);
}

#[test]
fn rot_comes_from_the_asked_edge_or_not_at_all() {
    let none = grow(1, &wood(0.0, 0.0));
    assert!(none.instances().is_empty());
    assert!(face(&none, 0.7).iter().all(|(_, _, m)| m.class == Class::Clear && m.instance == 0));
    let mut wood = wood(1.0, 1.0);
    wood.rot.reach_mm = 20.0;
    for edge in [-1.0, 1.0] {
        wood.rot.edge = edge;
        let plank = grow(1, &wood);
        let last = plank.instances().last().expect("rot is an instance");
        assert_eq!((last.id, last.class, last.x_mm.signum()), (3, Class::Rot, edge));
        let face = face(&plank, 0.7);
        assert!(face.iter().any(|(_, _, m)| m.class == Class::Rot && m.instance == 3));
        assert!(face.iter().all(|&(x, _, m)| m.class != Class::Rot || f64::from(x) * edge > 0.0));
    }
}

#[test]
fn rot_of_an_edge_ends_where_its_length_does() {
    let mut wood = wood(0.0, 0.0);
    wood.rot.reach_mm = 20.0;
    wood.rot.front_mm = 0.0;
    for (seed, length) in [(1, 60.0), (2, 120.0), (3, 30.0)] {
        wood.rot.edge_length_mm = length;
        let plank = grow(seed, &wood);
        let area = face(&plank, 0.5).iter().filter(|(_, _, m)| m.class == Class::Rot).count() as f64 * 0.25;
        // Half an ellipse, of which the board's end may take one half.
        let whole = std::f64::consts::PI * 20.0 * length / 4.0;
        assert!((0.45 * whole..1.05 * whole).contains(&area), "{area} of {whole} mm2 for {length} mm");
    }
}
