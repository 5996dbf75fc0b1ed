//! Tests of sawn boards that need to see inside of them.

use base::{BodyKind, Class, Relief, Slice};
use glam::{Vec2, Vec3};
use rand::RngExt;

use super::*;
use crate::wood::Wood;
use crate::wood::growth::Grown;
use crate::wood::knot::{Knot, KnotDistance};
use crate::wood::{BoardStreams, LogPoint, Plank};

/// How boards lie in their stems: anywhere between flat- and quarter-sawn, quarter-sawn, flat-sawn, and through the
/// pith.
const LIES: [&str; 4] = ["anywhere", "quarter", "flat", "through the pith"];

fn wood() -> Wood {
    Wood::from_values(&mut |p| p.default)
}

/// A board drawn at random, with its stem.
fn board(seed: u64) -> (Wood, Stem, Plank) {
    let stream = Stream::root(seed).child("sawn");
    let mut rng = stream.child("lies").rng();
    let mut draw = |from: f64, to: f64| from + (to - from) * rng.random::<f64>();
    let mut wood = wood();
    wood.board.width_mm = draw(40.0, 120.0);
    wood.stem.branch_width_mm *= draw(0.7, 2.0);
    wood.stem.board_along_mm = draw(0.0, 4000.0);
    wood.stem.board_azimuth_deg = draw(-180.0, 180.0);
    wood.stem.board_radius_mm = draw(10.0, 110.0);
    wood.stem.face_deg = draw(-180.0, 180.0);
    wood.log.grain_angle_deg = draw(-4.0, 4.0);
    // Every second stem has rings that follow a shape that is far from round.
    if seed % 8 >= 4 {
        (wood.stem.rings_follow_outline, wood.stem.oval) = (draw(0.1, 1.0), draw(1.0, 1.4));
        (wood.stem.eccentricity, wood.stem.lobes) = (draw(0.0, 0.3), draw(0.0, 0.04));
    }
    match LIES[seed as usize % 4] {
        "quarter" => wood.stem.face_deg = 90.0,
        "flat" => wood.stem.face_deg = 0.0,
        "through the pith" => {
            wood.stem.face_deg = 0.0;
            wood.stem.board_radius_mm = 0.5 * wood.board.thickness_mm;
        }
        _ => {}
    }
    let stem = Stem::grow(stream.child("stem"), &wood.stem);
    let plank = Plank::saw(stream.child("board"), &wood, &stem);
    (wood, stem, plank)
}

/// Places all over a board and through its thickness [mm].
fn places(plank: &Plank, count: u32) -> impl Iterator<Item = Vec3> {
    // The plastic number's powers fill the cube evenly (Roberts 2018).
    let turn = |i: u32, by: f32| (0.5 + i as f32 * by).fract();
    let (low, high) = plank.bounds();
    let size = (high - low).with_z(22.0);
    (0..count).map(move |i| low + size * Vec3::new(turn(i, 0.819_172_5), turn(i, 0.671_043_6), turn(i, 0.549_700_5)))
}

fn grown_at<'a>(plank: &'a Plank, place: &LogPoint) -> Grown<'a> {
    plank.growth.at(place, plank.knots.iter().map(|placed| &placed.knot))
}

fn grown(plank: &Plank, p: Vec3) -> Grown<'_> {
    grown_at(plank, &plank.trunk.place(p.x, p.y, p.z))
}

fn is_clear(grown: &Grown) -> bool {
    grown.branch.is_none_or(|branch| branch.x > 1.0)
}

#[test]
fn growth_rises_outwards_along_every_ray() {
    let mut looked = 0;
    for seed in 0..40 {
        let (_, _, plank) = board(seed);
        for p in places(&plank, 400) {
            let end = plank.trunk.place(p.x, p.y, p.z);
            let ray = |i: i32| {
                let r = 0.2 * i as f32;
                grown_at(&plank, &LogPoint { r, ..end })
            };
            let count = (end.r / 0.2) as i32;
            let mut before = ray(5);
            for i in 6..=count {
                let here = ray(i);
                if is_clear(&before) && is_clear(&here) {
                    assert!(here.t > before.t, "seed {seed}, {p}, r {}: {} after {}", 0.2 * i as f32, here.t, before.t);
                    looked += 1;
                }
                before = here;
            }
        }
    }
    assert!(looked > 2_000_000, "{looked}");
}

