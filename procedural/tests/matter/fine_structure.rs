//! Fine structure of faces: tool marks, torn grain, canals, vessels and rays appear where they should and as often as
//! asked.

use crate::boards::{grow, wood};
use base::{BodyKind, Relief, Stream};
use procedural::wood::Plank;
use procedural::wood::Wood;
use rand::RngExt;

/// A flat board without ripple and roughness, and a number source for its own numbers.
fn plain(seed: u64) -> (Wood, impl FnMut(f64, f64) -> f64) {
    let mut wood = wood(0.0, 0.0);
    (wood.board.saw_ripple_um, wood.board.roughness_um) = (0.0, 0.0);
    (wood.board.cup_mm, wood.board.twist_deg) = (0.0, 0.0);
    let mut rng = Stream::root(seed).child("fine structure").rng();
    (wood, move |low: f64, high: f64| low + (high - low) * rng.random::<f64>())
}

/// Height over the thickness along y at x [mm].
fn heights(plank: &Plank, thickness: f64, x: f32, ys: impl Iterator<Item = f32>) -> Vec<f64> {
    ys.map(|y| f64::from(plank.slice(y).surface(x).expect("inside").z) - thickness).collect()
}

/// Power at a wavelength of a series of step 0.05 mm.
fn power(series: &[f64], wavelength: f64) -> f64 {
    let turn = std::f64::consts::TAU * 0.05 / wavelength;
    let (c, s) = series.iter().enumerate().fold((0.0, 0.0), |(c, s), (i, z)| {
        let (sin, cos) = (turn * i as f64).sin_cos();
        (c + z * cos, s + z * sin)
    });
    c * c + s * s
}

/// Marks have the asked height and pitch, and lie along the asked line.
#[test]
fn tool_marks_have_their_height_pitch_and_direction() {
    for seed in 0..12 {
        for tool in ["planer", "band", "circular"] {
            let (mut wood, mut draw) = plain(seed);
            let (um, pitch) = (draw(3.0, 60.0), draw(1.0, 4.0));
            let asked = &mut wood.machining;
            asked.band_slant_deg = draw(-20.0, 20.0);
            match tool {
                "planer" => (asked.planer_um, asked.planer_pitch_mm) = (um, pitch),
                "band" => (asked.band_um, asked.band_pitch_mm) = (um, pitch),
                _ => (asked.circular_um, asked.circular_pitch_mm) = (um, pitch),
            }
            let plank = grow(seed, &wood);
            let series: Vec<f64> = (0..8)
                .flat_map(|i| {
                    heights(
                        &plank,
                        wood.board.thickness_mm,
                        10.0 * i as f32 - 35.0,
                        (0..400).map(|j| 25.0 + 0.5 * j as f32),
                    )
                })
                .collect();
            let rms = (series.iter().map(|z| z * z).sum::<f64>() / series.len() as f64).sqrt();
            // Some 50 to 200 marks, whose depths vary by a half and stay alike over three: a tenth, three times that.
            assert!((1.0e3 * rms / um - 1.0).abs() < 0.3, "{tool} of seed {seed}: {rms} mm for {um} um");
            // Phase drift widens the line: power is gathered within a sixth of the pitch on either side.
            let column = heights(&plank, wood.board.thickness_mm, 3.0, (0..3600).map(|j| 30.0 + 0.05 * j as f32));
            let band =
                |centre: f64| (-20..=20).map(|k| power(&column, centre * (1.0 + f64::from(k) / 120.0))).sum::<f64>();
            let [here, longer, shorter] = [1.0, 1.9, 0.71].map(|factor| band(factor * pitch));
            assert!(here > 1.5 * longer.max(shorter), "{tool} of seed {seed}: {here} at {pitch}, {longer}, {shorter}");
        }
    }
}

