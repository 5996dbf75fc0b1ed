//! The text of a recipe with values of some keys replaced: comments, order and all other keys stay as they were.
//!
//! A value is found by the place that the YAML reader gives its node, and ends where its brackets close, its word ends,
//! or, as a block of deeper lines, where lines are no deeper than its key. What can't be replaced in its place
//! (anchors, keys that the command line set) goes to the section `set`, which stands above all others. The result is
//! read again and must say what was asked for.

use crate::changes::{Change, changed_text};
use yaml::{YamlNode, YamlValue, parse_yaml};

/// A value in place of a key's own.
#[derive(Debug, Clone, PartialEq)]
pub struct NewValue {
    /// Path of the key.
    pub key: String,
    /// The value in YAML, in one line.
    pub value: String,
    /// What a comment above it says, where there is one.
    pub comment: Option<String>,
}

/// Where a value stands: line and column of its key and of itself, in characters from 1.
pub(super) struct TextPlace {
    /// Line of the section's key.
    pub section: usize,
    /// The key.
    pub key: (usize, usize),
    /// The value.
    pub value: (usize, usize),
}

/// `text` with the values in place of those of their keys, each with its comment, if it has one, in a line above.
pub fn with_new_values(text: &str, values: &[NewValue]) -> String {
    let mut lines: Vec<String> = text.lines().map(String::from).collect();
    let root = parse_yaml(text, "recipe").ok();
    let set_section = root.as_ref().and_then(|root| entry(root, "set"));
    let (mut edits, mut left) = (Vec::new(), Vec::new());
    for new in values {
        let is_set = set_section.as_ref().is_some_and(|(_, set)| entry(set, &new.key).is_some());
        let place = root.as_ref().filter(|_| !is_set).and_then(|root| place(root, new.key.split('.')));
        match place.and_then(|place| span(&lines, &place).map(|span| (place, span))) {
            Some((place, span)) => edits.push((place, span, new)),
            None => left.push(new),
        }
    }
    // From the end, so that places before an edit stay where they are.
    edits.sort_by_key(|(place, ..)| std::cmp::Reverse(place.value));
    // Line that a comment goes above, in the numbering of the moment.
    let mut comments: Vec<(usize, String)> = Vec::new();
    for (place, (last_line, last_column), new) in edits {
        let (line, column) = (place.value.0 - 1, place.value.1 - 1);
        let chars = |text: &str, from: usize, to: usize| text.chars().skip(from).take(to - from).collect::<String>();
        let before = chars(&lines[line], 0, column);
        let after = chars(&lines[last_line], last_column, usize::MAX);
        let key_line = place.key.0 - 1;
        // A block below its key goes back to the key's line.
        let (first, whole) = if key_line < line {
            (key_line, format!("{} {}{after}", lines[key_line].trim_end(), new.value))
        } else {
            (line, format!("{before}{}{after}", new.value))
        };
        let gone = last_line - first;
        lines.splice(first..=last_line, [whole]);
        comments.iter_mut().filter(|(at, _)| *at > first).for_each(|(at, _)| *at -= gone.min(*at - first));
        let indent = |line: &str| line.chars().take_while(|c| *c == ' ').count();
        // A key inside of a line has its comment above the section.
        let above = if indent(&lines[key_line]) == place.key.1 - 1 { key_line } else { place.section - 1 };
        if let Some(comment) = &new.comment {
            comments.push((above, format!("{}# {}: {comment}", " ".repeat(indent(&lines[above])), new.key)));
        }
    }
    // Those of one line in the order of the text; from the end again.
    comments.sort_by_key(|(line, _)| std::cmp::Reverse(*line));
    for (line, comment) in comments {
        lines.insert(line, comment);
    }
    let mut text = lines.join("\n");
    text.push('\n');
    if left.is_empty() {
        return text;
    }
    let changes: Vec<Change> =
        left.iter().filter_map(|new| format!("{}={}", new.key, new.value).parse().ok()).collect();
    changed_text(&text, &changes)
}

