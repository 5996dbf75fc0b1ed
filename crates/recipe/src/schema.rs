//! The JSON Schema of recipes, from the same tables; editors complete and check recipes with it.

use base::Parameter;
use serde_json::{Map, Value, json};

use super::changes::SET_DOC;
use super::constraints::transport;
use super::correlation::{self, CORRELATIONS};
use super::distribution::{FORMS, range};
use super::extends::{EXTENDS, EXTENDS_DOC};
use super::groups::{BATCH, BATCH_DOC, MAX_BATCH, MAX_RIGS, RIGS, RIGS_DOC};
use super::keys::alternatives::alternatives;
use super::keys::settings::{Setting, Settings, TransportSettings};
use super::keys::{RecipeSection, SECTIONS, TRANSPORT, TRANSPORT_DOC, tidy};
use super::merge::SET;
use super::presets::{self, PRESET, PRESET_DOC};
use super::reader::MAX_SHARE;
use super::reference::natural;
use super::sampling::{SAMPLING, SAMPLING_DOC, Sampling};
use super::subject::Subject;
use super::variation::{UNSTATED, UNSTATED_DOC, Unstated};
use optical_bench::settings::{ThesisMethod, TransportName};

/// JSON Schema (draft 2020-12) of a recipe.
pub fn schema() -> Value {
    let name = |what: &str| json!({ "description": what, "type": "string", "pattern": "^[a-z0-9_-]{1,64}$" });
    let family = "Recipes of one family draw the same random numbers for the same seed, so that their samples can be \
        compared one by one; by default each name is a family of its own.";
    let mut properties = Map::new();
    let mut add = |key: &str, schema: Value| properties.insert(key.to_owned(), schema);
    let parent = json!({ "type": "string", "minLength": 1 });
    let parents = json!({ "type": "array", "minItems": 1, "items": parent });
    add(EXTENDS, json!({ "description": EXTENDS_DOC, "oneOf": [parent, parents] }));
    add("name", name("Name of the dataset, part of file names."));
    add("family", or_nothing(name(family)));
    add("subject", json!({ "description": "What the objects are.", "enum": Subject::NAMES }));
    for top in SECTIONS.iter().filter(|section| !section.path.contains('.')) {
        let schema = match top.path {
            TRANSPORT => transport_model(),
            path if top.settings.is_empty() => reference(path),
            _ => section(top),
        };
        add(top.path, schema);
    }
    let usual = Unstated::Drawn.name();
    add(UNSTATED, or_nothing(json!({ "description": UNSTATED_DOC, "default": usual, "enum": Unstated::NAMES })));
    for (key, what, most) in [(RIGS, RIGS_DOC, MAX_RIGS), (BATCH, BATCH_DOC, MAX_BATCH)] {
        let count = json!({ "description": what, "type": "integer", "minimum": 1, "maximum": most });
        add(key, or_nothing(count));
    }
    let usual = Sampling::Independent.name();
    add(SAMPLING, or_nothing(json!({ "description": SAMPLING_DOC, "default": usual, "enum": Sampling::NAMES })));
    add(CORRELATIONS, correlation::schema());
    add(
        "classes",
        json!({
            "description": "Kinds of samples by name: how often each comes and what it changes of the top level.",
            "type": "object", "minProperties": 1,
            "additionalProperties": { "oneOf": [{ "$ref": "#/$defs/class" }, { "type": "null" }] },
            "propertyNames": { "pattern": "^[a-z0-9_]{1,64}$" },
        }),
    );
    let keys = json!({ "pattern": "^[a-z0-9_.-]+$" });
    add(SET, json!({ "description": SET_DOC.trim(), "type": ["object", "null"], "propertyNames": keys }));
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Sheetlight recipe",
        "type": "object",
        "additionalProperties": false,
        "properties": properties,
        "allOf": Subject::ALL.map(only).into_iter().chain([needed()]).collect::<Vec<_>>(),
        "$defs": definitions(),
    })
}

/// What a recipe must have, unless it can inherit it.
fn needed() -> Value {
    json!({
        "if": { "not": { "required": [EXTENDS] } },
        "then": {
            "required": ["name", "subject"],
            "properties": { "classes": { "additionalProperties": { "required": ["share"] } } },
        },
    })
}

