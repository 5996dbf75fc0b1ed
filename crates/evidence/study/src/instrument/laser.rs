//! The laser line: width over height, light along the line, and electrons of a column.
//!
//! Width: exposures of a level metal plate are averaged and fitted with a Gaussian; less the variance of lens and pixel
//! it is the laser's, in mm through the rows per mm of the projection. It is held to a Gaussian beam (Siegman 1986),
//!
//! ```text
//! w(z) = w0 sqrt(1 + ((z - z0) / zR)^2),    zR = pi w0^2 / (M^2 lambda),
//! ```
//!
//! and w^2, a parabola in z, gives waist, its height and M^2 back. Light: a white Lambertian plane at z = 0, of which a
//! column gets (docs/theory/instrument.md)
//!
//! ```text
//! P / (2 h tan(Phi/2)) width (D/2)^2 cos(phi) cos(theta) / r^2 T t QE lambda / (h c).
//! ```
//!
//! The closed forms stand in `closed_forms`.

use std::f64::consts::PI;

use glam::{DMat3, DVec3};
use image::RgbImage;
use serde_json::json;

use super::closed_forms::{box_error, electrons, half_width, lens_variance, rows_per_mm};
use super::layout::{BLUE, CHART_HEIGHT, CHART_WIDTH, GREY, Heading, ORANGE, area, chart, legend, page};
use super::targets::{
    BARE_PROFILE, TargetView, bare, expose_to_peak, gain, metal_radiance_factor, plate, scene, stream,
};
use super::{Figure, Repeats, Trials, document, table};
use crate::{StudyProgress, StudyReport};
use drawing::chart::{Axis, Series};
use drawing::{Area, MARGIN, Page, viridis};
use optical_bench::parameters::Bench;
use optical_bench::settings::Size;
use recipe::Scene;
use scanner::optics::camera::rig;
use scanner::optics::speckle::PatternCache;
use scanner::optics::{CENTRE, ROWS};
use transport::answer::Estimate;

/// Heights of the plate [mm].
const HEIGHTS_MM: [f64; 9] = [-50.0, -35.0, -20.0, -5.0, 10.0, 25.0, 40.0, 55.0, 70.0];
/// Indices of the heights whose light the table shows.
const LIT_HEIGHTS: [usize; 3] = [2, 4, 6];
/// Exposures averaged for a line, and columns of the plate.
const EXPOSURES: usize = 8;
const COLUMNS: usize = 128;
/// Columns of the whole sensor.
const SENSOR_COLUMNS: usize = 2560;
/// Fan whose ends lie on the sensor [deg].
const NARROW_FAN_DEG: f64 = 27.0;
/// Brightest pixel [DN over dark].
const PEAK_DN: f64 = 170.0;

/// A bench whose electrons are counted.
struct LightBudget {
    name: &'static str,
    bench: Bench,
}

/// What one repeat measures.
struct LaserRepeat {
    /// Half width at 1/e^2 at each height [mm].
    width: Vec<f64>,
    /// Light of the whole line at each height [e-].
    light: Vec<f64>,
    /// Light along the line by default and with a narrow fan, by bins [e-].
    along: [Vec<f64>; 2],
    /// Light of each budget in the middle [e-].
    budgets: Vec<f64>,
}

/// The mean line at a height.
struct MeasuredLine {
    /// Rows per mm [px/mm].
    rows_per_mm: f64,
    /// Where its Gaussian has its middle [px].
    centre: f64,
    /// Top of its Gaussian [e-].
    peak: f64,
    /// Light of each row of the window [e-].
    line: Vec<f64>,
}

/// What the picture shows.
struct LaserPlots {
    bench: Bench,
    width: Vec<Estimate>,
    /// x, light and expected light, by default and with a narrow fan [mm, e-, e-].
    along: [Vec<(f64, Estimate, f64)>; 2],
    /// The line at one height after another.
    beam: Vec<MeasuredLine>,
    /// Waist, its height, M^2.
    beam_fit: [Estimate; 3],
}

