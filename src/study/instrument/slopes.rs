//! The sensor's second slope: numbers and noise over light, for each mode.
//!
//! The patch of the study of the sensor is exposed for 0.03 to 20 times the light that fills a pixel with one slope. What
//! theory says is the closed form of [`crate::optics::sensor`]: B + r phi above the knee, with the noise of r phi.

use serde_json::{Value, json};

use super::sensor::{Full, patch};
use super::setup::{BARE, gain};
use crate::optics::speckle::Tiles;
use crate::settings::{Hdr, Readout};

/// Exposures at each level, the number of levels, and the least and the most light [full wells].
const EXPOSURES: usize = 12;
const LEVELS: usize = 27;
const LIGHT: [f64; 2] = [0.03, 20.0];

/// One mode.
pub(super) struct Mode {
    pub hdr: Hdr,
    /// Light [full wells], mean over dark [DN], variance in time [DN^2] at each level, as measured.
    pub seen: Vec<[f64; 3]>,
    /// The same by theory, up to the light that fills a pixel.
    pub expected: Vec<[f64; 3]>,
}

/// Every mode.
pub(super) fn modes(full: &Full, tiles: &Tiles) -> Vec<Mode> {
    Hdr::ALL.into_iter().map(|hdr| mode(full, hdr, tiles)).collect()
}

fn light(level: usize) -> f64 {
    LIGHT[0] * libm::pow(LIGHT[1] / LIGHT[0], level as f64 / (LEVELS - 1) as f64)
}

fn mode(full: &Full, hdr: Hdr, tiles: &Tiles) -> Mode {
    let exposure = full.scene.bench.exposure;
    let one = |level: usize| {
        let mut scene = full.scene.clone();
        scene.readout = Readout { bits: 8, hdr };
        scene.bench.exposure.time_us *= light(level);
        let [mean, variance] = patch(&scene, BARE + level * EXPOSURES, EXPOSURES, tiles);
        [light(level), mean - exposure.dark_level_dn, variance]
    };
    let most = 255.0 - exposure.dark_level_dn;
    let rest = 0.5 / hdr.gain();
    let still = exposure.dark_noise_dn.powi(2) - exposure.row_pattern_dn.powi(2);
    let theory = |i: usize| {
        let phi = LIGHT[0] * libm::pow(hdr.gain() / LIGHT[0], i as f64 / 100.0);
        let bent = hdr != Hdr::None && phi * (1.0 - rest) > 0.5;
        let (level, noisy) = if bent { (0.5 + rest * phi, rest * phi) } else { (phi, phi) };
        [phi, most * level, still + gain(&full.scene) * most * noisy]
    };
    Mode { hdr, seen: (0..LEVELS).map(one).collect(), expected: (0..=100).map(theory).collect() }
}

/// For the study's document.
pub(super) fn document(modes: &[Mode]) -> Value {
    let row = |[light, mean, variance]: &[f64; 3]| json!({ "light_full_wells": light, "mean_dn": mean, "variance_dn2": variance });
    let one = |mode: &Mode| json!({ "hdr": mode.hdr.name(), "levels": mode.seen.iter().map(row).collect::<Vec<_>>() });
    modes.iter().map(one).collect()
}
