//! Photon transfer of the sensor (EMVA 1288): gain, noise, linearity and row patterns, measured on digital numbers
//! alone.
//!
//! A white plane lit by a line of 4 mm is exposed again and again without speckle. Signal and noise of a pixel follow
//! (EMVA 1288)
//!
//! ```text
//! mean = dark + K e,    variance in time = dark noise^2 + K (mean - dark),
//! ```
//!
//! so the slope of variance over mean is the gain K, whatever the light. Rows are read off dark frames: where pixels
//! alone are noisy, the variance of row means is that of pixels over the number of columns; rows that stand out show as
//! a line at frequency 0 of the spectrum along the rows. Close to 255 the numbers are clipped; the expected curve there
//! is that of a clipped normal. Pixels are alike here: their fixed pattern is no noise in time;
//! tests/optics/sensor_chain.rs checks it.
//!
//! Modes with a second slope are exposed for 0.03 to 20 times the light that fills a pixel with one slope; theory is
//! the closed form B + r phi above the knee, with the noise of r phi.

use std::f64::consts::PI;

use image::{Rgb, RgbImage};
use rustfft::FftPlannerScalar;
use rustfft::num_complex::Complex64;
use serde_json::{Value, json};

use super::layout::{BLUE, GREEN, GREY, Heading, ORANGE, PURPLE, area, chart, legend, page};
use super::targets::{BARE_PROFILE, TargetView, bare, gain, scene, stream};
use super::{Figure, Repeats, Trials, document, mean_and_variance, table};
use crate::{StudyProgress, StudyReport};
use drawing::chart::{Axis, Series};
use drawing::{Area, INK, Page};
use numerics::chance::normal_below;
use optical_bench::settings::{Hdr, Readout};
use recipe::Scene;
use scanner::optics::CENTRE;
use scanner::optics::speckle::PatternCache;
use transport::answer::Estimate;

/// Exposure times, and the step between them as a share of that which fills a pixel.
const LEVELS: usize = 24;
const LEVEL_STEP: f64 = 0.05;
/// Levels that the line is fitted to: up to 70 % of full, as EMVA 1288 has it.
const FITTED_LEVELS: std::ops::RangeInclusive<usize> = 0..=14;
/// Levels whose variance the table shows.
const TABLE_LEVELS: [usize; 4] = [2, 6, 10, 14];
/// Columns, and rows around the line's middle, of the patch.
const PATCH_COLUMNS: usize = 256;
const PATCH_ROWS: std::ops::Range<usize> = CENTRE - 2..CENTRE + 2;
/// Exposures at each level, and dark frames, of one repeat.
const EXPOSURES: usize = 24;
const DARK_EXPOSURES: usize = 6;

/// Noise of dark frames.
struct DarkFrames {
    /// Variance of a pixel within its row, of a row's mean in time, and of rows' means that stay [DN^2].
    variances: [f64; 3],
    /// Variance of row means times columns over the variance of a pixel [1].
    ratio: f64,
    /// Power along the rows by frequency, 0 to 1/2 a pixel [DN^2].
    spectrum: Vec<f64>,
}

/// What one repeat measures.
struct SensorRepeat {
    /// Mean and variance in time at each level [DN, DN^2].
    levels: Vec<[f64; 2]>,
    /// With rows that stand out, and without.
    dark: [DarkFrames; 2],
}

/// What the picture shows.
struct SensorPlots {
    scene: Scene,
    /// Electrons, mean and variance at each level [e-, DN, DN^2].
    levels: Vec<(f64, Estimate, Estimate)>,
    /// Expected mean and variance by electrons [e-, DN, DN^2].
    expected: Vec<[f64; 3]>,
    gain: Estimate,
    /// Mean spectra with and without rows that stand out [DN^2].
    spectra: [Vec<f64>; 2],
    /// A dark frame with rows, and one without; `[rows, PATCH_COLUMNS]`.
    frames: [Vec<u16>; 2],
    /// With one slope and with two.
    modes: Vec<SlopeMode>,
}