#[test]
fn fibres_are_unit_vectors_in_the_growth_surface() {
    let (h, mut outside) = (0.05, 0);
    for seed in 0..40 {
        let (_, _, plank) = board(seed);
        for p in places(&plank, 1500) {
            let here = grown(&plank, p);
            assert!((here.fibre.length() - 1.0).abs() < 1.0e-3, "seed {seed}, {p}: {}", here.fibre);
            if !is_clear(&here) {
                continue;
            }
            assert!(here.fibre.dot(here.gradient.normalize()).abs() < 1.0e-3, "seed {seed}, {p}");
            outside += 1;
            // The same from differences of the time of growth alone.
            let place = plank.trunk.place(p.x, p.y, p.z);
            let jumps = plank.knots.iter().any(|k| (k.knot.death - place.r).abs() < 0.2);
            if jumps || place.r < 3.0 {
                continue;
            }
            let fibre = plank.trunk.vector(here.fibre.truncate(), here.fibre.z);
            let slope = (grown(&plank, p + h * fibre).t - grown(&plank, p - h * fibre).t) / (2.0 * h);
            // As in the test of the gradient: the table of the bulge and the pith's steps.
            assert!(slope.abs() < 0.02, "seed {seed}, {p}: time rises by {slope} along the fibre");
        }
    }
    assert!(outside > 40_000, "{outside}");
}

#[test]
fn the_gradient_is_that_of_the_time_of_growth() {
    let h = 0.02;
    let mut looked = 0;
    for seed in 0..24 {
        let (_, _, plank) = board(seed);
        for p in places(&plank, 1000) {
            let here = grown(&plank, p);
            let r = plank.trunk.place(p.x, p.y, p.z).r;
            let jumps = plank.knots.iter().any(|placed| (placed.knot.death - r).abs() < 0.1);
            if !is_clear(&here) || jumps || r < 3.0 {
                continue;
            }
            let numeric = Vec3::from_array(
                [Vec3::X, Vec3::Y, Vec3::Z]
                    .map(|axis| (grown(&plank, p + h * axis).t - grown(&plank, p - h * axis).t) / (2.0 * h)),
            );
            let analytic = plank.trunk.vector(here.gradient.truncate(), here.gradient.z);
            // As for boards with placed knots.
            assert!(numeric.distance(analytic) < 0.02, "seed {seed}, {p}: {numeric} against {analytic}");
            looked += 1;
        }
    }
    assert!(looked > 15_000, "{looked}");
}

#[test]
fn the_rooms_of_knots_are_only_a_shortcut() {
    for seed in 0..24 {
        let (_, _, plank) = board(seed);
        for p in places(&plank, 1000) {
            let slice = plank.cut(p.y);
            let z = p.z + slice.cut.warp(p.x - slice.middle).z;
            let all = grown(&plank, p).fibre;
            let fibre = plank.trunk.vector(all.truncate(), all.z);
            let distance = slice.matter(p.x, z).medium.fibre.distance(fibre);
            assert!(distance < 1.0e-3, "seed {seed} at {p}: {distance}");
        }
    }
}

/// The place in the stem of a point of the unwarped board: x, y and height [mm], by vectors alone.
fn in_stem(wood: &Wood, stem: &Stem, p: Vec3) -> [f64; 3] {
    let (board, lies) = (&wood.board, &wood.stem);
    let half = 0.5 * board.length_mm;
    let along = lies.board_along_mm.clamp(half, stem.ends_mm()[1] - half);
    let (dx, dy) = (f64::from(p.x) - board.offset_mm, f64::from(p.y) - board.lead_in_mm - half);
    let turn = wood.log.grain_angle_deg.to_radians();
    let (sideways, l) = (dx * turn.cos() - dy * turn.sin(), dx * turn.sin() + dy * turn.cos());
    let up = f64::from(p.z) - board.thickness_mm + wood.log.pith_tilt_deg.to_radians().tan() * l;
    let azimuth = lies.board_azimuth_deg.to_radians();
    let normal = azimuth + lies.face_deg.to_radians();
    let pith = stem.pith_mm(along);
    [
        pith[0] + lies.board_radius_mm * azimuth.cos() + up * normal.cos() - sideways * normal.sin(),
        pith[1] + lies.board_radius_mm * azimuth.sin() + up * normal.sin() + sideways * normal.cos(),
        along + l,
    ]
}

