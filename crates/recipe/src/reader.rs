//! Reader of recipes: parse the text, walk over the tables of keys, check what keys mean together.

use std::collections::BTreeMap;

use super::changes::{self, Change, ChangedText};
use super::class::SampleClass;
use super::constraints::{self, RecipeObject};
use super::correlation::{self, CORRELATIONS, ScoreMixture, WrittenPair};
use super::distribution::{self, Distribution};
use super::extends::{self, EXTENDS, Written};
use super::file_contents::FileContents;
use super::groups::{self, BATCH, GroupSizes, RIGS};
use super::keys::alternatives::{self, alternatives};
use super::keys::settings::{Settings, TransportSettings};
use super::keys::{self, SECTIONS, TRANSPORT, sections};
use super::kinds;
use super::level::DrawLevel;
use super::log_group::BOARDS_PER_LOG;
use super::merge::SET;
use super::presets::{self, PRESET};
use super::sampling::{SAMPLING, Sampling};
use super::subject::Subject;
use super::variation::{self, UNSTATED, Unstated, Variation};
use super::{Recipe, canonical};
use crate::asset_source::AssetSource;
use base::Words;
use optical_bench::settings::TransportName;
use yaml::{Mapping, NumberRange, YamlFaults, YamlNode, YamlReader, YamlValue, clipped_text, number_text, parse_yaml};

/// Largest share of a class; shares are relative, so this is no limit in practice.
pub(super) const MAX_SHARE: f64 = 1e6;
/// Smallest share of the samples; a rarer class would be missing from most datasets.
const MIN_SHARE: f64 = 1e-6;
/// Most classes, of which files keep the number in a byte.
const MAX_CLASSES: usize = 255;
/// Longest name of a recipe or class [bytes].
const MAX_NAME_BYTES: usize = 64;

/// Reads `text` with `changes`, what it extends and the files that it names; every fault that is found comes back.
pub(super) fn read(origin: &str, text: &str, changes: &[Change], files: &AssetSource) -> Result<Recipe, YamlFaults> {
    let ChangedText { text: changed, changed_from } = changes::changed(text, changes);
    let mut yaml = YamlReader::new(&changed, "recipe").set_from(changed_from);
    let recipe = match parse_yaml(&changed, "recipe") {
        Ok(root) => extends::whole(&mut yaml, Written { origin, text, root: &root, files }).and_then(|whole| {
            let root = changes::applied(&mut yaml, whole.as_ref().map_or(&root, |whole| &whole.root));
            let recipe = recipe(&mut yaml, &root, &changed, files);
            Some(match whole {
                Some(whole) => Recipe { text: whole.text, written: Some(changed.clone()), ..recipe? },
                None => recipe?,
            })
        }),
        Err(error) => {
            yaml.fault(error.place, "", error.problem, error.remedy);
            None
        }
    };
    yaml.finish(origin)?;
    Ok(recipe.expect("whatever gives no recipe notes a fault"))
}

/// Reads a recipe in steps, each of which takes what those before it have read. Faults are sorted by their place in the
/// text, so the order of the steps is not that of the message.
fn recipe(yaml: &mut YamlReader, root: &YamlNode, text: &str, files: &AssetSource) -> Option<Recipe> {
    is_map(yaml, root).then_some(())?;
    // Each key by itself first: what has an effect, and which files are needed, follows from all of them.
    let mut keys = written_keys(yaml, root);
    load_files(yaml, &mut keys, files);
    let contents = FileContents::read(yaml, keys.subject, &keys.settings);
    // Then the keys together: how large a board may be follows from its picture. What is not stated fits in with it.
    let variation = fill(yaml, &mut keys, &contents);
    let notes = check_together(yaml, &keys, &contents);
    // Correlations last: they are worked out from distributions that are in range.
    let mixtures = mixtures(yaml, &mut keys, &variation);
    let WrittenKeys { name, family, subject, settings, parameters, sampling, pairs, classes, groups, .. } = keys;
    let mut recipe = Recipe {
        name: name?,
        family: family?,
        subject: subject?,
        settings,
        parameters,
        classes,
        variation,
        groups,
        sampling: sampling?,
        correlations: correlation::sorted(&pairs),
        mixtures,
        contents,
        notes,
        text: text.to_owned(),
        written: None,
        canonical: serde_json::Value::Null,
        hash: String::new(),
    };
    recipe.canonical = canonical::json(&recipe);
    recipe.hash = canonical::hash(&recipe.canonical);
    Some(recipe)
}

