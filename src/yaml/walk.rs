//! The walk over the tree: takes keys and values, checks their types and ranges, and collects every fault on the way.

use std::collections::BTreeMap;

use super::fault::{Fault, Faults, nearest};
use super::node::{Key, Node, Place, Value};

/// Faults that are listed; the rest is counted.
const MOST_FAULTS: usize = 100;

/// The collector of faults.
pub(crate) struct Walk<'t> {
    text: &'t str,
    noun: &'static str,
    faults: Vec<Fault>,
    unlisted: usize,
    places: BTreeMap<String, Place>,
}

/// A map of which keys are taken one by one; what is left in the end is unknown.
pub(crate) struct Section<'n> {
    path: String,
    place: Place,
    entries: Vec<&'n (Key, Node)>,
}

impl<'t> Walk<'t> {
    /// A walk over the tree of `text`, which is to be a `noun`.
    pub fn new(text: &'t str, noun: &'static str) -> Self {
        Self { text, noun, faults: Vec::new(), unlisted: 0, places: BTreeMap::new() }
    }

    /// Notes a fault.
    pub fn fault(&mut self, place: Place, key: &str, problem: impl Into<String>, remedy: impl Into<String>) {
        if self.faults.len() < MOST_FAULTS {
            self.faults.push(Fault::new(self.text, place, key, problem.into(), remedy.into()));
        } else {
            self.unlisted += 1;
        }
    }

    /// Notes a fault of several keys together at the first of `keys` that the file has.
    pub fn joint_fault(&mut self, keys: &[String], problem: impl Into<String>, remedy: impl Into<String>) {
        let key = keys.iter().find(|key| self.places.contains_key(*key)).unwrap_or(&keys[0]);
        let place = self.places.get(key).copied().unwrap_or(Place::START);
        self.fault(place, key, problem, remedy);
    }

    /// Whether the file has the key `path`.
    pub fn has(&self, path: &str) -> bool {
        self.places.contains_key(path)
    }

    /// The faults by place, where there are any.
    pub fn finish(self, origin: &str) -> Result<(), Faults> {
        let Self { faults: mut list, unlisted, .. } = self;
        list.sort_by_key(|fault| (fault.line, fault.column));
        if list.is_empty() { Ok(()) } else { Err(Faults { origin: origin.to_owned(), list, unlisted }) }
    }

