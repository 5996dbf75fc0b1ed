//! Shard size: how large a sample will be on disk, and how many of them make a shard.
//!
//! A shard is what a stop loses. To keep the samples of an unfinished one would need a second form of each on disk,
//! written and synced beside the first, and trusted when it is read.

use super::table_writer::ROW_GROUP_BYTES;
use optical_bench::settings::{Channel, Output, SensorStack, Size, Splits};

/// Largest shard that is aimed at [bytes]: it fits a download and a restart.
const TARGET_SHARD_BYTES: u64 = 500_000_000;
/// Work of a shard that is aimed at [core seconds]: a minute of two cores, all that a run loses which is stopped.
const TARGET_SHARD_SECONDS: f64 = 120.0;
/// Most samples in a shard, however small they are: manifests and folders stay readable.
const MAX_SAMPLES_PER_SHARD: u64 = 1000;
/// What numbers, objects and file headers take in a sample, on the large side [bytes].
pub const ROW_BYTES: u64 = 16_000;
/// What schemas and footers of a shard's tables, and its manifest, take, on the large side [bytes].
pub const TABLES_BYTES: u64 = 380_000;

/// What an open table takes besides its rows: encoders and decoders of 320 columns, a hundred kilobytes each [bytes].
const OPEN_TABLE_BYTES: u64 = 32_000_000;

/// What a dataset's own documents take, on the large side: `dataset.json`, `croissant.json`, the card [bytes].
pub const DOCUMENTS_BYTES: u64 = 400_000;

/// Bytes for each pixel of a noisy scan, from `benches/write.rs`, rounded up.
fn png_bytes(channel: Channel) -> f64 {
    match channel {
        Channel::Range => 1.4,
        Channel::Reflectance => 0.9,
        Channel::Grey => 0.8,
        Channel::Scatter => 1.3,
        Channel::Label => 0.02,
        Channel::Instance => 0.03,
    }
}

/// Bytes for each pixel of a noisy scan, from `benches/write.rs`, rounded up; Reflectance counts twice, see `Y`.
fn exr_bytes(channel: Channel) -> f64 {
    match channel {
        Channel::Range => 2.2,
        Channel::Reflectance => 1.6,
        Channel::Grey => 1.4,
        Channel::Scatter => 1.4,
        Channel::Label | Channel::Instance => 0.05,
    }
}

/// The same of what whole numbers leave of Range, means included, which leave something else everywhere.
const REST_BYTES: f64 = 1.3;
/// Bytes for each pixel of the three truth maps together.
const TRUTH_BYTES: f64 = 3.0;
/// Bytes for each pixel of a sensor frame of 8 bits: most of it is dark noise.
const FRAME_BYTES: f64 = 0.4;
/// Bytes that each bit beyond 8 adds to a pixel of a frame, and to one of Reflectance: noise does not compress.
const BIT_BYTES: f64 = 0.15;

/// Estimate of what one sample takes on disk [bytes], on the large side; a pure function of sizes and output.
pub fn estimated_bytes_per_sample(output: &Output, size: &Size) -> u64 {
    let cols = size.columns / output.bin_columns.max(1);
    let rows = size.profiles / output.bin_profiles.max(1);
    let png: f64 = output.png.iter().map(|&channel| png_bytes(channel)).sum();
    let exr: f64 = output.exr.iter().map(|&channel| exr_bytes(channel)).sum();
    let rest = if output.range_rest { REST_BYTES } else { 0.0 };
    let truth = if output.truth_maps { TRUTH_BYTES } else { 0.0 };
    let more = f64::from(output.bits.saturating_sub(8)) * BIT_BYTES;
    let deep = if output.has(Channel::Grey) { 5.0 } else { 3.0 };
    let images = (cols * rows) as f64 * (png + exr + rest + truth + deep * more);
    ROW_BYTES + (images + frame_bytes(output, size)).ceil() as u64
}

/// Bytes of the sensor frames of a sample.
fn frame_bytes(output: &Output, size: &Size) -> f64 {
    let more = f64::from(output.bits.saturating_sub(8)) * BIT_BYTES;
    (output.frames(size) * size.columns * size.rows) as f64 * (FRAME_BYTES + more)
}

/// What the tables of a shard of `samples` samples take while they are open [bytes]: each holds the rows of a group, or
/// all that it has, but for the row that fills the group: its sample is held too.
pub fn open_tables_bytes(output: &Output, size: &Size, splits: &Splits, samples: u64) -> u64 {
    let frames = frame_bytes(output, size);
    let in_tables = Output {
        exr: Vec::new(),
        range_rest: false,
        truth_maps: false,
        sensor_stack: SensorStack::None,
        ..output.clone()
    };
    let row = estimated_bytes_per_sample(&in_tables, size) as f64;
    let group = |share: f64, bytes: f64| match share * bytes {
        0.0 => 0,
        _ => OPEN_TABLE_BYTES + (share * bytes * samples as f64).min(ROW_GROUP_BYTES as f64).ceil() as u64,
    };
    let mut rows = [splits.train, splits.validation, splits.test].map(|share| group(share, row));
    rows.sort_unstable_by(|a, b| b.cmp(a));
    // A table is begun with its first sample.
    rows.iter().take(samples as usize).sum::<u64>() + group(1.0, frames)
}

/// Samples in a shard: what the recipe asks for, else as many as stay under about 500 MB and about a minute's work of
/// two cores, at most 1000, at least 1; a sample takes `sample_seconds` of one core. A pure function of sizes, output
/// and that, which is fixed too, so that every process cuts alike.
pub fn samples_per_shard(output: &Output, size: &Size, sample_seconds: f64) -> usize {
    let of_work = (TARGET_SHARD_SECONDS / sample_seconds) as u64;
    let of_bytes = TARGET_SHARD_BYTES / estimated_bytes_per_sample(output, size);
    let fitting = of_bytes.min(of_work).clamp(1, MAX_SAMPLES_PER_SHARD);
    output.samples_per_shard.unwrap_or(fitting as usize).max(1)
}
