//! The settings: what is the same for all samples, each declared once.

use std::fmt;

use crate::asset::{Asset, BuiltIn};
use crate::mesh;
use crate::settings::{Channel, Hdr};

/// The declaration of one setting.
#[derive(Debug, Clone)]
pub(super) struct Setting {
    /// Key in its section.
    pub name: &'static str,
    /// What it may be.
    pub kind: Kind,
    /// What it is where the recipe says nothing.
    pub default: Value,
    /// What it means.
    pub doc: &'static str,
    /// Where the default and the range come from.
    pub source: &'static str,
}

/// What a setting may be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Kind {
    /// A whole number of `unit`.
    Count { min: usize, max: usize, unit: &'static str },
    /// One of some whole numbers.
    OneOf(&'static [usize]),
    /// A number of `unit`.
    Number { min: f64, max: f64, unit: &'static str },
    /// `true` or `false`.
    Flag,
    /// One of some words.
    Word(&'static [&'static str]),
    /// A list of different channels.
    Channels,
    /// `none`, `all` or `{every: k}`.
    Stack { max: usize },
    /// `auto` or a whole number.
    CountOrAuto { min: usize, max: usize },
    /// A file of at most `most_mb`, or one of those that are built in; `none` where the default is.
    File { most_mb: usize, built_in: &'static [BuiltIn] },
    /// `auto` or a number of `unit`.
    NumberOrAuto { min: f64, max: f64, unit: &'static str },
}

/// What a setting is.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Value {
    /// A whole number.
    Count(usize),
    /// A number.
    Number(f64),
    /// `true` or `false`.
    Flag(bool),
    /// A word.
    Word(&'static str),
    /// Which channels, in the order of [`Channel::ALL`].
    Channels([bool; Channel::ALL.len()]),
    /// `{every: k}`.
    Every(usize),
    /// The name of a file that is still to be read, and the SHA-256 that it must have.
    Named { name: String, sha256: Option<String> },
    /// A file.
    File(Asset),
}

/// Smallest and largest number of columns [px]; the smallest leaves something to bin.
pub(super) const COLUMNS: (usize, usize) = (8, 16384);
/// Profiles that the buffers of the real camera hold.
pub(super) const MOST_PROFILES: usize = 16383;
/// Most pixels of an unbinned image, 12 times the thesis' scan.
pub(super) const MOST_PIXELS: usize = 1 << 27;

impl Value {
    /// The value as JSON, which is how a recipe writes it too.
    pub fn json(&self) -> serde_json::Value {
        match self {
            Self::Count(count) => (*count).into(),
            Self::Number(number) => (*number).into(),
            Self::Flag(flag) => (*flag).into(),
            Self::Word(word) => (*word).into(),
            Self::Channels(chosen) => Channel::chosen(*chosen).iter().map(|channel| channel.name()).collect(),
            Self::Every(k) => serde_json::json!({ "every": k }),
            Self::Named { name, sha256: None } => name.as_str().into(),
            Self::Named { name, sha256 } => serde_json::json!({ "name": name, "sha256": sha256 }),
            Self::File(file) => serde_json::json!({ "name": file.name(), "sha256": file.sha256() }),
        }
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let list = |counts: &[usize]| counts.iter().map(usize::to_string).collect::<Vec<_>>().join(", ");
        match self {
            Self::Count { min, max, unit: "" } => write!(f, "a whole number from {min} to {max}"),
            Self::Count { min, max, unit } => write!(f, "a whole number from {min} to {max} {unit}"),
            Self::OneOf(counts) => write!(f, "one of {}", list(counts)),
            Self::Number { min, max, unit: "" } => write!(f, "a number from {min} to {max}"),
            Self::Number { min, max, unit } => write!(f, "a number from {min} to {max} {unit}"),
            Self::Flag => write!(f, "true or false"),
            Self::Word(words) => write!(f, "{}", words.join(" or ")),
            Self::Channels => write!(f, "a list of {}", Channel::ALL.map(Channel::name).join(", ")),
            Self::Stack { max } => write!(f, "none, all or {{every: k}}, k from 1 to {max}"),
            Self::CountOrAuto { min, max } => write!(f, "auto or a whole number from {min} to {max}"),
            Self::File { most_mb, built_in: [] } => write!(f, "the name of a file of at most {most_mb} MB"),
            Self::File { most_mb, built_in } => {
                let names: Vec<_> = built_in.iter().map(|(name, _)| *name).collect();
                write!(f, "the name of a file of at most {most_mb} MB, or the built-in {}", names.join(" or "))
            }
            Self::NumberOrAuto { min, max, unit } => write!(f, "auto or a number from {min} to {max} {unit}"),
        }
    }
}

/// The row of a setting.
pub(super) const fn setting(
    name: &'static str,
    kind: Kind,
    default: Value,
    doc: &'static str,
    source: &'static str,
) -> Setting {
    Setting { name, kind, default, doc, source }
}

/// Sizes.
pub(super) const SCAN: &[Setting] = &[
    setting(
        "columns",
        Kind::Count { min: COLUMNS.0, max: COLUMNS.1, unit: "px" },
        Value::Count(2560),
        "Sensor columns, and columns of the unbinned images.",
        "[T]",
    ),
    setting(
        "profiles",
        Kind::Count { min: 1, max: MOST_PROFILES, unit: "" },
        Value::Count(4000),
        "Profiles in a scan, and rows of the unbinned images.",
        "[T]; the buffers of the real camera hold 16383",
    ),
];

/// What of the sensor is not drawn.
pub(super) const EXPOSURE: &[Setting] = &[
    setting(
        "bits",
        Kind::OneOf(&[8, 10, 12]),
        Value::Count(8),
        "Bits of a digital number. Keys in DN stay on the scale of 8 bits; images, frames and Scatter get finer steps.",
        "[T] 8",
    ),
    setting(
        "hdr",
        Kind::Word(&Hdr::NAMES),
        Value::Word("none"),
        "A second, flatter slope for bright light: 2, 6 or 15 times the dynamic range.",
        "modes of the real camera",
    ),
];

/// What of a part is not drawn.
pub(super) const MESH: &[Setting] = &[setting(
    "file",
    Kind::File { most_mb: 64, built_in: &mesh::BUILT_IN },
    Value::Word(mesh::BUILT_IN[0].0),
    "Triangles of the part: OBJ, STL or PLY, by the name's ending.",
    "free",
)];

/// Parts of the dataset.
pub(super) const SPLITS: &[Setting] = &[
    setting("train", Kind::Number { min: 0.0, max: 1.0, unit: "" }, Value::Number(0.8), "Share for training.", "usual"),
    setting(
        "validation",
        Kind::Number { min: 0.0, max: 1.0, unit: "" },
        Value::Number(0.1),
        "Share for choosing.",
        "usual",
    ),
    setting(
        "test",
        Kind::Number { min: 0.0, max: 1.0, unit: "" },
        Value::Number(0.1),
        "Share for the last word.",
        "usual",
    ),
];

/// Files.
pub(super) const OUTPUT: &[Setting] = &[
    setting(
        "png",
        Kind::Channels,
        Value::Channels([true, true, true, true, false]),
        "Images in the Parquet rows, as PNG.",
        "free",
    ),
    setting(
        "exr",
        Kind::Channels,
        Value::Channels([true; 5]),
        "Images in the EXR files; `[]` for no EXR files.",
        "free",
    ),
    setting(
        "truth_maps",
        Kind::Flag,
        Value::Flag(true),
        "Whether the EXR files hold noise-free maps too: height, and fibre azimuth and dive, or film thickness and gap.",
        "free",
    ),
    setting(
        "sensor_stack",
        Kind::Stack { max: MOST_PROFILES },
        Value::Word("none"),
        "Which sensor frames are kept: none, all, or every k-th from the first.",
        "free",
    ),
    setting(
        "samples_per_shard",
        Kind::CountOrAuto { min: 1, max: 100_000 },
        Value::Word("auto"),
        "Samples in a shard; `auto` keeps a shard under about 500 MB.",
        "free",
    ),
];

/// Averaging before writing.
pub(super) const BIN: &[Setting] = &[
    setting(
        "columns",
        Kind::Count { min: 1, max: COLUMNS.1, unit: "px" },
        Value::Count(1),
        "Columns averaged into one; divides `scan.columns`.",
        "free",
    ),
    setting(
        "profiles",
        Kind::Count { min: 1, max: MOST_PROFILES, unit: "" },
        Value::Count(1),
        "Profiles averaged into one; divides `scan.profiles`.",
        "free",
    ),
];