#[test]
fn a_board_has_the_pith_the_outline_and_the_branches_of_its_place_in_the_stem() {
    let mut checked = 0;
    for seed in 0..24 {
        let (wood, stem, plank) = board(seed);
        for p in places(&plank, 200) {
            let place = plank.trunk.place(p.x, p.y, p.z);
            let [x, y, height] = in_stem(&wood, &stem, p);
            let pith = stem.pith_mm(height);
            let (x, y) = (x - pith[0], y - pith[1]);
            // The table of the pith has steps of 2 mm.
            assert!((f64::from(place.r) - x.hypot(y)).abs() < 2.0e-2, "seed {seed}, {p}: {place:?}");
            let outline = stem.radius_mm(y.atan2(x), height);
            let below =
                plank.cut(p.y).below_outline_mm(p.x, p.z + plank.cut(p.y).cut.warp(p.x - plank.cut(p.y).middle).z);
            assert!(
                (f64::from(below.expect("sawn")) - (outline - x.hypot(y))).abs() < 0.2 || place.r < 5.0,
                "seed {seed}, {p}: {below:?} against {outline} and {place:?}"
            );
        }
        for placed in &plank.knots {
            // Some branch of the stem lies where the knot does, and is as wide.
            for r in [20.0f32, 60.0, 90.0] {
                let section = placed.knot.section(&KnotDistance::new(r));
                let p = plank.trunk.point(r, section.phi, section.l);
                let [x, y, height] = in_stem(&wood, &stem, p);
                // Beyond the table of the pith only the way to the board matters, not the place.
                if section.l.abs() > 240.0 || r > placed.knot.end {
                    continue;
                }
                let pith = stem.pith_mm(height);
                let azimuth = (y - pith[1]).atan2(x - pith[0]);
                let fits = |branch: &StemBranch| {
                    let r = f64::from(r);
                    let turn = branch.azimuth_at(r) - azimuth;
                    let apart = r * 2.0 * (0.5 * turn).sin().abs();
                    (branch.height_at(r) - height).abs() < 0.05
                        && apart < 0.3
                        && (branch.width_mm(r) - 2.0 * f64::from(section.half_width)).abs() < 1.0e-3
                };
                assert!(stem.branches().iter().any(fits), "seed {seed}: {:?} at {r}", placed.knot);
                checked += 1;
            }
        }
    }
    assert!(checked > 250, "{checked}");
}

#[test]
fn an_end_is_rounded_and_what_it_did_fades_without_a_step() {
    let branch = StemBranch {
        width: [0.2, -0.8 * 0.2 / 40.0_f64.sqrt().sqrt()],
        height: [0.0, 0.1, -0.2],
        azimuth: [0.3, 0.05],
        end_mm: 60.0,
        death_mm: 40.0,
    };
    let draw = crate::wood::knot::KnotDraw::new(Stream::root(1), &Wood::from_values(&mut |p| p.default).knots);
    let knot = crate::wood::knot::Knot::of_branch(&branch, 0.0, 0.0, 50.0, 0.7, &draw);
    // 0.2 * 0.2 * 40 = 1.6 mm wide from its death on: 0.8 mm of rounding, 3.2 mm of healing.
    assert!(
        (branch.width_mm(50.0) - 1.6).abs() < 1.0e-9
            && (knot.section(&KnotDistance::new(55.0)).half_width - 0.8).abs() < 1.0e-5
    );
    assert_eq!((knot.tip(59.1), knot.left(59.1).0, knot.left(63.3).0), (1.0, 1.0, 0.0));
    assert!((knot.tip(59.6) - 0.75_f32.sqrt()).abs() < 1.0e-3 && knot.tip(60.0) < 0.01);
    for i in 0..90 {
        let r = 58.9 + 0.05 * i as f32;
        let numeric = (knot.left(r + 0.01).0 - knot.left(r - 0.01).0) / 0.02;
        // f32 gives r to 4e-6 mm; the third derivative is at most 60 over the cube of 4 mm.
        assert!((numeric - knot.left(r).1).abs() < 2.0e-3, "at {r}");
    }
}

