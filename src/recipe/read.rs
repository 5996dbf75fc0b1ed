//! From text to recipe: parse, walk the tables, check what keys mean together.

use std::collections::BTreeMap;
use std::sync::Arc;

use procedural::Mesh;

use super::camera;
use super::check::{self, Object};
use super::dist::Distribution;
use super::dist_read;
use super::laser;
use super::setting::{Kind, Setting, Value};
use super::setting_extraction;
use super::setting_read;
use super::settings::Settings;
use super::table::{self, SECTIONS, sections};
use super::{Class, Subject};
use super::{postprocess, transport};
use crate::asset::{Files, Wanted};
use crate::mesh;
use crate::yaml::fault::Faults;
use crate::yaml::node::{self, Node};
use crate::yaml::walk::{Range, Section, Walk, clipped, shown};

/// Largest share of a class; shares are relative, so this is no limit in practice.
pub(super) const LARGEST_SHARE: f64 = 1e6;
/// Smallest share of the samples; a rarer class would be missing from most datasets.
const SMALLEST_SHARE: f64 = 1e-6;
/// Most classes, of which files keep the number in a byte.
const MOST_CLASSES: usize = 255;
/// Key of the file of a part.
const MESH_FILE: &str = "mesh.file";
/// Longest name of a recipe or class [bytes].
const LONGEST_NAME: usize = 64;

/// What a text says, with every default filled in.
pub(super) struct Resolved {
    pub name: String,
    pub subject: Subject,
    pub settings: Settings,
    pub parameters: BTreeMap<String, Distribution>,
    pub classes: Vec<Class>,
    pub mesh: Option<Arc<Mesh>>,
}

/// Reads `text` and the files that it names; every fault that is found comes back.
pub(super) fn read(origin: &str, text: &str, files: &Files) -> Result<Resolved, Faults> {
    let mut walk = Walk::new(text, "recipe");
    let resolved = match node::parse(text, "recipe") {
        Ok(root) => recipe(&mut walk, &root, files),
        Err(error) => {
            walk.fault(error.place, "", error.problem, error.remedy);
            None
        }
    };
    walk.finish(origin)?;
    Ok(resolved.expect("whatever gives no recipe notes a fault"))
}

fn recipe(walk: &mut Walk, root: &Node, files: &Files) -> Option<Resolved> {
    if !matches!(root.value, node::Value::Map(_)) {
        let problem = match &root.value {
            node::Value::Nothing => "the file is empty".to_owned(),
            other => format!("the file is {}", other.kind()),
        };
        walk.fault(root.place, "", problem, "a recipe is a map with at least `name`, `subject` and `classes`");
        return None;
    }
    let mut top = walk.section(root, "");
    let name = required(walk, &mut top, root, "name").and_then(|node| name(walk, node, "name"));
    let subject = required(walk, &mut top, root, "subject").and_then(|node| {
        let word = walk.word(node, "subject", &Subject::NAMES)?;
        Subject::ALL.into_iter().find(|subject| subject.name() == word)
    });
    let mut settings = BTreeMap::new();
    let mut parameters = BTreeMap::new();
    for section in sections(subject).filter(|section| !section.path.contains('.')) {
        let node = top.take(walk, section.path);
        if section.path == transport::SECTION {
            transport::read(walk, node, subject, &mut settings);
        } else {
            let into = Keys { subject, settings: Some(&mut settings), parameters: &mut parameters };
            keys(walk, node, section, "", into);
        }
    }
    for parameter in table::parameters(subject) {
        parameters.entry(parameter.path()).or_insert(Distribution::Fixed(parameter.default));
    }
    let classes = required(walk, &mut top, root, "classes").map(|node| classes(walk, node, subject, &parameters));
    let sections = sections(subject).map(|section| section.path).filter(|path| !path.contains('.'));
    let known: Vec<_> = ["name", "subject"].into_iter().chain(sections).chain(["classes"]).collect();
    top.close(walk, &known, &|name| table::home(subject, name));

    setting_extraction::refuse_idle(walk, &settings);
    postprocess::idle(walk, &settings);
    for section in table::sections(subject) {
        for setting in section.settings {
            let path = format!("{}.{}", section.path, setting.name);
            let value = settings.remove(&path).unwrap_or_else(|| setting.default.clone());
            let value = load(walk, &path, setting, value, files);
            settings.extend(value.map(|value| (path, value)));
        }
    }
    transport::leave_out(&mut settings);
    postprocess::leave_out(&mut settings);
    setting_extraction::leave_out_idle(&mut settings);
    let (settings, classes) = (Settings(settings), classes.unwrap_or_default());
    let mesh = settings.file(MESH_FILE).and_then(|file| match mesh::read(file) {
        Ok(mesh) => Some(Arc::new(mesh)),
        Err((problem, remedy)) => {
            walk.joint_fault(&[MESH_FILE.to_owned()], problem, remedy);
            None
        }
    });
    check::settings(walk, subject, &settings);
    let kind = Object { subject, settings: &settings, mesh: mesh.as_deref() };
    check::scene(walk, kind, "", &parameters, &BTreeMap::new());
    camera::idle(walk, &settings, "", &parameters);
    postprocess::scene(walk, &settings, "", &parameters, &BTreeMap::new());
    for class in &classes {
        let prefix = format!("classes.{}.", class.name);
        check::scene(walk, kind, &prefix, &parameters, &class.overrides);
        camera::idle(walk, &settings, &prefix, &class.overrides);
        postprocess::scene(walk, &settings, &prefix, &parameters, &class.overrides);
    }
    laser::idle(walk, subject, &settings, &parameters, &classes);
    Some(Resolved { name: name?, subject: subject?, settings, parameters, classes, mesh })
}

