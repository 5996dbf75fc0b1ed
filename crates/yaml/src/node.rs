//! Syntax tree of a YAML file, in which every key and value knows its place; nothing here knows what it means.

use std::fmt;

use serde::Deserialize;
use serde::de::{Deserializer, Error, MapAccess, SeqAccess, Visitor};
use serde_saphyr::budget::BudgetBreach;
use serde_saphyr::options::{DuplicateKeyPolicy, NonFiniteFloatPolicy};
use serde_saphyr::{Location, Spanned};

/// Longest file that is read [bytes]; the longest of the embedded recipes has a hundredth of it.
pub const MAX_FILE_BYTES: usize = 1 << 20;
/// Deepest nesting; a recipe needs 9 (`classes`, class, group, parameter, `truncated`, `of`, `choice`, `values`,
/// value).
const MAX_DEPTH: usize = 24;
/// Most keys, values and list entries, those repeated by aliases included.
const MAX_NODES: usize = 50_000;
/// Most anchors, aliases and merge keys each.
const MAX_ALIASES: usize = 256;

/// A place in a text, or in one of several that are read as one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TextPosition {
    /// Which of the reader's texts, from 0.
    pub text: usize,
    /// Line, from 1.
    pub line: usize,
    /// Column, from 1 [characters].
    pub column: usize,
}

impl TextPosition {
    /// The first character of the file.
    pub const START: Self = Self { text: 0, line: 1, column: 1 };
}

impl From<Location> for TextPosition {
    fn from(location: Location) -> Self {
        let from_one = |n: u64| usize::try_from(n).unwrap_or(usize::MAX).max(1);
        Self { text: 0, line: from_one(location.line()), column: from_one(location.column()) }
    }
}

/// A value with its place.
#[derive(Debug, Clone)]
pub struct YamlNode {
    /// Where it stands; for an alias, where the alias stands.
    pub place: TextPosition,
    /// What stands there.
    pub value: YamlValue,
}

impl YamlNode {
    /// The same as the tree of another one of the reader's texts.
    #[must_use]
    pub fn in_text(self, text: usize) -> Self {
        let place = TextPosition { text, ..self.place };
        let value = match self.value {
            YamlValue::List(list) => YamlValue::List(list.into_iter().map(|entry| entry.in_text(text)).collect()),
            YamlValue::Map(map) => {
                let key = |key: YamlKey| YamlKey { place: TextPosition { text, ..key.place }, ..key };
                YamlValue::Map(map.into_iter().map(|(own, node)| (key(own), node.in_text(text))).collect())
            }
            other => other,
        };
        Self { place, value }
    }
}

/// A key with its place.
#[derive(Debug, Clone)]
pub struct YamlKey {
    /// Where it stands.
    pub place: TextPosition,
    /// What it says.
    pub name: String,
}

/// What YAML can say.
#[derive(Debug, Clone)]
pub enum YamlValue {
    /// `null`, `~` or nothing at all.
    Nothing,
    /// `true` or `false`.
    Flag(bool),
    /// A number, whole or not; counts up to 2^53 are exact.
    Number(f64),
    /// A text, quoted or not.
    Text(String),
    /// A list.
    List(Vec<YamlNode>),
    /// A map in the order of the file; keys are unique.
    Map(Vec<(YamlKey, YamlNode)>),
}

impl YamlValue {
    /// What it is, in words.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Nothing => "nothing",
            Self::Flag(_) => "true or false",
            Self::Number(_) => "a number",
            Self::Text(_) => "a text",
            Self::List(_) => "a list",
            Self::Map(_) => "a map",
        }
    }
}

/// Why a text is no YAML that we read.
pub struct YamlError {
    /// Where the reading stopped.
    pub place: TextPosition,
    /// What is wrong there.
    pub problem: String,
    /// What to do.
    pub remedy: String,
}