/// A board around the end of a single thick stub, whose axis runs straight up.
fn stub_board() -> Plank {
    let knots = [[0.75, -0.8 * 0.75 / 40.0_f64.sqrt().sqrt(), 200.0, 0.0, 0.0, 0.0, 0.0, 62.0, 40.0]];
    let pith: Vec<[f64; 3]> = (0..5).map(|i| [0.0, 0.0, 100.0 * f64::from(i)]).collect();
    let stem = Stem::measured(&pith, &vec![vec![130.0; 36]; 5], &knots).expect("a stem");
    let mut wood = wood();
    wood.log.pith_tilt_deg = 0.0;
    (wood.stem.board_along_mm, wood.stem.board_radius_mm) = (200.0, 77.0);
    Plank::saw(Stream::root(5), &wood, &stem)
}

#[test]
fn growth_layers_close_over_a_stub_smoothly_and_fibres_with_them() {
    let plank = stub_board();
    assert!(plank.instances().is_empty());
    let knot = &plank.knots[0].knot;
    // 0.2 * 0.75 * 40 = 6 mm wide: it rounds off over 3 mm and heals over 12 mm.
    assert!(knot.end == 62.0 && (knot.gone() - 74.0).abs() < 1.0e-3);
    let (h, mut looked, mut most) = (0.02, 0, 0.0_f32);
    let bulge = |p: Vec3| grown(&plank, p).t - plank.growth.at(&plank.trunk.place(p.x, p.y, p.z), std::iter::empty()).t;
    for i in -40..=40 {
        for j in -40..=40 {
            for k in 0..40 {
                let p = Vec3::new(0.25 * i as f32, 125.0 + 0.3 * j as f32, 0.5 + 0.5 * k as f32);
                let here = grown(&plank, p);
                // Where the shape of the bulge changes from inside the outline to outside its slope has a kink.
                let kink = (p.x.hypot(p.y - 125.0) / 3.0 - 0.8).abs() < 0.02;
                if kink || here.branch.is_some_and(|branch| branch.x < 1.1) {
                    continue;
                }
                let numeric = Vec3::from_array(
                    [Vec3::X, Vec3::Y, Vec3::Z]
                        .map(|axis| (grown(&plank, p + h * axis).t - grown(&plank, p - h * axis).t) / (2.0 * h)),
                );
                let analytic = plank.trunk.vector(here.gradient.truncate(), here.gradient.z);
                // As for boards with placed knots.
                assert!(numeric.distance(analytic) < 0.02, "{p}: {numeric} against {analytic}");
                most = most.max(bulge(p).abs());
                looked += 1;
            }
        }
    }
    assert!(looked > 150_000, "{looked}");
    // Above the middle of the stub the layers that bent in around it come back to where they were without it, steadily.
    assert!(most > 0.2, "{most}");
    let above: Vec<f32> = (0..=22).map(|k| bulge(Vec3::new(0.0, 125.0, 9.0 + 0.5 * k as f32))).collect();
    assert!(above.windows(2).all(|w| w[1] <= w[0] + 1.0e-3), "{above:?}");
    assert!(above[0] > 0.2 && above[21].abs() < 1.0e-4, "{above:?}");
    let beyond = grown(&plank, Vec3::new(0.3, 125.4, 19.5));
    assert!(beyond.disturbed == 0.0 && beyond.branch.is_none());
}

