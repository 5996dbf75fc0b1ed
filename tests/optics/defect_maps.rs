//! Masks of defects against measured maps: each board is rendered with a defect and without it, from the same streams,
//! and what differs must lie where the label says, show there, and show in the direction that physics gives.
//!
//! Boards of 15 x 11 mm, free of speckle and of shot noise; dark noise is the smallest there is and the same in both. A
//! pixel differs when Reflectance changes by more than [`REFLECTANCE_DN`], Scatter by more than [`SCATTER_SHARE`], or
//! Range by more than
//! [`RANGE_MM`] or is measured in one of the two alone. Light that enters in a defect leaves beside it: pixels within
//! `margin` of a mask may differ, and those beyond it may not, but for the share `beyond`. The margin is the reach of
//! scattered light, [`SCATTERED_MM`], for defects with a sharp border. Decay, stain and soaked wood fade over some
//! millimetres beyond their labels. An opening shades and hides what lies as far beside it as it is deep times the
//! tangents of camera and laser, and a knot parts fibres and bends rings up to four of its half widths from its axis.
//! Pixels within [`BORDER_MM`] of the board's outline are left out: a board with an opening hides itself by a grid of
//! 0.1 mm, one without by its hull, which moves its ends by less than that.
//!
//! One board of a kind is asked by default; `DEFECT_BOARDS=11` asks for 220 boards, as `make defect-maps` does.

use std::collections::BTreeMap;

use base::Class;
use dataset::record::Record;
use procedural::wood::Wood;
use recipe::{Plan, Recipe, Scene};
use test_support::target::patterns;

/// Change of Reflectance from which on a pixel differs [DN], of Scatter as a part of the board's median [1], of Range
/// [mm].
const REFLECTANCE_DN: f32 = 4.0;
const SCATTER_SHARE: f32 = 0.06;
const RANGE_MM: f32 = 0.03;
/// How far scattered light carries a visible change along the grain [mm].
const SCATTERED_MM: f64 = 3.0;
/// Width of the board's border, which is not looked at [mm].
const BORDER_MM: f64 = 0.25;
/// A class has to change its median by this part in the direction of the table [1], or Range by this [mm].
const LEAST_CHANGE: f64 = 0.04;
const LEAST_DROP_MM: f64 = 0.03;

/// What shows a class: the map, and the direction in which its median goes against the same place without the defect.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Shows {
    /// Absorption, a coat or walls that swallow light: the peak is darker.
    DarkerPeak,
    /// Less light leaves beside the line: absorption, or fibres that guide less of it.
    LessScatter,
    /// The surface is lower, or too deep to be seen.
    Lower,
}

/// A kind of defect.
struct Kind {
    class: Class,
    /// What the board has with and without it.
    rest: fn(&mut Wood),
    /// What asks for it.
    ask: fn(&mut Wood),
    shows: Shows,
    /// Beyond this from the mask pixels are alike [mm], but for this share of them [1].
    margin: f64,
    beyond: f64,
    /// Least share of mask pixels that differ, and least change of the median in the direction of the table [1].
    inside: f64,
    change: f64,
}

const NOTHING: fn(&mut Wood) = |_| ();

const fn kind(class: Class, ask: fn(&mut Wood), shows: Shows, margin: f64) -> Kind {
    Kind { class, rest: NOTHING, ask, shows, margin, beyond: 0.002, inside: 0.5, change: LEAST_CHANGE }
}

