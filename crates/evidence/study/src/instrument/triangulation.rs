//! Triangulation on flat targets: mean error and spread of Range, height of a row, width of a column.
//!
//! Metal plates, level and tilted along each axis, and level white ceramic, are rendered from body to Range map. The
//! truth is the plane itself. Expected spread of the centre of gravity over rows k with light I_k [DN], to first order
//! in noise:
//!
//! ```text
//! var = sum (k - c)^2 (s^2 + K I_k) / S^2 + sum (k - c) (l - c) C_k I_k C_l I_l r(k - l) / S^2 + 1 / (12 * 16^2),
//! ```
//!
//! S = sum I_k, s the noise in time without light, C_k and r contrast and correlation of speckle, the last term the
//! rounding to a sixteenth of a row. Height of a row and width of a column are held to the projection of
//! docs/theory/instrument.md: row = c - v Yc / Zc / cos(beta) / pixel and x = (col - c) pixel (d - f - z cos a) / f,
//! which are written out here once more. A last plate is seen in the corner of the field of a bent lens on a sensor
//! whose tilt breaks the Scheimpflug rule. The fixed pattern of rows shifts a whole level plate; it is drawn anew in
//! every repeat and stands in the errors.

use base::Body;
use glam::DVec2;
use image::{Rgb, RgbImage};
use serde_json::json;

use super::centroid;
use super::closed_forms::{column_width, height_per_row, row_up};
use super::layout::{BLUE, CHART_WIDTH, GREEN, GREY, Heading, ORANGE, PURPLE, area, chart, legend, page};
use super::targets::{TargetView, ceramic, expose_to_peak, gain, plate, scene, stream};
use super::{Figure, Repeats, Trials, document, mean_and_variance, table};
use crate::{StudyProgress, StudyReport};
use drawing::chart::{Axis, Series};
use drawing::{Area, MARGIN, Page};
use optical_bench::parameters::Bench;
use optical_bench::settings::Scheimpflug;
use pipeline;
use recipe::Scene;
use rig::{PixelCorrelation, grain_px};
use scanner::optics::ROWS;
use scanner::optics::speckle::PatternCache;
use transport::answer::Estimate;

/// Heights of the plates [mm].
const HEIGHTS_MM: [f64; 8] = [2.0, 9.0, 16.0, 23.0, 30.0, 37.0, 44.0, 51.0];
/// Slopes of the plates along the line and along the motion [1].
const SLOPES: [(f64, f64); 3] = [(0.0, 0.0), (0.15, 0.0), (0.0, 0.15)];
/// Heights of the plates that the table shows.
const TABLE_HEIGHTS: [usize; 3] = [0, 3, 7];
const COLUMNS: usize = 256;
/// Profiles of a plate, and those of them at its front edge that are left out: there light from below sees the edge.
const PROFILES: usize = 40;
const EDGE_PROFILES: usize = 4;
const CERAMIC_EDGE_PROFILES: usize = 40;
/// Profiles of the map that is drawn.
const MAP_PROFILES: usize = 112;
/// Brightest pixel [DN over dark].
const PEAK_DN: f64 = 185.0;

/// Mean error, its spread, line of Range over columns.
#[derive(Clone, Copy)]
struct PlateError {
    /// Mean of Range less truth [um].
    error: f64,
    /// Standard deviation of Range less truth [um].
    spread: f64,
    /// Slope of Range along columns over that of the truth [1].
    scale: f64,
}

/// What one repeat measures.
struct TriangulationRepeat {
    /// By slope and height.
    plates: Vec<Vec<PlateError>>,
    /// Level ceramic with speckle, by shown height.
    ceramic: Vec<PlateError>,
    /// Sensor row of the line on level plates by height [px].
    rows: Vec<f64>,
    /// Mean error at the edge of a bent lens's field [um].
    bent: f64,
}

