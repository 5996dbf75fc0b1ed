//! Files of a dataset that are changed after it was written, and manifests that agree with them again.

use std::fs::{self, File};
use std::path::Path;

use arrow_array::RecordBatch;
use output_schema::Manifest;
use parquet::arrow::ArrowWriter;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use serde_json::Value;
use sha2::{Digest, Sha256};

/// The rows of the first shard's training samples.
pub const DATA: &str = "data/train-00000.parquet";
/// The first manifest.
pub const MANIFEST: &str = "shards/00000.json";

/// Changes a document.
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
