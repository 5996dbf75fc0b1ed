//! One key of a recipe's text written, changed or taken out, as somebody does it by hand: comments, order and all other
//! keys stay as they were.
//!
//! A key that is there has its value replaced in its place ([`super::recipe_text`]). One that is not goes to the end of
//! its section, and a section to the end of the text. What comes out is read again and must say what was asked for;
//! where it does not (anchors, sections behind aliases), the key goes to the section `set`, as `--set` puts it there.

use std::collections::BTreeSet;

use super::changes::{Change, changed_text};
use super::flat_text::flow;
use super::keys::TRANSPORT;
use super::merge::{Level, SET};
use super::recipe_text::{TextPlace, closing, entry, place, span};
use yaml::{YamlNode, YamlValue, parse_yaml};

/// `text` with `change` written where it belongs.
pub fn with_key(text: &str, change: &Change) -> String {
    let edited = parse_yaml(text, "recipe").ok().and_then(|root| {
        let (names, value) = aim(&root, change);
        let edited = replaced(text, &root, &names, &value).or_else(|| inserted(text, &root, &names, &value))?;
        says(&edited, &names, &value).then_some(edited)
    });
    edited.unwrap_or_else(|| changed_text(text, std::slice::from_ref(change)))
}

/// `text` without the key at `path`; `None` where it has none, or none that can be taken out.
pub fn without_key(text: &str, path: &str) -> Option<String> {
    let root = parse_yaml(text, "recipe").ok()?;
    let mut names = names_of(&root, path);
    let mut rest = root.clone();
    // What would be left empty goes with it.
    while names.len() > 1 && children(&root, &names[..names.len() - 1]) == Some(1) {
        names.pop();
    }
    take(&mut rest, &names)?;
    let mut lines: Vec<String> = text.lines().map(String::from).collect();
    let place = place(&root, names.iter().map(String::as_str))?;
    let (last_line, last_column) = span(&lines, &place)?;
    let (line, column) = (place.key.0 - 1, place.key.1 - 1);
    let before = part(&lines[line], 0, column);
    if before.trim().is_empty() && !is_in_flow(&lines[last_line], last_column) {
        lines.drain(line..=last_line);
    } else {
        let after = part(&lines[last_line], last_column, usize::MAX);
        let joined = match after.trim_start().strip_prefix(',') {
            Some(after) => before + after.trim_start(),
            None => format!("{}{after}", before.trim_end().trim_end_matches(',')),
        };
        lines.splice(line..=last_line, [joined]);
    }
    let edited = lines.join("\n") + "\n";
    let left = parse_yaml(&edited, "recipe").ok()?;
    (flow(&left) == flow(&rest)).then_some(edited)
}

/// Paths of the keys that `text` itself has, those of its section `set` among them; classes' begin with `classes`.
pub fn written_keys(text: &str) -> BTreeSet<String> {
    fn walk(node: &YamlNode, level: Level, path: &str, found: &mut BTreeSet<String>) {
        match &node.value {
            YamlValue::Map(entries) if level != Level::Value => {
                for (key, node) in entries {
                    let at = if path.is_empty() { key.name.clone() } else { format!("{path}.{}", key.name) };
                    let inner = if at == TRANSPORT { Level::Section(TRANSPORT) } else { level.inner(&key.name) };
                    match level.inner(&key.name) {
                        Level::Set => walk(node, Level::Set, "", found),
                        _ => walk(node, inner, &at, found),
                    }
                }
            }
            YamlValue::Text(_) if path == TRANSPORT => _ = found.insert(format!("{TRANSPORT}.model")),
            _ => _ = found.insert(path.to_owned()),
        }
    }
    let mut found = BTreeSet::new();
    if let Ok(root) = parse_yaml(text, "recipe") {
        walk(&root, Level::Root, "", &mut found);
    }
    found
}

/// The names below each other that lead to a key: what the section `set` has wins.
fn names_of(root: &YamlNode, path: &str) -> Vec<String> {
    let is_set = entry(root, SET).is_some_and(|(_, set)| entry(set, path).is_some());
    if is_set { vec![SET.to_owned(), path.to_owned()] } else { path.split('.').map(String::from).collect() }
}

/// Where a change goes, and what is written there: the name of a model may stand for its whole section.
fn aim(root: &YamlNode, change: &Change) -> (Vec<String>, String) {
    let (key, value) = (change.key(), change.value());
    let names = names_of(root, key);
    match (names.as_slice(), entry(root, TRANSPORT).map(|(_, node)| &node.value)) {
        ([section, name], Some(YamlValue::Text(model))) if section == TRANSPORT => {
            let long = format!("{{model: {model}, {name}: {value}}}");
            (vec![TRANSPORT.to_owned()], if name == "model" { value.to_owned() } else { long })
        }
        _ => (names, value.to_owned()),
    }
}

