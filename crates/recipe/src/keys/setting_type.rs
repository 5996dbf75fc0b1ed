//! Types of settings: what values one can have, read from YAML, written as JSON, told in words and as JSON Schema.

use base::Words;
use serde_json::{Value as Json, json};

use crate::asset::{Asset, BuiltIn};
use crate::asset_source::{AssetRequest, AssetSource};
use optical_bench::settings::{Channel, SensorStack};
use yaml::{NumberRange, YamlNode, YamlReader, YamlValue, nearest_spelling, number_text};

/// The values that a setting may have.
pub(crate) trait SettingType {
    /// What a setting is.
    type Value;

    /// Reads the value at `node`; faults are noted and give `None`.
    fn read(&self, yaml: &mut YamlReader, node: &YamlNode, path: &str) -> Option<Self::Value>;

    /// Reads what of `value` lies in another file; faults are noted.
    fn load(&self, _value: &mut Self::Value, _yaml: &mut YamlReader, _path: &str, _files: &AssetSource) {}

    /// The value as JSON, which is how a recipe writes it too.
    fn json(&self, value: &Self::Value) -> Json;

    /// The same in the canonical form; `None` where it is left out.
    fn canonical(&self, value: &Self::Value) -> Option<Json> {
        Some(self.json(value))
    }

    /// The file that it names.
    fn asset<'v>(&self, _value: &'v Self::Value) -> Option<&'v Asset> {
        None
    }

    /// Files of the program that it may name; `None` where it names none.
    fn built_in(&self) -> Option<&'static [BuiltIn]> {
        None
    }

    /// What is allowed, in words.
    fn allowed(&self) -> String;

    /// Unit and range in the reference, where they have columns of their own.
    fn unit_and_range(&self) -> Option<(&'static str, String)> {
        None
    }

    /// What is allowed, as JSON Schema.
    fn schema(&self) -> Json;
}

/// An object with `properties`, of which `required` must be there, as JSON Schema.
fn object(properties: &Json, required: &str) -> Json {
    json!({ "type": "object", "required": [required], "additionalProperties": false, "properties": properties })
}

