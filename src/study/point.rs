//! A point of light on wood: Figures 4.23 (clear wood) and 4.24 (a knot) of Kihl and Källberg 2021, by every model and by
//! their own method.
//!
//! Around the point light is equal on ellipses. Each is named by its half diameter across the fibre; measured are the
//! half diameter along the fibre over it, and the azimuth of the long axis. Far away diffusion says an aspect of
//! sqrt(D_e / D_perp) along the fibre (docs/physics.md); near the point light that met cylinders alone lies ACROSS it.
//! Neglected: the laser spot's own width but for the thesis' method, which has no picture without it; the camera.

use glam::DVec2;
use serde_json::{Value, json};

use super::by::By;
use super::ellipse::{Ellipse, Map, ellipse};
use super::media::{CLEAR_WOOD, SOUND_KNOT, Wood};
use super::{Report, Watch, head, photons, point_page, told};
use crate::transport::answer::{Estimate, Question};
use crate::transport::kernel::diffusion;
use crate::transport::path::Effort;

/// Photons for each map unless told otherwise.
pub const PHOTONS: u64 = 1_000_000;
/// Half diameters across the fibre at which contours are measured [mm].
pub const ACROSS: [f64; 6] = [0.25, 0.5, 0.75, 1.0, 1.25, 1.5];
/// Those of the table.
const SHOWN: [f64; 3] = [0.5, 1.0, 1.5];
/// Azimuths of clear wood's fibre against the motion; between pixels' axes and diagonals their pull is strongest [deg].
const AZIMUTHS: [f64; 5] = [0.0, 22.5, 45.0, 67.5, 90.0];
/// The azimuth whose map is drawn [deg].
const DRAWN: f64 = 22.5;
/// Cells on either side of the central one.
pub const CELLS: usize = 90;
/// Pitch of the cells [mm].
pub const CELL_MM: f64 = 0.05;

/// A kind of wood and what is known of its ellipses.
pub(super) struct Case {
    pub wood: Wood,
    pub title: &'static str,
    pub azimuths: &'static [f64],
    /// Aspect at 1.5 mm across the fibre by the Monte Carlo of docs/physics.md [1].
    pub known: f64,
    pub spots: Vec<Spot>,
}

/// One map of one fibre.
pub(super) struct Spot {
    pub by: By,
    /// What is lit and how.
    pub note: String,
    pub azimuth: f64,
    /// In the order of [`ACROSS`], `None` where no ellipse was found; or why the model refuses.
    pub found: Result<Vec<Option<Contour>>, String>,
    /// Light of each cell, kept where it is drawn.
    pub map: Vec<f64>,
}

/// One line of equal light.
#[derive(Debug, Clone, Copy)]
pub struct Contour {
    /// The ellipse.
    pub ellipse: Ellipse,
    /// Half diameter along the fibre over that across it [1].
    pub aspect: Estimate,
    /// Azimuth of the long axis less that of the fibre, in (-90, 90] [deg].
    pub off: Estimate,
}

impl Case {
    /// What diffusion says far away, sqrt(D_e / D_perp) [1].
    pub fn far(&self) -> f64 {
        let [_, sigma_i, k, _] = self.wood.coefficients;
        let (along, across) = diffusion(sigma_i, k);
        let sin = libm::sin(self.wood.dive.to_radians());
        let down = across + (along - across) * sin * sin;
        (along / down).sqrt()
    }
}

/// Photons that [`study`] walks.
pub fn work(effort: Effort) -> u64 {
    photons(effort, AZIMUTHS.len() as u64 + 1)
}

/// Makes the study.
pub fn study(effort: Effort, watch: Watch) -> Report {
    let case = |wood, title, azimuths, known| Case { wood, title, azimuths, known, spots: Vec::new() };
    let mut cases = [
        case(CLEAR_WOOD, "Clear wood, fibre in the surface", &AZIMUTHS[..], 2.17),
        case(SOUND_KNOT, "Sound knot, fibre dives at 80 degrees", &AZIMUTHS[..1], 1.0),
    ];
    for case in &mut cases {
        for by in By::all() {
            // The conservative stencil takes seconds for each.
            let asked = |azimuth: &f64| by != By::Conservative || *azimuth == case.drawn();
            for azimuth in case.azimuths.iter().copied().filter(asked).collect::<Vec<_>>() {
                case.spots.push(spot(case, by, azimuth, effort, watch));
            }
        }
    }
    Report { table: table(&cases), json: json(&cases, effort), picture: point_page::draw(&cases) }
}

/// What is asked of each model.
pub(super) fn question() -> Question {
    Question { rows: 0, angles: 0, cells: CELLS, cell_mm: CELL_MM, ..Question::default() }
}

fn spot(case: &Case, by: By, azimuth: f64, effort: Effort, watch: Watch) -> Spot {
    let wood = case.wood.turned(azimuth);
    let light = by.light(&wood, effort, watch).map_err(|refusal| refusal.to_string());
    let drawn = azimuth == case.drawn();
    let map = light.as_ref().ok().filter(|_| drawn).map_or_else(Vec::new, |light| values(light));
    let found = light.map(|light| ACROSS.iter().map(|across| contour(&light, azimuth, *across)).collect());
    Spot { by, note: by.note(&wood), azimuth, found, map }
}

impl Case {
    /// The azimuth whose map is drawn [deg].
    pub fn drawn(&self) -> f64 {
        if self.azimuths.contains(&DRAWN) { DRAWN } else { self.azimuths[0] }
    }
}

fn values(light: &[Estimate]) -> Vec<f64> {
    light.iter().map(|cell| cell.value).collect()
}

