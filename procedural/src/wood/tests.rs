//! Tests of the parts together that need to see inside a board.

use super::*;

fn board(sound: f64, dead: f64, seed: u64) -> Plank {
    let mut wood = Wood::from_values(&mut |p| p.default);
    wood.knots.sound_count = sound;
    wood.knots.dead_count = dead;
    Plank::grow(Stream::root(seed), &wood)
}

/// Places all over a board and through its thickness [mm].
fn places(count: u32) -> impl Iterator<Item = Vec3> {
    // The plastic number's powers fill the cube evenly (Roberts 2018).
    let turn = |i: u32, by: f32| (0.5 + i as f32 * by).fract();
    (0..count).map(move |i| {
        Vec3::new(-46.0 + 92.0 * turn(i, 0.819_172_5), 21.0 + 208.0 * turn(i, 0.671_043_6), 22.0 * turn(i, 0.549_700_5))
    })
}

fn grown<'a>(plank: &'a Plank, p: Vec3) -> Grown<'a> {
    let place = plank.trunk.place(p.x, p.y, p.z);
    plank.growth.at(&place, plank.knots.iter().map(|placed| &placed.knot))
}

#[test]
fn the_gradient_is_that_of_the_time_of_growth() {
    let h = 0.02;
    let mut checked = 0;
    for seed in 0..6 {
        let plank = board(2.0, 2.0, seed);
        for p in places(3000) {
            let here = grown(&plank, p);
            let numeric = Vec3::from_array(
                [Vec3::X, Vec3::Y, Vec3::Z]
                    .map(|axis| (grown(&plank, p + h * axis).t - grown(&plank, p - h * axis).t) / (2.0 * h)),
            );
            let analytic = plank.trunk.vector(here.gradient.truncate(), here.gradient.z);
            // Where a branch dies the gradient itself jumps, and in a branch a little where its outline's wobble ends.
            let r = plank.trunk.place(p.x, p.y, p.z).r;
            let is_in_branch = here.branch.is_some_and(|branch| (0.6..1.0).contains(&branch.x));
            if is_in_branch || plank.knots.iter().any(|placed| (placed.knot.death - r).abs() < 0.1) {
                continue;
            }
            // f32 gives t to 4e-6, so its difference to 2e-4; the table of the bulge and the pith's steps add the rest.
            assert!(numeric.distance(analytic) < 0.02, "at {p}: {numeric} against {analytic}");
            checked += 1;
        }
    }
    assert!(checked > 15_000);
}

#[test]
fn fibres_are_unit_vectors_and_lie_in_the_growth_surface() {
    let mut outside = 0;
    for seed in 0..6 {
        let plank = board(2.0, 2.0, seed);
        for p in places(3000) {
            let here = grown(&plank, p);
            assert!((here.fibre.length() - 1.0).abs() < 1.0e-5);
            if here.branch.is_none_or(|branch| branch.x > 1.0) {
                assert!(here.fibre.dot(here.gradient.normalize()).abs() < 1.0e-5, "at {p}");
                outside += 1;
            }
        }
    }
    assert!(outside > 15_000);
}

