//! Model sidecar: a small YAML file beside a model that describes its inputs, outputs and classes.
//!
//! It is read together with the dataset's head, so that a class or a channel that the dataset lacks is a fault with
//! line, key and remedy like any other. docs/guide/check.md explains every key.

use std::path::{Path, PathBuf};

use dataset::atomic_file::sha256;
use output_schema::DatasetHead;
use output_schema::row::MEASURED;

use super::CheckError;
use super::trained_on::TrainedOn;
use yaml::{
    Mapping, NumberRange, YamlFaults, YamlNode, YamlReader, YamlValue, clipped_text, nearest_spelling, parse_yaml,
    read_bytes_or_standard_input, utf8_text,
};

/// What faults call the file.
const NOUN: &str = "sidecar";
/// Largest side of a window or of a model's input [px].
const MAX_SIDE_PX: f64 = 16384.0;

/// Endings of a sidecar beside its model.
pub const ENDINGS: [&str; 3] = ["yaml", "yml", "json"];

/// Keys of a channel.
const CHANNEL_KEYS: [&str; 6] = ["name", "unit", "mean", "sd", "missing", "relative"];
/// Units that a channel may name.
const UNITS: [&str; 3] = ["mm", "px", "DN"];

/// Largest seed that YAML gives exactly.
const MAX_SEED: f64 = 9_007_199_254_740_992.0;
/// Most classes of a model: 255 stands for none.
const MAX_CLASSES: usize = 254;

/// Task of a model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ModelTask {
    /// The class of a sample, from all of it.
    Samples,
    /// The class of an object, from a window around its middle.
    Objects,
    /// The class of a pixel, from a window around it.
    Pixels,
    /// The class of each pixel of a window.
    Segment,
}

impl ModelTask {
    /// Every task.
    pub const ALL: [Self; 4] = [Self::Samples, Self::Objects, Self::Pixels, Self::Segment];

    /// Name in sidecars.
    pub fn name(self) -> &'static str {
        match self {
            Self::Samples => "classify_samples",
            Self::Objects => "classify_objects",
            Self::Pixels => "classify_pixels",
            Self::Segment => "segment",
        }
    }

    /// What is counted, in words.
    pub fn units(self) -> &'static str {
        match self {
            Self::Samples => "samples",
            Self::Objects => "objects",
            Self::Pixels => "patches",
            Self::Segment => "windows",
        }
    }
}

/// Order of a model's numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Layout {
    /// Batch, channels, rows, columns.
    Nchw,
    /// Batch, rows, columns, channels.
    Nhwc,
}

/// What a model's numbers are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OutputKind {
    /// Before softmax, or before the logistic function of a single number.
    Logits,
    /// Between 0 and 1, of a sample or pixel together 1.
    Probabilities,
}

/// One input channel.
#[derive(Debug, Clone, PartialEq)]
pub struct InputChannel {
    /// Name of a map: `range` [unit of the dataset, mm or px, which the sidecar names too], `reflectance` [DN] or
    /// `scatter` [DN].
    pub name: String,
    /// Taken off [unit of the map].
    pub mean: f64,
    /// Divided by [unit of the map].
    pub sd: f64,
    /// Stands for what is missing, after normalisation.
    pub missing: f64,
    /// Whether the window's own mean is taken off first.
    pub relative: bool,
}

/// What a sidecar says; every number is in range and every name is the dataset's.
#[derive(Debug, Clone, PartialEq)]
pub struct Sidecar {
    /// Task of the model.
    pub task: ModelTask,
    /// Input channels in order.
    pub channels: Vec<InputChannel>,
    /// Rows and columns that are cut out [px]; `None` for all of them.
    pub window: Option<[usize; 2]>,
    /// Rows and columns of the model's input [px].
    pub size: [usize; 2],
    /// Order of the model's numbers.
    pub layout: Layout,
    /// What the model's numbers are.
    pub output: OutputKind,
    /// Name of the output that is read; `None` where the model has one.
    pub output_name: Option<String>,
    /// Most windows of each class.
    pub patches_per_class: u64,
    /// Names of the model's classes, in the order of its outputs.
    pub classes: Vec<String>,
    /// The model's class of each class of the dataset: of samples or of pixels by task.
    pub truth: Vec<Option<usize>>,
    /// The dataset that the model was trained on, where it says so.
    pub trained_on: Option<TrainedOn>,
}