/// Runs the study.
pub fn study(trials: Trials, progress: StudyProgress) -> StudyReport {
    let patterns = PatternCache::new(trials.seed);
    let patch = full_well_patch(&patterns);
    let repeats = Repeats::run(trials, progress, |one| measure(trials, one, &patch, &patterns));
    let (figures, plots) = figures(trials, &repeats, &patch, &patterns);
    let table = table("Sensor", trials, &figures, &[]);
    let mut json = document("sensor", trials, &figures);
    let level = |(electrons, mean, variance): &(f64, Estimate, Estimate)| {
        json!({ "electrons_e": electrons,
        "mean_dn": mean, "variance_dn2": variance })
    };
    json["levels"] = plots.levels.iter().map(level).collect();
    json["slopes"] = slope_document(&plots.modes);
    json["spectrum_with_rows_dn2"] = json!(plots.spectra[0]);
    json["spectrum_without_rows_dn2"] = json!(plots.spectra[1]);
    StudyReport { picture: draw(&plots, &table), table, json, figures }
}

/// The patch: a scene whose exposure time fills the pixels, and electrons of the patch then [e-].
struct FullWellPatch {
    scene: Scene,
    electrons: f64,
}

fn full_well_patch(patterns: &PatternCache) -> FullWellPatch {
    let mut scene = scene(base::Stream::root(0), PATCH_COLUMNS, BARE_PROFILE + EXPOSURES);
    (scene.bench.motion.conveyor_reflectance, scene.bench.laser.waist_mm) = (1.0, 2.0);
    scene.bench.speckle.strength = 0.0;
    let light = TargetView::new(&scene, bare(), patterns, BARE_PROFILE..BARE_PROFILE + 1).light(BARE_PROFILE);
    let (electrons, _) =
        mean_and_variance(light[PATCH_ROWS.start * PATCH_COLUMNS..PATCH_ROWS.end * PATCH_COLUMNS].iter().copied());
    scene.bench.exposure.time_us *= scene.bench.exposure.full_well_e / electrons;
    FullWellPatch { electrons: scene.bench.exposure.full_well_e, scene }
}

fn measure(trials: Trials, one: u64, patch: &FullWellPatch, patterns: &PatternCache) -> SensorRepeat {
    let own = stream("sensor", trials, one);
    let level = |i: usize| {
        let mut scene = patch.scene.clone();
        // Profiles of their own have noise of their own, over the same fixed pattern.
        scene.stream = own.child("levels");
        scene.bench.exposure.time_us = share(i) * patch.scene.bench.exposure.time_us;
        patch_moments(&scene, BARE_PROFILE + i * EXPOSURES, EXPOSURES, patterns)
    };
    let dark = |rows: bool| {
        let mut scene = patch.scene.clone();
        scene.stream = own.child("dark");
        dark(&dark_frames(&mut scene, rows, patterns))
    };
    SensorRepeat { levels: (0..LEVELS).map(level).collect(), dark: [dark(true), dark(false)] }
}

/// Exposure of a level over the one that fills a pixel [1].
fn share(level: usize) -> f64 {
    (level as f64 * LEVEL_STEP).max(1e-3)
}

/// Mean of the patch, and the mean over its pixels of their variance in time [DN, DN^2].
fn patch_moments(scene: &Scene, first: usize, exposures: usize, patterns: &PatternCache) -> [f64; 2] {
    let profiles = first..first + exposures;
    let look = TargetView::new(scene, bare(), patterns, profiles.clone());
    let frames: Vec<_> = profiles.map(|profile| look.frame(profile)).collect();
    let pixels = PATCH_ROWS.start * PATCH_COLUMNS..PATCH_ROWS.end * PATCH_COLUMNS;
    let n = pixels.len() as f64;
    let sums = pixels.map(|pixel| mean_and_variance(frames.iter().map(move |frame| f64::from(frame.dn[pixel]))));
    sums.fold([0.0; 2], |[mean, variance], (m, v)| [mean + m / n, variance + v / n])
}

fn dark_frames(scene: &mut Scene, rows: bool, patterns: &PatternCache) -> Vec<Vec<u16>> {
    (scene.bench.laser.power_mw, scene.bench.exposure.time_us) = (0.01, 0.1);
    if !rows {
        (scene.bench.exposure.row_noise_dn, scene.bench.exposure.row_pattern_dn) = (0.0, 0.0);
    }
    let look = TargetView::new(scene, bare(), patterns, BARE_PROFILE..BARE_PROFILE + DARK_EXPOSURES);
    (BARE_PROFILE..BARE_PROFILE + DARK_EXPOSURES).map(|profile| look.sensor_frame(profile)).collect()
}

