//! Speckle: contrast, intensity law, correlation, movement and boiling of the pattern in frames and patterns of the
//! simulator, against the theory of `speckle_theory`.
//!
//! - Contrast in frames of an evenly lit white plane without noise, for eight pixels from 1.2 to 12 um.
//! - The law of one pixel, read off the pattern itself ([`PatternCache`]) at pixels far enough apart to be independent:
//!   distance of Kolmogorov and Smirnov to the law of Karhunen and Loeve's exponential parts. Mean and contrast of a
//!   pattern are its own.
//! - Correlation along columns and rows, and between profiles: the pattern lies on the object, so that profile n + j
//!   shows that of profile n moved by j step rows/mm rows, and less of it, since it boils.
//! - Patterns of the stack before pixels gather them: a grid of 512 samples behind a pupil of 256. The law of points
//!   four grains apart is held to exp(-I), and patterns u steps apart of Bergmann's M = 16, whose pupils stand s =
//!   sin(pi u / 32) diameters apart, to the overlap of the pupils.
//! - Spread of the line's centre on a plane of speckle alone, through the simulator's own Range.
//!
//! Repeats have patterns of their own, since all columns and profiles of one share a pattern of 128 by 128 pixels.

use std::sync::Arc;

use base::Stream;
use image::{Rgb, RgbImage};
use serde_json::json;

use super::centroid::{beyond_first_order, spread};
use super::closed_forms::{height_per_row, lens_variance, rows_per_mm};
use super::layout::{BLUE, GREEN, GREY, Heading, ORANGE, PURPLE, area, chart, legend, page};
use super::speckle_theory::{IntensityLaw, boiled, overlap, pupils};
use super::targets::{BARE_PROFILE, TargetView, bare, expose_to_peak, gain, quiet, scene, stream};
use super::{Figure, Repeats, Trials, document, mean_and_variance, significance, table};
use crate::{StudyProgress, StudyReport};
use drawing::chart::{Axis, Series};
use drawing::{Area, Page, viridis};
use optical_bench::settings::SpeckleLaw;
use pipeline;
use recipe::Scene;
use rig::{PixelCorrelation, grain_px};
use scanner::optics::speckle::{PatternCache, PatternStack, Pupil, TILE};
use scanner::optics::{CENTRE, ROWS};
use transport::answer::Estimate;

/// Pixels whose contrast is measured [um].
const PIXELS_UM: [f64; 8] = [1.2, 2.4, 3.45, 4.8, 5.5, 6.0, 9.0, 12.0];
/// The sensor's own.
const OWN_PIXEL: usize = 5;
/// Profiles that go once around a pattern, and those whose contrast is taken: together they show all of it.
const ROUND_PROFILES: usize = 190;
const CONTRAST_STEP: usize = 27;
/// Patterns averaged in light from below.
const PATTERNS_BELOW: usize = 4;
/// Waist of the line under which patterns are looked at [mm].
const BROAD_WAIST_MM: f64 = 2.0;
/// Largest lag in pixels, and largest number of profiles apart.
const MAX_LAG: usize = 4;
const MAX_PROFILES_APART: usize = 5;
/// Lags between profiles, in rows, that are looked at.
const ROW_LAGS: std::ops::RangeInclusive<i64> = -2..=6;
/// Scales of contrast at which the line's centre is measured.
const STRENGTHS: [f64; 2] = [0.5, 1.0];
/// Waists of the lines whose centre is measured [mm].
const WAISTS_MM: [f64; 3] = [0.05, 0.1, 0.2];

/// Notes below the table.
const NOTES: [&str; 1] =
    ["Mean and contrast of a pattern are its own; grains in steps of 3 %, contrast carried over by Goodman's ratio."];

/// What one repeat measures.
struct SpeckleRepeat {
    /// Contrast by pixel [1].
    contrast: Vec<f64>,
    /// Correlation at lags 1.. along columns and along rows [1].
    lags: [Vec<f64>; 2],
    /// Correlation between profiles by distance and lag, over that at lag 0 [1].
    profiles: Vec<Vec<f64>>,
    /// Independent pixels of the pattern at 6 um, for light from the surface and from below, and at 1.2 um [1].
    laws: [Vec<f64>; 3],
    /// Correlation of neighbouring columns behind 12 um [1].
    wide: f64,
    /// Spread of the line's centre by waist and strength [px].
    centre: Vec<Vec<f64>>,
    /// Patterns before pixels.
    stack: StackRepeat,
}

