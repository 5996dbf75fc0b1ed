//! Reader of YAML files: from bytes to text; from the tree to keys and values of the right types and ranges; and every
//! fault that is found on the way.

use std::collections::BTreeMap;
use std::path::Path;

use super::fault::{YamlFault, YamlFaults, nearest_spelling};
use super::node::{MAX_FILE_BYTES, TextPosition, YamlKey, YamlNode, YamlValue};

/// Faults that are listed; the rest is counted.
const MAX_LISTED_FAULTS: usize = 100;

/// Takes keys and values from a tree, and collects the faults.
#[derive(Clone)]
pub struct YamlReader<'t> {
    text: &'t str,
    others: Vec<OtherText>,
    noun: &'static str,
    faults: Vec<YamlFault>,
    unlisted: usize,
    set_from: usize,
    places: BTreeMap<String, TextPosition>,
    /// Keys of joint faults, in a trial.
    tried: Option<Vec<String>>,
}

/// A text that is read with the first one, and where it comes from.
#[derive(Clone)]
struct OtherText {
    origin: String,
    text: String,
}

/// A map of which keys are taken one by one; what is left in the end is unknown.
pub struct Mapping<'n> {
    path: String,
    place: TextPosition,
    entries: Vec<&'n (YamlKey, YamlNode)>,
}

impl<'t> YamlReader<'t> {
    /// A reader of the tree of `text`, which is to be a `noun`.
    pub fn new(text: &'t str, noun: &'static str) -> Self {
        let (others, faults) = (Vec::new(), Vec::new());
        Self { text, others, noun, faults, unlisted: 0, set_from: usize::MAX, places: BTreeMap::new(), tried: None }
    }

    /// Reads with the first text another one, which comes from `origin`; places in it have this number.
    pub fn add_text(&mut self, origin: String, text: String) -> usize {
        self.others.push(OtherText { origin, text });
        self.others.len()
    }

    /// The same where the lines from `line` on were given on the command line, by `--set`.
    pub fn set_from(self, line: usize) -> Self {
        Self { set_from: line, ..self }
    }

    /// Notes a fault.
    pub fn fault(&mut self, place: TextPosition, key: &str, problem: impl Into<String>, remedy: impl Into<String>) {
        if self.faults.len() < MAX_LISTED_FAULTS {
            let other = place.text.checked_sub(1).and_then(|at| self.others.get(at));
            let text = other.map_or(self.text, |other| &other.text);
            let mut fault = YamlFault::new(text, place, key, problem.into(), remedy.into());
            fault.origin = other.map(|other| other.origin.clone());
            self.faults.push(fault);
        } else {
            self.unlisted += 1;
        }
    }

