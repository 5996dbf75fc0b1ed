//! Anything that the ranges of the recipe allow gives a sane board.

use crate::boards::grow;
use base::{BodyKind, Class, Slice, Stream};
use procedural::wood::Wood;
use procedural::wood::{Plank, Stem};
use rand::RngExt;

/// Boards whose parameters are drawn evenly over their whole ranges.
const BOARDS: u64 = 90;

/// How many instances of each class a board has.
fn asked(wood: &Wood) -> [(Class, f64); 22] {
    let Wood { knots, rot, inclusions, cracks, marks, .. } = wood;
    let one = |there: bool| f64::from(u8::from(there));
    let fronts = one(rot.reach_mm > 0.0) + one(rot.heart_mm > 0.0) + rot.pocket_count;
    let rotten = one(rot.severity > 0.0);
    [
        (Class::SoundKnot, knots.sound_count),
        (Class::DeadKnot, knots.dead_count),
        (Class::KnotHole, knots.hole_count),
        (Class::LooseKnot, knots.loose_count),
        (Class::Rot, rotten * fronts),
        (Class::IncipientDecay, rotten * one(fronts > 0.0 && rot.incipient_mm > 0.0)),
        (Class::CompressionWood, one(wood.compression.severity > 0.0)),
        (Class::BlueStain, one(wood.stain.severity > 0.0) * wood.stain.wedge_count),
        (Class::Pith, one(wood.log.pith_mm > 0.0)),
        (Class::ResinPocket, inclusions.resin_pocket_count),
        (Class::ResinStreak, inclusions.resin_streak_count),
        (Class::BarkPocket, inclusions.bark_pocket_count),
        (Class::Check, cracks.check_count),
        (Class::Shake, cracks.shake_count),
        (Class::Split, cracks.split_count),
        (Class::InsectHole, wood.holes.count),
        (Class::Wane, one(wood.wane.width_mm > 0.0)),
        (Class::RollerMark, one(marks.roller_um > 0.0)),
        (Class::PlanerSkip, marks.skip_count),
        (Class::Dirt, marks.dirt_count),
        (Class::Burn, marks.burn_count),
        (Class::Clear, 0.0),
    ]
}

/// The same without what needs a grid over the whole face, which takes most of the time on the largest boards.
fn without_fine_structure(mut wood: Wood) -> Wood {
    (wood.grain.torn_um, wood.grain.fuzzy_um, wood.rot.loss_mm) = (0.0, 0.0, 0.0);
    let anatomy = &mut wood.anatomy;
    (anatomy.canals_per_mm2, anatomy.pores_per_mm2, anatomy.ray_share) = (0.0, 0.0, 0.0);
    wood
}

#[test]
#[ignore = "long"]
fn every_draw_gives_finite_matter_and_a_fitting_label() {
    for seed in 0..BOARDS {
        let mut rng = Stream::root(seed).child("extremes").rng();
        // A third at each end, a third between: corners of the box are where things break.
        let wood = Wood::from_values(&mut |p| match rng.random_range(0..3) {
            0 => p.min,
            1 => p.max,
            _ if p.integer => (p.min + (p.max - p.min) * rng.random::<f64>()).round(),
            _ => p.min + (p.max - p.min) * rng.random::<f64>(),
        });
        let wood = if seed % 3 == 0 { wood } else { without_fine_structure(wood) };
        let plank = grow(seed, &wood);
        for (class, count) in asked(&wood) {
            let there = plank.instances().iter().filter(|instance| instance.class == class).count();
            assert_eq!(there, count as usize, "{class:?} of seed {seed}");
        }
        let (low, high) = plank.bounds();
        assert!(low.is_finite() && high.is_finite() && low.cmplt(high).all());
        assert!(plank.hull().positions.iter().all(|p| p.is_finite()));
        for _ in 0..200 {
            let share: [f32; 3] = std::array::from_fn(|_| rng.random());
            let (x, y) = (low.x + share[0] * (high.x - low.x), low.y + share[1] * (high.y - low.y));
            let slice = plank.cut(y);
            let Some(surface) = slice.surface(x) else { continue };
            assert!(
                (surface.z + surface.slope_x + surface.slope_y).is_finite(),
                "seed {seed}: {surface:?} in {wood:?}"
            );
            let matter = slice.matter(x, surface.z * share[2]);
            let m = matter.medium;
            let sane = m.mu_a > 0.0
                && m.sigma_i > 0.0
                && m.k >= 0.0
                && (3.0..=14.0).contains(&m.dispersion_deg)
                && (1.0..=1.6).contains(&m.n_eff)
                && m.gloss.share >= 0.0;
            assert!(sane && (m.mu_a + m.sigma_i + m.k + m.n_eff).is_finite(), "seed {seed}: {matter:?} in {wood:?}");
            assert!((m.fibre.length() - 1.0).abs() < 1.0e-4, "seed {seed}: {matter:?} in {wood:?}");
            let instance = plank.instances().iter().find(|i| i.id == matter.instance);
            assert_eq!(instance.map_or(Class::Clear, |i| i.class), matter.class, "seed {seed}");
        }
    }
}