#[test]
fn the_law_of_the_width_is_that_of_the_file() {
    // Row 8 of the scanned log: the law has its maximum where the branch died.
    let row = [0.553483, -0.14481, 350.565, 0.133432, -0.262179, 2.05488, 0.0302885, 138.0, 87.4148];
    let outline = StemOutline::measured([0.0, 4000.0], &[vec![130.0; 36], vec![130.0; 36]]);
    let branch = StemBranch::measured(&row, &outline);
    assert!(branch.end_mm.is_infinite() && branch.death_mm == 87.4148);
    assert!((branch.widest_mm() - 87.4).abs() < 0.1);
    for r in [10.0_f64, 50.0, 80.0] {
        assert!((branch.width_mm(r) - r * (row[0] + row[1] * r.powf(0.25))).abs() < 1.0e-12);
        assert!((branch.height_at(r) - (row[2] + row[3] * r.sqrt() + row[4] * r)).abs() < 1.0e-9);
        assert!((branch.azimuth_at(r) - (row[5] + row[6] * r.ln())).abs() < 1.0e-12);
    }
    assert_eq!(branch.width_mm(100.0), branch.width_mm(130.0));
    let short = StemBranch::measured(
        &{
            let mut r = row;
            r[7] = 90.0;
            r
        },
        &outline,
    );
    assert_eq!((short.end_mm, short.death_mm), (90.0, 87.4148));
    let lived = StemBranch::measured(
        &{
            let mut r = row;
            r[7] = 60.0;
            r
        },
        &outline,
    );
    assert_eq!((lived.end_mm, lived.death_mm), (60.0, 60.0));
}

#[test]
fn the_pith_passes_its_points_with_the_slope_of_its_neighbours() {
    let points = [[1.0, 5.0, 0.0], [2.0, 4.0, 10.0], [4.0, 4.0, 25.0], [3.0, 6.0, 30.0]];
    let line = PithLine::through(&points);
    for p in points {
        let ([x, y], _) = line.at(p[2]);
        assert!((x - p[0]).abs() < 1.0e-12 && (y - p[1]).abs() < 1.0e-12);
    }
    assert!((line.at(10.0).1[0] - 3.0 / 25.0).abs() < 1.0e-12);
    for i in 1..290 {
        let h = 0.1 * f64::from(i) + 0.03;
        let numeric = (line.at(h + 1.0e-5).0[1] - line.at(h - 1.0e-5).0[1]) / 2.0e-5;
        assert!((numeric - line.at(h).1[1]).abs() < 1.0e-6, "at {h}");
    }
    assert_eq!(line.at(-5.0), ([1.0, 5.0], [0.0; 2]));
}

#[test]
fn the_outline_is_a_circle_about_its_own_middle_where_it_has_no_other_shape() {
    let mut numbers = wood().stem;
    (numbers.oval, numbers.lobes, numbers.taper_mm_per_m, numbers.eccentricity) = (1.0, 0.0, 0.0, 0.1);
    let stem = Stem::grow(Stream::root(3), &numbers);
    let at = |azimuth: f64| {
        let (pith, r) = (stem.pith_mm(700.0), stem.radius_mm(azimuth, 700.0));
        Vec2::new((pith[0] + r * azimuth.cos()) as f32, (pith[1] + r * azimuth.sin()) as f32)
    };
    // Opposite points lie a diameter apart only through the middle: three points give it.
    let (a, b, c) = (at(0.0), at(2.0), at(4.0));
    let d = 2.0 * (a.x * (b.y - c.y) + b.x * (c.y - a.y) + c.x * (a.y - b.y));
    let sq = [a, b, c].map(|p| p.length_squared());
    let middle = Vec2::new(
        (sq[0] * (b.y - c.y) + sq[1] * (c.y - a.y) + sq[2] * (a.y - b.y)) / d,
        (sq[0] * (c.x - b.x) + sq[1] * (a.x - c.x) + sq[2] * (b.x - a.x)) / d,
    );
    assert!((middle.length() - 12.3).abs() < 1.0e-2, "{middle}");
    for i in 0..50 {
        assert!((at(0.13 * f64::from(i)).distance(middle) - 123.0).abs() < 1.0e-2);
    }
}

/// A small measured stem, and what is wrong once it was damaged.
fn fault(damage: impl Fn(&mut Vec<[f64; 3]>, &mut Vec<Vec<f64>>, &mut Vec<[f64; 9]>)) -> Result<Stem, StemError> {
    let mut pith = vec![[0.0, 0.0, 0.0], [0.0, 1.0, 100.0], [1.0, 1.0, 200.0]];
    let mut radii = vec![vec![80.0; 12]; 3];
    let mut knots = vec![[0.2, -0.05, 50.0, 0.1, -0.2, 1.0, 0.02, 80.0, 60.0]; 2];
    damage(&mut pith, &mut radii, &mut knots);
    Stem::measured(&pith, &radii, &knots)
}