/// Whether the text is a map; what else it is, is a fault.
fn is_map(yaml: &mut YamlReader, root: &YamlNode) -> bool {
    let problem = match &root.value {
        YamlValue::Map(_) => return true,
        YamlValue::Nothing => "the file is empty".to_owned(),
        other => format!("the file is {}", other.kind()),
    };
    yaml.fault(root.place, "", problem, "a recipe is a map with at least `name` and `subject`");
    false
}

/// What each key says by itself; `None` where one that has no default is missing or at fault.
struct WrittenKeys {
    name: Option<String>,
    family: Option<String>,
    subject: Option<Subject>,
    settings: Settings,
    parameters: BTreeMap<String, Distribution>,
    sampling: Option<Sampling>,
    unstated: Unstated,
    groups: GroupSizes,
    pairs: Vec<WrittenPair>,
    classes: Vec<SampleClass>,
}

/// Where a key that is unknown where it stands belongs.
fn home(subject: Option<Subject>, name: &str, known: &[&str]) -> Option<String> {
    if name == PRESET { Some(presets::remedy()) } else { keys::home(subject, name, known) }
}

/// Reads every key, each in its own range. The subject comes first, by which sections are known.
fn written_keys(yaml: &mut YamlReader, root: &YamlNode) -> WrittenKeys {
    let mut top = yaml.mapping(root, "");
    let name = required(yaml, &mut top, root, "name").and_then(|node| name(yaml, node, "name"));
    let family = match top.take(yaml, "family") {
        Some(node) => self::name(yaml, node, "family"),
        None => name.clone(),
    };
    let subject = required(yaml, &mut top, root, "subject").and_then(|node| {
        let word = yaml.word(node, "subject", &Subject::NAMES)?;
        Subject::named(word)
    });
    let mut settings = Settings::default();
    let mut parameters = BTreeMap::new();
    for section in sections(subject).filter(|section| !section.path.contains('.')) {
        let node = top.take(yaml, section.path);
        let Some(node) = node else { continue };
        let map = matches!(node.value, YamlValue::Map(_) | YamlValue::Nothing);
        if section.path == TRANSPORT && !map {
            transport_name(yaml, node, &mut settings);
        } else {
            let into = Keys { subject, settings: Some(&mut settings), parameters: &mut parameters };
            section_keys(yaml, node, section, "", into);
        }
    }
    settings.list_grey(|path| yaml.has(path));
    let unstated = top.take(yaml, UNSTATED).and_then(|node| {
        let word = yaml.word(node, UNSTATED, &Unstated::NAMES)?;
        Unstated::named(word)
    });
    let groups = groups::read(yaml, &mut top, subject, &settings);
    let sampling = top.take(yaml, SAMPLING).map_or(Some(Sampling::Independent), |node| {
        let word = yaml.word(node, SAMPLING, &Sampling::NAMES)?;
        Sampling::named(word)
    });
    let pairs = top.take(yaml, CORRELATIONS).map_or_else(Vec::new, |node| correlation::read(yaml, node, subject));
    let classes = match top.take(yaml, "classes") {
        Some(node) => classes(yaml, node, subject),
        None => kinds::usual(subject, &settings),
    };
    let sections = sections(subject).map(|section| section.path).filter(|path| !path.contains('.'));
    let known: Vec<_> = ["name", "family", "subject"]
        .into_iter()
        .chain(sections)
        .chain([UNSTATED, RIGS, BATCH, SAMPLING, CORRELATIONS, "classes", EXTENDS, SET])
        .collect();
    let in_text = || "it is no key to set: write it in the recipe's text".to_owned();
    top.close(yaml, &known, &|name| (name == EXTENDS).then(in_text).or_else(|| home(subject, name, &known)));
    let unstated = unstated.unwrap_or(Unstated::Drawn);
    WrittenKeys { name, family, subject, settings, parameters, sampling, unstated, groups, pairs, classes }
}

/// Gives each key that is not stated its distribution; what a class repeats of the top level is no change then.
fn fill(yaml: &YamlReader, keys: &mut WrittenKeys, contents: &FileContents) -> Variation {
    let WrittenKeys { subject, settings, parameters, unstated, classes, .. } = keys;
    let (mut filled, stated) = (parameters.clone(), parameters.keys().cloned().collect());
    let object = RecipeObject { subject: *subject, settings, contents, parameters, classes };
    let natural = variation::fill(yaml, *unstated, object, &mut filled);
    *parameters = filled;
    // It leaves the hash as it is.
    for class in classes {
        class.overrides.retain(|path, distribution| parameters.get(path) != Some(distribution));
    }
    Variation { stated, natural }
}

/// Reads the files that are named. What has no effect names none, though it may have a default.
fn load_files(yaml: &mut YamlReader, keys: &mut WrittenKeys, files: &AssetSource) {
    for setting in keys::settings(keys.subject) {
        if setting.idle(&keys.settings).is_none() {
            (setting.load)(&mut keys.settings, yaml, files);
        }
    }
}

