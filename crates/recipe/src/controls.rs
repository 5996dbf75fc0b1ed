//! The keys of a recipe as a program shows them to people who change them: what may be written, what is written, and
//! what has no effect beside the other keys. From the tables that recipes are read with.

use base::{Natural, Parameter};
use serde_json::{Map, Value, json};

use super::canonical::distribution_json;
use super::constraints::{self, RecipeObject};
use super::distribution::Distribution;
use super::keys::settings::Setting;
use super::keys::{self, RecipeSection, sections, tidy, unit};
use super::{Recipe, Subject};

/// Every key of recipes about `subject` by section, in the order of the light: what it means, where its default comes
/// from, and what it may be.
pub fn declarations(subject: Subject) -> Value {
    let section = |section: &RecipeSection| {
        let parameters = section.parameters.iter().map(parameter);
        let keys: Vec<Value> = section.settings.iter().map(setting).chain(parameters).collect();
        json!({ "path": section.path, "doc": tidy(section.doc), "keys": keys })
    };
    sections(Some(subject)).map(section).collect()
}

fn parameter(parameter: &Parameter) -> Value {
    let natural = match parameter.natural {
        Natural::Fixed => Value::Null,
        _ => json!({
            "ends": parameter.natural.ends(),
            "value": distribution_json(&Distribution::natural(parameter)),
        }),
    };
    json!({
        "path": parameter.path(), "name": parameter.name, "kind": "parameter", "unit": unit(parameter.name),
        "min": parameter.min, "max": parameter.max, "default": parameter.default, "integer": parameter.integer,
        "natural": natural, "doc": tidy(parameter.doc), "source": parameter.source,
    })
}

fn setting(setting: &Setting) -> Value {
    let description = (setting.describe)();
    json!({
        "path": setting.path, "name": setting.name, "kind": "setting", "unit": unit(setting.name),
        "schema": description.schema, "allowed": description.allowed, "default": description.default,
        "doc": tidy(setting.doc), "source": setting.source,
    })
}

impl Recipe {
    /// What each key is, by path, in samples of `class`, or where no class has another value: its `value`, and where it
    /// has no effect the `reason`.
    pub fn key_states(&self, class: Option<&str>) -> Map<String, Value> {
        let object = RecipeObject {
            subject: Some(self.subject),
            settings: &self.settings,
            contents: &self.contents,
            parameters: &self.parameters,
            classes: &self.classes,
        };
        let own = |path: &str| match class {
            Some(class) => self.distribution(class, path),
            None => self.parameters.get(path),
        };
        let mut states = Map::new();
        for parameter in keys::parameters(Some(self.subject)) {
            let path = parameter.path();
            let value = own(&path).map(distribution_json);
            states.insert(path, json!({ "value": value }));
        }
        for setting in keys::settings(Some(self.subject)) {
            let value = (setting.canonical)(&self.settings);
            let reason = setting.without_effect(&self.settings);
            states.insert(setting.path.to_owned(), json!({ "value": value, "reason": reason }));
        }
        for (path, reason) in constraints::reasons(object, class) {
            states[&path]["reason"] = reason.into();
        }
        states
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each declared key has a state, and no other one.
    #[test]
    fn every_key_has_a_state() {
        for subject in Subject::ALL {
            let recipe = Recipe::parse("test", &format!("name: a\nsubject: {}\n", subject.name()));
            let recipe = recipe.unwrap_or_else(|faults| panic!("{faults}"));
            let states = recipe.key_states(None);
            let declared = declarations(subject);
            let of = |section: &Value| section["keys"].as_array().cloned().unwrap_or_default();
            let keys: Vec<Value> = declared.as_array().into_iter().flatten().flat_map(of).collect();
            assert_eq!(keys.len(), states.len());
            for key in keys {
                let path = key["path"].as_str().expect("a key has a path");
                assert!(states.contains_key(path), "{path}");
                assert!(!key["doc"].as_str().expect("a key has words").is_empty(), "{path}");
            }
        }
    }

    /// What does nothing beside the other keys says so, until these change.
    #[test]
    fn a_key_without_effect_has_a_reason() {
        let state = |text: &str, class: Option<&str>, path: &str| {
            let text = format!("name: a\nsubject: wood\n{text}");
            let recipe = Recipe::parse("test", &text).unwrap_or_else(|faults| panic!("{faults}"));
            recipe.key_states(class)[path].clone()
        };
        let reason = state("", None, "camera.filter_centre_nm")["reason"].clone();
        assert_eq!(reason, "has no effect while `camera.filter` is `none`");
        let open = state("camera: {filter: band_pass}\n", None, "camera.filter_centre_nm");
        assert_eq!(open["reason"], Value::Null);
        let gamma = state("", None, "picture.gamma")["reason"].clone();
        assert!(gamma.as_str().is_some_and(|reason| reason.contains("no effect")), "{gamma}");
        let classes =
            "classes: {clear: {share: 1, knots: {sound_count: 0}}, knot: {share: 1, laser: {power_mw: 70}}}\n";
        assert_eq!(state(classes, Some("knot"), "laser.power_mw")["value"], 70.0);
        assert_ne!(state(classes, Some("clear"), "laser.power_mw")["value"], 70.0);
    }
}
