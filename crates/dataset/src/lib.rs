//! Dataset on disk: what a dataset folder holds, how shards are written, continued and read.
//!
//! ```text
//! Record --encode--> Encoded --push--> ShardWriter --finish--> files, then the manifest
//! files --Dataset::open--> Dataset --tables, rows, images, EXR maps, sensor frames--> plain values, or a Fault
//! ```
//!
//! A shard is there when its manifest is there: files are written under temporary names that start with `.tmp-`, synced
//! and renamed, and the manifest comes last. A process that is killed leaves temporary names and an unlocked lock file;
//! whoever takes the shard next removes them and starts the shard again. Two processes never write one shard: the
//! kernel holds the lock, and lets go of it when the process ends in whatever way.
//!
//! A folder may come from anybody: every file in it goes by [`enclosed`], which follows no link and opens only plain
//! files of a size that the head allows.
//!
//! What is in the files is declared in [`output_schema`]; bytes depend on records and output alone, never on threads,
//! processes or the time.

pub mod record;
pub mod validate;

pub mod atomic_file;
mod card;
mod croissant;
mod differences;
pub mod enclosed;
mod encoding;
mod exr;
mod fault;
mod folder;
pub mod kept_lines;
mod largest;
mod limits;
mod lock;
mod png;
mod range_rest;
mod reader;
mod recipe_words;
mod sample_rows;
mod shard_size;
mod shard_writer;
pub mod shares;
mod table_bounds;
mod table_reader;
mod table_writer;

pub use atomic_file::{free_bytes, hex};
pub(crate) use card::ClassCounts;
pub use differences::differences;
pub use encoding::encode;
pub(crate) use encoding::image_of;
pub use exr::{ExrChannel, read_exr, write_exr, write_exr_as};
pub(crate) use exr::{ExrDescription, ExrSize, channel_types, expected_header, exr_header, read_exr_of};
pub(crate) use exr::{RANGE_REST, map_channels, truth_channel};
pub use fault::{Fault, describe_bytes, one_line, own_remedy, plain};
pub(crate) use folder::descriptions;
pub use png::{Grey, range_numbers, range_values, read_png, read_png_of, rounded8, rounded16, write_png, write_png_as};
pub(crate) use png::{PngSize, foreign_part, png_size};
pub use range_rest::range_joined;
pub(crate) use reader::to_document;
pub use reader::{Dataset, DatasetSums, ExrMaps, FinishedTables, is_dataset};
pub use recipe_words::objects_in_words;
pub use sample_rows::{Encoded, encode_numbers, row_batch};
pub(crate) use sample_rows::{cell, frame_numbers, image_path, maps_sha256, object_cells};
pub use shard_size::{
    DOCUMENTS_BYTES, ROW_BYTES, TABLES_BYTES, estimated_bytes_per_sample, open_tables_bytes, samples_per_shard,
};
pub use shard_writer::{Claim, ShardWriter};
pub(crate) use table_bounds::{TableBounds, check_lengths};
pub use table_reader::{JsonRow, ObjectRow, RowBatch, RowQuery, Rows, StoredImage, Table};

use output_schema::{Images, NumberColumn};

use optical_bench::settings::{Output, RangeForm, SensorStack, Size};

/// Version of the program; another version may give other numbers.
pub const GENERATOR_VERSION: &str = env!("CARGO_PKG_VERSION");

/// Day of that version, which stands where metadata wants a date: no clock goes into files. The same as in
/// CHANGELOG.md, or the day on which work on the version began while it is unreleased.
pub(crate) const GENERATOR_DATE: &str = "2026-11-21";

/// The declaration of a parameter as a column.
pub fn number_column(parameter: &base::Parameter) -> NumberColumn {
    NumberColumn::new(parameter.group, parameter.name, parameter.doc)
}

/// What a recipe's sizes and output say about the images.
pub fn images(output: &Output, size: &Size, range: RangeForm) -> Images {
    let names = |channels: &[optical_bench::settings::Channel]| {
        let mut channels = channels.to_vec();
        channels.sort_unstable();
        channels.dedup();
        channels.into_iter().map(|channel| channel.name().to_string()).collect()
    };
    Images {
        cols: (size.columns / output.bin_columns.max(1)) as u64,
        rows: (size.profiles / output.bin_profiles.max(1)) as u64,
        png: names(&output.png),
        exr: output.exr_names(),
        range: range.name().into(),
        truth_maps: output.truth_maps,
        stack_every: match output.sensor_stack {
            SensorStack::None => None,
            SensorStack::Every(step) => Some(step.max(1) as u64),
            SensorStack::All => Some(1),
        },
        sensor_cols: size.columns as u64,
        sensor_rows: size.rows as u64,
        bits: output.bits.into(),
    }
}