/// A whole number from `min` to `max` of a unit, empty for none.
pub(crate) struct Count(pub usize, pub usize, pub &'static str);

impl Count {
    fn range(&self) -> NumberRange {
        NumberRange { min: self.0 as f64, max: self.1 as f64, whole: true, unit: self.2 }
    }
}

impl SettingType for Count {
    type Value = usize;

    fn read(&self, yaml: &mut YamlReader, node: &YamlNode, path: &str) -> Option<usize> {
        // The range ends far below 2^53, so the number is exact.
        yaml.number_in(node, path, self.range()).map(|number| number as usize)
    }

    fn json(&self, value: &usize) -> Json {
        (*value).into()
    }

    fn allowed(&self) -> String {
        let Self(min, max, unit) = self;
        let blank = if unit.is_empty() { "" } else { " " };
        format!("a whole number from {min} to {max}{blank}{unit}")
    }

    fn unit_and_range(&self) -> Option<(&'static str, String)> {
        Some((self.2, format!("{} to {}", self.0, self.1)))
    }

    fn schema(&self) -> Json {
        json!({ "type": "integer", "minimum": self.0, "maximum": self.1 })
    }
}

/// A whole number from 1 to a most, of what is treated as one; 1 leaves all as it is without it, and is left out of the
/// canonical form.
pub(crate) struct GroupSize(pub usize);

impl SettingType for GroupSize {
    type Value = usize;

    fn read(&self, yaml: &mut YamlReader, node: &YamlNode, path: &str) -> Option<usize> {
        Count(1, self.0, "").read(yaml, node, path)
    }

    fn json(&self, value: &usize) -> Json {
        (*value).into()
    }

    fn canonical(&self, value: &usize) -> Option<Json> {
        (*value > 1).then(|| self.json(value))
    }

    fn allowed(&self) -> String {
        Count(1, self.0, "").allowed()
    }

    fn unit_and_range(&self) -> Option<(&'static str, String)> {
        Count(1, self.0, "").unit_and_range()
    }

    fn schema(&self) -> Json {
        Count(1, self.0, "").schema()
    }
}

/// A number from the first to the second of a unit, empty for none.
pub(crate) struct Number(pub f64, pub f64, pub &'static str);

impl Number {
    fn range(&self) -> NumberRange {
        NumberRange { min: self.0, max: self.1, whole: false, unit: self.2 }
    }
}

impl SettingType for Number {
    type Value = f64;

    fn read(&self, yaml: &mut YamlReader, node: &YamlNode, path: &str) -> Option<f64> {
        yaml.number_in(node, path, self.range())
    }

    fn json(&self, value: &f64) -> Json {
        (*value).into()
    }

    fn allowed(&self) -> String {
        self.range().to_string()
    }

    fn unit_and_range(&self) -> Option<(&'static str, String)> {
        Some((self.2, format!("{} to {}", number_text(self.0), number_text(self.1))))
    }

    fn schema(&self) -> Json {
        json!({ "type": "number", "minimum": self.0, "maximum": self.1 })
    }
}

/// A value of `T`, or `auto`.
pub(crate) struct Auto<T>(pub T);

/// A type that [`Auto`] can stand beside.
pub(crate) trait Noun: SettingType {
    /// What it is called.
    const NOUN: &'static str;
}

impl Noun for Count {
    const NOUN: &'static str = "a whole number";
}

impl Noun for Number {
    const NOUN: &'static str = "a number";
}

impl<T: Noun> SettingType for Auto<T> {
    type Value = Option<T::Value>;

    fn read(&self, yaml: &mut YamlReader, node: &YamlNode, path: &str) -> Option<Option<T::Value>> {
        match &node.value {
            YamlValue::Text(text) if text == "auto" => Some(None),
            YamlValue::Text(text) => yaml.unknown_word(node.place, path, text, &["auto", T::NOUN]),
            _ => self.0.read(yaml, node, path).map(Some),
        }
    }

    fn json(&self, value: &Option<T::Value>) -> Json {
        value.as_ref().map_or_else(|| "auto".into(), |value| self.0.json(value))
    }

    fn allowed(&self) -> String {
        format!("auto or {}", self.0.allowed())
    }

    fn schema(&self) -> Json {
        json!({ "oneOf": [{ "const": "auto" }, self.0.schema()] })
    }
}

/// One of some whole numbers.
pub(crate) struct OneOf(pub &'static [usize]);

impl SettingType for OneOf {
    type Value = usize;

    fn read(&self, yaml: &mut YamlReader, node: &YamlNode, path: &str) -> Option<usize> {
        let allowed = self.allowed();
        let number = yaml.number(node, path, &allowed)?;
        let found = self.0.iter().copied().find(|count| *count as f64 == number);
        let problem = || format!("{number} is not allowed");
        found.or_else(|| yaml.refuse(node.place, path, problem(), format!("give {allowed}")))
    }

    fn json(&self, value: &usize) -> Json {
        (*value).into()
    }

    fn allowed(&self) -> String {
        format!("one of {}", self.0.iter().map(usize::to_string).collect::<Vec<_>>().join(", "))
    }

    fn schema(&self) -> Json {
        json!({ "enum": self.0 })
    }
}

/// `true` or `false`.
pub(crate) struct Flag();

impl SettingType for Flag {
    type Value = bool;

    fn read(&self, yaml: &mut YamlReader, node: &YamlNode, path: &str) -> Option<bool> {
        yaml.flag(node, path)
    }

    fn json(&self, value: &bool) -> Json {
        (*value).into()
    }

    fn allowed(&self) -> String {
        "true or false".to_owned()
    }

    fn schema(&self) -> Json {
        json!({ "type": "boolean" })
    }
}

/// One of some words.
pub(crate) struct Word<T: 'static>(pub &'static [T]);

impl<T: Words> Word<T> {
    fn names(&self) -> Vec<&'static str> {
        self.0.iter().map(|word| word.name()).collect()
    }
}

impl<T: Words> SettingType for Word<T> {
    type Value = T;

    fn read(&self, yaml: &mut YamlReader, node: &YamlNode, path: &str) -> Option<T> {
        yaml.word(node, path, &self.names()).and_then(T::named)
    }

    fn json(&self, value: &T) -> Json {
        value.name().into()
    }

    fn allowed(&self) -> String {
        self.names().join(" or ")
    }

    fn schema(&self) -> Json {
        json!({ "enum": self.names() })
    }
}

/// A list of different words, in the order of their declaration; the list that is given, if one is, is left out of the
/// canonical form.
pub(crate) struct WordList<T: 'static>(pub Option<&'static [T]>);

impl<T: Words> SettingType for WordList<T> {
    type Value = Vec<T>;

    fn read(&self, yaml: &mut YamlReader, node: &YamlNode, path: &str) -> Option<Vec<T>> {
        let mut chosen = Vec::new();
        for entry in yaml.list(node, path, &self.allowed())? {
            let word = yaml.word(entry, path, T::NAMES).and_then(T::named)?;
            if chosen.contains(&word) {
                yaml.fault(entry.place, path, format!("lists `{}` twice", word.name()), "remove one of them");
            } else {
                chosen.push(word);
            }
        }
        Some(T::ALL.iter().copied().filter(|word| chosen.contains(word)).collect())
    }

    fn json(&self, value: &Vec<T>) -> Json {
        value.iter().map(|word| word.name()).collect()
    }

