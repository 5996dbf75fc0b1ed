//! Knots as a scan of the upper face sees them: all there, in their size and class, with fibres that dive.

use base::{BodyKind, Class};

use crate::boards::{dive_deg, face, grow, is_knot, wood};

#[test]
fn every_knot_shows_with_its_class_and_number() {
    for seed in 0..12 {
        let plank = grow(seed, &wood(2.0, 2.0));
        let face = face(&plank, 0.4);
        assert_eq!(plank.instances().len(), 4);
        for (index, instance) in plank.instances().iter().enumerate() {
            assert_eq!(usize::from(instance.id), index + 1);
            assert_eq!(instance.class, if index < 2 { Class::SoundKnot } else { Class::DeadKnot });
            let seen = face.iter().filter(|(_, _, m)| m.instance == instance.id);
            assert!(seen.clone().all(|(_, _, m)| m.class == instance.class));
            assert!(seen.count() > 10, "seed {seed}: knot {} is not seen", instance.id);
        }
    }
}

#[test]
#[ignore = "long"]
fn the_visible_area_is_that_of_the_leaning_branch() {
    let step = 0.2_f32;
    for seed in 0..12 {
        let mut wood = wood(2.0, 2.0);
        wood.knots.width_log_sd = 0.2;
        let plank = grow(seed, &wood);
        let face = face(&plank, step);
        for instance in plank.instances() {
            let pixels = face.iter().filter(|(_, _, m)| m.instance == instance.id).count();
            let area = pixels as f64 * f64::from(step * step);
            let cut = 0.25 * std::f64::consts::PI * instance.diameter_mm.powi(2) / instance.dive_deg.to_radians().sin();
            // The outline wobbles by 3.5 percent, which costs little area; a widening branch adds some.
            assert!((0.85..1.2).contains(&(area / cut)), "seed {seed}, {instance:?}: {area} against {cut}");
        }
    }
}

#[test]
fn knots_stay_inside_the_board_and_apart() {
    for seed in 0..12 {
        let plank = grow(seed, &wood(2.0, 2.0));
        let (low, high) = plank.bounds();
        let knots = plank.instances();
        for (i, a) in knots.iter().enumerate() {
            let half = 0.5 * a.diameter_mm;
            assert!(a.x_mm - half > f64::from(low.x) && a.x_mm + half < f64::from(high.x), "seed {seed}: {a:?}");
            assert!(a.y_mm - half > f64::from(low.y) && a.y_mm + half < f64::from(high.y), "seed {seed}: {a:?}");
            for b in &knots[..i] {
                let apart = (a.x_mm - b.x_mm).hypot(a.y_mm - b.y_mm);
                assert!(apart > half + 0.5 * b.diameter_mm, "seed {seed}: {a:?} {b:?}");
            }
        }
    }
}

#[test]
fn edges_cut_knots_where_they_may() {
    let cut = |seed: u64| {
        let mut wood = wood(2.0, 2.0);
        wood.knots.cut_share = 1.0;
        let plank = grow(seed, &wood);
        let (low, high) = plank.bounds();
        let crosses =
            |at: f64, half: f64, [low, high]: [f32; 2]| at - half < f64::from(low) || at + half > f64::from(high);
        let is_cut = |k: &&base::Instance| {
            let half = 0.5 * k.diameter_mm;
            crosses(k.x_mm, half, [low.x, high.x]) || crosses(k.y_mm, half, [low.y, high.y])
        };
        plank.instances().iter().filter(is_cut).count()
    };
    // Middles are even over 94 mm x 210 mm; with a half width of 6 mm 0.18 of them lie that near an edge.
    let share = (0..100).map(cut).sum::<usize>() as f64 / 400.0;
    assert!((0.1..0.28).contains(&share), "{share} of the knots are cut");
}

#[test]
fn knots_that_have_cracked_are_called_so() {
    for (asked, named) in [(0.0, 0), (1.0, 4)] {
        let mut wood = wood(2.0, 2.0);
        wood.knots.crack_share = asked;
        let plank = grow(3, &wood);
        let called = |k: &&base::Instance| k.knot.is_some_and(|names| names.text().ends_with("crack"));
        assert_eq!(plank.instances().iter().filter(called).count(), named);
    }
}

#[test]
fn widths_are_lognormal() {
    let wood = wood(1.0, 0.0);
    let n = 1500_u64;
    let logs: Vec<f64> = (0..n).map(|seed| grow(seed, &wood).instances()[0].diameter_mm.ln()).collect();
    let mean = logs.iter().sum::<f64>() / n as f64;
    let sd = (logs.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n as f64).sqrt();
    // 2 tests, alpha 0.001 in all: 3.5 standard errors; widths above 42 mm (3.6 sd) are cut.
    let (asked_mean, asked_sd) = (wood.knots.width_mm.ln(), wood.knots.width_log_sd);
    assert!((mean - asked_mean).abs() < 3.5 * asked_sd / (n as f64).sqrt(), "mean {mean}");
    assert!((sd / asked_sd - 1.0).abs() < 3.5 / (2.0 * n as f64).sqrt(), "sd {sd}");
}