/// Keys of a sidecar.
const KEYS: [&str; 11] = [
    "task",
    "channels",
    "bits",
    "window_px",
    "size_px",
    "layout",
    "output",
    "output_name",
    "patches_per_class",
    "classes",
    "trained_on",
];
/// Keys of the dataset that a model was trained on.
const TRAINED_KEYS: [&str; 3] = ["family", "seed", "recipe_hash"];

impl Sidecar {
    /// The sidecar in the file `path`, on standard input where that is `-`, for a dataset; and its SHA-256.
    ///
    /// # Errors
    /// Where it cannot be read, and every fault of it at once.
    pub fn load(path: &Path, head: &DatasetHead) -> Result<(Self, String), CheckError> {
        let bytes = read_bytes_or_standard_input(path).map_err(|error| {
            let remedy = "write one as docs/guide/check.md says, or name another with --sidecar";
            CheckError::at(path, format!("the sidecar cannot be read: {error}"), remedy)
        })?;
        let (origin, sum) = (files::shown(path), sha256(&bytes));
        Ok((Self::parse(&origin, &utf8_text(&origin, bytes, NOUN)?, head)?, sum))
    }

    /// The sidecar that `text` writes; `origin` is where faults say that it comes from.
    ///
    /// # Errors
    /// Every fault of it at once.
    pub fn parse(origin: &str, text: &str, head: &DatasetHead) -> Result<Self, YamlFaults> {
        let mut yaml = YamlReader::new(text, NOUN);
        let sidecar = match parse_yaml(text, NOUN) {
            Ok(root) => read(&mut yaml, &root, head),
            Err(error) => {
                yaml.fault(error.place, "", error.problem, error.remedy);
                None
            }
        };
        yaml.finish(origin)?;
        Ok(sidecar.expect("whatever gives no sidecar notes a fault"))
    }
}