/// Slopes are those of the heights, in the mean of many places: kinks of cusps and of the grid are few.
#[test]
fn slopes_of_fine_structure_match_differences() {
    let (mut misses, mut all) = (0, 0);
    for seed in 0..6 {
        let (mut base, mut draw) = plain(seed);
        base.knots.sound_count = 2.0;
        base.machining.planer_um = draw(0.0, 10.0);
        base.machining.band_um = draw(0.0, 100.0);
        base.machining.circular_um = draw(0.0, 100.0);
        base.machining.teeth_um = draw(0.0, 20.0);
        base.grain.torn_um = draw(0.0, 200.0);
        base.grain.fuzzy_um = draw(0.0, 50.0);
        // Walls of vessels are as steep as their differences are wide: few of them.
        base.anatomy.pores_per_mm2 = draw(0.0, 3.0);
        let plank = grow(seed, &base);
        for _ in 0..400 {
            let (x, y) = (draw(-45.0, 45.0) as f32, draw(22.0, 225.0) as f32);
            let at = |dx: f32, dy: f32| plank.slice(y + dy).surface(x + dx).expect("inside");
            let here = at(0.0, 0.0);
            let h = 0.01;
            let [along_x, along_y] =
                [(at(h, 0.0).z - at(-h, 0.0).z) / (2.0 * h), (at(0.0, h).z - at(0.0, -h).z) / (2.0 * h)];
            all += 1;
            let far = |a: f32, b: f32| (a - b).abs() > 0.02 + 0.1 * a.abs();
            misses += i32::from(far(here.slope_x, along_x) || far(here.slope_y, along_y));
        }
    }
    assert!(misses < all / 20, "{misses} of {all}");
}

/// Grain tears around knots, where it dives, on one side of each, and nowhere far from them.
#[test]
fn grain_tears_where_it_dives() {
    let (mut near, mut far, mut torn) = (0, 0, 0);
    for seed in 0..8 {
        let (mut base, mut draw) = plain(seed);
        base.knots.sound_count = 3.0;
        let mut asked = base;
        asked.grain.torn_um = draw(50.0, 200.0);
        asked.grain.fuzzy_um = draw(10.0, 50.0);
        let (without, with) = (grow(seed, &base), grow(seed, &asked));
        for j in 0..400 {
            let y = 22.0 + 0.51 * j as f32;
            let (a, b) = (without.slice(y), with.slice(y));
            for i in 0..180 {
                let x = -45.0 + 0.5 * i as f32;
                let (za, zb) = (a.surface(x).expect("inside").z, b.surface(x).expect("inside").z);
                let m = a.matter(x, za);
                let changed = (za - zb).abs() > 0.01;
                torn += u32::from(changed);
                if crate::boards::dive_deg(&m) > 6.0 {
                    near += u32::from(changed)
                }
                if crate::boards::dive_deg(&m) < 2.0 && !crate::boards::is_knot(m.class) {
                    far += u32::from(changed)
                }
            }
        }
    }
    assert!(torn > 1000 && near > torn / 2 && far < torn / 20, "{torn}: {near} where it dives, {far} where not");
}

/// The share of the face that rays take is that of the volume at every angle, and flecks along the face are as long as
/// the angle between it and the rays has them.
#[test]
fn rays_keep_their_share_and_flecks_grow_towards_quarter_sawn_faces() {
    let mut chords = Vec::new();
    for (seed, degrees) in [(1_u64, 0.0_f64), (2, 30.0), (3, 60.0), (4, 85.0)] {
        let (mut total, mut rays, mut runs) = (0.0, 0.0, 0.0);
        for board in 0..6 {
            let (mut base, _) = plain(seed);
            (base.board.width_mm, base.board.length_mm) = (30.0, 60.0);
            let (sin, cos) = degrees.to_radians().sin_cos();
            (base.log.pith_depth_mm, base.log.pith_offset_mm) = (150.0 * cos + 11.0, 150.0 * sin);
            (base.log.pith_tilt_deg, base.log.pith_wander_mm, base.log.spiral_deg) = (0.0, 0.0, 0.0);
            let mut asked = base;
            (asked.anatomy.ray_share, asked.anatomy.ray_height_mm, asked.anatomy.ray_width_um) = (0.15, 3.0, 400.0);
            let (without, with) = (grow(10 * seed + board, &base), grow(10 * seed + board, &asked));
            for j in 0..120 {
                let y = 22.0 + 0.47 * j as f32;
                let (a, b) = (without.slice(y), with.slice(y));
                let mut inside = false;
                for i in 0..280 {
                    let x = -14.0 + 0.1 * i as f32;
                    let ray = a.matter(x, 22.0).medium.fibre != b.matter(x, 22.0).medium.fibre;
                    total += 1.0;
                    rays += f64::from(u8::from(ray));
                    runs += f64::from(u8::from(ray && !inside));
                    inside = ray;
                }
            }
        }
        // A fleck of a quarter-sawn face takes a part of it: 60 of them stand on six boards.
        let share = rays / total;
        let error = if degrees > 80.0 { 0.07 } else { 0.03 };
        assert!((share - 0.15_f64).abs() < error, "{share} at {degrees} deg");
        chords.push(0.1 * rays / runs);
    }
    // The mean chord of an ellipse's width w is pi w / 4 over the cosine: 0.31, 0.36 and 0.63 mm, and far more at 85
    // degrees.
    for (chord, expected) in chords.iter().zip([0.314, 0.363, 0.628]) {
        assert!((chord / expected - 1.0_f64).abs() < 0.2, "{chords:?}");
    }
    assert!(chords[3] > 1.2, "{chords:?}");
}