/// Reads `text`, which is to be a `noun`, as one YAML document.
pub fn parse_yaml(text: &str, noun: &'static str) -> Result<YamlNode, YamlError> {
    if text.len() > MAX_FILE_BYTES {
        let problem = format!("the file is longer than {MAX_FILE_BYTES} bytes, and no {noun} is");
        return Err(YamlError { place: TextPosition::START, problem, remedy: "write it more plainly".to_owned() });
    }
    let options = serde_saphyr::options! {
        budget: serde_saphyr::budget! {
            flow_nesting_limit: MAX_DEPTH,
            max_depth: MAX_DEPTH,
            max_nodes: MAX_NODES,
            max_events: 4 * MAX_NODES,
            max_aliases: MAX_ALIASES,
            max_anchors: MAX_ALIASES,
            max_merge_keys: MAX_ALIASES,
            max_recorded_anchor_events: MAX_NODES,
            max_documents: 1,
        },
        alias_limits: serde_saphyr::alias_limits! {
            max_total_replayed_events: MAX_NODES,
            max_replay_stack_depth: MAX_DEPTH,
        },
        duplicate_keys: DuplicateKeyPolicy::Error,
        non_finite_float_policy: NonFiniteFloatPolicy::PassThrough,
        strict_booleans: true,
        reject_unsupported_tags: true,
        with_snippet: false,
    };
    serde_saphyr::from_str_with_options(text, options).map_err(|error| {
        let place = error.location().map_or(TextPosition::START, TextPosition::from);
        let (problem, remedy) = words(&error, noun);
        // The reader names the value that it was reading when it met the tab.
        let place = if problem.contains("tab") { tab(text, place).unwrap_or(place) } else { place };
        let problem = match section(text, place) {
            Some(section) => format!("{problem}, in `{section}`"),
            None => problem,
        };
        YamlError { place, problem, remedy }
    })
}

/// A budget is exhausted.
fn too_much(noun: &str) -> (String, String) {
    (format!("more nesting, values or aliases than any {noun} needs"), "write it more plainly".to_owned())
}

/// What the reader stumbled over, and what to do about it.
fn words(error: &serde_saphyr::Error, noun: &str) -> (String, String) {
    use serde_saphyr::Error;
    match error {
        Error::DuplicateMappingKey { key: Some(key), .. } => {
            (format!("key `{key}` stands here twice"), "remove one of them".to_owned())
        }
        Error::DuplicateMappingKey { .. } => ("a key stands here twice".to_owned(), "remove one of them".to_owned()),
        Error::MultipleDocuments { .. } | Error::Budget { breach: BudgetBreach::Documents { .. }, .. } => {
            ("a second document begins".to_owned(), format!("keep one {noun} in a file"))
        }
        Error::Budget { .. }
        | Error::AliasReplayLimitExceeded { .. }
        | Error::AliasExpansionLimitExceeded { .. }
        | Error::AliasReplayStackDepthExceeded { .. } => too_much(noun),
        // Within an alias, the reader hands its refusals on as text.
        other => match without_place(&other.to_string()) {
            text if text.starts_with("budget breached") => too_much(noun),
            text => {
                let remedy = remedy(&text).to_owned();
                (text, remedy)
            }
        },
    }
}

/// What to do about a problem that the reader has no remedy for.
fn remedy(problem: &str) -> &'static str {
    /// Words of a problem, and its remedy; the first that fits counts.
    const REMEDIES: [(&[&str], &str); 6] = [
        (&["tab"], "indent with blanks: YAML takes no tab there"),
        (&["quote"], "end the text with the quote that it begins with"),
        (
            &["unclosed", "bracket", "flow mapping", "flow sequence", "EOF", "unexpected eof"],
            "close each `{` with `}` and each `[` with `]`, and put commas between their entries",
        ),
        (&["':' must be followed", "':' may not precede"], "put a blank behind the colon"),
        (
            &[
                "indent",
                "expected key",
                "mapping values",
                "mapping keys",
                "simple key",
                "block mapping",
                "node content",
            ],
            "write each key as `key: value`, keys of one section in the same column, right of the section's name",
        ),
        (&["anchor", "alias"], "write the value itself, or give the anchor `&name` above"),
    ];
    let fits = |words: &[&str]| words.iter().any(|word| problem.contains(word));
    REMEDIES.iter().find(|(words, _)| fits(words)).map_or("correct the YAML here", |(_, remedy)| remedy)
}