/// Notes what keys cannot mean together, and which have no effect; what may be so all the same comes back.
fn check_together(yaml: &mut YamlReader, keys: &WrittenKeys, contents: &FileContents) -> Vec<String> {
    let WrittenKeys { subject, settings, parameters, classes, .. } = keys;
    let object = RecipeObject { subject: *subject, settings, contents, parameters, classes };
    constraints::check(yaml, object);
    groups::check(yaml, settings, keys.groups.rigs);
    let mut notes = constraints::notes(object);
    let mut every = classes.iter().flat_map(|class| class.overrides.values()).chain(parameters.values());
    if keys.sampling == Some(Sampling::LowDiscrepancy) && every.all(|own| matches!(own, Distribution::Fixed(_))) {
        notes.push(format!("{SAMPLING} has no effect: no key is drawn; give one a distribution, or remove it"));
    }
    notes
}

/// What correlations do in each class, those that nature has with those that the recipe has.
fn mixtures(yaml: &mut YamlReader, keys: &mut WrittenKeys, variation: &Variation) -> Vec<ScoreMixture> {
    let is_wood = keys.subject == Some(Subject::Wood);
    correlation::refuse_across(yaml, &keys.pairs, |path| match keys.groups.level(path) {
        DrawLevel::Rig => ("a rig", Some(RIGS)),
        DrawLevel::Lot if is_wood => ("a log", Some(BOARDS_PER_LOG)),
        DrawLevel::Lot => ("a batch", Some(BATCH)),
        DrawLevel::Sample => ("a sample", None),
    });
    keys.pairs.extend(variation.correlated(&keys.pairs, &keys.groups, &keys.classes));
    correlation::mixtures(yaml, &keys.pairs, keys.subject, &keys.parameters, &keys.classes)
}

/// Where the keys of a section go; classes have no settings.
struct Keys<'k> {
    subject: Option<Subject>,
    settings: Option<&'k mut Settings>,
    parameters: &'k mut BTreeMap<String, Distribution>,
}

/// Reads the name of a model, which stands for the whole section `transport`.
fn transport_name(yaml: &mut YamlReader, node: &YamlNode, settings: &mut Settings) {
    let model = &TransportSettings::SETTINGS[0];
    if matches!(node.value, YamlValue::Text(_)) {
        (model.read)(settings, yaml, node, TRANSPORT);
        return;
    }
    let remedy = format!("give one of {}, or a map of `model` and its keys", TransportName::NAMES.join(", "));
    yaml.fault(node.place, TRANSPORT, format!("is {}", node.value.kind()), remedy);
}

/// Reads the keys of `section` from `node`, whose path is the section's after `prefix`.
fn section_keys(yaml: &mut YamlReader, node: &YamlNode, section: &keys::RecipeSection, prefix: &str, mut into: Keys) {
    let mut map = yaml.mapping(node, &format!("{prefix}{}", section.path));
    let mut known = Vec::new();
    for parameter in section.parameters {
        known.push(parameter.name);
        if let Some(node) = map.take(yaml, parameter.name) {
            let path = map.path_of(parameter.name);
            let read = distribution::distribution(yaml, node, &path, parameter);
            into.parameters.extend(read.map(|distribution| (parameter.path(), distribution)));
        }
    }
    known.extend(alternatives(section.path).map(|alternative| alternative.name));
    alternatives::take(yaml, &mut map, section.path, into.parameters);
    if let Some(settings) = &mut into.settings {
        // Whether a setting has an effect is open while one that it needs is at fault itself.
        let mut faulty: Vec<&str> = Vec::new();
        for setting in section.settings {
            known.push(setting.name);
            let Some(node) = map.take(yaml, setting.name) else { continue };
            let decided = !faulty.iter().any(|path| setting.exists_by(path));
            if let Some(idle) = setting.idle(settings).filter(|_| decided) {
                let (problem, remedy) = idle.refusal();
                yaml.joint_fault(&[setting.path], problem, remedy);
            } else if (setting.read)(settings, yaml, node, setting.path).is_none() {
                faulty.push(setting.path);
            }
        }
        for inner in SECTIONS.iter() {
            if let Some(name) = inner.path.strip_prefix(section.path).and_then(|rest| rest.strip_prefix('.')) {
                known.push(name);
                let Some(node) = map.take(yaml, name) else { continue };
                let mut none = BTreeMap::new();
                let into = Keys { subject: into.subject, settings: Some(settings), parameters: &mut none };
                section_keys(yaml, node, inner, prefix, into);
            }
        }
    }
    let in_class = into.settings.is_none();
    map.close(yaml, &known, &|name| {
        let setting = in_class && section.settings.iter().any(|setting| setting.name == name);
        let fixed = || format!("`{}.{name}` is the same for all classes: set it at the top level", section.path);
        if setting { Some(fixed()) } else { home(into.subject, name, &known) }
    });
}

