//! The canonical form of a recipe: everything it means, defaults included, and nothing of how it was written.
//!
//! It is a recipe itself (JSON is YAML): sorted keys, classes by name, class keys only where they change the top level.
//! Ways of drawing that a recipe does not use (rigs, batches, correlations, low discrepancy) are left out, so that they
//! leave the hash of other recipes as it is. So is `unstated`: here every number is stated.

use serde_json::{Map, Value, json};
use sha2::{Digest, Sha256};

use super::asset::hex;
use super::correlation::{CORRELATIONS, Correlation};
use super::distribution::{Distribution, form_keys};
use super::groups::{BATCH, RIGS};
use super::sampling::{SAMPLING, Sampling};
use super::{Recipe, Subject, keys};

/// The canonical form of `recipe`.
pub(super) fn json(recipe: &Recipe) -> Value {
    let mut root = Map::new();
    let effective = keys::settings(Some(recipe.subject)).filter(|setting| setting.idle(&recipe.settings).is_none());
    for setting in effective {
        if let Some(value) = (setting.canonical)(&recipe.settings) {
            insert(&mut root, setting.path, value);
        }
    }
    for (path, distribution) in &recipe.parameters {
        insert(&mut root, path, distribution_json(distribution));
    }
    insert(&mut root, "name", json!(recipe.name));
    insert(&mut root, "family", json!(recipe.family));
    insert(&mut root, "subject", json!(recipe.subject.name()));
    if let Some(rigs) = recipe.groups.rigs {
        insert(&mut root, RIGS, json!(rigs));
    }
    if recipe.subject != Subject::Wood && recipe.groups.lot > 1 {
        insert(&mut root, BATCH, json!(recipe.groups.lot));
    }
    if recipe.sampling != Sampling::Independent {
        insert(&mut root, SAMPLING, json!(recipe.sampling.name()));
    }
    if !recipe.correlations.is_empty() {
        let pairs: Vec<_> = recipe.correlations.iter().map(Correlation::json).collect();
        insert(&mut root, CORRELATIONS, pairs.into());
    }
    for class in &recipe.classes {
        let prefix = format!("classes.{}", class.name);
        insert(&mut root, &format!("{prefix}.share"), json!(class.share));
        for (path, distribution) in &class.overrides {
            insert(&mut root, &format!("{prefix}.{path}"), distribution_json(distribution));
        }
    }
    let mut root = Value::Object(root);
    root.sort_all_objects();
    root
}

/// SHA-256 of the canonical form, in hexadecimal.
pub(super) fn hash(canonical: &Value) -> String {
    hex(&Sha256::digest(canonical.to_string()))
}

/// Keys in which two canonical forms differ, each with both values: `camera.tilt_deg: 25.0 -> 30.0`.
pub fn differences(a_json: &str, b_json: &str) -> Vec<String> {
    let mut changes = Vec::new();
    match (serde_json::from_str(a_json), serde_json::from_str(b_json)) {
        (Ok(a), Ok(b)) => compare("", Some(&a), Some(&b), &mut changes),
        (Err(error), _) => changes.push(format!("the first recipe is no JSON: {error}")),
        (_, Err(error)) => changes.push(format!("the second recipe is no JSON: {error}")),
    }
    changes
}

fn compare(path: &str, a: Option<&Value>, b: Option<&Value>, changes: &mut Vec<String>) {
    if a == b {
        return;
    }
    let (inner_a, inner_b) = (a.and_then(keys), b.and_then(keys));
    if (inner_a.is_some() || a.is_none()) && (inner_b.is_some() || b.is_none()) {
        let mut names: Vec<_> = inner_a.into_iter().chain(inner_b).flat_map(Map::keys).collect();
        names.sort();
        names.dedup();
        for name in names {
            let inner = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
            compare(&inner, inner_a.and_then(|map| map.get(name)), inner_b.and_then(|map| map.get(name)), changes);
        }
    } else {
        let shown = |value: Option<&Value>| value.map_or_else(|| "nothing".to_owned(), Value::to_string);
        changes.push(format!("{path}: {} -> {}", shown(a), shown(b)));
    }
}

/// The keys of a section; a distribution is a value.
fn keys(value: &Value) -> Option<&Map<String, Value>> {
    value.as_object().filter(|map| !map.keys().any(|key| form_keys().contains(&key.as_str()) || key == "every"))
}

/// Puts `value` at `path` below `map`.
fn insert(map: &mut Map<String, Value>, path: &str, value: Value) {
    match path.split_once('.') {
        None => {
            map.insert(path.to_owned(), value);
        }
        Some((first, rest)) => {
            let inner = map.entry(first).or_insert_with(|| Value::Object(Map::new()));
            if let Value::Object(inner) = inner {
                insert(inner, rest, value);
            }
        }
    }
}

/// The distribution as a recipe writes it.
pub(super) fn distribution_json(distribution: &Distribution) -> Value {
    match distribution {
        Distribution::Fixed(value) => json!(value),
        Distribution::Uniform { min, max } => json!({ "uniform": [min, max] }),
        Distribution::LogUniform { min, max } => json!({ "log_uniform": [min, max] }),
        Distribution::Normal { mean, sd } => json!({ "normal": { "mean": mean, "sd": sd } }),
        Distribution::Lognormal { median, log_sd } => json!({ "lognormal": { "median": median, "log_sd": log_sd } }),
        Distribution::Choice { values, weights } => json!({ "choice": { "values": values, "weights": weights } }),
        Distribution::Truncated { of, min, max } => {
            json!({ "truncated": { "of": distribution_json(of), "min": min, "max": max } })
        }
    }
}
