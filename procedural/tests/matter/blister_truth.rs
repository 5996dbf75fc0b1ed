//! Pocket truth is exact under pose: tablets lie inside, nothing overlaps, what is lost matches its severity, masks lie
//! where their pockets are.

use base::{BodyKind, Class, Stream};
use procedural::blister::{Blister, Defects, Pack, Solid, extent};
use rand::RngExt;

fn form(seed: u64, blister: &Blister) -> Pack {
    Pack::form(Stream::root(seed), blister)
}

/// Places over a solid's box, `n` each way [mm].
fn over(solid: &Solid, n: u32) -> impl Iterator<Item = (f32, f32)> {
    let [low, high] = solid.bounds;
    let at = move |k: u32, low: f32, high: f32| low + (high - low) * (k as f32 + 0.5) / n as f32;
    (0..n * n).map(move |k| (at(k % n, low.x, high.x), at(k / n, low.y, high.y)))
}

/// Lowest and highest height of a solid above (x, y) [mm].
fn column(solid: &Solid, x: f32, y: f32) -> Option<[f32; 2]> {
    solid.span(glam::Vec3::new(x, y, 0.0), glam::Vec3::Z)
}

/// Whether every solid lies between foil and film and outside all others; `n` columns each way.
fn check_inside(pack: &Pack, n: u32, what: &str) {
    for (k, solid) in pack.solids().iter().enumerate() {
        let mut seen = 0;
        for (x, y) in over(solid, n) {
            let Some([low, high]) = column(solid, x, y) else { continue };
            seen += 1;
            let (foil, _) = pack.foil(x, y);
            assert!(low > foil.z - 2.0e-4, "{what}: solid {k} at {x}, {y}: {low} below the foil at {}", foil.z);
            if let Some(sheet) = pack.sheet(x, y) {
                let s = sheet.surface;
                let film = s.z - sheet.thickness_mm * (1.0 + s.slope_x * s.slope_x + s.slope_y * s.slope_y).sqrt();
                assert!(!sheet.sealed, "{what}: solid {k} ({:?}) under sealed film at {x}, {y}", solid.class);
                assert!(high < film + 2.0e-4, "{what}: solid {k} ({:?}) at {x}, {y}: {high} above {film}", solid.class);
            }
            for other in &pack.solids()[..k] {
                if let Some([from, to]) = column(other, x, y) {
                    assert!(low > to - 2.0e-4 || high < from + 2.0e-4, "{what}: solids overlap at {x}, {y}");
                }
            }
        }
        assert!(seen > 0 || n < 30, "{what}: solid {k} is nowhere");
    }
}

/// A pack that a packaging line could make, with some of every defect.
fn plausible(seed: u64) -> Blister {
    let mut rng = Stream::root(seed).child("plausible").rng();
    let mut b = Blister::from_values(&mut |p| if p.group == "defects" && p.integer { 1.0 } else { p.default });
    let mut even = |low: f64, high: f64| low + (high - low) * rng.random::<f64>();
    b.tablet.shape = even(-0.5, 2.5).round();
    (b.tablet.length_mm, b.tablet.width_mm) = if b.tablet.shape == 0.0 && even(0.0, 1.0) < 0.6 {
        let d = even(6.0, 13.0);
        (d, d)
    } else {
        (even(12.0, 19.0), even(5.5, 9.0))
    };
    b.tablet.thickness_mm = even(3.0, 6.0);
    b.tablet.band_mm = even(1.5, 4.0);
    (b.tablet.tilt_deg, b.tablet.on_edge) = (even(0.0, 25.0), 0.2);
    (b.pocket.clearance_mm, b.pocket.headroom_mm) = (even(0.3, 1.5), even(0.3, 3.0));
    (b.pocket.draft_deg, b.pocket.turn_deg) = (even(8.0, 30.0), even(-90.0, 90.0));
    (b.pocket.dome_mm, b.pocket.bumps_um) = (even(0.0, 1.5), even(0.0, 60.0));
    (b.card.width_mm, b.card.length_mm, b.card.columns, b.card.rows) = (90.0, 100.0, 3.0, 4.0);
    (b.card.bow_mm, b.card.curl_mm, b.card.turn_deg) = (even(-0.5, 0.5), even(-0.5, 0.5), even(-10.0, 10.0));
    b.defects.severity = even(0.1, 1.0);
    b
}