/// The line of equal light that is `across` [mm] away from its centre across a fibre of azimuth `azimuth` [deg], in the
/// light that [`By::light`] gives; `None` where it is no ellipse.
pub fn contour(light: &[Estimate], azimuth: f64, across: f64) -> Option<Contour> {
    let values = values(light);
    let (x, y) = libm::sincos(azimuth.to_radians());
    let (along, sideways) = (DVec2::new(x, y), DVec2::new(-y, x));
    let map = Map { light: &values, cells: CELLS, cell_mm: CELL_MM };
    let mut ellipse = ellipse(map, across * sideways)?;
    if light.iter().all(|cell| cell.error == 0.0) {
        // What the fit calls errors is then the shape's misfit alone.
        (ellipse.aspect.error, ellipse.angle.error) = (0.0, 0.0);
    }
    let value = ellipse.reach(along) / ellipse.reach(sideways);
    let aspect = Estimate { value, error: value * ellipse.aspect.error / ellipse.aspect.value };
    let off = 90.0 - (90.0 - (ellipse.angle.value - azimuth)).rem_euclid(180.0);
    Some(Contour { ellipse, aspect, off: Estimate { value: off, error: ellipse.angle.error } })
}

fn table(cases: &[Case]) -> String {
    let mut text = String::new();
    for case in cases {
        text += &format!("{}, azimuth {}:\n", case.title, case.drawn());
        text += "half diameter along the fibre over that across it, and the long axis against the fibre [deg]\n";
        text += &format!("  far away by diffusion {:.2}; Monte Carlo of docs/physics.md ", case.far());
        text += &format!("at 1.5 mm {:.2}\n  {:14}", case.known, "model");
        for across in SHOWN {
            text += &format!("   {:>24}", format!("{across:.1} mm across"));
        }
        text += "\n";
        for spot in case.spots.iter().filter(|spot| spot.azimuth == case.drawn()) {
            text += &format!("  {:14}", spot.by.name());
            match &spot.found {
                Ok(contours) => {
                    let shown = ACROSS.iter().zip(contours).filter(|(across, _)| SHOWN.contains(across));
                    for (_, contour) in shown {
                        let words = contour.map_or_else(|| "no ellipse".to_owned(), |c| c.words());
                        text += &format!("   {words:>24}");
                    }
                    text += &format!("   {}", spot.note);
                }
                Err(reason) => text += &format!("   refuses: {reason}"),
            }
            text = text.trim_end().to_owned() + "\n";
        }
        text += "\n";
        if case.azimuths.len() > 1 {
            text += &angles(case);
        }
    }
    text
}

/// The long axis against the fibre at every azimuth.
fn angles(case: &Case) -> String {
    let mut text = String::from("Long axis less fibre at 1.5 mm across [deg], by the fibre's azimuth\n");
    text += &format!("  {:14}", "model");
    for azimuth in case.azimuths {
        text += &format!("{azimuth:>12}");
    }
    text += "\n";
    for by in By::all() {
        text += &format!("  {:14}", by.name());
        for azimuth in case.azimuths {
            let spot = case.spots.iter().find(|spot| spot.by == by && spot.azimuth == *azimuth);
            let last = spot.and_then(|spot| spot.found.as_ref().ok()?.last().copied().flatten());
            let words = last.map_or_else(|| "-".to_owned(), |c| c.angle());
            text += &format!("{words:>12}");
        }
        text += "\n";
    }
    text + "\n"
}

impl Contour {
    fn words(&self) -> String {
        format!("{}  {:>10}", told(self.aspect, 3), self.angle())
    }

    /// Of the long axis against the fibre; a circle has none.
    fn angle(&self) -> String {
        let round = self.off.error > 15.0 || self.ellipse.aspect.value < 1.02;
        if round { "round".to_owned() } else { told(self.off, 1) }
    }
}

fn json(cases: &[Case], effort: Effort) -> Value {
    let mut document = head("point", effort);
    let each = |case: &Case| {
        let [mu_a, sigma_i, sigma_c, n] = case.wood.coefficients;
        json!({
            "case": case.wood.name,
            "mu_a_per_mm": mu_a, "sigma_i_per_mm": sigma_i, "sigma_c_per_mm": sigma_c, "n": n,
            "dive_deg": case.wood.dive,
            "aspect_far_by_diffusion": case.far(),
            "aspect_known_at_1.5_mm": case.known,
            "spots": case.spots.iter().map(shown).collect::<Vec<_>>(),
        })
    };
    document["cell_mm"] = json!(CELL_MM);
    document["cases"] = cases.iter().map(each).collect();
    document
}

fn shown(spot: &Spot) -> Value {
    let contour = |(across, contour): (&f64, &Option<Contour>)| {
        contour.as_ref().map(|c| {
            json!({
                "across_mm": across,
                "aspect_along_over_across": c.aspect,
                "long_axis_less_fibre_deg": c.off,
                "long_over_short": c.ellipse.aspect,
                "long_axis_azimuth_deg": c.ellipse.angle,
                "half_axes_mm": c.ellipse.half,
                "centre_mm": c.ellipse.centre.to_array(),
            })
        })
    };
    match &spot.found {
        Ok(contours) => json!({
            "model": spot.by.name(),
            "note": spot.note,
            "azimuth_deg": spot.azimuth,
            "contours": ACROSS.iter().zip(contours).map(contour).collect::<Vec<_>>(),
        }),
        Err(reason) => json!({ "model": spot.by.name(), "azimuth_deg": spot.azimuth, "refuses": reason }),
    }
}