/// What is expected of the repeats.
struct TriangulationTheory {
    bench: Bench,
    /// Spread on level plates by height [um].
    level: Vec<f64>,
    /// Spread on ceramic by shown height [um].
    ceramic: Vec<f64>,
}

impl TriangulationRepeat {
    /// Height of a row between a height and the next [um].
    fn row_um(&self, i: usize) -> f64 {
        1000.0 * (HEIGHTS_MM[i + 1] - HEIGHTS_MM[i]) / (self.rows[i + 1] - self.rows[i])
    }

    /// Width of a column at a height [um].
    fn column_um(&self, i: usize, bench: &Bench) -> f64 {
        1000.0 * column_width(bench, HEIGHTS_MM[i]) * self.plates[1][i].scale
    }
}

/// Runs the study.
pub fn study(trials: Trials, progress: StudyProgress) -> StudyReport {
    let patterns = PatternCache::new(trials.seed);
    let repeats = Repeats::run(trials, progress, |one| measure(trials, one, &patterns));
    let own = stream("triangulation", trials, 0);
    let (figures, theory) = figures(own, &repeats, &patterns);
    let table = table("Triangulation", trials, &figures, &[]);
    let mut json = document("triangulation", trials, &figures);
    let plates = |slope: usize| {
        let at = |i: usize| {
            let (error, spread) = (repeats.estimate(error(slope, i)), repeats.estimate(spread(slope, i)));
            json!({ "height_mm": HEIGHTS_MM[i], "error_um": error, "spread_um": spread })
        };
        json!({ "slopes": SLOPES[slope], "heights": (0..HEIGHTS_MM.len()).map(at).collect::<Vec<_>>() })
    };
    json["plates"] = (0..SLOPES.len()).map(plates).collect();
    let body = ceramic(23.0);
    let mut scene = set(own.child("map"), &body, true, &patterns);
    scene.size.profiles = CERAMIC_EDGE_PROFILES + MAP_PROFILES;
    let map = errors(&scene, body, CERAMIC_EDGE_PROFILES, &patterns, TiltedPlane::level(23.0)).0;
    StudyReport { picture: draw(&repeats, &theory, &map, &table), table, json, figures }
}

/// Mean error of Range on a plate [um].
fn error(slope: usize, height: usize) -> impl Fn(&TriangulationRepeat) -> f64 {
    move |repeat| repeat.plates[slope][height].error
}

/// Spread of Range on a plate [um].
fn spread(slope: usize, height: usize) -> impl Fn(&TriangulationRepeat) -> f64 {
    move |repeat| repeat.plates[slope][height].spread
}

/// A scene over a plate of metal without speckle, or of ceramic with it.
fn set(own: base::Stream, body: &Body, speckle: bool, patterns: &PatternCache) -> Scene {
    let edge = if speckle { CERAMIC_EDGE_PROFILES } else { EDGE_PROFILES };
    let mut scene = scene(own, COLUMNS, edge + PROFILES);
    if !speckle {
        scene.bench.speckle.strength = 0.0;
    }
    expose_to_peak(&mut scene, body, patterns, edge + PROFILES / 2, PEAK_DN);
    scene
}

/// The plane that a target is.
#[derive(Clone, Copy)]
struct TiltedPlane {
    /// Height at the origin [mm].
    height_mm: f64,
    /// Slopes along the line and along the motion [1].
    slope: DVec2,
}

impl TiltedPlane {
    fn level(height_mm: f64) -> Self {
        Self { height_mm, slope: DVec2::ZERO }
    }
}