/// Tubes take the share of the face that their number and diameter say; canals keep to latewood, vessels of ring-porous
/// wood to earlywood.
#[test]
fn canals_and_vessels_are_as_many_as_asked() {
    for seed in 0..4 {
        let (base, mut draw) = plain(seed);
        let (number, um) = (draw(0.5, 4.0), draw(100.0, 250.0));
        let mut pores = base;
        (pores.anatomy.pores_per_mm2, pores.anatomy.pore_um) = (number, um);
        let mut canals = base;
        (canals.anatomy.canals_per_mm2, canals.anatomy.canal_um) = (number, um);
        let [base, pores, canals] = [base, pores, canals].map(|wood| grow(seed, &wood));
        let (mut total, mut open, mut resin, mut late) = (0.0, 0.0, 0.0, 0.0);
        for j in 0..500 {
            let y = 22.0 + 0.41 * j as f32;
            let [a, b, c] = [&base, &pores, &canals].map(|plank| plank.slice(y));
            for i in 0..300 {
                let x = -45.0 + 0.3 * i as f32;
                let [a, b, c] = [&a, &b, &c].map(|slice| slice.matter(x, 22.0).medium);
                total += 1.0;
                open += f64::from(u8::from(b.coat < 1.0));
                resin += f64::from(u8::from(c.n_eff > 1.3));
                late += f64::from(u8::from(c.n_eff > 1.3 && a.mu_a > 0.13));
            }
        }
        let share = number * std::f64::consts::FRAC_PI_4 * 1.0e-6 * um * um;
        // Tubes of some millimetres on 190 cm2: thousands of them.
        assert!((open / total / share - 1.0).abs() < 0.2, "seed {seed}: {} for {share}", open / total);
        assert!(resin < 0.8 * open && resin > 0.1 * open && late > 0.4 * resin, "seed {seed}: {resin} {late} {open}");
    }
}

/// Long edges leave their lines by the asked root mean square, and the board's bounds hold them.
#[test]
fn edges_wander_as_asked() {
    for seed in 0..10 {
        let (mut asked, mut draw) = plain(seed);
        asked.board.length_mm = 4000.0;
        asked.board.edge_wander_mm = draw(0.02, 2.0);
        let plank = grow(seed, &asked);
        let (low, high) = plank.bounds();
        let half = 0.5 * asked.board.width_mm;
        let mut squares = [0.0; 2];
        const PLACES: u32 = 800;
        for i in 0..PLACES {
            let y = low.y + (high.y - low.y) * (i as f32 + 0.5) / PLACES as f32;
            let slice = plank.slice(y);
            for (square, side) in squares.iter_mut().zip([-1.0, 1.0]) {
                // The border by halving: there is board in the middle, and none beyond the bounds.
                let (mut inside, mut outside) = (0.0, side * (high.x - low.x));
                for _ in 0..30 {
                    let middle: f32 = 0.5 * (inside + outside);
                    let is_board = slice.surface(asked.board.offset_mm as f32 + middle).is_some();
                    *if is_board { &mut inside } else { &mut outside } = middle;
                }
                let x = asked.board.offset_mm as f32 + inside;
                assert!(low.x <= x && x <= high.x, "seed {seed}: an edge at {x} mm leaves the bounds");
                *square += (f64::from(inside.abs()) - half).powi(2) / f64::from(PLACES);
            }
        }
        for square in squares {
            // Some 90 cells of 45 mm: the estimate is good to a tenth.
            let found = square.sqrt() / asked.board.edge_wander_mm;
            assert!((found - 1.0).abs() < 0.3, "seed {seed}: {found} of the asked wander");
        }
    }
}

