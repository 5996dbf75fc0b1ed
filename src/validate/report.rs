//! What validation found.

use std::fmt;

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::balance::Statistics;

/// A rule that a dataset can break.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Code {
    /// `dataset.json` is not there.
    DatasetMissing,
    /// `dataset.json` is no document of this format.
    DatasetUnreadable,
    /// `dataset.json` says something else than its recipe gives, or is not written as the program writes it.
    DatasetDiffers,
    /// The recipe in `dataset.json` does not load, or means something else than it did.
    RecipeDiffers,
    /// Another version of the program, or one for another target, wrote the dataset: its draws cannot be compared.
    WriterDiffers,
    /// The dataset was written with a schema that this program does not read.
    VersionUnknown,
    /// A shard has no manifest: it is not finished.
    ManifestMissing,
    /// A manifest is no document of this format.
    ManifestUnreadable,
    /// A manifest belongs to another dataset, or counts other samples or files than it should.
    ManifestDiffers,
    /// A file of the manifest is not there.
    FileMissing,
    /// A file has another size than its manifest says.
    FileSize,
    /// A file has another SHA-256 than its manifest says.
    FileChecksum,
    /// A file that no manifest names.
    FileUnexpected,
    /// A Parquet file cannot be read.
    TableUnreadable,
    /// A Parquet file has other columns than declared.
    SchemaDiffers,
    /// A Parquet file has more or fewer rows than it should.
    RowCount,
    /// The indices in a file are not those of its shard and split, in order.
    IndexOrder,
    /// Two samples have one id.
    IdRepeated,
    /// A row says another id, split, class or seed than its file, manifest or `dataset.json`.
    RowDiffers,
    /// A drawn number is not what recipe, seed and index give.
    DrawDiffers,
    /// A row has a class that `dataset.json` does not name.
    ClassUnknown,
    /// A number that can never be missing is missing.
    NumberMissing,
    /// A number is outside of its range.
    ValueRange,
    /// An image cannot be decoded.
    ImageUnreadable,
    /// An image has another size or bit depth than declared.
    ImageSize,
    /// Range is missing where light was measured, or the other way round.
    MissingRule,
    /// A label that is no pixel class.
    LabelUnknown,
    /// An object's area or box is not what the instance image shows, or an instance has no object.
    ObjectDiffers,
    /// A pixel has another class than its instance, or an instance where there is none.
    InstanceClass,
    /// Labels or objects are not what the truth maps show.
    TruthDiffers,
    /// The label's outline is not where Range steps from the conveyor to the object.
    OutlineDiffers,
    /// The area of a class is not what the label image shows.
    ClassAreaDiffers,
    /// An EXR file cannot be read.
    ExrUnreadable,
    /// An EXR file has other channels, types or size than declared.
    ExrChannels,
    /// An EXR file says something else than the row's images.
    ExrDiffers,
    /// The maps of a sample have another SHA-256 than the manifest says.
    SampleChecksum,
    /// Two samples have the same measured maps.
    SampleRepeated,
    /// Two samples share their noise: one is a copy of the other with small changes.
    SampleAlike,
    /// The dataset card lacks a line that the program wrote.
    CardDiffers,
    /// The sensor frames are not those that the recipe keeps.
    StackDiffers,
    /// The classes come otherwise than the recipe's shares give.
    ClassBalance,
    /// The splits come otherwise than the recipe's shares make likely.
    SplitBalance,
    /// The drawn numbers of a parameter are spread otherwise than its declaration makes likely.
    DistributionDiffers,
    /// A sensor frame is 0 everywhere.
    StackBlank,
    /// Two sensor frames have the same pixels, noise and all.
    StackRepeated,
    /// A sample could not be rendered again.
    RerenderFailed,
    /// A sample that was rendered again is not what is on disk.
    RerenderDiffers,
}

impl Code {
    /// Name in reports.
    pub fn name(self) -> String {
        // A unit variant becomes a JSON string.
        serde_json::to_value(self).ok().and_then(|v| v.as_str().map(String::from)).unwrap_or_default()
    }

