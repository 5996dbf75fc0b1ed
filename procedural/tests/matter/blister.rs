//! Packs from outside: determinism, surface, film, hull, and that every parameter does something.

use base::{BodyKind, Class, Matter, Parameter, Stream, Surface};
use glam::Vec3;
use procedural::blister::{Blister, Pack, Solid};

fn blister() -> Blister {
    Blister::from_values(&mut |p| p.default)
}

fn form(seed: u64, blister: &Blister) -> Pack {
    Pack::form(Stream::root(seed), blister)
}

/// What a pack answers, sampled.
#[derive(PartialEq)]
struct Answers {
    points: Vec<(Option<Surface>, Matter)>,
    hull: Vec<Vec3>,
    solids: Vec<Solid>,
    bounds: (Vec3, Vec3),
    /// As words, since numbers without meaning equal nothing.
    instances: String,
}

fn answers(pack: &Pack) -> Answers {
    const SIDE: usize = 130;
    let (low, high) = pack.bounds();
    let at = |low: f32, high: f32, k: usize| low + (high - low) * (k as f32 + 0.5) / SIDE as f32;
    let points = (0..SIDE * SIDE).map(|k| {
        let (x, slice) = (at(low.x, high.x, k % SIDE), pack.slice(at(low.y, high.y, k / SIDE)));
        (slice.surface(x), slice.matter(x, 0.0))
    });
    Answers {
        points: points.collect(),
        hull: pack.hull().positions,
        solids: pack.solids().to_vec(),
        bounds: (low, high),
        instances: format!("{:?}", pack.instances()),
    }
}

/// A pack on which every parameter has something to act on.
fn rich() -> Blister {
    let mut b = Blister::from_values(&mut |p| match p.group {
        "defects" if p.integer => 1.0,
        _ => p.default,
    });
    (b.card.width_mm, b.card.length_mm, b.card.columns, b.card.rows) = (110.0, 100.0, 4.0, 4.0);
    (b.card.pitch_x_mm, b.card.pitch_y_mm, b.card.perforation_mm) = (19.0, 18.0, 2.0);
    (b.tablet.length_mm, b.tablet.width_mm, b.tablet.thickness_mm) = (8.0, 7.0, 4.0);
    (b.pocket.headroom_mm, b.tablet.score_mm, b.tablet.coat) = (4.5, 0.2, 0.8);
    b
}

fn with(base: &Blister, changed: &Parameter, value: f64) -> Blister {
    let mut values = base.values().into_iter();
    Blister::from_values(&mut |p| {
        let (same, old) = values.next().expect("as many values as declarations");
        assert_eq!(same.path(), p.path());
        if p.path() == changed.path() { value } else { old }
    })
}

#[test]
fn every_parameter_has_an_effect() {
    let base = rich();
    let before = answers(&form(5, &base));
    for (parameter, value) in base.values() {
        // A tenth of the way to the farther end of the range, or one more; few tablets stand, so all shall.
        let end = if parameter.max - value > value - parameter.min { parameter.max } else { parameter.min };
        let step = if parameter.name == "on_edge" { 1.0 } else { 0.1 };
        let other = if parameter.integer { value + 1.0 } else { value + step * (end - value) };
        let after = answers(&form(5, &with(&base, parameter, other)));
        assert!(before != after, "{} does nothing from {value} to {other}", parameter.path());
    }
}

#[test]
fn a_pack_is_a_function_of_its_stream_and_numbers() {
    let base = rich();
    assert!(answers(&form(5, &base)) == answers(&form(5, &base)));
    assert!(answers(&form(5, &base)) != answers(&form(6, &base)));
}

#[test]
fn another_count_leaves_other_tablets_alone() {
    let mut base = blister();
    base.defects.missing = 1.0;
    let before = form(3, &base);
    for (missing, powder) in [(3.0, 0.0), (1.0, 4.0)] {
        let mut other = base;
        other.defects.missing = missing;
        other.defects.powder = powder;
        let after = form(3, &other);
        assert_eq!(after.solids().len(), 9 - missing as usize);
        assert!(after.solids().iter().all(|solid| before.solids().contains(solid)));
    }
}

#[test]
fn slopes_match_finite_differences() {
    for (shape, turn) in [(0.0, 0.0), (0.0, 25.0), (2.0, -40.0)] {
        let mut b = blister();
        (b.card.turn_deg, b.card.bow_mm, b.card.curl_mm, b.card.perforation_mm) = (12.0, 1.0, 0.7, 2.0);
        (b.tablet.shape, b.tablet.length_mm, b.tablet.width_mm, b.pocket.turn_deg) = (shape, 10.0, 7.0, turn);
        (b.defects.wrinkle, b.defects.delamination, b.defects.channel) = (2.0, 1.0, 2.0);
        let pack = form(2, &b);
        let (low, high) = pack.bounds();
        let h = 0.004_f32;
        let height = |x: f32, y: f32| pack.slice(y).surface(x).map(|s| s.z);
        let (mut seen, mut off) = (0, 0);
        for i in 0..20_000_u32 {
            let x = low.x + (i as f32 * 0.618_034).fract() * (high.x - low.x);
            let y = low.y + (i as f32 * 0.754_878).fract() * (high.y - low.y);
            let Some(s) = pack.slice(y).surface(x) else { continue };
            let around = [height(x + h, y), height(x - h, y), height(x, y + h), height(x, y - h)];
            let [Some(e), Some(w), Some(n), Some(f)] = around else { continue };
            let error = ((e - w) / (2.0 * h) - s.slope_x).abs().max(((n - f) / (2.0 * h) - s.slope_y).abs());
            // Where radius meets wall or roof the curvature jumps by 1/R (1 + s^2)^1.5, 70 mm^-1 at most, times h.
            assert!(error < 70.0 * h + 0.02, "{error} at {x}, {y}");
            seen += 1;
            off += u32::from(error > 0.02);
        }
        // Dots of the code, whose slopes are differences over 0.04 mm, and those jumps are all that may be off.
        assert!(seen > 10_000 && f64::from(off) < 0.02 * f64::from(seen), "{off} of {seen} slopes are off");
    }
}