fn dark(frames: &[Vec<u16>]) -> DarkFrames {
    let rows = frames[0].len() / PATCH_COLUMNS;
    let transform = FftPlannerScalar::new().plan_fft_forward(PATCH_COLUMNS);
    let (mut pixel, mut all_means) = (0.0, Vec::new());
    let mut spectrum = vec![0.0; PATCH_COLUMNS / 2 + 1];
    for frame in frames {
        let (mean, _) = mean_and_variance(frame.iter().map(|&dn| f64::from(dn)));
        let mut means = Vec::new();
        for row in frame.chunks(PATCH_COLUMNS) {
            let (m, v) = mean_and_variance(row.iter().map(|&dn| f64::from(dn)));
            pixel += v / (rows * frames.len()) as f64;
            means.push(m);
            let mut line: Vec<_> = row.iter().map(|&dn| Complex64::new(f64::from(dn) - mean, 0.0)).collect();
            transform.process(&mut line);
            for (sum, wave) in spectrum.iter_mut().zip(&line) {
                *sum += wave.norm_sqr() / (PATCH_COLUMNS * rows * frames.len()) as f64;
            }
        }
        all_means.push(means);
    }
    let n = frames.len() as f64;
    let within = all_means.iter().map(|means| mean_and_variance(means.iter().copied()).1).sum::<f64>() / n;
    let of_row = |row: usize| mean_and_variance(all_means.iter().map(move |means| means[row]));
    let in_time = (0..rows).map(|row| of_row(row).1).sum::<f64>() / rows as f64;
    let staying = mean_and_variance((0..rows).map(|row| of_row(row).0)).1 - in_time / n;
    let by_chance = pixel / PATCH_COLUMNS as f64;
    DarkFrames { variances: [pixel, in_time - by_chance, staying], ratio: within / by_chance, spectrum }
}

/// Straight line through levels: value at 0 and slope, each level weighted by the inverse of its `scatter`.
fn line(levels: impl Iterator<Item = (f64, f64, f64)>) -> [f64; 2] {
    let mut s = [0.0; 5];
    for (x, y, scatter) in levels {
        let w = 1.0 / (scatter * scatter);
        s = [s[0] + w, s[1] + w * x, s[2] + w * y, s[3] + w * x * x, s[4] + w * x * y];
    }
    let slope = (s[0] * s[4] - s[1] * s[2]) / (s[0] * s[3] - s[1] * s[1]);
    [(s[2] - slope * s[1]) / s[0], slope]
}

/// Variance in time of a pixel without light: the fixed pattern of rows is the same in all exposures [DN^2].
fn noise_in_time(patch: &FullWellPatch) -> f64 {
    let exposure = patch.scene.bench.exposure;
    exposure.dark_noise_dn.powi(2) - exposure.row_pattern_dn.powi(2)
}

fn figures(
    trials: Trials,
    repeats: &Repeats<SensorRepeat>,
    patch: &FullWellPatch,
    patterns: &PatternCache,
) -> (Vec<Figure>, SensorPlots) {
    let exposure = patch.scene.bench.exposure;
    let k = gain(&patch.scene);
    let electrons = |i: usize| share(i) * patch.electrons;
    let in_time = noise_in_time(patch);
    let transfer = |f: &SensorRepeat| line(FITTED_LEVELS.map(|i| (f.levels[i][0], f.levels[i][1], f.levels[i][1])));
    let response = |f: &SensorRepeat| line(FITTED_LEVELS.map(|i| (electrons(i), f.levels[i][0], 1.0)));
    let bend = |f: &SensorRepeat| {
        let [start, slope] = response(f);
        // A parabola over the fitted levels has a third of its height in the middle's residue, twice a sixth at the
        // ends.
        let off = |i: usize| f.levels[i][0] - start - slope * electrons(i);
        let (first, last) = (*FITTED_LEVELS.start(), *FITTED_LEVELS.end());
        100.0 * (off((first + last) / 2) - 0.5 * (off(first) + off(last))) / (slope * electrons(last))
    };
    let spread = |i: usize| move |f: &SensorRepeat| f.dark[0].variances[i].max(0.0).sqrt();
    let staying = exposure.row_noise_dn.powi(2) + exposure.row_pattern_dn.powi(2);
    let pixel = exposure.dark_noise_dn.powi(2) - staying;
    let full_well = |f: &SensorRepeat| (255.0 - exposure.dark_level_dn) / transfer(f)[1];
    let unlit = in_time + k * k * electrons(0);
    let ratio = 1.0 + staying * PATCH_COLUMNS as f64 / pixel;
    let mut figures = vec![
        repeats.figure("gain K, slope of variance over mean [DN/e-]", |f| transfer(f)[1], k),
        repeats.figure("full well, (255 - dark) / K [e-]", full_well, exposure.full_well_e),
        repeats.figure("noise in time without light [DN]", |f| f.levels[0][1].sqrt(), unlit.sqrt()),
        repeats.figure("response, slope of mean over electrons [DN/e-]", |f| response(f)[1], k),
        repeats.figure("bend of the response, % of its range", bend, 0.0),
        repeats.figure("row noise, new each exposure [DN]", spread(1), exposure.row_noise_dn),
        repeats.figure("row pattern that stays [DN]", spread(2), exposure.row_pattern_dn),
        repeats.figure("pixel in its row, dark [DN]", spread(0), pixel.sqrt()),
        repeats.figure("row means' variance ratio", |f| f.dark[0].ratio, ratio),
        repeats.figure("row means' variance ratio, row noise off", |f| f.dark[1].ratio, 1.0),
        repeats.figure("pixel, row noise off [DN^2]", |f| f.dark[1].variances[0], exposure.dark_noise_dn.powi(2)),
    ];
    figures.extend(TABLE_LEVELS.map(|i| {
        let name = format!("variance at {:.0} DN [DN^2]", exposure.dark_level_dn + k * electrons(i));
        repeats.figure(name, |f| f.levels[i][1], in_time + k * k * electrons(i))
    }));
    let plots = plots(trials, repeats, patch, patterns, figures[0].measured);
    (figures, plots)
}

