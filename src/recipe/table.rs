//! Every key of a recipe, declared once: reading, canonical form, schema and reference all walk over these tables.
//!
//! Parameters are drawn for each sample and declared beside the physics that uses them; settings are the same for all
//! samples and declared here.

use procedural::Parameter;
use procedural::wood::{Board, Knots, Log, Media, Rot};

use crate::optics::parameters::{Camera, Exposure, Laser, Motion, Speckle};
use crate::settings::{Channel, ScatterMode};

/// A group of keys.
#[derive(Debug, Clone, Copy)]
pub(super) struct Section {
    /// Key path, for instance `camera` or `output.bin`.
    pub path: &'static str,
    /// What the group is about.
    pub doc: &'static str,
    /// Keys that are the same for all samples.
    pub settings: &'static [Setting],
    /// Keys that are drawn for each sample.
    pub parameters: &'static [Parameter],
}

/// The declaration of one setting.
#[derive(Debug, Clone, Copy)]
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
}

/// What a setting is.
#[derive(Debug, Clone, Copy, PartialEq)]
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
}

/// Smallest and largest number of columns [px]; the smallest leaves something to bin.
pub(super) const COLUMNS: (usize, usize) = (8, 16384);
/// Profiles that the buffers of the real camera hold.
pub(super) const MOST_PROFILES: usize = 16383;
/// Most pixels of an unbinned image, 12 times the thesis' scan.
pub(super) const MOST_PIXELS: usize = 1 << 27;

/// The row of a setting.
const fn setting(name: &'static str, kind: Kind, default: Value, doc: &'static str, source: &'static str) -> Setting {
    Setting { name, kind, default, doc, source }
}

const SCAN: &[Setting] = &[
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

const CAMERA: &[Setting] = &[setting(
    "rows",
    Kind::Count { min: 64, max: 4096, unit: "px" },
    Value::Count(832),
    "Sensor rows; the same for all samples, so a class cannot change it.",
    "[T]",
)];

const EXTRACTION: &[Setting] = &[
    setting(
        "method",
        Kind::Word(&["centre_of_gravity"]),
        Value::Word("centre_of_gravity"),
        "How the peak is placed between the rows.",
        "[T]",
    ),
    setting(
        "window_rows",
        Kind::OneOf(&[3, 7, 15]),
        Value::Count(7),
        "Rows on each side of the peak that the centre of gravity uses.",
        "window around the maximum of the real camera",
    ),
    setting(
        "threshold_dn",
        Kind::Number { min: 0.0, max: 255.0, unit: "DN" },
        Value::Number(17.0),
        "Smallest digital number of a peak.",
        "dark level plus five standard deviations",
    ),
    setting(
        "subpixel_steps",
        Kind::Count { min: 0, max: 256, unit: "" },
        Value::Count(16),
        "Steps per row in which the peak position is given; 0 leaves it unrounded.",
        "1/16 px of the real camera",
    ),
    setting(
        "scatter_mode",
        Kind::Word(&ScatterMode::NAMES),
        Value::Word("symmetric"),
        "Which side windows Scatter sums: both, `front` (smaller row numbers) or `back`.",
        "modes of the real camera",
    ),
    setting(
        "scatter_offset_rows",
        Kind::Count { min: 0, max: 15, unit: "px" },
        Value::Count(1),
        "Distance from the peak to the first summed row; 0 includes the peak.",
        "[T] wood",
    ),
    setting(
        "scatter_width_rows",
        Kind::Count { min: 1, max: 16, unit: "px" },
        Value::Count(8),
        "Rows that are summed on each side; offset and width together at most 16, at most 29 rows in all.",
        "[T] wood",
    ),
];

const SPLITS: &[Setting] = &[
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

const OUTPUT: &[Setting] = &[
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
        "Whether the EXR files hold noise-free height, fibre azimuth and fibre dive too.",
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

const BIN: &[Setting] = &[
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

/// A section of parameters, and perhaps settings beside them.
macro_rules! drawn {
    ($Group:ty, $settings:expr) => {
        Section { path: <$Group>::GROUP, doc: <$Group>::DOC, settings: $settings, parameters: <$Group>::PARAMETERS }
    };
}

/// A section of settings alone.
const fn fixed(path: &'static str, doc: &'static str, settings: &'static [Setting]) -> Section {
    Section { path, doc, settings, parameters: &[] }
}

/// Every section, in the order of the light: scan, bench, board, reading, writing.
pub(super) const SECTIONS: [Section; 15] = [
    fixed("scan", "Sizes of the scan.", SCAN),
    drawn!(Motion, &[]),
    drawn!(Laser, &[]),
    drawn!(Camera, CAMERA),
    drawn!(Exposure, &[]),
    drawn!(Speckle, &[]),
    drawn!(Board, &[]),
    drawn!(Log, &[]),
    drawn!(Knots, &[]),
    drawn!(Rot, &[]),
    drawn!(Media, &[]),
    fixed("extraction", "How a profile is read from a frame.", EXTRACTION),
    fixed("splits", "Shares of the parts of the dataset; they sum to 1.", SPLITS),
    fixed("output", "What is written.", OUTPUT),
    fixed("output.bin", "How many pixels are averaged into one of the written images.", BIN),
];

/// Every parameter in the order of [`SECTIONS`].
pub(super) fn parameters() -> impl Iterator<Item = &'static Parameter> {
    SECTIONS.iter().flat_map(|section| section.parameters)
}

/// The unit that a key ends in, empty for none.
pub(super) fn unit(name: &str) -> &'static str {
    const UNITS: [(&str, &str); 12] = [
        ("_deg_per_mm", "deg/mm"),
        ("_per_mm", "1/mm"),
        ("_mm", "mm"),
        ("_um", "um"),
        ("_nm", "nm"),
        ("_deg", "deg"),
        ("_mw", "mW"),
        ("_us", "us"),
        ("_dn", "DN"),
        ("_e", "electrons"),
        ("_rows", "px"),
        ("_columns", "px"),
    ];
    UNITS.iter().find(|(end, _)| name.ends_with(end)).map_or("", |(_, unit)| unit)
}

impl Value {
    /// The value as JSON, which is how a recipe writes it too.
    pub fn json(self) -> serde_json::Value {
        match self {
            Self::Count(count) => count.into(),
            Self::Number(number) => number.into(),
            Self::Flag(flag) => flag.into(),
            Self::Word(word) => word.into(),
            Self::Channels(chosen) => Channel::chosen(chosen).iter().map(|channel| channel.name()).collect(),
            Self::Every(k) => serde_json::json!({ "every": k }),
        }
    }
}

/// Where a key that stands in the wrong section belongs.
pub(super) fn home(name: &str) -> Option<String> {
    let has = |section: &&Section| {
        section.parameters.iter().any(|p| p.name == name) || section.settings.iter().any(|s| s.name == name)
    };
    let homes: Vec<_> = SECTIONS.iter().filter(has).map(|section| format!("`{}`", section.path)).collect();
    (!homes.is_empty()).then(|| format!("`{name}` belongs in {}", homes.join(" or ")))
}

/// Documentation without the blanks that `///` leaves in front of its lines.
pub(super) fn tidy(doc: &str) -> String {
    doc.trim().replace("  ", " ")
}

impl std::fmt::Display for Kind {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
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
        }
    }
}
