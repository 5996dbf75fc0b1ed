//! Faults of a file: where, what, and what to do; all of them at once.

use std::fmt;

use super::node::TextPosition;

/// Longest piece of a source line that a fault shows [characters].
const MAX_EXCERPT_CHARS: usize = 110;

/// Everything that is wrong with one text.
#[derive(Debug, Clone, PartialEq)]
pub struct YamlFaults {
    /// Where the text comes from, usually a path.
    pub origin: String,
    /// The faults by place.
    pub list: Vec<YamlFault>,
    /// Faults beyond those listed.
    pub unlisted: usize,
    /// First line that does not stand in the text at `origin` but was given on the command line, by `--set`.
    pub set_from: usize,
}

impl YamlFaults {
    /// Whether `fault` is of what was given on the command line.
    pub fn is_set(&self, fault: &YamlFault) -> bool {
        fault.origin.is_none() && fault.place.line >= self.set_from
    }
}

/// One thing that is wrong.
#[derive(Debug, Clone, PartialEq)]
pub struct YamlFault {
    /// Where it stands.
    pub place: TextPosition,
    /// Where the text comes from, unless it is the first.
    pub origin: Option<String>,
    /// Path of the key, for instance `camera.tilt_deg`; empty for the whole file.
    pub key: String,
    /// What is wrong.
    pub problem: String,
    /// What is allowed, or what to do.
    pub remedy: String,
    /// The line of the text.
    excerpt: Excerpt,
}

/// A piece of a line with a caret below one of its characters.
#[derive(Debug, Clone, PartialEq)]
struct Excerpt {
    text: String,
    caret: usize,
}

impl YamlFault {
    /// A fault at `place` of `text`.
    pub fn new(text: &str, place: TextPosition, key: &str, problem: String, remedy: String) -> Self {
        let line = text.lines().nth(place.line - 1).unwrap_or_default();
        let skipped = if line.chars().count() <= MAX_EXCERPT_CHARS {
            0
        } else {
            (place.column - 1).saturating_sub(MAX_EXCERPT_CHARS / 2)
        };
        let shown = line.chars().skip(skipped).take(MAX_EXCERPT_CHARS);
        let excerpt = Excerpt {
            text: shown.map(|c| if c.is_control() { ' ' } else { c }).collect(),
            caret: (place.column - 1 - skipped).min(MAX_EXCERPT_CHARS),
        };
        Self { place, origin: None, key: key.to_owned(), problem, remedy, excerpt }
    }
}

impl fmt::Display for YamlFault {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        if !self.key.is_empty() {
            write!(f, "{}: ", self.key)?;
        }
        write!(f, "{}", self.problem)?;
        if self.remedy.is_empty() { Ok(()) } else { write!(f, "; {}", self.remedy) }
    }
}

impl fmt::Display for YamlFaults {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let count = self.list.len() + self.unlisted;
        writeln!(f, "{} has {count} fault{}:", self.origin, if count == 1 { "" } else { "s" })?;
        for fault in &self.list {
            let TextPosition { line, column, .. } = fault.place;
            let is_set = self.is_set(fault);
            if is_set {
                writeln!(f, "--set {fault}")?;
            } else {
                writeln!(f, "{}:{line}:{column}: {fault}", fault.origin.as_ref().unwrap_or(&self.origin))?;
            }
            if !fault.excerpt.text.trim().is_empty() {
                let line = if is_set { "--set".to_owned() } else { line.to_string() };
                writeln!(f, "{line:>6} | {}", fault.excerpt.text.trim_end())?;
                writeln!(f, "       | {}^", " ".repeat(fault.excerpt.caret))?;
            }
        }
        if self.unlisted > 0 {
            writeln!(f, "and {} more", self.unlisted)?;
        }
        if self.list.iter().any(|fault| fault.origin.is_some()) {
            writeln!(f, "{} can replace what it inherits, or remove it: `key: null`", self.origin)?;
        }
        Ok(())
    }
}

impl std::error::Error for YamlFaults {}

/// The one of `known` that is spelt most like `name`, where one is like it at all.
pub fn nearest_spelling<'k>(name: &str, known: impl IntoIterator<Item = &'k str>) -> Option<&'k str> {
    /// Share of characters that must agree.
    const MIN_LIKENESS: f64 = 0.55;
    /// Beyond this nobody meant a key [bytes].
    const MAX_NAME_BYTES: usize = 64;
    if name.len() > MAX_NAME_BYTES {
        return None;
    }
    let name = name.to_lowercase().replace('-', "_");
    let likeness = |known: &str| {
        let known = known.replace('-', "_");
        // A key of which the unit is missing is meant more surely than one of other letters.
        let lacks_end = known.strip_prefix(&name).is_some_and(|end| end.starts_with('_'));
        if lacks_end { 0.9 } else { strsim::normalized_damerau_levenshtein(&name, &known) }
    };
    let best = known.into_iter().map(|known| (likeness(known), known)).max_by(|a, b| a.0.total_cmp(&b.0))?;
    (best.0 >= MIN_LIKENESS).then_some(best.1)
}
