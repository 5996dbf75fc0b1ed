//! `dataset.json`: what is known before the first sample. No clock, no host.

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::calibration::CALIBRATION;
use crate::channel::{Channel, channels, range_form};
use crate::column::{Column, ColumnKind, NumberColumn, newest};
use crate::file::SHARDS_PER_FOLDER;
use crate::row::{OBJECT, ROW};
use crate::stack::STACK;

/// Value of `format`.
pub const FORMAT: &str = "sheetlight-dataset";

/// Version of everything in this crate: a new major number where old readers would misread, a new minor number where
/// something was added: that of the newest column, or `NEWEST_OTHER`.
pub const SCHEMA_VERSION: [u32; 2] =
    [1, newest(&ROW, newest(&OBJECT, newest(&CALIBRATION, newest(&STACK, NEWEST_OTHER))))];

/// The minor number with which something other than a column was added last: EXR files of truth maps alone.
const NEWEST_OTHER: u32 = 9;

/// Most samples of a dataset.
pub const MAX_SAMPLES: u64 = 100_000_000;

/// Most shards of a dataset: their names have five digits.
pub const MAX_SHARDS: u64 = 100_000;

/// Most samples of a shard.
pub const MAX_SAMPLES_PER_SHARD: u64 = 100_000;

/// Longest side of an image or a sensor frame: the widest sensor has 16384 columns [px].
const MAX_SIDE: u64 = 16384;

/// Most pixels of an image: those of the largest recipe [px].
const MAX_PIXELS: u64 = 1 << 27;

/// Most classes of a recipe.
const MAX_CLASSES: usize = 255;

/// Longest name of a class, a group or a column [bytes].
const MAX_NAME_BYTES: usize = 128;

/// The oldest minor number of this major one whose columns and keys are all that readers here ask for.
pub const OLDEST_MINOR: u32 = 2;

/// The program that wrote a dataset.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Generator {
    /// Its name.
    pub name: String,
    /// Its version; another version may give other numbers.
    pub version: String,
}

/// The recipe of a dataset.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RecipeHead {
    /// Name, for titles.
    pub name: String,
    /// The file as the user wrote it.
    pub text: String,
    /// SHA-256 of the canonical form, hexadecimal.
    pub hash: String,
    /// Every key with its value, defaults filled in.
    pub canonical: Value,
}

/// A file that the recipe names.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct AssetHead {
    /// Key of the recipe that names it.
    pub key: String,
    /// Its name when it was read, without folders.
    pub name: String,
    /// Path of the copy, relative to the folder.
    pub path: String,
    /// Size [bytes].
    pub bytes: u64,
    /// SHA-256 of its content, hexadecimal.
    pub sha256: String,
}

impl AssetHead {
    /// Whether its path is that of a copy, and so leads out of no folder.
    pub fn is_in_folder(&self) -> bool {
        let name = self.path.strip_prefix("assets/").and_then(|rest| rest.strip_prefix(&self.sha256));
        let hexadecimal = self.sha256.len() == 64 && self.sha256.bytes().all(|c| c.is_ascii_hexdigit());
        hexadecimal && name.is_some_and(|name| name.starts_with('-') && !name.contains(['/', '\\']))
    }
}

/// A warning of the check of the rig, which comes before the first sample.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct RigWarning {
    /// What is wrong, by the code that validation gives single samples, or `wide-line` or `profiles-far-apart`.
    pub code: String,
    /// What was found.
    pub what: String,
    /// What to do.
    pub remedy: String,
}

/// Shares of the splits [1].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SplitShares {
    /// For training.
    pub train: f64,
    /// For choosing.
    pub validation: f64,
    /// For the last word.
    pub test: f64,
}

impl SplitShares {
    /// Names and shares in the order of files.
    pub fn named(&self) -> [(&'static str, f64); 3] {
        [("train", self.train), ("validation", self.validation), ("test", self.test)]
    }
}

/// Sizes and kinds of the images.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Images {
    /// Columns of every image [px].
    pub cols: u64,
    /// Rows of every image [px].
    pub rows: u64,
    /// Images in the Parquet rows.
    pub png: Vec<String>,
    /// Images in the EXR files; empty where there are none.
    pub exr: Vec<String>,
    /// What Range is: a name in [`crate::channel::RANGE_FORMS`].
    pub range: String,
    /// Whether the EXR files hold the truth maps.
    pub truth_maps: bool,
    /// Every how many profiles a sensor frame is kept; null for none.
    pub stack_every: Option<u64>,
    /// Columns of a sensor frame [px].
    pub sensor_cols: u64,
    /// Rows of a sensor frame [px].
    pub sensor_rows: u64,
    /// Bits of a digital number: 8, 10 or 12.
    pub bits: u64,
}

