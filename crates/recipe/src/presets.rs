//! Presets: what data sheets say of a camera, a laser, a lens or a material, as values of a recipe.
//!
//! `camera: {preset: NAME}` takes the numbers of the preset that [`FILES`] has for the section. What the recipe states
//! wins over them, and they win over what it [extends](super::extends), by the same rules. A list of names takes
//! several, the last one first. A number keeps its place, so that faults name the file of presets and its line.
//!
//! A file has `sources` (what, where, and when its numbers were taken over) and `presets`, each with `numbers` by key
//! path: what the number `is`, `by` which source, and `as` what the sheet calls it or how it follows. `says` is what
//! the sheet tells and no key takes, `lacks` what it leaves open: that stays as it is.

use yaml::{TextPosition, YamlError, YamlKey, YamlNode, YamlReader, YamlValue, parse_yaml};

use super::flat_text::flow;
use super::merge::{Level, SET, merged};

/// The key that names presets.
pub(super) const PRESET: &str = "preset";
/// What the key is about.
pub(super) const PRESET_DOC: &str = "\
Values of data sheets for what this recipe does not state itself: the name of a preset, or a list of them, of which \
the last one counts most.";
/// Most presets that a section names.
const MAX_PRESETS: usize = 8;

/// Files of presets: the section that names those in it, and the text.
const FILES: [(&str, &str); 6] = [
    ("laser", include_str!("../../../recipes/presets/laser.yaml")),
    ("camera", include_str!("../../../recipes/presets/camera.yaml")),
    ("log", include_str!("../../../recipes/presets/log.yaml")),
    ("tablet", include_str!("../../../recipes/presets/tablet.yaml")),
    ("film", include_str!("../../../recipes/presets/film.yaml")),
    ("foil", include_str!("../../../recipes/presets/foil.yaml")),
];

/// What a data sheet says, as values of a recipe.
#[derive(Debug, Clone)]
pub struct Preset {
    /// The section that names it.
    pub section: &'static str,
    /// Its name.
    pub name: String,
    /// What it is of.
    pub what: String,
    /// Its numbers, in the order of the file.
    pub numbers: Vec<PresetNumber>,
    /// What the sheet tells and no key takes.
    pub says: Vec<String>,
    /// What the sheet leaves open.
    pub lacks: Vec<String>,
}

/// A number of a preset.
#[derive(Debug, Clone)]
pub struct PresetNumber {
    /// Path of its key.
    pub key: String,
    /// The value, as YAML in one line.
    pub value: String,
    /// Where it was taken from.
    pub source: PresetSource,
    /// What the source calls it, or how it follows from what that says; empty where it stands there as it is.
    pub remark: String,
}

/// Where a number was taken from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PresetSource {
    /// The document.
    pub what: String,
    /// Where it is found; empty where its title says so.
    pub address: String,
    /// When it was taken over, as a date.
    pub seen: String,
}

/// Every preset, by section.
pub fn presets() -> Vec<Preset> {
    let of_file = |&(section, text): &(&'static str, &str)| {
        let root = parsed(text).ok();
        let sources = root.as_ref().and_then(|root| entry(root, "sources")).cloned();
        let all = root.as_ref().map(|root| listed(root).to_vec()).unwrap_or_default();
        all.into_iter().map(move |(key, node)| preset(section, &key.name, &node, sources.as_ref())).collect::<Vec<_>>()
    };
    FILES.iter().flat_map(of_file).collect()
}

/// Names of the presets that `section` can name.
pub(super) fn names(section: &str) -> Vec<String> {
    let Some((_, text)) = FILES.iter().find(|(known, _)| *known == section) else { return Vec::new() };
    parsed(text).map(|root| listed(&root).iter().map(|(key, _)| key.name.clone()).collect()).unwrap_or_default()
}

/// What to do about a key `preset` in a section without presets.
pub(super) fn remedy() -> String {
    let sections: Vec<_> = FILES.iter().map(|(section, _)| format!("`{section}`")).collect();
    let sections = sections.join(", ");
    format!("presets are for {sections}: `gen recipe presets` lists them; set `camera.preset` by itself, not in a map")
}

/// The tree of a file of presets.
fn parsed(text: &str) -> Result<YamlNode, YamlError> {
    parse_yaml(text, "file of presets")
}