/// The file that a setting names; `None` for none, and where it is a fault.
fn load(walk: &mut Walk, path: &str, setting: &Setting, value: Value, files: &Files) -> Option<Value> {
    let Kind::File { most_mb, built_in } = setting.kind else { return Some(value) };
    let (name, sha256) = match &value {
        Value::Word("none") => return None,
        Value::Word(name) => (*name, None),
        Value::Named { name, sha256 } => (name.as_str(), sha256.as_deref()),
        _ => return Some(value),
    };
    match files.find(&Wanted { key: path, name, sha256, most: most_mb << 20, built_in }) {
        Ok(file) => Some(Value::File(file)),
        Err((problem, remedy)) => {
            walk.joint_fault(&[path.to_owned()], problem, remedy);
            None
        }
    }
}

/// Where the keys of a section go; classes have no settings.
struct Keys<'k> {
    subject: Option<Subject>,
    settings: Option<&'k mut BTreeMap<String, Value>>,
    parameters: &'k mut BTreeMap<String, Distribution>,
}

/// Reads the keys of `section` from `node`, whose path is the section's after `prefix`.
fn keys(walk: &mut Walk, node: Option<&Node>, section: &table::Section, prefix: &str, mut into: Keys) {
    let Some(node) = node else { return };
    let mut map = walk.section(node, &format!("{prefix}{}", section.path));
    let mut known = Vec::new();
    for parameter in section.parameters {
        known.push(parameter.name);
        if let Some(node) = map.take(walk, parameter.name) {
            let path = map.path_of(parameter.name);
            let read = dist_read::read(walk, node, &path, parameter);
            into.parameters.extend(read.map(|distribution| (parameter.path(), distribution)));
        }
    }
    if let Some(settings) = &mut into.settings {
        for setting in section.settings {
            known.push(setting.name);
            if let Some(node) = map.take(walk, setting.name) {
                let path = map.path_of(setting.name);
                let read = setting_read::read(walk, node, &path, setting);
                settings.extend(read.map(|value| (path, value)));
            }
        }
        for inner in &SECTIONS {
            if let Some(name) = inner.path.strip_prefix(section.path).and_then(|rest| rest.strip_prefix('.')) {
                known.push(name);
                let node = map.take(walk, name);
                let mut none = BTreeMap::new();
                let into = Keys { subject: into.subject, settings: Some(settings), parameters: &mut none };
                keys(walk, node, inner, prefix, into);
            }
        }
    }
    let in_class = into.settings.is_none();
    map.close(walk, &known, &|name| {
        let setting = in_class && section.settings.iter().any(|setting| setting.name == name);
        let fixed = || format!("`{}.{name}` is the same for all classes: set it at the top level", section.path);
        if setting { Some(fixed()) } else { table::home(into.subject, name) }
    });
}