/// The classes by name.
pub(super) fn classes(yaml: &mut YamlReader, node: &YamlNode, subject: Option<Subject>) -> Vec<SampleClass> {
    let entries = yaml.mapping(node, "classes").take_all();
    if entries.is_empty() || entries.len() > MAX_CLASSES {
        let problem = format!("has {} classes", entries.len());
        yaml.fault(
            node.place,
            "classes",
            problem,
            format!("give 1 to {MAX_CLASSES} classes, each `name: {{share: ...}}`"),
        );
    }
    let mut classes: Vec<_> = entries
        .iter()
        .take(MAX_CLASSES)
        .filter_map(|(key, node)| {
            let path = format!("classes.{}", clipped_text(&key.name));
            let letters = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
            if key.name.is_empty() || key.name.len() > MAX_NAME_BYTES || !key.name.chars().all(letters) {
                yaml.fault(key.place, &path, "is no name for a class", "use a-z, 0-9 and _, at most 64 of them");
            }
            class(yaml, (&key.name, node), &path, subject)
        })
        .collect();
    classes.sort_by(|a, b| a.name.cmp(&b.name));
    share_out(yaml, &mut classes);
    classes
}

/// Makes shares sum to 1.
pub(super) fn share_out(yaml: &mut YamlReader, classes: &mut [SampleClass]) {
    let sum: f64 = classes.iter().map(|class| class.share).sum();
    // Shares that were written to sum to 1 stay as they were written.
    if sum > 0.0 && (sum - 1.0).abs() > 1e-9 {
        classes.iter_mut().for_each(|class| class.share /= sum);
    }
    for class in classes.iter().filter(|class| class.share < MIN_SHARE) {
        let key = format!("classes.{}.share", class.name);
        let problem = format!("is {} of all shares", number_text(class.share));
        yaml.joint_fault(&[key], problem, format!("give at least {MIN_SHARE} of their sum, or remove the class"));
    }
}

fn class(
    yaml: &mut YamlReader,
    (name, node): (&str, &YamlNode),
    path: &str,
    subject: Option<Subject>,
) -> Option<SampleClass> {
    let mut map = yaml.mapping(node, path);
    let range = NumberRange { min: 0.0, max: MAX_SHARE, whole: false, unit: "" };
    let share = required(yaml, &mut map, node, "share").and_then(|node| {
        let path = format!("{path}.share");
        yaml.number_in(node, &path, range)
    });
    let mut overrides = BTreeMap::new();
    let drawn = || sections(subject).filter(|section| !section.parameters.is_empty());
    for section in drawn() {
        let Some(node) = map.take(yaml, section.path) else { continue };
        let into = Keys { subject, settings: None, parameters: &mut overrides };
        section_keys(yaml, node, section, &format!("{path}."), into);
    }
    let known: Vec<_> = ["share"].into_iter().chain(drawn().map(|section| section.path)).collect();
    map.close(yaml, &known, &|name| {
        let fixed = sections(subject).any(|section| section.path == name)
            || ["name", "family", "subject", UNSTATED, RIGS, BATCH, SAMPLING, CORRELATIONS].contains(&name);
        if fixed {
            Some(format!("`{name}` is the same for all classes: set it at the top level"))
        } else {
            home(subject, name, &known)
        }
    });
    Some(SampleClass { name: name.to_owned(), share: share?, overrides })
}

/// The value of a key that has no default.
fn required<'n>(yaml: &mut YamlReader, map: &mut Mapping<'n>, node: &YamlNode, key: &str) -> Option<&'n YamlNode> {
    let found = map.take(yaml, key);
    found.or_else(|| yaml.refuse(node.place, &map.path_of(key), "is missing", "it has no default"))
}

/// The name of a dataset, which is part of file names.
fn name(yaml: &mut YamlReader, node: &YamlNode, path: &str) -> Option<String> {
    let allowed = "a name of a-z, 0-9, - and _, at most 64 of them";
    let name = yaml.text(node, path, allowed)?;
    let letters = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-' || c == '_';
    if name.is_empty() || name.len() > MAX_NAME_BYTES || !name.chars().all(letters) {
        let problem = format!("`{}` is no name", clipped_text(name));
        return yaml.refuse(node.place, path, problem, format!("give {allowed}"));
    }
    Some(name.to_owned())
}