/// What the picture shows.
struct SpecklePlots {
    contrast: Vec<Estimate>,
    lags: [Vec<Estimate>; 2],
    /// Lag less movement, correlation, and number of profiles apart [px, 1].
    profiles: Vec<(f64, Estimate, usize)>,
    laws: Vec<(Vec<f64>, IntensityLaw)>,
    centre: CentreSpread,
    own: PixelCorrelation,
    grain_um: f64,
    /// The pattern of the sensor's own pixels and that of 1.2 um, [rows, TILE] from fine rows a pixel apart [1].
    patterns: [Vec<f64>; 2],
    /// Patterns apart in Bergmann's stack, and correlation [1].
    boil: Vec<(f64, Estimate)>,
    /// Number of profiles, what is left of the pattern after them, and what theory says [1].
    left: Vec<(usize, Estimate, f64)>,
}

/// Runs the study.
pub fn study(trials: Trials, progress: StudyProgress) -> StudyReport {
    let repeats = Repeats::run(trials, progress, |one| measure(trials, one));
    let (figures, plots) = figures(trials, &repeats);
    let table = table("Speckle", trials, &figures, &NOTES);
    let mut json = document("speckle", trials, &figures);
    json["pixels_um"] = json!(PIXELS_UM);
    json["contrast"] = json!(plots.contrast);
    json["between_profiles"] = plots
        .profiles
        .iter()
        .map(|(lag, c, n)| json!({ "profiles": n, "lag_less_movement_px": lag, "correlation": c }))
        .collect();
    StudyReport { picture: draw(&plots, &table), table, json, figures }
}

fn measure(trials: Trials, one: u64) -> SpeckleRepeat {
    let own = stream("speckle", trials, one);
    let patterns = PatternCache::new(own.key());
    let (lags, profiles) = correlations(own.child("correlation"), &patterns);
    let grain = grain_px(&white(own, PIXELS_UM[OWN_PIXEL]).bench);
    let lines = |(i, waist): (usize, &f64)| {
        let each =
            |strength: &f64| centre(&lined(own.child("line").index(i as u64), *waist, *strength, &patterns), &patterns);
        STRENGTHS.iter().map(each).collect()
    };
    SpeckleRepeat {
        contrast: PIXELS_UM.iter().map(|pixel| contrast(own.child("contrast"), *pixel, &patterns)).collect(),
        lags,
        profiles,
        laws: [
            law(&patterns, grain, 0, 2),
            law(&patterns, grain, 1, 2),
            law(&patterns, grain * PIXELS_UM[OWN_PIXEL] / PIXELS_UM[0], 0, 3),
        ],
        wide: neighbours(&patterns, grain * PIXELS_UM[OWN_PIXEL] / PIXELS_UM[PIXELS_UM.len() - 1]),
        centre: WAISTS_MM.iter().enumerate().map(lines).collect(),
        stack: stack_found(own.child("stack")),
    }
}