impl Images {
    /// Whether an image of this name is kept, as PNG or in EXR files.
    pub fn holds(&self, name: &str) -> bool {
        self.png.iter().chain(&self.exr).any(|image| image == name)
    }

    /// Bits in a pixel of the image `reflectance` and of sensor frames: 8, or 16 where digital numbers have more.
    pub fn depth(&self) -> u8 {
        if self.bits > 8 { 16 } else { 8 }
    }

    /// Sensor columns that are averaged into one column of the images [px].
    pub fn binned_columns(&self) -> u64 {
        self.sensor_cols / self.cols.max(1)
    }

    /// Greatest digital number [DN].
    pub fn most_dn(&self) -> u16 {
        u16::MAX >> 16u64.saturating_sub(self.bits).min(15)
    }
}

/// `dataset.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DatasetHead {
    /// [`FORMAT`].
    pub format: String,
    /// [`SCHEMA_VERSION`] of the writer: major, minor.
    pub schema_version: [u32; 2],
    /// The program.
    pub generator: Generator,
    /// Target triple that the program was built for; bytes are promised for one target.
    pub target: String,
    /// The recipe.
    pub recipe: RecipeHead,
    /// Files that the recipe names, by key; the key `assets` is left out where there are none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub assets: Vec<AssetHead>,
    /// Seed.
    pub seed: u64,
    /// Samples (n).
    pub samples: u64,
    /// Samples in a shard; the last one may hold fewer.
    pub samples_per_shard: u64,
    /// Shards.
    pub shards: u64,
    /// Names of the recipe's classes; the position is the value of the column `class`.
    pub classes: Vec<String>,
    /// What the objects are: a name in [`crate::SUBJECTS`].
    pub subject: String,
    /// Names of the pixel classes; the position is the value in label images.
    pub pixel_classes: Vec<String>,
    /// Values that label images of the subject may have, in order.
    pub label_values: Vec<u8>,
    /// Shares of the splits.
    pub splits: SplitShares,
    /// Images.
    pub images: Images,
    /// Drawn numbers in the order of columns.
    pub parameters: Vec<NumberColumn>,
    /// Derived numbers in the order of columns.
    pub physics: Vec<NumberColumn>,
    /// What the check of the rig warns of; the key `warnings` is left out where that is nothing.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<RigWarning>,
}

impl DatasetHead {
    /// Shards that `samples` samples need.
    pub fn shards_for(samples: u64, samples_per_shard: u64) -> u64 {
        samples.div_ceil(samples_per_shard.max(1))
    }

    /// Why no dataset has so many samples and shards, or `None` where one can.
    ///
    /// ```
    /// # use output_schema::DatasetHead;
    /// assert!(DatasetHead::refuse_size(100, 25, 4).is_none());
    /// assert!(DatasetHead::refuse_size(100, 25, 5).unwrap().contains("not 5 shards"));
    /// assert!(DatasetHead::refuse_size(u64::MAX, 1, u64::MAX).unwrap().contains("at most"));
    /// ```
    pub fn refuse_size(samples: u64, samples_per_shard: u64, shards: u64) -> Option<String> {
        if samples_per_shard == 0 || shards != Self::shards_for(samples, samples_per_shard) {
            return Some(format!("{samples} samples in shards of {samples_per_shard} are not {shards} shards"));
        }
        if samples > MAX_SAMPLES || shards > MAX_SHARDS {
            return Some(format!(
                "{samples} samples in {shards} shards: at most {MAX_SAMPLES} samples in {MAX_SHARDS} shards"
            ));
        }
        (samples_per_shard > MAX_SAMPLES_PER_SHARD)
            .then(|| format!("{samples_per_shard} samples in a shard: at most {MAX_SAMPLES_PER_SHARD}"))
    }

