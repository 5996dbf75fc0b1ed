//! Point spread on wood: aspect and direction of the ellipses of equal light around a point of light, by every model.
//! These are Figures 4.23 (clear wood) and 4.24 (a knot) of Kihl and Källberg 2021, and their own method stands beside
//! the models.
//!
//! Around the point light is equal on ellipses. Each is named by its half diameter across the fibre; measured are the
//! half diameter along the fibre over it, and the azimuth of the long axis. Far away diffusion gives an aspect of
//! sqrt(D_e / D_perp) along the fibre (docs/theory/physics.md); near the point, light that was scattered by cylinders
//! alone lies ACROSS it.
//! Neglected: the laser spot's own width but for the thesis' method, which has no picture without it; the camera.

use glam::DVec2;
use image::{Rgb, RgbImage};
use serde_json::{Value, json};

use super::compared_model::ComparedModel;
use super::ellipse::{Ellipse, LightMap, ellipse};
use super::{StudyProgress, StudyReport, announce, ask, describe, photon_document, total_photons};
use drawing::chart::{Axis, Chart, Series};
use drawing::{Area, LETTER, MARGIN, Page, viridis};
use reference::media::{CLEAR_WOOD, SOUND_KNOT, WoodMedium};
use reference::path::Effort;
use reference::thesis::{self, PixelGround, SpreadMethod};
use transport::answer::{Estimate, Question};
use transport::kernel::diffusion;

/// Default number of photons for each map.
pub const PHOTONS: u64 = 1_000_000;
/// Half diameters across the fibre at which contours are measured [mm].
const HALF_DIAMETERS_MM: [f64; 6] = [0.25, 0.5, 0.75, 1.0, 1.25, 1.5];
/// Half diameters that the table shows [mm].
const TABLE_HALF_DIAMETERS_MM: [f64; 3] = [0.5, 1.0, 1.5];
/// Azimuths of clear wood's fibre against the motion; a pixel grid biases most between its axes and diagonals [deg].
const CLEAR_WOOD_AZIMUTHS_DEG: [f64; 5] = [0.0, 22.5, 45.0, 67.5, 90.0];
/// The azimuth whose map is drawn [deg].
const DRAWN_AZIMUTH_DEG: f64 = 22.5;
/// Cells on either side of the central one.
const CELLS: usize = 90;
/// Pitch of the cells [mm].
const CELL_MM: f64 = 0.05;

/// A kind of wood, published values of its ellipses, and the maps of the models.
struct PointCase {
    wood: WoodMedium,
    title: &'static str,
    azimuths: &'static [f64],
    /// Aspect at 1.5 mm across the fibre by the Monte Carlo of docs/theory/physics.md [1].
    monte_carlo_aspect: f64,
    maps: Vec<PointMap>,
}

/// Light of a point on wood of one azimuth, by one model.
struct PointMap {
    model: ComparedModel,
    /// What is lit and how.
    note: String,
    /// Azimuth of the fibre [deg].
    azimuth: f64,
    /// Lines of equal light in the order of [`HALF_DIAMETERS_MM`], `None` where no ellipse was found; or why the model
    /// refuses.
    contours: Result<Vec<Option<Contour>>, String>,
    /// Light of each cell, kept where it is drawn.
    light: Vec<f64>,
}

/// One line of equal light.
#[derive(Debug, Clone, Copy)]
pub struct Contour {
    /// The ellipse.
    pub ellipse: Ellipse,
    /// Half diameter along the fibre over that across it [1].
    pub aspect: Estimate,
    /// Azimuth of the long axis less that of the fibre, in (-90, 90] [deg].
    pub misalignment: Estimate,
}

impl PointCase {
    /// Aspect far away by diffusion, sqrt(D_e / D_perp) [1].
    pub(crate) fn far_aspect(&self) -> f64 {
        let [_, sigma_i, k, _] = self.wood.coefficients;
        let (along, across) = diffusion(sigma_i, k);
        let sin = libm::sin(self.wood.dive.to_radians());
        let down = across + (along - across) * sin * sin;
        (along / down).sqrt()
    }
}