fn figures(trials: Trials, repeats: &Repeats<SpeckleRepeat>) -> (Vec<Figure>, SpecklePlots) {
    let own = stream("speckle", trials, 0);
    let patterns = PatternCache::new(own.key());
    let bench = white(own, PIXELS_UM[OWN_PIXEL]).bench;
    let grain = grain_px(&bench);
    let grain_behind = |pixel: f64| grain * PIXELS_UM[OWN_PIXEL] / pixel;
    let theory = |pixel: f64| PixelCorrelation::of(grain_behind(pixel));
    let coarse = theory(PIXELS_UM[OWN_PIXEL]);
    let contrast = |i: usize| {
        let pixel = PIXELS_UM[i];
        let name = format!("contrast behind {pixel} um, grain {:.2} px [1]", grain_behind(pixel));
        repeats.figure(name, |f| f.contrast[i], theory(pixel).contrast())
    };
    let mut figures: Vec<_> = (0..PIXELS_UM.len()).map(contrast).collect();
    let names = ["from the surface, 6 um", "from below, 6 um", "from the surface, 1.2 um"];
    let made = [grain, grain_behind(PIXELS_UM[0])].map(|grain| stack(&patterns, grain).grain());
    let of = [IntensityLaw::of(made[0], 1), IntensityLaw::of(made[0], PATTERNS_BELOW), IntensityLaw::of(made[1], 1)];
    let mut laws = Vec::new();
    for (i, (name, law)) in names.iter().zip(of).enumerate() {
        let mut all: Vec<f64> = repeats.0.iter().flat_map(|f| f.laws[i].iter().copied()).collect();
        let distance = significance::distance(&mut all, |x| law.below(x));
        figures.push(Figure::distance(format!("distance to the law, {name} [1]"), distance, all.len()));
        let name = format!("skewness, {name} [1]");
        figures.push(repeats.figure(name, |f| skewness(&f.laws[i]), law.skewness()));
        laws.push((all, law));
    }
    figures.extend(lag_figures(repeats, &coarse, &theory(PIXELS_UM[PIXELS_UM.len() - 1])));
    let size = white(own, PIXELS_UM[OWN_PIXEL]).size;
    let move_px = bench.motion.step_mm * rows_per_mm(&bench, &size, 0.0);
    for n in [1, MAX_PROFILES_APART] {
        let expected: Vec<f64> = ROW_LAGS.map(|lag| coarse.at(lag as f64 - n as f64 * move_px)).collect();
        let name = format!("movement of the pattern in {n} profile{} [px]", if n > 1 { "s" } else { "" });
        let near = n as f64 * move_px;
        figures.push(repeats.figure(name, |f| middle(&f.profiles[n - 1], near), middle(&expected, near)));
    }
    // Contrast and correlations are taken under a broad line, whose wave is flat.
    let mut broad = bench;
    broad.laser.waist_mm = BROAD_WAIST_MM;
    let expected = |n: usize| boiled(grain, n as f64 * pupils(&broad, broad.motion.step_mm));
    // Lags that have something in common; further ones add noise alone.
    let left = |f: &SpeckleRepeat, n: usize| {
        let near = |lag: i64| lag as f64 - n as f64 * move_px;
        let lags = || ROW_LAGS.zip(&f.profiles[n - 1]).filter(|(lag, _)| near(*lag).abs() < 1.5);
        lags().map(|(_, c)| c).sum::<f64>() / lags().map(|(lag, _)| coarse.at(near(lag))).sum::<f64>()
    };
    for n in [1, MAX_PROFILES_APART] {
        let name = format!("left of the pattern after {n} profile{} [1]", if n > 1 { "s" } else { "" });
        figures.push(repeats.figure(name, |f| left(f, n), expected(n)));
    }
    figures.extend(stack_figures(repeats));
    let centre = centre_spread(repeats, own, &patterns, &coarse, &laws[0].1, &mut figures);
    let profiles = (1..=MAX_PROFILES_APART).flat_map(|n| ROW_LAGS.enumerate().map(move |(i, lag)| (n, i, lag)));
    let plots = SpecklePlots {
        contrast: (0..PIXELS_UM.len()).map(|i| repeats.estimate(|f| f.contrast[i])).collect(),
        lags: [0, 1].map(|way| (0..MAX_LAG).map(|lag| repeats.estimate(|f| f.lags[way][lag])).collect()),
        profiles: profiles
            .map(|(n, i, lag)| (lag as f64 - n as f64 * move_px, repeats.estimate(|f| f.profiles[n - 1][i]), n))
            .collect(),
        laws,
        centre,
        own: coarse.clone(),
        grain_um: grain * PIXELS_UM[OWN_PIXEL],
        patterns: [OWN_PIXEL, 0].map(|i| law(&patterns, grain_behind(PIXELS_UM[i]), 0, 1)),
        left: (1..=MAX_PROFILES_APART).map(|n| (n, repeats.estimate(|f| left(f, n)), expected(n))).collect(),
        boil: STACK_STEPS.iter().enumerate().map(|(i, u)| (*u, repeats.estimate(|f| f.stack.alike[i]))).collect(),
    };
    (figures, plots)
}

/// Correlation of neighbours behind the sensor's own pixels (`coarse`), and behind the widest.
fn lag_figures(repeats: &Repeats<SpeckleRepeat>, coarse: &PixelCorrelation, wide: &PixelCorrelation) -> Vec<Figure> {
    let mut figures = Vec::new();
    for (way, name) in ["columns", "rows"].iter().enumerate() {
        for lag in 0..2 {
            let name = format!("correlation {} px apart along the {name} [1]", lag + 1);
            figures.push(repeats.figure(name, |f| f.lags[way][lag], coarse.at(lag as f64 + 1.0)));
        }
    }
    let last = PIXELS_UM[PIXELS_UM.len() - 1];
    let name = format!("correlation 1 px apart along the columns, {last} um [1]");
    figures.push(repeats.figure(name, |f| f.wide, wide.at(1.0)));
    figures
}

