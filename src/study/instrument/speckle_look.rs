//! Looking at speckle: even and lined planes under the nominal bench, contrast, correlations and centres read off them.

use std::sync::Arc;

use procedural::Stream;

use super::beam::height_per_row;
use super::centre::spread;
use super::moments;
use super::pattern::{Correlation, grain_px};
use super::setup::{BARE, Look, bare, expose_to, gain, quiet, scene};
use super::speckle::{AHEAD, APART, BELOW, BROAD_MM, EVERY, LAGS, OWN, PIXELS, ROUND};
use crate::optics::speckle::{Stack, TILE, Tiles};
use crate::optics::{CENTRE, ROWS};
use crate::pipeline;
use crate::recipe::Scene;
use crate::settings::SpeckleLaw;

/// A white plane under the nominal bench, no noise but rounding.
pub(super) fn white(own: Stream, pixel_um: f64) -> Scene {
    let mut scene = scene(own, TILE, BARE + ROUND);
    scene.bench.motion.conveyor_reflectance = 1.0;
    scene.bench.camera.pixel_um = pixel_um;
    quiet(&mut scene);
    scene
}

/// The same lit by a broad line, so that many rows are alike.
fn broad(own: Stream, pixel_um: f64, tiles: &Tiles) -> Scene {
    let mut scene = white(own, pixel_um);
    scene.bench.laser.waist_mm = BROAD_MM;
    // Exponential light is seven times its mean once in a thousand.
    let peak = 230.0 / (1.0 + 6.0 * Correlation::of(grain_px(&scene.bench)).contrast());
    expose_to(&mut scene, &bare(), tiles, BARE, peak);
    scene
}

/// Rows about the line's middle that are looked at.
const MIDDLE: std::ops::Range<usize> = CENTRE - 11..CENTRE + 11;

/// Light over its mean, `[ROWS][TILE]` [1].
fn shades(scene: &Scene, look: &Look, light: &[f64], profile: usize) -> Vec<f64> {
    let (k, dark) = (gain(scene), scene.bench.exposure.dark_level_dn);
    let frame = look.frame(profile);
    frame.dn.iter().zip(light).map(|(&dn, e)| (f64::from(dn) - dark) / (k * e).max(1e-9)).collect()
}

/// Contrast of the pattern over a whole round, less what rounding and the least noise add [1].
pub(super) fn contrast(own: Stream, pixel_um: f64, tiles: &Tiles) -> f64 {
    let scene = broad(own, pixel_um, tiles);
    let k = gain(&scene);
    let (mut sum, mut squares, mut noise, mut n) = (0.0, 0.0, 0.0, 0.0);
    for profile in (BARE..BARE + ROUND).step_by(EVERY) {
        let look = Look::at(&scene, bare(), tiles, profile..profile + 1);
        let light = look.light(profile);
        let shades = shades(&scene, &look, &light, profile);
        for at in MIDDLE.start * TILE..MIDDLE.end * TILE {
            sum += shades[at];
            squares += shades[at] * shades[at];
            noise += (scene.bench.exposure.dark_noise_dn / (k * light[at])).powi(2);
            n += 1.0;
        }
    }
    let mean = sum / n;
    (squares / n - mean * mean - noise / n).max(0.0).sqrt() / mean
}

/// Correlations along the pattern and between profiles, of the sensor's own pixel.
pub(super) fn correlations(own: Stream, tiles: &Tiles) -> ([Vec<f64>; 2], Vec<Vec<f64>>) {
    let scene = broad(own, PIXELS[OWN], tiles);
    let last = BARE + ROUND + APART;
    let look = Look::at(&scene, bare(), tiles, BARE..last);
    let light = look.light(BARE);
    let all: Vec<Vec<f64>> = (BARE..last)
        .map(|profile| shades(&scene, &look, &light, profile).iter().map(|shade| shade - 1.0).collect())
        .collect();
    // Mean product of what lies `rows` and `columns` and `apart` profiles away.
    let product = |rows: i64, columns: usize, apart: usize| {
        let (mut sum, mut n) = (0.0, 0.0);
        for profile in 0..ROUND {
            let (here, there) = (&all[profile], &all[profile + apart]);
            for k in MIDDLE {
                let other = (k as i64 + rows) as usize;
                for c in 0..TILE - columns {
                    sum += here[k * TILE + c] * there[other * TILE + c + columns];
                }
            }
            n += (MIDDLE.len() * (TILE - columns)) as f64;
        }
        sum / n
    };
    let variance = product(0, 0, 0);
    let lags = [
        (1..=LAGS).map(|lag| product(0, lag, 0) / variance).collect(),
        (1..=LAGS).map(|lag| product(lag as i64, 0, 0) / variance).collect(),
    ];
    let profiles = (1..=APART).map(|n| AHEAD.map(|lag| product(lag, 0, n) / variance).collect()).collect();
    (lags, profiles)
}