/// The value at `names` in place of its own.
fn replaced(text: &str, root: &YamlNode, names: &[String], value: &str) -> Option<String> {
    let mut lines: Vec<String> = text.lines().map(String::from).collect();
    let place = place(root, names.iter().map(String::as_str))?;
    let (last_line, last_column) = span(&lines, &place)?;
    let (line, column) = (place.value.0 - 1, place.value.1 - 1);
    let after = part(&lines[last_line], last_column, usize::MAX);
    // A block below its key goes back to the key's line.
    let key_line = place.key.0 - 1;
    let whole = if key_line < line {
        format!("{} {value}{after}", lines[key_line].trim_end())
    } else {
        format!("{}{value}{after}", part(&lines[line], 0, column))
    };
    lines.splice(line.min(key_line)..=last_line, [whole]);
    Some(lines.join("\n") + "\n")
}

/// The key at `names` behind the last one of its section, with the sections that are missing.
fn inserted(text: &str, root: &YamlNode, names: &[String], value: &str) -> Option<String> {
    let mut lines: Vec<String> = text.lines().map(String::from).collect();
    let (mut node, mut depth, mut key) = (root, 0, (1, 1));
    while let Some((place, inner)) = names.get(depth).and_then(|name| entry(node, name)) {
        (node, depth, key) = (inner, depth + 1, place);
    }
    let rest = &names[depth..];
    let YamlValue::Map(entries) = &node.value else { return None };
    let place = TextPlace { section: key.0, key, value: (node.place.line, node.place.column) };
    let (line, column) = (place.value.0 - 1, place.value.1 - 1);
    if lines.get(line)?.chars().nth(column) == Some('{') {
        let (line, end) = closing(&lines, line, column)?;
        let before = part(&lines[line], 0, end - 1);
        let comma = if entries.is_empty() || before.trim_end().ends_with(',') { "" } else { ", " };
        let (last, above) = rest.split_last()?;
        let open: String = above.iter().map(|name| format!("{name}: {{")).collect();
        let new = format!("{open}{last}: {value}{}", "}".repeat(above.len()));
        lines[line] = format!("{}{comma}{new}{}", before.trim_end(), part(&lines[line], end - 1, usize::MAX));
    } else {
        let indent = entries.first()?.0.place.column - 1;
        let end = if depth == 0 { lines.len() } else { span(&lines, &place)?.0 + 1 };
        let mut new: Vec<String> = Vec::new();
        if depth == 0 && rest.len() > 1 {
            new.push(String::new());
        }
        for (deeper, name) in rest.iter().enumerate() {
            let value = if deeper + 1 == rest.len() { format!(" {value}") } else { String::new() };
            new.push(format!("{}{name}:{value}", " ".repeat(indent + 2 * deeper)));
        }
        lines.splice(end..end, new);
    }
    Some(lines.join("\n") + "\n")
}

/// Whether a text has this value at `names`.
fn says(text: &str, names: &[String], value: &str) -> bool {
    let Ok(root) = parse_yaml(text, "recipe") else { return false };
    let found = names.iter().try_fold(&root, |node, name| entry(node, name).map(|(_, inner)| inner));
    found.zip(parse_yaml(value, "value").ok()).is_some_and(|(found, value)| flow(found) == flow(&value))
}

/// How many entries the map at `names` has.
fn children(root: &YamlNode, names: &[String]) -> Option<usize> {
    let found = names.iter().try_fold(root, |node, name| entry(node, name).map(|(_, inner)| inner))?;
    if let YamlValue::Map(entries) = &found.value { Some(entries.len()) } else { None }
}

/// Takes the entry at `names` out of a tree.
fn take(node: &mut YamlNode, names: &[String]) -> Option<()> {
    let YamlValue::Map(entries) = &mut node.value else { return None };
    let (name, inner) = names.split_first()?;
    let at = entries.iter().position(|(key, _)| key.name == *name)?;
    if inner.is_empty() {
        entries.remove(at);
        Some(())
    } else {
        take(&mut entries[at].1, inner)
    }
}

/// Whether a value that ends in a line is followed by more of a map in brackets.
fn is_in_flow(line: &str, end: usize) -> bool {
    part(line, end, usize::MAX).trim_start().starts_with([',', '}', ']'])
}

