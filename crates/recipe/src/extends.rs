//! Inheritance: `extends: NAME` takes the values of another recipe, those that this one states in their place.
//!
//! The parent is a file beside the recipe or a built-in one, and may extend another. Of a list of parents the last one
//! counts most; one with a few sections of a recipe, such as the media of a fit, serves as well. What the recipe states
//! wins, by the rules of [`merged`]; what [presets] say lies between the parents and the recipe that names them.
//!
//! Each value keeps the place where it stands, so that faults name file and line. What was resolved is written out as
//! one text, which a dataset keeps: it needs the other files no more.

use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};
use yaml::{TextPosition, YamlKey, YamlNode, YamlReader, YamlValue, clipped_text, parse_yaml};

use super::RecipeError;
use super::asset::{AssetFault, file_name, hex, printable};
use super::changes;
use super::embedded::{self, FoundText};
use super::flat_text;
use super::keys;
use super::keys::setting_type::NamedFile;
use super::merge::{Level, merged};
use super::presets;
use crate::asset_source::AssetSource;

/// The key that names the parent.
pub(super) const EXTENDS: &str = "extends";
/// What the key is about.
pub(super) const EXTENDS_DOC: &str = "\
A recipe whose values this one takes where it states none: a file beside it, or a built-in one by its name; or a list \
of some, each with a few sections or all, of which the last one counts most. `null` removes a key.";
/// Most recipes that one has above it.
const MAX_PARENTS: usize = 8;

/// A recipe's text as it is written.
pub(super) struct Written<'t> {
    /// Where it comes from.
    pub origin: &'t str,
    /// What the file holds, without changes.
    pub text: &'t str,
    /// Its tree, with changes.
    pub root: &'t YamlNode,
    /// Where the files are that it names.
    pub files: &'t AssetSource,
}

/// A recipe with all that it inherits.
pub(super) struct Whole {
    /// Its tree; each value stands where it was written.
    pub root: YamlNode,
    /// The same as a text of its own.
    pub text: String,
}

/// What a recipe is with what it extends and the presets that it names, where it does; `None` where that is at fault.
pub(super) fn whole(yaml: &mut YamlReader, written: Written) -> Option<Option<Whole>> {
    let Written { origin, text, root, files } = written;
    let mut line = Line { recipes: vec![embedded::identity(origin, files)], above: 0, sums: Vec::new() };
    line.note(file_name(origin), text);
    let parent = extends(root).map(|(key, _)| key.place);
    if parent.is_none() && !presets::are_named(root) {
        return Some(None);
    }
    let root = line.with_parents(yaml, root.clone(), files)?;
    let mut text = "# What it states and what it inherits, in one text. It was made from, by SHA-256:\n".to_owned();
    line.sums.iter().for_each(|(name, sum)| text += &format!("# {sum}  {name}\n"));
    text += &flat_text::block(&root);
    // Parts within the limits of a text can exceed them together.
    if let Err(error) = parse_yaml(&text, "recipe") {
        let problem = format!("makes a recipe that is too large: {}", error.problem);
        return yaml.refuse(parent.unwrap_or(root.place), EXTENDS, problem, error.remedy);
    }
    Some(Some(Whole { root, text }))
}

/// A recipe and its parents, as far as they were read.
struct Line {
    /// From the recipe to the parent that is read.
    recipes: Vec<PathBuf>,
    /// Parents so far.
    above: usize,
    /// Name and SHA-256 of each.
    sums: Vec<(String, String)>,
}

impl Line {
    fn note(&mut self, name: &str, text: &str) {
        self.sums.push((printable(name), hex(&Sha256::digest(text))));
    }

    /// The tree `own` of a recipe whose files are in `files`, with all that it inherits.
    fn with_parents(&mut self, yaml: &mut YamlReader, mut own: YamlNode, files: &AssetSource) -> Option<YamlNode> {
        let mut used = Vec::new();
        let taken = presets::taken(yaml, &mut own, &mut used);
        used.iter().for_each(|(file, text)| self.note(file, text));
        let mut parents = YamlNode { place: own.place, value: YamlValue::Map(Vec::new()) };
        if let Some((key, named)) = take_extends(&mut own) {
            let one = std::slice::from_ref(&named);
            let list = if let YamlValue::List(list) = &named.value { list } else { one };
            if list.is_empty() {
                return yaml.refuse(named.place, EXTENDS, "names no recipe", "name one, or leave the key out");
            }
            for node in list {
                parents = merged(parents, self.parent(yaml, (&key, node), files)?, Level::Root);
            }
        }
        Some(merged(merged(parents, taken, Level::Root), own, Level::Root))
    }

