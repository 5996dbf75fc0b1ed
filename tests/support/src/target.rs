//! A bench at its nominal values and flat targets under it.

use std::sync::OnceLock;

use base::{Body, Medium};
use dataset::record::Record;
use optical_bench::parameters::Bench;
use pipeline;
use procedural::flat::Flat;
use recipe::{Recipe, Scene};
use scanner::optics::speckle::PatternCache;
use scanner::optics::{Band, Sensor};

/// Every number of the bench at its declared default.
pub fn nominal() -> Bench {
    Bench::default()
}

/// A scene of the nominal bench, 256 columns in the middle of the sensor.
pub fn scene(profiles: usize) -> Scene {
    let mut scene = Recipe::load("wood-small.yaml").expect("the embedded recipe loads").draw(0, 0);
    scene.bench = nominal();
    scene.size.columns = 256;
    scene.size.profiles = profiles;
    scene
}

/// Dense bright ceramic: light leaves within some thousandths of a mm of where it entered, so that the camera, which
/// sees it leave nearer to itself, reads heights right to 1 um.
pub fn ceramic() -> Medium {
    Medium::isotropic(5.0, 1500.0, 1.0, base::Gloss::NONE)
}

/// A wide plate: height at the origin [mm], dz/dx, dz/dy.
pub fn plate(medium: Medium, height_mm: f32, slope_x: f32, slope_y: f32) -> Body {
    Body::new(Flat { height_mm, slope_x, slope_y, width_mm: 400.0, length_mm: 400.0, medium })
}

/// Speckle patterns of seed 0, made once.
pub fn patterns() -> &'static PatternCache {
    static PATTERNS: OnceLock<PatternCache> = OnceLock::new();
    PATTERNS.get_or_init(|| PatternCache::new(0))
}

/// Renders a body in a scene.
pub fn render(scene: &Scene, body: Body) -> Record {
    pipeline::render_body(scene, body, patterns(), &|_| ())
}

/// The sensor over a body, and light of `profiles` worked out.
pub fn expose(scene: &Scene, body: Body, profiles: std::ops::Range<usize>) -> (Sensor, Band) {
    let (sensor, specimen) = pipeline::set_up(scene, body, patterns());
    let band = sensor.band(&specimen, profiles);
    (sensor, band)
}

/// Mean and standard deviation.
pub fn moments(values: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
    let n = values.clone().count() as f64;
    let mean = values.clone().sum::<f64>() / n;
    (mean, (values.map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt())
}
