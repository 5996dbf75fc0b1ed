//! Rows of a dataset's tables, some columns at a time; what cannot be read is a fault of the file, never a panic.

use std::fs::File;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use arrow_array::cast::AsArray;
use arrow_array::types::ArrowPrimitiveType;
use arrow_array::{Array, ArrayRef, Float64Array, PrimitiveArray, RecordBatch, StructArray};
use parquet::arrow::ProjectionMask;
use parquet::arrow::arrow_reader::{ParquetRecordBatchReaderBuilder, RowSelection, RowSelector};

/// Rows that are held at once where they have no images.
const STEP: usize = 256;

/// Gives `take` the rows of a table with the columns that are wanted.
///
/// # Errors
/// In words, without the file's name.
pub(super) fn read(
    path: &Path,
    wanted: &dyn Fn(&str) -> bool,
    take: &mut dyn FnMut(&RecordBatch) -> Result<(), String>,
) -> Result<(), String> {
    guarded(|| {
        let reader = open(path, wanted)?.with_batch_size(STEP).build().map_err(|e| e.to_string())?;
        for batch in reader {
            take(&batch.map_err(|e| e.to_string())?)?;
        }
        Ok(())
    })
}

/// Gives `take` the row `row` of a table.
///
/// # Errors
/// As [`read`].
pub(super) fn one<T>(
    path: &Path,
    row: usize,
    wanted: &dyn Fn(&str) -> bool,
    take: impl FnOnce(&RecordBatch) -> Result<T, String>,
) -> Result<T, String> {
    guarded(|| {
        let selection = RowSelection::from(vec![RowSelector::skip(row), RowSelector::select(1)]);
        let reader = open(path, wanted)?.with_row_selection(selection).with_batch_size(1).build();
        let batch = reader.map_err(|e| e.to_string())?.next().ok_or_else(|| format!("it has no row {row}"))?;
        take(&batch.map_err(|e| e.to_string())?)
    })
}

/// Readers of other crates may panic on content that was made to mislead.
fn guarded<T>(read: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    catch_unwind(AssertUnwindSafe(read)).unwrap_or_else(|_| Err("the reader gave up on its content".into()))
}

fn open(path: &Path, wanted: &dyn Fn(&str) -> bool) -> Result<ParquetRecordBatchReaderBuilder<File>, String> {
    let file = File::open(path).map_err(|e| e.to_string())?;
    let builder = ParquetRecordBatchReaderBuilder::try_new(file).map_err(|e| e.to_string())?;
    let fields = builder.schema().fields().iter().enumerate();
    let roots: Vec<usize> = fields.filter(|(_, field)| wanted(field.name())).map(|(i, _)| i).collect();
    let mask = ProjectionMask::roots(builder.parquet_schema(), roots);
    Ok(builder.with_projection(mask))
}

/// The column `name`.
pub(super) fn column<'a>(batch: &'a RecordBatch, name: &str) -> Result<&'a ArrayRef, String> {
    batch.column_by_name(name).ok_or_else(|| format!("`{name}` is missing"))
}

/// The column `name` of whole or other numbers.
pub(super) fn numbers<'a, T: ArrowPrimitiveType>(
    batch: &'a RecordBatch,
    name: &str,
) -> Result<&'a PrimitiveArray<T>, String> {
    column(batch, name)?.as_primitive_opt::<T>().ok_or_else(|| format!("`{name}` has another type"))
}

/// The struct `name`.
pub(super) fn structure<'a>(batch: &'a RecordBatch, name: &str) -> Result<&'a StructArray, String> {
    column(batch, name)?.as_struct_opt().ok_or_else(|| format!("`{name}` is no struct"))
}

/// A field of a struct.
pub(super) fn field<'a, T: ArrowPrimitiveType>(
    group: &'a StructArray,
    name: &str,
) -> Result<&'a PrimitiveArray<T>, String> {
    let found = group.column_by_name(name).and_then(|column| column.as_primitive_opt::<T>());
    found.ok_or_else(|| format!("`{name}` is missing"))
}

/// A number of a column; NaN where it is missing.
pub(super) fn known(column: &Float64Array, row: usize) -> f64 {
    if column.is_null(row) { f64::NAN } else { column.value(row) }
}
