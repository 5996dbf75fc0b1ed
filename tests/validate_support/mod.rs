//! Datasets that are damaged in one way, and what validation says about them.

#![allow(dead_code)]

use std::fs::{self, File};
use std::path::Path;

use arrow_array::RecordBatch;
use output_schema::Manifest;
use parquet::arrow::ArrowWriter;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use serde_json::Value;
use sha2::{Digest, Sha256};
use sheetlight::settings::Channel;
use sheetlight::shard::{
    DatasetFolder, Encoded, ExrChannel, Grey, ShardWriter, read_exr, read_png, write_exr, write_png,
};
use sheetlight::validate::{Code, Options, Report, validate};
use tempfile::TempDir;

use crate::shard_support::{SIZE, encoded, head, output, write_dataset};

/// A file of the damaged dataset.
pub const DATA: &str = "data/train-00000.parquet";
/// A file of the damaged dataset.
pub const EXR: &str = "exr/00000/00000000-0000-5000-8000-000000000002.exr";
/// A file of the damaged dataset.
pub const MANIFEST: &str = "shards/00000.json";

pub fn check(place: &TempDir) -> Report {
    let report = validate(place.path(), &Options::default());
    // Both forms can be made of every report.
    assert_eq!(report.json()["faults"].as_array().map(Vec::len), Some(report.faults.len()));
    assert!(report.to_string().contains("faults"));
    report
}

/// A dataset of four samples, then `damage`, then what validation says.
pub fn after(damage: impl Fn(&Path)) -> Vec<Code> {
    let place = tempfile::tempdir().expect("a folder");
    write_dataset(place.path(), 4, &output());
    damage(place.path());
    check(&place).codes()
}

/// A dataset whose sample 2 was changed before it was written.
pub fn with(change: impl Fn(&mut Encoded)) -> Vec<Code> {
    let place = tempfile::tempdir().expect("a folder");
    let folder = DatasetFolder::open_or_create(place.path(), head(&output(), &SIZE, 4)).expect("it opens");
    let mut writer = ShardWriter::create(&folder, 0).expect("the shard is free");
    for index in 0..4 {
        let mut sample = encoded(index, &output());
        if index == 2 {
            change(&mut sample);
        }
        writer.push(sample).expect("it is written");
    }
    writer.finish().expect("it is finished");
    folder.complete().expect("the card is written");
    check(&place).codes()
}

pub fn edit_json(path: &Path, change: impl Fn(&mut Value)) {
    let mut value: Value = serde_json::from_slice(&fs::read(path).expect("it is there")).expect("it is JSON");
    change(&mut value);
    // As the program writes it.
    fs::write(path, format!("{value:#}\n")).expect("it can be written");
}

/// Makes the manifest agree with the files again, so that only their content is at fault.
pub fn agree(root: &Path) {
    let path = root.join(MANIFEST);
    let mut manifest: Manifest =
        serde_json::from_slice(&fs::read(&path).expect("it is there")).expect("it is a manifest");
    for file in &mut manifest.files {
        let bytes = fs::read(root.join(&file.path)).expect("it is there");
        file.bytes = bytes.len() as u64;
        file.sha256 = Sha256::digest(&bytes).iter().map(|byte| format!("{byte:02x}")).collect();
    }
    fs::write(path, serde_json::to_string_pretty(&manifest).expect("plain data") + "\n").expect("it can be written");
}

/// Rewrites the rows of `DATA`.
pub fn rewrite(root: &Path, change: impl Fn(Vec<RecordBatch>) -> Vec<RecordBatch>) {
    let file = File::open(root.join(DATA)).expect("it is there");
    let reader = ParquetRecordBatchReaderBuilder::try_new(file).expect("it is Parquet");
    // Batches come without the metadata of the file's schema.
    let schema = reader.schema().clone();
    let whole = |batch: RecordBatch| RecordBatch::try_new(schema.clone(), batch.columns().to_vec()).expect("same");
    let rows = reader.with_batch_size(1).build().expect("it is Parquet");
    let rows = change(rows.map(|batch| whole(batch.expect("it can be read"))).collect());
    let file = File::create(root.join(DATA)).expect("it can be written");
    let mut writer = ArrowWriter::try_new(file, rows[0].schema(), None).expect("a writer");
    rows.iter().for_each(|batch| writer.write(batch).expect("it is written"));
    writer.close().expect("it is closed");
    agree(root);
}

pub fn png(sample: &mut Encoded, channel: Channel, change: impl Fn(&mut Vec<u16>)) {
    let place = sample.png.iter().position(|(c, _)| *c == channel).expect("the output asks for it");
    let (cols, _, image) = read_png(&sample.png[place].1).expect("it was just written");
    let mut numbers = image.numbers();
    change(&mut numbers);
    let grey = match image {
        Grey::Eight(_) => Grey::Eight(numbers.iter().map(|&n| n as u8).collect()),
        Grey::Sixteen(_) => Grey::Sixteen(numbers),
    };
    sample.png[place].1 = write_png(&grey, cols as usize);
}

pub fn exr(sample: &mut Encoded, change: impl Fn(&mut Vec<ExrChannel>)) {
    let (cols, _, mut channels, text) =
        read_exr(sample.exr.as_deref().expect("the output asks for it")).expect("it was just written");
    change(&mut channels);
    let description = serde_json::from_str(&text).expect("it is JSON");
    sample.exr = Some(write_exr(channels, cols, (0.04, 0.068), &description));
}
