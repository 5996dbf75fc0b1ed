//! Reader of media: from YAML text to layers and a question, with every fault of the text at once.
//!
//! First what stands around the layers, then a layer, then the question, then numbers with their ranges.

use std::f64::consts::FRAC_PI_2;

use glam::DVec3;

use super::LayeredMedium;
use transport::answer::Question;
use transport::stack::{CylinderPhase, Foil, Layer, Scattering, Stack, Substrate, WOOD_DISPERSION};
use yaml::{Mapping, NumberRange, TextPosition, YamlFaults, YamlNode, YamlReader, YamlValue, parse_yaml};

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
    let mut top = MediumMap::new(yaml, root, "");
    let above = top.number("n_above", INDEX, Some(1.0));
    let layers = top.wanted("layers", "list the layers from the surface downwards, `layers: [{...}]`");
    let layers = layers.and_then(|node| read_layers(top.yaml, node));
    let below = below(&mut top);
    let question = match top.take("question") {
        Some(node) => read_question(top.yaml, node),
        None => Some(Question { incidence_azimuth: to_model_azimuth(0.0), ..Question::default() }),
    };
    top.close(&|name| LAYER_KEYS.contains(&name).then(|| format!("`{name}` belongs in an entry of `layers`")));
    Some(LayeredMedium { stack: Stack { above: above?, layers: layers?, below: below? }, question: question? })
}

/// What the last layer lies on: an index, or foil.
fn below(top: &mut MediumMap) -> Option<Substrate> {
    let index = top.take("n_below").map(|node| (node, top.yaml.number_in(node, "n_below", INDEX)));
    let Some(node) = top.take("below") else {
        return index.map_or(Some(1.0), |(_, n)| n).map(Substrate::Index);
    };
    if let Some((node, _)) = index {
        top.yaml.fault(node.place, "n_below", "stands beside `below`", "foil has no index: remove one of them");
    }
    let mut map = MediumMap::new(top.yaml, node, "below");
    let remedy = "write `below: {foil: {reflectance: 0.9, roughness: [0.25, 0.12]}}`, or `n_below` for clear matter";
    let foil = map.wanted("foil", remedy);
    map.close(&|_| None);
    let mut map = MediumMap::new(top.yaml, foil?, "below.foil");
    let reflectance = map.number("reflectance", range(0.0, 1.0, ""), None);
    let roughness = map.numbers("roughness", "two numbers, [along x, along y]", ROUGHNESS);
    map.close(&|_| None);
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
/// What reads a law of scattering.
type ReadScattering = fn(&mut MediumMap) -> Option<Scattering>;
/// The laws of scattering by their keys in a layer.
const SCATTERING_LAWS: [(&str, ReadScattering); 3] = [("isotropic", isotropic), ("fibres", fibres), ("tensor", tensor)];

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
    let mut map = MediumMap::new(yaml, node, &path);
    if !matches!(node.value, YamlValue::Map(_)) {
        if matches!(node.value, YamlValue::Nothing) {
            yaml.fault(node.place, &path, "is nothing", "give the keys of a layer");
        }
        return None;
    }
    // Only the last layer may be without end.
    let thickness = map.number("thickness_mm", THICKNESS, last.then_some(f64::INFINITY));
    let n = map.number("n", INDEX, None);
    let mu_a = map.number("mu_a_per_mm", ABSORPTION, None);
    let coat = map.number("coat", COAT, Some(1.0));
    let given = SCATTERING_LAWS.iter().filter_map(|law| map.take(law.0).map(|node| (law, node)));
    let scattering = match given.collect::<Vec<_>>().as_slice() {
        [] => Some(Scattering::Isotropic { mu_s: 0.0, g: 0.0 }),
        [((name, read), node)] => {
            let mut law = MediumMap::new(map.yaml, node, &format!("{path}.{name}"));
            let scattering = read(&mut law);
            law.close(&|_| None);
            scattering
        }
        [_, ((name, _), node), ..] => {
            let remedy = "a layer scatters by one of isotropic, fibres, tensor: remove the others";
            map.fault(node.place, name, "is a second law of scattering", remedy);
            None
        }
    };
    map.close(&|_| None);
    Some(Layer { coat: coat?, ..Layer::new(thickness?, n?, mu_a?, scattering?) })
}

fn isotropic(map: &mut MediumMap) -> Option<Scattering> {
    let mu_s = map.number("mu_s_per_mm", SCATTERING, None);
    let g = map.number("g", COSINE, Some(0.0));
    Some(Scattering::Isotropic { mu_s: mu_s?, g: g? })
}

fn tensor(map: &mut MediumMap) -> Option<Scattering> {
    let mu_s = map.numbers("mu_s_per_mm", "three numbers, [along x, along y, along z]", SCATTERING);
    let g = map.number("g", COSINE, Some(0.0));
    Some(Scattering::Tensor { mu_s: DVec3::from_array(mu_s?), g: g? })
}