#[test]
fn a_damaged_stem_is_refused_with_its_row() {
    assert!(fault(|_, _, _| {}).is_ok());
    type Damage = fn(&mut Vec<[f64; 3]>, &mut Vec<Vec<f64>>, &mut Vec<[f64; 9]>);
    let faults: [(&str, Damage); 17] = [
        ("pith: 1 rows, but at least 2", |p, _, _| p.truncate(1)),
        ("radii: 0 rows, but at least 2", |_, r, _| r.clear()),
        ("knots: 0 rows, but at least 1", |_, _, k| k.clear()),
        ("knots: 10001 rows, but at most 10000", |_, _, k| k.resize(10_001, k[0])),
        ("radii: 4 sections for 3 points", |_, r, _| r.push(vec![80.0; 12])),
        ("radii, row 2: 11 radii where 12", |_, r, _| r[1].truncate(11)),
        ("radii, row 1: 5 radii where 8", |_, r, _| r.iter_mut().for_each(|row| row.truncate(5))),
        ("pith, row 3: column height", |p, _, _| p[2][2] = f64::NAN),
        ("radii, row 3: column 4", |_, r, _| r[2][3] = f64::INFINITY),
        ("knots, row 2: column B", |_, _, k| k[1][1] = f64::NAN),
        ("pith, row 2: height 0 mm after 0 mm", |p, _, _| p[1][2] = 0.0),
        ("radii, row 1: the radius in column 1", |_, r, _| r[0][0] = -3.0),
        ("knots, row 1: A, the opening", |_, _, k| k[0][0] = 0.0),
        ("knots, row 1: F, the azimuth", |_, _, k| k[0][5] = 215.0),
        ("knots, row 2: C, the height", |_, _, k| k[1][2] = 5000.0),
        ("knots, row 2: the slope", |_, _, k| k[1][4] = -8.0),
        ("knots, row 2: the width where it ends", |_, _, k| k[1][1] = 2.0),
    ];
    for (text, damage) in faults {
        let said = fault(damage).expect_err(text).to_string();
        assert!(said.starts_with(text) && said.contains(';'), "{said:?} for {text:?}");
    }
}

/// A log's boards, drawn at random: the first, the room, and how many pieces are sure.
fn pattern(seed: u64) -> (Wood, LogRoom, u64) {
    let mut rng = Stream::root(seed).child("pattern").rng();
    let mut draw = |from: f64, to: f64| from + (to - from) * rng.random::<f64>();
    let mut wood = wood();
    (wood.board.width_mm, wood.board.length_mm) = (draw(10.0, 200.0), draw(20.0, 900.0));
    wood.board.thickness_mm = draw(4.0, 60.0);
    (wood.stem.length_mm, wood.stem.radius_mm) = (draw(1000.0, 9000.0), draw(60.0, 300.0));
    wood.stem.board_along_mm = draw(0.0, 9000.0);
    wood.stem.board_azimuth_deg = draw(-180.0, 180.0);
    wood.stem.board_radius_mm = draw(0.0, 250.0);
    wood.stem.face_deg = draw(-180.0, 180.0);
    wood.log.grain_angle_deg = if seed.is_multiple_of(2) { draw(-5.0, 5.0) } else { draw(-90.0, 90.0) };
    let room = LogRoom { length_mm: wood.stem.length_mm, radius_mm: wood.stem.radius_mm };
    let turn = wood.log.grain_angle_deg;
    (wood, room, least_pieces(room.length_mm, wood.board.length_mm, wood.board.width_mm, turn))
}

/// Middle of the upper face in the stem and azimuth of its normal: x, y, height [mm]; [rad].
fn lies(wood: &Wood) -> ([f64; 3], f64) {
    let half = 0.5 * wood.board.length_mm;
    let along = wood.stem.board_along_mm.clamp(half, (wood.stem.length_mm - half).max(half));
    let azimuth = wood.stem.board_azimuth_deg.to_radians();
    let r = wood.stem.board_radius_mm;
    ([r * azimuth.cos(), r * azimuth.sin(), along], azimuth + wood.stem.face_deg.to_radians())
}

