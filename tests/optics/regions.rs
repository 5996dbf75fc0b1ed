//! A region of a sample is to the bit what the whole scan has there.

use std::sync::atomic::{AtomicUsize, Ordering};

use optical_bench::settings::{Order, RangeForm, SensorStack};
use pipeline::{Equipment, PixelRegion, body, cropped, render_region, render_set_up, set_up};
use recipe::{Change, Recipe, Scene};
use scanner::optics::speckle::PatternCache;

/// A sample of a built-in recipe with these changes, as pictures have it: no pixels are put together.
fn scene(name: &str, changes: &[&str]) -> Scene {
    let changes: Vec<Change> = changes.iter().map(|change| change.parse().expect("it is a change")).collect();
    let mut scene = Recipe::load_changed(name, &changes).expect("the recipe loads").draw(3, 5);
    (scene.output.bin_columns, scene.output.bin_profiles) = (1, 1);
    scene.output.sensor_stack = SensorStack::None;
    scene
}

/// Faults a region that is another one than the part of the whole.
fn holds(name: &str, scene: &Scene) {
    let patterns = PatternCache::repeating(0);
    let equipment = Equipment { patterns: &patterns, line_solvers: |_, _| None };
    let (sensor, specimen) = set_up(scene, body(scene), equipment);
    let whole = render_set_up(scene, &sensor, &specimen, &|_| {});
    let (columns, profiles) = (scene.size.columns, scene.size.profiles);
    let regions = [
        PixelRegion { profiles: 0..1, columns: 0..1 },
        PixelRegion { profiles: 0..profiles, columns: 0..columns },
        PixelRegion::about([profiles / 2, columns / 2], [profiles / 3, columns / 3], scene.size),
        PixelRegion::about([profiles, columns], [37, 131], scene.size),
        PixelRegion { profiles: 11..profiles - 3, columns: columns / 2..columns / 2 + 1 },
    ];
    for region in regions {
        let (maps, labels) = render_region(scene, &sensor, &specimen, &region, &|| false).expect("nobody stops it");
        let rows = |map: &[f32]| {
            let rows = map.get(region.profiles.start * columns..region.profiles.end * columns).unwrap_or_default();
            cropped(rows, columns, &region.columns).iter().map(|value| value.to_bits()).collect::<Vec<_>>()
        };
        let bits = |map: &[f32]| map.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
        for (what, own, all) in [
            ("Range", &maps.range, &whole.maps.range),
            ("Reflectance", &maps.reflectance, &whole.maps.reflectance),
            ("Scatter", &maps.scatter, &whole.maps.scatter),
            ("grey", &maps.grey, &whole.maps.grey),
        ] {
            assert!(bits(own) == rows(all), "{name}: {what} in {region:?}");
        }
        let pixels = region.profiles.start * columns..region.profiles.end * columns;
        assert!(
            labels.class == cropped(&whole.labels.class[pixels.clone()], columns, &region.columns),
            "{name}: labels"
        );
        assert!(
            labels.instance == cropped(&whole.labels.instance[pixels], columns, &region.columns),
            "{name}: objects"
        );
    }
    let lit = whole.maps.reflectance.iter().filter(|value| **value > 0.0).count();
    assert!(lit > columns * profiles / 20, "{name}: {lit} pixels are lit");
}

/// Each kind of object, and what makes columns or profiles depend on each other: lamps, rectified Range, scripts.
#[test]
#[ignore = "long"]
fn a_region_is_a_part_of_the_whole() {
    let small = ["scan.profiles=96"];
    holds("wood", &scene("wood-small", &small));
    holds("lamps", &scene("wood-small", &["scan.profiles=96", "lamps.number=two", "output.exr=[grey]"]));
    holds("part", &scene("mesh-small", &small));
    let mut rectified = scene("sawtooth-small", &small);
    rectified.extraction.range = RangeForm::Rectified { pitch_mm: None };
    holds("rectified", &rectified);
    let pack = scene("blister-small", &["scan.columns=200", "scan.profiles=90"]);
    holds("pack", &pack);
    let scripted = scene("thesis/sawtooth", &["scan.columns=160", "scan.profiles=48", "transport=kernel"]);
    assert_ne!(scripted.postprocess.order, Order::Physical);
    holds("scripts", &scripted);
}

/// Regions at the edges of a scan are moved inwards, and none is larger than the scan.
#[test]
fn regions_lie_within_the_scan() {
    let size = scene("wood-small", &[]).size;
    let region = PixelRegion::about([0, size.columns], [100, 10_000], size);
    assert_eq!(region, PixelRegion { profiles: 0..100, columns: 0..size.columns });
    let region = PixelRegion::about([usize::MAX, 3], [1, 7], size);
    assert_eq!(region, PixelRegion { profiles: size.profiles - 1..size.profiles, columns: 0..7 });
}

/// A region ends soon after it is asked to.
#[test]
fn a_region_stops() {
    let scene = scene("wood-small", &[]);
    let patterns = PatternCache::repeating(0);
    let (sensor, specimen) = set_up(&scene, body(&scene), &patterns);
    let all = PixelRegion { profiles: 0..scene.size.profiles, columns: 0..scene.size.columns };
    let asked = AtomicUsize::new(0);
    let is_stopped = || asked.fetch_add(1, Ordering::Relaxed) >= 1;
    let made = render_region(&scene, &sensor, &specimen, &all, &is_stopped);
    assert!(made.is_none() && asked.into_inner() < 8, "bands were made after the stop");
}
