//! The key `transport`: the name of a model, or a map of a model and the settings that have an effect on it.
//!
//! Its settings stand in one table as all others do. What is special is that each belongs to one model: beside another
//! one it is a fault, and the canonical form leaves it out.

use std::collections::BTreeMap;

use serde_json::{Map, json};

use super::Subject;
use super::schema::setting;
use super::setting::{Kind, Setting, Value};
use super::setting_read;
use super::settings::Settings;
use super::table;
use crate::settings::{ThesisMethod, Transport};
use crate::yaml::node::{self, Node};
use crate::yaml::walk::Walk;

/// Path of the section.
pub(super) const SECTION: &str = "transport";

/// What the section is about.
pub(super) const DOC: &str = "\
How light spreads below the surface: the name of a model (`transport: path`), or a map of a model and its keys
(`transport: {model: path, photons_per_profile: 100000}`). Each key has an effect on one model and is a fault beside
another. Datasets are made with `kernel`; the others are slow, for single profiles and comparisons.";

/// The settings; `model` and `method` stand before those that depend on them.
pub(super) const TABLE: &[Setting] = &[
    Setting {
        name: "model",
        kind: Kind::Word(&Transport::NAMES),
        default: Value::Word(Transport::NAMES[0]),
        doc: "Who says where light leaves: a table of Gaussians, Monte Carlo (the judge), diffusion on voxels or the \
              thesis' picture.",
        source: "docs/physics.md",
    },
    Setting {
        name: "photons_per_profile",
        kind: Kind::Count { min: 1000, max: 10_000_000_000, unit: "" },
        default: Value::Count(1_000_000),
        doc: "For `path`: photons that are walked in each profile.",
        source: "free; noise falls with their square root",
    },
    Setting {
        name: "voxel_mm",
        kind: Kind::Number { min: 0.05, max: 0.5, unit: "mm" },
        default: Value::Number(0.1),
        doc: "For `diffusion`: edge of a voxel; memory grows with its inverse cube.",
        source: "free; 0.1 is a row of the default camera",
    },
    Setting {
        name: "method",
        kind: Kind::Word(&ThesisMethod::NAMES),
        default: Value::Word(ThesisMethod::NAMES[0]),
        doc: "For `thesis`: how light is spread over pixels; `conservative` is what its diffusion should be.",
        source: "[T]; `conservative` is ours",
    },
    Setting {
        name: "iterations",
        kind: Kind::Count { min: 1, max: 1000, unit: "" },
        default: Value::Count(20),
        doc: "For `thesis` by `diffusion`: iterations; by `conservative`: steps from each path length to the next.",
        source: "[T] 20 on clear wood, 10 on a knot",
    },
    Setting {
        name: "pixel_mm",
        kind: Kind::Number { min: 0.02, max: 0.5, unit: "mm" },
        default: Value::Number(0.1),
        doc: "For `thesis`: side of a pixel.",
        source: "free; 0.1 is a row of the default camera",
    },
];

/// The model that a setting has an effect on; `None` where it has one on each.
fn user(name: &str) -> Option<&'static str> {
    match name {
        "photons_per_profile" => Some("path"),
        "voxel_mm" => Some("diffusion"),
        "method" | "iterations" | "pixel_mm" => Some("thesis"),
        _ => None,
    }
}

fn iterates(method: &str) -> bool {
    ThesisMethod::ALL.into_iter().any(|known| known.name() == method && known.iterates())
}

/// Why a setting has no effect, and what to do; `None` where it has one.
fn idle(name: &str, model: &str, method: &str) -> Option<(String, String)> {
    let user = user(name)?;
    if user != model {
        let remedy = format!("it is for model `{user}`: give `model: {user}`, or remove it");
        return Some((format!("has no effect on model `{model}`"), remedy));
    }
    (name == "iterations" && !iterates(method)).then(|| {
        let iterating: Vec<_> = ThesisMethod::NAMES.into_iter().filter(|name| iterates(name)).collect();
        let remedy = format!("it is for method `{}`: give one of them, or remove it", iterating.join("` or `"));
        (format!("has no effect on method `{method}`"), remedy)
    })
}

/// The model and the method of `settings`, defaults where they say nothing.
fn chosen(settings: &BTreeMap<String, Value>) -> [&'static str; 2] {
    let defaults = [("model", Transport::NAMES[0]), ("method", ThesisMethod::NAMES[0])];
    defaults.map(|(name, default)| match settings.get(&format!("{SECTION}.{name}")) {
        Some(Value::Word(word)) => word,
        _ => default,
    })
}

