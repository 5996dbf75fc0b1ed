//! From text to medium: what stands around the layers.

use super::layer::{self, INDEX};
use super::{Medium, question};
use crate::transport::answer::Question;
use crate::transport::stack::{Foil, Layer, Stack, Substrate};
use crate::yaml::{Mapping, NumberRange, YamlFaults, YamlNode, YamlReader, YamlValue, parse_yaml};

/// What faults call the file.
pub(super) const NOUN: &str = "medium";
/// Smoother foil is a mirror, rougher foil no foil.
const ROUGHNESS: NumberRange = range(1e-3, 1.0, "");
/// Most layers.
const MOST_LAYERS: usize = 64;

/// Reads `text`; every fault that is found comes back.
pub(super) fn read(origin: &str, text: &str) -> Result<Medium, YamlFaults> {
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

fn medium(yaml: &mut YamlReader, root: &YamlNode) -> Option<Medium> {
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
    let layers = layers.and_then(|node| list(yaml, node));
    let below = below(yaml, &mut top);
    let question = match top.take(yaml, "question") {
        Some(node) => question::read(yaml, node),
        None => Some(Question { incidence_azimuth: question::inward(0.0), ..Question::default() }),
    };
    top.close(yaml, &["n_above", "layers", "n_below", "below", "question"], &|name| {
        layer::KEYS.contains(&name).then(|| format!("`{name}` belongs in an entry of `layers`"))
    });
    Some(Medium { stack: Stack { above: above?, layers: layers?, below: below? }, question: question? })
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
    let roughness = layer::numbers(yaml, &mut map, "roughness", "two numbers, [along x, along y]", ROUGHNESS);
    map.close(yaml, &["reflectance", "roughness"], &|_| None);
    Some(Substrate::Foil(Foil { reflectance: reflectance?, roughness: roughness? }))
}

fn list(yaml: &mut YamlReader, node: &YamlNode) -> Option<Vec<Layer>> {
    let YamlValue::List(entries) = &node.value else {
        let problem = format!("is {}", node.value.kind());
        yaml.fault(node.place, "layers", problem, "give a list of layers, each behind a dash");
        return None;
    };
    if entries.is_empty() || entries.len() > MOST_LAYERS {
        let problem = format!("has {} layers", entries.len());
        yaml.fault(node.place, "layers", problem, format!("give 1 to {MOST_LAYERS} layers"));
        return None;
    }
    let last = entries.len() - 1;
    let read: Vec<_> = entries.iter().enumerate().map(|(i, entry)| layer::read(yaml, entry, i, i == last)).collect();
    read.into_iter().collect()
}

/// The number at `name`; `default` where the file has none, and a fault where there is no default either.
pub(super) fn number(
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
pub(super) const fn range(min: f64, max: f64, unit: &'static str) -> NumberRange {
    NumberRange { min, max, whole: false, unit }
}