/// The values as sections of a recipe, each below its comment; those of a section one after the other.
pub fn as_sections(values: &[NewValue]) -> String {
    let mut text = String::new();
    let named: Vec<_> = values.iter().filter_map(|new| Some((new.key.split_once('.')?, new))).collect();
    for section in named.chunk_by(|((a, _), _), ((b, _), _)| a == b) {
        text += &format!("{}:\n", section[0].0.0);
        for ((_, key), new) in section {
            let comment = new.comment.as_ref().map(|comment| format!("  # {key}: {comment}\n"));
            text += &format!("{}  {key}: {}\n", comment.unwrap_or_default(), new.value);
        }
    }
    text
}

/// The entry of a map by its name: where its key stands, and its value.
pub(super) fn entry<'n>(node: &'n YamlNode, name: &str) -> Option<((usize, usize), &'n YamlNode)> {
    let YamlValue::Map(entries) = &node.value else { return None };
    let (key, value) = entries.iter().find(|(key, _)| key.name == name)?;
    Some(((key.place.line, key.place.column), value))
}

/// Where the value at a path of names stands.
pub(super) fn place<'n>(root: &YamlNode, names: impl IntoIterator<Item = &'n str>) -> Option<TextPlace> {
    let (mut node, mut key, mut section) = (root, (1, 1), None);
    for name in names {
        (key, node) = entry(node, name)?;
        section.get_or_insert(key.0);
    }
    Some(TextPlace { section: section?, key, value: (node.place.line, node.place.column) })
}

/// Line (from 0) and column (from 0, exclusive) where the value at `place` ends.
pub(super) fn span(lines: &[String], place: &TextPlace) -> Option<(usize, usize)> {
    let (first, column) = (place.value.0 - 1, place.value.1 - 1);
    let text: Vec<char> = lines.get(first)?.chars().collect();
    match text.get(column)? {
        '{' | '[' => closing(lines, first, column),
        // Anchors, aliases, tags, block texts.
        '&' | '*' | '!' | '|' | '>' => None,
        quote @ ('"' | '\'') => {
            let end = text.iter().enumerate().skip(column + 1).find(|(_, c)| *c == quote)?.0;
            Some((first, end + 1))
        }
        _ if place.key.0 < place.value.0 => {
            // A block: all lines that are deeper than the key.
            let depth = place.key.1 - 1;
            let deeper = |line: &String| {
                let blanks = line.chars().take_while(|c| *c == ' ').count();
                line.trim().is_empty() || blanks > depth
            };
            let mut last = first;
            for (i, line) in lines.iter().enumerate().skip(first).take_while(|(_, line)| deeper(line)) {
                if !line.trim().is_empty() && !line.trim_start().starts_with('#') {
                    last = i;
                }
            }
            Some((last, lines[last].chars().count()))
        }
        _ => {
            let is_end = |i: &usize| {
                matches!(text[*i], ',' | '}' | ']') || text[*i] == '#' && text.get(i.wrapping_sub(1)) == Some(&' ')
            };
            let end = (column..text.len()).find(is_end).unwrap_or(text.len());
            let word: String = text[column..end].iter().collect();
            Some((first, column + word.trim_end().chars().count()))
        }
    }
}