    fn canonical(&self, value: &Vec<T>) -> Option<Json> {
        (Some(value.as_slice()) != self.0).then(|| self.json(value))
    }

    fn allowed(&self) -> String {
        format!("a list of {}", T::NAMES.join(", "))
    }

    fn schema(&self) -> Json {
        json!({ "type": "array", "uniqueItems": true, "items": { "enum": T::NAMES } })
    }
}

/// Images that lie in EXR files too.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum ImageChoice {
    /// Those that the tables do not hold to the last bit.
    Auto,
    /// All.
    All,
    /// These.
    These(Vec<Channel>),
}

/// `auto`, `all` or a list of images.
pub(crate) struct ImageList();

impl ImageList {
    const WORDS: [&'static str; 2] = ["auto", "all"];
    const LIST: WordList<Channel> = WordList(None);
}

impl SettingType for ImageList {
    type Value = ImageChoice;

    fn read(&self, yaml: &mut YamlReader, node: &YamlNode, path: &str) -> Option<ImageChoice> {
        match &node.value {
            YamlValue::Text(text) if text == "auto" => Some(ImageChoice::Auto),
            YamlValue::Text(text) if text == "all" => Some(ImageChoice::All),
            YamlValue::Text(text) => {
                let meant = nearest_spelling(text, Self::WORDS);
                let meant = meant.map(|word| format!("did you mean `{word}`? ")).unwrap_or_default();
                let remedy = format!("{meant}give a list, auto or all");
                yaml.refuse(node.place, path, format!("is {}", node.value.kind()), remedy)
            }
            _ => Self::LIST.read(yaml, node, path).map(ImageChoice::These),
        }
    }

    fn json(&self, value: &ImageChoice) -> Json {
        match value {
            ImageChoice::Auto => "auto".into(),
            ImageChoice::All => "all".into(),
            ImageChoice::These(list) => Self::LIST.json(list),
        }
    }

    fn allowed(&self) -> String {
        format!("auto, all, or {}", Self::LIST.allowed())
    }

    fn schema(&self) -> Json {
        json!({ "oneOf": [{ "enum": Self::WORDS }, Self::LIST.schema()] })
    }
}

/// `none`, `all` or `{every: k}` with k up to a number.
pub(crate) struct StackChoice(pub usize);

impl StackChoice {
    const WORDS: [&'static str; 2] = ["none", "all"];

    fn step(&self) -> Count {
        Count(1, self.0, "")
    }
}

impl SettingType for StackChoice {
    type Value = SensorStack;

    fn read(&self, yaml: &mut YamlReader, node: &YamlNode, path: &str) -> Option<SensorStack> {
        let remedy = "give none, all or {every: k}";
        let meant = match &node.value {
            YamlValue::Text(text) if text == "none" => return Some(SensorStack::None),
            YamlValue::Text(text) if text == "all" => return Some(SensorStack::All),
            YamlValue::Text(text) => nearest_spelling(text, ["none", "all", "every"]),
            _ => None,
        };
        if !matches!(node.value, YamlValue::Map(_)) {
            let meant = meant.map(|word| format!("did you mean `{word}`? ")).unwrap_or_default();
            return yaml.refuse(node.place, path, format!("is {}", node.value.kind()), format!("{meant}{remedy}"));
        }
        let mut map = yaml.mapping(node, path);
        let every = map.take(yaml, "every");
        let path = map.path_of("every");
        if every.is_none() && map.is_empty() {
            yaml.fault(node.place, &path, "is missing", remedy);
        }
        map.close(yaml, &["every"], &|_| None);
        self.step().read(yaml, every?, &path).map(SensorStack::Every)
    }

    fn json(&self, value: &SensorStack) -> Json {
        match value {
            SensorStack::None => "none".into(),
            SensorStack::All => "all".into(),
            SensorStack::Every(k) => json!({ "every": k }),
        }
    }

    fn allowed(&self) -> String {
        format!("none, all or {{every: k}}, k from 1 to {}", self.0)
    }

    fn schema(&self) -> Json {
        json!({ "oneOf": [{ "enum": Self::WORDS }, object(&json!({ "every": self.step().schema() }), "every")] })
    }
}

/// A file of at most some MB, or one of those that are built in.
pub(crate) struct File(pub usize, pub &'static [BuiltIn], pub FileForm);

/// What a name of a file stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum FileForm {
    /// A file: a recipe cannot do without.
    Needed,
    /// A file, or `none`.
    Optional,
    /// A tar of PNG files, or a folder of them, which counts as a tar; or `none`.
    OptionalStack,
}

/// A file that a recipe names, and its content once it is read.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct NamedFile {
    /// `None` for no file.
    name: Option<String>,
    sha256: Option<String>,
    asset: Option<Asset>,
}

impl NamedFile {
    /// How a recipe says that there is no file.
    pub const NONE_NAME: &'static str = "none";
    /// No file.
    pub const NONE: Self = Self { name: None, sha256: None, asset: None };