/// The first tab from `place` on.
fn tab(text: &str, place: TextPosition) -> Option<TextPosition> {
    let mut lines = text.lines().enumerate().skip(place.line - 1);
    lines.find_map(|(number, line)| {
        let column = line.chars().position(|c| c == '\t')? + 1;
        Some(TextPosition { line: number + 1, column, ..place })
    })
}

/// The key at the left edge that stands last above `place`.
fn section(text: &str, place: TextPosition) -> Option<String> {
    let name = |line: &str| -> Option<String> {
        let (name, _) = line.split_once(':')?;
        let plain = !name.is_empty() && name.bytes().all(|c| c.is_ascii_alphanumeric() || b"_-".contains(&c));
        plain.then(|| name.to_owned())
    };
    text.lines().take(place.line - 1).filter_map(name).last()
}

/// The reader's first line without the place it ends in, which a fault shows in front.
fn without_place(message: &str) -> String {
    let line = message.lines().next().unwrap_or_default();
    let end = line.find(" at line ").unwrap_or(line.len());
    let start = line.find("error: ").map_or(0, |i| i + "error: ".len());
    line.get(start..end).unwrap_or(line).to_owned()
}

impl<'de> Deserialize<'de> for YamlNode {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let spanned = Spanned::<YamlValue>::deserialize(deserializer)?;
        Ok(Self { place: spanned.referenced.into(), value: spanned.value })
    }
}

impl<'de> Deserialize<'de> for YamlKey {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let spanned = Spanned::<String>::deserialize(deserializer)?;
        Ok(Self { place: spanned.referenced.into(), name: spanned.value })
    }
}

impl<'de> Deserialize<'de> for YamlValue {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(AnyValue)
    }
}

/// Takes whatever the reader finds.
struct AnyValue;

impl<'de> Visitor<'de> for AnyValue {
    type Value = YamlValue;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a number, a text, true, false, a list or a map")
    }

    fn visit_unit<E: Error>(self) -> Result<YamlValue, E> {
        Ok(YamlValue::Nothing)
    }

    fn visit_none<E: Error>(self) -> Result<YamlValue, E> {
        Ok(YamlValue::Nothing)
    }

    fn visit_bool<E: Error>(self, flag: bool) -> Result<YamlValue, E> {
        Ok(YamlValue::Flag(flag))
    }

    fn visit_i64<E: Error>(self, number: i64) -> Result<YamlValue, E> {
        Ok(YamlValue::Number(number as f64))
    }

    fn visit_u64<E: Error>(self, number: u64) -> Result<YamlValue, E> {
        Ok(YamlValue::Number(number as f64))
    }

    fn visit_i128<E: Error>(self, number: i128) -> Result<YamlValue, E> {
        Ok(YamlValue::Number(number as f64))
    }

    fn visit_u128<E: Error>(self, number: u128) -> Result<YamlValue, E> {
        Ok(YamlValue::Number(number as f64))
    }

    fn visit_f64<E: Error>(self, number: f64) -> Result<YamlValue, E> {
        // Adding zero turns -0 into 0, so that the two have one meaning and one hash.
        Ok(YamlValue::Number(number + 0.0))
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<YamlValue, E> {
        Ok(YamlValue::Text(text.to_owned()))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut entries: A) -> Result<YamlValue, A::Error> {
        let mut list = Vec::new();
        while let Some(entry) = entries.next_element()? {
            list.push(entry);
        }
        Ok(YamlValue::List(list))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut entries: A) -> Result<YamlValue, A::Error> {
        let mut map = Vec::new();
        while let Some(entry) = entries.next_entry()? {
            map.push(entry);
        }
        Ok(YamlValue::Map(map))
    }
}