fn read(yaml: &mut YamlReader, root: &YamlNode, head: &DatasetHead) -> Option<Sidecar> {
    if !matches!(root.value, YamlValue::Map(_)) {
        let problem = format!("the file is {}", root.value.kind());
        yaml.fault(root.place, "", problem, format!("a sidecar is a map with {}", KEYS.join(", ")));
        return None;
    }
    let mut top = yaml.mapping(root, "");
    let names = ModelTask::ALL.map(ModelTask::name);
    let task = required(yaml, &mut top, "task", &format!("one of {}", names.join(", ")));
    let task = task.and_then(|node| yaml.word(node, "task", &names));
    let task = task.and_then(|name| ModelTask::ALL.into_iter().find(|task| task.name() == name));
    let channels = required(yaml, &mut top, "channels", "the maps in the model's order, `channels: [{name: scatter}]`");
    let channels = channels.and_then(|node| read_channels(yaml, node, head));
    check_bits(yaml, &mut top, channels.as_deref().unwrap_or_default(), head);
    if let Some(ModelTask::Pixels | ModelTask::Segment) = task
        && !head.images.holds("label")
    {
        let remedy = "write `output: {png: [..., label]}` in the recipe and make the dataset anew";
        yaml.joint_fault(&["task"], "the dataset has no images of `label` to hold it to", remedy);
    }
    let whole = [head.images.rows as usize, head.images.cols as usize];
    let window = match top.take(yaml, "window_px") {
        Some(node) if matches!(&node.value, YamlValue::Text(text) if text == "whole") => Some(None),
        Some(node) => sides(yaml, node, "window_px").map(Some),
        None => Some(None),
    };
    if let (Some(ModelTask::Objects | ModelTask::Pixels), Some(None)) = (task, window) {
        let remedy = "give the rows and columns that are cut out around each, `window_px: [64, 64]`";
        yaml.joint_fault(&["window_px", "task"], "patches need a window", remedy);
    }
    let size = match top.take(yaml, "size_px") {
        Some(node) => sides(yaml, node, "size_px"),
        None => window.map(|window| window.unwrap_or(whole)),
    };
    let layout = word(yaml, &mut top, "layout", &[("nchw", Layout::Nchw), ("nhwc", Layout::Nhwc)]);
    let output = [("logits", OutputKind::Logits), ("probabilities", OutputKind::Probabilities)];
    let output = word(yaml, &mut top, "output", &output);
    let output_name = top.take(yaml, "output_name");
    let output_name = output_name.map(|node| yaml.text(node, "output_name", "the name of an output").map(String::from));
    let range = NumberRange { min: 1.0, max: 1e9, whole: true, unit: "" };
    let patches = match (task, top.take(yaml, "patches_per_class")) {
        (Some(task @ (ModelTask::Samples | ModelTask::Segment)), Some(node)) => {
            let problem = format!("has no effect in `{}`, which asks about all that there is", task.name());
            yaml.fault(node.place, "patches_per_class", problem, "leave it out");
            None
        }
        (_, Some(node)) => yaml.number_in(node, "patches_per_class", range),
        (_, None) => Some(1000.0),
    };
    let classes = required(yaml, &mut top, "classes", "the model's classes in order, `classes: [clear, rot]`");
    let classes = classes.and_then(|node| read_classes(yaml, node, task?, head));
    let trained_on = top.take(yaml, "trained_on").map(|node| read_trained_on(yaml, node));
    top.close(yaml, &KEYS, &|name| {
        CHANNEL_KEYS.contains(&name).then(|| format!("`{name}` belongs in an entry of `channels`"))
    });
    let (classes, truth) = classes?;
    Some(Sidecar {
        task: task?,
        channels: channels?,
        window: window?,
        size: size?,
        layout: layout?,
        output: output?,
        output_name: output_name.map_or(Some(None), |name| name.map(Some))?,
        patches_per_class: patches? as u64,
        classes,
        truth,
        trained_on: trained_on.map_or(Some(None), |read| read.map(Some))?,
    })
}

/// Refuses digital numbers of other bits than the dataset has, where the model counts them.
fn check_bits(yaml: &mut YamlReader, top: &mut Mapping, channels: &[InputChannel], head: &DatasetHead) {
    let bits = number(yaml, top, "bits", NumberRange { min: 8.0, max: 12.0, whole: true, unit: "" }, 8.0);
    let is_counted = |channel: &InputChannel| channel.name != "range";
    if let Some(bits) = bits.filter(|_| channels.iter().any(is_counted))
        && bits as u64 != head.images.bits
    {
        let found = head.images.bits;
        let problem = format!("the model takes digital numbers of {bits} bits, the dataset has them of {found}");
        let remedy = format!(
            "make a dataset whose recipe says `exposure: {{bits: {bits}}}`, or write `bits: {found}` where the model \
                was \
             trained on that"
        );
        yaml.joint_fault(&["bits", "channels"], problem, remedy);
    }
}

