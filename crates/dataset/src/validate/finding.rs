//! Findings: the rules that a dataset can break, what to do about each, and a fault that breaks one.

use serde::Serialize;

use crate::Fault;
use crate::shares::Shortfall;

/// Declares the codes with their meaning: the words of the declaration are those of the table in `docs/validate.md`.
macro_rules! codes {
    ($($(#[doc = $doc:literal])+ $name:ident,)+) => {
        /// A rule that a dataset can break.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
        #[serde(rename_all = "kebab-case")]
        pub enum Code {
            $($(#[doc = $doc])+ $name,)+
        }

        impl Code {
            /// Every code in order.
            pub const ALL: &'static [Self] = &[$(Self::$name,)+];

            /// What is wrong.
            pub fn meaning(self) -> &'static str {
                match self {
                    $(Self::$name => concat!($($doc,)+).trim_ascii(),)+
                }
            }
        }
    };
}

codes! {
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
    /// The dataset was written with another minor version of the schema: much of it cannot be compared.
    VersionDiffers,
    /// A shard has no manifest: it is not finished.
    ManifestMissing,
    /// A manifest is no document of this format.
    ManifestUnreadable,
    /// A manifest belongs to another dataset, or counts other samples or files than it should.
    ManifestDiffers,
    /// A file of the manifest is not there.
    FileMissing,
    /// A file or folder is there, but may not be read.
    FileUnreadable,
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
    /// A drawn number, or what follows from the draws without light, is not what recipe, seed and index give.
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
    /// An image or EXR file has a header, or a part, that the program does not write.
    HeaderDiffers,
    /// Range is missing where light was measured, or the other way round.
    MissingRule,
    /// A label that is no pixel class.
    LabelUnknown,
    /// An object's area or box is not what the instance image shows, an instance has no object, or `defect_classes` is
    /// not what pixels show.
    ObjectDiffers,
    /// A pixel has another class than its instance, or an instance where there is none.
    InstanceClass,
    /// Labels or objects are not what the truth maps show; a warning where the recipe cannot be drawn again.
    TruthDiffers,
    /// Labels or instances are not those of the body that the recipe makes.
    LabelDiffers,
    /// The area of a class is not what the label image shows.
    ClassAreaDiffers,
    /// The measured or the saturated share is not what the images show.
    ShareDiffers,
    /// An EXR file cannot be read.
    ExrUnreadable,
    /// An EXR file has other channels, types or size than declared.
    ExrChannels,
    /// An EXR file says something else than the row's images.
    ExrDiffers,
    /// The maps of a sample have another SHA-256 than the manifest says.
    SampleChecksum,
    /// The dataset card or `croissant.json` lacks a line that the program wrote.
    CardDiffers,
    /// The sensor frames are not those that the recipe keeps.
    StackDiffers,
    /// A sensor frame is 0 everywhere, and is not when it is exposed again; a warning where it cannot be.
    StackBlank,
    /// Two sensor frames have the same pixels, noise and all.
    StackRepeated,
    /// A sample could not be rendered again.
    RerenderFailed,
    /// A sample that was rendered again is not what is on disk.
    RerenderDiffers,
    /// A row or a sensor frame that was exposed again is not what is on disk.
    ProfileDiffers,
    /// Warning: Range seems to be nowhere near the body that the recipe makes.
    RangeDiffers,
    /// Warning: the label's outline seems not to be where Range steps from the conveyor to the object.
    OutlineDiffers,
    /// Warning: in the middle of a knot the fibre seems to dive otherwise than the knot's axis.
    DiveDiffers,
    /// Warning: two samples have the same measured maps.
    SampleRepeated,
    /// Warning: two samples seem to share their noise: one is a copy of the other with small changes.
    SampleAlike,
    /// Warning: less than two thirds of the object lie in the field of the images, or no pixel shows it.
    ObjectOutOfView,
    /// Warning: Range is measured in less than a tenth of the pixels that show the object.
    HardlyMeasured,
    /// Warning: Range is measured in less than 80 % of the pixels that show matter without defect.
    PartlyMeasured,
    /// Warning: the line saturates in 95 % of the object's measured pixels, or more.
    Saturated,
}

impl From<Shortfall> for Code {
    fn from(shortfall: Shortfall) -> Self {
        match shortfall {
            Shortfall::ObjectOutOfView => Self::ObjectOutOfView,
            Shortfall::HardlyMeasured => Self::HardlyMeasured,
            Shortfall::PartlyMeasured => Self::PartlyMeasured,
            Shortfall::Saturated => Self::Saturated,
        }
    }
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
            Self::CardDiffers => "remove the file and run the command that made the dataset again: it writes it anew",
            Self::WriterDiffers => "validate with the program version and target that the message names",
            Self::VersionDiffers => "validate with the program version that wrote the dataset; it stays readable",
            Self::VersionUnknown => "use the program version that the message names",
            Self::ManifestMissing => "run the command that began the dataset to continue it",
            Self::FileUnreadable => "let it be read by whom `gen` runs for; nothing is known to be wrong with it",
            Self::FileUnexpected => "remove the file, or continue the dataset if it is being written",
            Self::RerenderFailed => "validate with the recipe and program version of dataset.json",
            Self::RangeDiffers => "look at the sample: this is an estimate; --rows 1 compares Range exactly",
            Self::OutlineDiffers | Self::DiveDiffers => LOOK,
            Self::SampleRepeated | Self::SampleAlike => {
                "look at both samples: this is an estimate; --rows 1 compares them exactly, with the version that wrote them"
            }
            Self::ObjectOutOfView => Shortfall::ObjectOutOfView.remedy(),
            Self::HardlyMeasured => Shortfall::HardlyMeasured.remedy(),
            Self::PartlyMeasured => Shortfall::PartlyMeasured.remedy(),
            Self::Saturated => Shortfall::Saturated.remedy(),
            Self::RerenderDiffers => "use the same program version and target; if they are the same, report it",
            Self::ManifestUnreadable
            | Self::ManifestDiffers
            | Self::FileMissing
            | Self::FileSize
            | Self::FileChecksum
            | Self::TableUnreadable
            | Self::SampleChecksum => "remove the shard's manifest and run the command again: the shard is made again",
            _ => {
                "remove the shard's manifest and run the command again; if it comes back, report it with recipe, seed and index"
            }
        }
    }
}

/// What to do about what is likely wrong, where nothing exact can be compared.
pub(super) const LOOK: &str =
    "look at the sample: this is an estimate; the program version that wrote the dataset compares exactly";

/// Every code with its meaning and remedy, as a table in Markdown.
pub fn fault_table() -> String {
    let row = |code: &Code| format!("| `{}` | {} | {} |\n", code.name(), code.meaning(), code.remedy());
    format!("| code | what is wrong | what to do |\n|---|---|---|\n{}", Code::ALL.iter().map(row).collect::<String>())
}

/// One broken rule.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Finding {
    /// The rule.
    pub code: Code,
    /// File, and sample where it is about one; what is wrong there, and what to do.
    #[serde(flatten)]
    pub fault: Fault,
}

impl Finding {
    /// A fault with the remedy of its code.
    pub fn new(code: Code, place: impl Into<String>, what: impl Into<String>) -> Self {
        Self { code, fault: Fault::new(place, what, code.remedy()) }
    }

    /// The same with a remedy that fits better.
    pub(super) fn with_remedy(mut self, remedy: &'static str) -> Self {
        self.fault.remedy = remedy.into();
        self
    }
}