    /// The tree of the recipe that is `named`, with all that it inherits, by one whose files are in `files`.
    fn parent(
        &mut self,
        yaml: &mut YamlReader,
        (key, node): (&YamlKey, &YamlNode),
        files: &AssetSource,
    ) -> Option<YamlNode> {
        let allowed = "the name of a built-in recipe, or of a file beside this one, or a list of some";
        let name = yaml.text(node, EXTENDS, allowed)?;
        self.above += 1;
        if self.above > MAX_PARENTS {
            let problem = format!("has more than {MAX_PARENTS} recipes above it");
            return yaml.refuse(key.place, EXTENDS, problem, "extend one of those directly");
        }
        let found = match find(name, files) {
            Ok(found) => found,
            Err(AssetFault { problem, remedy }) => return yaml.refuse(node.place, EXTENDS, problem, remedy),
        };
        let FoundText { text, files, identity } = found;
        if self.recipes.contains(&identity) {
            let problem = format!("`{}` comes back to itself", clipped_text(name));
            return yaml.refuse(node.place, EXTENDS, problem, "extend a recipe that does not extend this one");
        }
        self.recipes.push(identity);
        self.note(name, &text);
        let built_in = if matches!(files, AssetSource::BuiltIn) { " (built in)" } else { "" };
        let number = yaml.add_text(format!("{}{built_in}", printable(name)), text.clone());
        let parent = match parse_yaml(&text, "recipe") {
            Ok(parent) => parent.in_text(number),
            Err(error) => {
                let place = TextPosition { text: number, ..error.place };
                return yaml.refuse(place, "", error.problem, error.remedy);
            }
        };
        if !matches!(parent.value, YamlValue::Map(_)) {
            return yaml.refuse(
                parent.place,
                "",
                format!("is {}", parent.value.kind()),
                "name a recipe, a map of keys",
            );
        }
        let parent = self.with_parents(yaml, parent, &files)?;
        self.recipes.pop();
        let mut parent = changes::applied(yaml, &parent);
        let folder = Path::new(name).parent().filter(|folder| !folder.as_os_str().is_empty());
        if let (AssetSource::Beside(beside), Some(folder)) = (&files, folder) {
            rename_files(&mut parent, beside, folder);
        }
        Some(parent)
    }
}

/// The entry that names the parent.
fn extends(root: &YamlNode) -> Option<&(YamlKey, YamlNode)> {
    let YamlValue::Map(entries) = &root.value else { return None };
    entries.iter().find(|(key, _)| key.name == EXTENDS)
}

/// Takes the entry that names the parent.
fn take_extends(root: &mut YamlNode) -> Option<(YamlKey, YamlNode)> {
    let YamlValue::Map(entries) = &mut root.value else { return None };
    let at = entries.iter().position(|(key, _)| key.name == EXTENDS)?;
    Some(entries.remove(at))
}

/// The recipe `name` beside one whose files are in `files`.
fn find(name: &str, files: &AssetSource) -> Result<FoundText, AssetFault> {
    if matches!(files, AssetSource::Kept(_)) {
        let problem = "stands in a dataset, which keeps the whole text";
        return Err(AssetFault::new(problem, "bring dataset.json back from a copy"));
    }
    embedded::find(name, files).map_err(|error| match error {
        RecipeError::NotFound { known, nearest, .. } => {
            let meant = nearest.map_or_else(String::new, |name| format!("did you mean `{name}`? "));
            AssetFault::new(
                format!("there is no file `{0}` beside it and no built-in recipe `{0}`", clipped_text(name)),
                format!("{meant}give a name relative to the recipe's own file, or one of {}", known.join(", ")),
            )
        }
        RecipeError::Unreadable { source, .. } => {
            AssetFault::new(format!("`{}` cannot be read: {source}", clipped_text(name)), "make it readable")
        }
        RecipeError::Faulty(faults) => {
            let first = faults.list.into_iter().next();
            let (problem, remedy) = first.map(|fault| (fault.problem, fault.remedy)).unwrap_or_default();
            AssetFault::new(format!("`{}` {problem}", clipped_text(name)), remedy)
        }
    })
}

/// Names the files of a recipe in the folder `beside` as one names them from whose own folder this is `folder`.
fn rename_files(root: &mut YamlNode, beside: &Path, folder: &Path) {
    for setting in keys::settings(None) {
        let Some(built_in) = (setting.built_in)() else { continue };
        let path = setting.path.split('.');
        let Some(node) = path.clone().try_fold(&mut *root, entry) else { continue };
        let node = if matches!(node.value, YamlValue::Map(_)) { entry(node, "name") } else { Some(node) };
        let Some(YamlNode { value: YamlValue::Text(name), .. }) = node else { continue };
        let is_own = name != NamedFile::NONE_NAME && built_in.iter().all(|(known, _)| known != name);
        if is_own || beside.join(&*name).exists() {
            *name = folder.join(&*name).to_string_lossy().into_owned();
        }
    }
}

/// The value of `name` in a map.
fn entry<'n>(node: &'n mut YamlNode, name: &str) -> Option<&'n mut YamlNode> {
    let YamlValue::Map(entries) = &mut node.value else { return None };
    entries.iter_mut().find(|(key, _)| key.name == name).map(|(_, node)| node)
}