    /// The file `name`, which is still to be read.
    pub fn new(name: &str) -> Self {
        Self { name: Some(name.to_owned()), ..Self::NONE }
    }

    /// What the recipe calls it; `None` where it names none.
    pub fn name(&self) -> Option<&str> {
        self.name.as_deref()
    }

    /// The file; `None` where the recipe names none.
    pub fn asset(&self) -> Option<&Asset> {
        self.asset.as_ref()
    }
}

/// The name of a file.
fn file_name(yaml: &mut YamlReader, node: &YamlNode, path: &str, allowed: &str) -> Option<String> {
    let name = yaml.text(node, path, allowed)?;
    if name.is_empty() {
        return yaml.refuse(node.place, path, "is empty", format!("give {allowed}"));
    }
    Some(name.to_owned())
}

/// A SHA-256 in hexadecimal.
fn sha256(yaml: &mut YamlReader, node: &YamlNode, path: &str) -> Option<String> {
    let allowed = "64 digits of 0-9 and a-f, as `sha256sum` prints them";
    let text = yaml.text(node, path, allowed)?;
    let digits = text.len() == 64 && text.bytes().all(|c| matches!(c, b'0'..=b'9' | b'a'..=b'f'));
    if !digits {
        return yaml.refuse(node.place, path, "is no SHA-256", format!("give {allowed}"));
    }
    Some(text.to_owned())
}

impl SettingType for File {
    type Value = NamedFile;

    fn read(&self, yaml: &mut YamlReader, node: &YamlNode, path: &str) -> Option<NamedFile> {
        let allowed = self.allowed();
        match &node.value {
            YamlValue::Text(text) if text == NamedFile::NONE_NAME && self.2 != FileForm::Needed => {
                return Some(NamedFile::NONE);
            }
            YamlValue::Map(_) => {}
            _ => return file_name(yaml, node, path, &allowed).map(|name| NamedFile::new(&name)),
        }
        let mut map = yaml.mapping(node, path);
        let (name, sum) = (map.take(yaml, "name"), map.take(yaml, "sha256"));
        let (name_path, sum_path) = (map.path_of("name"), map.path_of("sha256"));
        map.close(yaml, &["name", "sha256"], &|_| None);
        let Some(name) = name else {
            return yaml.refuse(node.place, &name_path, "is missing", format!("give {allowed}"));
        };
        let name = file_name(yaml, name, &name_path, &allowed)?;
        let sha256 = match sum {
            Some(node) => Some(sha256(yaml, node, &sum_path)?),
            None => None,
        };
        Some(NamedFile { name: Some(name), sha256, asset: None })
    }

    fn load(&self, value: &mut NamedFile, yaml: &mut YamlReader, path: &str, files: &AssetSource) {
        let Some(name) = &value.name else { return };
        let Self(max_mb, built_in, form) = *self;
        let sha256 = value.sha256.as_deref();
        let folders = form == FileForm::OptionalStack;
        let wanted = AssetRequest { key: path, name, sha256, max_bytes: max_mb << 20, built_in, folders };
        match files.find(&wanted) {
            Ok(asset) => value.asset = Some(asset),
            Err(fault) => yaml.joint_fault(&[path], fault.problem, fault.remedy),
        }
    }

    fn json(&self, value: &NamedFile) -> Json {
        value.name.as_deref().unwrap_or(NamedFile::NONE_NAME).into()
    }

    fn canonical(&self, value: &NamedFile) -> Option<Json> {
        value.asset().map(|asset| json!({ "name": asset.name(), "sha256": asset.sha256() }))
    }

    fn asset<'v>(&self, value: &'v NamedFile) -> Option<&'v Asset> {
        value.asset()
    }

    fn built_in(&self) -> Option<&'static [BuiltIn]> {
        Some(self.1)
    }

    fn allowed(&self) -> String {
        let what = match self.2 {
            FileForm::Needed | FileForm::Optional => "a file",
            FileForm::OptionalStack => "a folder of PNG files, or of a tar of them,",
        };
        let names: Vec<_> = self.1.iter().map(|(name, _)| *name).collect();
        let built_in =
            if names.is_empty() { String::new() } else { format!(", or the built-in {}", names.join(" or ")) };
        format!("the name of {what} of at most {} MB{built_in}", self.0)
    }

    fn schema(&self) -> Json {
        let name = json!({ "type": "string", "minLength": 1 });
        let sha256 = json!({ "type": "string", "pattern": "^[0-9a-f]{64}$" });
        json!({ "oneOf": [name, object(&json!({ "name": name, "sha256": sha256 }), "name")] })
    }
}