/// Reads `node`, the name of a model or a map, into `settings`.
pub(super) fn read(
    walk: &mut Walk,
    node: Option<&Node>,
    subject: Option<Subject>,
    settings: &mut BTreeMap<String, Value>,
) {
    let Some(node) = node else { return };
    match &node.value {
        node::Value::Text(_) => {
            let model = setting_read::read(walk, node, SECTION, &TABLE[0]);
            settings.extend(model.map(|model| (format!("{SECTION}.{}", TABLE[0].name), model)));
        }
        node::Value::Map(_) | node::Value::Nothing => long(walk, node, subject, settings),
        other => {
            let remedy = format!("give one of {}, or a map of `model` and its keys", Transport::NAMES.join(", "));
            walk.fault(node.place, SECTION, format!("is {}", other.kind()), remedy);
        }
    }
}

fn long(walk: &mut Walk, node: &Node, subject: Option<Subject>, settings: &mut BTreeMap<String, Value>) {
    let mut map = walk.section(node, SECTION);
    // Whom a key would have an effect on is open while model or method is a fault itself.
    let mut known = true;
    for setting in TABLE {
        let Some(node) = map.take(walk, setting.name) else { continue };
        let path = map.path_of(setting.name);
        let [model, method] = chosen(settings);
        if let Some((problem, remedy)) = idle(setting.name, model, method).filter(|_| known) {
            walk.joint_fault(&[path], problem, remedy);
            continue;
        }
        match setting_read::read(walk, node, &path, setting) {
            Some(value) => _ = settings.insert(path, value),
            None => known &= !matches!(setting.kind, Kind::Word(_)),
        }
    }
    let names: Vec<_> = TABLE.iter().map(|setting| setting.name).collect();
    map.close(walk, &names, &|name| table::home(subject, name));
}

/// Whether a model can spread light in such objects: those that need one medium without air know no pack, and all but the
/// kernel ask for a height field, which a mesh need not be.
fn knows(model: &str, subject: Subject) -> bool {
    match subject {
        Subject::Wood | Subject::Sawtooth => true,
        Subject::Blister => matches!(model, "kernel" | "path"),
        Subject::Mesh => model == "kernel",
    }
}

/// The model that is chosen can spread light in the recipe's objects.
pub(super) fn check(walk: &mut Walk, subject: Option<Subject>, settings: &Settings) {
    let [model, _] = chosen(&settings.0);
    if let Some(subject) = subject.filter(|subject| !knows(model, *subject)) {
        let keys = [format!("{SECTION}.{}", TABLE[0].name), SECTION.to_owned()];
        let (lack, remedy) = match subject {
            Subject::Mesh => ("no part that overhangs", "give `kernel`"),
            _ => ("no film over air", "give `kernel`, or `path` for single profiles"),
        };
        walk.joint_fault(&keys, format!("`{model}` knows {lack}, and the subject is `{}`", subject.name()), remedy);
    }
}

/// The names of the models that can spread light in objects of `subject`.
pub(super) fn models(subject: Subject) -> Vec<&'static str> {
    Transport::NAMES.into_iter().filter(|model| knows(model, subject)).collect()
}

/// Leaves out of `settings` what has no effect.
pub(super) fn leave_out(settings: &mut BTreeMap<String, Value>) {
    let [model, method] = chosen(settings);
    for setting in TABLE.iter().filter(|setting| idle(setting.name, model, method).is_some()) {
        settings.remove(&format!("{SECTION}.{}", setting.name));
    }
}

/// JSON Schema of the key: a name, or a map for each choice that decides which keys have an effect.
pub(super) fn schema() -> serde_json::Value {
    let (iterating, others): (Vec<_>, Vec<_>) = ThesisMethod::NAMES.into_iter().partition(|name| iterates(name));
    let mut forms = vec![json!({ "enum": Transport::NAMES })];
    for model in Transport::NAMES {
        let methods = if model == "thesis" { vec![&iterating, &others] } else { vec![&iterating] };
        for methods in methods {
            let used = TABLE.iter().filter(|setting| idle(setting.name, model, methods[0]).is_none());
            let mut keys: Map<_, _> = used.map(|row| (row.name.to_owned(), setting(row))).collect();
            narrow(&mut keys, "model", &json!({ "const": model }));
            narrow(&mut keys, "method", &json!({ "enum": methods }));
            // Keys whose default leads elsewhere.
            let needed = [("model", Transport::NAMES[0] != model), ("method", methods[0] != ThesisMethod::NAMES[0])];
            let required: Vec<_> = needed.iter().filter(|(_, needed)| *needed).map(|(name, _)| name).collect();
            forms.push(json!({
                "type": if required.is_empty() { json!(["object", "null"]) } else { json!("object") },
                "required": required,
                "additionalProperties": false,
                "properties": keys,
            }));
        }
    }
    json!({ "description": DOC.replace('\n', " "), "default": Transport::NAMES[0], "oneOf": forms })
}

/// Puts fewer values in place of all that the setting `name` may have.
fn narrow(keys: &mut Map<String, serde_json::Value>, name: &str, to: &serde_json::Value) {
    if let Some(schema) = keys.get_mut(name) {
        let description = schema["description"].clone();
        *schema = to.clone();
        schema["description"] = description;
    }
}
