//! Conditional parameters: those that have an effect beside some settings, parameters or matter alone.
//!
//! A number that has no effect under the other keys of a recipe is a fault where a recipe gives it another value than its
//! default: nothing that is written is passed over in silence.

use std::collections::BTreeMap;

use super::bounds::DrawBounds;
use crate::class::Class;
use crate::distribution::Distribution;
use crate::keys;
use crate::keys::idle::{Idle, Wording};
use crate::keys::settings::Settings;
use crate::subject::Subject;
use bench::settings::{Fan, Filter, LineShape, Movement, Scheimpflug, Words};
use yaml::YamlReader;

/// What a parameter needs to have an effect.
#[derive(Debug, Clone, Copy)]
enum ParameterNeeds {
    /// A movement of the object.
    Movement(Movement),
    /// One of some shapes of the laser's line.
    Profile(&'static [LineShape]),
    /// A lens of the laser.
    Fan(Fan),
    /// Who says how the sensor stands.
    Scheimpflug(Scheimpflug),
    /// A filter before the lens.
    Filter(Filter),
    /// Facets of metal.
    Facets,
    /// Fibres.
    Fibres,
    /// Another parameter that can be other than 0, by its path.
    Amount(&'static str),
}

use ParameterNeeds::{Amount, Facets, Fibres, Profile};

const BEAM: ParameterNeeds = Profile(&[LineShape::Gaussian, LineShape::Point]);
const BEAM_OR_SLIT: ParameterNeeds = Profile(&[LineShape::Gaussian, LineShape::Slit]);
const LINE: ParameterNeeds = Profile(&[LineShape::Gaussian, LineShape::Slit, LineShape::Texture]);
const GAUSSIAN: ParameterNeeds = Profile(&[LineShape::Gaussian]);
const SLIT: ParameterNeeds = Profile(&[LineShape::Slit]);
const TEXTURE: ParameterNeeds = Profile(&[LineShape::Texture]);
const POINT: ParameterNeeds = Profile(&[LineShape::Point]);
const POWELL: ParameterNeeds = ParameterNeeds::Fan(Fan::Powell);
const TURNTABLE: ParameterNeeds = ParameterNeeds::Movement(Movement::Turntable);
const GIVEN: ParameterNeeds = ParameterNeeds::Scheimpflug(Scheimpflug::Given);
const BAND_PASS: ParameterNeeds = ParameterNeeds::Filter(Filter::BandPass);

/// Every conditional parameter by its path; of several needs the first that is not met is told.
const CONDITIONAL: &[(&str, &[ParameterNeeds])] = &[
    ("motion.turn_radius_mm", &[TURNTABLE]),
    ("motion.turn_axis_x_mm", &[TURNTABLE]),
    ("motion.turn_axis_y_mm", &[TURNTABLE]),
    ("motion.wow_period_mm", &[Amount("motion.wow_um")]),
    ("laser.waist_mm", &[BEAM]),
    ("laser.waist_height_mm", &[BEAM]),
    ("laser.m_squared", &[BEAM]),
    ("laser.fan_angle_deg", &[BEAM_OR_SLIT]),
    ("laser.fan_ripple", &[BEAM_OR_SLIT]),
    ("laser.fan_soft_ends", &[BEAM_OR_SLIT, POWELL]),
    ("laser.width_jitter", &[BEAM_OR_SLIT]),
    ("laser.width_jitter_mm", &[BEAM_OR_SLIT, Amount("laser.width_jitter")]),
    ("laser.smile_um", &[LINE]),
    ("laser.smile_cubic_um", &[LINE]),
    ("laser.second_line_mm", &[LINE]),
    ("laser.second_line_share", &[LINE, Amount("laser.second_line_mm")]),
    ("laser.lobe_share", &[GAUSSIAN]),
    ("laser.lobe_pairs", &[GAUSSIAN, Amount("laser.lobe_share")]),
    ("laser.lobe_distance", &[GAUSSIAN, Amount("laser.lobe_share")]),
    ("laser.skirt_share", &[GAUSSIAN]),
    ("laser.skirt_width", &[GAUSSIAN, Amount("laser.skirt_share")]),
    ("laser.line_width_mm", &[SLIT]),
    ("laser.texture_length_mm", &[TEXTURE]),
    ("laser.texture_width_mm", &[TEXTURE]),
    ("laser.point_x_mm", &[POINT]),
    ("laser.point_step_mm", &[POINT]),
    ("laser.point_span_mm", &[POINT]),
    ("laser.streaks_per_mm", &[Fibres]),
    ("laser.streak_width_um", &[Amount("laser.streaks_per_mm")]),
    ("laser.streak_length_mm", &[Amount("laser.streaks_per_mm")]),
    ("laser.streak_share", &[Amount("laser.streaks_per_mm")]),
    ("laser.glints_per_mm", &[Facets]),
    ("laser.glint_gain", &[Amount("laser.glints_per_mm")]),
    ("laser.glint_length_mm", &[Amount("laser.glints_per_mm")]),
    ("camera.sensor_tilt_deg", &[GIVEN]),
    ("camera.focus_distance_mm", &[GIVEN]),
    ("camera.filter_centre_nm", &[BAND_PASS]),
    ("camera.filter_width_nm", &[BAND_PASS]),
    ("material.fibre_azimuth_deg", &[Amount("material.k_per_mm")]),
    ("material.fibre_dive_deg", &[Amount("material.k_per_mm")]),
];

/// Reflectance above which facets are taken for metal ([`procedural::Gloss::is_metal`]) [1].
const MIN_METAL_REFLECTANCE: f64 = 0.5;

/// Notes parameters that have no effect, at the top level and in each class.
pub(crate) fn refuse(
    yaml: &mut YamlReader,
    subject: Option<Subject>,
    settings: &Settings,
    base: &BTreeMap<String, Distribution>,
    classes: &[Class],
) {
    let none = BTreeMap::new();
    let top = DrawBounds { prefix: "", base, overrides: &none };
    let prefixes: Vec<_> = classes.iter().map(|class| format!("classes.{}.", class.name)).collect();
    let scenes: Vec<_> = classes
        .iter()
        .zip(&prefixes)
        .map(|(class, prefix)| DrawBounds { prefix, base, overrides: &class.overrides })
        .collect();
    for (path, needs) in CONDITIONAL {
        let Some(parameter) = keys::parameters(subject).find(|parameter| parameter.path() == *path) else { continue };
        let usual = Distribution::Fixed(parameter.default);
        let refusal = |scene: &DrawBounds| needs.iter().find_map(|need| need.refusal(subject, settings, scene));
        if base.get(*path) != Some(&usual)
            && scenes.iter().all(|scene| refusal(scene).is_some())
            && let Some((problem, remedy)) = refusal(&top).or_else(|| scenes.iter().find_map(refusal))
        {
            yaml.joint_fault(&[(*path).to_owned()], problem, remedy);
        }
        for (class, scene) in classes.iter().zip(&scenes) {
            let own = class.overrides.get(*path).filter(|own| **own != usual);
            if let (Some(_), Some((problem, remedy))) = (own, refusal(scene)) {
                yaml.joint_fault(&[format!("{}{path}", scene.prefix)], problem, remedy);
            }
        }
    }
}

impl ParameterNeeds {
    /// Why a parameter with this need has no effect, and what to do; `None` where the need is met.
    fn refusal(self, subject: Option<Subject>, settings: &Settings, scene: &DrawBounds) -> Option<(String, String)> {
        match self {
            Self::Movement(wanted) => unmet(("motion", "kind"), settings.motion.kind, &[wanted], Wording::OnPair),
            Self::Profile(wanted) => unmet(("laser", "profile"), settings.laser.profile, wanted, Wording::OnPair),
            Self::Fan(wanted) => unmet(("laser", "fan"), settings.laser.fan, &[wanted], Wording::OnPair),
            Self::Scheimpflug(wanted) => {
                unmet(("camera", "scheimpflug"), settings.camera.scheimpflug, &[wanted], Wording::While)
            }
            Self::Filter(wanted) => unmet(("camera", "filter"), settings.camera.filter, &[wanted], Wording::While),
            Self::Facets => no_facets(subject?, scene).map(no_matter),
            Self::Fibres => no_fibres(subject?, scene).map(no_matter),
            Self::Amount(path) => (scene.least(path) == 0.0 && scene.most(path) == 0.0)
                .then(|| (format!("has no effect while `{path}` is 0"), format!("give `{path}` too, or remove it"))),
        }
    }
}

/// The refusal of a parameter that needs one of the words `wanted` of a setting, where another is chosen.
fn unmet<T: Words>(
    (section, key): (&'static str, &'static str),
    chosen: T,
    wanted: &[T],
    wording: Wording,
) -> Option<(String, String)> {
    let words = wanted.iter().map(|word| word.name()).collect();
    (!wanted.contains(&chosen)).then(|| Idle { section, key, chosen: chosen.name(), words, wording }.refusal())
}

/// What matter lacks, and what to do, as a refusal.
fn no_matter((lack, remedy): (&str, &str)) -> (String, String) {
    (format!("has no effect: {lack}"), remedy.to_owned())
}

/// Why matter has no facets of metal, and what to do.
fn no_facets(subject: Subject, scene: &DrawBounds) -> Option<(&'static str, &'static str)> {
    match subject {
        Subject::Wood => Some(("boards have no metal", "remove it")),
        Subject::Blister => None,
        Subject::Sawtooth | Subject::Mesh => {
            let dull =
                scene.most("material.gloss") == 0.0 || scene.most("material.reflectance") <= MIN_METAL_REFLECTANCE;
            dull.then_some((
                "the material has no facets of metal",
                "give `material.gloss` above 0 and `material.reflectance` above 0.5, or remove it",
            ))
        }
    }
}

/// Why matter has no fibres, and what to do.
fn no_fibres(subject: Subject, scene: &DrawBounds) -> Option<(&'static str, &'static str)> {
    match subject {
        Subject::Wood => None,
        Subject::Blister => Some(("packs have no fibres", "remove it")),
        Subject::Sawtooth | Subject::Mesh => (scene.most("material.k_per_mm") == 0.0)
            .then_some(("the material has no fibres", "give `material.k_per_mm` above 0, or remove it")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn conditions_are_of_parameters_that_are_declared() {
        let declared = |path: &str| keys::parameters(None).any(|parameter| parameter.path() == path);
        for (path, needs) in CONDITIONAL {
            assert!(declared(path), "{path}");
            for need in *needs {
                assert!(!matches!(need, Amount(amount) if !declared(amount)), "{path} needs {need:?}");
            }
        }
    }
}