/// Photons of the whole study.
pub fn workload(effort: Effort) -> u64 {
    total_photons(effort, CLEAR_WOOD_AZIMUTHS_DEG.len() as u64 + 1)
}

/// Runs the study.
pub fn study(effort: Effort, progress: StudyProgress) -> StudyReport {
    let case = |wood, title, azimuths, monte_carlo_aspect| PointCase {
        wood,
        title,
        azimuths,
        monte_carlo_aspect,
        maps: Vec::new(),
    };
    let mut cases = [
        case(CLEAR_WOOD, "Clear wood, fibre in the surface", &CLEAR_WOOD_AZIMUTHS_DEG[..], 2.17),
        case(SOUND_KNOT, "Sound knot, fibre dives at 80 degrees", &CLEAR_WOOD_AZIMUTHS_DEG[..1], 1.0),
    ];
    for case in &mut cases {
        for model in ComparedModel::all() {
            // The conservative stencil takes seconds for each.
            let asked = |azimuth: &f64| model != ComparedModel::Conservative || *azimuth == case.drawn_azimuth();
            for azimuth in case.azimuths.iter().copied().filter(asked).collect::<Vec<_>>() {
                case.maps.push(point_map(case, model, azimuth, effort, progress));
            }
        }
    }
    StudyReport { table: table(&cases), json: json(&cases, effort), picture: draw(&cases), figures: Vec::new() }
}

impl ComparedModel {
    /// What is lit and how, where it is not a point as such.
    ///
    /// The thesis' method is shown as its Figures 4.23 and 4.24 show it: a spot of 55 pixels, 20 iterations on clear
    /// wood and 10 on a knot. The thesis does not say how large its pixels are; here they are the study's cells, so the
    /// half diameters in mm are a choice, aspects and angles are not. The thesis' spot is part of its map. The
    /// conservative stencil lights one pixel and is asked what the models of transport are asked.
    fn point_note(self, wood: &WoodMedium) -> String {
        match self {
            Self::Model(_) => String::new(),
            Self::Thesis => {
                let iterations = if is_knot(&ground(wood)) { 10 } else { 20 };
                format!("55 px spot, {iterations} iterations, {CELL_MM} mm/px")
            }
            Self::Conservative => format!("one pixel lit, {CELL_MM} mm/px"),
        }
    }

    /// Share of the energy that leaves in each cell around a point of light, `[2 CELLS + 1, 2 CELLS + 1]`, row-major,
    /// rows along y [1].
    ///
    /// # Errors
    /// In words, where the model refuses.
    pub fn point_light(
        self,
        wood: &WoodMedium,
        effort: Effort,
        progress: StudyProgress,
    ) -> Result<Vec<Estimate>, String> {
        let middle = DVec2::splat(CELLS as f64);
        let what = format!("{} at {} deg", wood.name, wood.azimuth);
        let (source, method) = match self {
            Self::Model(model) => {
                return Ok(ask(model, &what, (&wood.stack(), &question()), effort, progress)?.point);
            }
            Self::Thesis if is_knot(&ground(wood)) => (thesis::LaserPoint::thesis(middle), SpreadMethod::ON_A_KNOT),
            Self::Thesis => (thesis::LaserPoint::thesis(middle), SpreadMethod::ON_CLEAR_WOOD),
            Self::Conservative => {
                (thesis::LaserPoint { at: middle, diameter: 1.0, deviation: 1.0 }, SpreadMethod::CONSERVATIVE)
            }
        };
        announce(self.name(), &what, progress);
        Ok(thesis::point(&ground(wood), &source, method).light.into_iter().map(Estimate::exact).collect())
    }
}