/// What the picture shows, the gain having been found.
fn plots(
    trials: Trials,
    repeats: &Repeats<SensorRepeat>,
    patch: &FullWellPatch,
    patterns: &PatternCache,
    gain: Estimate,
) -> SensorPlots {
    let exposure = patch.scene.bench.exposure;
    let k = super::targets::gain(&patch.scene);
    let electrons = |i: usize| share(i) * patch.electrons;
    let in_time = noise_in_time(patch);
    // Without light the patch shows its rows' fixed pattern.
    let mean =
        |i: usize| repeats.estimate(|f| f.levels[i][0] - f.levels[0][0] + exposure.dark_level_dn + k * electrons(0));
    let levels = (0..LEVELS).map(|i| (electrons(i), mean(i), repeats.estimate(|f| f.levels[i][1])));
    let curve = (0..=230).map(|i| {
        let e = f64::from(i) * 0.005 * patch.electrons;
        let [mean, variance] = clipped(exposure.dark_level_dn + k * e, in_time + k * k * e);
        [e, mean, variance]
    });
    let frames = [true, false].map(|rows| {
        let mut scene = patch.scene.clone();
        scene.stream = stream("sensor", trials, 0).child("dark");
        dark_frames(&mut scene, rows, patterns).swap_remove(0)
    });
    let spectra =
        [0, 1].map(|on| (0..=PATCH_COLUMNS / 2).map(|i| repeats.estimate(|f| f.dark[on].spectrum[i]).value).collect());
    SensorPlots {
        levels: levels.collect(),
        expected: curve.collect(),
        gain,
        spectra,
        frames,
        modes: modes(patch, patterns),
        scene: patch.scene.clone(),
    }
}

/// Mean and variance of a normal number that is clipped at 255 [DN, DN^2].
fn clipped(mean: f64, variance: f64) -> [f64; 2] {
    // The twelfth that rounding adds is in the variance; what is clipped has none.
    let sigma = variance.sqrt();
    let t = (255.0 - mean) / sigma;
    let (below, density) = (normal_below(t), libm::exp(-0.5 * t * t) / (2.0 * PI).sqrt());
    // Of min(x, t) for a standard normal x.
    let first = -density + t * (1.0 - below);
    let second = below - t * density + t * t * (1.0 - below);
    [mean + sigma * first, variance * (second - first * first)]
}

/// Exposures at each level, the number of levels, and the least and the most light [full wells].
const SLOPE_EXPOSURES: usize = 12;
const SLOPE_LEVELS: usize = 27;
const SLOPE_LIGHT: [f64; 2] = [0.03, 20.0];

/// Photon transfer of one mode.
struct SlopeMode {
    hdr: Hdr,
    /// Light [full wells], mean over dark [DN], variance in time [DN^2] at each level, as measured.
    measured: Vec<[f64; 3]>,
    /// The same by theory, up to the light that fills a pixel.
    expected: Vec<[f64; 3]>,
}

/// Every mode.
fn modes(patch: &FullWellPatch, patterns: &PatternCache) -> Vec<SlopeMode> {
    Hdr::ALL.into_iter().map(|hdr| mode(patch, hdr, patterns)).collect()
}