#[test]
fn fibres_dive_in_knots_and_lie_flat_elsewhere() {
    let mut wood = wood(2.0, 1.0);
    // Flat-sawn: the pith right below, so that branches come straight up.
    wood.log.pith_offset_mm = 0.0;
    wood.log.pith_depth_mm = 150.0;
    let (mut clear, mut flat, mut steepest) = (0, 0, 0.0_f32);
    for seed in 0..10 {
        let plank = grow(seed, &wood);
        let instances = plank.instances();
        let (mut inside, mut steep) = (0, 0);
        for (x, y, matter) in face(&plank, 0.5) {
            let (x, y) = (f64::from(x), f64::from(y));
            let near = |reach: f64| instances.iter().any(|k| (x - k.x_mm).hypot(y - k.y_mm) < reach * k.diameter_mm);
            if !near(3.0) {
                clear += 1;
                flat += i32::from(dive_deg(&matter) < 5.0);
                steepest = steepest.max(dive_deg(&matter));
            } else if is_knot(matter.class) && near(0.35) {
                inside += 1;
                steep += i32::from((60.0..=90.0).contains(&dive_deg(&matter)));
            }
        }
        // A branch of the steepest slopes (-10 deg, sd 8 deg) may lean a little further at the far edges.
        assert!(
            inside > 50 && f64::from(steep) > 0.9 * f64::from(inside),
            "seed {seed}: {steep} of {inside} are steep"
        );
    }
    // Tilt 0.6 deg, wander and waviness with about 1 deg each: 5 deg is three standard deviations.
    assert!(clear > 100_000 && f64::from(flat) > 0.98 * f64::from(clear), "{flat} of {clear} lie flat");
    assert!(steepest < 9.0, "clear wood dives by {steepest} deg");
}

#[test]
#[ignore = "long"]
fn only_a_dead_knot_has_a_bark_ring() {
    for seed in 0..10 {
        let wood = wood(1.0, 1.0);
        let plank = grow(seed, &wood);
        let face = face(&plank, 0.15);
        for knot in plank.instances() {
            let distance = |x: f32, y: f32| (f64::from(x) - knot.x_mm).hypot(f64::from(y) - knot.y_mm);
            let bark = wood.media.bark_mu_a_per_mm as f32;
            let seen = face.iter().filter(|(_, _, m)| m.instance == knot.id);
            let ring: Vec<f64> =
                seen.filter(|(_, _, m)| m.medium.mu_a == bark).map(|&(x, y, _)| distance(x, y)).collect();
            if knot.class == Class::SoundKnot {
                assert!(ring.is_empty());
                continue;
            }
            let nearest = ring.iter().copied().fold(f64::INFINITY, f64::min);
            assert!(nearest > 0.5 * (0.5 * knot.diameter_mm - wood.knots.bark_mm), "seed {seed}: bark at {nearest} mm");
            // A ring of the asked thickness around the wood, longer where the knot leans.
            let area = ring.len() as f64 * 0.15 * 0.15;
            let round = std::f64::consts::PI * wood.knots.bark_mm * (knot.diameter_mm - wood.knots.bark_mm);
            assert!((0.7..1.8).contains(&(area / round)), "seed {seed}: {area} against {round}");
        }
    }
}

#[test]
fn another_knot_leaves_the_earlier_ones_alone() {
    for seed in 0..10 {
        let (three, four) = (grow(seed, &wood(3.0, 0.0)), grow(seed, &wood(4.0, 0.0)));
        for (a, b) in three.instances().iter().zip(four.instances()) {
            assert_eq!((a.id, a.x_mm, a.y_mm, a.diameter_mm), (b.id, b.x_mm, b.y_mm, b.diameter_mm));
        }
    }
}

#[test]
fn the_fibre_at_a_knots_centre_is_the_axis_that_its_instance_tells() {
    for seed in 0..12 {
        let plank = grow(seed, &wood(2.0, 2.0));
        for knot in plank.instances() {
            let (x, y) = (knot.x_mm as f32, knot.y_mm as f32);
            let slice = plank.slice(y);
            let matter = slice.matter(x, slice.surface(x).expect("knots are on the board").z);
            assert_eq!((matter.instance, matter.class), (knot.id, knot.class));
            // Cup, twist and ripple move the surface by up to half a millimetre along the axis.
            assert!((f64::from(dive_deg(&matter)) - knot.dive_deg).abs() < 1.0, "seed {seed}: {knot:?}");
            assert_eq!(knot.death_radius_mm.is_nan(), knot.class == Class::SoundKnot);
        }
    }
}