/// The wood as the surface of a picture of the thesis' method.
fn ground(wood: &WoodMedium) -> PixelGround {
    const SIDE: usize = 2 * CELLS + 1;
    PixelGround::new(SIDE, SIDE, CELL_MM, &vec![Some(wood.medium()); SIDE * SIDE])
}

/// The thesis' rule: wood that absorbs is a knot.
fn is_knot(ground: &PixelGround) -> bool {
    ground.map.alpha(0) < 1.0
}

/// What is asked of each model.
fn question() -> Question {
    Question { rows: 0, angles: 0, cells: CELLS, cell_mm: CELL_MM, ..Question::default() }
}

fn point_map(
    case: &PointCase,
    model: ComparedModel,
    azimuth: f64,
    effort: Effort,
    progress: StudyProgress,
) -> PointMap {
    let wood = case.wood.turned(azimuth);
    let light = model.point_light(&wood, effort, progress);
    let drawn = azimuth == case.drawn_azimuth();
    let kept = light.as_ref().ok().filter(|_| drawn).map_or_else(Vec::new, |light| values(light));
    let contours =
        light.map(|light| HALF_DIAMETERS_MM.iter().map(|across| contour(&light, azimuth, *across)).collect());
    PointMap { model, note: model.point_note(&wood), azimuth, contours, light: kept }
}

impl PointCase {
    /// The azimuth whose map is drawn [deg].
    pub(crate) fn drawn_azimuth(&self) -> f64 {
        if self.azimuths.contains(&DRAWN_AZIMUTH_DEG) { DRAWN_AZIMUTH_DEG } else { self.azimuths[0] }
    }
}

fn values(light: &[Estimate]) -> Vec<f64> {
    light.iter().map(|cell| cell.value).collect()
}

/// The line of equal light that is `across` [mm] away from its centre across a fibre of azimuth `azimuth` [deg], in the
/// light that [`ComparedModel::point_light`] gives; `None` where it is no ellipse.
pub fn contour(light: &[Estimate], azimuth: f64, across: f64) -> Option<Contour> {
    let values = values(light);
    let (x, y) = libm::sincos(azimuth.to_radians());
    let (along, sideways) = (DVec2::new(x, y), DVec2::new(-y, x));
    let map = LightMap { light: &values, cells: CELLS, cell_mm: CELL_MM };
    let mut ellipse = ellipse(map, across * sideways)?;
    if light.iter().all(|cell| cell.error == 0.0) {
        // Without chance the residuals are misfit of the shape, not statistical errors.
        (ellipse.aspect.error, ellipse.angle.error) = (0.0, 0.0);
    }
    let value = ellipse.reach(along) / ellipse.reach(sideways);
    let aspect = Estimate { value, error: value * ellipse.aspect.error / ellipse.aspect.value };
    let off = 90.0 - (90.0 - (ellipse.angle.value - azimuth)).rem_euclid(180.0);
    Some(Contour { ellipse, aspect, misalignment: Estimate { value: off, error: ellipse.angle.error } })
}

fn table(cases: &[PointCase]) -> String {
    let mut text = String::new();
    for case in cases {
        text += &format!("{}, azimuth {}:\n", case.title, case.drawn_azimuth());
        text += "half diameter along the fibre over that across it, and the long axis against the fibre [deg]\n";
        text += &format!("  far away by diffusion {:.2}; Monte Carlo of docs/theory/physics.md ", case.far_aspect());
        text += &format!("at 1.5 mm {:.2}\n  {:14}", case.monte_carlo_aspect, "model");
        for across in TABLE_HALF_DIAMETERS_MM {
            text += &format!("   {:>24}", format!("{across:.1} mm across"));
        }
        text += "\n";
        for map in case.maps.iter().filter(|map| map.azimuth == case.drawn_azimuth()) {
            text += &format!("  {:14}", map.model.name());
            match &map.contours {
                Ok(contours) => {
                    let shown = HALF_DIAMETERS_MM
                        .iter()
                        .zip(contours)
                        .filter(|(across, _)| TABLE_HALF_DIAMETERS_MM.contains(across));
                    for (_, contour) in shown {
                        let words = contour.map_or_else(|| "no ellipse".to_owned(), |c| c.words());
                        text += &format!("   {words:>24}");
                    }
                    text += &format!("   {}", map.note);
                }
                Err(reason) => text += &format!("   refuses: {reason}"),
            }
            text = text.trim_end().to_owned() + "\n";
        }
        text += "\n";
        if case.azimuths.len() > 1 {
            text += &angle_table(case);
        }
    }
    text
}

