//! Boards that are sawn from stems, as a scan of the upper face sees them.

use crate::boards::{face, is_knot};
use crate::gran_1::{deviation, gran_1, grown, knots, mean, surface};
use base::{BodyKind, Class, Instance, Slice, Stream};
use procedural::wood::{Plank, Stem, StemBranch, Wood};

/// A board without warp and marks of the saw, parallel to the stem, so that its face is the plane that was asked for.
fn plain(width: f64, length: f64) -> Wood {
    let mut wood = Wood::from_values(&mut |p| p.default);
    (wood.board.width_mm, wood.board.length_mm) = (width, length);
    (wood.board.cup_mm, wood.board.twist_deg) = (0.0, 0.0);
    (wood.board.saw_ripple_um, wood.board.roughness_um) = (0.0, 0.0);
    wood.log.pith_tilt_deg = 0.0;
    wood
}

/// The same with the middle of its face where the branch's axis is `r` from the pith.
fn through(wood: &mut Wood, stem: &Stem, branch: &StemBranch, r: f64) {
    wood.stem.board_radius_mm = r;
    wood.stem.board_azimuth_deg = branch.azimuth_at(r).to_degrees();
    wood.stem.board_along_mm = branch.height_at(r) - stem.ends_mm()[0];
}

fn saw(seed: u64, wood: &Wood, stem: &Stem) -> Plank {
    Plank::saw(Stream::root(seed), wood, stem)
}

/// The knot nearest to the middle of the face, and how far from it [mm].
fn middle_knot(plank: &Plank) -> Option<(Instance, f64)> {
    let (low, high) = plank.bounds();
    let middle = 0.5 * (low + high);
    let off = |k: &Instance| (k.x_mm - f64::from(middle.x)).hypot(k.y_mm - f64::from(middle.y));
    plank.instances().iter().map(|k| (*k, off(k))).min_by(|a, b| a.1.total_cmp(&b.1))
}

/// How wide a knot shows across the board at its centre [mm].
fn shown_width(plank: &Plank, knot: &Instance) -> f64 {
    let slice = plank.cut(knot.y_mm as f32);
    let step = 0.01_f32;
    let edge = |side: f32| {
        let at = |i: &i32| {
            let x = knot.x_mm as f32 + side * step * *i as f32;
            slice.surface(x).is_some_and(|s| slice.matter(x, s.z).instance == knot.id)
        };
        f64::from(step) * f64::from((0..4000).take_while(at).count() as u32)
    };
    edge(-1.0) + edge(1.0)
}

#[test]
fn a_board_through_a_measured_knot_shows_it() {
    let stem = gran_1();
    let (mut faces, mut ratios) = (0, Vec::new());
    for (row, (numbers, branch)) in knots().iter().zip(stem.branches()).enumerate() {
        let &[.., end, death] = numbers;
        let reach = surface(&stem, branch).min(end);
        // Alive halfway to its death, and dead halfway from there to its end, if it is.
        let alive = 0.5 * death.min(reach);
        let mut places = vec![(alive, Class::SoundKnot), (0.95 * death.min(reach), Class::SoundKnot)];
        if death < 0.95 * reach {
            places.push((0.5 * (death + reach), Class::DeadKnot));
        }
        for (r, class) in places {
            let mut wood = plain(60.0, 60.0);
            through(&mut wood, &stem, branch, r);
            let plank = saw(row as u64, &wood, &stem);
            let (knot, off) = middle_knot(&plank).unwrap_or_else(|| panic!("row {}: no knot at {r}", row + 1));
            // The table of the pith has steps of 2 mm.
            assert!(off < 0.05, "row {}: {off} mm from the place", row + 1);
            assert_eq!(knot.class, class, "row {} at {r}: dies at {death}", row + 1);
            let width = branch.width_mm(r);
            assert!((knot.diameter_mm / width - 1.0).abs() < 2.0e-3, "row {}: {knot:?} for {width}", row + 1);
            let matter = plank.cut(knot.y_mm as f32).matter(knot.x_mm as f32, 22.0);
            assert_eq!((matter.class, matter.instance), (class, knot.id), "row {}", row + 1);
            assert_eq!(knot.death_radius_mm.is_nan(), class == Class::SoundKnot);
            // Alone on its place it also looks that wide, but for the chord and the wobble of the outline.
            let alone = plank.instances().iter().all(|other| {
                other.id == knot.id
                    || (other.x_mm - knot.x_mm).hypot(other.y_mm - knot.y_mm) > 2.0 * width + other.diameter_mm
            });
            if alone && r > 30.0 && r < end - width {
                ratios.push(shown_width(&plank, &knot) / width);
            }
            faces += 1;
        }
    }
    assert!(faces > 250, "{faces}");
    // The outline wobbles by 3.5 percent of the radius, each side with its own; the lean and the widening of the axis
    // add little.
    let spread = deviation(&ratios);
    let error = spread / (ratios.len() as f64).sqrt();
    println!("{faces} faces, {} widths: {} +- {spread} of the law's", ratios.len(), mean(ratios.iter().copied()));
    assert!(ratios.len() > 100 && (mean(ratios.iter().copied()) - 1.0).abs() < 3.3 * error + 5.0e-3);
    assert!(spread < 0.04, "{spread}");
}