    /// What to do.
    pub fn remedy(self) -> &'static str {
        match self {
            Self::DatasetMissing => "name the folder that holds dataset.json",
            Self::DatasetUnreadable => "bring dataset.json back from a copy, or make the dataset again",
            Self::DatasetDiffers | Self::RecipeDiffers => {
                "bring dataset.json back from a copy: what it says no longer fits its samples"
            }
            Self::CardDiffers => "remove the card and run the command that began the dataset: it is written again",
            Self::SampleRepeated | Self::SampleAlike => "remove the manifests of both shards and run the command again",
            Self::WriterDiffers => "validate with the program version and target that the message names",
            Self::VersionUnknown => "use the program version that the message names",
            Self::ManifestMissing => "run the command that began the dataset to continue it",
            Self::FileUnexpected => "remove the file, or continue the dataset if it is being written",
            Self::ClassBalance | Self::SplitBalance | Self::DistributionDiffers => {
                "samples were left out, added or drawn otherwise: make the dataset again from its recipe"
            }
            Self::RerenderFailed => "validate with the recipe and program version of dataset.json",
            Self::RerenderDiffers => "use the same program version and target; if they are the same, report it",
            Self::ManifestUnreadable
            | Self::ManifestDiffers
            | Self::FileMissing
            | Self::FileSize
            | Self::FileChecksum
            | Self::TableUnreadable
            | Self::SampleChecksum => "remove the shard's manifest and run the command again: the shard is made again",
            _ => "the writer is at fault: report it with recipe, seed and index",
        }
    }
}

/// One broken rule.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Fault {
    /// The rule.
    pub code: Code,
    /// File, and sample where it is about one.
    pub place: String,
    /// What is wrong.
    pub what: String,
    /// What to do.
    pub remedy: &'static str,
}

impl Fault {
    /// A fault with the remedy of its code.
    pub fn new(code: Code, place: impl Into<String>, what: impl Into<String>) -> Self {
        Self { code, place: place.into(), what: what.into(), remedy: code.remedy() }
    }
}

/// Everything that validation found, and how much it looked at.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Report {
    /// Broken rules, in the order of shards.
    pub faults: Vec<Fault>,
    /// Shards that have a manifest.
    pub shards: u64,
    /// Files whose checksum was computed.
    pub files: u64,
    /// Size of those files [bytes].
    pub bytes: u64,
    /// Rows that were read.
    pub samples: u64,
    /// Images that were decoded, EXR channels included.
    pub images: u64,
    /// Samples that were rendered again.
    pub rerendered: u64,
    /// Indices of the samples that were chosen for that.
    pub chosen: Vec<u64>,
    /// Classes, splits and drawn numbers against the recipe; null where there is none to compare with.
    pub statistics: Option<Statistics>,
}

/// Faults of one code that [`Report`] prints in full.
const PRINTED: usize = 8;

impl Report {
    /// Whether no rule is broken.
    pub fn is_clean(&self) -> bool {
        self.faults.is_empty()
    }

    /// Everything as JSON, with the number of faults of each code.
    pub fn json(&self) -> Value {
        let mut counts = serde_json::Map::new();
        for code in self.codes() {
            counts.insert(code.name(), self.faults.iter().filter(|f| f.code == code).count().into());
        }
        // Plain data always becomes JSON.
        let mut value = serde_json::to_value(self).unwrap_or_default();
        value["clean"] = json!(self.is_clean());
        value["fault_counts"] = Value::Object(counts);
        value
    }

    /// The codes of the faults, each once, in order.
    pub fn codes(&self) -> Vec<Code> {
        let mut codes: Vec<Code> = self.faults.iter().map(|fault| fault.code).collect();
        codes.sort_unstable();
        codes.dedup();
        codes
    }

    pub(super) fn add(&mut self, other: Self) {
        self.faults.extend(other.faults);
        self.shards += other.shards;
        self.files += other.files;
        self.bytes += other.bytes;
        self.samples += other.samples;
        self.images += other.images;
        self.rerendered += other.rerendered;
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut kinds: Vec<(Code, &str)> = Vec::new();
        for code in self.codes() {
            for fault in self.faults.iter().filter(|fault| fault.code == code) {
                if !kinds.contains(&(code, fault.remedy)) {
                    kinds.push((code, fault.remedy));
                }
            }
        }
        for (code, remedy) in kinds {
            let faults: Vec<&Fault> =
                self.faults.iter().filter(|fault| (fault.code, fault.remedy) == (code, remedy)).collect();
            writeln!(f, "{} ({}): {remedy}", code.name(), faults.len())?;
            for fault in faults.iter().take(PRINTED) {
                writeln!(f, "  {}: {}", fault.place, fault.what)?;
            }
            if faults.len() > PRINTED {
                writeln!(f, "  ... and {} more", faults.len() - PRINTED)?;
            }
        }
        let megabytes = self.bytes as f64 / 1e6;
        write!(
            f,
            "checked {} shards, {} files ({megabytes:.1} MB), {} samples, {} images; {} rendered again; {} faults",
            self.shards,
            self.files,
            self.samples,
            self.images,
            self.rerendered,
            self.faults.len()
        )
    }
}
