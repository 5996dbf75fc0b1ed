//! From a node to a layer.

use glam::DVec3;

use super::read::{number, range};
use crate::transport::stack::{CylinderPhase, Layer, Scattering, WOOD_DISPERSION};
use crate::yaml::{Mapping, NumberRange, YamlNode, YamlReader, YamlValue};

/// Keys of a layer.
pub(super) const KEYS: [&str; 7] = ["thickness_mm", "n", "mu_a_per_mm", "coat", "isotropic", "fibres", "tensor"];
/// The laws of scattering among them.
const LAWS: [&str; 3] = ["isotropic", "fibres", "tensor"];

/// Refractive indices.
pub(super) const INDEX: NumberRange = range(1.0, 4.0, "");
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
pub(super) fn read(yaml: &mut YamlReader, node: &YamlNode, i: usize, last: bool) -> Option<Layer> {
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
    let laws: Vec<_> = LAWS.iter().filter_map(|law| map.take(yaml, law).map(|node| (*law, node))).collect();
    let scattering = match laws.as_slice() {
        [] => Some(Scattering::Isotropic { mu_s: 0.0, g: 0.0 }),
        [(law, node)] => scattering(yaml, node, &map.path_of(law), law),
        [_, (law, node), ..] => {
            let remedy = "a layer scatters by one of isotropic, fibres, tensor: remove the others";
            yaml.fault(node.place, &map.path_of(law), "is a second law of scattering", remedy);
            None
        }
    };
    map.close(yaml, &KEYS, &|_| None);
    Some(Layer { coat: coat?, ..Layer::new(thickness?, n?, mu_a?, scattering?) })
}

fn scattering(yaml: &mut YamlReader, node: &YamlNode, path: &str, law: &str) -> Option<Scattering> {
    let mut map = yaml.mapping(node, path);
    let (read, known): (_, &[&str]) = match law {
        "isotropic" => {
            let mu_s = number(yaml, &mut map, "mu_s_per_mm", SCATTERING, None);
            let g = number(yaml, &mut map, "g", COSINE, Some(0.0));
            (mu_s.zip(g).map(|(mu_s, g)| Scattering::Isotropic { mu_s, g }), &["mu_s_per_mm", "g"])
        }
        "tensor" => {
            let mu_s = numbers(yaml, &mut map, "mu_s_per_mm", "three numbers, [along x, along y, along z]", SCATTERING)
                .map(DVec3::from_array);
            let g = number(yaml, &mut map, "g", COSINE, Some(0.0));
            (mu_s.zip(g).map(|(mu_s, g)| Scattering::Tensor { mu_s, g }), &["mu_s_per_mm", "g"])
        }
        _ => (fibres(yaml, &mut map), &FIBRES),
    };
    map.close(yaml, known, &|_| None);
    read
}

const FIBRES: [&str; 7] =
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

/// As many numbers as wanted; `wanted` says which.
pub(super) fn numbers<const N: usize>(
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