/// Beside a knot's outline the dive is largest and falls steadily along the grain, outwards below the branch and
/// inwards above; there is no point around a knot from which fibres fan out or at which they turn at once.
#[test]
fn fibres_dive_most_at_a_living_branch_and_turn_nowhere_at_once() {
    let mut wood = Wood::from_values(&mut |p| p.default);
    (wood.knots.sound_count, wood.knots.bulge_log_sd, wood.knots.lean_sd_deg) = (1.0, 0.0, 0.0);
    wood.log.spiral_deg = 0.0;
    wood.log.spiral_slope_deg_per_mm = 0.0;
    for seed in 0..40 {
        let plank = Plank::grow(Stream::root(seed), &wood);
        let knot = &plank.instances()[0];
        let middle = plank.trunk.place(knot.x_mm as f32, knot.y_mm as f32, 20.0);
        let section = plank.knots[0].knot.section(&knot::KnotDistance::new(middle.r));
        let half = section.half_width;
        // The fibre `x` half widths up the stem from the axis and `aside` around it, where it is the stem's.
        let fibre = |x: f32, aside: f32| {
            let p = plank.trunk.point(middle.r, section.phi + aside * half / middle.r, section.l + x * half);
            let grown = grown(&plank, p);
            let outwards = grown.fibre.truncate().dot(plank.trunk.place(p.x, p.y, p.z).outward);
            grown.branch.is_none_or(|branch| branch.x > 1.02).then_some((grown.fibre, outwards))
        };
        for side in [-1.0, 1.0] {
            let dives: Vec<f32> = (0..40)
                .filter_map(|i| fibre(side * (1.05 + 0.1 * i as f32), 0.0))
                .map(|(_, out)| -side * out)
                .collect();
            assert!(dives[0] > 0.25 && dives[0] < 0.45, "seed {seed}: {dives:?} at the outline");
            assert!(dives.windows(2).all(|w| w[1] < w[0] + 0.01), "seed {seed}, side {side}: {dives:?}");
        }
        for aside in [-1.25, 1.25] {
            let (_, out) = fibre(0.0, aside).expect("it lies beside the branch");
            assert!(out.abs() < 0.15, "seed {seed}: {out} beside");
        }
        let mut steepest = 0.0f32;
        for i in -80..80 {
            for j in -40..40 {
                let (x, aside) = (0.05 * i as f32, 0.05 * j as f32);
                let Some((here, _)) = fibre(x, aside).filter(|_| x.hypot(aside) > 1.02) else { continue };
                for other in [fibre(x + 0.05, aside), fibre(x, aside + 0.05)].into_iter().flatten() {
                    steepest = steepest.max(here.angle_between(other.0).to_degrees());
                }
            }
        }
        assert!(steepest < 4.0, "seed {seed}: fibres turn by {steepest} deg within a twentieth of a half width");
    }
}

/// Slopes along the grain of the layers two half widths up and down the stem from a knot's axis, of many boards.
fn slopes_at_knots(bulge_log_sd: f64, lean_sd_deg: f64) -> Vec<[f64; 2]> {
    let mut wood = Wood::from_values(&mut |p| p.default);
    (wood.knots.sound_count, wood.knots.bulge_log_sd, wood.knots.lean_sd_deg) = (1.0, bulge_log_sd, lean_sd_deg);
    let slopes = (0..150).map(|seed| {
        let plank = Plank::grow(Stream::root(seed), &wood);
        let knot = &plank.instances()[0];
        let middle = plank.trunk.place(knot.x_mm as f32, knot.y_mm as f32, 20.0);
        let section = plank.knots[0].knot.section(&knot::KnotDistance::new(middle.r));
        [2.0, -2.0].map(|x| {
            let p = plank.trunk.point(middle.r, section.phi, section.l + x * section.half_width);
            let slope = grown(&plank, p).gradient;
            f64::from(-slope.z / slope.truncate().length())
        })
    });
    slopes.collect()
}

#[test]
fn knots_bulge_and_lean_as_they_are_asked_to() {
    let spread = |values: Vec<f64>| {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt()
    };
    let steep = |slopes: &[[f64; 2]]| slopes.iter().map(|[up, down]| (down - up).abs().ln()).collect::<Vec<_>>();
    let lean = |slopes: &[[f64; 2]]| slopes.iter().map(|[up, down]| 0.5 * (up + down)).collect::<Vec<_>>();
    let [still, bulging, leaning] = [(0.0, 0.0), (0.6, 0.0), (0.0, 8.0)].map(|(b, l)| slopes_at_knots(b, l));
    let (by_still, by_bulging) = (spread(steep(&still)), spread(steep(&bulging)));
    // Branches taper and lean differently even where all bulges are alike.
    assert!(by_still < 0.25 && (0.5..0.8).contains(&by_bulging), "{by_still}, {by_bulging}");
    // Both sides lean alike, by 0.4 tan 8 deg = 0.056.
    let (by_still, by_leaning) = (spread(lean(&still)), spread(lean(&leaning)));
    assert!((0.035..0.1).contains(&by_leaning) && by_leaning > 1.3 * by_still, "{by_still}, {by_leaning}");
}

/// Both sides of a pith in the face have the same fibres at it, and leave each other slowly.
#[test]
fn spiral_grain_begins_at_none() {
    let mut wood = Wood::from_values(&mut |p| p.default);
    (wood.log.pith_depth_mm, wood.log.pith_offset_mm, wood.log.pith_wander_mm) = (0.0, 0.0, 0.0);
    (wood.log.pith_tilt_deg, wood.log.spiral_deg, wood.log.spiral_slope_deg_per_mm) = (0.0, 5.0, 0.0);
    let plank = Plank::grow(Stream::root(1), &wood);
    let apart = |x: f32| {
        let [left, right] = [-x, x].map(|x| grown(&plank, Vec3::new(x, 100.0, 22.0)).fibre);
        left.angle_between(right).to_degrees()
    };
    // Twice the spiral of 5 deg far out, half of that 5 mm from the pith.
    assert!(apart(0.5) < 0.5 && (apart(5.0) - 5.0).abs() < 1.0 && (apart(40.0) - 10.0).abs() < 1.0);
}