/// Some characters of a line.
fn part(line: &str, from: usize, to: usize) -> String {
    line.chars().skip(from).take(to - from).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Recipe;

    const TEXT: &str = "\
# A recipe.
name: plate
subject: sawtooth
unstated: fixed

laser:            # the laser
  waist_mm: {uniform: [0.05, 0.2]}   # as sold
  # more
  m_squared: 1.3

# Lens and sensor.
camera: {f_number: {log_uniform: [2,
    16]}, blur_um: 2} # a lens
classes: {plate: {share: 1}}
";

    fn edited(text: &str, change: &str) -> String {
        with_key(text, &change.parse().unwrap_or_else(|fault| panic!("{change}: {fault}")))
    }

    fn value(text: &str, class: &str, path: &str) -> Option<crate::Distribution> {
        let recipe = Recipe::parse("test", text).unwrap_or_else(|faults| panic!("{faults}\n{text}"));
        recipe.distribution(class, path).cloned()
    }

    /// Each kind of place takes a value, and nothing else of the text moves.
    #[test]
    fn a_key_is_written_where_it_belongs() {
        for (change, line) in [
            ("laser.waist_mm=0.1", "  waist_mm: 0.1   # as sold"),
            ("laser.power_mw={uniform: [20, 30]}", "  power_mw: {uniform: [20, 30]}"),
            ("camera.blur_um=3", "    16]}, blur_um: 3} # a lens"),
            ("camera.tilt_deg=30", "    16]}, blur_um: 2, tilt_deg: 30} # a lens"),
            ("exposure.time_us=40", "  time_us: 40"),
            ("classes.plate.laser.power_mw=44", "classes: {plate: {share: 1, laser: {power_mw: 44}}}"),
        ] {
            let text = edited(TEXT, change);
            assert!(text.lines().any(|own| own == line), "{change}:\n{text}");
            let (path, wanted) = change.split_once('=').expect("it is a change");
            let path = path.strip_prefix("classes.plate.").unwrap_or(path);
            let other =
                edited("name: plate\nsubject: sawtooth\nunstated: fixed\nclasses:\n  plate: {share: 1}\n", change);
            assert_eq!(value(&text, "plate", path), value(&other, "plate", path), "{wanted}");
            let kept = TEXT.lines().filter(|own| !text.lines().any(|line| line == *own)).count();
            assert!(kept <= 1, "{change} moves other lines:\n{text}");
            for comment in ["# A recipe.", "# the laser", "# as sold", "  # more", "# Lens and sensor.", "# a lens"] {
                assert!(text.contains(comment), "{comment} is lost:\n{text}");
            }
        }
    }

    /// A key that is written and taken out again leaves the text that was there.
    #[test]
    fn what_is_taken_out_leaves_the_text_as_it_was() {
        for (path, change) in [
            ("laser.power_mw", "laser.power_mw=44"),
            ("camera.tilt_deg", "camera.tilt_deg=30"),
            ("classes.plate.laser.power_mw", "classes.plate.laser.power_mw=44"),
        ] {
            let text = edited(TEXT, change);
            assert_ne!(text, TEXT);
            assert_eq!(without_key(&text, path).as_deref(), Some(TEXT), "{path}");
        }
        let text = without_key(TEXT, "camera.f_number").expect("it is there");
        assert!(text.contains("camera: {blur_um: 2} # a lens"), "{text}");
        let text = without_key(TEXT, "laser.waist_mm").expect("it is there");
        assert!(!text.contains("waist_mm") && text.contains("# the laser\n  # more\n"), "{text}");
        assert_eq!(without_key(TEXT, "laser.power_mw"), None);
    }

    /// What the command line has set is changed there, and comments stay.
    #[test]
    fn a_key_that_was_set_is_changed_there() {
        let set = format!("{TEXT}set:\n  laser.waist_mm: 0.2   # by hand\n");
        let text = edited(&set, "laser.waist_mm=0.15");
        assert_eq!(text, set.replace("0.2   #", "0.15   #"));
        assert_eq!(without_key(&text, "laser.waist_mm").as_deref(), Some(TEXT));
        let alias = TEXT.replace("{uniform: [0.05, 0.2]}", "&w {uniform: [0.05, 0.2]}");
        let text = edited(&alias, "laser.waist_mm=0.15");
        assert_eq!(value(&text, "plate", "laser.waist_mm"), Some(crate::Distribution::Fixed(0.15)), "{text}");
    }

    #[test]
    fn a_model_stands_for_its_section() {
        let short = format!("{TEXT}transport: path\n");
        assert!(edited(&short, "transport.model=kernel").ends_with("transport: kernel\n"));
        let long = edited(&short, "transport.photons_per_profile=5000");
        assert!(long.ends_with("transport: {model: path, photons_per_profile: 5000}\n"), "{long}");
        assert!(written_keys(&long).contains("transport.photons_per_profile"));
    }

    #[test]
    fn keys_that_are_written_are_told() {
        let written: Vec<String> =
            written_keys(&format!("{TEXT}set: {{exposure.time_us: 40}}\n")).into_iter().collect();
        let wanted = ["camera.blur_um", "camera.f_number", "classes.plate.share", "exposure.time_us"];
        assert_eq!(written[..4], wanted);
        assert!(written.iter().any(|path| path == "laser.waist_mm"), "{written:?}");
    }
}