fn slope_light(level: usize) -> f64 {
    SLOPE_LIGHT[0] * libm::pow(SLOPE_LIGHT[1] / SLOPE_LIGHT[0], level as f64 / (SLOPE_LEVELS - 1) as f64)
}

fn mode(patch: &FullWellPatch, hdr: Hdr, patterns: &PatternCache) -> SlopeMode {
    let exposure = patch.scene.bench.exposure;
    let one = |level: usize| {
        let mut scene = patch.scene.clone();
        scene.readout = Readout { bits: 8, hdr };
        scene.bench.exposure.time_us *= slope_light(level);
        let [mean, variance] = patch_moments(&scene, BARE_PROFILE + level * SLOPE_EXPOSURES, SLOPE_EXPOSURES, patterns);
        [slope_light(level), mean - exposure.dark_level_dn, variance]
    };
    let most = 255.0 - exposure.dark_level_dn;
    let rest = 0.5 / hdr.gain();
    let still = noise_in_time(patch);
    let theory = |i: usize| {
        let phi = SLOPE_LIGHT[0] * libm::pow(hdr.gain() / SLOPE_LIGHT[0], i as f64 / 100.0);
        let bent = hdr != Hdr::None && phi * (1.0 - rest) > 0.5;
        let (level, noisy) = if bent { (0.5 + rest * phi, rest * phi) } else { (phi, phi) };
        [phi, most * level, still + gain(&patch.scene) * most * noisy]
    };
    SlopeMode { hdr, measured: (0..SLOPE_LEVELS).map(one).collect(), expected: (0..=100).map(theory).collect() }
}

/// For the study's document.
fn slope_document(modes: &[SlopeMode]) -> Value {
    let row = |[light, mean, variance]: &[f64; 3]| {
        json!({ "light_full_wells": light, "mean_dn": mean,
        "variance_dn2": variance })
    };
    let one = |mode: &SlopeMode| {
        json!({ "hdr": mode.hdr.name(),
        "levels": mode.measured.iter().map(row).collect::<Vec<_>>() })
    };
    modes.iter().map(one).collect()
}

/// Side of a cut of a dark frame [px], and pixels of the page for each of its.
const CUT_PX: u32 = 120;
const ZOOM: u32 = 2;

fn draw(plots: &SensorPlots, table: &str) -> RgbImage {
    let heading = Heading {
        title: "The sensor by photon transfer",
        subtitle: "A white plane under a broad line without speckle, exposed again and again; read off digital \
            numbers alone. Grey: theory.",
    };
    let mut page = page(2, 3, heading, table);
    draw_transfer(&mut page, plots);
    draw_spectra(&mut page, plots);
    draw_frames(&mut page, plots);
    draw_slopes(&mut page, plots);
    page.0
}

/// Photon transfer and linearity.
fn draw_transfer(page: &mut Page, plots: &SensorPlots) {
    let (k, dark) = (gain(&plots.scene), plots.scene.bench.exposure.dark_level_dn);
    let Area { left: x, top: y, .. } = chart(
        page,
        [0, 0],
        "Photon transfer: the slope is the gain",
        Axis::even("mean [DN]", 0.0, 265.0),
        Axis::even("variance in time [DN^2]", 0.0, 4.0),
        vec![
            Series::curve(GREY, plots.expected.iter().map(|e| (e[1], e[2]))),
            Series::marks(BLUE, plots.levels.iter().map(|(_, mean, v)| (mean.value, v.value, v.error))),
        ],
    );
    page.words_in(x + 74, y + 66, &format!("K = {:.6} +- {:.6} DN/e-", plots.gain.value, plots.gain.error), BLUE);
    page.words_in(x + 74, y + 82, &format!("set: {k:.6}"), GREY);
    page.words_in(x + 400, y + 230, "clipped at 255", GREY);

    chart(
        page,
        [1, 0],
        "Linearity: mean less dark and K e, % of full",
        Axis::even("electrons / 1000", 0.0, 29.0),
        Axis::even("[%]", -0.15, 0.15),
        vec![
            Series::curve(
                GREY,
                plots.expected.iter().map(|e| (e[0] / 1e3, 100.0 * (e[1] - dark - k * e[0]) / (255.0 - dark))),
            ),
            Series::marks(
                BLUE,
                plots.levels.iter().map(|(e, mean, _)| {
                    let off = mean.value - dark - k * e;
                    (e / 1e3, 100.0 * off / (255.0 - dark), 100.0 * mean.error / (255.0 - dark))
                }),
            ),
        ],
    );
}