#[test]
#[ignore = "long"]
fn tablets_lie_inside_and_nothing_overlaps() {
    for seed in 0..200 {
        let b = plausible(seed);
        check_inside(&form(seed, &b), 32, &format!("seed {seed}"));
    }
}

/// No film rises above the height that is told beforehand, with two tablets in a pocket or with one.
#[test]
#[ignore = "long"]
fn no_pack_is_higher_than_was_told() {
    let mut closest = [0.0f64; 2];
    for seed in 0..120 {
        let mut b = plausible(seed);
        b.tablet.shape = (seed % 3) as f64;
        b.defects = Defects { severity: b.defects.severity, ..Defects::from_values(&mut |p| p.min) };
        for double in [0.0, 12.0] {
            b.defects.double = double;
            let (told, high) = (extent(&b).height_mm, f64::from(form(seed, &b).bounds().1.z));
            assert!(high <= told, "seed {seed}, {double} doubles: {high} of {told} mm");
            let kind = usize::from(double > 0.0);
            closest[kind] = closest[kind].max(high / told);
        }
    }
    // It is no idle bound.
    assert!(closest[0] > 0.9 && closest[1] > 0.7, "{closest:?}");
}

#[test]
#[ignore = "long"]
fn anything_that_the_recipe_allows_is_sane() {
    for seed in 0..120 {
        let mut rng = Stream::root(seed).child("extremes").rng();
        let mut b = Blister::from_values(&mut |p| match rng.random_range(0..3) {
            0 => p.min,
            1 => p.max,
            _ if p.integer => (p.min + (p.max - p.min) * rng.random::<f64>()).round(),
            _ => p.min + (p.max - p.min) * rng.random::<f64>(),
        });
        b.card.width_mm = b.card.width_mm.min(120.0);
        b.card.length_mm = b.card.length_mm.min(120.0);
        let pack = form(seed, &b);
        check_inside(&pack, 12, &format!("extreme {seed}"));
        let (low, high) = pack.bounds();
        assert!(low.is_finite() && high.is_finite() && low.cmplt(high).all());
        let told = extent(&b).height_mm;
        assert!(f64::from(high.z) <= told, "extreme {seed}: {} mm high, told {told}: {b:?}", high.z);
        assert!(pack.hull().positions.iter().all(|p| p.is_finite() && p.z <= high.z + 1.0e-3), "extreme {seed}");
        for _ in 0..400 {
            let (x, y) =
                (low.x + (high.x - low.x) * rng.random::<f32>(), low.y + (high.y - low.y) * rng.random::<f32>());
            let slice = pack.slice(y);
            let Some(s) = slice.surface(x) else { continue };
            assert!((s.z + s.slope_x + s.slope_y).is_finite() && s.z > -0.3, "extreme {seed}: {s:?} in {b:?}");
            let matter = slice.matter(x, 0.0);
            let instance = pack.instances().iter().find(|i| i.id == matter.instance);
            assert_eq!(instance.map_or(Class::Flange, |i| i.class), matter.class, "extreme {seed}");
            for m in [Some(matter.medium), matter.film.map(|film| film.under)].into_iter().flatten() {
                let sane = m.mu_a > 0.0 && m.sigma_i > 0.0 && (1.0..=1.6).contains(&m.n_eff) && m.coat > 0.0;
                assert!(sane && (m.mu_a + m.sigma_i).is_finite(), "extreme {seed}: {m:?}");
            }
            if let Some(film) = matter.film {
                let sane = film.thickness_mm > 0.0 && film.gap_mm.is_none_or(|gap| gap >= 0.0 && gap.is_finite());
                assert!(sane && film.under_slope.iter().all(|s| s.is_finite()), "extreme {seed}: {film:?}");
            }
        }
    }
}

/// Volume of solids over a pocket [mm^3].
fn volume(pack: &Pack, solids: &[&Solid]) -> f64 {
    let n = 500;
    assert!(!pack.solids().is_empty());
    solids
        .iter()
        .map(|solid| {
            let size = solid.bounds[1] - solid.bounds[0];
            let sum: f64 =
                over(solid, n).filter_map(|(x, y)| column(solid, x, y)).map(|[low, high]| f64::from(high - low)).sum();
            sum * f64::from(size.x * size.y) / f64::from(n * n)
        })
        .sum()
}