/// Range less truth away from the front edge, `[profiles, columns]` [um].
fn errors(scene: &Scene, body: Body, edge: usize, patterns: &PatternCache, plane: TiltedPlane) -> (Vec<f64>, f64) {
    let record = pipeline::render_body(scene, body, patterns, &|_| ());
    let (bench, middle) = (&scene.bench, 0.5 * (COLUMNS as f64 - 1.0));
    let (mut errors, mut over, mut under) = (Vec::new(), 0.0, 0.0);
    for profile in edge..scene.size.profiles {
        let y = profile as f64 * bench.motion.step_mm;
        for column in 0..COLUMNS {
            // z = h + slope x, x = (col - c) (w0 + w1 z): both are straight.
            let u = column as f64 - middle;
            let (w0, step) = (column_width(bench, 0.0), column_width(bench, 0.0) - column_width(bench, 1.0));
            let start = plane.height_mm + plane.slope.y * y;
            let truth = (start + plane.slope.x * u * w0) / (1.0 + plane.slope.x * u * step);
            let range = f64::from(record.maps.range[profile * COLUMNS + column]);
            errors.push(1000.0 * (range - truth));
            over += (range - start) * (truth - start);
            under += (truth - start) * (truth - start);
        }
    }
    (errors, if under > 0.0 { over / under } else { 1.0 })
}

fn plate_error(scene: &Scene, body: Body, patterns: &PatternCache, plane: TiltedPlane) -> PlateError {
    let (errors, scale) = errors(scene, body, scene.size.profiles - PROFILES, patterns, plane);
    let (error, variance) = mean_and_variance(errors.iter().copied());
    PlateError { error, spread: variance.sqrt(), scale }
}

fn measure(trials: Trials, one: u64, patterns: &PatternCache) -> TriangulationRepeat {
    let own = stream("triangulation", trials, one);
    // Other repeats lie on other own_patterns of speckle.
    let own_patterns = PatternCache::new(trials.seed.wrapping_mul(1 << 20).wrapping_add(one));
    let metal = |slope: usize, i: usize| {
        let (x, y) = SLOPES[slope];
        let body = plate(HEIGHTS_MM[i] as f32, x as f32, y as f32);
        let scene = set(own.child("metal").index((slope * HEIGHTS_MM.len() + i) as u64), &body, false, patterns);
        plate_error(&scene, body, patterns, TiltedPlane { height_mm: HEIGHTS_MM[i], slope: DVec2::new(x, y) })
    };
    let white = |i: usize| {
        let body = ceramic(HEIGHTS_MM[i] as f32);
        let scene = set(own.child("ceramic").index(i as u64), &body, true, &own_patterns);
        plate_error(&scene, body, &own_patterns, TiltedPlane::level(HEIGHTS_MM[i]))
    };
    let row = |i: usize| {
        let body = plate(HEIGHTS_MM[i] as f32, 0.0, 0.0);
        centre(&set(own.child("row").index(i as u64), &body, false, patterns), body, patterns)
    };
    TriangulationRepeat {
        plates: (0..SLOPES.len()).map(|slope| (0..HEIGHTS_MM.len()).map(|i| metal(slope, i)).collect()).collect(),
        ceramic: TABLE_HEIGHTS.map(white).to_vec(),
        rows: (0..HEIGHTS_MM.len()).map(row).collect(),
        bent: bent(own.child("bent"), patterns),
    }
}

/// Mean error on a level plate at the edge of the field of a bent lens, on a sensor out of the rule of Scheimpflug
/// [um].
fn bent(own: base::Stream, patterns: &PatternCache) -> f64 {
    let body = plate(HEIGHTS_MM[TABLE_HEIGHTS[1]] as f32, 0.0, 0.0);
    let mut scene = scene(own, COLUMNS, EDGE_PROFILES + PROFILES);
    scene.bench.speckle.strength = 0.0;
    let (camera, optics) = (&mut scene.bench.camera, &mut scene.bench.optics);
    (camera.distortion_k1, camera.distortion_k2, camera.distortion_p1) = (-0.06, 0.05, 5e-4);
    (camera.sensor_tilt_deg, camera.focus_distance_mm) = (7.0, 405.0);
    (optics.scheimpflug, optics.offset_columns) = (Scheimpflug::Given, 1100.0);
    expose_to_peak(&mut scene, &body, patterns, EDGE_PROFILES + PROFILES / 2, PEAK_DN);
    plate_error(&scene, body, patterns, TiltedPlane::level(HEIGHTS_MM[TABLE_HEIGHTS[1]])).error
}