/// Runs the study.
pub fn study(trials: Trials, progress: StudyProgress) -> StudyReport {
    let patterns = PatternCache::new(trials.seed);
    let repeats = Repeats::run(trials, progress, |one| measure(trials, one, &patterns));
    let (figures, plots) = figures(&repeats, &patterns);
    let error = 100.0 * box_error(&plots.bench);
    let note = format!(
        "The line on the sensor is a Gaussian that holds the pixel's variance; light gathered over the pixel's box \
            differs\n\
         from it by at most {error:.2} % of the peak. Its sum over whole rows is divided out, so that a column's \
         light does not\n\
         depend on where between rows the line lies.\n\
         Light of the white plane at z = 0 is {:.0} e- a column by default.",
        electrons(&plots.bench, 0.0, 0.0)
    );
    let table = table("Laser", trials, &figures, &[&note]);
    let mut json = document("laser", trials, &figures);
    json["height_mm"] = json!(HEIGHTS_MM);
    json["half_width_mm"] = json!(plots.width);
    json["along"] =
        plots.along[0].iter().map(|(x, e, t)| json!({ "x_mm": x, "electrons_e": e, "theory_e": t })).collect();
    StudyReport { picture: draw(&plots, &table), table, json, figures }
}

/// Benches whose light is counted: those of docs/theory/instrument.md and others that change one factor each.
fn budgets() -> Vec<LightBudget> {
    let nominal = white_scene(1).bench;
    let change = |set: fn(&mut Bench)| {
        let mut bench = nominal;
        set(&mut bench);
        bench
    };
    vec![
        LightBudget { name: "default bench", bench: nominal },
        LightBudget {
            name: "50 mW over 236.4 mm, QE 0.5, 50 us",
            bench: change(|b| {
                (b.exposure.quantum_efficiency, b.exposure.time_us) = (0.5, 50.0);
                b.laser.fan_angle_deg = 2.0 * libm::atan(118.2 / 400.0).to_degrees();
            }),
        },
        LightBudget { name: "f/5.6", bench: change(|b| b.camera.f_number = 5.6) },
        LightBudget { name: "d = 820 mm", bench: change(|b| b.camera.distance_mm = 820.0) },
        LightBudget { name: "405 nm", bench: change(|b| b.laser.wavelength_nm = 405.0) },
    ]
}

/// A white plane at z = 0 under a sensor without speckle.
fn white_scene(columns: usize) -> Scene {
    let mut scene = scene(base::Stream::root(0), columns, BARE_PROFILE + EXPOSURES);
    scene.bench.motion.conveyor_reflectance = 1.0;
    scene.bench.speckle.strength = 0.0;
    scene
}

/// A scene over the metal plate at a height.
fn metal_scene(z: f64, patterns: &PatternCache) -> (Scene, base::Body) {
    let mut scene = scene(base::Stream::root(0), COLUMNS, BARE_PROFILE + EXPOSURES);
    scene.bench.speckle.strength = 0.0;
    let body = plate(z as f32, 0.0, 0.0);
    expose_to_peak(&mut scene, &body, patterns, BARE_PROFILE, PEAK_DN);
    (scene, body)
}

fn measure(trials: Trials, one: u64, patterns: &PatternCache) -> LaserRepeat {
    let own = stream("laser", trials, one);
    let (mut width, mut light) = (Vec::new(), Vec::new());
    for (i, z) in HEIGHTS_MM.into_iter().enumerate() {
        let (mut scene, body) = metal_scene(z, patterns);
        scene.stream = own.child("height").index(i as u64);
        let [all, _, sigma] = fit_gaussian(&mean_line(&exposed_line(&scene, &body, patterns)));
        let lens = lens_variance(&scene.bench, &scene.size) + 1.0 / 12.0;
        width.push(2.0 * (sigma * sigma - lens).max(0.0).sqrt() / rows_per_mm(&scene.bench, &scene.size, z));
        light.push(all / scene.bench.exposure.time_us);
    }
    let along = |fan: Option<f64>| {
        let mut scene = white_scene(SENSOR_COLUMNS);
        scene.stream = own.child("along").index(u64::from(fan.is_some()));
        scene.bench.laser.fan_angle_deg = fan.unwrap_or(scene.bench.laser.fan_angle_deg);
        bin_light(&white_line(scene, patterns))
    };
    let budget = |(i, LightBudget { bench, .. }): (usize, LightBudget)| {
        let mut scene = white_scene(COLUMNS);
        (scene.bench, scene.stream) = (bench, own.child("budget").index(i as u64));
        let bins = bin_light(&white_line(scene, patterns));
        bins.iter().sum::<f64>() / bins.len() as f64
    };
    let along = [along(None), along(Some(NARROW_FAN_DEG))];
    LaserRepeat { width, light, along, budgets: budgets().into_iter().enumerate().map(budget).collect() }
}

