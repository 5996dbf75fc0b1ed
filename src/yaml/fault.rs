//! What is wrong with a file: where, what, and what to do; all of it at once.

use std::fmt;

use super::node::Place;

/// Longest piece of a source line that a fault shows [characters].
const EXCERPT: usize = 110;

/// Everything that is wrong with one text.
#[derive(Debug, Clone, PartialEq)]
pub struct Faults {
    /// Where the text comes from, usually a path.
    pub origin: String,
    /// The faults by place.
    pub list: Vec<Fault>,
    /// Faults beyond those listed.
    pub unlisted: usize,
}

/// One thing that is wrong.
#[derive(Debug, Clone, PartialEq)]
pub struct Fault {
    /// Line, from 1.
    pub line: usize,
    /// Column, from 1 [characters].
    pub column: usize,
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

impl Fault {
    /// A fault at `place` of `text`.
    pub(crate) fn new(text: &str, place: Place, key: &str, problem: String, remedy: String) -> Self {
        let line = text.lines().nth(place.line - 1).unwrap_or_default();
        let skipped = if line.chars().count() <= EXCERPT { 0 } else { (place.column - 1).saturating_sub(EXCERPT / 2) };
        let shown = line.chars().skip(skipped).take(EXCERPT);
        let excerpt = Excerpt {
            text: shown.map(|c| if c.is_control() { ' ' } else { c }).collect(),
            caret: (place.column - 1 - skipped).min(EXCERPT),
        };
        Self { line: place.line, column: place.column, key: key.to_owned(), problem, remedy, excerpt }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        if !self.key.is_empty() {
            write!(f, "{}: ", self.key)?;
        }
        write!(f, "{}", self.problem)?;
        if self.remedy.is_empty() { Ok(()) } else { write!(f, "; {}", self.remedy) }
    }
}

impl fmt::Display for Faults {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let count = self.list.len() + self.unlisted;
        writeln!(f, "{} has {count} fault{}:", self.origin, if count == 1 { "" } else { "s" })?;
        for fault in &self.list {
            writeln!(f, "{}:{}:{}: {fault}", self.origin, fault.line, fault.column)?;
            if !fault.excerpt.text.trim().is_empty() {
                writeln!(f, "{:>6} | {}", fault.line, fault.excerpt.text.trim_end())?;
                writeln!(f, "       | {}^", " ".repeat(fault.excerpt.caret))?;
            }
        }
        if self.unlisted > 0 {
            writeln!(f, "and {} more", self.unlisted)?;
        }
        Ok(())
    }
}

impl std::error::Error for Faults {}

/// The one of `known` that is spelt most like `name`, where one is like it at all.
pub(crate) fn nearest<'k>(name: &str, known: impl IntoIterator<Item = &'k str>) -> Option<&'k str> {
    /// Share of characters that must agree.
    const ALIKE: f64 = 0.55;
    /// Beyond this nobody meant a key [bytes].
    const LONGEST: usize = 64;
    if name.len() > LONGEST {
        return None;
    }
    let name = name.to_lowercase().replace('-', "_");
    let likeness = |known: &str| strsim::normalized_damerau_levenshtein(&name, &known.replace('-', "_"));
    let best = known.into_iter().map(|known| (likeness(known), known)).max_by(|a, b| a.0.total_cmp(&b.0))?;
    (best.0 >= ALIKE).then_some(best.1)
}