/// Chips lower the face beside the arrises, by as much as their length says, and leave labels alone.
#[test]
fn arrises_chip_where_they_are() {
    let (mut changed, mut deepest) = (0, 0.0f32);
    for seed in 0..8 {
        let (mut base, mut draw) = plain(seed);
        base.wane.width_mm = if seed.is_multiple_of(2) { 0.0 } else { 6.0 };
        let mut asked = base;
        asked.marks.chip_count = 6.0;
        asked.marks.chip_mm = draw(4.0, 15.0);
        let (with, without) = (grow(seed, &asked), grow(seed, &base));
        let half = 0.5 * base.board.width_mm as f32;
        for _ in 0..20_000 {
            let (from_edge, y) = (draw(0.0, 25.0) as f32, draw(21.0, 229.0) as f32);
            let x = (half - from_edge) * if draw(-1.0, 1.0) < 0.0 { -1.0 } else { 1.0 };
            let look = |plank: &Plank| {
                let slice = plank.slice(y);
                let z = slice.surface(x).expect("inside").z;
                (z, slice.matter(x, z).class)
            };
            let ((z, class), (z0, class0)) = (look(&with), look(&without));
            assert_eq!(class, class0, "seed {seed}: a chip changes the label");
            assert!(z <= z0 + 1.0e-4, "seed {seed}: a chip raises the face");
            if z < z0 - 0.01 {
                changed += 1;
                deepest = deepest.max(z0 - z);
                // The widest of six lognormal chips, with the unevenness of its outline.
                assert!(f64::from(from_edge) < 0.25 * asked.marks.chip_mm * 3.5 * 1.8, "{from_edge} mm from the edge");
            }
        }
    }
    assert!(changed > 500 && deepest > 0.5, "{changed} points, the deepest by {deepest} mm");
}

/// Water takes scattering away and raises the index, in patches that cover about their own area, and colours nothing.
#[test]
fn wet_places_scatter_less() {
    let (mut covered, mut expected) = (0.0, 0.0);
    for seed in 0..12 {
        let (base, mut draw) = plain(seed);
        let mut asked = base;
        asked.moisture.patch_count = 3.0;
        asked.moisture.patch_mm = draw(8.0, 25.0);
        asked.moisture.filled = draw(0.1, 1.0);
        let (with, without) = (grow(seed, &asked), grow(seed, &base));
        let mut wet = 0;
        const POINTS: i32 = 3000;
        for _ in 0..POINTS {
            let (x, y) = (draw(-46.0, 46.0) as f32, draw(21.0, 229.0) as f32);
            let matter = |plank: &Plank| plank.slice(y).matter(x, 21.0);
            let (a, b) = (matter(&with), matter(&without));
            let (m, n) = (a.medium, b.medium);
            assert!(a.class == b.class && m.mu_a == n.mu_a && m.fibre == n.fibre);
            // All three follow from one share of full lumina.
            let filled = (1.0 - f64::from(m.k / n.k)) / 0.84;
            assert!(-1.0e-6 <= filled && filled <= asked.moisture.filled + 1.0e-5, "{filled}");
            assert!((f64::from(m.sigma_i / n.sigma_i) - (1.0 - 0.42 * filled)).abs() < 1.0e-5);
            let index = (f64::from(n.n_eff) + 0.72 * 0.33 * filled).min(1.55);
            assert!((f64::from(m.n_eff) - index).abs() < 1.0e-5);
            wet += i32::from(filled > 0.0);
        }
        covered += f64::from(wet) / f64::from(POINTS);
        // Ellipses three times as long as wide; some of each lies beside the board, and some overlap.
        let size: f64 = asked.moisture.patch_mm;
        expected += 3.0 * 0.25 * std::f64::consts::PI * 3.0 * size * size * 1.17 / (94.0 * 210.0);
    }
    assert!((0.4..1.2).contains(&(covered / expected)), "{covered} of {expected}");
}