/// `schema`, or nothing: `null` removes what is inherited.
fn or_nothing(mut schema: Value) -> Value {
    if let Some(forms) = schema["oneOf"].as_array_mut() {
        forms.push(json!({ "type": "null" }));
    } else if let Some(words) = schema["enum"].as_array_mut() {
        words.push(Value::Null);
    } else {
        schema["type"] = json!([schema["type"], "null"]);
    }
    schema
}

/// What a recipe about `subject` must not have: sections of other subjects and models that do not know it.
fn only(subject: Subject) -> Value {
    let foreign = || SECTIONS.iter().filter(|section| !section.is_of(Some(subject)));
    let none: Map<_, _> = foreign().map(|section| (section.path.to_owned(), json!(false))).collect();
    let mut then = none.clone();
    then.insert("classes".into(), json!({ "additionalProperties": { "properties": none } }));
    let models = transport::models(subject);
    let long = json!({ "type": ["object", "null"], "properties": { "model": { "enum": models } } });
    then.insert(TRANSPORT.into(), json!({ "anyOf": [{ "enum": models }, long] }));
    json!({
        "if": { "properties": { "subject": { "const": subject.name() } }, "required": ["subject"] },
        "then": { "properties": then },
    })
}

/// A top-level section: its settings, its parameters and the sections below it.
fn section(top: &RecipeSection) -> Value {
    let mut properties = parameters(top);
    properties.extend(top.settings.iter().map(|row| (row.name.to_owned(), setting(row))));
    for inner in SECTIONS.iter() {
        if let Some(name) = inner.path.strip_prefix(top.path).and_then(|rest| rest.strip_prefix('.')) {
            properties.insert(name.to_owned(), section(inner));
        }
    }
    map(&tidy(top.doc), properties)
}

/// A map of known keys, which may be left empty.
fn map(description: &str, properties: Map<String, Value>) -> Value {
    json!({
        "description": description,
        "type": ["object", "null"],
        "additionalProperties": false,
        "properties": properties,
    })
}

/// The parameters of a section, and what stands for some.
fn parameters(section: &RecipeSection) -> Map<String, Value> {
    let own = section.parameters.iter().map(|row| (row.name.to_owned(), parameter(row)));
    let words = alternatives(section.path).map(|row| (row.name.to_owned(), row.schema()));
    let names = presets::names(section.path);
    let preset = (!names.is_empty()).then(|| {
        let name = json!({ "enum": names });
        let list = json!({ "type": "array", "items": name });
        (PRESET.to_owned(), json!({ "description": PRESET_DOC, "oneOf": [name, list] }))
    });
    own.chain(words).chain(preset).collect()
}

/// A number in range, or a distribution whose bounded arguments are.
fn parameter(row: &Parameter) -> Value {
    let limits = json!({ "minimum": row.min, "maximum": row.max });
    let number = if row.integer { "integer" } else { "number" };
    let natural = match natural(row) {
        none if none.is_empty() => none,
        varied => format!(" By nature {varied}."),
    };
    json!({
        "description":
            format!("{} Give {} or a distribution.{natural} Source: {}.", tidy(row.doc), range(row), row.source),
        "default": row.default,
        "oneOf": [
            { "type": number, "minimum": row.min, "maximum": row.max },
            { "$ref": "#/$defs/distribution" },
        ],
        "properties": {
            "uniform": { "items": limits },
            "log_uniform": { "items": limits },
            "choice": { "properties": { "values": { "items": limits } } },
            "truncated": { "properties": { "min": limits, "max": limits } },
        },
    })
}

/// A setting.
fn setting(row: &Setting) -> Value {
    let description = (row.describe)();
    let mut schema = or_nothing(description.schema);
    schema["description"] = format!("{} Give {}. Source: {}.", tidy(row.doc), description.allowed, row.source).into();
    schema["default"] = description.default;
    schema
}