#[test]
fn measured_branches_end_at_the_measured_outline() {
    let stem = gran_1();
    let knots = knots();
    let reaching = knots.iter().zip(stem.branches()).filter(|(_, branch)| branch.end_mm.is_infinite());
    let (ends, outline): (Vec<f64>, Vec<f64>) = reaching.map(|(row, branch)| (row[7], surface(&stem, branch))).unzip();
    let covariance = |a: &[f64], b: &[f64]| {
        let (u, v) = (mean(a.iter().copied()), mean(b.iter().copied()));
        mean(a.iter().zip(b).map(|(a, b)| (a - u) * (b - v)))
    };
    let correlation = covariance(&ends, &outline) / (deviation(&ends) * deviation(&outline));
    println!("{} ends, correlation {correlation}", ends.len());
    // The whole file has 0.91, and 0.64 at best where the sections are read the other way. By Fisher's transform 0.82
    // lies 3.6 standard errors of 95 pairs below the one and as many above the other.
    assert!(ends.len() == 95 && correlation > 0.82, "{correlation}");
}

#[test]
fn a_branch_that_has_ended_is_not_seen() {
    let stem = gran_1();
    let (mut ends, mut before, mut beyond) = (0, 0, 0);
    let mut looked = |stem: &Stem, branch: &StemBranch| {
        let end = branch.end_mm;
        let width = branch.width_mm(end);
        if end + width + 2.0 > surface(stem, branch) {
            return;
        }
        ends += 1;
        for (r, sees) in
            [(end - width, true), (end + 0.1, false), (end + 0.5 * width, false), (end + width + 1.0, false)]
        {
            let mut wood = plain(60.0, 60.0);
            through(&mut wood, stem, branch, r);
            let plank = saw(ends, &wood, stem);
            let middle = middle_knot(&plank).filter(|(knot, off)| *off < 0.3 && knot.diameter_mm < 1.001 * width);
            let (low, high) = plank.bounds();
            let (x, y) = (0.5 * (low.x + high.x), 0.5 * (low.y + high.y));
            let matter = plank.cut(y).matter(x, 22.0);
            // Another branch may run here too.
            let others = stem.branches().iter().filter(|other| *other != branch && r < other.end_mm).any(|other| {
                let turn = (0.5 * (other.azimuth_at(r) - branch.azimuth_at(r))).sin().abs() * 2.0 * r;
                (other.height_at(r) - branch.height_at(r)).hypot(turn) < 2.0 * other.width_mm(r)
            });
            if sees {
                assert!(middle.is_some(), "{branch:?} at {r}: {:?}", plank.instances());
                before += 1;
            } else if !others {
                assert!(middle.is_none(), "{branch:?} at {r}: {middle:?}");
                assert_eq!((matter.class, matter.instance), (Class::Clear, 0), "{branch:?} at {r}");
                beyond += 1;
            }
        }
    };
    for branch in stem.branches().iter().filter(|b| b.end_mm.is_finite()) {
        looked(&stem, branch);
    }
    for seed in 0..6 {
        let stem = grown(seed);
        let [low, high] = stem.ends_mm();
        let within = |b: &&StemBranch| b.end_mm.is_finite() && low + 60.0 < b.height[0] && b.height[0] < high - 60.0;
        for branch in stem.branches().iter().filter(within) {
            looked(&stem, branch);
        }
    }
    assert!(ends > 60 && before == ends && beyond > 150, "{ends} ends, {before} before, {beyond} beyond");
}