/// Spread of the line's centre by waist and strength, its value to first order, and the line's own width [px].
#[derive(Default)]
struct CentreSpread {
    measured: Vec<Vec<Estimate>>,
    theory: Vec<Vec<f64>>,
    line_px: Vec<f64>,
}

/// The spread of the line's centre on patterns of the correlation `coarse`, whose light has the law `law`; its figures
/// join the others.
fn centre_spread(
    repeats: &Repeats<SpeckleRepeat>,
    own: Stream,
    patterns: &PatternCache,
    coarse: &PixelCorrelation,
    law: &IntensityLaw,
    figures: &mut Vec<Figure>,
) -> CentreSpread {
    let Scene { bench, size, .. } = white(own, PIXELS_UM[OWN_PIXEL]);
    let mut spread = CentreSpread::default();
    for (w, waist) in WAISTS_MM.into_iter().enumerate() {
        let first = figures.len();
        for (s, strength) in STRENGTHS.into_iter().enumerate() {
            let scene = lined(own, waist, strength, patterns);
            let contrast = strength * coarse.contrast();
            let theory = sum_of_line(&scene, contrast, patterns).sqrt()
                * beyond_first_order(&middle_line(&scene, patterns), law, strength);
            let name = format!("spread of the centre, w {waist} mm, C {contrast:.3} [px]");
            figures.push(repeats.figure(name, |f| f.centre[w][s], theory));
        }
        spread.measured.push(figures[first..].iter().map(|figure| figure.measured).collect());
        spread.theory.push(figures[first..].iter().map(|figure| figure.theory).collect());
        let laser = 0.5 * waist * rows_per_mm(&bench, &size, 0.0);
        spread.line_px.push((laser * laser + lens_variance(&bench, &size) + 1.0 / 12.0).sqrt());
    }
    spread
}

/// A white plane under the nominal bench, no noise but rounding.
fn white(own: Stream, pixel_um: f64) -> Scene {
    let mut scene = scene(own, TILE, BARE_PROFILE + ROUND_PROFILES);
    scene.bench.motion.conveyor_reflectance = 1.0;
    scene.bench.camera.pixel_um = pixel_um;
    quiet(&mut scene);
    scene
}

/// The same lit by a broad line, so that many rows are alike.
fn broad(own: Stream, pixel_um: f64, patterns: &PatternCache) -> Scene {
    let mut scene = white(own, pixel_um);
    scene.bench.laser.waist_mm = BROAD_WAIST_MM;
    // Exponential light is seven times its mean once in a thousand.
    let peak = 230.0 / (1.0 + 6.0 * PixelCorrelation::of(grain_px(&scene.bench)).contrast());
    expose_to_peak(&mut scene, &bare(), patterns, BARE_PROFILE, peak);
    scene
}

/// Rows about the line's middle that are looked at.
const MIDDLE_ROWS: std::ops::Range<usize> = CENTRE - 11..CENTRE + 11;

/// Light over its mean, `[ROWS][TILE]` [1].
fn shades(scene: &Scene, look: &TargetView, light: &[f64], profile: usize) -> Vec<f64> {
    let (k, dark) = (gain(scene), scene.bench.exposure.dark_level_dn);
    let frame = look.frame(profile);
    frame.dn.iter().zip(light).map(|(&dn, e)| (f64::from(dn) - dark) / (k * e).max(1e-9)).collect()
}