    /// The map at `node`; a key without a value is an empty one.
    pub fn section<'n>(&mut self, node: &'n Node, path: &str) -> Section<'n> {
        let entries = match &node.value {
            Value::Map(entries) => entries.iter().collect(),
            Value::Nothing => Vec::new(),
            other => {
                self.fault(node.place, path, format!("is {}", other.kind()), "give a map of keys");
                Vec::new()
            }
        };
        Section { path: path.to_owned(), place: node.place, entries }
    }

    /// A finite number.
    pub fn number(&mut self, node: &Node, path: &str, allowed: &str) -> Option<f64> {
        match &node.value {
            Value::Number(number) if number.is_finite() => Some(*number),
            Value::Number(number) => {
                self.fault(
                    node.place,
                    path,
                    format!("is {number}, which is no finite number"),
                    format!("give {allowed}"),
                );
                None
            }
            Value::Text(text) if text.trim().parse::<f64>().is_ok_and(f64::is_finite) => {
                self.fault(node.place, path, "is a text", "remove the quotes to make it a number");
                None
            }
            other => {
                self.fault(node.place, path, format!("is {}", other.kind()), format!("give {allowed}"));
                None
            }
        }
    }

    /// A number from `min` to `max`, whole where `whole`.
    pub fn number_in(&mut self, node: &Node, path: &str, range: Range) -> Option<f64> {
        let allowed = range.to_string();
        let number = self.number(node, path, &allowed)?;
        if number < range.min || number > range.max {
            self.fault(node.place, path, format!("{} is out of range", shown(number)), format!("give {allowed}"));
            return None;
        }
        if range.whole && number.fract() != 0.0 {
            self.fault(node.place, path, format!("{} is not whole", shown(number)), format!("give {allowed}"));
            return None;
        }
        Some(number)
    }

    /// A text.
    pub fn text<'n>(&mut self, node: &'n Node, path: &str, allowed: &str) -> Option<&'n str> {
        if let Value::Text(text) = &node.value {
            return Some(text);
        }
        self.fault(node.place, path, format!("is {}", node.value.kind()), format!("give {allowed}"));
        None
    }

    /// One of `words`.
    pub fn word(&mut self, node: &Node, path: &str, words: &[&'static str]) -> Option<&'static str> {
        let allowed = format!("one of {}", words.join(", "));
        let text = self.text(node, path, &allowed)?;
        let found = words.iter().copied().find(|word| *word == text);
        if found.is_none() {
            self.unknown_word(node.place, path, text, words);
        }
        found
    }

    /// Notes that `text` is none of `words`.
    pub fn unknown_word(&mut self, place: Place, path: &str, text: &str, words: &[&str]) {
        let meant = nearest(text, words.iter().copied());
        let allowed = format!("one of {}", words.join(", "));
        self.fault(place, path, format!("`{}` is unknown", clipped(text)), remedy(meant, &allowed));
    }
}

impl<'n> Section<'n> {
    /// Where the map stands.
    pub fn place(&self) -> Place {
        self.place
    }

    /// Path of the key `name` in it.
    pub fn path_of(&self, name: &str) -> String {
        if self.path.is_empty() { name.to_owned() } else { format!("{}.{name}", self.path) }
    }

    /// Takes the value of `name` where the map has it, and remembers its place for joint faults.
    pub fn take(&mut self, walk: &mut Walk, name: &str) -> Option<&'n Node> {
        let at = self.entries.iter().position(|(key, _)| key.name == name)?;
        let (key, node) = self.entries.remove(at);
        walk.places.insert(self.path_of(name), key.place);
        Some(node)
    }

    /// Whether every key is taken.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// Takes every key that is left.
    pub fn take_all(&mut self) -> Vec<&'n (Key, Node)> {
        std::mem::take(&mut self.entries)
    }

    /// Faults every key that is left; `known` are the keys that there are, `elsewhere` tells where a key belongs.
    pub fn close(self, walk: &mut Walk, known: &[&str], elsewhere: &dyn Fn(&str) -> Option<String>) {
        let of = if self.path.is_empty() { format!("a {}", walk.noun) } else { format!("`{}`", self.path) };
        for (key, _) in &self.entries {
            let name = clipped(&key.name);
            let path = self.path_of(&name);
            let all = format!("keys of {of} are {}", known.join(", "));
            let meant = || nearest(&key.name, known.iter().copied()).map(|meant| remedy(Some(meant), &all));
            let hint = elsewhere(&key.name).or_else(meant).unwrap_or_else(|| all.clone());
            walk.fault(key.place, &path, format!("`{name}` is no key of {of}"), hint);
        }
    }
}

/// The numbers that a key allows.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Range {
    /// Smallest.
    pub min: f64,
    /// Largest.
    pub max: f64,
    /// Whole numbers only.
    pub whole: bool,
    /// Unit, empty for none.
    pub unit: &'static str,
}

impl std::fmt::Display for Range {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        let article = if self.whole { "a whole number" } else { "a number" };
        write!(f, "{article} from {} to {}", shown(self.min), shown(self.max))?;
        if self.unit.is_empty() { Ok(()) } else { write!(f, " {}", self.unit) }
    }
}

/// `did you mean` with the allowed things behind it.
fn remedy(meant: Option<&str>, allowed: &str) -> String {
    meant.map_or_else(|| format!("give {allowed}"), |word| format!("did you mean `{word}`? ({allowed})"))
}

/// A number as people write it.
pub(crate) fn shown(number: f64) -> String {
    let plain = number == 0.0 || (1e-4..1e7).contains(&number.abs());
    if plain { format!("{number}") } else { format!("{number:e}") }
}

/// A text short enough for a message, without control characters.
pub(crate) fn clipped(text: &str) -> String {
    const LONGEST: usize = 64;
    let clean = text.chars().take(LONGEST).map(|c| if c.is_control() { ' ' } else { c });
    clean.chain(text.chars().nth(LONGEST).map(|_| '…')).collect()
}