/// Rows that the line's centre of gravity lies above the sensor's middle, mean over columns of some exposures [px].
fn centre(scene: &Scene, body: Body, patterns: &PatternCache) -> f64 {
    let look = TargetView::new(scene, body, patterns, EDGE_PROFILES..EDGE_PROFILES + 8);
    let dark = scene.bench.exposure.dark_level_dn;
    let (mut sum, mut moment) = (0.0, 0.0);
    for profile in EDGE_PROFILES..EDGE_PROFILES + 8 {
        let frame = look.frame(profile);
        // All light is within eight rows of the middle of the window.
        for k in ROWS / 2 - 8..=ROWS / 2 + 8 {
            for column in 0..COLUMNS {
                let light = f64::from(frame.dn[k * COLUMNS + column]) - dark;
                sum += light;
                moment += light * (k as f64 + f64::from(frame.first_row[column]));
            }
        }
    }
    0.5 * (scene.size.rows as f64 - 1.0) - moment / sum
}

/// Standard deviation of Range that noise and speckle make in the middle column, the whole column's shift left out
/// [um].
fn expected(scene: &Scene, body: &Body, patterns: &PatternCache, correlation: &PixelCorrelation) -> f64 {
    let profile = scene.size.profiles - PROFILES / 2;
    let look = TargetView::new(scene, body.clone(), patterns, profile..profile + 1);
    let (k, exposure) = (gain(scene), &scene.bench.exposure);
    let light = look.light(profile);
    let line: Vec<f64> = (0..ROWS).map(|row| k * light[row * COLUMNS + COLUMNS / 2]).collect();
    let still = exposure.dark_noise_dn.powi(2) - exposure.row_pattern_dn.powi(2);
    let contrasts = look.contrasts_from_below(profile);
    let variance = centroid::spread(&line, scene.extraction.window_rows, still, k, &contrasts, correlation)
        + 1.0 / (12.0 * f64::from(scene.extraction.subpixel_steps).powi(2));
    let z = f64::from(body.bounds().1.z);
    1000.0 * height_per_row(&scene.bench, z) * variance.sqrt()
}

/// Errors and spreads of Range on plates, and spreads expected on ceramic [um].
fn plate_figures(
    repeats: &Repeats<TriangulationRepeat>,
    own: base::Stream,
    patterns: &PatternCache,
    level: &[f64],
    correlation: &PixelCorrelation,
) -> (Vec<Figure>, Vec<f64>) {
    let names = ["level", "dz/dx .15", "dz/dy .15"];
    let mut white = Vec::new();
    let mut figures = Vec::new();
    for (slope, name) in names.iter().enumerate() {
        for i in TABLE_HEIGHTS {
            let z = HEIGHTS_MM[i];
            let name = format!("{name}, {z:.0} mm: mean error [um]");
            figures.push(repeats.figure(name, error(slope, i), 0.0));
        }
    }
    for i in TABLE_HEIGHTS {
        let name = format!("level, {:.0} mm: spread [um]", HEIGHTS_MM[i]);
        figures.push(repeats.figure(name, spread(0, i), level[i]));
    }
    for (place, i) in TABLE_HEIGHTS.into_iter().enumerate() {
        let z = HEIGHTS_MM[i];
        let body = ceramic(z as f32);
        let scene = set(own, &body, true, patterns);
        let theory = expected(&scene, &body, patterns, correlation);
        let name = format!("ceramic, {z:.0} mm: mean error [um]");
        figures.push(repeats.figure(name, |f| f.ceramic[place].error, 0.0));
        let name = format!("ceramic, {z:.0} mm: spread, speckle too [um]");
        figures.push(repeats.figure(name, |f| f.ceramic[place].spread, theory));
        white.push(theory);
    }
    (figures, white)
}

