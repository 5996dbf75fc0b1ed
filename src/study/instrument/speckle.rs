//! Speckle as production makes it, against the theory of [`super::pattern`].
//!
//! - Contrast in frames of an evenly lit white plane without noise, for eight pixels from 1.2 to 12 um.
//! - The law of one pixel, read off the pattern itself ([`Tiles`]) at pixels far enough apart to be independent: distance of
//!   Kolmogorov and Smirnov to the gamma law. The pattern is kept at mean 0 and spread 1, so mean and contrast of a
//!   pixel are imposed; shape and skewness are its own.
//! - Correlation along columns and rows, and between profiles: the pattern lies on the object, so that profile n + j shows
//!   that of profile n moved by j step rows/mm rows.
//! - Spread of the line's centre on a plane of speckle alone, through production's Range.
//!
//! Repeats have patterns of their own, since all columns and profiles of one share a pattern of 128 by 128 pixels.

use procedural::Stream;
use serde_json::json;

use super::beam::rows_per_mm;
use super::pattern::{Correlation, grain_px};
use super::setup::{BARE, Look, bare, expose_to, gain, quiet, scene, stream};
use super::triangulation::{height_per_row, spread};
use super::{Figure, Trials, chance, document, each, moments, repeat, speckle_page, table};
use crate::optics::speckle::{FINE, TILE, Tiles};
use crate::optics::{CENTRE, ROWS};
use crate::pipeline;
use crate::recipe::Scene;
use crate::study::{Report, Watch};
use crate::transport::answer::Estimate;

/// Pixels whose contrast is measured [um].
pub(super) const PIXELS: [f64; 8] = [1.2, 2.4, 3.45, 4.8, 5.5, 6.0, 9.0, 12.0];
/// The sensor's own.
const OWN: usize = 5;
/// Profiles that go once around a pattern, and those whose contrast is taken: together they show all of it.
const ROUND: usize = 190;
const EVERY: usize = 27;
/// Largest lag in pixels, and largest number of profiles apart.
pub(super) const LAGS: usize = 4;
pub(super) const APART: usize = 5;
/// Lags between profiles, in rows, that are looked at.
const AHEAD: std::ops::RangeInclusive<i64> = -2..=6;
/// Scales of contrast at which the line's centre is measured.
pub(super) const STRENGTHS: [f64; 3] = [0.25, 0.5, 1.0];
/// Waists of the lines whose centre is measured [mm].
pub(super) const WAISTS: [f64; 3] = [0.05, 0.1, 0.2];

struct Found {
    /// Contrast by pixel [1].
    contrast: Vec<f64>,
    /// Correlation at lags 1.. along columns and along rows [1].
    lags: [Vec<f64>; 2],
    /// Correlation between profiles by distance and lag, over that at lag 0 [1].
    profiles: Vec<Vec<f64>>,
    /// Independent pixels of the pattern at 6 um, for light from the surface and from below, and at 1.2 um [1].
    laws: [Vec<f64>; 3],
    /// Spread of the line's centre by waist and strength [px].
    centre: Vec<Vec<f64>>,
}

/// Everything that the picture shows.
pub(super) struct Seen {
    pub contrast: Vec<Estimate>,
    pub lags: [Vec<Estimate>; 2],
    /// Lag less movement, correlation, and number of profiles apart [px, 1].
    pub profiles: Vec<(f64, Estimate, usize)>,
    pub laws: [(Vec<f64>, f64); 3],
    /// Spread of the line's centre by waist and strength, what the sum over rows says of it, and the line's own width [px].
    pub centre: Vec<Vec<Estimate>>,
    pub sum: Vec<Vec<f64>>,
    pub line_px: Vec<f64>,
    pub own: Correlation,
    pub grain_um: f64,
    /// The pattern of the sensor's own pixels and that of 1.2 um, [rows, TILE] from fine rows a pixel apart [1].
    pub patterns: [Vec<f64>; 2],
}

/// Makes the study.
pub fn study(trials: Trials, watch: Watch) -> Report {
    let found = repeat(trials, watch, |one| found(trials, one));
    let (figures, seen) = figures(trials, &found);
    let table = table("Speckle", trials, &figures, &[]);
    let mut json = document("speckle", trials, &figures);
    json["pixels_um"] = json!(PIXELS);
    json["contrast"] = json!(seen.contrast);
    json["between_profiles"] = seen.profiles.iter().map(|(lag, c, n)| json!({ "profiles": n, "lag_less_movement_px": lag, "correlation": c })).collect();
    Report { picture: speckle_page::draw(&seen, &table), table, json }
}