/// The line on the white plane, exposed without saturation and scaled to the exposure time of the scene [e-].
fn white_line(scene: Scene, patterns: &PatternCache) -> Vec<Vec<f64>> {
    let mut short = scene.clone();
    expose_to_peak(&mut short, &bare(), patterns, BARE_PROFILE, PEAK_DN);
    let scale = scene.bench.exposure.time_us / short.bench.exposure.time_us;
    let mut line = exposed_line(&short, &bare(), patterns);
    line.iter_mut().flatten().for_each(|light| *light *= scale);
    line
}

/// Mean light of a column of the metal plate at height `z`; its facets reflect less to the sides [e-].
fn metal_electrons(bench: &Bench, z: f64) -> f64 {
    let (sin, cos) = libm::sincos(bench.camera.tilt_deg.to_radians());
    let size = Size { columns: COLUMNS, rows: 1, profiles: 1 };
    let column = |i: usize| {
        let point = DVec3::new(rig(bench, &size).along(i as f64, z), 0.0, z);
        let view = bench.camera.distance_mm * DVec3::new(0.0, -sin, cos) - point;
        let light = DVec3::new(0.0, 0.0, bench.laser.fan_height_mm) - point;
        electrons(bench, point.x, z) * metal_radiance_factor(light.normalize().as_vec3(), view.normalize().as_vec3())
    };
    (0..COLUMNS).map(column).sum::<f64>() / COLUMNS as f64
}

/// Mean of the closed form over the columns of a bin [e-].
fn bin_electrons(bench: &Bench, bin: usize) -> f64 {
    let pitch = (bin_position(1, bench) - bin_position(0, bench)) / BIN_COLUMNS as f64;
    let first = bin_position(bin, bench) - 0.5 * (BIN_COLUMNS as f64 - 1.0) * pitch;
    (0..BIN_COLUMNS).map(|i| electrons(bench, first + i as f64 * pitch, 0.0)).sum::<f64>() / BIN_COLUMNS as f64
}

/// Middle of a bin along the line on the plane z = 0 [mm].
fn bin_position(bin: usize, bench: &Bench) -> f64 {
    let size = Size { columns: SENSOR_COLUMNS, rows: 1, profiles: 1 };
    rig(bench, &size).along((bin * BIN_COLUMNS) as f64 + 0.5 * (BIN_COLUMNS as f64 - 1.0), 0.0)
}

fn figures(repeats: &Repeats<LaserRepeat>, patterns: &PatternCache) -> (Vec<Figure>, LaserPlots) {
    let bench = white_scene(SENSOR_COLUMNS).bench;
    let fit = |i: usize| move |f: &LaserRepeat| fit_beam(&f.width, bench.laser.wavelength_nm)[i];
    let names = ["waist, half width at 1/e^2 [mm]", "height of the waist [mm]", "beam quality M^2 [1]"];
    let set = [bench.laser.waist_mm, bench.laser.waist_height_mm, bench.laser.m_squared];
    let mut figures: Vec<_> = (0..3).map(|i| repeats.figure(names[i], fit(i), set[i])).collect();
    for (i, z) in HEIGHTS_MM.into_iter().enumerate() {
        let name = format!("half width at z = {z:.0} mm [mm]");
        figures.push(repeats.figure(name, |f| f.width[i], half_width(&bench, z)));
    }
    let mut narrow = bench;
    narrow.laser.fan_angle_deg = NARROW_FAN_DEG;
    let at = |bin: usize| bin_position(bin, &bench);
    let expected: Vec<f64> = (0..SENSOR_COLUMNS / BIN_COLUMNS).map(|bin| bin_electrons(&narrow, bin)).collect();
    let name = format!("half light of a {NARROW_FAN_DEG:.0} deg fan at [mm]");
    let theory = half_light(&expected, &bench, at);
    figures.push(repeats.figure(name, |f| half_light(&f.along[1], &bench, at), theory));
    let last = SENSOR_COLUMNS / BIN_COLUMNS - 1;
    let edge =
        |light: &dyn Fn(usize) -> f64| 0.5 * (light(0) + light(last)) / (0.5 * (light(last / 2) + light(last / 2 + 1)));
    let name = "ends of the line over its middle, 45 deg fan [1]";
    figures.push(repeats.figure(name, |f| edge(&|i| f.along[0][i]), edge(&|i| bin_electrons(&bench, i))));
    for (i, LightBudget { name, bench }) in budgets().into_iter().enumerate() {
        let name = format!("white, z = 0, {name} [e-]");
        figures.push(repeats.figure(name, |f| f.budgets[i], electrons(&bench, 0.0, 0.0)));
    }
    for i in LIT_HEIGHTS {
        let z = HEIGHTS_MM[i];
        let name = format!("metal plate at z = {z:.0} mm [e-]");
        figures.push(repeats.figure(name, |f| f.light[i] * bench.exposure.time_us, metal_electrons(&bench, z)));
    }
    let along = [(0, bench), (1, narrow)].map(|(which, bench)| {
        let bin =
            |i: usize| (bin_position(i, &bench), repeats.estimate(|f| f.along[which][i]), bin_electrons(&bench, i));
        (0..=last).map(bin).collect()
    });
    let beam = HEIGHTS_MM.into_iter().map(|z| {
        let (scene, body) = metal_scene(z, patterns);
        let line = mean_line(&exposed_line(&scene, &body, patterns));
        let [light, centre, sigma] = fit_gaussian(&line);
        let peak = light / ((2.0 * PI).sqrt() * sigma);
        MeasuredLine { rows_per_mm: rows_per_mm(&scene.bench, &scene.size, z), centre, peak, line }
    });
    let plots = LaserPlots {
        bench,
        width: (0..HEIGHTS_MM.len()).map(|i| repeats.estimate(|f| f.width[i])).collect(),
        along,
        beam: beam.collect(),
        beam_fit: [0, 1, 2].map(|i| figures[i].measured),
    };
    (figures, plots)
}