/// A loose knot is a dead one with a gap as wide as asked and a face as low as asked.
#[test]
fn loose_knots_have_a_gap_and_have_sunk() {
    let mut ratios = [Vec::new(), Vec::new()];
    for seed in 0..10 {
        let (mut base, mut draw) = plain(seed);
        (base.knots.width_mm, base.knots.width_log_sd, base.knots.slope_deg) = (16.0, 0.0, 0.0);
        base.knots.slope_sd_deg = 0.0;
        base.knots.loose_count = 1.0;
        (base.knots.loose_gap_mm, base.knots.loose_sunk_mm) = (draw(0.2, 1.0), draw(0.2, 1.0));
        let plank = grow(seed, &base);
        let knot = plank.instances()[0];
        assert_eq!(knot.class, base::Class::LooseKnot);
        assert!(knot.death_radius_mm.is_finite() && knot.knot.is_some());
        let thickness = base.board.thickness_mm as f32;
        let sunk = base.knots.loose_sunk_mm as f32;
        let (mut open, mut all, mut inner) = (0.0, 0.0, Vec::new());
        for _ in 0..40_000 {
            let (dx, dy) = (draw(-12.0, 12.0) as f32, draw(-12.0, 12.0) as f32);
            let (x, y) = (knot.x_mm as f32 + dx, knot.y_mm as f32 + dy);
            let slice = plank.slice(y);
            let Some(face) = slice.surface(x) else { continue };
            let labelled = slice.matter(x, face.z).class == base::Class::LooseKnot;
            let depth = thickness - face.z;
            assert!(labelled || depth.abs() < 0.031, "seed {seed}: {depth} mm deep beside the knot");
            all += f64::from(u8::from(labelled));
            open += f64::from(u8::from(depth > 1.8 * sunk));
            if dx.hypot(dy) < 3.0 {
                inner.push(f64::from(depth));
            }
        }
        // A ring of width g in an ellipse of mean radius R takes 2 g / R of its area, less where its walls are not yet
        // deep.
        let radius = 0.5 * knot.diameter_mm;
        ratios[0].push(open / all / (2.0 * base.knots.loose_gap_mm / radius));
        ratios[1].push(inner.iter().sum::<f64>() / inner.len() as f64 / f64::from(sunk));
    }
    for (name, found) in ["gap", "sunk"].into_iter().zip(&ratios) {
        let mean = found.iter().sum::<f64>() / found.len() as f64;
        assert!((0.75..1.15).contains(&mean), "{name}: {mean} of what was asked, {found:?}");
    }
}

/// Knife marks have the asked root mean square, uneven as they are.
#[test]
fn planed_faces_have_the_asked_height() {
    let (mut squares, mut count) = (0.0, 0.0);
    for seed in 0..24 {
        let (mut wood, mut draw) = plain(seed);
        wood.board.length_mm = 1000.0;
        (wood.machining.planer_um, wood.machining.planer_pitch_mm) = (draw(2.0, 50.0), draw(0.8, 2.0));
        let plank = grow(seed, &wood);
        let column = heights(&plank, wood.board.thickness_mm, 3.0, (0..4000).map(|j| 25.0 + 0.247 * j as f32));
        squares += column.iter().map(|z| (1.0e3 * z / wood.machining.planer_um).powi(2)).sum::<f64>();
        count += column.len() as f64;
    }
    // Some 18 000 marks whose depths are alike over three, of squares with a spread of 0.75: 0.5 %.
    let rms = (squares / count).sqrt();
    assert!((rms - 1.0).abs() < 0.02, "{rms} of what was asked");
}

