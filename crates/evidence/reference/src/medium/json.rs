//! A medium as JSON with the keys of its file, defaults filled in.

use serde_json::{Map, Value, json};

use super::LayeredMedium;
use transport::answer::Question;
use transport::stack::{CylinderPhase, Foil, Layer, Scattering, Substrate};

impl LayeredMedium {
    /// Everything that the medium means; JSON is YAML, so it is a medium file itself.
    pub fn json(&self) -> Value {
        let mut shown = json!({
            "n_above": self.stack.above,
            "layers": self.stack.layers.iter().map(layer).collect::<Vec<_>>(),
        });
        match self.stack.below {
            Substrate::Index(n) => shown["n_below"] = json!(n),
            Substrate::Foil(Foil { reflectance, roughness }) => {
                shown["below"] = json!({ "foil": { "reflectance": reflectance, "roughness": roughness } });
            }
        }
        shown["question"] = question(&self.question);
        shown
    }
}

fn layer(layer: &Layer) -> Value {
    let mut map = Map::new();
    if layer.thickness.is_finite() {
        map.insert("thickness_mm".into(), json!(layer.thickness));
    }
    map.insert("n".into(), json!(layer.n));
    map.insert("mu_a_per_mm".into(), json!(layer.mu_a));
    if layer.coat < 1.0 {
        map.insert("coat".into(), json!(layer.coat));
    }
    let (law, scattering) = match layer.scattering {
        Scattering::Isotropic { mu_s, g } => ("isotropic", json!({ "mu_s_per_mm": mu_s, "g": g })),
        Scattering::Tensor { mu_s, g } => ("tensor", json!({ "mu_s_per_mm": mu_s.to_array(), "g": g })),
        Scattering::Fibres { sigma_i, sigma_c, turn, axis, dispersion } => {
            let (name, turn) = match turn {
                CylinderPhase::Cauchy(g2) => ("g2", json!(g2)),
                CylinderPhase::Mirror => ("turn", json!("mirror")),
            };
            let fibres = json!({
                "sigma_i_per_mm": sigma_i,
                "sigma_c_per_mm": sigma_c,
                name: turn,
                "azimuth_deg": tidy(libm::atan2(axis.x, axis.y).to_degrees()),
                "dive_deg": tidy(libm::asin(axis.z.clamp(-1.0, 1.0)).to_degrees()),
                "dispersion_deg": tidy(dispersion.to_degrees()),
            });
            ("fibres", fibres)
        }
    };
    map.insert(law.into(), scattering);
    Value::Object(map)
}

fn question(question: &Question) -> Value {
    let mut map = Map::new();
    match question.incidence {
        Some(angle) => map.insert("incidence_deg".into(), json!(tidy(angle.to_degrees()))),
        None => map.insert("diffuse".into(), json!(true)),
    };
    let view = question.view;
    let azimuth = if view.x == 0.0 && view.y == 0.0 { 0.0 } else { libm::atan2(view.x, view.y).to_degrees() };
    let rest = [
        ("incidence_azimuth_deg", json!(tidy(90.0 - question.incidence_azimuth.to_degrees()))),
        ("view_tilt_deg", json!(tidy(libm::acos(view.z.clamp(-1.0, 1.0)).to_degrees()))),
        ("view_azimuth_deg", json!(tidy(azimuth))),
        ("line_sd_mm", json!(question.line_mm)),
        ("row_mm", json!(question.row_mm)),
        ("rows", json!(question.rows)),
        ("cell_mm", json!(question.cell_mm)),
        ("cells", json!(question.cells)),
        ("angles", json!(question.angles)),
    ];
    map.extend(rest.map(|(key, value)| (key.to_owned(), value)));
    Value::Object(map)
}

/// An angle as the file had it, but for rounding [deg].
fn tidy(angle: f64) -> f64 {
    (angle * 1e9).round() / 1e9 + 0.0
}