/// The long axis against the fibre at every azimuth.
fn angle_table(case: &PointCase) -> String {
    let mut text = String::from("Long axis less fibre at 1.5 mm across [deg], by the fibre's azimuth\n");
    text += &format!("  {:14}", "model");
    for azimuth in case.azimuths {
        text += &format!("{azimuth:>12}");
    }
    text += "\n";
    for model in ComparedModel::all() {
        text += &format!("  {:14}", model.name());
        for azimuth in case.azimuths {
            let map = case.maps.iter().find(|map| map.model == model && map.azimuth == *azimuth);
            let last = map.and_then(|map| map.contours.as_ref().ok()?.last().copied().flatten());
            let words = last.map_or_else(|| "-".to_owned(), |c| c.angle());
            text += &format!("{words:>12}");
        }
        text += "\n";
    }
    text + "\n"
}

impl Contour {
    fn words(&self) -> String {
        format!("{}  {:>10}", describe(self.aspect, 3), self.angle())
    }

    /// Of the long axis against the fibre; a circle has none.
    fn angle(&self) -> String {
        let round = self.misalignment.error > 15.0 || self.ellipse.aspect.value < 1.02;
        if round { "round".to_owned() } else { describe(self.misalignment, 1) }
    }
}

fn json(cases: &[PointCase], effort: Effort) -> Value {
    let mut document = photon_document("point", effort);
    let each = |case: &PointCase| {
        let [mu_a, sigma_i, sigma_c, n] = case.wood.coefficients;
        json!({
            "case": case.wood.name,
            "mu_a_per_mm": mu_a, "sigma_i_per_mm": sigma_i, "sigma_c_per_mm": sigma_c, "n": n,
            "dive_deg": case.wood.dive,
            "aspect_far_by_diffusion": case.far_aspect(),
            "aspect_known_at_1.5_mm": case.monte_carlo_aspect,
            "spots": case.maps.iter().map(map_json).collect::<Vec<_>>(),
        })
    };
    document["cell_mm"] = json!(CELL_MM);
    document["cases"] = cases.iter().map(each).collect();
    document
}

fn map_json(map: &PointMap) -> Value {
    let contour = |(across, contour): (&f64, &Option<Contour>)| {
        contour.as_ref().map(|c| {
            json!({
                "across_mm": across,
                "aspect_along_over_across": c.aspect,
                "long_axis_less_fibre_deg": c.misalignment,
                "long_over_short": c.ellipse.aspect,
                "long_axis_azimuth_deg": c.ellipse.angle,
                "half_axes_mm": c.ellipse.half,
                "centre_mm": c.ellipse.centre.to_array(),
            })
        })
    };
    match &map.contours {
        Ok(contours) => json!({
            "model": map.model.name(),
            "note": map.note,
            "azimuth_deg": map.azimuth,
            "contours": HALF_DIAMETERS_MM.iter().zip(contours).map(contour).collect::<Vec<_>>(),
        }),
        Err(reason) => json!({ "model": map.model.name(), "azimuth_deg": map.azimuth, "refuses": reason }),
    }
}

