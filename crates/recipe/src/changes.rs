//! Changes to a recipe from outside its text: `--set camera.tilt_deg=30`.
//!
//! The text with its changes is a text again, with one more section: `set` maps key paths to values, which replace
//! those of the text. So a dataset records both, and is made again from that text alone.

use super::flat_text::{flow, quoted};
use super::merge::SET;
use yaml::{TextPosition, YamlError, YamlKey, YamlNode, YamlReader, YamlValue, parse_yaml};

/// What the section is about.
pub(super) const SET_DOC: &str = "\
What was changed on the command line (`--set KEY=VALUE`): key paths with the values that replace those above.";

/// A key and the value that replaces its own.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Change {
    key: String,
    value: String,
}

impl std::str::FromStr for Change {
    type Err = String;

    /// `KEY=VALUE`, the value in YAML.
    fn from_str(text: &str) -> Result<Self, String> {
        let example = "for instance camera.tilt_deg=30 or 'camera.tilt_deg={uniform: [20, 30]}'";
        let (key, value) = text.split_once('=').ok_or_else(|| format!("give KEY=VALUE, {example}"))?;
        if key.is_empty() || !key.bytes().all(|c| c.is_ascii_alphanumeric() || b"_.-".contains(&c)) {
            return Err(format!("`{key}` is no key; give the path of one, {example}"));
        }
        let parsed =
            parse_yaml(value, "value").map_err(|YamlError { problem, remedy, .. }| format!("{problem}; {remedy}"))?;
        Ok(Self { key: key.to_owned(), value: flow(&parsed) })
    }
}

impl Change {
    /// Path of the key.
    pub fn key(&self) -> &str {
        &self.key
    }

    /// The value as YAML in one line.
    pub fn value(&self) -> &str {
        &self.value
    }
}

/// A recipe's text with changes, in a section `set` where it has none that names them.
pub fn changed_text(text: &str, changes: &[Change]) -> String {
    changed(text, changes).text
}

/// A text with changes, and the first line that is not its own.
pub(super) struct ChangedText {
    pub text: String,
    pub changed_from: usize,
}

/// `text` with `changes`; where a key is changed twice, the last counts.
pub(super) fn changed(text: &str, changes: &[Change]) -> ChangedText {
    let unchanged = ChangedText { text: text.to_owned(), changed_from: usize::MAX };
    if changes.is_empty() {
        return unchanged;
    }
    // What is no map has faults of its own.
    let Some((root, entries)) = parse_yaml(text, "recipe").ok().and_then(|root| match &root.value {
        YamlValue::Map(entries) => Some((root.place, entries.clone())),
        _ => None,
    }) else {
        return unchanged;
    };
    let mut set: Vec<(String, String)> = Vec::new();
    let before = entries.iter().find(|(key, _)| key.name == SET);
    if let Some(YamlValue::Map(before)) = before.map(|(_, node)| &node.value) {
        set.extend(before.iter().map(|(key, node)| (key.name.clone(), flow(node))));
    }
    for Change { key, value } in changes {
        set.retain(|(known, _)| known != key);
        set.push((key.clone(), value.clone()));
    }
    let is_flow = text.lines().nth(root.line - 1).and_then(|line| line.chars().nth(root.column - 1)) == Some('{');
    let ends = text.lines().any(|line| line == "...");
    if before.is_none() && !is_flow && !ends {
        let indent = " ".repeat(root.column - 1);
        let body = text.trim_end();
        let mut text = format!("{body}\n\n{indent}{SET}:\n");
        let changed_from = text.lines().count();
        set.iter().for_each(|(key, value)| text.push_str(&format!("{indent}  {key}: {value}\n")));
        return ChangedText { text, changed_from };
    }
    // Comments would end up in wrong places: the same values in one form, a key a line.
    let others = entries.iter().filter(|(key, _)| key.name != SET);
    let mut lines: Vec<String> = others.map(|(key, node)| format!("{}: {}", quoted(&key.name), flow(node))).collect();
    let changed_from = lines.len() + 1;
    lines.push(format!("{SET}:"));
    lines.extend(set.iter().map(|(key, value)| format!("  {key}: {value}")));
    ChangedText { text: lines.join("\n") + "\n", changed_from }
}

/// The tree with the values of its section `set` in place of the others.
pub(super) fn applied(yaml: &mut YamlReader, root: &YamlNode) -> YamlNode {
    let mut root = root.clone();
    let YamlValue::Map(entries) = &mut root.value else { return root };
    let Some(at) = entries.iter().position(|(key, _)| key.name == SET) else { return root };
    let (_, set) = entries.remove(at);
    match set.value {
        YamlValue::Nothing => {}
        YamlValue::Map(changes) => {
            for (key, value) in changes {
                let path: Vec<&str> = key.name.split('.').collect();
                replace(yaml, &mut root, (&path, key.place, &key.name), value);
            }
        }
        other => {
            let remedy = "give key paths with values, for instance `camera.tilt_deg: 30`";
            yaml.fault(set.place, SET, format!("is {}", other.kind()), remedy);
        }
    }
    root
}

/// Puts `value` at a path below `node`; maps that are not there are made.
fn replace(yaml: &mut YamlReader, node: &mut YamlNode, path: (&[&str], TextPosition, &str), value: YamlNode) {
    let (names, place, whole) = path;
    let Some((name, inner)) = names.split_first() else {
        *node = value;
        return;
    };
    if matches!(node.value, YamlValue::Nothing) {
        *node = YamlNode { place, value: YamlValue::Map(Vec::new()) };
    }
    let YamlValue::Map(entries) = &mut node.value else {
        let known = whole.len() - names.join(".").len();
        let above = whole[..known].trim_end_matches('.');
        let problem = format!("`{above}` is {}, which has no keys", node.value.kind());
        yaml.fault(place, whole, problem, format!("set `{above}` as a whole"));
        return;
    };
    let at = entries.iter().position(|(key, _)| key.name == *name).unwrap_or_else(|| {
        let nothing = YamlNode { place, value: YamlValue::Nothing };
        entries.push((YamlKey { place, name: (*name).to_owned() }, nothing));
        entries.len() - 1
    });
    if inner.is_empty() {
        entries[at].0.place = place;
    }
    replace(yaml, &mut entries[at].1, (inner, place, whole), value);
}