/// A white plane under the nominal bench, no noise but rounding.
fn white(own: Stream, pixel_um: f64) -> Scene {
    let mut scene = scene(own, TILE, BARE + ROUND);
    scene.bench.motion.conveyor_reflectance = 1.0;
    scene.bench.camera.pixel_um = pixel_um;
    quiet(&mut scene);
    scene
}

/// The same lit by a broad line, so that many rows are alike.
fn broad(own: Stream, pixel_um: f64, tiles: &Tiles) -> Scene {
    let mut scene = white(own, pixel_um);
    scene.bench.laser.waist_mm = 2.0;
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
fn contrast(own: Stream, pixel_um: f64, tiles: &Tiles) -> f64 {
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
fn correlations(own: Stream, tiles: &Tiles) -> ([Vec<f64>; 2], Vec<Vec<f64>>) {
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

/// Pixels of a pattern `apart` pixels from each other, of mean 1.
fn law(tiles: &Tiles, grain: f64, which: usize, contrast: f64, apart: usize) -> Vec<f64> {
    let pattern = &tiles.get(grain)[which];
    let rows = (0..TILE).step_by(apart);
    rows.flat_map(|row| pattern.row((row * FINE) as i64).iter().step_by(apart).map(|v| 1.0 + contrast * f64::from(*v)))
        .collect()
}

/// A plane of speckle alone under a line of half width `waist`; its contrast `strength` times the developed one.
fn lined(own: Stream, waist: f64, strength: f64, tiles: &Tiles) -> Scene {
    let mut scene = white(own, PIXELS[OWN]);
    scene.size.profiles = BARE + 2 * ROUND;
    (scene.bench.laser.waist_mm, scene.bench.laser.waist_height_mm) = (waist, 0.0);
    scene.bench.speckle.strength = strength;
    scene.extraction.subpixel_steps = 0;
    expose_to(&mut scene, &bare(), tiles, BARE, 110.0);
    scene
}

/// Spread of the line's centre, rounding and the least noise taken off [px].
fn centre(scene: &Scene, tiles: &Tiles) -> f64 {
    let record = pipeline::render_body(scene, bare(), tiles, &|_| ());
    let range = record.maps.range[BARE * TILE..].iter().map(|&z| f64::from(z));
    let variance = moments(range).1 / height_per_row(&scene.bench, 0.0).powi(2);
    (variance - sum_of_line(scene, 0.0, tiles)).max(0.0).sqrt()
}

/// What the sum over rows says of the centre's variance [px^2].
fn sum_of_line(scene: &Scene, contrast: f64, tiles: &Tiles) -> f64 {
    let light = Look::at(scene, bare(), tiles, BARE..BARE + 1).light(BARE);
    let line: Vec<f64> = (0..ROWS).map(|k| gain(scene) * light[k * TILE + TILE / 2]).collect();
    let noise = scene.bench.exposure.dark_noise_dn.powi(2);
    let correlation = Correlation::of(grain_px(&scene.bench));
    spread(&line, scene.extraction.window_rows, if contrast > 0.0 { 0.0 } else { noise }, 0.0, contrast, &correlation)
}

fn found(trials: Trials, one: u64) -> Found {
    let own = stream("speckle", trials, one);
    let tiles = Tiles::new(own.key());
    let (lags, profiles) = correlations(own.child("correlation"), &tiles);
    let bench = white(own, PIXELS[OWN]).bench;
    let grain = grain_px(&bench);
    let (coarse, fine) = (Correlation::of(grain), Correlation::of(grain * PIXELS[OWN] / PIXELS[0]));
    let lines = |(i, waist): (usize, &f64)| {
        let each = |strength: &f64| centre(&lined(own.child("line").index(i as u64), *waist, *strength, &tiles), &tiles);
        STRENGTHS.iter().map(each).collect()
    };
    Found {
        contrast: PIXELS.iter().map(|pixel| contrast(own.child("contrast"), *pixel, &tiles)).collect(),
        lags,
        profiles,
        laws: [
            law(&tiles, grain, 0, coarse.contrast(), 2),
            law(&tiles, grain, 1, coarse.contrast() / 2.0, 2),
            law(&tiles, grain * PIXELS[OWN] / PIXELS[0], 0, fine.contrast(), 3),
        ],
        centre: WAISTS.iter().enumerate().map(lines).collect(),
    }
}

fn figures(trials: Trials, found: &[Found]) -> (Vec<Figure>, Seen) {
    let own = stream("speckle", trials, 0);
    let tiles = Tiles::new(own.key());
    let bench = white(own, PIXELS[OWN]).bench;
    let grain = grain_px(&bench);
    let theory = |pixel: f64| Correlation::of(grain * PIXELS[OWN] / pixel);
    let (coarse, fine) = (theory(PIXELS[OWN]), theory(PIXELS[0]));
    let mut figures: Vec<_> = (0..PIXELS.len())
        .map(|i| {
            let name = format!("contrast behind {} um, grain {:.2} px [1]", PIXELS[i], grain * PIXELS[OWN] / PIXELS[i]);
            Figure::of(&name, &each(found, |f| f.contrast[i]), theory(PIXELS[i]).contrast())
        })
        .collect();
    let names = ["light from the surface behind 6 um", "light from below behind 6 um", "light from the surface behind 1.2 um"];
    let contrasts = [coarse.contrast(), coarse.contrast() / 2.0, fine.contrast()];
    let mut laws = Vec::new();
    for (i, name) in names.iter().enumerate() {
        let mut all: Vec<f64> = found.iter().flat_map(|f| f.laws[i].iter().copied()).collect();
        let shape = contrasts[i].powi(-2);
        let distance = chance::distance(&mut all, |x| chance::gamma_below(shape, x));
        figures.push(Figure::distance(&format!("distance to a gamma law, {name} [1]"), distance, all.len()));
        let skew = each(found, |f| skewness(&f.laws[i]));
        figures.push(Figure::of(&format!("skewness, {name} [1]"), &skew, 2.0 * contrasts[i]));
        laws.push((all, shape));
    }
    for (way, name) in ["columns", "rows"].iter().enumerate() {
        for lag in 0..2 {
            let name = format!("correlation {} px apart along the {name} [1]", lag + 1);
            figures.push(Figure::of(&name, &each(found, |f| f.lags[way][lag]), coarse.at(lag as f64 + 1.0)));
        }
    }
    let size = white(own, PIXELS[OWN]).size;
    let move_px = bench.motion.step_mm * rows_per_mm(&bench, &size, 0.0);
    for n in [1, APART] {
        let expected: Vec<f64> = AHEAD.map(|lag| coarse.at(lag as f64 - n as f64 * move_px)).collect();
        let name = format!("movement of the pattern in {n} profile{} [px]", if n > 1 { "s" } else { "" });
        figures.push(Figure::of(&name, &each(found, |f| middle(&f.profiles[n - 1])), middle(&expected)));
    }
    let estimate = |number: &dyn Fn(&Found) -> f64| Estimate::of(each(found, number).iter().copied());
    let (mut centre, mut sum, mut line_px) = (Vec::new(), Vec::new(), Vec::new());
    for (w, waist) in WAISTS.into_iter().enumerate() {
        let (mut of_waist, mut sums) = (Vec::new(), Vec::new());
        for (s, strength) in STRENGTHS.into_iter().enumerate() {
            let scene = lined(own, waist, strength, &tiles);
            let contrast = strength * coarse.contrast();
            let theory = sum_of_line(&scene, contrast, &tiles).sqrt();
            let name = format!("spread of the centre, w {waist} mm, C {contrast:.3} [px]");
            figures.push(Figure::of(&name, &each(found, |f| f.centre[w][s]), theory));
            of_waist.push(estimate(&|f| f.centre[w][s]));
            sums.push(theory);
        }
        centre.push(of_waist);
        sum.push(sums);
        let camera = &bench.camera;
        let laser = 0.5 * waist * rows_per_mm(&bench, &size, 0.0);
        line_px.push((laser * laser + (camera.blur_um / camera.pixel_um).powi(2) + 1.0 / 12.0).sqrt());
    }
    let profiles = (1..=APART).flat_map(|n| AHEAD.enumerate().map(move |(i, lag)| (n, i, lag)));
    let seen = Seen {
        contrast: (0..PIXELS.len()).map(|i| estimate(&|f| f.contrast[i])).collect(),
        lags: [0, 1].map(|way| (0..LAGS).map(|lag| estimate(&|f| f.lags[way][lag])).collect()),
        profiles: profiles.map(|(n, i, lag)| (lag as f64 - n as f64 * move_px, estimate(&|f| f.profiles[n - 1][i]), n)).collect(),
        laws: laws.try_into().unwrap_or_default(),
        centre,
        sum,
        line_px,
        own: coarse,
        grain_um: grain * PIXELS[OWN],
        patterns: [OWN, 0].map(|i| law(&tiles, grain * PIXELS[OWN] / PIXELS[i], 0, theory(PIXELS[i]).contrast(), 1)),
    };
    (figures, seen)
}

fn skewness(values: &[f64]) -> f64 {
    let (mean, variance) = moments(values.iter().copied());
    values.iter().map(|v| (v - mean).powi(3)).sum::<f64>() / values.len() as f64 / (variance * variance.sqrt())
}

/// Centre of gravity of a correlation over [`AHEAD`] [px].
fn middle(correlation: &[f64]) -> f64 {
    let sum: f64 = correlation.iter().sum();
    AHEAD.zip(correlation).map(|(lag, c)| lag as f64 * c).sum::<f64>() / sum
}