/// Columns taken together along the line.
const BIN_COLUMNS: usize = 40;

/// Mean of some exposures less the same without light, a row of the window after another, `[ROWS][columns]` [e-].
fn exposed_line(scene: &Scene, body: &base::Body, patterns: &PatternCache) -> Vec<Vec<f64>> {
    let profiles = BARE_PROFILE..BARE_PROFILE + EXPOSURES;
    let mut dark = scene.clone();
    // As little light as there may be, other noise, the same fixed pattern.
    (dark.bench.laser.power_mw, dark.bench.exposure.time_us) = (0.01, 0.1);
    let lit = TargetView::new(scene, body.clone(), patterns, profiles.clone());
    let unlit = TargetView::new(&dark, body.clone(), patterns, profiles.start + EXPOSURES..profiles.end + EXPOSURES);
    let scale = 1.0 / (gain(scene) * EXPOSURES as f64);
    let columns = scene.size.columns;
    let mut sum = vec![vec![0.0; columns]; ROWS];
    for profile in profiles {
        let (bright, dark) = (lit.frame(profile), unlit.frame(profile + EXPOSURES));
        for (k, row) in sum.iter_mut().enumerate() {
            for (c, sum) in row.iter_mut().enumerate() {
                let at = k * columns + c;
                *sum += scale * (f64::from(bright.dn[at]) - f64::from(dark.dn[at]));
            }
        }
    }
    sum
}

/// Light, centre and standard deviation of a Gaussian by least squares (Gauss and Newton) [e-, px, px].
fn fit_gaussian(line: &[f64]) -> [f64; 3] {
    let peak = (0..line.len()).max_by(|&a, &b| line[a].total_cmp(&line[b])).unwrap_or(0);
    let mut p = [2.5 * line[peak], peak as f64, 1.0];
    for _ in 0..30 {
        let (mut m, mut r) = ([[0.0; 3]; 3], [0.0; 3]);
        for (k, value) in line.iter().enumerate() {
            let t = (k as f64 - p[1]) / p[2];
            let shape = libm::exp(-0.5 * t * t) / ((2.0 * PI).sqrt() * p[2]);
            let slope = [shape, p[0] * shape * t / p[2], p[0] * shape * (t * t - 1.0) / p[2]];
            for i in 0..3 {
                r[i] += slope[i] * (value - p[0] * shape);
                for j in 0..3 {
                    m[i][j] += slope[i] * slope[j];
                }
            }
        }
        let matrix = DMat3::from_cols_array_2d(&m);
        let step = matrix.inverse() * DVec3::from_array(r);
        p = [p[0] + step.x, p[1] + step.y, (p[2] + step.z).clamp(0.3, 8.0)];
    }
    p
}

/// Mean over columns.
fn mean_line(line: &[Vec<f64>]) -> Vec<f64> {
    line.iter().map(|row| row.iter().sum::<f64>() / row.len() as f64).collect()
}