#[test]
fn forming_keeps_the_volume_of_the_film() {
    for (shape, length, width) in [(0.0, 11.0, 11.0), (0.0, 13.0, 8.0), (1.0, 12.0, 6.0)] {
        let mut b = blister();
        (b.card.columns, b.card.rows, b.card.knurl_um, b.card.code_mm) = (1.0, 1.0, 0.0, 0.0);
        (b.card.width_mm, b.card.length_mm, b.card.corner_mm, b.card.bow_mm, b.card.curl_mm) =
            (26.0, 26.0, 0.0, 0.0, 0.0);
        (b.pocket.bumps_um, b.web.thinning_spread) = (0.0, 0.0);
        (b.tablet.shape, b.tablet.length_mm, b.tablet.width_mm) = (shape, length, width);
        let pack = form(1, &b);
        let (low, high) = pack.bounds();
        let n = 900;
        let (mut film, mut flat) = (0.0_f64, 0.0_f64);
        for j in 0..n {
            for i in 0..n {
                let share = |k: i32, low: f32, high: f32| low + (high - low) * (k as f32 + 0.5) / n as f32;
                let sheet = pack.sheet(share(i, low.x, high.x), share(j, low.y, high.y)).expect("a whole card");
                let s = sheet.surface;
                let stretched = f64::from(1.0 + s.slope_x * s.slope_x + s.slope_y * s.slope_y).sqrt();
                if !sheet.sealed {
                    film += f64::from(sheet.thickness_mm) * stretched;
                    flat += b.web.thickness_mm;
                }
            }
        }
        assert!((film / flat - 1.0).abs() < 0.01, "shape {shape}: {film} of {flat}");
    }
}

#[test]
fn the_thinnest_film_is_where_converters_find_it() {
    let pack = form(1, &blister());
    let (low, high) = pack.bounds();
    let mut thin = f32::MAX;
    for i in 0..40_000_u32 {
        let x = low.x + (i as f32 * 0.618_034).fract() * (high.x - low.x);
        let y = low.y + (i as f32 * 0.754_878).fract() * (high.y - low.y);
        if let Some(sheet) = pack.sheet(x, y) {
            thin = thin.min(sheet.thickness_mm);
        }
    }
    assert!((0.07..0.15).contains(&thin), "thinnest film {thin} mm");
}

#[test]
fn the_hull_is_closed_and_follows_the_surface() {
    let mut b = rich();
    (b.card.turn_deg, b.card.bow_mm) = (20.0, -1.0);
    let pack = form(3, &b);
    let hull = pack.hull();
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
    // The same volume from heights: the bottom is bent as the top is, so thickness over the conveyor's bend counts.
    let (low, high) = pack.bounds();
    let (mut sum, n) = (0.0_f64, 700);
    let half = hull.positions.len() / 2;
    for j in 0..n {
        for i in 0..n {
            let x = low.x + (high.x - low.x) * (i as f32 + 0.5) / n as f32;
            let y = low.y + (high.y - low.y) * (j as f32 + 0.5) / n as f32;
            if let (Some(sheet), (foil, _)) = (pack.sheet(x, y), pack.foil(x, y)) {
                sum += f64::from(sheet.surface.z - foil.z) + b.foil.thickness_mm;
            }
        }
    }
    let expected = sum * f64::from((high.x - low.x) * (high.y - low.y)) / f64::from(n * n);
    assert!((volume / expected - 1.0).abs() < 0.01, "{volume} for {expected} mm3");
    // Nowhere does the rim fall to the foil: film ends where the card does.
    let flange = (b.web.thickness_mm + b.foil.thickness_mm - 0.21) as f32;
    for (top, bottom) in hull.positions[..half].iter().zip(&hull.positions[half..]) {
        assert!(top.z - bottom.z > flange, "{top} over {bottom}");
    }
    let mut near = 0;
    for p in &hull.positions[..half] {
        assert!(p.z <= high.z && p.z >= low.z);
        if let (Some(surface), Some(_)) = (pack.slice(p.y).surface(p.x), pack.sheet(p.x, p.y)) {
            assert!((surface.z - p.z).abs() < 0.01, "hull at {p}, surface at {}", surface.z);
            near += 1;
        }
    }
    assert!(near > half * 9 / 10);
}

#[test]
fn pockets_hold_tablets_and_the_rest_is_flange() {
    let pack = form(1, &blister());
    assert_eq!((pack.instances().len(), pack.solids().len()), (9, 9));
    for (i, pocket) in pack.instances().iter().enumerate() {
        assert_eq!((pocket.id, pocket.class, pocket.state), (i as u16 + 1, Class::Pocket, Class::Pocket));
        let slice = pack.slice(pocket.y_mm as f32);
        let matter = slice.matter(pocket.x_mm as f32, 0.0);
        let film = matter.film.expect("film over a pocket");
        assert_eq!((matter.class, matter.instance), (Class::Pocket, pocket.id));
        assert!(!film.under.gloss.is_metal() && film.gap_mm.is_some_and(|gap| gap > 0.1 && gap < 1.6), "{film:?}");
    }
    let edge = pack.slice(6.5).matter(0.0, 0.0);
    let film = edge.film.expect("film over the flange");
    assert_eq!((edge.class, edge.instance, film.gap_mm), (Class::Flange, 0, None));
    assert!(film.under.gloss.is_metal());
}