/// Where the bracket at a place closes, quotes and comments passed over.
pub(super) fn closing(lines: &[String], first: usize, column: usize) -> Option<(usize, usize)> {
    let (mut depth, mut quote) = (0_i32, None);
    for (i, line) in lines.iter().enumerate().skip(first) {
        let text: Vec<char> = line.chars().collect();
        let from = if i == first { column } else { 0 };
        for j in from..text.len() {
            let c = text[j];
            match quote {
                Some(open) if c == open => quote = None,
                Some(_) => {}
                None => match c {
                    '"' | '\'' => quote = Some(c),
                    '{' | '[' => depth += 1,
                    '}' | ']' => {
                        depth -= 1;
                        if depth == 0 {
                            return Some((i, j + 1));
                        }
                    }
                    '#' if j == 0 || text[j - 1] == ' ' => break,
                    _ => {}
                },
            }
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Distribution, Recipe};

    const TEXT: &str = "\
# A recipe.
name: plate
subject: sawtooth
unstated: fixed

laser:            # the laser
  waist_mm: {uniform: [0.05, 0.2]}   # as sold
  power_mw:
    lognormal:
      median: 50
      log_sd: 0.2
  # more
  m_squared: 1.3
camera: {f_number: {log_uniform: [2,
    16]}, blur_um: {uniform: [0, 3]}} # a lens
classes: {plate: {share: 1}}
";

    fn new(key: &str, value: &str) -> NewValue {
        NewValue { key: key.into(), value: value.into(), comment: Some("fitted".into()) }
    }

    /// Flow values, blocks and values inside of others are replaced; all else stays, comments too.
    #[test]
    fn values_are_replaced_in_their_places() {
        let values = [
            new("laser.waist_mm", "{normal: {mean: 0.1, sd: 0.01}}"),
            new("laser.power_mw", "44"),
            new("camera.f_number", "8"),
            new("camera.blur_um", "{uniform: [1, 2]}"),
        ];
        let text = with_new_values(TEXT, &values);
        let begins = "\
# A recipe.
name: plate
subject: sawtooth
unstated: fixed

laser:            # the laser
  # laser.waist_mm: fitted
  waist_mm: {normal: {mean: 0.1, sd: 0.01}}   # as sold
  # laser.power_mw: fitted
  power_mw: 44
  # more
  m_squared: 1.3
";
        let found = Recipe::parse("test", &text).unwrap_or_else(|faults| panic!("{faults}\n{text}"));
        let of = |path: &str| found.distribution("plate", path).expect("it is a key").clone();
        assert_eq!(of("laser.waist_mm"), Distribution::Normal { mean: 0.1, sd: 0.01 });
        assert_eq!(of("laser.power_mw"), Distribution::Fixed(44.0));
        assert_eq!(of("camera.f_number"), Distribution::Fixed(8.0));
        assert_eq!(of("camera.blur_um"), Distribution::Uniform { min: 1.0, max: 2.0 });
        assert_eq!(of("laser.m_squared"), Distribution::Fixed(1.3));
        assert!(text.starts_with(begins), "{text}");
        assert!(text.contains("# camera.f_number: fitted\n# camera.blur_um: fitted\ncamera: {"), "{text}");
        for comment in ["# A recipe.", "# the laser", "# as sold", "  # more", "# a lens"] {
            assert!(text.contains(comment), "{comment} is lost:\n{text}");
        }
        assert!(!text.contains("log_sd"), "{text}");
    }

    /// As sections of their own, values are what a recipe extends.
    #[test]
    fn sections_hold_the_values_alone() {
        let values = [new("laser.waist_mm", "0.1"), new("laser.power_mw", "44"), new("camera.f_number", "8")];
        let text = "laser:\n  # waist_mm: fitted\n  waist_mm: 0.1\n  # power_mw: fitted\n  power_mw: 44\n\
                    camera:\n  # f_number: fitted\n  f_number: 8\n";
        assert_eq!(as_sections(&values), text);
    }

    /// A key that the command line changed is changed there; one behind an alias goes to `set`.
    #[test]
    fn what_has_no_place_is_set() {
        let set = format!("{TEXT}set:\n  laser.waist_mm: {{uniform: [0.1, 0.3]}}\n");
        let alias = TEXT.replace("{uniform: [0.05, 0.2]}", "&w {uniform: [0.05, 0.2]}");
        for text in [set, alias] {
            let text = with_new_values(&text, &[new("laser.waist_mm", "0.15")]);
            let found = Recipe::parse("test", &text).unwrap_or_else(|faults| panic!("{faults}\n{text}"));
            assert_eq!(found.distribution("plate", "laser.waist_mm"), Some(&Distribution::Fixed(0.15)), "{text}");
        }
    }
}