/// Light of each bin of columns: rows about the middle that hold it all [e-].
fn bin_light(line: &[Vec<f64>]) -> Vec<f64> {
    let rows = &line[CENTRE - 8..=CENTRE + 8];
    let column = |c: usize| rows.iter().map(|row| row[c]).sum::<f64>();
    let bin = line[0].len().min(BIN_COLUMNS);
    (0..line[0].len() / bin).map(|b| (b * bin..(b + 1) * bin).map(column).sum::<f64>() / bin as f64).collect()
}

/// Waist, its height and M^2 from the parabola w^2 = a + b z + c z^2 through measured widths [mm, mm, 1].
fn fit_beam(width: &[f64], wavelength_nm: f64) -> [f64; 3] {
    let (mut m, mut r) = ([[0.0; 3]; 3], DVec3::ZERO);
    for (z, w) in HEIGHTS_MM.into_iter().zip(width) {
        let (terms, weight) = (DVec3::new(1.0, z, z * z), w.powi(-4));
        r += weight * w * w * terms;
        for (i, column) in m.iter_mut().enumerate() {
            for (j, entry) in column.iter_mut().enumerate() {
                *entry += weight * terms[i] * terms[j];
            }
        }
    }
    let p = DMat3::from_cols_array_2d(&m).inverse() * r;
    let least = p.x - p.y * p.y / (4.0 * p.z);
    let rayleigh = (least / p.z).sqrt();
    [least.sqrt(), -0.5 * p.y / p.z, PI * least / (rayleigh * wavelength_nm * 1e-6)]
}

/// Distance from the middle at which the light along the line is half of what an even line has there [mm].
fn half_light(bins: &[f64], bench: &Bench, position: impl Fn(usize) -> f64) -> f64 {
    let mut even = *bench;
    even.laser.fan_angle_deg = 60.0;
    let share = |i: usize| bins[i] / electrons(&even, position(i), 0.0);
    let full = share(bins.len() / 2);
    let ends = [1.0, -1.0].map(|side| {
        let at = |i: usize| if side > 0.0 { bins.len() / 2 + i } else { bins.len() / 2 - 1 - i };
        let i = (1..bins.len() / 2).find(|&i| share(at(i)) < 0.5 * full).unwrap_or(1);
        let (near, far) = (share(at(i - 1)), share(at(i)));
        let t = (near - 0.5 * full) / (near - far);
        let (from, to) = (position(at(i - 1)).abs(), position(at(i)).abs());
        from + t * (to - from)
    });
    0.5 * (ends[0] + ends[1])
}

/// How far the line is shown on either side [mm].
const REACH_MM: f64 = 0.4;
/// Rows on either side that a point between rows is made of.
const LOBES: f64 = 5.0;

fn draw(plots: &LaserPlots, table: &str) -> RgbImage {
    let bench = &plots.bench;
    let heading = Heading {
        title: "The laser line",
        subtitle: "Read off averaged frames: its width over height, its light along itself and at several heights. \
            Grey: closed forms.",
    };
    let mut page = page(2, 2, heading, table);

    let heights = || (0..=140).map(|i| -55.0 + f64::from(i));
    let Area { left: x, top: y, .. } = chart(
        &mut page,
        [0, 0],
        "Half width at 1/e^2 over height",
        Axis::even("z [mm]", -60.0, 80.0),
        Axis::even("[mm]", 0.0, 0.3),
        vec![
            Series::curve(GREY, heights().filter(|z| *z <= 75.0).map(|z| (z, half_width(bench, z)))),
            Series::marks(BLUE, HEIGHTS_MM.iter().zip(&plots.width).map(|(z, w)| (*z, w.value, w.error))),
        ],
    );
    let [waist, place, quality] = plots.beam_fit;
    let words = [
        format!("waist   {:.5} +- {:.5} mm, set {}", waist.value, waist.error, bench.laser.waist_mm),
        format!("height  {:.3} +- {:.3} mm, set {}", place.value, place.error, bench.laser.waist_height_mm),
        format!("M^2     {:.4} +- {:.4}, set {}", quality.value, quality.error, bench.laser.m_squared),
    ];
    for (i, words) in words.iter().enumerate() {
        page.words_in(x + 190, y + 240 + 16 * i as u32, words, BLUE);
    }

    let Area { left: x, top: y, .. } = area(1, 0);
    page.words(x, y + 12, "The line across itself over height, as the sensor has it;");
    page.words(x, y + 28, "each height over its own peak; white: the laser's half width alone");
    let inner = Area { left: x + 48, top: y + 40, width: CHART_WIDTH - 48 - MARGIN, height: CHART_HEIGHT - 40 - 40 };
    draw_caustic(&mut page, inner, plots);

    let series = |which: usize, colour| {
        vec![
            Series::curve(GREY, plots.along[which].iter().map(|(x, _, t)| (*x, t / 1e3))),
            Series::marks(colour, plots.along[which].iter().map(|(x, e, _)| (*x, e.value / 1e3, e.error / 1e3))),
        ]
    };
    let Area { left: x, top: y, .. } = chart(
        &mut page,
        [0, 1],
        "Light along the line on a white plane, z = 0",
        Axis::even("x [mm]", -125.0, 125.0),
        Axis::even("electrons a column / 1000, 40 us", 0.0, 160.0),
        [series(0, BLUE), series(1, ORANGE)].concat(),
    );
    legend(
        &mut page,
        x + 180,
        y + 240,
        &[(BLUE, "fan of 45 deg, the default"), (ORANGE, "fan of 27 deg, its ends in sight")],
    );

    let off = plots.along[0].iter().map(|(x, e, t)| (*x, 100.0 * (e.value / t - 1.0), 100.0 * e.error / t));
    let Area { left: x, top: y, .. } = chart(
        &mut page,
        [1, 1],
        "The same over the closed form, 45 deg",
        Axis::even("x [mm]", -125.0, 125.0),
        Axis::even("[%]", -0.5, 0.5),
        vec![Series::curve(GREY, [(-118.0, 0.0), (118.0, 0.0)]), Series::marks(BLUE, off)],
    );
    let words = format!("middle: {:.0} electrons a column by the closed form", electrons(bench, 0.0, 0.0));
    page.words_in(x + 70, y + 56, &words, GREY);
    page.0
}