#[test]
fn what_is_lost_matches_the_severity() {
    for (seed, shape) in [(0, 0.0), (1, 1.0), (2, 2.0)] {
        let mut b = Blister::from_values(&mut |p| p.default);
        (b.tablet.shape, b.tablet.length_mm, b.tablet.width_mm) = (shape, 13.0, 8.0);
        (b.card.columns, b.defects.severity) = (2.0, 0.9);
        let whole = form(seed, &b);
        (b.defects.broken, b.defects.chipped) = (3.0, 3.0);
        let pack = form(seed, &b);
        let mut seen = 0;
        for defect in pack.instances().iter().filter(|i| i.within != 0) {
            let pocket = usize::from(defect.within) - 1;
            let (before, after) =
                (volume(&whole, &[&whole.solids()[pocket]]), volume(&pack, &[&pack.solids()[pocket]]));
            let share = match defect.class {
                Class::Broken => 0.2 + 0.6 * defect.severity,
                _ => 0.01 + 0.09 * defect.severity,
            };
            let lost = 1.0 - after / before;
            assert!((lost / share - 1.0).abs() < 0.01 || (lost - share).abs() < 3.0e-4, "{lost} for {share}");
            seen += 1;
        }
        assert_eq!(seen, 6);
    }
}

#[test]
fn masks_lie_within_their_pockets_and_every_defect_is_counted() {
    let mut pixels = std::collections::BTreeMap::new();
    for seed in 0..12 {
        let mut b = plausible(seed);
        (b.tablet.shape, b.tablet.length_mm, b.tablet.width_mm) = (0.0, 10.0, 10.0);
        b.defects.severity = 0.8;
        let pack = form(seed, &b);
        let instances = pack.instances();
        for (i, instance) in instances.iter().enumerate() {
            assert_eq!(usize::from(instance.id), i + 1);
            assert!(usize::from(instance.within) <= 12);
            assert!(instance.class == Class::Pocket || (0.0..=1.0).contains(&instance.severity), "{instance:?}");
        }
        let pockets = &instances[..12];
        for pocket in pockets {
            let worst = instances.iter().filter(|i| i.within == pocket.id).map(|i| i.severity).fold(f64::NAN, f64::max);
            if pocket.class == Class::Pocket && worst.is_finite() {
                assert!(pocket.severity == worst && pocket.state != Class::Pocket, "{pocket:?}");
            } else if pocket.class == Class::Shallow && pocket.state != Class::Shallow {
                // The tablet that was swept off.
                let inside = |solid: &Solid| {
                    let middle = 0.5 * (solid.bounds[0] + solid.bounds[1]);
                    let off = [f64::from(middle.x) - pocket.x_mm, f64::from(middle.y) - pocket.y_mm];
                    off[0].hypot(off[1]) < 5.0 && solid.instance == 0
                };
                assert!(pocket.state == Class::Missing && !pack.solids().iter().any(inside), "{pocket:?}");
            } else {
                assert_eq!(pocket.state, pocket.class);
            }
        }
        let (low, high) = pack.bounds();
        for j in 0..500 {
            let y = low.y + (high.y - low.y) * (j as f32 + 0.5) / 500.0;
            let slice = pack.slice(y);
            for i in 0..500 {
                let x = low.x + (high.x - low.x) * (i as f32 + 0.5) / 500.0;
                if slice.surface(x).is_none() {
                    continue;
                }
                let matter = slice.matter(x, 0.0);
                if matter.instance == 0 {
                    assert_eq!(matter.class, Class::Flange);
                    continue;
                }
                let instance = &instances[usize::from(matter.instance) - 1];
                assert_eq!(instance.class, matter.class);
                *pixels.entry(matter.class).or_insert(0) += 1;
                if instance.within != 0 && instance.class != Class::Channel {
                    let far = |p: &base::Instance| (p.x_mm - f64::from(x)).abs().max((p.y_mm - f64::from(y)).abs());
                    let nearest = pockets.iter().min_by(|a, b| far(a).total_cmp(&far(b))).expect("pockets");
                    assert_eq!(nearest.id, instance.within, "{instance:?} at {x}, {y}");
                    assert!(pack.sheet(x, y).is_none_or(|sheet| !sheet.sealed), "{instance:?} on sealed film");
                }
            }
        }
    }
    // Only a hole in the foil may have no pixels: it is small, and a tablet lies over it.
    let of_packs = |class: &Class| class.subject() == Some("blister") && *class != Class::Pinhole;
    for class in Class::ALL.into_iter().filter(of_packs) {
        assert!(class == Class::Flange || pixels.contains_key(&class), "{} is nowhere", class.name());
    }
}
