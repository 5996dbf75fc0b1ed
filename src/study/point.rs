//! A point of light on wood: Figures 4.23 (clear wood) and 4.24 (a knot) of Kihl and Källberg 2021, by every model.
//!
//! Around the point light is equal on ellipses. Each is named by its half diameter across the fibre; measured are the
//! half diameter along the fibre over it, and the azimuth of the long axis. Far away diffusion says an aspect of
//! sqrt(D_e / D_perp) along the fibre (docs/physics.md); near the point light that met cylinders alone lies ACROSS it.
//! Neglected: the laser spot's own width, the camera.

use glam::DVec2;
use serde_json::{Value, json};

use super::ellipse::{Ellipse, Map, ellipse};
use super::media::{CLEAR_WOOD, SOUND_KNOT, Wood};
use super::{Report, Watch, ask, head, photons, point_page, told};
use crate::transport::answer::{Answer, Estimate, Question};
use crate::transport::kernel::diffusion;
use crate::transport::model::Model;
use crate::transport::path::Effort;

/// Photons for each map unless told otherwise.
pub const PHOTONS: u64 = 1_000_000;
/// Half diameters across the fibre at which contours are measured [mm].
pub const ACROSS: [f64; 6] = [0.25, 0.5, 0.75, 1.0, 1.25, 1.5];
/// Those of the table.
const SHOWN: [f64; 3] = [0.5, 1.0, 1.5];
/// Azimuths of clear wood's fibre against the motion [deg].
const AZIMUTHS: [f64; 7] = [0.0, 15.0, 30.0, 45.0, 60.0, 75.0, 90.0];
/// The azimuth whose map is drawn [deg].
const DRAWN: f64 = 30.0;
/// Cells on either side, and their pitch [mm].
const CELLS: usize = 90;
pub(super) const CELL_MM: f64 = 0.05;

/// A kind of wood and what is known of its ellipses.
pub(super) struct Case {
    pub wood: Wood,
    pub title: &'static str,
    pub azimuths: &'static [f64],
    /// Aspect at 1.5 mm across the fibre by the Monte Carlo of docs/physics.md [1].
    pub known: f64,
    pub spots: Vec<Spot>,
}

/// One model's map of one fibre.
pub(super) struct Spot {
    pub model: Model,
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
        for model in Model::ALL {
            for &azimuth in case.azimuths {
                case.spots.push(spot(case, model, azimuth, effort, watch));
            }
        }
    }
    Report { table: table(&cases), json: json(&cases, effort), picture: point_page::draw(&cases) }
}

fn spot(case: &Case, model: Model, azimuth: f64, effort: Effort, watch: Watch) -> Spot {
    let wood = case.wood.turned(azimuth);
    let question = Question { rows: 0, angles: 0, cells: CELLS, cell_mm: CELL_MM, ..Question::default() };
    let what = format!("{} at {azimuth} deg", wood.name);
    let answer = ask(model, &what, (&wood.stack(), &question), effort, watch).map_err(|refusal| refusal.to_string());
    let drawn = azimuth == case.drawn();
    let map = answer.as_ref().ok().filter(|_| drawn).map_or_else(Vec::new, light);
    let found = answer.map(|answer| ACROSS.iter().map(|across| contour(&answer, azimuth, *across)).collect());
    Spot { model, azimuth, found, map }
}

impl Case {
    /// The azimuth whose map is drawn [deg].
    pub fn drawn(&self) -> f64 {
        if self.azimuths.contains(&DRAWN) { DRAWN } else { self.azimuths[0] }
    }
}

fn light(answer: &Answer) -> Vec<f64> {
    answer.point.iter().map(|cell| cell.value).collect()
}

/// The line of equal light that is `across` [mm] away from its centre across a fibre of azimuth `azimuth` [deg].
pub fn contour(answer: &Answer, azimuth: f64, across: f64) -> Option<Contour> {
    let light = light(answer);
    let side = libm::sqrt(light.len() as f64) as usize;
    let (x, y) = libm::sincos(azimuth.to_radians());
    let (along, sideways) = (DVec2::new(x, y), DVec2::new(-y, x));
    let map = Map { light: &light, cells: side / 2, cell_mm: answer.cell_mm };
    let mut ellipse = ellipse(map, across * sideways)?;
    if answer.point.iter().all(|cell| cell.error == 0.0) {
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
        text += &format!("{}: half diameter along the fibre over that across it, ", case.title);
        text += "and the long axis against the fibre [deg]\n";
        text += &format!("  far away by diffusion {:.2}; Monte Carlo of docs/physics.md ", case.far());
        text += &format!("at 1.5 mm {:.2}\n  {:10}{:>7}", case.known, "model", "fibre");
        for across in SHOWN {
            text += &format!("   {:>24}", format!("{across:.1} mm across"));
        }
        text += "\n";
        for spot in &case.spots {
            text += &format!("  {:10}{:>7}", spot.model.name(), spot.azimuth);
            match &spot.found {
                Ok(contours) => {
                    let shown = ACROSS.iter().zip(contours).filter(|(across, _)| SHOWN.contains(across));
                    for (_, contour) in shown {
                        let words = contour.map_or_else(|| "no ellipse".to_owned(), |c| c.words());
                        text += &format!("   {words:>24}");
                    }
                }
                Err(reason) => text += &format!("   refuses: {reason}"),
            }
            text += "\n";
        }
        text += "\n";
    }
    text
}

impl Contour {
    fn words(&self) -> String {
        // A circle has no long axis.
        let round = self.off.error > 15.0 || self.ellipse.aspect.value < 1.02;
        let off = if round { "round".to_owned() } else { told(self.off, 1) };
        format!("{}  {off:>10}", told(self.aspect, 3))
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
            "model": spot.model.name(),
            "azimuth_deg": spot.azimuth,
            "contours": ACROSS.iter().zip(contours).map(contour).collect::<Vec<_>>(),
        }),
        Err(reason) => json!({ "model": spot.model.name(), "azimuth_deg": spot.azimuth, "refuses": reason }),
    }
}