/// Spectra of dark frames.
fn draw_spectra(page: &mut Page, plots: &SensorPlots) {
    let exposure = plots.scene.bench.exposure;
    let n = 2.0 * (plots.spectra[0].len() - 1) as f64;
    let spectrum = |i: usize| plots.spectra[i].iter().enumerate().map(move |(f, p)| (f as f64 / n, *p));
    let level =
        |i: usize| if i == 0 { exposure.dark_noise_dn.powi(2) - rows(plots) } else { exposure.dark_noise_dn.powi(2) };
    let zero = |power: f64| [(0.0, power, 0.0)];
    let Area { left: x, top: y, .. } = chart(
        page,
        [0, 1],
        "Dark frames: power along the rows",
        Axis::even("cycles a pixel", -0.01, 0.5),
        Axis::log("[DN^2]", 0.5, 100.0),
        vec![
            Series::curve(GREY, [0.0, 0.5].map(|f| (f, level(0))).into_iter()),
            Series::curve(GREY, [0.0, 0.5].map(|f| (f, level(1))).into_iter()),
            Series::curve(ORANGE, spectrum(1).skip(1)),
            Series::curve(BLUE, spectrum(0).skip(1)),
            Series::marks(ORANGE, zero(plots.spectra[1][0])),
            Series::marks(BLUE, zero(plots.spectra[0][0])),
        ],
    );
    legend(page, x + 90, y + 70, &[(BLUE, "rows stand out (as set)"), (ORANGE, "row noise and pattern off")]);
    page.words_in(x + 66, y + 120, "<- row means: frequency 0", GREY);
}

/// Cuts of dark frames.
fn draw_frames(page: &mut Page, plots: &SensorPlots) {
    let Area { left: x, top: y, .. } = area(1, 1);
    page.words(x, y + 12, "Dark frames, 120 x 120 pixels, 9 to 15 DN");
    for (i, (frame, words)) in
        plots.frames.iter().zip(["rows stand out (as set)", "row noise and pattern off"]).enumerate()
    {
        let left = x + 20 + i as u32 * (CUT_PX * ZOOM + 30);
        let columns = frame.len() as u32 / plots.scene.size.rows as u32;
        let picture = RgbImage::from_fn(CUT_PX * ZOOM, CUT_PX * ZOOM, |px, py| {
            let dn = frame[(py / ZOOM * columns + px / ZOOM) as usize];
            let grey = ((f32::from(dn) - 9.0) / 6.0).clamp(0.0, 1.0) * 255.0;
            Rgb([grey as u8; 3])
        });
        page.picture(left, y + 40, &picture);
        page.words_in(left, y + 40 + CUT_PX * ZOOM + 16, words, [BLUE, ORANGE][i]);
    }
    let words = "mean 11.6, sd 1.09 DN in both";
    page.words_in(x + 20, y + 40 + CUT_PX * ZOOM + 34, words, INK);
}

/// Numbers and noise over light with one slope and with two.
fn draw_slopes(page: &mut Page, plots: &SensorPlots) {
    const COLOURS: [Rgb<u8>; 4] = [BLUE, ORANGE, PURPLE, GREEN];
    let light = || Axis::log("light / light that fills one slope", 0.03, 20.0);
    for (place, title, axis) in [
        (0, "Two slopes: mean less dark", Axis::even("[DN]", 0.0, 260.0)),
        (1, "Two slopes: variance in time", Axis::even("[DN^2]", 0.0, 4.0)),
    ] {
        let theory =
            plots.modes.iter().map(|mode| Series::curve(GREY, mode.expected.iter().map(|v| (v[0], v[1 + place]))));
        let measured = plots.modes.iter().zip(COLOURS);
        let measured = measured
            .map(|(mode, colour)| Series::marks(colour, mode.measured.iter().map(|v| (v[0], v[1 + place], 0.0))));
        let area = chart(page, [place as u32, 2], title, light(), axis, theory.chain(measured).collect());
        let names: Vec<_> =
            COLOURS.into_iter().zip(&plots.modes).map(|(colour, mode)| (colour, mode.hdr.name())).collect();
        legend(page, area.left + 90, area.top + 70, &names);
    }
}

/// Variance that rows have of their own [DN^2].
fn rows(plots: &SensorPlots) -> f64 {
    let exposure = plots.scene.bench.exposure;
    exposure.row_noise_dn.powi(2) + exposure.row_pattern_dn.powi(2)
}