/// A saw is large enough for the board with its edges wherever they wander: slopes are those of the heights there too.
#[test]
fn circular_marks_have_their_slopes_along_edges_that_wander() {
    let mut beyond = 0;
    for seed in 0..24 {
        let (mut wood, mut draw) = plain(seed);
        (wood.board.width_mm, wood.board.edge_wander_mm) = (100.0, 3.0);
        (wood.machining.circular_um, wood.machining.circular_pitch_mm) = (100.0, 40.0);
        wood.machining.circular_radius_mm = 40.0;
        let plank = grow(seed, &wood);
        for _ in 0..2000 {
            let x = draw(50.5, 59.0) as f32 * if draw(-1.0, 1.0) < 0.0 { -1.0 } else { 1.0 };
            let slice = plank.slice(draw(25.0, 245.0) as f32);
            let h = 0.005;
            let at = |dx: f32| slice.surface(x + dx);
            let (Some(here), Some(left), Some(right)) = (at(0.0), at(-h), at(h)) else { continue };
            let numeric = (right.z - left.z) / (2.0 * h);
            // f32 has heights of 22 mm to 2e-6 mm.
            let off = (here.slope_x - numeric).abs();
            assert!(off < 3.0e-3 + 0.05 * numeric.abs(), "seed {seed} at {x}: {here:?}, and {numeric} by differences");
            beyond += 1;
        }
    }
    assert!(beyond > 1000, "{beyond} places");
}

/// Wane goes on over all that stands outside of it: no strip of full height is left where an edge wanders outwards.
#[test]
fn wane_goes_on_to_an_edge_that_wanders() {
    let mut beyond = 0;
    for seed in 0..12 {
        let (mut wood, mut draw) = plain(seed);
        (wood.board.edge_wander_mm, wood.wane.width_mm) = (1.0, 15.0);
        wood.wane.edge = if seed.is_multiple_of(2) { 1.0 } else { -1.0 };
        let plank = grow(seed, &wood);
        let half = 0.5 * wood.board.width_mm;
        for _ in 0..4000 {
            let (x, y) = ((wood.wane.edge * draw(half, half + 3.0)) as f32, draw(21.0, 229.0) as f32);
            let slice = plank.slice(y);
            let Some(face) = slice.surface(x) else { continue };
            let inner = slice.surface((wood.wane.edge * (half - 0.5)) as f32).expect("inside");
            // The line of the wane is wide enough at all but a few places.
            let class = slice.matter(x, face.z).class;
            let is_waned = inner.z < wood.board.thickness_mm as f32 - 0.5;
            assert!(!is_waned || (class == base::Class::Wane && face.z < inner.z + 0.8), "seed {seed}: ({x}, {y})");
            beyond += u32::from(is_waned);
        }
    }
    assert!(beyond > 5000, "{beyond} places beyond the nominal width");
}

/// What takes wood away leaves a sheet above the conveyor, however much is asked together; sound knots stand in sunk
/// decay, whose walls count where rays are hidden.
#[test]
fn sunk_decay_stays_above_the_conveyor_and_knots_stay() {
    let (mut lowest, mut in_knots) = (f32::INFINITY, 0);
    for seed in 0..8 {
        let (mut wood, mut draw) = plain(seed);
        (wood.rot.reach_mm, wood.rot.severity) = (60.0, 1.0);
        let holed = seed.is_multiple_of(2);
        if holed {
            (wood.knots.hole_count, wood.knots.hole_depth_mm) = (3.0, 50.0);
        } else {
            (wood.board.thickness_mm, wood.knots.sound_count) = (5.0, 3.0);
        }
        let whole = grow(seed, &wood);
        wood.rot.loss_mm = if holed { 4.0 } else { 8.0 };
        let plank = grow(seed, &wood);
        assert!(plank.relief() == Relief::Openings && (whole.relief() == Relief::Openings) == holed);
        let half = 0.5 * wood.board.width_mm;
        for _ in 0..20_000 {
            let (x, y) = (draw(-half, half) as f32, draw(21.0, 229.0) as f32);
            let (slice, before) = (plank.slice(y), whole.slice(y));
            let (face, was) = (slice.surface(x).expect("inside"), before.surface(x).expect("inside"));
            assert!(face.z > 0.299, "seed {seed}: ({x}, {y}) lies at {} mm", face.z);
            lowest = lowest.min(face.z);
            let inside = plank.instances().iter().any(|knot| {
                knot.class == base::Class::SoundKnot
                    && (f64::from(x) - knot.x_mm).hypot(f64::from(y) - knot.y_mm) < 0.4 * knot.diameter_mm - 1.5
            });
            if inside {
                assert!((face.z - was.z).abs() < 1.0e-3, "seed {seed}: a sound knot sinks by {}", was.z - face.z);
                in_knots += 1;
            }
        }
    }
    assert!(lowest < 0.31 && in_knots > 50, "{lowest} mm is the lowest, {in_knots} places in knots");
}