    /// Notes a fault, which leaves no value.
    pub fn refuse<T>(
        &mut self,
        place: TextPosition,
        key: &str,
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Option<T> {
        self.fault(place, key, problem, remedy);
        None
    }

    /// Notes that a node is something else than what is `allowed`.
    pub fn refuse_kind<T>(&mut self, node: &YamlNode, path: &str, allowed: &str) -> Option<T> {
        self.refuse(node.place, path, format!("is {}", node.value.kind()), format!("give {allowed}"))
    }

    /// The keys of the joint faults that `check` would note; none is noted.
    pub fn keys_at_fault(&self, check: impl FnOnce(&mut Self)) -> Vec<String> {
        let mut trial = Self { tried: Some(Vec::new()), ..self.clone() };
        check(&mut trial);
        trial.tried.unwrap_or_default()
    }

    /// Notes a fault of several keys together at the first of `keys` that the file has.
    pub fn joint_fault(&mut self, keys: &[impl AsRef<str>], problem: impl Into<String>, remedy: impl Into<String>) {
        let mut keys = keys.iter().map(AsRef::as_ref);
        if let Some(tried) = &mut self.tried {
            tried.extend(keys.map(str::to_owned));
            return;
        }
        let first = keys.clone().next().unwrap_or_default();
        let key = keys.find(|key| self.places.contains_key(*key)).unwrap_or(first);
        let place = self.places.get(key).copied().unwrap_or(TextPosition::START);
        self.fault(place, key, problem, remedy);
    }

    /// Notes that the key `path`, which the file has, stands for the key `other`: joint faults of that are found there.
    pub fn stands_for(&mut self, path: &str, other: &str) {
        if let Some(place) = self.places.get(path).copied() {
            self.places.insert(other.to_owned(), place);
        }
    }

    /// Whether any fault was noted.
    pub fn has_faults(&self) -> bool {
        !self.faults.is_empty()
    }

    /// Whether the file has the key `path`.
    pub fn has(&self, path: &str) -> bool {
        self.places.contains_key(path)
    }

    /// Whether a fault was noted of the key `path`, of what stands in it, or of the same key of a section further in.
    pub fn has_fault_of(&self, path: &str) -> bool {
        self.faults.iter().any(|fault| format!(".{}.", fault.key).contains(&format!(".{path}.")))
    }

    /// The faults by place, where there are any.
    pub fn finish(self, origin: &str) -> Result<(), YamlFaults> {
        let Self { faults: mut list, unlisted, set_from, .. } = self;
        list.sort_by_key(|fault| (fault.place.text, fault.place.line, fault.place.column));
        if list.is_empty() { Ok(()) } else { Err(YamlFaults { origin: origin.to_owned(), list, unlisted, set_from }) }
    }

    /// The map at `node`; a key without a value is an empty one.
    pub fn mapping<'n>(&mut self, node: &'n YamlNode, path: &str) -> Mapping<'n> {
        let entries = match &node.value {
            YamlValue::Map(entries) => entries.iter().collect(),
            YamlValue::Nothing => Vec::new(),
            other => {
                self.fault(node.place, path, format!("is {}", other.kind()), "give a map of keys");
                Vec::new()
            }
        };
        Mapping { path: path.to_owned(), place: node.place, entries }
    }

    /// A finite number.
    pub fn number(&mut self, node: &YamlNode, path: &str, allowed: &str) -> Option<f64> {
        match &node.value {
            YamlValue::Number(number) if number.is_finite() => Some(*number),
            YamlValue::Number(number) => {
                let problem = format!("is {number}, which is no finite number");
                self.refuse(node.place, path, problem, format!("give {allowed}"))
            }
            YamlValue::Text(text) if text.trim().parse::<f64>().is_ok_and(f64::is_finite) => {
                self.refuse(node.place, path, "is a text", "remove the quotes to make it a number")
            }
            _ => self.refuse_kind(node, path, allowed),
        }
    }

    /// A number from `min` to `max`, whole where `whole`.
    pub fn number_in(&mut self, node: &YamlNode, path: &str, range: NumberRange) -> Option<f64> {
        let allowed = range.to_string();
        let number = self.number(node, path, &allowed)?;
        if number < range.min || number > range.max {
            let problem = format!("{} is out of range", number_text(number));
            return self.refuse(node.place, path, problem, format!("give {allowed}"));
        }
        if range.whole && number.fract() != 0.0 {
            let share = if number > 0.0 && number < 1.0 && range.max > 1.0 {
                "; it counts things and is no share of them"
            } else {
                ""
            };
            let problem = format!("{} is not whole", number_text(number));
            return self.refuse(node.place, path, problem, format!("give {allowed}{share}"));
        }
        Some(number)
    }

    /// A text.
    pub fn text<'n>(&mut self, node: &'n YamlNode, path: &str, allowed: &str) -> Option<&'n str> {
        match &node.value {
            YamlValue::Text(text) => Some(text),
            _ => self.refuse_kind(node, path, allowed),
        }
    }

    /// A list.
    pub fn list<'n>(&mut self, node: &'n YamlNode, path: &str, allowed: &str) -> Option<&'n [YamlNode]> {
        match &node.value {
            YamlValue::List(entries) => Some(entries),
            _ => self.refuse_kind(node, path, allowed),
        }
    }

    /// A flag.
    pub fn flag(&mut self, node: &YamlNode, path: &str) -> Option<bool> {
        match node.value {
            YamlValue::Flag(flag) => Some(flag),
            _ => self.refuse_kind(node, path, "true or false"),
        }
    }

    /// One of `words`.
    pub fn word(&mut self, node: &YamlNode, path: &str, words: &[&'static str]) -> Option<&'static str> {
        let allowed = format!("one of {}", words.join(", "));
        let text = self.text(node, path, &allowed)?;
        let found = words.iter().copied().find(|word| *word == text);
        found.or_else(|| self.unknown_word(node.place, path, text, words))
    }

    /// Notes that `text` is none of `words`.
    pub fn unknown_word<T>(&mut self, place: TextPosition, path: &str, text: &str, words: &[&str]) -> Option<T> {
        let meant = nearest_spelling(text, words.iter().copied());
        let allowed = format!("one of {}", words.join(", "));
        self.refuse(place, path, format!("`{}` is unknown", clipped_text(text)), remedy(meant, &allowed))
    }
}

impl<'n> Mapping<'n> {
    /// Where the map stands.
    pub fn place(&self) -> TextPosition {
        self.place
    }

    /// Path of the key `name` in it.
    pub fn path_of(&self, name: &str) -> String {
        if self.path.is_empty() { name.to_owned() } else { format!("{}.{name}", self.path) }
    }

    /// Takes the value of `name` where the map has it, and remembers its place for joint faults.
    pub fn take(&mut self, yaml: &mut YamlReader, name: &str) -> Option<&'n YamlNode> {
        let at = self.entries.iter().position(|(key, _)| key.name == name)?;
        let (key, node) = self.entries.remove(at);
        yaml.places.insert(self.path_of(name), key.place);
        Some(node)
    }

    /// Whether every key is taken.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// Takes every key that is left.
    pub fn take_all(&mut self) -> Vec<&'n (YamlKey, YamlNode)> {
        std::mem::take(&mut self.entries)
    }

    /// Faults every key that is left; `known` are the keys that there are, `elsewhere` tells where a key belongs.
    pub fn close(self, yaml: &mut YamlReader, known: &[&str], elsewhere: &dyn Fn(&str) -> Option<String>) {
        let of = if self.path.is_empty() { format!("a {}", yaml.noun) } else { format!("`{}`", self.path) };
        for (key, _) in &self.entries {
            let name = clipped_text(&key.name);
            let path = self.path_of(&name);
            let all = format!("keys of {of} are {}", known.join(", "));
            let meant = || nearest_spelling(&key.name, known.iter().copied()).map(|meant| remedy(Some(meant), &all));
            let hint = elsewhere(&key.name).or_else(meant).unwrap_or_else(|| all.clone());
            yaml.fault(key.place, &path, format!("`{name}` is no key of {of}"), hint);
        }
    }
}