/// The classes by name.
fn classes(
    walk: &mut Walk,
    node: &Node,
    subject: Option<Subject>,
    base: &BTreeMap<String, Distribution>,
) -> Vec<Class> {
    let entries = walk.section(node, "classes").take_all();
    if entries.is_empty() || entries.len() > MOST_CLASSES {
        let problem = format!("has {} classes", entries.len());
        walk.fault(
            node.place,
            "classes",
            problem,
            format!("give 1 to {MOST_CLASSES} classes, each `name: {{share: ...}}`"),
        );
    }
    let mut classes: Vec<_> = entries
        .iter()
        .take(MOST_CLASSES)
        .filter_map(|(key, node)| {
            let path = format!("classes.{}", clipped(&key.name));
            let letters = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
            if key.name.is_empty() || key.name.len() > LONGEST_NAME || !key.name.chars().all(letters) {
                walk.fault(key.place, &path, "is no name for a class", "use a-z, 0-9 and _, at most 64 of them");
            }
            class(walk, (&key.name, node), &path, subject, base)
        })
        .collect();
    classes.sort_by(|a, b| a.name.cmp(&b.name));
    let sum: f64 = classes.iter().map(|class| class.share).sum();
    // Shares that were written to sum to 1 stay as they were written.
    if sum > 0.0 && (sum - 1.0).abs() > 1e-9 {
        classes.iter_mut().for_each(|class| class.share /= sum);
    }
    for class in classes.iter().filter(|class| class.share < SMALLEST_SHARE) {
        let key = format!("classes.{}.share", class.name);
        let problem = format!("is {} of all shares", shown(class.share));
        walk.joint_fault(&[key], problem, format!("give at least {SMALLEST_SHARE} of their sum, or remove the class"));
    }
    classes
}

fn class(
    walk: &mut Walk,
    (name, node): (&str, &Node),
    path: &str,
    subject: Option<Subject>,
    base: &BTreeMap<String, Distribution>,
) -> Option<Class> {
    let mut map = walk.section(node, path);
    let range = Range { min: 0.0, max: LARGEST_SHARE, whole: false, unit: "" };
    let share = required(walk, &mut map, node, "share").and_then(|node| {
        let path = format!("{path}.share");
        walk.number_in(node, &path, range)
    });
    let mut overrides = BTreeMap::new();
    let drawn = || sections(subject).filter(|section| !section.parameters.is_empty());
    for section in drawn() {
        let node = map.take(walk, section.path);
        keys(walk, node, section, &format!("{path}."), Keys { subject, settings: None, parameters: &mut overrides });
    }
    let known: Vec<_> = ["share"].into_iter().chain(drawn().map(|section| section.path)).collect();
    map.close(walk, &known, &|name| {
        let fixed = sections(subject).any(|section| section.path == name) || name == "name" || name == "subject";
        if fixed {
            Some(format!("`{name}` is the same for all classes: set it at the top level"))
        } else {
            table::home(subject, name)
        }
    });
    // What repeats the top level has no meaning of its own and leaves the hash as it is.
    overrides.retain(|path, distribution| base.get(path) != Some(distribution));
    Some(Class { name: name.to_owned(), share: share?, overrides })
}

/// The value of a key that has no default.
fn required<'n>(walk: &mut Walk, map: &mut Section<'n>, node: &Node, key: &str) -> Option<&'n Node> {
    let found = map.take(walk, key);
    if found.is_none() {
        walk.fault(node.place, &map.path_of(key), "is missing", "it has no default");
    }
    found
}

/// The name of a dataset, which is part of file names.
fn name(walk: &mut Walk, node: &Node, path: &str) -> Option<String> {
    let allowed = "a name of a-z, 0-9, - and _, at most 64 of them";
    let name = walk.text(node, path, allowed)?;
    let letters = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-' || c == '_';
    if name.is_empty() || name.len() > LONGEST_NAME || !name.chars().all(letters) {
        walk.fault(node.place, path, format!("`{}` is no name", clipped(name)), format!("give {allowed}"));
        return None;
    }
    Some(name.to_owned())
}