fn fibres(map: &mut MediumMap) -> Option<Scattering> {
    let sigma_i = map.number("sigma_i_per_mm", SCATTERING, None);
    let sigma_c = map.number("sigma_c_per_mm", SCATTERING, None);
    let (g2, turn) = (map.take("g2"), map.take("turn"));
    let turn = match (g2, turn) {
        (Some(_), Some(node)) => {
            map.fault(node.place, "turn", "stands beside `g2`", "a mirror has no g2: remove one of them");
            None
        }
        (Some(node), None) => map.number_at(node, "g2", COSINE).map(CylinderPhase::Cauchy),
        (None, Some(node)) => {
            let path = map.map.path_of("turn");
            map.yaml.word(node, &path, &["mirror"]).map(|_| CylinderPhase::Mirror)
        }
        (None, None) => Some(CylinderPhase::Cauchy(0.0)),
    };
    let azimuth = map.number("azimuth_deg", AZIMUTH, Some(0.0));
    let dive = map.number("dive_deg", DIVE, Some(0.0));
    let dispersion = map.number("dispersion_deg", DISPERSION, Some(WOOD_DISPERSION.to_degrees()));
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
    let mut map = MediumMap::new(yaml, node, "question");
    let incidence = map.number("incidence_deg", INCIDENCE, Some(-1.0));
    let diffuse = map.take("diffuse").map(|node| (node, map.flag(node, "diffuse")));
    let incidence = match (diffuse, incidence) {
        (Some((node, Some(true))), Some(0.0..)) => {
            let remedy = "light is diffuse or has a direction: remove one of them";
            map.fault(node.place, "diffuse", "stands beside `incidence_deg`", remedy);
            None
        }
        (Some((_, None)), _) => None,
        (Some((_, Some(true))), _) => Some(None),
        (_, angle) => angle.map(|angle| Some(angle.max(0.0).to_radians())),
    };
    let incidence_azimuth = map.number("incidence_azimuth_deg", AZIMUTH, Some(0.0));
    let tilt = map.number("view_tilt_deg", INCIDENCE, Some(VIEW_TILT));
    let azimuth = map.number("view_azimuth_deg", AZIMUTH, Some(VIEW_AZIMUTH));
    let line_mm = map.number("line_sd_mm", range(0.0, 10.0, "mm"), Some(usual.line_mm));
    let pitch = range(1e-3, 100.0, "mm");
    let row_mm = map.number("row_mm", pitch, Some(usual.row_mm));
    let rows = map.number("rows", count(2000.0), Some(usual.rows as f64));
    let cell_mm = map.number("cell_mm", pitch, Some(usual.cell_mm));
    let cells = map.number("cells", count(200.0), Some(usual.cells as f64));
    let angles = map.number("angles", count(180.0), Some(usual.angles as f64));
    map.close(&|_| None);
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

/// A map of a medium's file: what is asked for are the keys that there are.
struct MediumMap<'y, 't, 'n> {
    yaml: &'y mut YamlReader<'t>,
    map: Mapping<'n>,
    asked: Vec<&'static str>,
}

impl<'y, 't, 'n> MediumMap<'y, 't, 'n> {
    fn new(yaml: &'y mut YamlReader<'t>, node: &'n YamlNode, path: &str) -> Self {
        let map = yaml.mapping(node, path);
        Self { yaml, map, asked: Vec::new() }
    }

    /// The value of `name`, if the map has it.
    fn take(&mut self, name: &'static str) -> Option<&'n YamlNode> {
        self.asked.push(name);
        self.map.take(self.yaml, name)
    }

    /// The value of `name`; a fault with the remedy where the map lacks it.
    fn wanted(&mut self, name: &'static str, remedy: &str) -> Option<&'n YamlNode> {
        let node = self.take(name);
        if node.is_none() {
            self.fault(self.map.place(), name, "is missing", remedy);
        }
        node
    }

    /// Notes a fault of the key `name`.
    fn fault(&mut self, place: TextPosition, name: &str, problem: impl Into<String>, remedy: &str) {
        self.yaml.fault(place, &self.map.path_of(name), problem, remedy);
    }

    /// The number at `name`; `default` where the file has none, and a fault where there is no default either.
    fn number(&mut self, name: &'static str, range: NumberRange, default: Option<f64>) -> Option<f64> {
        if default.is_none() {
            let node = self.wanted(name, &format!("give {range}"))?;
            return self.number_at(node, name, range);
        }
        self.take(name).map_or(default, |node| self.number_at(node, name, range))
    }

    fn number_at(&mut self, node: &YamlNode, name: &str, range: NumberRange) -> Option<f64> {
        self.yaml.number_in(node, &self.map.path_of(name), range)
    }

    /// As many numbers as wanted; `wanted` says which.
    fn numbers<const N: usize>(&mut self, name: &'static str, wanted: &str, range: NumberRange) -> Option<[f64; N]> {
        let remedy = format!("give {wanted}");
        let node = self.wanted(name, &remedy)?;
        let problem = match &node.value {
            YamlValue::List(entries) if entries.len() == N => {
                let read: Vec<_> = entries.iter().map(|entry| self.number_at(entry, name, range)).collect();
                return read.into_iter().collect::<Option<Vec<f64>>>()?.try_into().ok();
            }
            YamlValue::List(entries) => format!("has {} entries", entries.len()),
            other => format!("is {}", other.kind()),
        };
        self.fault(node.place, name, problem, &remedy);
        None
    }

    fn flag(&mut self, node: &YamlNode, name: &str) -> Option<bool> {
        if let YamlValue::Flag(flag) = node.value {
            return Some(flag);
        }
        self.fault(node.place, name, format!("is {}", node.value.kind()), "give true or false");
        None
    }

    /// Faults every key that was not asked for; `elsewhere` tells where a key belongs.
    fn close(self, elsewhere: &dyn Fn(&str) -> Option<String>) {
        self.map.close(self.yaml, &self.asked, elsewhere);
    }
}

/// Numbers from `min` to `max`.
const fn range(min: f64, max: f64, unit: &'static str) -> NumberRange {
    NumberRange { min, max, whole: false, unit }
}