#[test]
#[ignore = "long"]
fn every_draw_of_a_stem_gives_finite_matter_and_a_fitting_label() {
    for seed in 0..BOARDS {
        let mut rng = Stream::root(seed).child("stem extremes").rng();
        let wood = Wood::from_values(&mut |p| {
            // Boards of 10 m in stems of 20 m only take long.
            let max = if p.name == "length_mm" { p.max.min(3000.0) } else { p.max };
            match rng.random_range(0..3) {
                0 => p.min,
                1 => max,
                _ if p.integer => (p.min + (max - p.min) * rng.random::<f64>()).round(),
                _ => p.min + (max - p.min) * rng.random::<f64>(),
            }
        });
        let wood = if seed % 3 == 0 { wood } else { without_fine_structure(wood) };
        let stem = Stem::grow(Stream::root(seed).child("stem"), &wood.stem);
        let [from, to] = stem.ends_mm();
        for i in 0..60 {
            let r = stem.radius_mm(0.1 * f64::from(i), from + (to - from) * f64::from(i) / 59.0);
            assert!(r.is_finite() && r > 0.0, "seed {seed}: outline {r}");
        }
        for branch in stem.branches() {
            for r in [1.0, 30.0, 200.0] {
                let sane = branch.width_mm(r) > 0.0 && branch.width_mm(r) <= r && branch.height_at(r).is_finite();
                assert!(sane, "seed {seed}: {branch:?} at {r}");
            }
            assert!(
                branch.end_mm > 0.0 && branch.death_mm > 0.0 && branch.end_mm >= branch.death_mm.min(branch.end_mm)
            );
        }
        let plank = Plank::saw(Stream::root(seed), &wood, &stem);
        let (low, high) = plank.bounds();
        for _ in 0..200 {
            let share: [f32; 3] = std::array::from_fn(|_| rng.random());
            let (x, y) = (low.x + share[0] * (high.x - low.x), low.y + share[1] * (high.y - low.y));
            let slice = plank.cut(y);
            let Some(surface) = slice.surface(x) else { continue };
            let matter = slice.matter(x, surface.z * share[2]);
            let m = matter.medium;
            let sum = m.mu_a + m.sigma_i + m.k + m.n_eff + m.dispersion_deg;
            assert!(m.mu_a > 0.0 && sum.is_finite(), "seed {seed}: {matter:?} in {wood:?}");
            assert!((m.fibre.length() - 1.0).abs() < 1.0e-4, "seed {seed}: {matter:?} in {wood:?}");
            let instance = plank.instances().iter().find(|i| i.id == matter.instance);
            assert_eq!(instance.map_or(Class::Clear, |i| i.class), matter.class, "seed {seed}");
            assert!(slice.below_outline_mm(x, surface.z).is_some_and(f32::is_finite), "seed {seed}");
        }
    }
}

/// Nothing of the upper face stands out of the box of the board.
#[test]
#[ignore = "long"]
fn every_face_lies_within_its_bounds() {
    let mut torn = 0.0_f32;
    for seed in 0..40 {
        let mut rng = Stream::root(seed).child("bounds").rng();
        let mut draw = |low: f64, high: f64| low + (high - low) * rng.random::<f64>();
        let mut wood = crate::boards::wood(2.0, 1.0);
        (wood.board.width_mm, wood.board.length_mm) = (draw(20.0, 120.0), draw(40.0, 120.0));
        wood.board.edge_wander_mm = draw(0.0, 1.0) * wood.board.width_mm / 24.0;
        (wood.board.cup_mm, wood.board.twist_deg) = (draw(-3.0, 3.0), draw(-1.0, 1.0));
        (wood.board.saw_ripple_um, wood.board.roughness_um) = (draw(0.0, 100.0), draw(0.0, 30.0));
        // On every other board torn grain is all that there is.
        if seed.is_multiple_of(2) {
            (wood.board.cup_mm, wood.board.twist_deg) = (0.0, 0.0);
            (wood.board.saw_ripple_um, wood.board.roughness_um) = (0.0, 0.0);
        }
        wood.machining.planer_um = draw(0.0, 10.0);
        (wood.grain.torn_um, wood.grain.fuzzy_um) = (draw(50.0, 300.0), draw(0.0, 30.0));
        (wood.grain.torn_dive_deg, wood.log.pith_tilt_deg) = (1.0, 4.0);
        (wood.anatomy.pores_per_mm2, wood.rot.reach_mm, wood.rot.loss_mm) = (1.0, 10.0, draw(0.0, 2.0));
        (wood.knots.hole_count, wood.wane.width_mm, wood.marks.chip_count) = (1.0, 5.0, 2.0);
        let plank = grow(seed, &wood);
        let (low, high) = plank.bounds();
        for j in 0..300 {
            let slice = plank.cut(low.y + (high.y - low.y) * (j as f32 + 0.5) / 300.0);
            for i in 0..300 {
                let x = low.x + (high.x - low.x) * (i as f32 + 0.5) / 300.0;
                let Some(face) = slice.surface(x) else { continue };
                assert!(low.z < face.z && face.z < high.z, "seed {seed}: {} mm of {} to {} mm", face.z, low.z, high.z);
                if seed.is_multiple_of(2) {
                    torn = torn.max((face.z - 22.0) / (1.0e-3 * wood.grain.torn_um as f32));
                }
            }
        }
    }
    assert!(torn > 1.5, "torn grain rises by {torn} of what is asked");
}