/// Side of a map [px], and what it shows on either side of the point [mm].
const SIDE: u32 = 330;
const REACH_MM: f64 = 3.3;
const HEADING_PX: u32 = 40;
const FOOT_PX: u32 = 50;
const CHART_PX: u32 = 400;
/// Ends of the scale of light [mm^-2].
const DARKEST_PER_MM2: f64 = 1e-5;
const BRIGHTEST_PER_MM2: f64 = 10.0;
const WHITE: Rgb<u8> = Rgb([255, 255, 255]);
const FIBRE: Rgb<u8> = Rgb([255, 120, 60]);
const GREY: Rgb<u8> = Rgb([150, 150, 150]);
/// How far an angle may be off [deg].
const ANGLE_TOLERANCE_DEG: f64 = 1.6;

fn draw(cases: &[PointCase]) -> RgbImage {
    let row = HEADING_PX + SIDE + FOOT_PX;
    let width = ComparedModel::all().count() as u32 * (SIDE + MARGIN);
    let mut page = Page::new(MARGIN + width, cases.len() as u32 * row + CHART_PX + MARGIN);
    for (i, case) in cases.iter().enumerate() {
        let top = i as u32 * row;
        let title = format!("{}: light of a point, fibre at {} deg", case.title, case.drawn_azimuth());
        page.words(MARGIN, top + 16, &title);
        let maps = case.maps.iter().filter(|map| map.azimuth == case.drawn_azimuth());
        for (column, map) in maps.enumerate() {
            let left = MARGIN + column as u32 * (SIDE + MARGIN);
            let name = map.model.name();
            page.words_in(left, top + HEADING_PX - 6, name, map.model.colour());
            page.words(left + LETTER * (name.len() as u32 + 2), top + HEADING_PX - 6, &map.note);
            draw_map(&mut page, left, top + HEADING_PX, map, case);
        }
        let ramp = |t: f32| viridis(t);
        page.bar(MARGIN, top + HEADING_PX + SIDE + 8, SIDE, "1e-5", "log scale  10 per mm2", &ramp);
        let words =
            "white: equal light at 0.5, 1, 1.5 mm across the fibre; orange: the fibre; x right, y (motion) down";
        page.words(2 * MARGIN + SIDE, top + HEADING_PX + SIDE + 17, words);
    }
    let top = cases.len() as u32 * row;
    let charts: Vec<_> = cases.iter().map(aspect_chart).chain([angle_chart(&cases[0])]).collect();
    let pitch = width / charts.len() as u32;
    for (column, chart) in charts.iter().enumerate() {
        let area = Area { left: MARGIN + column as u32 * pitch, top, width: pitch - MARGIN, height: CHART_PX };
        chart.draw(&mut page, area);
    }
    page.0
}

fn draw_map(page: &mut Page, left: u32, top: u32, map: &PointMap, case: &PointCase) {
    let contours = match &map.contours {
        Ok(contours) => contours,
        Err(reason) => return page.words(left, top + 20, reason),
    };
    let side = libm::sqrt(map.light.len() as f64) as i64;
    let mm = |pixel: u32| (f64::from(pixel) + 0.5) / f64::from(SIDE) * 2.0 * REACH_MM - REACH_MM;
    let cell = |mm: f64| ((mm / CELL_MM).round() as i64 + side / 2).clamp(0, side - 1);
    let picture = RgbImage::from_fn(SIDE, SIDE, |x, y| {
        let light = map.light[(cell(mm(y)) * side + cell(mm(x))) as usize] / (CELL_MM * CELL_MM);
        viridis(
            (libm::log(light.max(DARKEST_PER_MM2) / DARKEST_PER_MM2) / libm::log(BRIGHTEST_PER_MM2 / DARKEST_PER_MM2))
                as f32,
        )
    });
    page.picture(left, top, &picture);
    let pixel = |place: DVec2| {
        let at = |v: f64| (v + REACH_MM) / (2.0 * REACH_MM) * f64::from(SIDE);
        (f64::from(left) + at(place.x), f64::from(top) + at(place.y))
    };
    let inside = |place: &DVec2| place.abs().max_element() < REACH_MM;
    for contour in HALF_DIAMETERS_MM.iter().zip(contours).filter(|(across, _)| (*across * 2.0).fract() == 0.0) {
        let Some(Contour { ellipse, .. }) = contour.1 else { continue };
        let at = |i: u32| {
            let (sin, cos) = libm::sincos(f64::from(i) * std::f64::consts::TAU / 180.0);
            ellipse.centre + ellipse.frame() * DVec2::new(cos, sin)
        };
        for i in 0..180 {
            let (from, to) = (at(i), at(i + 1));
            if inside(&from) && inside(&to) {
                page.line(pixel(from), pixel(to), WHITE, 1);
            }
        }
    }
    let (x, y) = libm::sincos(map.azimuth.to_radians());
    let flat = libm::cos(case.wood.dive.to_radians());
    for sign in [-1.0, 1.0] {
        let direction = sign * DVec2::new(x, y);
        page.line(pixel((3.1 - 0.5 * flat) * direction), pixel(3.1 * direction), FIBRE, 2);
    }
    let (x, y) = pixel(DVec2::new(-3.0, 3.0));
    let (end, _) = pixel(DVec2::new(-2.0, 3.0));
    page.line((x, y), (end, y), WHITE, 3);
    page.words_in(end as u32 + 6, y as u32 + 4, "1 mm", WHITE);
}