/// The numbers that a key allows.
#[derive(Debug, Clone, Copy)]
pub struct NumberRange {
    /// Smallest.
    pub min: f64,
    /// Largest.
    pub max: f64,
    /// Whole numbers only.
    pub whole: bool,
    /// Unit, empty for none.
    pub unit: &'static str,
}

impl std::fmt::Display for NumberRange {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        let article = if self.whole { "a whole number" } else { "a number" };
        write!(f, "{article} from {} to {}", number_text(self.min), number_text(self.max))?;
        if self.unit.is_empty() { Ok(()) } else { write!(f, " {}", self.unit) }
    }
}

/// `did you mean` with the allowed things behind it.
fn remedy(meant: Option<&str>, allowed: &str) -> String {
    meant.map_or_else(|| format!("give {allowed}"), |word| format!("did you mean `{word}`? ({allowed})"))
}

/// A number as people write it.
pub fn number_text(number: f64) -> String {
    let plain = number == 0.0 || (1e-4..1e7).contains(&number.abs());
    if plain { format!("{number}") } else { format!("{number:e}") }
}

/// A text short enough for a message, without control characters.
pub fn clipped_text(text: &str) -> String {
    const MAX_CHARS: usize = 64;
    let clean = text.chars().take(MAX_CHARS).map(|c| if c.is_control() { ' ' } else { c });
    clean.chain(text.chars().nth(MAX_CHARS).map(|_| '…')).collect()
}

/// The bytes of a plain file, as far as it takes to see that they are too many.
pub fn read_bytes(path: &Path) -> std::io::Result<Vec<u8>> {
    files::read_start(path, MAX_FILE_BYTES as u64 + 1)
}

/// The same of standard input where the path is `-`.
pub fn read_bytes_or_standard_input(path: &Path) -> std::io::Result<Vec<u8>> {
    files::read_start_or_standard_input(path, MAX_FILE_BYTES as u64 + 1)
}

/// The bytes as text of what is to be a `noun`; the first byte that is none is a fault at its place.
pub fn utf8_text(origin: &str, bytes: Vec<u8>, noun: &'static str) -> Result<String, YamlFaults> {
    if bytes.len() > MAX_FILE_BYTES {
        // Cut off in the middle of a letter, perhaps; the parser refuses the length.
        return Ok(String::from_utf8_lossy(&bytes).into_owned());
    }
    String::from_utf8(bytes).or_else(|error| {
        let good = String::from_utf8_lossy(&error.as_bytes()[..error.utf8_error().valid_up_to()]).into_owned();
        let column = good.rsplit('\n').next().unwrap_or_default().chars().count() + 1;
        let place = TextPosition { line: good.matches('\n').count() + 1, column, ..TextPosition::START };
        let mut yaml = YamlReader::new(&good, noun);
        yaml.fault(place, "", "is no UTF-8", format!("save the {noun} as UTF-8 text"));
        yaml.finish(origin).map(|()| good)
    })
}