/// The value of `name` in a map.
fn entry<'n>(node: &'n YamlNode, name: &str) -> Option<&'n YamlNode> {
    let YamlValue::Map(entries) = &node.value else { return None };
    entries.iter().find(|(key, _)| key.name == name).map(|(_, node)| node)
}

/// The entries of a map.
fn entries(node: Option<&YamlNode>) -> &[(YamlKey, YamlNode)] {
    match node.map(|node| &node.value) {
        Some(YamlValue::Map(entries)) => entries,
        _ => &[],
    }
}

/// The presets of a file.
fn listed(root: &YamlNode) -> &[(YamlKey, YamlNode)] {
    entries(entry(root, "presets"))
}

/// A text in a map; empty where there is none.
fn text(node: &YamlNode, name: &str) -> String {
    match entry(node, name).map(|node| &node.value) {
        Some(YamlValue::Text(text)) => text.clone(),
        _ => String::new(),
    }
}

/// A list of texts in a map.
fn texts(node: &YamlNode, name: &str) -> Vec<String> {
    let Some(YamlValue::List(list)) = entry(node, name).map(|node| &node.value) else { return Vec::new() };
    let text = |node: &YamlNode| match &node.value {
        YamlValue::Text(text) => Some(text.clone()),
        _ => None,
    };
    list.iter().filter_map(text).collect()
}

/// A preset of a file with these sources.
fn preset(section: &'static str, name: &str, node: &YamlNode, sources: Option<&YamlNode>) -> Preset {
    let number = |(key, number): &(YamlKey, YamlNode)| {
        let source = sources.and_then(|sources| entry(sources, &text(number, "by")));
        let part = |name: &str| source.map(|source| text(source, name)).unwrap_or_default();
        PresetNumber {
            key: key.name.clone(),
            value: entry(number, "is").map(flow).unwrap_or_default(),
            source: PresetSource { what: part("what"), address: part("at"), seen: part("seen") },
            remark: text(number, "as"),
        }
    };
    Preset {
        section,
        name: name.to_owned(),
        what: text(node, "what"),
        numbers: entries(entry(node, "numbers")).iter().map(number).collect(),
        says: texts(node, "says"),
        lacks: texts(node, "lacks"),
    }
}

/// Whether a recipe, a class of it or what was changed in it names presets.
pub(super) fn are_named(root: &YamlNode) -> bool {
    let in_section = |root: &YamlNode| {
        FILES.iter().any(|(section, _)| entry(root, section).is_some_and(|node| entry(node, PRESET).is_some()))
    };
    let is_change = |(key, _): &(YamlKey, YamlNode)| changed(&key.name).is_some();
    in_section(root)
        || entries(entry(root, "classes")).iter().any(|(_, class)| in_section(class))
        || entries(entry(root, SET)).iter().any(is_change)
}

