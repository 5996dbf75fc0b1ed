//! From text to medium: what stands around the layers.

use super::layer::{self, INDEX};
use super::{Medium, question};
use crate::transport::answer::Question;
use crate::transport::stack::{Foil, Layer, Stack, Substrate};
use crate::yaml::fault::Faults;
use crate::yaml::node::{self, Node, Value};
use crate::yaml::walk::{Range, Section, Walk};

/// What faults call the file.
pub(super) const NOUN: &str = "medium";
/// Smoother foil is a mirror, rougher foil no foil.
const ROUGHNESS: Range = range(1e-3, 1.0, "");
/// Most layers.
const MOST_LAYERS: usize = 64;

/// Reads `text`; every fault that is found comes back.
pub(super) fn read(origin: &str, text: &str) -> Result<Medium, Faults> {
    let mut walk = Walk::new(text, NOUN);
    let medium = match node::parse(text, NOUN) {
        Ok(root) => medium(&mut walk, &root),
        Err(error) => {
            walk.fault(error.place, "", error.problem, error.remedy);
            None
        }
    };
    walk.finish(origin)?;
    Ok(medium.expect("whatever gives no medium notes a fault"))
}

fn medium(walk: &mut Walk, root: &Node) -> Option<Medium> {
    if !matches!(root.value, Value::Map(_)) {
        let problem = match &root.value {
            Value::Nothing => "the file is empty".to_owned(),
            other => format!("the file is {}", other.kind()),
        };
        walk.fault(root.place, "", problem, "a medium is a map with at least `layers`");
        return None;
    }
    let mut top = walk.section(root, "");
    let above = number(walk, &mut top, "n_above", INDEX, Some(1.0));
    let layers = top.take(walk, "layers");
    if layers.is_none() {
        walk.fault(root.place, "layers", "is missing", "list the layers from the surface downwards, `layers: [{...}]`");
    }
    let layers = layers.and_then(|node| list(walk, node));
    let below = below(walk, &mut top);
    let question = match top.take(walk, "question") {
        Some(node) => question::read(walk, node),
        None => Some(Question { incidence_azimuth: question::inward(0.0), ..Question::default() }),
    };
    top.close(walk, &["n_above", "layers", "n_below", "below", "question"], &|name| {
        layer::KEYS.contains(&name).then(|| format!("`{name}` belongs in an entry of `layers`"))
    });
    Some(Medium { stack: Stack { above: above?, layers: layers?, below: below? }, question: question? })
}

/// What the last layer lies on: an index, or foil.
fn below(walk: &mut Walk, top: &mut Section) -> Option<Substrate> {
    let index = top.take(walk, "n_below").map(|node| (node, walk.number_in(node, "n_below", INDEX)));
    let Some(node) = top.take(walk, "below") else {
        return index.map_or(Some(1.0), |(_, n)| n).map(Substrate::Index);
    };
    if let Some((node, _)) = index {
        walk.fault(node.place, "n_below", "stands beside `below`", "foil has no index: remove one of them");
    }
    let mut map = walk.section(node, "below");
    let foil = map.take(walk, "foil");
    map.close(walk, &["foil"], &|_| None);
    let Some(foil) = foil else {
        let remedy =
            "write `below: {foil: {reflectance: 0.9, roughness: [0.25, 0.12]}}`, or `n_below` for clear matter";
        walk.fault(node.place, "below.foil", "is missing", remedy);
        return None;
    };
    let mut map = walk.section(foil, "below.foil");
    let reflectance = number(walk, &mut map, "reflectance", range(0.0, 1.0, ""), None);
    let roughness = layer::numbers(walk, &mut map, "roughness", "two numbers, [along x, along y]", ROUGHNESS);
    map.close(walk, &["reflectance", "roughness"], &|_| None);
    Some(Substrate::Foil(Foil { reflectance: reflectance?, roughness: roughness? }))
}

fn list(walk: &mut Walk, node: &Node) -> Option<Vec<Layer>> {
    let Value::List(entries) = &node.value else {
        let problem = format!("is {}", node.value.kind());
        walk.fault(node.place, "layers", problem, "give a list of layers, each behind a dash");
        return None;
    };
    if entries.is_empty() || entries.len() > MOST_LAYERS {
        let problem = format!("has {} layers", entries.len());
        walk.fault(node.place, "layers", problem, format!("give 1 to {MOST_LAYERS} layers"));
        return None;
    }
    let last = entries.len() - 1;
    let read: Vec<_> = entries.iter().enumerate().map(|(i, entry)| layer::read(walk, entry, i, i == last)).collect();
    read.into_iter().collect()
}

/// The number at `name`; `default` where the file has none, and a fault where there is no default either.
pub(super) fn number(
    walk: &mut Walk,
    map: &mut Section,
    name: &str,
    range: Range,
    default: Option<f64>,
) -> Option<f64> {
    let path = map.path_of(name);
    match map.take(walk, name) {
        Some(node) => walk.number_in(node, &path, range),
        None => {
            if default.is_none() {
                walk.fault(map.place(), &path, "is missing", format!("give {range}"));
            }
            default
        }
    }
}

/// Numbers from `min` to `max`.
pub(super) const fn range(min: f64, max: f64, unit: &'static str) -> Range {
    Range { min, max, whole: false, unit }
}