#[test]
fn beyond_a_healed_end_the_wood_is_as_if_there_had_been_no_branch() {
    let stem = gran_1();
    let mut looked = 0;
    for branch in stem.branches().iter().filter(|b| b.end_mm < 80.0) {
        let mut wood = plain(40.0, 40.0);
        let r = branch.end_mm + 6.0 * branch.width_mm(branch.end_mm);
        through(&mut wood, &stem, branch, r);
        // A thin board lies beyond the end altogether.
        wood.board.thickness_mm = 2.0;
        let far = stem.branches().iter().all(|other| {
            let turn = (0.5 * (other.azimuth_at(r) - branch.azimuth_at(r))).sin().abs() * 2.0 * r;
            other == branch || r > other.end_mm || (other.height_at(r) - branch.height_at(r)).hypot(turn) > 60.0
        });
        if !far {
            continue;
        }
        let plank = saw(1, &wood, &stem);
        assert!(plank.instances().is_empty());
        let rows = knots();
        let others: Vec<[f64; 9]> =
            stem.branches().iter().zip(&rows).filter(|(other, _)| *other != branch).map(|(_, row)| *row).collect();
        let without = Stem::measured(&crate::gran_1::pith(), &crate::gran_1::radii(), &others).expect("a row less");
        let bare = saw(1, &wood, &without);
        for ((x, y, a), (_, _, b)) in face(&plank, 1.0).into_iter().zip(face(&bare, 1.0)) {
            assert_eq!(a, b, "at {x}, {y}");
        }
        looked += 1;
    }
    assert!(looked >= 3, "{looked}");
}

#[test]
fn instances_are_what_the_face_shows() {
    let (mut seen, mut small, mut spikes) = (0, 0, 0);
    for seed in 0..12 {
        let stem = grown(seed);
        let mut wood = Wood::from_values(&mut |p| p.default);
        wood.board.length_mm = 500.0;
        wood.stem.board_along_mm = 300.0 + 280.0 * seed as f64;
        wood.stem.board_azimuth_deg = 31.0 * seed as f64 - 180.0;
        wood.stem.face_deg = [0.0, 90.0, 150.0, 0.0][seed as usize % 4];
        wood.stem.board_radius_mm = [60.0, 50.0, 40.0, 4.0][seed as usize % 4];
        let plank = saw(seed, &wood, &stem);
        let face = face(&plank, 0.4);
        let knots = plank.instances();
        assert!(knots.windows(2).all(|w| w[0].y_mm <= w[1].y_mm), "seed {seed}: not in order");
        for (index, knot) in knots.iter().enumerate() {
            assert_eq!(usize::from(knot.id), index + 1);
            let shown = face.iter().filter(|(_, _, m)| m.instance == knot.id);
            assert!(shown.clone().all(|(_, _, m)| m.class == knot.class));
            let count = shown.count();
            // A knot under 1 mm may lie between the points, or only show on a ridge.
            assert!(count > 0 || knot.diameter_mm < 1.0 || knot.dive_deg < 10.0, "seed {seed}: {knot:?} is not seen");
            seen += i32::from(count > 0);
            small += i32::from(count == 0);
            spikes += i32::from(knot.dive_deg < 30.0);
        }
        for (x, y, matter) in &face {
            let known = knots.iter().find(|knot| knot.id == matter.instance).map_or(Class::Clear, |knot| knot.class);
            assert_eq!(known, matter.class, "seed {seed} at {x}, {y}");
            // Wood of a branch is labelled: no other fibre dives or runs across like that.
            let along = matter.medium.fibre.y.abs();
            assert!(
                along > 0.5 || is_knot(matter.class) || near_knot(knots, *x, *y),
                "seed {seed} at {x}, {y}: {matter:?}"
            );
        }
    }
    assert!(seen > 35 && small * 8 < seen && spikes > 7, "{seen} seen, {small} not, {spikes} spikes");
}

