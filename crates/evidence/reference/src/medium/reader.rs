//! Reader of media: from YAML text to layers and a question, with every fault of the text at once.
//!
//! First what stands around the layers, then a layer, then the question, then numbers with their ranges.

use std::f64::consts::FRAC_PI_2;

use glam::DVec3;

use super::LayeredMedium;
use transport::answer::Question;
use transport::stack::{CylinderPhase, Foil, Layer, Scattering, Stack, Substrate, WOOD_DISPERSION};
use yaml::{Mapping, NumberRange, YamlFaults, YamlNode, YamlReader, YamlValue, parse_yaml};

/// What faults call the file.
pub(super) const NOUN: &str = "medium";
/// Smoother foil is a mirror, rougher foil no foil.
const ROUGHNESS: NumberRange = range(1e-3, 1.0, "");
/// Most layers.
const MAX_LAYERS: usize = 64;

/// Reads `text`; every fault that is found comes back.
pub(super) fn read(origin: &str, text: &str) -> Result<LayeredMedium, YamlFaults> {
    let mut yaml = YamlReader::new(text, NOUN);
    let medium = match parse_yaml(text, NOUN) {
        Ok(root) => medium(&mut yaml, &root),
        Err(error) => {
            yaml.fault(error.place, "", error.problem, error.remedy);
            None
        }
    };
    yaml.finish(origin)?;
    Ok(medium.expect("whatever gives no medium notes a fault"))
}

fn medium(yaml: &mut YamlReader, root: &YamlNode) -> Option<LayeredMedium> {
    if !matches!(root.value, YamlValue::Map(_)) {
        let problem = match &root.value {
            YamlValue::Nothing => "the file is empty".to_owned(),
            other => format!("the file is {}", other.kind()),
        };
        yaml.fault(root.place, "", problem, "a medium is a map with at least `layers`");
        return None;
    }
    let mut top = yaml.mapping(root, "");
    let above = number(yaml, &mut top, "n_above", INDEX, Some(1.0));
    let layers = top.take(yaml, "layers");
    if layers.is_none() {
        yaml.fault(root.place, "layers", "is missing", "list the layers from the surface downwards, `layers: [{...}]`");
    }
    let layers = layers.and_then(|node| read_layers(yaml, node));
    let below = below(yaml, &mut top);
    let question = match top.take(yaml, "question") {
        Some(node) => read_question(yaml, node),
        None => Some(Question { incidence_azimuth: to_model_azimuth(0.0), ..Question::default() }),
    };
    top.close(yaml, &["n_above", "layers", "n_below", "below", "question"], &|name| {
        LAYER_KEYS.contains(&name).then(|| format!("`{name}` belongs in an entry of `layers`"))
    });
    Some(LayeredMedium { stack: Stack { above: above?, layers: layers?, below: below? }, question: question? })
}

/// What the last layer lies on: an index, or foil.
fn below(yaml: &mut YamlReader, top: &mut Mapping) -> Option<Substrate> {
    let index = top.take(yaml, "n_below").map(|node| (node, yaml.number_in(node, "n_below", INDEX)));
    let Some(node) = top.take(yaml, "below") else {
        return index.map_or(Some(1.0), |(_, n)| n).map(Substrate::Index);
    };
    if let Some((node, _)) = index {
        yaml.fault(node.place, "n_below", "stands beside `below`", "foil has no index: remove one of them");
    }
    let mut map = yaml.mapping(node, "below");
    let foil = map.take(yaml, "foil");
    map.close(yaml, &["foil"], &|_| None);
    let Some(foil) = foil else {
        let remedy =
            "write `below: {foil: {reflectance: 0.9, roughness: [0.25, 0.12]}}`, or `n_below` for clear matter";
        yaml.fault(node.place, "below.foil", "is missing", remedy);
        return None;
    };
    let mut map = yaml.mapping(foil, "below.foil");
    let reflectance = number(yaml, &mut map, "reflectance", range(0.0, 1.0, ""), None);
    let roughness = numbers(yaml, &mut map, "roughness", "two numbers, [along x, along y]", ROUGHNESS);
    map.close(yaml, &["reflectance", "roughness"], &|_| None);
    Some(Substrate::Foil(Foil { reflectance: reflectance?, roughness: roughness? }))
}