/// The depth of a loose knot is that of its deepest place, in the gap or on its face.
#[test]
#[ignore = "long"]
fn the_depth_of_a_loose_knot_is_its_greatest() {
    // Gap and sinking: the gap is deepest, the face is, and a gap wider than the knot.
    for (seed, (gap, sunk)) in [(0.3, 0.2), (0.05, 2.0), (3.0, 0.0)].into_iter().enumerate() {
        for more in 0..3 {
            let seed = 10 * seed as u64 + more;
            let (mut wood, _) = plain(seed);
            (wood.knots.loose_count, wood.knots.loose_gap_mm, wood.knots.loose_sunk_mm) = (1.0, gap, sunk);
            (wood.knots.width_mm, wood.knots.width_log_sd) = (if gap > 1.0 { 4.0 } else { 16.0 }, 0.0);
            let plank = grow(seed, &wood);
            let knot = plank.instances()[0];
            let mut deepest = 0.0f64;
            for j in -600..600 {
                let slice = plank.slice(knot.y_mm as f32 + 0.02 * j as f32);
                for i in -600..600 {
                    let Some(face) = slice.surface(knot.x_mm as f32 + 0.02 * i as f32) else { continue };
                    deepest = deepest.max(wood.board.thickness_mm - f64::from(face.z));
                }
            }
            let told = knot.depth_mm;
            assert!((deepest / told - 1.0).abs() < 0.06, "seed {seed}: {deepest} mm deep, {told} told");
        }
    }
}

/// Dents of a roller lie a pitch apart in the mean, as deep as asked at most, and no two are alike.
#[test]
fn dents_of_a_roller_wear() {
    for seed in 0..8 {
        let (mut wood, mut draw) = plain(seed);
        (wood.marks.roller_um, wood.marks.roller_pitch_mm) = (draw(80.0, 300.0), draw(3.0, 8.0));
        wood.marks.roller_width_mm = draw(12.0, 40.0);
        let (plank, pitch) = (grow(seed, &wood), wood.marks.roller_pitch_mm as f32);
        let dent = plank.instances().iter().find(|known| known.class == base::Class::RollerMark).expect("a roller");
        // The middle of the row that is nearer to the board's.
        let x = dent.x_mm - 0.25 * wood.marks.roller_width_mm * dent.x_mm.signum();
        let first = (25.0 / pitch).ceil();
        // The deepest point of each tooth's cell.
        let deepest = |tooth: usize| {
            let y = |i: usize| pitch * (first + tooth as f32 + i as f32 / 60.0);
            let depths =
                (0..60).flat_map(|i| heights(&plank, wood.board.thickness_mm, x as f32, std::iter::once(y(i))));
            -1.0e3 * depths.fold(0.0, f64::min) / wood.marks.roller_um
        };
        let depths: Vec<f64> = (0..20).map(deepest).collect();
        let mean = depths.iter().sum::<f64>() / 20.0;
        let sd = (depths.iter().map(|depth| (depth - mean).powi(2)).sum::<f64>() / 20.0).sqrt();
        assert!(depths.iter().all(|&depth| depth < 1.001) && mean > 0.2, "seed {seed}: {depths:?}");
        assert!(sd > 0.1 * mean, "seed {seed}: {mean} of the depth, spread {sd}");
    }
}
