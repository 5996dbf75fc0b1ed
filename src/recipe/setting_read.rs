//! From a node to a setting.

use super::setting::{Kind, Setting, Value};
use crate::settings::Channel;
use crate::yaml::fault::nearest;
use crate::yaml::node::{self, Node};
use crate::yaml::walk::{Range, Walk};

/// Reads the setting at `node`; faults are noted and give `None`.
pub(super) fn read(walk: &mut Walk, node: &Node, path: &str, setting: &Setting) -> Option<Value> {
    let text = match &node.value {
        node::Value::Text(text) => Some(text.as_str()),
        _ => None,
    };
    match setting.kind {
        Kind::Count { min, max, unit } => count(walk, node, path, (min, max), unit).map(Value::Count),
        Kind::OneOf(counts) => one_of(walk, node, path, counts),
        Kind::Number { min, max, unit } => {
            walk.number_in(node, path, Range { min, max, whole: false, unit }).map(Value::Number)
        }
        Kind::Flag => flag(walk, node, path),
        Kind::Word(words) => walk.word(node, path, words).map(Value::Word),
        Kind::Channels => channels(walk, node, path),
        Kind::Stack { .. } if text == Some("none") => Some(Value::Word("none")),
        Kind::Stack { .. } if text == Some("all") => Some(Value::Word("all")),
        Kind::Stack { max } => stack(walk, node, path, max),
        Kind::CountOrAuto { .. } | Kind::NumberOrAuto { .. } if text == Some("auto") => Some(Value::Word("auto")),
        Kind::CountOrAuto { .. } if text.is_some() => {
            walk.word(node, path, &["auto", "a whole number"]).map(Value::Word)
        }
        Kind::NumberOrAuto { .. } if text.is_some() => walk.word(node, path, &["auto", "a number"]).map(Value::Word),
        Kind::CountOrAuto { min, max } => count(walk, node, path, (min, max), "").map(Value::Count),
        Kind::File { .. } if text == Some("none") && setting.default == Value::Word("none") => {
            Some(Value::Word("none"))
        }
        Kind::File { .. } => file(walk, node, path, &setting.kind.to_string()),
        Kind::NumberOrAuto { min, max, unit } => {
            walk.number_in(node, path, Range { min, max, whole: false, unit }).map(Value::Number)
        }
    }
}

/// The name of a file, or a map of its name and the SHA-256 that it must have; it is read when all keys are.
fn file(walk: &mut Walk, node: &Node, path: &str, allowed: &str) -> Option<Value> {
    let named = |walk: &mut Walk, node: &Node, path: &str| {
        let name = walk.text(node, path, allowed)?;
        if name.is_empty() {
            walk.fault(node.place, path, "is empty", format!("give {allowed}"));
        }
        (!name.is_empty()).then(|| name.to_owned())
    };
    if !matches!(node.value, node::Value::Map(_)) {
        return named(walk, node, path).map(|name| Value::Named { name, sha256: None });
    }
    let mut map = walk.section(node, path);
    let (name, sha256) = (map.take(walk, "name"), map.take(walk, "sha256"));
    let (name_path, sum_path) = (map.path_of("name"), map.path_of("sha256"));
    map.close(walk, &["name", "sha256"], &|_| None);
    let Some(name) = name else {
        walk.fault(node.place, &name_path, "is missing", format!("give {allowed}"));
        return None;
    };
    let name = named(walk, name, &name_path)?;
    let sha256 = match sha256 {
        Some(node) => Some(sum(walk, node, &sum_path)?),
        None => None,
    };
    Some(Value::Named { name, sha256 })
}

/// A SHA-256 in hexadecimal.
fn sum(walk: &mut Walk, node: &Node, path: &str) -> Option<String> {
    let allowed = "64 digits of 0-9 and a-f, as `sha256sum` prints them";
    let text = walk.text(node, path, allowed)?;
    let digits = text.len() == 64 && text.bytes().all(|c| matches!(c, b'0'..=b'9' | b'a'..=b'f'));
    if !digits {
        walk.fault(node.place, path, "is no SHA-256", format!("give {allowed}"));
    }
    digits.then(|| text.to_owned())
}

fn count(walk: &mut Walk, node: &Node, path: &str, (min, max): (usize, usize), unit: &'static str) -> Option<usize> {
    let range = Range { min: min as f64, max: max as f64, whole: true, unit };
    // The range ends far below 2^53, so the number is exact.
    walk.number_in(node, path, range).map(|number| number as usize)
}

fn one_of(walk: &mut Walk, node: &Node, path: &str, counts: &'static [usize]) -> Option<Value> {
    let allowed = format!("one of {}", counts.iter().map(usize::to_string).collect::<Vec<_>>().join(", "));
    let number = walk.number(node, path, &allowed)?;
    let found = counts.iter().copied().find(|count| *count as f64 == number);
    if found.is_none() {
        walk.fault(node.place, path, format!("{number} is not allowed"), format!("give {allowed}"));
    }
    found.map(Value::Count)
}

fn flag(walk: &mut Walk, node: &Node, path: &str) -> Option<Value> {
    if let node::Value::Flag(flag) = node.value {
        return Some(Value::Flag(flag));
    }
    walk.fault(node.place, path, format!("is {}", node.value.kind()), "give true or false");
    None
}

fn channels(walk: &mut Walk, node: &Node, path: &str) -> Option<Value> {
    let names = Channel::ALL.map(Channel::name);
    let node::Value::List(entries) = &node.value else {
        let remedy = format!("give a list of {}", names.join(", "));
        walk.fault(node.place, path, format!("is {}", node.value.kind()), remedy);
        return None;
    };
    let mut chosen = [false; Channel::ALL.len()];
    for entry in entries {
        let name = walk.word(entry, path, &names)?;
        for (chosen, _) in chosen.iter_mut().zip(names).filter(|(_, known)| *known == name) {
            if *chosen {
                walk.fault(entry.place, path, format!("lists `{name}` twice"), "remove one of them");
            }
            *chosen = true;
        }
    }
    Some(Value::Channels(chosen))
}

fn stack(walk: &mut Walk, node: &Node, path: &str, max: usize) -> Option<Value> {
    let remedy = "give none, all or {every: k}";
    if !matches!(node.value, node::Value::Map(_)) {
        let meant = match &node.value {
            node::Value::Text(text) => nearest(text, ["none", "all", "every"]),
            _ => None,
        };
        let meant = meant.map(|word| format!("did you mean `{word}`? ")).unwrap_or_default();
        walk.fault(node.place, path, format!("is {}", node.value.kind()), format!("{meant}{remedy}"));
        return None;
    }
    let mut map = walk.section(node, path);
    let every = map.take(walk, "every");
    let path = map.path_of("every");
    if every.is_none() && map.is_empty() {
        walk.fault(node.place, &path, "is missing", remedy);
    }
    map.close(walk, &["every"], &|_| None);
    let every = every?;
    count(walk, every, &path, (1, max), "").map(Value::Every)
}