fn figures(
    own: base::Stream,
    repeats: &Repeats<TriangulationRepeat>,
    patterns: &PatternCache,
) -> (Vec<Figure>, TriangulationTheory) {
    let bench = scene(own, COLUMNS, 1).bench;
    let correlation = PixelCorrelation::of(grain_px(&bench));
    let expect = |z: &f64| {
        let body = plate(*z as f32, 0.0, 0.0);
        expected(&set(own, &body, false, patterns), &body, patterns, &correlation)
    };
    let level: Vec<f64> = HEIGHTS_MM.iter().map(expect).collect();
    let (mut figures, white) = plate_figures(repeats, own, patterns, &level, &correlation);
    let name = format!("bent lens, field's edge, {:.0} mm: mean error [um]", HEIGHTS_MM[TABLE_HEIGHTS[1]]);
    figures.push(repeats.figure(name, |f| f.bent, 0.0));
    let truth = |i: usize| {
        1000.0 * (HEIGHTS_MM[i + 1] - HEIGHTS_MM[i])
            / (row_up(&bench, HEIGHTS_MM[i + 1]) - row_up(&bench, HEIGHTS_MM[i]))
    };
    for i in [0, 3, 6] {
        let name = format!("height of a row, {:.0} to {:.0} mm [um]", HEIGHTS_MM[i], HEIGHTS_MM[i + 1]);
        figures.push(repeats.figure(name, |f| f.row_um(i), truth(i)));
    }
    for i in TABLE_HEIGHTS {
        let name = format!("width of a column at {:.0} mm [um]", HEIGHTS_MM[i]);
        let theory = 1000.0 * column_width(&bench, HEIGHTS_MM[i]);
        figures.push(repeats.figure(name, |f| f.column_um(i, &bench), theory));
    }
    (figures, TriangulationTheory { bench, level, ceramic: white })
}

/// Ends of the map's scale [um].
const MAP_LIMIT_UM: f64 = 45.0;