/// Patterns for grains of about `grain` pixels: one of light from the surface, four of light from below.
pub(super) fn stack(tiles: &Tiles, grain: f64) -> Arc<Stack> {
    tiles.get(grain, SpeckleLaw::Exponential, [1.0, BELOW as f64])
}

/// Pixels of a pattern `apart` pixels from each other, of mean 1.
pub(super) fn law(tiles: &Tiles, grain: f64, which: usize, apart: usize) -> Vec<f64> {
    let stack = stack(tiles, grain);
    let rows = (0..stack.rows()).step_by(apart * stack.fine());
    rows.flat_map(|row| stack.row(0, row as i64)[which].iter().step_by(apart).map(|v| 1.0 + f64::from(*v))).collect()
}

/// Correlation of neighbouring columns of a pattern [1].
pub(super) fn neighbours(tiles: &Tiles, grain: f64) -> f64 {
    let pattern = law(tiles, grain, 0, 1);
    let pairs = pattern.chunks(TILE).flat_map(|row| row.windows(2).map(|pair| (pair[0] - 1.0) * (pair[1] - 1.0)));
    let squares = pattern.iter().map(|v| (v - 1.0).powi(2)).sum::<f64>();
    pairs.sum::<f64>() / squares * TILE as f64 / (TILE - 1) as f64
}

/// A plane of speckle alone under a line of half width `waist`; its contrast `strength` times the developed one.
pub(super) fn lined(own: Stream, waist: f64, strength: f64, tiles: &Tiles) -> Scene {
    let mut scene = white(own, PIXELS[OWN]);
    scene.size.profiles = BARE + 2 * ROUND;
    (scene.bench.laser.waist_mm, scene.bench.laser.waist_height_mm) = (waist, 0.0);
    scene.bench.speckle.strength = strength;
    scene.extraction.subpixel_steps = 0;
    // A whole number, so that rows without light are exact.
    scene.bench.exposure.dark_level_dn = 12.0;
    expose_to(&mut scene, &bare(), tiles, BARE, 110.0);
    scene
}

/// Spread of the line's centre, rounding and the least noise taken off [px].
pub(super) fn centre(scene: &Scene, tiles: &Tiles) -> f64 {
    let record = pipeline::render_body(scene, bare(), tiles, &|_| ());
    let range = record.maps.range[BARE * TILE..].iter().map(|&z| f64::from(z));
    let variance = moments(range).1 / height_per_row(&scene.bench, 0.0).powi(2);
    (variance - sum_of_line(scene, 0.0, tiles)).max(0.0).sqrt()
}

/// Light of the middle column before noise [DN].
pub(super) fn middle_line(scene: &Scene, tiles: &Tiles) -> Vec<f64> {
    let light = Look::at(scene, bare(), tiles, BARE..BARE + 1).light(BARE);
    (0..ROWS).map(|k| gain(scene) * light[k * TILE + TILE / 2]).collect()
}

/// What the sum over rows says of the centre's variance; without contrast that of rounding, in rows that have light [px^2].
pub(super) fn sum_of_line(scene: &Scene, contrast: f64, tiles: &Tiles) -> f64 {
    let line = middle_line(scene, tiles);
    let correlation = Correlation::of(grain_px(&scene.bench));
    if contrast > 0.0 {
        return spread(&line, scene.extraction.window_rows, 0.0, 0.0, contrast, &correlation);
    }
    let lit: Vec<f64> = line.into_iter().filter(|dn| *dn > 0.5).collect();
    spread(&lit, lit.len(), scene.bench.exposure.dark_noise_dn.powi(2), 0.0, 0.0, &correlation)
}

pub(super) fn skewness(values: &[f64]) -> f64 {
    let (mean, variance) = moments(values.iter().copied());
    values.iter().map(|v| (v - mean).powi(3)).sum::<f64>() / values.len() as f64 / (variance * variance.sqrt())
}

/// Centre of gravity of a correlation over those of [`AHEAD`] that are near its middle [px].
pub(super) fn middle(correlation: &[f64], near: f64) -> f64 {
    let lags = || AHEAD.map(|lag| lag as f64).zip(correlation).filter(|(lag, _)| (lag - near).abs() < 1.5);
    lags().map(|(lag, c)| lag * c).sum::<f64>() / lags().map(|(_, c)| c).sum::<f64>()
}