const KINDS: [Kind; 20] = [
    kind(Class::SoundKnot, |w| w.knots.sound_count = 1.0, Shows::LessScatter, 8.0),
    kind(Class::DeadKnot, |w| w.knots.dead_count = 1.0, Shows::LessScatter, 8.0),
    kind(Class::KnotHole, |w| (w.knots.hole_count, w.knots.hole_depth_mm) = (1.0, 4.0), Shows::Lower, 8.0),
    kind(Class::LooseKnot, |w| (w.knots.loose_count, w.knots.loose_sunk_mm) = (1.0, 0.5), Shows::Lower, 8.0),
    kind(Class::Rot, |w| w.rot.reach_mm = 5.0, Shows::LessScatter, SCATTERED_MM),
    Kind {
        // It fades into clear wood and is faint all over: a twentieth of its pixels differ by more than the bounds.
        inside: 0.0,
        change: 0.015,
        rest: |w| (w.rot.reach_mm, w.rot.severity, w.rot.rim_mm) = (2.0, 0.9, 0.0),
        ..kind(Class::IncipientDecay, |w| w.rot.incipient_mm = 3.0, Shows::LessScatter, SCATTERED_MM)
    },
    Kind {
        rest: |w| {
            (w.log.pith_depth_mm, w.log.pith_offset_mm, w.log.flipped) = (0.0, 0.0, 0.0);
            (w.log.pith_tilt_deg, w.log.pith_wander_mm) = (0.0, 0.2);
        },
        ..kind(Class::Pith, |w| w.log.pith_mm = 1.5, Shows::LessScatter, SCATTERED_MM)
    },
    kind(
        Class::CompressionWood,
        |w| (w.compression.severity, w.compression.width_mm) = (1.0, 4.0),
        Shows::LessScatter,
        SCATTERED_MM,
    ),
    kind(
        Class::BlueStain,
        |w| (w.stain.severity, w.stain.wedge_count, w.stain.wedge_deg, w.stain.length_mm) = (1.0, 1.0, 3.0, 6.0),
        Shows::LessScatter,
        SCATTERED_MM,
    ),
    kind(Class::ResinPocket, |w| pocket(w, 0), Shows::DarkerPeak, SCATTERED_MM),
    kind(
        Class::ResinStreak,
        |w| (w.inclusions.resin_streak_count, w.inclusions.width_mm, w.inclusions.streak_length_mm) = (1.0, 4.0, 10.0),
        Shows::DarkerPeak,
        SCATTERED_MM,
    ),
    kind(Class::BarkPocket, |w| pocket(w, 1), Shows::DarkerPeak, SCATTERED_MM),
    kind(Class::Check, |w| crack(w, 0), Shows::Lower, SCATTERED_MM),
    kind(Class::Shake, |w| crack(w, 1), Shows::Lower, SCATTERED_MM),
    kind(Class::Split, |w| crack(w, 2), Shows::Lower, SCATTERED_MM),
    kind(Class::InsectHole, |w| (w.holes.count, w.holes.frass) = (2.0, 0.0), Shows::Lower, SCATTERED_MM),
    kind(Class::Wane, |w| w.wane.width_mm = 4.0, Shows::Lower, SCATTERED_MM),
    kind(Class::Dirt, |w| (w.marks.dirt_count, w.marks.dirt_mm) = (1.0, 3.0), Shows::DarkerPeak, SCATTERED_MM),
    kind(Class::PlanerSkip, |w| (w.marks.skip_count, w.marks.skip_mm) = (1.0, 8.0), Shows::Lower, SCATTERED_MM),
    kind(Class::Burn, |w| (w.marks.burn_count, w.marks.burn_mm) = (1.0, 3.0), Shows::DarkerPeak, SCATTERED_MM),
];

fn pocket(wood: &mut Wood, which: usize) {
    let asked = &mut wood.inclusions;
    *[&mut asked.resin_pocket_count, &mut asked.bark_pocket_count][which] = 1.0;
    (asked.length_mm, asked.width_mm, asked.thickness_mm) = (6.0, 4.0, 1.5);
}

fn crack(wood: &mut Wood, which: usize) {
    let asked = &mut wood.cracks;
    *[&mut asked.check_count, &mut asked.shake_count, &mut asked.split_count][which] = 1.0;
    (asked.length_mm, asked.width_mm, asked.depth_mm) = (6.0, 0.6, 3.0);
}