    /// Why no dataset has such a head, or `None` where one can: from its sizes and names follows what is read of it at
    /// most.
    pub fn refuse(&self) -> Option<String> {
        let Images { cols, rows, sensor_cols, sensor_rows, .. } = self.images;
        let sides = [("cols", cols), ("rows", rows), ("sensor_cols", sensor_cols), ("sensor_rows", sensor_rows)];
        if let Some((name, side)) = sides.into_iter().find(|(_, side)| !(1..=MAX_SIDE).contains(side)) {
            return Some(format!("`images.{name}` is {side}, not 1 to {MAX_SIDE}"));
        }
        if cols * rows > MAX_PIXELS {
            return Some(format!("its images have {cols} x {rows} pixels, at most {MAX_PIXELS}"));
        }
        if !(1..=MAX_CLASSES).contains(&self.classes.len()) {
            return Some(format!("it names {} classes, not 1 to {MAX_CLASSES}", self.classes.len()));
        }
        let columns = self.parameters.iter().chain(&self.physics);
        let names = columns.flat_map(|column| [&column.group, &column.key]).chain(&self.classes);
        let longest = names.map(String::len).max().unwrap_or(0);
        if longest > MAX_NAME_BYTES {
            return Some(format!("it has a name of {longest} bytes, at most {MAX_NAME_BYTES}"));
        }
        if self.schema_version < [1, 6] && self.shards > SHARDS_PER_FOLDER {
            let [major, minor] = self.schema_version;
            return Some(format!(
                "its {} shards were written with schema {major}.{minor}, which has them all in one folder; from 1.6 \
                    on those after \
                 the first {SHARDS_PER_FOLDER} lie in folders of their own: read it with an older program, or make it \
                 again",
                self.shards
            ));
        }
        Self::refuse_size(self.samples, self.samples_per_shard, self.shards)
    }

    /// First index and count of a shard; the count is 0 past the end.
    pub fn span(&self, shard: u64) -> (u64, u64) {
        let first = shard.saturating_mul(self.samples_per_shard);
        (first, self.samples.saturating_sub(first).min(self.samples_per_shard))
    }

    /// The pixel classes that labels can show: values and names, in order.
    pub fn shown_classes(&self) -> impl Iterator<Item = (usize, &str)> {
        let name = |value: usize| self.pixel_classes.get(value).map(|name| (value, name.as_str()));
        self.label_values.iter().filter_map(move |&value| name(value.into()))
    }

    /// The channels of every EXR file, in the order of files; none where there are no such files.
    pub fn channels(&self) -> Vec<Channel> {
        if self.images.exr.is_empty() && self.schema_version < [1, 9] {
            return Vec::new();
        }
        channels(&self.images.exr, self.images.truth_maps, &self.subject, &self.images.range, self.images.bits)
    }

    /// Whether there are EXR files.
    pub fn has_exr(&self) -> bool {
        !self.channels().is_empty()
    }

    /// Unit of Range: `mm` or `px`.
    pub fn range_unit(&self) -> &'static str {
        range_form(&self.images.range).map_or("mm", |form| form.unit)
    }

    /// Whether the rows of this dataset have a column, or a field of one, that rows of the newest version have.
    pub fn has(&self, column: &Column) -> bool {
        let is_asked_for = match column.kind {
            ColumnKind::Image(_) => self.images.png.iter().any(|name| name == column.name),
            ColumnKind::RangeNumber => column.unit == self.range_unit(),
            _ => true,
        };
        is_asked_for && self.schema_version >= [1, column.since]
    }

    /// Groups of drawn numbers in the order of columns, each with its columns.
    pub fn groups(&self) -> Vec<(&str, Vec<&NumberColumn>)> {
        let mut groups: Vec<(&str, Vec<&NumberColumn>)> = Vec::new();
        for number in &self.parameters {
            match groups.iter_mut().find(|(name, _)| *name == number.group) {
                Some((_, columns)) => columns.push(number),
                None => groups.push((&number.group, vec![number])),
            }
        }
        groups
    }
}

/// Says why a document cannot be read by this version, or `None` where it can.
///
/// ```
/// assert!(output_schema::refuse_version("sheetlight-dataset", [1, 7]).is_none());
/// assert!(output_schema::refuse_version("sheetlight-dataset", [2, 0]).unwrap().contains("newer"));
/// assert!(output_schema::refuse_version("sheetlight-dataset", [1, 1]).unwrap().contains("lacks"));
/// ```
pub fn refuse_version(format: &str, version: [u32; 2]) -> Option<String> {
    let [major, minor] = version;
    let [known, _] = SCHEMA_VERSION;
    if format != FORMAT {
        Some(format!("its format is `{format}`, not `{FORMAT}`"))
    } else if major != known {
        let [age, program] = if major > known { ["newer", "a newer"] } else { ["older", "an older"] };
        Some(format!(
            "it was written with schema {major}.{minor}, {age} than {known}.x that this program reads; use {program} \
             program"
        ))
    } else if minor < OLDEST_MINOR {
        Some(format!(
            "it was written with schema {major}.{minor}, which lacks columns of {known}.{OLDEST_MINOR} that this \
                program reads; use an older program"
        ))
    } else {
        None
    }
}