fn aspect_chart(case: &PointCase) -> Chart {
    let axis = Axis::even("half diameter across the fibre [mm]", 0.0, 1.6);
    let (low, high) = if case.far_aspect() > 1.5 { (0.0, 4.0) } else { (0.6, 1.6) };
    let mut series = vec![
        Series::curve(GREY, [(0.0, case.far_aspect()), (1.6, case.far_aspect())]).named("diffusion, far away"),
        Series::marks(GREY, [(1.5, case.monte_carlo_aspect, 0.0)]).named("docs/theory/physics.md"),
    ];
    for model in ComparedModel::all() {
        let maps = || case.maps.iter().filter(move |map| map.model == model);
        let at = |i: usize| {
            let found: Vec<_> = maps().filter_map(|s| s.contours.as_ref().ok()?[i]).collect();
            let n = found.len() as f64;
            let mean = found.iter().map(|c| c.aspect.value).sum::<f64>() / n;
            let error = found.iter().map(|c| c.aspect.error * c.aspect.error).sum::<f64>().sqrt() / n;
            (!found.is_empty()).then_some((HALF_DIAMETERS_MM[i], mean, error))
        };
        let points = (0..HALF_DIAMETERS_MM.len()).filter_map(at);
        series.push(Series { joined: true, ..Series::marks(model.colour(), points).named(model.name()) });
    }
    let title = if case.wood.dive > 0.0 { "Sound knot" } else { "Clear wood" };
    Chart::new(title, axis, Axis::even("half diameter along over across", low, high), series)
}

fn angle_chart(case: &PointCase) -> Chart {
    let mut series: Vec<_> =
        [ANGLE_TOLERANCE_DEG, -ANGLE_TOLERANCE_DEG].map(|off| Series::curve(GREY, [(0.0, off), (90.0, off)])).into();
    for model in ComparedModel::all() {
        let last = |map: &PointMap| map.contours.as_ref().ok()?.last().copied().flatten().map(|c| (map.azimuth, c));
        let maps = case.maps.iter().filter(|map| map.model == model).filter_map(last);
        // Side by side, so that none hides another.
        let aside = 1.2 * series.len() as f64 - 4.8;
        let points = maps.map(|(azimuth, c)| (azimuth + aside, c.misalignment.value, c.misalignment.error));
        series.push(Series::marks(model.colour(), points).named(model.name()));
    }
    let x = Axis::even("azimuth of the fibre [deg]", -5.0, 95.0);
    let y = Axis::even("long axis less fibre [deg]; grey: 1.6 deg", -12.0, 16.0);
    Chart::new("Clear wood, 1.5 mm across the fibre", x, y, series)
}