/// Brightness across the line (up) over height (right), between measured heights in between.
fn draw_caustic(page: &mut Page, area: Area, plots: &LaserPlots) {
    let Area { left, top, width, height } = area;
    let (low, high) = (HEIGHTS_MM[0], HEIGHTS_MM[HEIGHTS_MM.len() - 1]);
    let z = |px: f64| low + px / f64::from(width) * (high - low);
    let at = |which: usize, mm: f64| {
        let MeasuredLine { rows_per_mm, centre, peak, line } = &plots.beam[which];
        let place = centre + mm * rows_per_mm;
        // Lanczos: straight pieces or cubics would show the rows' own grid.
        let wave = |x: f64| if x.abs() < 1e-9 { 1.0 } else { libm::sin(PI * x) / (PI * x) };
        let lobe = |x: f64| if x.abs() < LOBES { wave(x) * wave(x / LOBES) } else { 0.0 };
        let value: f64 = line.iter().enumerate().map(|(k, v)| v * lobe(place - k as f64)).sum();
        value / peak
    };
    let picture = RgbImage::from_fn(width, height, |px, py| {
        let mm = REACH_MM * (1.0 - 2.0 * (f64::from(py) + 0.5) / f64::from(height));
        let place = (z(f64::from(px)) - low) / (high - low) * (HEIGHTS_MM.len() - 1) as f64;
        let (i, t) =
            ((place as usize).min(HEIGHTS_MM.len() - 2), place - (place as usize).min(HEIGHTS_MM.len() - 2) as f64);
        viridis(((1.0 - t) * at(i, mm) + t * at(i + 1, mm)) as f32)
    });
    page.picture(left, top, &picture);
    let white = image::Rgb([255, 255, 255]);
    for side in [-1.0, 1.0] {
        for px in 0..width - 1 {
            let up = |px: u32| {
                let w = side * half_width(&plots.bench, z(f64::from(px)));
                (f64::from(left + px), f64::from(top) + f64::from(height) * 0.5 * (1.0 - w / REACH_MM))
            };
            page.line(up(px), up(px + 1), white, 1);
        }
    }
    for (i, mm) in [REACH_MM, 0.0, -REACH_MM].into_iter().enumerate() {
        page.words(left - 40, top + 10 + i as u32 * (height - 10) / 2, &format!("{mm:>5.1}"));
    }
    for z in [-50.0, -20.0, 10.0, 40.0, 70.0] {
        let px = (z - low) / (high - low) * f64::from(width);
        page.words((f64::from(left) + px - 10.0) as u32, top + height + 16, &format!("{z:.0}"));
    }
    page.words(left + width - 56, top + height + 34, "z [mm]");
    page.words(left - 48, top + height + 34, "across [mm]");
}