/// A quiet scene of a clear board.
fn scene(recipe: &Recipe, kind: &Kind, index: u64) -> Scene {
    let mut scene = recipe.draw(23, index);
    scene.output.truth_maps = false;
    scene.bench.speckle.strength = 0.0;
    let exposure = &mut scene.bench.exposure;
    (exposure.shot_noise, exposure.dark_noise_dn, exposure.row_noise_dn) = (0.0, 0.3, 0.0);
    (exposure.row_pattern_dn, exposure.column_pattern_dn, exposure.dsnu_dn, exposure.prnu) = (0.0, 0.0, 0.0, 0.0);
    let Plan::Wood(wood) = &mut scene.plan else { panic!("a recipe of wood") };
    (wood.board.width_mm, wood.board.length_mm) = (15.0, 11.0);
    (scene.size.columns, scene.size.profiles) = (184, 192);
    (wood.knots.sound_count, wood.knots.dead_count, wood.rot.reach_mm) = (0.0, 0.0, 0.0);
    (wood.knots.width_mm, wood.knots.width_log_sd) = (2.0, 0.0);
    (kind.rest)(wood);
    scene
}

/// Distance of each pixel from the nearest of a mask [mm], at most `most`.
fn distances(mask: &[bool], record: &Record, most: f64) -> Vec<f64> {
    let cols = record.cols;
    // Along each row first, then along columns: the squared distance is the least sum of both.
    let mut along = vec![f64::INFINITY; mask.len()];
    for (line, out) in mask.chunks(cols).zip(along.chunks_mut(cols)) {
        let mut last = f64::INFINITY;
        for (marked, out) in line.iter().zip(out.iter_mut()) {
            last = if *marked { 0.0 } else { last + record.col_mm };
            *out = last;
        }
        let mut last = f64::INFINITY;
        for (marked, out) in line.iter().zip(out.iter_mut()).rev() {
            last = if *marked { 0.0 } else { last + record.col_mm };
            *out = out.min(last);
        }
    }
    let reach = (most / record.row_mm).ceil() as usize;
    (0..mask.len())
        .map(|i| {
            let (row, col) = (i / cols, i % cols);
            let near = row.saturating_sub(reach)..(row + reach + 1).min(record.rows);
            near.map(|r| along[r * cols + col].hypot(record.row_mm * r.abs_diff(row) as f64)).fold(most, f64::min)
        })
        .collect()
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// What one kind's boards show.
#[derive(Debug, Default)]
struct Seen {
    /// Share of mask pixels that differ [1], by board.
    inside: Vec<f64>,
    /// Pixels beyond the margin, and those of them that differ.
    beyond: [usize; 2],
    /// Largest distance at which all but one of a thousand pixels beside the mask are alike [mm].
    reach: Vec<f64>,
    /// Changes of Reflectance [1], Scatter [1] and Range [mm] inside; lost pixels count as deep.
    changes: [Vec<f64>; 3],
    /// Instances without a pixel, and all.
    empty: [usize; 2],
}

fn compare(kind: &Kind, with: &Record, without: &Record, asked: usize, seen: &mut Seen) {
    let mask: Vec<bool> = with.labels.class.iter().map(|&class| class == kind.class as u8).collect();
    let clear = |map: &[f32]| {
        let values = map.iter().zip(&without.labels.class).filter(|(_, class)| **class == Class::Clear as u8);
        median(values.map(|(v, _)| f64::from(*v)).collect())
    };
    let [peak, beside] = [clear(&without.maps.reflectance), clear(&without.maps.scatter)];
    let distances = distances(&mask, with, kind.margin + 4.0);
    let background = |i: usize| [with, without].iter().any(|record| record.labels.class[i] == Class::Background as u8);
    let outside: Vec<bool> = (0..mask.len()).map(background).collect();
    let border = self::distances(&outside, with, BORDER_MM);
    let (mut inside, mut far) = ([0, 0], Vec::new());
    for (i, &distance) in distances.iter().enumerate() {
        if border[i] < BORDER_MM && !mask[i] {
            continue;
        }
        let pair = |of: fn(&Record) -> &[f32]| [of(with)[i], of(without)[i]];
        let (r, s, z) = (pair(|m| &m.maps.reflectance), pair(|m| &m.maps.scatter), pair(|m| &m.maps.range));
        let lost = z[0].is_nan() != z[1].is_nan();
        let differs = lost
            || (r[0] - r[1]).abs() > REFLECTANCE_DN
            || (s[0] - s[1]).abs() > SCATTER_SHARE * beside as f32
            || (z[0] - z[1]).abs() > RANGE_MM;
        if mask[i] {
            inside = [inside[0] + 1, inside[1] + usize::from(differs)];
            seen.changes[0].push(f64::from(r[0] - r[1]) / peak);
            seen.changes[1].push(f64::from(s[0] - s[1]) / beside);
            seen.changes[2].push(if z[0].is_nan() {
                -10.0
            } else if z[1].is_nan() {
                0.0
            } else {
                f64::from(z[0] - z[1])
            });
        } else {
            if distance > kind.margin {
                seen.beyond = [seen.beyond[0] + 1, seen.beyond[1] + usize::from(differs)];
            }
            if differs {
                far.push(distance);
            }
        }
    }
    far.sort_by(f64::total_cmp);
    let spare = distances.len() / 1000;
    seen.reach.push(if far.len() > spare { far[far.len() - 1 - spare] } else { 0.0 });
    seen.inside.push(inside[1] as f64 / f64::from(inside[0].max(1) as u32));
    let shown = with.objects.iter().filter(|object| object.instance.class == kind.class).count();
    seen.empty = [seen.empty[0] + asked - shown, seen.empty[1] + asked];
}

#[test]
#[ignore = "long"]
fn masks_are_where_maps_change() {
    let boards: u64 = std::env::var("DEFECT_BOARDS").ok().and_then(|n| n.parse().ok()).unwrap_or(1);
    let recipe = Recipe::load("wood-small.yaml").expect("the embedded recipe loads");
    let mut missed = Vec::new();
    let mut plain: BTreeMap<u64, (Scene, Record)> = BTreeMap::new();
    for kind in &KINDS {
        let mut seen = Seen::default();
        for index in 0..boards {
            let scene = scene(&recipe, kind, index);
            let mut asked = scene.clone();
            let Plan::Wood(wood) = &mut asked.plan else { panic!("a recipe of wood") };
            (kind.ask)(wood);
            let with = pipeline::render(&asked, patterns(), &|_| ());
            // Most kinds share the board without.
            if plain.get(&index).is_none_or(|(known, _)| *known != scene) {
                plain.insert(index, (scene.clone(), pipeline::render(&scene, patterns(), &|_| ())));
            }
            let without = &plain[&index].1;
            let defects = with.defects.iter().chain(&with.unseen);
            let count = defects.filter(|class| **class == kind.class).count();
            assert!(count > 0, "{:?} {index}: nothing was asked for", kind.class);
            compare(kind, &with, without, count, &mut seen);
        }
        let [beyond, differ] = seen.beyond;
        let outside = differ as f64 / beyond.max(1) as f64;
        let reach = seen.reach.iter().copied().fold(0.0, f64::max);
        let least = seen.inside.iter().copied().fold(1.0, f64::min);
        let [peak, scatter, range] = seen.changes.map(median);
        println!(
            "{:?}: {:.2} of mask pixels differ (least board {least:.2}), {outside:.5} of {beyond} beyond {} mm, reach \
                {reach:.2} mm; \
             median change {:+.0} % Reflectance, {:+.0} % Scatter, {range:+.3} mm Range; {} of {} empty",
            kind.class,
            median(seen.inside.clone()),
            kind.margin,
            100.0 * peak,
            100.0 * scatter,
            seen.empty[0],
            seen.empty[1],
        );
        let shows = match kind.shows {
            Shows::DarkerPeak => peak < -kind.change,
            Shows::LessScatter => scatter < -kind.change,
            Shows::Lower => range < -LEAST_DROP_MM,
        };
        if least < kind.inside || outside > kind.beyond || !shows || seen.empty[0] > 0 {
            missed.push(kind.class);
        }
    }
    assert!(missed.is_empty(), "{missed:?}");
}