#[test]
fn far_from_knots_rings_are_cylinders_around_the_pith() {
    let plank = board(0.0, 0.0, 3);
    let n = 4000;
    let squares: f64 = places(n)
        .map(|p| {
            let r = plank.trunk.place(p.x, p.y, p.z).r;
            f64::from(grown(&plank, p).t / r - 1.0).powi(2)
        })
        .sum();
    // The waviness has a root mean square of 0.005, and the board shows few of its cells: a factor of 2 either way.
    let rms = (squares / f64::from(n)).sqrt();
    assert!((0.0025..0.01).contains(&rms), "waviness {rms}");
}

#[test]
fn clear_wood_shows_the_ring_that_its_time_of_growth_names() {
    let mut wood = Wood::from_values(&mut |p| p.default);
    wood.log.streak = 0.0;
    let plank = Plank::grow(Stream::root(4), &wood);
    let (early, late) = (plank.kinds.earlywood, plank.kinds.latewood);
    for p in places(2000) {
        let slice = plank.cut(p.y);
        let medium = slice.matter(p.x, p.z).medium;
        let t = grown(&plank, Vec3::new(p.x, p.y, p.z - slice.cut.warp(p.x).z)).t;
        let phase = plank.rings.at(t);
        let expected = phase.gain * (early.mu_a + phase.latewood * (late.mu_a - early.mu_a));
        assert!((medium.mu_a - expected).abs() < 1.0e-6);
        assert!((medium.k - (early.k + phase.latewood * (late.k - early.k))).abs() < 1.0e-4);
    }
}

#[test]
fn a_knot_outside_its_room_changes_nothing() {
    // The rooms are only a shortcut: the slice must agree with asking every knot everywhere.
    for seed in 0..8 {
        let mut wood = Wood::from_values(&mut |p| p.default);
        wood.knots.sound_count = 3.0;
        wood.knots.dead_count = 3.0;
        wood.log.grain_angle_deg = 15.0 * seed as f64;
        wood.knots.slope_deg = -5.0 * seed as f64;
        let plank = Plank::grow(Stream::root(seed), &wood);
        for p in places(2000) {
            let slice = plank.cut(p.y);
            let z = p.z + slice.cut.warp(p.x).z;
            let all = grown(&plank, p).fibre;
            let fibre = plank.trunk.vector(all.truncate(), all.z);
            assert!(slice.matter(p.x, z).medium.fibre.distance(fibre) < 1.0e-3, "seed {seed} at {p}");
        }
    }
}

#[test]
fn streaks_have_the_asked_size_and_follow_the_fibre() {
    let mut wood = Wood::from_values(&mut |p| p.default);
    wood.media.latewood_k_ratio = 1.0;
    let plank = Plank::grow(Stream::root(6), &wood);
    let departure = |x: f32, y: f32| {
        let k = plank.cut(y).matter(x, 20.0).medium.k / wood.media.earlywood_k_per_mm as f32;
        f64::from(k - 1.0) / f64::from(STREAK_SCATTERING)
    };
    let (mut square, mut along, mut across) = (0.0, 0.0, 0.0);
    let n = 20_000;
    for p in places(n) {
        let here = departure(p.x, p.y);
        square += here * here;
        along += here * departure(p.x, p.y + 1.0);
        across += here * departure(p.x + 1.0, p.y);
    }
    // 20 000 points share the coarse cells, 0.6 by 18 mm, about twenty to one: 1000 independent ones, 3 percent.
    let rms = (square / f64::from(n)).sqrt();
    assert!((rms / wood.log.streak - 1.0).abs() < 3.3 * 0.03, "streaks of {rms}");
    assert!(along / square > 0.7 && across / square < 0.15, "a millimetre along {along}, across {across}, of {square}");
}