/// Reads `trained_on`.
fn read_trained_on(yaml: &mut YamlReader, node: &YamlNode) -> Option<TrainedOn> {
    const PATH: &str = "trained_on";
    if !matches!(node.value, YamlValue::Map(_)) {
        let remedy = "give the family and the seed of the dataset, `trained_on: {family: wood, seed: 0}`";
        yaml.fault(node.place, PATH, format!("is {}", node.value.kind()), remedy);
        return None;
    }
    let mut map = yaml.mapping(node, PATH);
    let family =
        required(yaml, &mut map, "family", "the family of the recipe, which is its name unless it says otherwise");
    let family = family.and_then(|node| yaml.text(node, "trained_on.family", "the name of a family"));
    let seed = required(yaml, &mut map, "seed", "the seed of the dataset");
    let range = NumberRange { min: 0.0, max: MAX_SEED, whole: true, unit: "" };
    let seed = seed.and_then(|node| yaml.number_in(node, "trained_on.seed", range));
    let hash = map.take(yaml, "recipe_hash");
    let hash = hash.map(|node| yaml.text(node, "trained_on.recipe_hash", "the hash of the recipe, in quotes"));
    map.close(yaml, &TRAINED_KEYS, &|_| None);
    let recipe_hash = hash.map_or(Some(None), |hash| hash.map(|hash| Some(hash.into())))?;
    Some(TrainedOn { family: family?.into(), seed: seed? as u64, recipe_hash })
}

/// Reads `channels`.
fn read_channels(yaml: &mut YamlReader, node: &YamlNode, head: &DatasetHead) -> Option<Vec<InputChannel>> {
    let entries = match &node.value {
        YamlValue::List(entries) if !entries.is_empty() => entries,
        other => {
            let problem = if let YamlValue::List(_) = other { "is empty" } else { "is no list" };
            yaml.fault(node.place, "channels", problem, "list the model's input maps in order");
            return None;
        }
    };
    let read: Vec<_> = entries.iter().enumerate().map(|(i, entry)| read_channel(yaml, entry, i, head)).collect();
    read.into_iter().collect()
}

fn read_channel(yaml: &mut YamlReader, node: &YamlNode, i: usize, head: &DatasetHead) -> Option<InputChannel> {
    let path = format!("channels[{i}]");
    let short = matches!(node.value, YamlValue::Text(_));
    let mut map = if short { None } else { Some(yaml.mapping(node, &path)) };
    let name = match &mut map {
        None => Some(node),
        Some(map) => required(yaml, map, "name", &format!("one of {}", MEASURED.join(", "))),
    };
    let found = name.and_then(|node| yaml.word(node, &path, &MEASURED));
    if let Some((node, name)) = name.zip(found).filter(|(_, name)| !head.images.holds(name)) {
        let remedy = format!("write `output: {{png: [..., {name}]}}` in the recipe and make the dataset anew");
        yaml.fault(node.place, &path, format!("the dataset has no images of `{name}`"), remedy);
    }
    let Some(mut map) = map else {
        check_unit(yaml, node, (found?, None), &path, head);
        return Some(InputChannel { name: found?.into(), mean: 0.0, sd: 1.0, missing: 0.0, relative: false });
    };
    let any = NumberRange { min: -1e9, max: 1e9, whole: false, unit: "" };
    let unit =
        map.take(yaml, "unit").map_or(Some(None), |node| yaml.word(node, &map.path_of("unit"), &UNITS).map(Some));
    if let Some((name, unit)) = found.zip(unit) {
        check_unit(yaml, node, (name, unit), &path, head);
    }
    let mean = number(yaml, &mut map, "mean", any, 0.0);
    let sd = number(yaml, &mut map, "sd", NumberRange { min: 1e-9, ..any }, 1.0);
    let missing = number(yaml, &mut map, "missing", any, 0.0);
    let relative = map.take(yaml, "relative");
    let relative = relative.map_or(Some(false), |node| yaml.flag(node, &map.path_of("relative")));
    map.close(yaml, &CHANNEL_KEYS, &|_| None);
    Some(InputChannel { name: found?.into(), mean: mean?, sd: sd?, missing: missing?, relative: relative? })
}

