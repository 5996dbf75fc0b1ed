//! From a node to a layer.

use glam::DVec3;

use super::read::{number, range};
use crate::transport::stack::{CylinderPhase, Layer, Scattering, WOOD_DISPERSION};
use crate::yaml::node::{Node, Value};
use crate::yaml::walk::{Range, Section, Walk};

/// Keys of a layer.
pub(super) const KEYS: [&str; 7] = ["thickness_mm", "n", "mu_a_per_mm", "coat", "isotropic", "fibres", "tensor"];
/// The laws of scattering among them.
const LAWS: [&str; 3] = ["isotropic", "fibres", "tensor"];

/// Refractive indices.
pub(super) const INDEX: Range = range(1.0, 4.0, "");
/// Thinner layers are waves' business, not photons'.
const THICKNESS: Range = range(1e-4, 1e4, "mm");
const ABSORPTION: Range = range(0.0, 1e4, "1/mm");
const SCATTERING: Range = range(0.0, 1e5, "1/mm");
/// A coat that lets nothing through would hide the layer.
const COAT: Range = range(1e-3, 1.0, "");
/// A mean cosine; light that goes only forwards or only backwards has no density.
const COSINE: Range = range(-0.999, 0.999, "");
const AZIMUTH: Range = range(-360.0, 360.0, "deg");
const DIVE: Range = range(-90.0, 90.0, "deg");
const DISPERSION: Range = range(0.0, 30.0, "deg");

/// Reads entry number `i` of the layers.
pub(super) fn read(walk: &mut Walk, node: &Node, i: usize, last: bool) -> Option<Layer> {
    let path = format!("layers[{i}]");
    let mut map = walk.section(node, &path);
    if !matches!(node.value, Value::Map(_)) {
        if matches!(node.value, Value::Nothing) {
            walk.fault(node.place, &path, "is nothing", "give the keys of a layer");
        }
        return None;
    }
    // Only the last layer may be without end.
    let thickness = number(walk, &mut map, "thickness_mm", THICKNESS, last.then_some(f64::INFINITY));
    let n = number(walk, &mut map, "n", INDEX, None);
    let mu_a = number(walk, &mut map, "mu_a_per_mm", ABSORPTION, None);
    let coat = number(walk, &mut map, "coat", COAT, Some(1.0));
    let laws: Vec<_> = LAWS.iter().filter_map(|law| map.take(walk, law).map(|node| (*law, node))).collect();
    let scattering = match laws.as_slice() {
        [] => Some(Scattering::Isotropic { mu_s: 0.0, g: 0.0 }),
        [(law, node)] => scattering(walk, node, &map.path_of(law), law),
        [_, (law, node), ..] => {
            let remedy = "a layer scatters by one of isotropic, fibres, tensor: remove the others";
            walk.fault(node.place, &map.path_of(law), "is a second law of scattering", remedy);
            None
        }
    };
    map.close(walk, &KEYS, &|_| None);
    Some(Layer { coat: coat?, ..Layer::new(thickness?, n?, mu_a?, scattering?) })
}

fn scattering(walk: &mut Walk, node: &Node, path: &str, law: &str) -> Option<Scattering> {
    let mut map = walk.section(node, path);
    let (read, known): (_, &[&str]) = match law {
        "isotropic" => {
            let mu_s = number(walk, &mut map, "mu_s_per_mm", SCATTERING, None);
            let g = number(walk, &mut map, "g", COSINE, Some(0.0));
            (mu_s.zip(g).map(|(mu_s, g)| Scattering::Isotropic { mu_s, g }), &["mu_s_per_mm", "g"])
        }
        "tensor" => {
            let mu_s = numbers(walk, &mut map, "mu_s_per_mm", "three numbers, [along x, along y, along z]", SCATTERING)
                .map(DVec3::from_array);
            let g = number(walk, &mut map, "g", COSINE, Some(0.0));
            (mu_s.zip(g).map(|(mu_s, g)| Scattering::Tensor { mu_s, g }), &["mu_s_per_mm", "g"])
        }
        _ => (fibres(walk, &mut map), &FIBRES),
    };
    map.close(walk, known, &|_| None);
    read
}

const FIBRES: [&str; 7] =
    ["sigma_i_per_mm", "sigma_c_per_mm", "g2", "turn", "azimuth_deg", "dive_deg", "dispersion_deg"];

fn fibres(walk: &mut Walk, map: &mut Section) -> Option<Scattering> {
    let sigma_i = number(walk, map, "sigma_i_per_mm", SCATTERING, None);
    let sigma_c = number(walk, map, "sigma_c_per_mm", SCATTERING, None);
    let (g2, turn) = (map.take(walk, "g2"), map.take(walk, "turn"));
    let turn = match (g2, turn) {
        (Some(_), Some(node)) => {
            let problem = "stands beside `g2`";
            walk.fault(node.place, &map.path_of("turn"), problem, "a mirror has no g2: remove one of them");
            None
        }
        (Some(node), None) => walk.number_in(node, &map.path_of("g2"), COSINE).map(CylinderPhase::Cauchy),
        (None, Some(node)) => walk.word(node, &map.path_of("turn"), &["mirror"]).map(|_| CylinderPhase::Mirror),
        (None, None) => Some(CylinderPhase::Cauchy(0.0)),
    };
    let azimuth = number(walk, map, "azimuth_deg", AZIMUTH, Some(0.0));
    let dive = number(walk, map, "dive_deg", DIVE, Some(0.0));
    let dispersion = number(walk, map, "dispersion_deg", DISPERSION, Some(WOOD_DISPERSION.to_degrees()));
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
    walk: &mut Walk,
    map: &mut Section,
    name: &str,
    wanted: &str,
    range: Range,
) -> Option<[f64; N]> {
    let path = map.path_of(name);
    let remedy = format!("give {wanted}");
    let Some(node) = map.take(walk, name) else {
        walk.fault(map.place(), &path, "is missing", remedy);
        return None;
    };
    match &node.value {
        Value::List(entries) if entries.len() == N => {
            let read: Vec<_> = entries.iter().map(|entry| walk.number_in(entry, &path, range)).collect();
            read.into_iter().collect::<Option<Vec<f64>>>()?.try_into().ok()
        }
        Value::List(entries) => {
            walk.fault(node.place, &path, format!("has {} entries", entries.len()), remedy);
            None
        }
        other => {
            walk.fault(node.place, &path, format!("is {}", other.kind()), remedy);
            None
        }
    }
}