/// Wood of a stem's oval layers has rings out to the bark: the table reaches every layer of the board.
#[test]
fn rings_reach_every_layer_of_the_board() {
    let mut farthest = 0.0_f32;
    for seed in 0..12 {
        let mut wood = Wood::from_values(&mut |p| p.default);
        (wood.board.width_mm, wood.board.length_mm) = (40.0, 40.0);
        (wood.stem.rings_follow_outline, wood.stem.eccentricity, wood.stem.board_radius_mm) = (1.0, 0.3, 80.0);
        wood.stem.board_azimuth_deg = 30.0 * seed as f64;
        let stem = Stem::grow(Stream::root(seed).child("stem"), &wood.stem);
        let plank = Plank::saw(Stream::root(seed), &wood, &stem);
        let (low, high) = plank.bounds();
        for i in 0..=10 {
            for j in 0..=10 {
                let share = Vec3::new(i as f32, j as f32, 10.0) / 10.0;
                let p = (low + share * (high - low)).with_z(22.0);
                let place = plank.trunk.place(p.x, p.y, p.z);
                let t = grown(&plank, p).t;
                assert!(t < plank.rings.end(), "seed {seed}: layer {t} of rings out to {}", plank.rings.end());
                farthest = farthest.max(t - place.r);
            }
        }
    }
    assert!(farthest > 2.0 * RING_MARGIN_MM, "layers lie {farthest} mm farther out than their places");
}

/// The grid over the face has the bundles of the wood itself, all around a pith inside the board.
#[test]
fn the_grid_of_the_face_has_the_bundles_of_the_wood_about_a_pith() {
    for seed in 0..6 {
        let mut wood = Wood::from_values(&mut |p| p.default);
        (wood.log.pith_depth_mm, wood.log.pith_offset_mm, wood.log.pith_wander_mm) = (5.0, 0.0, 0.5);
        wood.grain.torn_um = 20.0;
        let plank = Plank::grow(Stream::root(seed), &wood);
        let (grains, _) = &**plank.grain.as_ref().expect("torn grain has a grid");
        let mut above = 0;
        for i in 0..4000 {
            let spot = Vec2::new(-12.0 + 0.006 * i as f32, 22.0 + 0.05 * i as f32);
            let p = spot.extend(22.0);
            let place = plank.trunk.place(p.x, p.y, p.z);
            let (here, by) = grains.at(spot);
            let turn = plank.growth.bundles_around(place.r);
            let off = here.bundle - grown(&plank, p).bundle;
            let off = off - (off / turn).round() * turn;
            // Between nodes the arc bends away from its chord by step^2 / 8 r.
            assert!(off.abs() < 0.15, "seed {seed} at {spot}: {off} mm");
            // A bundle is r phi: its slope is 1 along the arc and phi outwards.
            assert!(by.iter().all(|slope| slope.bundle.abs() < 4.5), "seed {seed} at {spot}: {by:?}");
            above += u32::from(place.phi.abs() > 3.0);
        }
        assert!(above > 20, "seed {seed}: {above} places opposite of the board's middle");
    }
}

/// Columns together see what each sees by itself, to the bit, on boards of all kinds.
#[test]
fn blocks_are_their_places() {
    let mut on_board = 0;
    for seed in 0..6_u64 {
        let mut wood = Wood::from_values(&mut |p| p.default);
        wood.knots.sound_count = (seed % 3) as f64;
        wood.log.streak = 0.1;
        wood.board.roughness_um = 20.0;
        if seed >= 3 {
            (wood.grain.torn_um, wood.machining.planer_um) = (60.0, 5.0);
            (wood.holes.count, wood.moisture.patch_count) = (50.0, 4.0);
        }
        let plank = Plank::grow(Stream::root(seed), &wood);
        for row in 0..40 {
            let slice = plank.cut(15.0 + 5.7 * row as f32);
            let x: [f32; BLOCK] = std::array::from_fn(|n| -60.0 + 3.1 * row as f32 + 0.37 * n as f32);
            let together = slice.surfaces(&x);
            let places = std::array::from_fn(|n| Some(Vec2::new(x[n], together[n]?.z)));
            let mut matters = [None; BLOCK];
            slice.matters(&places, &mut |n, matter| matters[n] = Some(matter));
            for n in 0..BLOCK {
                assert_eq!(together[n], slice.surface(x[n]), "surface, board {seed}, row {row}");
                let alone = places[n].map(|place| slice.matter(place.x, place.y));
                assert_eq!(matters[n], alone, "matter, board {seed}, row {row}");
                on_board += usize::from(alone.is_some());
            }
        }
    }
    assert!(on_board > 1000, "{on_board} places");
}