/// Faults a channel whose numbers the dataset has in another unit than the model takes.
fn check_unit(
    yaml: &mut YamlReader,
    node: &YamlNode,
    (name, given): (&str, Option<&str>),
    path: &str,
    head: &DatasetHead,
) {
    let (usual, found) = if name == "range" { ("mm", head.range_unit()) } else { ("DN", "DN") };
    let wanted = given.unwrap_or(usual);
    if wanted != found {
        let problem = format!("the model takes `{name}` in {wanted}, the dataset has it in {found}");
        let remedy = match found {
            "px" => "make a dataset whose recipe says `extraction: {range: calibrated}`, or write `unit: px` here \
                where the model was trained on sensor rows"
                .into(),
            _ => format!("write `unit: {found}` here where the model was trained on that, or name another dataset"),
        };
        yaml.fault(node.place, path, problem, remedy);
    }
}

/// Names of the model's classes, and its class of each class of the dataset.
type ClassMapping = (Vec<String>, Vec<Option<usize>>);

/// Reads `classes`.
fn read_classes(yaml: &mut YamlReader, node: &YamlNode, task: ModelTask, head: &DatasetHead) -> Option<ClassMapping> {
    let entries = match &node.value {
        YamlValue::List(entries) if (2..=MAX_CLASSES).contains(&entries.len()) => entries,
        YamlValue::List(entries) => {
            let problem = format!("has {} entries", entries.len());
            yaml.fault(node.place, "classes", problem, format!("list 2 to {MAX_CLASSES} classes"));
            return None;
        }
        other => {
            yaml.fault(node.place, "classes", format!("is {}", other.kind()), "list the model's classes in order");
            return None;
        }
    };
    let known: Vec<(usize, &str)> = match task {
        ModelTask::Samples => head.classes.iter().map(String::as_str).enumerate().collect(),
        _ => head.shown_classes().collect(),
    };
    let last = known.iter().map(|(value, _)| *value).max().unwrap_or(0);
    let (mut names, mut truth) = (Vec::new(), vec![None; last + 1]);
    let mut whole = true;
    for (class, entry) in entries.iter().enumerate() {
        let path = format!("classes[{class}]");
        let Some((name, of)) = read_class(yaml, entry, &path) else {
            whole = false;
            continue;
        };
        if names.contains(&name) {
            let problem = format!("`{}` stands here twice", clipped_text(&name));
            yaml.fault(entry.place, &path, problem, "give each class its own name");
        }
        names.push(name);
        for node in of {
            let Some(text) = yaml.text(node, &path, "the name of a class of the dataset") else { continue };
            let Some((value, _)) = known.iter().find(|(_, known)| *known == text) else {
                let all: Vec<&str> = known.iter().map(|(_, name)| *name).collect();
                let kind = if task == ModelTask::Samples { "samples" } else { "pixels" };
                let hint = nearest_spelling(text, all.iter().copied())
                    .map_or(String::new(), |m| format!("did you mean `{m}`? "));
                let remedy = format!("{hint}its classes of {kind} are {}; `of: []` for none", all.join(", "));
                yaml.fault(node.place, &path, format!("the dataset has no class `{}`", clipped_text(text)), remedy);
                continue;
            };
            if let Some(other) = truth[*value].replace(class).filter(|&other| other != class) {
                let problem = format!("`{text}` belongs to classes[{other}] already");
                yaml.fault(node.place, &path, problem, "name it under one class");
            }
        }
    }
    whole.then_some((names, truth))
}

