//! Differences between documents, and which of them keep a dataset from being continued.

use output_schema::DatasetHead;
use serde_json::Value;

/// What differs between two documents, by key: `key.path: old -> new`.
///
/// ```
/// let (old, new) = (serde_json::json!({"laser": {"power_mw": 50}}), serde_json::json!({"laser": {"power_mw": 60}}));
/// assert_eq!(dataset::differences("recipe", &old, &new), ["recipe.laser.power_mw: 50 -> 60"]);
/// ```
pub fn differences(path: &str, old: &Value, new: &Value) -> Vec<String> {
    let below = |key: &str| if path.is_empty() { key.to_string() } else { format!("{path}.{key}") };
    match (old, new) {
        (Value::Object(a), Value::Object(b)) => {
            let added = b.keys().filter(|key| !a.contains_key(*key));
            let pairs = a.keys().chain(added).map(|key| (below(key), a.get(key), b.get(key)));
            pairs
                .flat_map(|(path, a, b)| match (a, b) {
                    (Some(a), Some(b)) => differences(&path, a, b),
                    (Some(a), None) => vec![format!("{path}: {} -> nothing", short(a))],
                    (None, Some(b)) => vec![format!("{path}: nothing -> {}", short(b))],
                    (None, None) => Vec::new(),
                })
                .collect()
        }
        (Value::Array(a), Value::Array(b)) if a.len() == b.len() => {
            let pairs = a.iter().zip(b).enumerate();
            pairs.flat_map(|(i, (a, b))| differences(&format!("{path}[{i}]"), a, b)).collect()
        }
        _ if old == new => Vec::new(),
        _ => vec![format!("{path}: {} -> {}", short(old), short(new))],
    }
}

/// Differences in one line, no more than `most` of them.
pub(super) fn shortened(all: &[String], most: usize) -> String {
    let named = all[..all.len().min(most)].join("; ");
    match all.len().saturating_sub(most) {
        0 => named,
        more => format!("{named}; and {more} more"),
    }
}

fn short(value: &Value) -> String {
    let text = value.to_string();
    match text.char_indices().nth(60) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text,
    }
}

/// Every reason why samples of `new` cannot go into a dataset of `old`; the number of samples may differ, and so may
/// the recipe's text where its meaning is the same.
pub(super) fn reasons_to_refuse(old: &DatasetHead, new: &DatasetHead) -> Vec<String> {
    let mut reasons = Vec::new();
    if old.recipe.hash != new.recipe.hash {
        let mut keys = differences("recipe", &old.recipe.canonical, &new.recipe.canonical);
        if keys.is_empty() {
            keys.push(format!("recipe hash: {} -> {}", old.recipe.hash, new.recipe.hash));
        }
        reasons.extend(keys);
    }
    let rest = |head: &DatasetHead| {
        // A head is plain data: it always becomes JSON.
        let mut rest = serde_json::to_value(head).unwrap_or_default();
        if let Some(rest) = rest.as_object_mut() {
            ["recipe", "samples", "shards"].iter().for_each(|key| _ = rest.remove(*key));
        }
        rest
    };
    let recipe_differs = !reasons.is_empty();
    let follow = ["classes", "pixel_classes", "splits", "images", "parameters", "physics", "warnings"];
    let rest = differences("", &rest(old), &rest(new));
    // What follows from the recipe is told by the recipe's keys.
    reasons.extend(
        rest.into_iter().filter(|reason| !(recipe_differs && follow.iter().any(|key| reason.starts_with(key)))),
    );
    reasons
}
