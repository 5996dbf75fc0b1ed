//! A recipe fitted to public frames of a real camera stays inside what was measured on them (docs/compare.md).

use recipe::Recipe;
use scanner::optics::speckle::PatternCache;
use tools::compare::{ScanMaps, ScanStatistics, StatisticsBuilder};

/// Robust noise of heights in either direction, both frames [um].
const NOISE_UM: std::ops::RangeInclusive<f64> = 11.0..=33.0;
/// Share of missing heights, both frames [1].
const MISSING: std::ops::RangeInclusive<f64> = 0.001..=0.37;
/// Least digital number beside a height: the threshold of detection, both frames [DN].
const FLOOR_DN: std::ops::RangeInclusive<f64> = 20.0..=21.0;
/// Share of heights with a saturated peak, both frames [1].
const SATURATED: std::ops::RangeInclusive<f64> = 0.45..=0.9;
/// Correlation of the noise of neighbours along the line: 0.45 to 0.48 on the printed part, by how edges are left out.
const ALONG: std::ops::RangeInclusive<f64> = 0.38..=0.55;

/// What `gen compare` says of the recipe's first sample on three fifths of its profiles.
fn statistics() -> ScanStatistics {
    let mut scene = Recipe::load("recipes/real/plastic-tray.yaml").expect("the recipe loads").draw(0, 0);
    scene.size.profiles = 300;
    let record = pipeline::render(&scene, &PatternCache::new(0), &|_| ());
    let frame = ScanMaps {
        cols: record.cols,
        rows: record.rows,
        range: record.maps.range.iter().map(|&z| f64::from(z)).collect(),
        reflectance: Some(record.maps.reflectance),
        ..ScanMaps::default()
    };
    let mut builder = StatisticsBuilder::new("plastic-tray");
    builder.add(&frame);
    builder.statistics()
}

#[test]
fn a_fitted_recipe_looks_like_real_frames() {
    let found = statistics();
    let missing = found.missing.expect("there are pixels");
    let floor = found.least_reflectance.expect("there are heights");
    let saturated = found.saturated.expect("there are heights");
    let noise = found.noise.map(|um| um.expect("there is noise"));
    let along = found.noise_correlation[0][1];
    println!(
        "missing {missing:.3}, floor {floor}, saturated {saturated:.3}, noise {noise:.1?} um, correlation {along:.3}"
    );
    assert!(MISSING.contains(&missing), "missing {missing}");
    assert!(FLOOR_DN.contains(&floor), "least reflectance {floor} DN");
    assert!(SATURATED.contains(&saturated), "saturated {saturated}");
    assert!(noise.iter().all(|um| NOISE_UM.contains(um)), "range noise {noise:?} um");
    assert!(ALONG.contains(&along), "correlation along the line {along}");
}