/// Name of a class and the nodes that name classes of the dataset; a plain text is both.
fn read_class<'n>(yaml: &mut YamlReader, entry: &'n YamlNode, path: &str) -> Option<(String, Vec<&'n YamlNode>)> {
    if let YamlValue::Text(name) = &entry.value {
        return Some((name.clone(), vec![entry]));
    }
    let mut map = yaml.mapping(entry, path);
    let name = required(yaml, &mut map, "name", "the name of the class");
    let name = name.and_then(|node| yaml.text(node, &map.path_of("name"), "the name of the class"));
    let node = map.take(yaml, "of");
    let of = match node.map(|node| &node.value) {
        Some(YamlValue::List(entries)) => Some(entries.iter().collect()),
        Some(YamlValue::Text(_)) => node.map(|node| vec![node]),
        other => {
            let place = node.map_or(map.place(), |node| node.place);
            let problem = other.map_or("is missing".into(), |value| format!("is {}", value.kind()));
            let remedy = "list the classes of the dataset that it is, `of: [sound_knot, dead_knot]`";
            yaml.fault(place, &map.path_of("of"), problem, remedy);
            None
        }
    };
    map.close(yaml, &["name", "of"], &|_| None);
    Some((name?.to_owned(), of?))
}

/// The sidecar beside a model.
///
/// # Errors
/// Where there is none, or more than one.
pub fn beside(model: &Path) -> Result<PathBuf, CheckError> {
    let all = ENDINGS.map(|ending| model.with_extension(ending));
    let shown = |paths: &[PathBuf], and: &str| {
        paths.iter().map(|path| path.display().to_string()).collect::<Vec<_>>().join(and)
    };
    let mut found = all.clone().to_vec();
    found.retain(|path| path.exists());
    match found.as_slice() {
        [one] => Ok(one.clone()),
        [] if !model.exists() => Err(CheckError::at(model, "it is not there".into(), "name a model, an .onnx file")),
        [] => {
            let remedy = "write one as docs/guide/check.md says, or name it with --sidecar";
            Err(CheckError::at(model, format!("there is no sidecar beside it ({})", shown(&all, ", ")), remedy))
        }
        several => {
            let what = format!("{} lie beside it", shown(several, " and "));
            Err(CheckError::at(model, what, "name the one that is its sidecar with --sidecar"))
        }
    }
}

fn required<'n>(yaml: &mut YamlReader, top: &mut Mapping<'n>, name: &str, wanted: &str) -> Option<&'n YamlNode> {
    let found = top.take(yaml, name);
    if found.is_none() {
        yaml.fault(top.place(), &top.path_of(name), "is missing", format!("give {wanted}"));
    }
    found
}

/// One of the words, the first where the key is not there.
fn word<T: Copy>(yaml: &mut YamlReader, top: &mut Mapping, name: &str, words: &[(&'static str, T)]) -> Option<T> {
    let Some(node) = top.take(yaml, name) else { return words.first().map(|(_, value)| *value) };
    let names: Vec<&'static str> = words.iter().map(|(word, _)| *word).collect();
    let found = yaml.word(node, &top.path_of(name), &names)?;
    words.iter().find(|(word, _)| *word == found).map(|(_, value)| *value)
}

fn number(yaml: &mut YamlReader, map: &mut Mapping, name: &str, range: NumberRange, default: f64) -> Option<f64> {
    let path = map.path_of(name);
    map.take(yaml, name).map_or(Some(default), |node| yaml.number_in(node, &path, range))
}

/// `[rows, columns]`, or one number for both.
fn sides(yaml: &mut YamlReader, node: &YamlNode, path: &str) -> Option<[usize; 2]> {
    let range = NumberRange { min: 1.0, max: MAX_SIDE_PX, whole: true, unit: "px" };
    match &node.value {
        YamlValue::List(entries) if entries.len() == 2 => {
            let sides = [yaml.number_in(&entries[0], path, range), yaml.number_in(&entries[1], path, range)];
            Some([sides[0]? as usize, sides[1]? as usize])
        }
        YamlValue::Number(_) => yaml.number_in(node, path, range).map(|side| [side as usize; 2]),
        other => {
            let remedy = format!("give `{path}: [rows, columns]`");
            let remedy = if path == "window_px" { format!("{remedy} or `window_px: whole`") } else { remedy };
            yaml.fault(node.place, path, format!("is {}", other.kind()), remedy);
            None
        }
    }
}

#[cfg(test)]
mod tests;