fn draw(repeats: &Repeats<TriangulationRepeat>, theory: &TriangulationTheory, map: &[f64], table: &str) -> RgbImage {
    let heading = Heading {
        title: "Triangulation on flat targets",
        subtitle: "Range of level and tilted plates, rendered from body to map, less the plane itself. Grey: theory.",
    };
    let mut page = page(2, 2, heading, table);
    let z = || (0..=110).map(|i| 0.5 * f64::from(i));
    let aside = |slope: usize| 0.8 * (slope as f64 - 1.0);

    let colours = [BLUE, ORANGE, PURPLE];
    let mark = |z: f64, Estimate { value, error }: Estimate| (z, value, error);
    let errors = |slope: usize| {
        let at = |i: usize| mark(HEIGHTS_MM[i] + aside(slope), repeats.estimate(error(slope, i)));
        Series::marks(colours[slope], (0..HEIGHTS_MM.len()).map(at))
    };
    let Area { left: x, top: y, .. } = chart(
        &mut page,
        [0, 0],
        "Mean error of Range, metal plates",
        Axis::even("height [mm]", 0.0, 55.0),
        Axis::even("[um]; bars: standard errors", -2.0, 2.0),
        vec![Series::curve(GREY, [(0.0, 0.0), (55.0, 0.0)]), errors(0), errors(1), errors(2)],
    );
    legend(&mut page, x + 380, y + 52, &[(BLUE, "level"), (ORANGE, "dz/dx = 0.15"), (PURPLE, "dz/dy = 0.15")]);
    page.words_in(x + 60, y + 52, "1 um is 1/200 row", GREY);

    let level = (0..HEIGHTS_MM.len()).map(|i| mark(HEIGHTS_MM[i], repeats.estimate(spread(0, i))));
    let white = (0..TABLE_HEIGHTS.len())
        .map(|place| mark(HEIGHTS_MM[TABLE_HEIGHTS[place]], repeats.estimate(|f| f.ceramic[place].spread)));
    let Area { left: x, top: y, .. } = chart(
        &mut page,
        [1, 0],
        "Spread of Range, level plates",
        Axis::even("height [mm]", 0.0, 55.0),
        Axis::even("standard deviation [um]", 0.0, 16.0),
        vec![
            Series::curve(GREY, HEIGHTS_MM.into_iter().zip(theory.level.iter().copied())),
            Series::curve(GREY, TABLE_HEIGHTS.iter().zip(&theory.ceramic).map(|(i, um)| (HEIGHTS_MM[*i], *um))),
            Series::marks(BLUE, level),
            Series::marks(GREEN, white),
        ],
    );
    legend(&mut page, x + 300, y + 52, &[(GREEN, "ceramic, speckle and noise"), (BLUE, "metal, sensor noise alone")]);

    let row = |i: usize| mark(0.5 * (HEIGHTS_MM[i] + HEIGHTS_MM[i + 1]), repeats.estimate(|f| f.row_um(i)));
    let column = |i: usize| mark(HEIGHTS_MM[i], repeats.estimate(|f| f.column_um(i, &theory.bench)));
    let Area { left: x, top: y, .. } = chart(
        &mut page,
        [0, 1],
        "A row in height, a column in width",
        Axis::even("height [mm]", 0.0, 55.0),
        Axis::even("[um]", 60.0, 240.0),
        vec![
            Series::curve(GREY, z().map(|z| (z, 1000.0 * height_per_row(&theory.bench, z)))),
            Series::curve(GREY, z().map(|z| (z, 1000.0 * column_width(&theory.bench, z)))),
            Series::marks(BLUE, (0..HEIGHTS_MM.len() - 1).map(row)),
            Series::marks(ORANGE, (0..HEIGHTS_MM.len()).map(column)),
        ],
    );
    legend(
        &mut page,
        x + 270,
        y + 180,
        &[(BLUE, "height of a row, level plates"), (ORANGE, "width of a column, dz/dx = 0.15")],
    );

    let Area { left: x, top: y, .. } = area(1, 1);
    page.words(x, y + 12, "Range less truth on level ceramic at 23 mm, speckle and noise");
    page.words(x, y + 28, "columns right, profiles down");
    draw_error_map(&mut page, x, y + 40, map);
    page.0
}

/// Draws Range less truth, `[profiles, COLUMNS]` [um].
fn draw_error_map(page: &mut Page, left: u32, top: u32, errors: &[f64]) {
    let rows = errors.len() / COLUMNS;
    let (width, height) = (CHART_WIDTH - MARGIN, (CHART_WIDTH - MARGIN) * rows as u32 / COLUMNS as u32);
    let at = |px: u32, py: u32| {
        let (column, row) = (px as usize * COLUMNS / width as usize, py as usize * rows / height as usize);
        errors[row * COLUMNS + column]
    };
    let picture = RgbImage::from_fn(width, height, |px, py| diverging(at(px, py) / MAP_LIMIT_UM));
    page.picture(left, top, &picture);
    let ramp = |t: f32| diverging(2.0 * f64::from(t) - 1.0);
    page.bar(
        left,
        top + height + 12,
        width / 2,
        &format!("-{MAP_LIMIT_UM:.0}"),
        &format!("+{MAP_LIMIT_UM:.0} um"),
        &ramp,
    );
}

/// Blue below, white at 0, red above, for a number in [-1, 1].
fn diverging(t: f64) -> Rgb<u8> {
    let t = t.clamp(-1.0, 1.0);
    let end = if t < 0.0 { [33.0, 90.0, 160.0] } else { [190.0, 60.0, 30.0] };
    Rgb([0, 1, 2].map(|c| (248.0 + (end[c] - 248.0) * t.abs()) as u8))
}