/// Whether a knot's surroundings are near, where fibres part.
fn near_knot(knots: &[Instance], x: f32, y: f32) -> bool {
    knots.iter().any(|k| {
        let reach = k.diameter_mm / k.dive_deg.to_radians().sin().max(0.1) + 1.0;
        (k.x_mm - f64::from(x)).hypot(k.y_mm - f64::from(y)) < reach
    })
}

#[test]
#[ignore = "long"]
fn statistics_do_not_depend_on_the_place_along_the_stem() {
    let stems = 120;
    let mut numbers = Wood::from_values(&mut |p| p.default);
    numbers.stem.taper_mm_per_m = 0.0;
    let of = |along: f64| -> Vec<[f64; 4]> {
        (0..stems)
            .map(|seed| {
                let stem = Stem::grow(Stream::root(seed).child("stem"), &numbers.stem);
                let mut wood = plain(94.0, 400.0);
                wood.stem = numbers.stem;
                wood.stem.board_along_mm = along;
                wood.stem.board_azimuth_deg = 3.0 * seed as f64 - 180.0;
                let plank = saw(seed, &wood, &stem);
                let knots = plank.instances();
                let dead = knots.iter().filter(|k| k.class == Class::DeadKnot).count();
                let widths = mean(knots.iter().map(|k| k.diameter_mm.ln()));
                let clear = mean((0..60).flat_map(|j| {
                    let slice = plank.cut(25.0 + 6.5 * j as f32);
                    (0..20).map(move |i| f64::from(slice.matter(-46.0 + 4.8 * i as f32, 22.0).medium.mu_a))
                }));
                [knots.len() as f64, dead as f64, widths, clear]
            })
            .collect()
    };
    let column = |rows: &[[f64; 4]], n: usize| rows.iter().map(|r| r[n]).filter(|v| v.is_finite()).collect::<Vec<_>>();
    let places = [200.0, 1400.0, 2600.0, 3800.0].map(of);
    for (n, name) in ["knots", "dead ones", "mean ln width", "mean absorption"].into_iter().enumerate() {
        for a in 0..4 {
            for b in 0..a {
                let (u, v) = (column(&places[a], n), column(&places[b], n));
                let apart = mean(u.iter().copied()) - mean(v.iter().copied());
                let error = (deviation(&u).powi(2) / u.len() as f64 + deviation(&v).powi(2) / v.len() as f64).sqrt();
                // 24 tests, alpha 0.001 in all: 4.1 standard errors.
                assert!(apart.abs() < 4.1 * error, "{name}: {apart} +- {error} between places {a} and {b}");
            }
        }
    }
}

/// Everything that tells one sawn board from another, sampled coarsely.
fn answers(wood: &Wood) -> Vec<u32> {
    let stem = Stem::grow(Stream::root(11).child("stem"), &wood.stem);
    let plank = saw(11, wood, &stem);
    let mut words: Vec<u32> = format!("{:?}", plank.instances()).bytes().map(u32::from).collect();
    for j in 0..50 {
        let slice = plank.cut(25.0 + 15.7 * j as f32);
        for i in 0..30 {
            let x = -45.0 + 3.1 * i as f32;
            let m = slice.matter(x, 21.7);
            words.extend([m.medium.mu_a, m.medium.fibre.x, m.medium.fibre.z].map(f32::to_bits));
            words.push(slice.surface(x).map_or(0, |surface| surface.z.to_bits()));
            words.push(slice.below_outline_mm(x, 21.7).expect("sawn").to_bits());
        }
    }
    words
}

