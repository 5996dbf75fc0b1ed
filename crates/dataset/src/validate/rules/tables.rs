//! Parquet files: readable, with the columns that are declared, as many rows as the manifest says, in its order, none
//! of them empty. A table is read in one pass, so its rules are one file.

use std::panic::{AssertUnwindSafe, catch_unwind};

use arrow_array::RecordBatch;
use output_schema::arrow::row_schema;
use output_schema::{ManifestFile, ManifestSample, SCHEMA_VERSION};
use parquet::arrow::arrow_reader::ParquetRecordBatchReader;

use super::{Code, Finding, REMAKE, REMAKE_OR_REPORT, Rule, ValidationReport};
use crate::validate::columns::{StoredRow, stored_row};
use crate::validate::shard::OpenShard;
use crate::validate::shard_task::ShardTask;
use crate::{TableBounds, enclosed, largest};

pub(super) const UNREADABLE: Rule = Rule { meaning: "A Parquet file cannot be read.", remedy: REMAKE };
pub(super) const SCHEMA_DIFFERS: Rule =
    Rule { meaning: "A Parquet file has other columns than declared.", remedy: REMAKE_OR_REPORT };
pub(super) const ROW_COUNT: Rule =
    Rule { meaning: "A Parquet file has more or fewer rows than it should.", remedy: REMAKE_OR_REPORT };
pub(super) const INDEX_ORDER: Rule =
    Rule { meaning: "The indices in a file are not those of its shard and split, in order.", remedy: REMAKE_OR_REPORT };
pub(super) const NUMBER_MISSING: Rule =
    Rule { meaning: "A number that can never be missing is missing.", remedy: REMAKE_OR_REPORT };

/// A reader of the rows of a table, which has the columns that it should.
pub(in crate::validate) fn rows(shard: &OpenShard, path: &str) -> Result<ParquetRecordBatchReader, Finding> {
    let unreadable = |e: String| Finding::new(Code::TableUnreadable, path, e);
    let file = enclosed::open(shard.task.root, path, largest::table_bytes(shard.task.head));
    let file = file.map_err(|e| unreadable(e.to_string()))?;
    let bounds = TableBounds::of_rows(shard.task.head);
    let builder = bounds.open(file, &|_| true).map_err(unreadable)?;
    let (found, expected) = (builder.schema().clone(), row_schema(shard.task.head));
    // Another version's metadata and descriptions differ; each value's name and type is asked for where it is read.
    if shard.task.head.schema_version == SCHEMA_VERSION && *found != expected {
        let fields =
            expected.fields().iter().filter(|field| found.field_with_name(field.name()).ok() != Some(field.as_ref()));
        let names: Vec<&str> = fields.map(|field| field.name().as_str()).collect();
        let what = format!("its columns are not those that are declared: {names:?}, their order, or the metadata");
        return Err(Finding::new(Code::SchemaDiffers, path, what));
    }
    builder.with_batch_size(1).build().map_err(|e| unreadable(e.to_string()))
}

/// A row as plain values, where none is missing.
pub(in crate::validate) fn row(
    task: &ShardTask,
    batch: &RecordBatch,
    file: &ManifestFile,
    report: &mut ValidationReport,
) -> Option<StoredRow> {
    stored_row(batch, task.head).map_err(|what| report.fault(Code::NumberMissing, &file.path, what)).ok()
}

/// What the manifest says about a row, where it stands in its order.
pub(in crate::validate) fn in_order<'a>(
    row: &StoredRow,
    listed: Option<&'a ManifestSample>,
    place: &str,
    report: &mut ValidationReport,
) -> Option<&'a ManifestSample> {
    let what = match listed {
        Some(listed) if row.index == listed.index as i64 => return Some(listed),
        Some(listed) => format!("index {} stands where the manifest has {}", row.index, listed.index),
        None => format!("index {} is not the next one of this split in the manifest", row.index),
    };
    report.fault(Code::IndexOrder, place, what);
    None
}

/// Readers of other crates may panic on content that was made to mislead; that is a fault of the file.
pub(in crate::validate) fn caught<T>(path: &str, read: impl FnOnce() -> Result<T, Finding>) -> Result<T, Finding> {
    let gave_up = |_| Err(Finding::new(Code::TableUnreadable, path, "a reader gave up on its content"));
    catch_unwind(AssertUnwindSafe(read)).unwrap_or_else(gave_up)
}
