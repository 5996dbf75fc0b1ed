//! Largest files: how many bytes a file of a dataset can have, as its head declares it. Nothing larger is read.
//!
//! Generous: pixels that do not compress at all, an eighth more, and room for what stands around them.

use output_schema::{DatasetHead, SampleType};

/// `dataset.json`, the card and `croissant.json` [bytes]: a recipe has 1 MiB at most.
pub(crate) const DOCUMENT_BYTES: u64 = 16 << 20;
/// A copy of a file that a recipe names, as recipes allow [bytes].
pub(crate) const ASSET_BYTES: u64 = 256 << 20;
/// Most samples that any shard has, as recipes and the command line allow.
const MAX_SAMPLES_PER_SHARD: u64 = 100_000;
/// What a manifest says of a sample and of its file [bytes]: two sums, an id, a path, keys and blanks; a class has 64
/// bytes.
const LISTED_BYTES: u64 = 1 << 10;
/// Numbers, texts and objects of a row; headers and texts of an EXR file [bytes].
const ROW_BYTES: u64 = 1 << 20;
/// Schema, footer and indices of a table; a manifest without samples [bytes].
const TABLE_BYTES: u64 = 16 << 20;
/// Most pixels of an image, as recipes allow.
const MAX_PIXELS: u64 = 1 << 27;
/// Most profiles of a scan, as recipes allow.
const MAX_PROFILES: u64 = 16_383;

/// A manifest of the dataset.
pub(crate) fn manifest_bytes(head: &DatasetHead) -> u64 {
    TABLE_BYTES + samples(head) * LISTED_BYTES
}

/// A table of rows.
pub(crate) fn table_bytes(head: &DatasetHead) -> u64 {
    let images = with_room(pixels(head).saturating_mul(2 * head.images.png.len() as u64));
    TABLE_BYTES.saturating_add(samples(head).saturating_mul(images.saturating_add(ROW_BYTES)))
}

/// An EXR file.
pub(crate) fn exr_bytes(head: &DatasetHead) -> u64 {
    let bytes = |samples: SampleType| if samples == SampleType::Half { 2 } else { 4 };
    let pixel: u64 = head.channels().iter().map(|channel| bytes(channel.samples)).sum();
    with_room(pixels(head).saturating_mul(pixel)).saturating_add(ROW_BYTES)
}

/// A table of sensor frames.
pub(crate) fn stack_bytes(head: &DatasetHead) -> u64 {
    let profiles = head.recipe.canonical["scan"]["profiles"].as_u64().unwrap_or(MAX_PROFILES).min(MAX_PROFILES);
    let frames = profiles.div_ceil(head.images.stack_every.unwrap_or(1).max(1));
    let frame = head.images.sensor_cols.saturating_mul(head.images.sensor_rows).min(MAX_PIXELS);
    let frames = samples(head).saturating_mul(frames).saturating_mul(with_room(2 * frame).saturating_add(LISTED_BYTES));
    TABLE_BYTES.saturating_add(frames)
}

fn samples(head: &DatasetHead) -> u64 {
    head.samples_per_shard.min(MAX_SAMPLES_PER_SHARD)
}

fn pixels(head: &DatasetHead) -> u64 {
    head.images.cols.saturating_mul(head.images.rows).min(MAX_PIXELS)
}

fn with_room(bytes: u64) -> u64 {
    bytes.saturating_add(bytes / 8)
}