#[test]
fn every_number_of_the_stem_has_an_effect() {
    let mut base = Wood::from_values(&mut |p| p.default);
    base.board.length_mm = 800.0;
    // Its arrises lie beyond the outline.
    base.stem.board_radius_mm = 130.0;
    let before = answers(&base);
    for (parameter, value) in base.stem.values() {
        let end = if parameter.max - value > value - parameter.min { parameter.max } else { parameter.min };
        let other = if parameter.integer { end } else { value + 0.1 * (end - value) };
        let mut values = base.stem.values().into_iter();
        let mut changed = base;
        changed.stem = procedural::wood::StemParameters::from_values(&mut |p| {
            let (_, old) = values.next().expect("as many values as declarations");
            if p.path() == parameter.path() { other } else { old }
        });
        assert!(before != answers(&changed), "{} does nothing from {value} to {other}", parameter.path());
    }
}

#[test]
fn a_grown_board_has_no_outline_and_a_sawn_one_that_of_its_stem() {
    let wood = plain(94.0, 210.0);
    let stem = grown(2);
    let plank = saw(2, &wood, &stem);
    let placed = Plank::grow(Stream::root(2), &wood);
    assert!(placed.outline_mm(0.0, 0.0).is_none() && placed.cut(100.0).below_outline_mm(0.0, 20.0).is_none());
    // Azimuth 0 points from the pith to the middle of a flat-sawn board, here at the azimuth 0 of the stem.
    for l in [-100.0f32, -3.0, 0.0, 55.0] {
        for phi in [-2.0f32, -0.4, 0.0, 1.3, 3.0] {
            let outline = plank.outline_mm(phi, l).expect("sawn");
            let asked = stem.radius_mm(f64::from(phi), wood.stem.board_along_mm + f64::from(l));
            // Chords of 1.4 deg leave an arc of 120 mm by 0.01 mm, sections of 10 mm the lobes by less than 0.05 mm.
            assert!((f64::from(outline) - asked).abs() < 0.1, "{outline} for {asked}");
        }
    }
    // 70 mm from the pith in the middle of the face; a board beyond the outline says so.
    let below = plank.cut(125.0).below_outline_mm(0.0, 22.0).expect("sawn");
    assert!((f64::from(below) - (stem.radius_mm(0.0, 2000.0) - 70.0)).abs() < 0.1, "{below}");
    let mut outer = wood;
    outer.stem.board_radius_mm = 130.0;
    assert!(saw(2, &outer, &stem).cut(125.0).below_outline_mm(46.0, 22.0).expect("sawn") < 0.0);
}

#[test]
fn a_board_is_a_function_of_its_stream_its_stem_and_its_numbers() {
    let wood = Wood::from_values(&mut |p| p.default);
    assert!(answers(&wood) == answers(&wood));
    let (a, b) = (saw(1, &wood, &grown(1)), saw(2, &wood, &grown(1)));
    // Another stream is another board of the same branches.
    let places = |plank: &Plank| plank.instances().iter().map(|k| (k.x_mm, k.y_mm, k.diameter_mm)).collect::<Vec<_>>();
    assert_eq!(places(&a), places(&b));
    assert!(a.cut(100.0).matter(3.0, 21.0) != b.cut(100.0).matter(3.0, 21.0));
    assert_ne!(places(&a), places(&saw(1, &wood, &grown(2))));
}

#[test]
fn wider_branches_are_the_same_branches() {
    // Branches are keyed by shoot and bud: a wider median widens all and moves none.
    let numbers = Wood::from_values(&mut |p| p.default).stem;
    let mut wider = numbers;
    wider.branch_width_mm *= 1.5;
    let (a, b) = (Stem::grow(Stream::root(4), &numbers), Stem::grow(Stream::root(4), &wider));
    assert_eq!(a.branches().len(), b.branches().len());
    for (a, b) in a.branches().iter().zip(b.branches()) {
        assert_eq!((a.height, a.azimuth), (b.height, b.azimuth));
        assert!(b.width[0] >= a.width[0]);
    }
}
