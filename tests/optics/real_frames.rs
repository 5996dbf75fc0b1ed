//! A recipe fitted to public frames of a real camera stays inside what was measured on them (docs/theory/comparing.md).

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

/// The same across profiles, lags 1 and 2: 0.27 and 0.01 on the printed part.
const ACROSS: [std::ops::RangeInclusive<f64>; 2] = [0.2..=0.4, -0.05..=0.1];
/// Median contrast of level patches: 0.33 on the printed part, print included.
const CONTRAST: std::ops::RangeInclusive<f64> = 0.2..=0.36;

/// What `gen compare` says of the recipe's first sample on two thirds of its profiles.
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
    let [along, across] = [&found.noise_correlation[0], &found.noise_correlation[1]];
    let (along, across) = (along[1], [across[1], across[2]]);
    let [_, contrast, _] = found.contrast_sample.deciles().expect("there are level patches");
    println!(
        "missing {missing:.3}, floor {floor}, saturated {saturated:.3}, noise {noise:.1?} um, correlation {along:.3}, \
            {across:.3?}, contrast \
         {contrast:.3}"
    );
    assert!(MISSING.contains(&missing), "missing {missing}");
    assert!(FLOOR_DN.contains(&floor), "least reflectance {floor} DN");
    assert!(SATURATED.contains(&saturated), "saturated {saturated}");
    assert!(noise.iter().all(|um| NOISE_UM.contains(um)), "range noise {noise:?} um");
    assert!(ALONG.contains(&along), "correlation along the line {along}");
    let across_fits = ACROSS.iter().zip(across).all(|(range, lag)| range.contains(&lag));
    assert!(across_fits, "correlation across profiles {across:?}");
    assert!(CONTRAST.contains(&contrast), "contrast {contrast}");
}