/// The key `transport`: a name, or a map for each choice that decides which keys have an effect.
fn transport_model() -> Value {
    let (iterating, others): (Vec<_>, Vec<_>) = ThesisMethod::ALL.into_iter().partition(|method| method.iterates());
    let names = |methods: &[ThesisMethod]| methods.iter().map(|method| method.name()).collect::<Vec<_>>();
    let defaults = Settings::default().transport;
    let mut forms = vec![json!({ "enum": TransportName::NAMES })];
    for model in TransportName::ALL {
        let methods = if model == TransportName::Thesis { vec![&iterating, &others] } else { vec![&iterating] };
        for methods in methods {
            let mut chosen = Settings::default();
            (chosen.transport.model, chosen.transport.method) = (model, methods[0]);
            let used = TransportSettings::SETTINGS.iter().filter(|setting| setting.idle(&chosen).is_none());
            let mut keys: Map<_, _> = used.map(|row| (row.name.to_owned(), setting(row))).collect();
            narrow(&mut keys, "model", &json!({ "const": model.name() }));
            narrow(&mut keys, "method", &json!({ "enum": names(methods) }));
            // Keys whose default leads elsewhere.
            let needed = [("model", defaults.model != model), ("method", methods[0] != defaults.method)];
            let required: Vec<_> = needed.iter().filter(|(_, needed)| *needed).map(|(name, _)| name).collect();
            forms.push(json!({
                "type": if required.is_empty() { json!(["object", "null"]) } else { json!("object") },
                "required": required,
                "additionalProperties": false,
                "properties": keys,
            }));
        }
    }
    json!({ "description": TRANSPORT_DOC.replace('\n', " "), "default": defaults.model.name(), "oneOf": forms })
}

/// Puts fewer values in place of all that the setting `name` may have.
fn narrow(keys: &mut Map<String, Value>, name: &str, to: &Value) {
    if let Some(schema) = keys.get_mut(name) {
        let description = schema["description"].clone();
        *schema = to.clone();
        schema["description"] = description;
    }
}

/// Forms of distributions, groups of parameters and the class.
fn definitions() -> Map<String, Value> {
    let number = || json!({ "type": "number" });
    let not_negative = || json!({ "type": "number", "minimum": 0 });
    let positive = || json!({ "type": "number", "exclusiveMinimum": 0 });
    let pair = |end: Value| json!({ "type": "array", "items": end, "minItems": 2, "maxItems": 2 });
    let list = |entry: Value| json!({ "type": "array", "items": entry, "minItems": 1 });
    let mut definitions = Map::new();
    for form in FORMS {
        let arguments = match form.key {
            "uniform" => pair(number()),
            "log_uniform" => pair(positive()),
            "normal" => object(&[("mean", number()), ("sd", not_negative())], &["mean", "sd"]),
            "lognormal" => object(&[("median", positive()), ("log_sd", not_negative())], &["median", "log_sd"]),
            "choice" => object(&[("values", list(number())), ("weights", list(not_negative()))], &["values"]),
            "truncated" => object(&[("of", reference("untruncated")), ("min", number()), ("max", number())], &["of"]),
            other => unreachable!("{other} has no schema"),
        };
        let mut schema = object(&[(form.key, arguments)], &[form.key]);
        schema["description"] = format!("{}: {}.", form.example, form.law).into();
        definitions.insert(form.key.into(), schema);
    }
    let forms = FORMS.iter().map(|form| reference(form.key)).chain([json!({ "type": "null" })]);
    let plain = FORMS.iter().filter(|form| form.key != "truncated").map(|form| reference(form.key));
    let untruncated: Vec<_> = [number()].into_iter().chain(plain).collect();
    definitions.insert("distribution".into(), json!({ "oneOf": forms.collect::<Vec<_>>() }));
    definitions.insert("untruncated".into(), json!({ "oneOf": untruncated }));

    let share = json!({
        "description": "How often it comes, relative to the other classes.",
        "type": "number", "exclusiveMinimum": 0, "maximum": MAX_SHARE,
    });
    let mut class = Map::from_iter([("share".to_owned(), share)]);
    for section in SECTIONS.iter().filter(|section| !section.parameters.is_empty()) {
        definitions.insert(section.path.into(), map(&tidy(section.doc), parameters(section)));
        class.insert(section.path.into(), reference(section.path));
    }
    let class = json!({ "type": "object", "additionalProperties": false, "properties": class });
    definitions.insert("class".into(), class);
    definitions
}

/// What is defined as `name`.
fn reference(name: &str) -> Value {
    json!({ "$ref": format!("#/$defs/{name}") })
}

/// An object of known keys.
fn object(properties: &[(&str, Value)], required: &[&str]) -> Value {
    let properties: Map<_, _> = properties.iter().map(|(key, schema)| ((*key).to_owned(), schema.clone())).collect();
    json!({ "type": "object", "required": required, "additionalProperties": false, "properties": properties })
}