/// What the presets that `own` names say, as a recipe; `own` names none then. What was changed names values then.
pub(super) fn taken(yaml: &mut YamlReader, own: &mut YamlNode, used: &mut Vec<(String, &'static str)>) -> YamlNode {
    let mut found = map(own.place);
    in_sections(yaml, own, &mut found, ("", used));
    let YamlValue::Map(sections) = &mut own.value else { return found };
    for (key, node) in sections {
        match &mut node.value {
            YamlValue::Map(classes) if key.name == "classes" => {
                for (name, class) in classes {
                    let mut of_class = map(class.place);
                    in_sections(yaml, class, &mut of_class, (&format!("classes.{}.", name.name), used));
                    if !entries(Some(&of_class)).is_empty() {
                        put(&mut found, &[("classes", key.place), (&name.name, name.place)], of_class);
                    }
                }
            }
            YamlValue::Map(changes) if key.name == SET => in_changes(yaml, changes, used),
            _ => {}
        }
    }
    found
}

/// Adds to `found` what the sections of `own`, a recipe or a class, take of presets.
fn in_sections(
    yaml: &mut YamlReader,
    own: &mut YamlNode,
    found: &mut YamlNode,
    (path, used): (&str, &mut Vec<(String, &'static str)>),
) {
    let YamlValue::Map(sections) = &mut own.value else { return };
    for (section, node) in sections {
        let Some(file) = FILES.iter().find(|(known, _)| *known == section.name) else { continue };
        let YamlValue::Map(keys) = &mut node.value else { continue };
        let Some(at) = keys.iter().position(|(key, _)| key.name == PRESET) else { continue };
        let (_, named) = keys.remove(at);
        for (key, value) in values(yaml, file, &named, &format!("{path}{}.{PRESET}", section.name), used) {
            let Some((group, name)) = key.name.split_once('.') else { continue };
            let mut one = map(key.place);
            put(&mut one, &[(group, key.place), (name, key.place)], value);
            let level = if path.is_empty() { Level::Root } else { Level::Class };
            *found = merged(std::mem::replace(found, map(key.place)), one, level);
        }
    }
}

/// Puts values in the place of presets in what was changed; what is changed itself wins over them.
fn in_changes(yaml: &mut YamlReader, changes: &mut Vec<(YamlKey, YamlNode)>, used: &mut Vec<(String, &'static str)>) {
    let mut taken = Vec::new();
    changes.retain(|(key, node)| {
        let Some((path, file)) = changed(&key.name) else { return true };
        let values = values(yaml, file, node, &key.name, used);
        taken.extend(
            values
                .into_iter()
                .map(|(own, value)| (YamlKey { place: own.place, name: format!("{path}{}", own.name) }, value)),
        );
        false
    });
    taken.retain(|(key, _)| changes.iter().all(|(own, _)| own.name != key.name));
    taken.append(changes);
    *changes = taken;
}

/// Where a changed key names presets: the path of what they are put into (empty, or that of a class) and their file.
fn changed(key: &str) -> Option<(&str, &'static (&'static str, &'static str))> {
    let before = key.strip_suffix(PRESET)?.strip_suffix('.')?;
    let section = before.rsplit('.').next()?;
    let file = FILES.iter().find(|(known, _)| *known == section)?;
    Some((&before[..before.len() - section.len()], file))
}

/// The numbers of the presets that `named` names, by key path, of those of one key that of the last preset.
fn values(
    yaml: &mut YamlReader,
    &(section, text): &'static (&'static str, &'static str),
    named: &YamlNode,
    path: &str,
    used: &mut Vec<(String, &'static str)>,
) -> Vec<(YamlKey, YamlNode)> {
    let one = std::slice::from_ref(named);
    let list = if let YamlValue::List(list) = &named.value { list } else { one };
    if list.len() > MAX_PRESETS {
        yaml.fault(named.place, path, format!("names {} presets", list.len()), format!("name at most {MAX_PRESETS}"));
        return Vec::new();
    }
    let file = format!("presets/{section}.yaml");
    let Ok(root) = parsed(text) else { return Vec::new() };
    let origin = yaml.add_text(format!("{file} (built in)"), text.to_owned());
    let root = root.in_text(origin);
    let known = listed(&root);
    let mut found: Vec<(YamlKey, YamlNode)> = Vec::new();
    for node in list {
        let Some(name) = yaml.text(node, path, "the name of a preset, or a list of some") else { continue };
        let Some((_, preset)) = known.iter().find(|(key, _)| key.name == name) else {
            let names: Vec<_> = known.iter().map(|(key, _)| key.name.as_str()).collect();
            yaml.unknown_word::<()>(node.place, path, name, &names);
            continue;
        };
        for (key, number) in entries(entry(preset, "numbers")) {
            let Some(value) = entry(number, "is") else { continue };
            found.retain(|(known, _)| known.name != key.name);
            found.push((key.clone(), value.clone()));
        }
    }
    if !found.is_empty() && used.iter().all(|(known, _)| *known != file) {
        used.push((file, text));
    }
    found
}

/// A map without entries.
fn map(place: TextPosition) -> YamlNode {
    YamlNode { place, value: YamlValue::Map(Vec::new()) }
}

/// Puts `value` into the map `node` at a path whose maps are made where they are not there.
fn put(node: &mut YamlNode, path: &[(&str, TextPosition)], value: YamlNode) {
    let Some(((name, place), inner)) = path.split_first() else {
        *node = value;
        return;
    };
    let YamlValue::Map(entries) = &mut node.value else { return };
    let at = entries.iter().position(|(key, _)| key.name == *name).unwrap_or_else(|| {
        entries.push((YamlKey { place: *place, name: (*name).to_owned() }, map(*place)));
        entries.len() - 1
    });
    put(&mut entries[at].1, inner, value);
}