#[test]
fn boards_of_a_log_do_not_overlap() {
    let (mut pairs, mut stacked) = (0, 0);
    for seed in 0..400 {
        let (wood, room, sure) = pattern(seed);
        let boards: Vec<Wood> = (0..sure.min(30)).map(|number| sawn_at(&wood, room, number)).collect();
        assert_eq!(boards[0], wood, "seed {seed}: the first board lies where it was asked");
        let (sin, cos) = wood.log.grain_angle_deg.to_radians().sin_cos();
        for (i, a) in boards.iter().enumerate() {
            let (place, normal) = lies(a);
            assert!(a.stem.board_radius_mm <= room.radius_mm.max(wood.stem.board_radius_mm) + 1e-9);
            for b in &boards[..i] {
                let (other, same) = lies(b);
                let off = [0, 1, 2].map(|k| place[k] - other[k]);
                assert!((normal - same).sin().abs() < 1e-9, "seed {seed}: boards are parallel");
                // In the board's own directions: through it, across it and along it.
                let through = off[0] * normal.cos() + off[1] * normal.sin();
                let aside = off[1] * normal.cos() - off[0] * normal.sin();
                let (across, along) = (aside * cos - off[2] * sin, aside * sin + off[2] * cos);
                let board = &wood.board;
                assert!(
                    through.abs() >= board.thickness_mm + 3.9
                        || across.abs() >= board.width_mm + 3.9
                        || along.abs() >= board.length_mm + 3.9,
                    "seed {seed}, board {i}: {through} {across} {along}"
                );
                (pairs, stacked) = (pairs + 1, stacked + u32::from(through.abs() > 1.0));
            }
        }
    }
    assert!(pairs > 5000 && stacked > 1000, "{stacked} of {pairs} pairs lie above each other");
}

/// Boards of one log have its rings, and what one branch is in one of them it is in the other: the same outline about
/// the pith.
#[test]
fn a_branch_that_reaches_two_boards_is_in_both() {
    let mut both = 0;
    for seed in 0..12 {
        let (mut wood, _, _) = board(4 * seed + 2);
        wood.stem.board_radius_mm = 60.0;
        wood.log.grain_angle_deg = 0.0;
        let log = Stream::root(seed).child("log");
        let room = LogRoom { length_mm: wood.stem.length_mm, radius_mm: wood.stem.radius_mm };
        let stem = Stem::grow(log.child("stem"), &wood.stem);
        let saw = |number: u64| {
            let streams = BoardStreams { board: Stream::root(seed).index(number), log };
            let wood = sawn_at(&wood, room, number);
            (Plank::saw_of_log(streams, &wood, &stem), Sawing::new(&wood, &stem))
        };
        let ((upper, above), (lower, below)) = (saw(0), saw(1));
        assert_eq!(above.along, below.along);
        for t in 0..600 {
            let t = 0.1 * t as f32;
            assert_eq!(upper.rings.at(t), lower.rings.at(t), "rings at {t}");
        }
        for knot in &upper.knots {
            let knot = &knot.knot;
            let turn = |sawing: &Sawing, phi: f32| f64::from(phi) + sawing.azimuth;
            let at = |knot: &Knot| knot.section(&KnotDistance::new(40.0));
            let twin = lower.knots.iter().map(|other| &other.knot).find(|other| {
                let apart = turn(&above, at(knot).phi) - turn(&below, at(other).phi);
                (at(knot).l - at(other).l).abs() < 1e-3 && libm::remainder(apart, std::f64::consts::TAU).abs() < 1e-4
            });
            if let Some(twin) = twin {
                assert_eq!((at(knot).half_width, knot.end, knot.death), (at(twin).half_width, twin.end, twin.death));
                both += 1;
            }
        }
    }
    assert!(both > 20, "{both} branches reach two boards");
}

