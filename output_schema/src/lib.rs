//! What is on disk: every file, column and channel of a Sheetlight dataset, as plain tables.
//!
//! - [`row`], [`calibration`], [`channel`], [`stack`], [`file`], [`subject`]: the declarations -> name, type, unit,
//!   range, missing rule, meaning.
//! - [`arrow`]: declarations + [`DatasetHead`] -> Arrow schema with the metadata that `datasets` reads.
//! - [`dataset`], [`manifest`]: the two JSON documents as structs.
//! - [`json`]: everything -> JSON Schema and tables for programs.
//! - [`dictionary`]: everything -> `output_schema/README.md` for people.
//!
//! Nothing here knows physics, a recipe's keys or how a byte is written.

pub mod arrow;
pub mod calibration;
pub mod channel;
pub mod column;
pub mod dataset;
pub mod dictionary;
pub mod file;
pub mod json;
pub mod manifest;
pub mod row;
pub mod stack;
pub mod subject;

pub use channel::{CHANNELS, Channel, SampleType};
pub use column::{Column, ColumnKind, NumberColumn, Source, unit_of};
pub use dataset::{
    AssetHead, DatasetHead, FORMAT, Generator, Images, MAX_SAMPLES, MAX_SHARDS, OLDEST_MINOR, RecipeHead, RigWarning,
    SCHEMA_VERSION, SplitShares, refuse_version,
};
pub use json::json_schema;
pub use manifest::{Manifest, ManifestFile, ManifestSample};
pub use subject::{SUBJECTS, label_values, pixel_classes};