fn read_layers(yaml: &mut YamlReader, node: &YamlNode) -> Option<Vec<Layer>> {
    let YamlValue::List(entries) = &node.value else {
        let problem = format!("is {}", node.value.kind());
        yaml.fault(node.place, "layers", problem, "give a list of layers, each behind a dash");
        return None;
    };
    if entries.is_empty() || entries.len() > MAX_LAYERS {
        let problem = format!("has {} layers", entries.len());
        yaml.fault(node.place, "layers", problem, format!("give 1 to {MAX_LAYERS} layers"));
        return None;
    }
    let last = entries.len() - 1;
    let read: Vec<_> = entries.iter().enumerate().map(|(i, entry)| read_layer(yaml, entry, i, i == last)).collect();
    read.into_iter().collect()
}

/// Keys of a layer.
const LAYER_KEYS: [&str; 7] = ["thickness_mm", "n", "mu_a_per_mm", "coat", "isotropic", "fibres", "tensor"];
/// A law of scattering: its key in a layer, what reads it, and its own keys.
type ScatteringLaw = (&'static str, fn(&mut YamlReader, &mut Mapping) -> Option<Scattering>, &'static [&'static str]);
/// The laws of scattering.
const SCATTERING_LAWS: [ScatteringLaw; 3] = [
    ("isotropic", isotropic, &["mu_s_per_mm", "g"]),
    ("fibres", fibres, &FIBRE_KEYS),
    ("tensor", tensor, &["mu_s_per_mm", "g"]),
];

/// Refractive indices.
const INDEX: NumberRange = range(1.0, 4.0, "");
/// Thinner layers are waves' business, not photons'.
const THICKNESS: NumberRange = range(1e-4, 1e4, "mm");
const ABSORPTION: NumberRange = range(0.0, 1e4, "1/mm");
const SCATTERING: NumberRange = range(0.0, 1e5, "1/mm");
/// A coat that lets nothing through would hide the layer.
const COAT: NumberRange = range(1e-3, 1.0, "");
/// A mean cosine; light that goes only forwards or only backwards has no density.
const COSINE: NumberRange = range(-0.999, 0.999, "");
const AZIMUTH: NumberRange = range(-360.0, 360.0, "deg");
const DIVE: NumberRange = range(-90.0, 90.0, "deg");
const DISPERSION: NumberRange = range(0.0, 30.0, "deg");

/// Reads entry number `i` of the layers.
fn read_layer(yaml: &mut YamlReader, node: &YamlNode, i: usize, last: bool) -> Option<Layer> {
    let path = format!("layers[{i}]");
    let mut map = yaml.mapping(node, &path);
    if !matches!(node.value, YamlValue::Map(_)) {
        if matches!(node.value, YamlValue::Nothing) {
            yaml.fault(node.place, &path, "is nothing", "give the keys of a layer");
        }
        return None;
    }
    // Only the last layer may be without end.
    let thickness = number(yaml, &mut map, "thickness_mm", THICKNESS, last.then_some(f64::INFINITY));
    let n = number(yaml, &mut map, "n", INDEX, None);
    let mu_a = number(yaml, &mut map, "mu_a_per_mm", ABSORPTION, None);
    let coat = number(yaml, &mut map, "coat", COAT, Some(1.0));
    let given = SCATTERING_LAWS.iter().filter_map(|law| map.take(yaml, law.0).map(|node| (law, node)));
    let scattering = match given.collect::<Vec<_>>().as_slice() {
        [] => Some(Scattering::Isotropic { mu_s: 0.0, g: 0.0 }),
        [((name, read, keys), node)] => {
            let mut law = yaml.mapping(node, &map.path_of(name));
            let scattering = read(yaml, &mut law);
            law.close(yaml, keys, &|_| None);
            scattering
        }
        [_, ((name, ..), node), ..] => {
            let remedy = "a layer scatters by one of isotropic, fibres, tensor: remove the others";
            yaml.fault(node.place, &map.path_of(name), "is a second law of scattering", remedy);
            None
        }
    };
    map.close(yaml, &LAYER_KEYS, &|_| None);
    Some(Layer { coat: coat?, ..Layer::new(thickness?, n?, mu_a?, scattering?) })
}

fn isotropic(yaml: &mut YamlReader, map: &mut Mapping) -> Option<Scattering> {
    let mu_s = number(yaml, map, "mu_s_per_mm", SCATTERING, None);
    let g = number(yaml, map, "g", COSINE, Some(0.0));
    Some(Scattering::Isotropic { mu_s: mu_s?, g: g? })
}

fn tensor(yaml: &mut YamlReader, map: &mut Mapping) -> Option<Scattering> {
    let mu_s = numbers(yaml, map, "mu_s_per_mm", "three numbers, [along x, along y, along z]", SCATTERING);
    let g = number(yaml, map, "g", COSINE, Some(0.0));
    Some(Scattering::Tensor { mu_s: DVec3::from_array(mu_s?), g: g? })
}

/// Keys of a layer of fibres.
const FIBRE_KEYS: [&str; 7] =
    ["sigma_i_per_mm", "sigma_c_per_mm", "g2", "turn", "azimuth_deg", "dive_deg", "dispersion_deg"];

fn fibres(yaml: &mut YamlReader, map: &mut Mapping) -> Option<Scattering> {
    let sigma_i = number(yaml, map, "sigma_i_per_mm", SCATTERING, None);
    let sigma_c = number(yaml, map, "sigma_c_per_mm", SCATTERING, None);
    let (g2, turn) = (map.take(yaml, "g2"), map.take(yaml, "turn"));
    let turn = match (g2, turn) {
        (Some(_), Some(node)) => {
            let problem = "stands beside `g2`";
            yaml.fault(node.place, &map.path_of("turn"), problem, "a mirror has no g2: remove one of them");
            None
        }
        (Some(node), None) => yaml.number_in(node, &map.path_of("g2"), COSINE).map(CylinderPhase::Cauchy),
        (None, Some(node)) => yaml.word(node, &map.path_of("turn"), &["mirror"]).map(|_| CylinderPhase::Mirror),
        (None, None) => Some(CylinderPhase::Cauchy(0.0)),
    };
    let azimuth = number(yaml, map, "azimuth_deg", AZIMUTH, Some(0.0));
    let dive = number(yaml, map, "dive_deg", DIVE, Some(0.0));
    let dispersion = number(yaml, map, "dispersion_deg", DISPERSION, Some(WOOD_DISPERSION.to_degrees()));
    Some(Scattering::Fibres {
        sigma_i: sigma_i?,
        sigma_c: sigma_c?,
        turn: turn?,
        axis: axis(azimuth?, dive?),
        dispersion: dispersion?.to_radians(),
    })
}

/// Unit vector along fibres whose track has this azimuth [deg] and which rise with it by `dive` [deg].
pub fn axis(azimuth: f64, dive: f64) -> DVec3 {
    let (across, along) = libm::sincos(azimuth.to_radians());
    let (up, flat) = libm::sincos(dive.to_radians());
    DVec3::new(flat * across, flat * along, up).normalize()
}

/// Keys of the question.
const QUESTION_KEYS: [&str; 11] = [
    "incidence_deg",
    "diffuse",
    "incidence_azimuth_deg",
    "view_tilt_deg",
    "view_azimuth_deg",
    "line_sd_mm",
    "row_mm",
    "rows",
    "cell_mm",
    "cells",
    "angles",
];
const INCIDENCE: NumberRange = range(0.0, 89.0, "deg");
/// Azimuth of the reference camera, on the side of small y [deg].
const VIEW_AZIMUTH: f64 = 180.0;
/// Tilt of the reference camera [deg].
const VIEW_TILT: f64 = 25.0;

const fn count(max: f64) -> NumberRange {
    NumberRange { min: 0.0, max, whole: true, unit: "" }
}

/// Reads the question at `node`.
fn read_question(yaml: &mut YamlReader, node: &YamlNode) -> Option<Question> {
    let usual = Question::default();
    let mut map = yaml.mapping(node, "question");
    let diffuse = map.take(yaml, "diffuse").map(|node| (node, flag(yaml, node, "question.diffuse")));
    let incidence = number(yaml, &mut map, "incidence_deg", INCIDENCE, Some(-1.0));
    let incidence = match (diffuse, incidence) {
        (Some((node, Some(true))), Some(0.0..)) => {
            let remedy = "light is diffuse or has a direction: remove one of them";
            yaml.fault(node.place, "question.diffuse", "stands beside `incidence_deg`", remedy);
            None
        }
        (Some((_, None)), _) => None,
        (Some((_, Some(true))), _) => Some(None),
        (_, angle) => angle.map(|angle| Some(angle.max(0.0).to_radians())),
    };
    let incidence_azimuth = number(yaml, &mut map, "incidence_azimuth_deg", AZIMUTH, Some(0.0));
    let tilt = number(yaml, &mut map, "view_tilt_deg", INCIDENCE, Some(VIEW_TILT));
    let azimuth = number(yaml, &mut map, "view_azimuth_deg", AZIMUTH, Some(VIEW_AZIMUTH));
    let line_mm = number(yaml, &mut map, "line_sd_mm", range(0.0, 10.0, "mm"), Some(usual.line_mm));
    let pitch = range(1e-3, 100.0, "mm");
    let row_mm = number(yaml, &mut map, "row_mm", pitch, Some(usual.row_mm));
    let rows = number(yaml, &mut map, "rows", count(2000.0), Some(usual.rows as f64));
    let cell_mm = number(yaml, &mut map, "cell_mm", pitch, Some(usual.cell_mm));
    let cells = number(yaml, &mut map, "cells", count(200.0), Some(usual.cells as f64));
    let angles = number(yaml, &mut map, "angles", count(180.0), Some(usual.angles as f64));
    map.close(yaml, &QUESTION_KEYS, &|_| None);
    Some(Question {
        incidence: incidence?,
        incidence_azimuth: to_model_azimuth(incidence_azimuth?),
        view: view(tilt?, azimuth?),
        line_mm: line_mm?,
        row_mm: row_mm?,
        rows: rows? as usize,
        cell_mm: cell_mm?,
        cells: cells? as usize,
        angles: angles? as usize,
    })
}

/// An azimuth of a file, from +y towards +x [deg], as the models count it, from +x towards +y [rad].
fn to_model_azimuth(azimuth: f64) -> f64 {
    FRAC_PI_2 - azimuth.to_radians()
}

fn view(tilt: f64, azimuth: f64) -> DVec3 {
    let (sin, cos) = libm::sincos(tilt.to_radians());
    if azimuth == VIEW_AZIMUTH {
        return DVec3::new(0.0, -sin, cos);
    }
    let (across, along) = libm::sincos(azimuth.to_radians());
    DVec3::new(sin * across, sin * along, cos)
}

fn flag(yaml: &mut YamlReader, node: &YamlNode, path: &str) -> Option<bool> {
    if let YamlValue::Flag(flag) = node.value {
        return Some(flag);
    }
    yaml.fault(node.place, path, format!("is {}", node.value.kind()), "give true or false");
    None
}

/// As many numbers as wanted; `wanted` says which.
fn numbers<const N: usize>(
    yaml: &mut YamlReader,
    map: &mut Mapping,
    name: &str,
    wanted: &str,
    range: NumberRange,
) -> Option<[f64; N]> {
    let path = map.path_of(name);
    let remedy = format!("give {wanted}");
    let Some(node) = map.take(yaml, name) else {
        yaml.fault(map.place(), &path, "is missing", remedy);
        return None;
    };
    match &node.value {
        YamlValue::List(entries) if entries.len() == N => {
            let read: Vec<_> = entries.iter().map(|entry| yaml.number_in(entry, &path, range)).collect();
            read.into_iter().collect::<Option<Vec<f64>>>()?.try_into().ok()
        }
        YamlValue::List(entries) => {
            yaml.fault(node.place, &path, format!("has {} entries", entries.len()), remedy);
            None
        }
        other => {
            yaml.fault(node.place, &path, format!("is {}", other.kind()), remedy);
            None
        }
    }
}

/// The number at `name`; `default` where the file has none, and a fault where there is no default either.
fn number(
    yaml: &mut YamlReader,
    map: &mut Mapping,
    name: &str,
    range: NumberRange,
    default: Option<f64>,
) -> Option<f64> {
    let path = map.path_of(name);
    match map.take(yaml, name) {
        Some(node) => yaml.number_in(node, &path, range),
        None => {
            if default.is_none() {
                yaml.fault(map.place(), &path, "is missing", format!("give {range}"));
            }
            default
        }
    }
}

/// Numbers from `min` to `max`.
const fn range(min: f64, max: f64, unit: &'static str) -> NumberRange {
    NumberRange { min, max, whole: false, unit }
}
