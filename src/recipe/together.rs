//! What the parameters of an object must mean together, and with the bench above it.

use std::collections::BTreeMap;

use super::dist::Distribution;
use super::table;
use crate::yaml::walk::{Walk, shown};

/// Least film between two pockets, and between a pocket and the card's edge [mm]: less would not seal.
const LEAST_SEAL_MM: f64 = 1.0;

/// The parameters of a class, or of the top level where `prefix` is empty.
pub(super) struct Together<'a> {
    /// Path of the class and a dot.
    pub prefix: &'a str,
    /// The top level's distributions.
    pub base: &'a BTreeMap<String, Distribution>,
    /// The class's own in place of them.
    pub overrides: &'a BTreeMap<String, Distribution>,
}

impl Together<'_> {
    fn distribution(&self, path: &str) -> Option<&Distribution> {
        self.overrides.get(path).or_else(|| self.base.get(path))
    }

    fn bounds(&self, path: &str) -> (f64, f64) {
        let parameter = table::parameters(None).find(|parameter| parameter.path() == path);
        let (distribution, parameter) =
            self.distribution(path).zip(parameter).unwrap_or_else(|| panic!("no table declares {path}"));
        distribution.bounds(parameter)
    }

    /// Smallest value that a draw can have.
    pub fn least(&self, path: &str) -> f64 {
        self.bounds(path).0
    }

    /// Largest value that a draw can have.
    pub fn most(&self, path: &str) -> f64 {
        self.bounds(path).1
    }

    /// Notes a fault of `keys` together, once: at the class's key where a class changes one, else at the top level's.
    pub fn fault(&self, walk: &mut Walk, keys: &[&str], problem: String, remedy: &str) {
        if self.prefix.is_empty() || keys.iter().any(|key| self.overrides.contains_key(*key)) {
            let own = keys.iter().map(|key| format!("{}{key}", self.prefix));
            let places: Vec<_> = own.chain(keys.iter().map(|key| (*key).to_owned())).collect();
            walk.joint_fault(&places, problem, remedy);
        }
    }

    /// Laser and camera stand above an object that can be `height` high, which follows from `keys` [mm].
    fn below_the_bench(&self, walk: &mut Walk, height: f64, keys: &[&str], noun: &str) {
        for stand in ["laser.fan_height_mm", "camera.distance_mm"] {
            let tilt = if stand.starts_with("camera") { self.most("camera.tilt_deg") } else { 0.0 };
            let lowest = self.least(stand) * libm::cos(tilt.to_radians());
            if lowest <= height {
                let problem = format!(
                    "stands {} mm high, and the {noun} can be {} mm thick",
                    shown(lowest),
                    shown(rounded(height))
                );
                let keys: Vec<_> = [stand].into_iter().chain(keys.iter().copied()).chain(["camera.tilt_deg"]).collect();
                self.fault(walk, &keys, problem, &format!("laser and camera must be above the {noun}"));
            }
        }
    }
}

/// A board.
pub(super) fn wood(walk: &mut Walk, scene: &Together) {
    let thickness = scene.most("board.thickness_mm");
    scene.below_the_bench(walk, thickness, &["board.thickness_mm"], "board");

    let keys = ["rot.edge"];
    let one = |values: Vec<f64>| values.iter().all(|edge| edge.abs() == 1.0);
    if !scene.distribution(keys[0]).and_then(Distribution::values).is_some_and(one) {
        let remedy = "give -1, 1 or {choice: {values: [-1, 1]}}";
        scene.fault(walk, &keys, "can be something other than -1 and 1".to_owned(), remedy);
    }
}

/// A blister pack.
pub(super) fn blister(walk: &mut Walk, scene: &Together) {
    let keys = ["tablet.band_mm", "tablet.thickness_mm"];
    let (band, thickness) = (scene.most(keys[0]), scene.least(keys[1]));
    if band > thickness {
        let problem = format!("the band can be {} mm of a tablet that is {} mm thick", shown(band), shown(thickness));
        scene.fault(walk, &keys, problem, "the straight side is at most the whole thickness");
    }
    let [foot_x, foot_y] = feet(scene);
    let tablet = ["tablet.length_mm", "tablet.width_mm", "pocket.clearance_mm", "pocket.turn_deg"];
    for (along, foot, pitch, count, size) in [
        ("the laser line", foot_x, "pack.pitch_x_mm", "pack.columns", "pack.width_mm"),
        ("the scan", foot_y, "pack.pitch_y_mm", "pack.rows", "pack.length_mm"),
    ] {
        let least = scene.least(pitch);
        let keys: Vec<_> = [pitch].into_iter().chain(tablet).collect();
        if scene.most(count) > 1.0 && foot + LEAST_SEAL_MM > least {
            let problem = format!(
                "pockets can be {} mm apart along {along}, and tablet and clearance {} mm",
                shown(least),
                shown(rounded(foot))
            );
            scene.fault(walk, &keys, problem, "leave at least 1 mm of film between pockets");
        }
        let whole = (scene.most(count) - 1.0) * scene.most(pitch) + foot + 2.0 * LEAST_SEAL_MM;
        let keys: Vec<_> = [size, count, pitch].into_iter().chain(tablet).collect();
        if whole > scene.least(size) {
            let problem = format!(
                "the card can be {} mm along {along}, and its pockets {} mm with 1 mm of film on each side",
                shown(scene.least(size)),
                shown(rounded(whole))
            );
            scene.fault(walk, &keys, problem, "make the card larger, or its pockets fewer, smaller or closer");
        }
    }
    let keys = ["tablet.thickness_mm", "pocket.headroom_mm", "pocket.dome_mm", "pack.bow_mm", "pack.curl_mm"];
    let height = keys.iter().map(|key| scene.most(key)).sum::<f64>() + scene.most("film.thickness_mm");
    scene.below_the_bench(walk, height, &keys, "pack");
}

/// Largest extent of a pocket's foot along the laser line and along the scan [mm].
fn feet(scene: &Together) -> [f64; 2] {
    let (length, width) = (scene.most("tablet.length_mm"), scene.most("tablet.width_mm"));
    let (low, high) = (scene.least("pocket.turn_deg"), scene.most("pocket.turn_deg"));
    // Between no turn and a right angle the extent goes one way, so its largest is at an end.
    let most = low.abs().max(high.abs());
    let least = if low <= 0.0 && high >= 0.0 { 0.0 } else { low.abs().min(high.abs()) };
    let extent = |turn: f64| {
        let (s, c) = (libm::sin(turn.to_radians()), libm::cos(turn.to_radians()));
        [(length * c, width * s), (length * s, width * c)].map(|(a, b)| (a * a + b * b).sqrt())
    };
    let (a, b) = (extent(least), extent(most));
    [0, 1].map(|i| a[i].max(b[i]) + 2.0 * scene.most("pocket.clearance_mm"))
}

/// To hundredths, for messages.
fn rounded(number: f64) -> f64 {
    (number * 100.0).round() / 100.0
}
