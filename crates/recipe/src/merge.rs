//! Merging: a recipe's tree with another one's values in place of its own.
//!
//! Sections, classes and their sections are merged key by key ([`Level`] says what these are, by the tables of keys);
//! every other value is one and is replaced whole. `null` removes a key. A key in the words of data sheets removes what
//! it stands for, and the other way round.

use yaml::{YamlKey, YamlNode, YamlValue};

use super::keys::alternatives::alternatives;
use super::keys::{SECTIONS, TRANSPORT};

/// The section of a recipe that changes the others.
pub(super) const SET: &str = "set";

/// What a map is that stands in a recipe.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Level {
    /// All of it.
    Root,
    /// The classes by name.
    Classes,
    /// One class.
    Class,
    /// A section of that path.
    Section(&'static str),
    /// What was changed on the command line.
    Set,
    /// One value, which is no section.
    Value,
}

impl Level {
    /// What stands at `name` in it.
    pub fn inner(self, name: &str) -> Self {
        let section = |path: &str| {
            let known = SECTIONS.iter().find(|section| section.path == path && path != TRANSPORT);
            known.map_or(Self::Value, |section| Self::Section(section.path))
        };
        match self {
            Self::Root if name == "classes" => Self::Classes,
            Self::Root if name == SET => Self::Set,
            Self::Root | Self::Class => section(name),
            Self::Classes => Self::Class,
            Self::Section(path) => section(&format!("{path}.{name}")),
            Self::Set | Self::Value => Self::Value,
        }
    }
}

/// `parent` with the values of `own` in place of its own; both stand where `level` says.
pub(super) fn merged(parent: YamlNode, own: YamlNode, level: Level) -> YamlNode {
    let (YamlValue::Map(mut entries), YamlValue::Map(stated)) = (parent.value, &own.value) else { return own };
    if level == Level::Value {
        return own;
    }
    if let Level::Section(path) = level {
        leave_out_what_is_restated(path, &mut entries, stated);
    }
    let YamlNode { place, value } = own;
    let YamlValue::Map(stated) = value else { unreachable!("it is a map") };
    for (key, node) in stated {
        let Some(at) = entries.iter().position(|(known, _)| known.name == key.name) else {
            entries.push((key, node));
            continue;
        };
        if matches!(node.value, YamlValue::Nothing) {
            entries.remove(at);
            continue;
        }
        let (_, inherited) = entries.remove(at);
        let node = merged(inherited, node, level.inner(&key.name));
        entries.insert(at, (key, node));
    }
    YamlNode { place, value: YamlValue::Map(entries) }
}

/// Leaves out of the `entries` of a section what stands for keys that are `stated`, and what such keys stand for.
fn leave_out_what_is_restated(section: &str, entries: &mut Vec<(YamlKey, YamlNode)>, stated: &[(YamlKey, YamlNode)]) {
    let says =
        |name: &str| stated.iter().any(|(key, node)| key.name == name && !matches!(node.value, YamlValue::Nothing));
    for alternative in alternatives(section) {
        if says(alternative.name) {
            entries.retain(|(key, _)| !alternative.of.contains(&key.name.as_str()));
        } else if alternative.of.iter().all(|name| says(name)) {
            entries.retain(|(key, _)| key.name != alternative.name);
        }
    }
}
