//! Rules: every finding of `gen validate`, each a file with its sentence, its remedy and its check. What tells it in a
//! damaged dataset stands in `tests/validate/sabotage`, and the table of docs/guide/faults.md is made from here.
//!
//! What all of them name ([`Code`], [`Rule`], [`SampleToCheck`], [`ValidationReport`]) they take from here. Rules whose
//! checks share one pass, such as the reading of a file, are one file, which says so. A rule about one sample is called
//! by `of_sample`; others are called where what they are about is read.

pub(super) mod card_differs;
mod class_area_differs;
pub(super) mod dataset_differs;
pub(super) mod dataset_json;
pub(super) mod dive_differs;
mod draw_differs;
pub(super) mod duplicates;
pub(super) mod exr;
pub(super) mod files;
mod header_differs;
pub(super) mod id_repeated;
pub(super) mod images;
mod instance_class;
mod label_differs;
pub(super) mod label_unknown;
pub(super) mod manifests;
mod missing_rule;
mod object_differs;
pub(super) mod of_sample;
mod outline_differs;
pub(super) mod profile_differs;
mod range_differs;
pub(super) mod recipe;
mod rerender;
mod row_differs;
mod sample_checksum;
mod shares;
pub(super) mod stack;
pub(super) mod tables;
pub(super) mod truth_differs;
mod value_range;

use serde::Serialize;

pub(super) use super::report::ValidationReport;
pub(super) use super::sample_to_check::SampleToCheck;
use crate::Fault;

/// What to do about a shard whose files are not those that were written.
const REMAKE: &str = "remove the shard's manifest and run the command again: the shard is made again";
/// What to do about a shard whose content is wrong in itself.
const REMAKE_OR_REPORT: &str =
    "remove the shard's manifest and run the command again; if it comes back, report it with recipe, seed and index";
/// What to do about a `dataset.json` that was changed.
const RESTORE: &str = "bring dataset.json back from a copy: what it says no longer fits its samples";
/// What to do about what is likely wrong, where nothing exact can be compared.
pub(super) const LOOK: &str =
    "look at the sample: this is an estimate; the program version that wrote the dataset compares exactly";

/// What is said of a finding, wherever it is.
pub(super) struct Rule {
    /// What is wrong, in one sentence.
    meaning: &'static str,
    /// What to do.
    remedy: &'static str,
}

/// Declares the codes in their order, each with the file and the name of its rule.
macro_rules! codes {
    ($($code:ident => $file:ident::$rule:ident,)+) => {
        /// A rule that a dataset can break.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
        #[serde(rename_all = "kebab-case")]
        pub enum Code {
            $(#[doc = concat!("Told by `rules/", stringify!($file), ".rs`.")] $code,)+
        }

        impl Code {
            /// Every code in order.
            pub const ALL: &'static [Self] = &[$(Self::$code,)+];

            fn rule(self) -> &'static Rule {
                match self {
                    $(Self::$code => &$file::$rule,)+
                }
            }
        }
    };
}

codes! {
    DatasetMissing => dataset_json::MISSING,
    DatasetUnreadable => dataset_json::UNREADABLE,
    DatasetDiffers => dataset_differs::RULE,
    RecipeDiffers => recipe::RECIPE_DIFFERS,
    WriterDiffers => recipe::WRITER_DIFFERS,
    VersionUnknown => dataset_json::VERSION_UNKNOWN,
    VersionDiffers => dataset_json::VERSION_DIFFERS,
    ManifestMissing => manifests::MISSING,
    ManifestUnreadable => manifests::UNREADABLE,
    ManifestDiffers => manifests::DIFFERS,
    FileMissing => files::MISSING,
    FileUnreadable => files::UNREADABLE,
    FileSize => files::SIZE,
    FileChecksum => files::CHECKSUM,
    FileUnexpected => files::UNEXPECTED,
    TableUnreadable => tables::UNREADABLE,
    SchemaDiffers => tables::SCHEMA_DIFFERS,
    RowCount => tables::ROW_COUNT,
    IndexOrder => tables::INDEX_ORDER,
    IdRepeated => id_repeated::RULE,
    RowDiffers => row_differs::RULE,
    DrawDiffers => draw_differs::RULE,
    ClassUnknown => row_differs::CLASS_UNKNOWN,
    NumberMissing => tables::NUMBER_MISSING,
    ValueRange => value_range::RULE,
    ImageUnreadable => images::UNREADABLE,
    ImageSize => images::SIZE,
    HeaderDiffers => header_differs::RULE,
    MissingRule => missing_rule::RULE,
    LabelUnknown => label_unknown::RULE,
    ObjectDiffers => object_differs::RULE,
    InstanceClass => instance_class::RULE,
    TruthDiffers => truth_differs::RULE,
    LabelDiffers => label_differs::RULE,
    ClassAreaDiffers => class_area_differs::RULE,
    ShareDiffers => shares::DIFFERS,
    ExrUnreadable => exr::UNREADABLE,
    ExrChannels => exr::CHANNELS,
    ExrDiffers => exr::DIFFERS,
    SampleChecksum => sample_checksum::RULE,
    CardDiffers => card_differs::RULE,
    StackDiffers => stack::DIFFERS,
    StackBlank => stack::BLANK,
    StackRepeated => stack::REPEATED,
    RerenderFailed => rerender::FAILED,
    RerenderDiffers => rerender::DIFFERS,
    ProfileDiffers => profile_differs::RULE,
    RangeDiffers => range_differs::RULE,
    OutlineDiffers => outline_differs::RULE,
    DiveDiffers => dive_differs::RULE,
    SampleRepeated => duplicates::REPEATED,
    SampleAlike => duplicates::ALIKE,
    ObjectOutOfView => shares::OBJECT_OUT_OF_VIEW,
    HardlyMeasured => shares::HARDLY_MEASURED,
    PartlyMeasured => shares::PARTLY_MEASURED,
    Saturated => shares::SATURATED,
}

impl Code {
    /// Name in reports.
    pub fn name(self) -> String {
        // A unit variant becomes a JSON string.
        serde_json::to_value(self).ok().and_then(|v| v.as_str().map(String::from)).unwrap_or_default()
    }

    /// What is wrong.
    pub fn meaning(self) -> &'static str {
        self.rule().meaning
    }

    /// What to do.
    pub fn remedy(self) -> &'static str {
        self.rule().remedy
    }
}

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