/// The last layer is the outline where layers follow it fully, and the round one elsewhere.
#[test]
fn the_outermost_ring_is_the_outline() {
    for seed in 0..12 {
        let (mut wood, stem, _) = board(8 * seed + 4);
        wood.stem.rings_follow_outline = 1.0;
        let plank = Plank::saw(Stream::root(seed), &wood, &stem);
        wood.stem.rings_follow_outline = 0.0;
        let round = Plank::saw(Stream::root(seed), &wood, &stem);
        let mean = stem.mean_radius_mm() as f32;
        let mut uneven = 0.0f32;
        for p in places(&plank, 300) {
            let place = plank.trunk.place(p.x, p.y, p.z);
            let r = plank.outline_mm(place.phi, place.l).expect("a stem has an outline");
            let at_bark = LogPoint { r, ..place };
            // The spline smooths lobes between azimuths and sections.
            let last = plank.trunk.layer(&at_bark);
            assert!((last / mean - 1.0).abs() < 2.0e-3, "seed {seed}: {last} mm, of a stem of {mean}");
            uneven = uneven.max((round.trunk.layer(&at_bark) / mean - 1.0).abs());
        }
        assert!(uneven > 0.02, "seed {seed}: the stem is round, {uneven}");
    }
}

/// With wane by the outline, nothing of the upper face lies beyond the outline but for bark's roughness, the rest of it
/// is where it was, and all that is lower has the label, chipped or not.
#[test]
fn wane_is_where_the_outline_leaves_the_board() {
    let (mut waned, mut full, mut chips, mut outer) = (0, 0, 0, 0);
    for seed in 0..16 {
        let (mut wood, stem, _) = board(4 * seed + 2);
        wood.stem.board_radius_mm = 85.0 + 2.0 * seed as f64;
        (wood.board.saw_ripple_um, wood.board.roughness_um) = (0.0, 0.0);
        // Every other board has edges that wander, beyond its nominal width too.
        wood.board.edge_wander_mm = if seed.is_multiple_of(2) { 0.0 } else { 1.5 };
        let edged = Plank::saw(Stream::root(seed), &wood, &stem);
        wood.stem.outline_wane = 1.0;
        let plank = Plank::saw(Stream::root(seed), &wood, &stem);
        (wood.marks.chip_count, wood.marks.chip_mm) = (30.0, 20.0);
        let chipped = Plank::saw(Stream::root(seed), &wood, &stem);
        assert!(edged.relief() == Relief::Smooth && edged.instances().iter().all(|found| found.class != Class::Wane));
        let (low, high) = plank.bounds();
        for i in 0..40 {
            let y = low.y + (high.y - low.y) * (0.5 + i as f32) / 40.0;
            let (slice, before, after) = (plank.cut(y), edged.cut(y), chipped.cut(y));
            for k in 0..60 {
                let x = low.x + (high.x - low.x) * (0.5 + k as f32) / 60.0;
                let (Some(face), Some(whole)) = (slice.surface(x), before.surface(x)) else { continue };
                let was = before.below_outline_mm(x, whole.z).expect("a stem");
                let label = slice.matter(x, face.z).class;
                let under = after.surface(x).expect("as wide as before").z;
                chips += u32::from(label == Class::Wane && under < face.z - 0.05);
                assert!(
                    label != Class::Wane || after.matter(x, under).class == label,
                    "seed {seed}: a chip takes a label"
                );
                outer += u32::from(
                    label == Class::Wane && (x - 0.5 * (low.x + high.x)).abs() > 0.5 * wood.board.width_mm as f32,
                );
                if was > 0.01 {
                    assert_eq!(face.z, whole.z, "seed {seed}: ({x}, {y}) is {was} mm inside");
                    assert!(label != Class::Wane);
                    full += 1;
                } else if was < -0.5 {
                    assert!(face.z < whole.z && label == Class::Wane, "seed {seed}: ({x}, {y}) is {was} mm outside");
                    let is = slice.below_outline_mm(x, face.z).expect("a stem");
                    let is_sheet = face.z < (whole.z - wood.board.thickness_mm as f32 + 0.5).max(0.31);
                    assert!(is_sheet || is.abs() < 2.5, "seed {seed}: ({x}, {y}) is {is} mm inside");
                    waned += 1;
                }
            }
        }
        let width: f64 = plank.instances().iter().filter(|f| f.class == Class::Wane).map(|f| f.diameter_mm).sum();
        assert!(width < wood.board.width_mm);
    }
    assert!(waned > 1000 && full > 8000, "{waned} spots of wane, {full} of the face");
    assert!(chips > 20 && outer > 20, "{chips} spots of chips in wane, {outer} of wane beyond the nominal width");
}