/// Contrast of the pattern over a whole round, less what rounding and the least noise add [1].
fn contrast(own: Stream, pixel_um: f64, patterns: &PatternCache) -> f64 {
    let scene = broad(own, pixel_um, patterns);
    let k = gain(&scene);
    let (mut sum, mut squares, mut noise, mut n) = (0.0, 0.0, 0.0, 0.0);
    for profile in (BARE_PROFILE..BARE_PROFILE + ROUND_PROFILES).step_by(CONTRAST_STEP) {
        let look = TargetView::new(&scene, bare(), patterns, profile..profile + 1);
        let light = look.light(profile);
        let shades = shades(&scene, &look, &light, profile);
        for at in MIDDLE_ROWS.start * TILE..MIDDLE_ROWS.end * TILE {
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
fn correlations(own: Stream, patterns: &PatternCache) -> ([Vec<f64>; 2], Vec<Vec<f64>>) {
    let scene = broad(own, PIXELS_UM[OWN_PIXEL], patterns);
    let last = BARE_PROFILE + ROUND_PROFILES + MAX_PROFILES_APART;
    let look = TargetView::new(&scene, bare(), patterns, BARE_PROFILE..last);
    let light = look.light(BARE_PROFILE);
    let all: Vec<Vec<f64>> = (BARE_PROFILE..last)
        .map(|profile| shades(&scene, &look, &light, profile).iter().map(|shade| shade - 1.0).collect())
        .collect();
    // Mean product of what lies `rows` and `columns` and `apart` profiles away.
    let product = |rows: i64, columns: usize, apart: usize| {
        let (mut sum, mut n) = (0.0, 0.0);
        for profile in 0..ROUND_PROFILES {
            let (here, there) = (&all[profile], &all[profile + apart]);
            for k in MIDDLE_ROWS {
                let other = (k as i64 + rows) as usize;
                for c in 0..TILE - columns {
                    sum += here[k * TILE + c] * there[other * TILE + c + columns];
                }
            }
            n += (MIDDLE_ROWS.len() * (TILE - columns)) as f64;
        }
        sum / n
    };
    let variance = product(0, 0, 0);
    let lags = [
        (1..=MAX_LAG).map(|lag| product(0, lag, 0) / variance).collect(),
        (1..=MAX_LAG).map(|lag| product(lag as i64, 0, 0) / variance).collect(),
    ];
    let profiles =
        (1..=MAX_PROFILES_APART).map(|n| ROW_LAGS.map(|lag| product(lag, 0, n) / variance).collect()).collect();
    (lags, profiles)
}

/// Patterns for grains of about `grain` pixels: one of light from the surface, four of light from below.
fn stack(patterns: &PatternCache, grain: f64) -> Arc<PatternStack> {
    patterns.get(grain, SpeckleLaw::Exponential, [1.0, PATTERNS_BELOW as f64])
}

/// Pixels of a pattern `apart` pixels from each other, of mean 1.
fn law(patterns: &PatternCache, grain: f64, which: usize, apart: usize) -> Vec<f64> {
    let stack = stack(patterns, grain);
    let rows = (0..stack.rows()).step_by(apart * stack.fine());
    rows.flat_map(|row| stack.row(0, row as i64)[which].iter().step_by(apart).map(|v| 1.0 + f64::from(*v))).collect()
}

/// Correlation of neighbouring columns of a pattern [1].
fn neighbours(patterns: &PatternCache, grain: f64) -> f64 {
    let pattern = law(patterns, grain, 0, 1);
    let pairs = pattern.chunks(TILE).flat_map(|row| row.windows(2).map(|pair| (pair[0] - 1.0) * (pair[1] - 1.0)));
    let squares = pattern.iter().map(|v| (v - 1.0).powi(2)).sum::<f64>();
    pairs.sum::<f64>() / squares * TILE as f64 / (TILE - 1) as f64
}

/// A plane of speckle alone under a line of half width `waist`; its contrast `strength` times the developed one.
fn lined(own: Stream, waist: f64, strength: f64, patterns: &PatternCache) -> Scene {
    let mut scene = white(own, PIXELS_UM[OWN_PIXEL]);
    scene.size.profiles = BARE_PROFILE + 2 * ROUND_PROFILES;
    (scene.bench.laser.waist_mm, scene.bench.laser.waist_height_mm) = (waist, 0.0);
    scene.bench.speckle.strength = strength;
    scene.extraction.subpixel_steps = 0;
    // A whole number, so that rows without light are exact.
    scene.bench.exposure.dark_level_dn = 12.0;
    expose_to_peak(&mut scene, &bare(), patterns, BARE_PROFILE, 110.0);
    scene
}

/// Spread of the line's centre, rounding and the least noise taken off [px].
fn centre(scene: &Scene, patterns: &PatternCache) -> f64 {
    let record = pipeline::render_body(scene, bare(), patterns, &|_| ());
    let range = record.maps.range[BARE_PROFILE * TILE..].iter().map(|&z| f64::from(z));
    let variance = mean_and_variance(range).1 / height_per_row(&scene.bench, 0.0).powi(2);
    (variance - sum_of_line(scene, 0.0, patterns)).max(0.0).sqrt()
}

/// Light of the middle column before noise [DN].
fn middle_line(scene: &Scene, patterns: &PatternCache) -> Vec<f64> {
    let light = TargetView::new(scene, bare(), patterns, BARE_PROFILE..BARE_PROFILE + 1).light(BARE_PROFILE);
    (0..ROWS).map(|k| gain(scene) * light[k * TILE + TILE / 2]).collect()
}

/// Variance of the line's centre to first order; without contrast that of rounding, in rows that have light [px^2].
fn sum_of_line(scene: &Scene, contrast: f64, patterns: &PatternCache) -> f64 {
    let line = middle_line(scene, patterns);
    let correlation = PixelCorrelation::of(grain_px(&scene.bench));
    if contrast > 0.0 {
        return spread(&line, scene.extraction.window_rows, 0.0, 0.0, &[contrast; ROWS], &correlation);
    }
    let lit: Vec<f64> = line.into_iter().filter(|dn| *dn > 0.5).collect();
    spread(&lit, lit.len(), scene.bench.exposure.dark_noise_dn.powi(2), 0.0, &vec![0.0; lit.len()], &correlation)
}

fn skewness(values: &[f64]) -> f64 {
    let (mean, variance) = mean_and_variance(values.iter().copied());
    values.iter().map(|v| (v - mean).powi(3)).sum::<f64>() / values.len() as f64 / (variance * variance.sqrt())
}

/// Centre of gravity of a correlation over those of [`ROW_LAGS`] that are near its middle [px].
fn middle(correlation: &[f64], near: f64) -> f64 {
    let lags = || ROW_LAGS.map(|lag| lag as f64).zip(correlation).filter(|(lag, _)| (lag - near).abs() < 1.5);
    lags().map(|(lag, c)| lag * c).sum::<f64>() / lags().map(|(_, c)| c).sum::<f64>()
}

/// Steps of the stack between the patterns that are compared.
const STACK_STEPS: [f64; 5] = [1.0, 2.0, 4.0, 8.0, 12.0];
/// Samples along a side, and samples a grain.
const STACK_SIDE: usize = 512;
const STACK_GRAIN: f64 = 2.0;

struct StackRepeat {
    /// Light of mean 1 in independent points [1].
    points: Vec<f64>,
    /// Correlation by [`STACK_STEPS`] [1].
    alike: Vec<f64>,
}

/// Distance between pupils u steps apart, in diameters.
fn chord(u: f64) -> f64 {
    libm::sin(std::f64::consts::PI * u / 32.0)
}

fn stack_found(own: Stream) -> StackRepeat {
    let pupil = Pupil::new([STACK_SIDE; 2], STACK_GRAIN, own);
    let light = |shift: usize| -> Vec<f64> {
        let light = pupil.intensity(shift);
        let mean = light.iter().map(|v| f64::from(*v)).sum::<f64>() / light.len() as f64;
        light.iter().map(|v| f64::from(*v) / mean - 1.0).collect()
    };
    let first = light(0);
    let product = |other: &[f64]| first.iter().zip(other).map(|(a, b)| a * b).sum::<f64>() / first.len() as f64;
    let shift = |u: &f64| (chord(*u) * STACK_SIDE as f64 / STACK_GRAIN).round() as usize;
    let points = first.iter().enumerate().filter(|(i, _)| (i / STACK_SIDE).is_multiple_of(8) && i.is_multiple_of(8));
    StackRepeat {
        points: points.map(|(_, v)| 1.0 + v).collect(),
        alike: STACK_STEPS.iter().map(|u| product(&light(shift(u)))).collect(),
    }
}

fn stack_figures(repeats: &Repeats<SpeckleRepeat>) -> Vec<Figure> {
    let mut all: Vec<f64> = repeats.0.iter().flat_map(|f| f.stack.points.iter().copied()).collect();
    let distance = significance::distance(&mut all, |x| 1.0 - libm::exp(-x));
    let mut figures = vec![Figure::distance("distance to exp(-I), a point [1]", distance, all.len())];
    for (i, u) in STACK_STEPS.iter().enumerate() {
        let name = format!("correlation of patterns {u} of 32 apart, a point [1]");
        figures.push(repeats.figure(name, |f| f.stack.alike[i], overlap(chord(*u)).powi(2)));
    }
    figures
}

const COLOURS: [Rgb<u8>; 5] = [BLUE, ORANGE, PURPLE, GREEN, Rgb([30, 30, 30])];

fn draw(plots: &SpecklePlots, table: &str) -> RgbImage {
    let heading = Heading {
        title: "Speckle as production makes it",
        subtitle: "Contrast, law, correlation and movement of the pattern, and what it does to the line's centre. \
            Grey: theory.",
    };
    let mut page = page(2, 4, heading, table);
    draw_contrast(&mut page, plots);
    draw_laws(&mut page, plots);
    draw_lags(&mut page, plots);
    draw_movement(&mut page, plots);
    draw_centre(&mut page, plots);
    draw_patterns(&mut page, plots);
    draw_boiling(&mut page, plots);
    page.0
}

/// Contrast in a pixel by grain.
fn draw_contrast(page: &mut Page, plots: &SpecklePlots) {
    let theory =
        (0..=60).map(|i| 0.12 + 0.03 * f64::from(i)).map(|grain| (grain, PixelCorrelation::of(grain).contrast()));
    let measured = PIXELS_UM.iter().zip(&plots.contrast).map(|(pixel, c)| (plots.grain_um / pixel, c.value, c.error));
    let Area { left: x, top: y, .. } = chart(
        page,
        [0, 0],
        "Contrast in one pixel (Goodman), pixels of 12 to 1.2 um",
        Axis::even("grain over pixel", 0.0, 1.8),
        Axis::even("standard deviation over mean", 0.0, 1.0),
        vec![Series::curve(GREY, theory), Series::marks(BLUE, measured)],
    );
    let (own, theory) = (plots.contrast[OWN_PIXEL].value, plots.own.contrast());
    page.words_in(x + 200, y + 250, &format!("the sensor's own 6 um: {own:.4}, theory {theory:.4}"), BLUE);
}

/// The law of the light in one pixel.
fn draw_laws(page: &mut Page, plots: &SpecklePlots) {
    let mut series = Vec::new();
    for (i, (values, law)) in plots.laws.iter().enumerate() {
        series.push(Series::curve(GREY, (1..=150).map(|j| 0.02 * f64::from(j)).map(|v| (v, law.density(v)))));
        series.push(Series::marks(COLOURS[i], histogram(values)));
    }
    let Area { left: x, top: y, .. } = chart(
        page,
        [1, 0],
        "Law of one pixel: histograms, and sums of exponential parts",
        Axis::even("light over its mean", 0.0, 3.0),
        Axis::even("density", 0.0, 3.0),
        series,
    );
    let entries = [
        (PURPLE, "surface, 1.2 um: nearly exponential"),
        (BLUE, "surface, 6 um"),
        (ORANGE, "below, 6 um: mean of four"),
    ];
    legend(page, x + 260, y + 60, &entries);
}

/// Correlation within a profile.
fn draw_lags(page: &mut Page, plots: &SpecklePlots) {
    let lags = |way: usize| {
        let aside = if way == 0 { -0.03 } else { 0.03 };
        plots.lags[way].iter().enumerate().map(move |(i, c)| (i as f64 + 1.0 + aside, c.value, c.error))
    };
    let most = MAX_LAG as f64 + 0.4;
    let Area { left: x, top: y, .. } = chart(
        page,
        [0, 1],
        "Correlation of pixels within a profile",
        Axis::even("pixels apart", 0.0, most),
        Axis::even("", -0.02, 0.12),
        vec![
            Series::curve(GREY, (6..=88).map(|i| 0.05 * f64::from(i)).map(|lag| (lag, plots.own.at(lag)))),
            Series::marks(BLUE, lags(0)),
            Series::marks(ORANGE, lags(1)),
        ],
    );
    legend(page, x + 380, y + 60, &[(BLUE, "along columns"), (ORANGE, "along rows")]);
}

/// Correlation between profiles.
fn draw_movement(page: &mut Page, plots: &SpecklePlots) {
    let apart =
        |n: usize| plots.profiles.iter().filter(move |(_, _, m)| *m == n).map(|(lag, c, _)| (*lag, c.value, c.error));
    let mut series =
        vec![Series::curve(GREY, (-80..=80).map(|i| 0.025 * f64::from(i)).map(|lag| (lag, plots.own.at(lag))))];
    series.extend((1..=5).map(|n| Series::marks(COLOURS[n - 1], apart(n))));
    let Area { left: x, top: y, .. } = chart(
        page,
        [1, 1],
        "Correlation between profiles: the pattern moves with the object",
        Axis::even("rows apart less 0.673 rows a profile", -2.0, 2.0),
        Axis::even("", -0.1, 1.1),
        series,
    );
    let entries: Vec<String> = (1..=5).map(|n| format!("{n} profile{}", if n > 1 { "s" } else { "" })).collect();
    let entries: Vec<_> = COLOURS.iter().zip(&entries).map(|(colour, words)| (*colour, words.as_str())).collect();
    legend(page, x + 430, y + 60, &entries);
}

/// Spread of the line's centre.
fn draw_centre(page: &mut Page, plots: &SpecklePlots) {
    let CentreSpread { measured, theory, line_px } = &plots.centre;
    let mut series: Vec<_> = STRENGTHS
        .iter()
        .map(|s| {
            let c = s * plots.own.contrast();
            Series::curve(GREY, (30..=140).map(|i| 0.01 * f64::from(i)).map(move |px| (px, plots.own.wide_line(c, px))))
        })
        .collect();
    for s in 0..STRENGTHS.len() {
        let at = (0..WAISTS_MM.len()).map(move |w| (line_px[w], measured[w][s].value, measured[w][s].error));
        series.push(Series::marks(COLOURS[s], at));
        series.push(Series::curve(COLOURS[s], (0..WAISTS_MM.len()).map(move |w| (line_px[w], theory[w][s]))));
    }
    let Area { left: x, top: y, .. } = chart(
        page,
        [0, 2],
        "Spread of the line's centre on speckle alone",
        Axis::even("standard deviation of the line [rows]", 0.3, 1.4),
        Axis::even("[rows]", 0.0, 0.2),
        series,
    );
    let entries: Vec<String> =
        STRENGTHS.iter().map(|s| format!("contrast {:.3}; line: sum over rows", s * plots.own.contrast())).collect();
    let mut entries: Vec<_> =
        COLOURS.iter().zip(&entries).map(|(colour, words)| (*colour, words.as_str())).rev().collect();
    entries.push((GREY, "C sqrt(sigma L_c / (4 sqrt(pi)))"));
    legend(page, x + 64, y + 56, &entries);
}

/// Two patterns.
fn draw_patterns(page: &mut Page, plots: &SpecklePlots) {
    let Area { left: x, top: y, .. } = area(1, 2);
    page.words(x, y + 12, "The pattern, 64 x 64 pixels: of the sensor's 6 um, and of 1.2 um");
    for (i, pattern) in plots.patterns.iter().enumerate() {
        draw_pattern(page, x + i as u32 * 276, y + 30, pattern);
    }
    page.bar(x, y + 30 + 256 + 12, 256, "0", "3 times the mean", &|t| viridis(t));
}

/// What boiling leaves.
fn draw_boiling(page: &mut Page, plots: &SpecklePlots) {
    let theory = (0..=100).map(|i| 0.01 * f64::from(i)).map(|s| (s, overlap(s).powi(2)));
    chart(
        page,
        [0, 3],
        "Boiling: patterns of the stack, points",
        Axis::even("pupils apart over their diameter", 0.0, 1.05),
        Axis::even("correlation", -0.05, 1.0),
        vec![
            Series::curve(GREY, theory),
            Series::marks(BLUE, plots.boil.iter().map(|(u, c)| (chord(*u), c.value, c.error))),
        ],
    );
    chart(
        page,
        [1, 3],
        "Boiling: what is left of the pattern between profiles",
        Axis::even("profiles apart", 0.0, 5.5),
        Axis::even("correlation, all lags over still", 0.8, 1.05),
        vec![
            Series::curve(GREY, plots.left.iter().map(|(n, _, theory)| (*n as f64, *theory))),
            Series::marks(ORANGE, plots.left.iter().map(|(n, c, _)| (*n as f64, c.value, c.error))),
        ],
    );
}

/// 64 by 64 pixels of a pattern, four pixels of the page each.
fn draw_pattern(page: &mut Page, left: u32, top: u32, pattern: &[f64]) {
    let picture =
        RgbImage::from_fn(256, 256, |px, py| viridis((pattern[py as usize / 4 * TILE + px as usize / 4] / 3.0) as f32));
    page.picture(left, top, &picture);
}

/// Middle of each bin, density, and its standard error for independent pixels.
fn histogram(values: &[f64]) -> Vec<(f64, f64, f64)> {
    const BIN: f64 = 0.1;
    let n = values.len() as f64;
    let bin = |i: usize| {
        let (from, to) = (BIN * i as f64, BIN * (i + 1) as f64);
        let count = values.iter().filter(|v| (from..to).contains(*v)).count() as f64;
        (0.5 * (from + to), count / (n * BIN), count.sqrt() / (n * BIN))
    };
    (0..30).map(bin).collect()
}
