//! `data/*.parquet` -> rows as plain values: numbers, words and objects as JSON, images as the PNG bytes that are stored.
//!
//! Rows come one after the other, so a table of any length takes the memory of one row. Whatever is damaged is an error with
//! a reason; who calls knows the place and the remedy.

use std::fs::File;
use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use arrow_array::cast::AsArray;
use arrow_array::types::{Float64Type, Int32Type, Int64Type, UInt64Type};
use arrow_array::{Array, ArrayRef};
use arrow_schema::DataType;
use output_schema::row::IMAGES;
use parquet::arrow::ProjectionMask;
use parquet::arrow::arrow_reader::{ParquetRecordBatchReader, ParquetRecordBatchReaderBuilder, RowSelection};
use serde_json::{Map, Number, Value};

/// One row.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Row {
    /// Every column but images by name, in the order of columns; null where a number is missing.
    pub values: Map<String, Value>,
    /// The images that were asked for, as they are stored, by name.
    pub images: Vec<(String, Vec<u8>)>,
}

impl Row {
    /// A whole number.
    ///
    /// # Errors
    /// Where it is missing or another kind of value.
    pub fn whole(&self, name: &str) -> Result<u64, String> {
        let value = self.values.get(name).and_then(Value::as_u64);
        value.ok_or_else(|| format!("`{name}` is missing or no whole number"))
    }

    /// A number.
    ///
    /// # Errors
    /// Where it is missing or another kind of value.
    pub fn number(&self, name: &str) -> Result<f64, String> {
        let value = self.values.get(name).and_then(Value::as_f64);
        value.ok_or_else(|| format!("`{name}` is missing or no number"))
    }

    /// A text.
    ///
    /// # Errors
    /// Where it is missing or another kind of value.
    pub fn text(&self, name: &str) -> Result<&str, String> {
        let value = self.values.get(name).and_then(Value::as_str);
        value.ok_or_else(|| format!("`{name}` is missing or no text"))
    }

    /// The bytes of an image that was asked for.
    pub fn image(&self, name: &str) -> Option<&[u8]> {
        self.images.iter().find(|(known, _)| known == name).map(|(_, bytes)| bytes.as_slice())
    }
}

/// The rows of a table, one after the other.
pub struct Rows(ParquetRecordBatchReader);

/// Opens a table: the rows at `places` of its `count`, with the images that `images` names.
///
/// # Errors
/// Why it cannot be read, or that it has not `count` rows.
pub fn read_rows(path: &Path, count: u64, places: Vec<Range<usize>>, images: &[&str]) -> Result<Rows, String> {
    guarded(|| {
        let file = File::open(path).map_err(|e| e.to_string())?;
        let builder = ParquetRecordBatchReaderBuilder::try_new(file).map_err(|e| e.to_string())?;
        let found = builder.metadata().file_metadata().num_rows();
        if u64::try_from(found) != Ok(count) {
            return Err(format!("it has {found} rows, and its manifest names {count}"));
        }
        let wanted = |name: &str| !IMAGES.contains(&name) || images.contains(&name);
        let fields = builder.schema().fields().iter().enumerate();
        let roots: Vec<usize> = fields.filter(|(_, field)| wanted(field.name())).map(|(i, _)| i).collect();
        let mask = ProjectionMask::roots(builder.parquet_schema(), roots);
        let chosen = RowSelection::from_consecutive_ranges(places.into_iter(), count as usize);
        let builder = builder.with_projection(mask).with_row_selection(chosen).with_batch_size(1);
        builder.build().map(Rows).map_err(|e| e.to_string())
    })
}

impl Iterator for Rows {
    type Item = Result<Row, String>;

    fn next(&mut self) -> Option<Self::Item> {
        let row = || {
            let Some(batch) = self.0.next() else { return Ok(None) };
            let batch = batch.map_err(|e| e.to_string())?;
            let mut row = Row::default();
            for (field, column) in batch.schema().fields().iter().zip(batch.columns()) {
                let told = |what: String| format!("`{}`: {what}", field.name());
                if IMAGES.contains(&field.name().as_str()) {
                    row.images.push((field.name().clone(), bytes(column).map_err(told)?));
                } else {
                    row.values.insert(field.name().clone(), value(column, 0).map_err(told)?);
                }
            }
            Ok(Some(row))
        };
        guarded(row).transpose()
    }
}

/// Readers of other crates may panic on content that was made to mislead; that is a fault of the file.
fn guarded<T>(read: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    catch_unwind(AssertUnwindSafe(read)).unwrap_or_else(|_| Err("the reader gave up on its content".into()))
}

fn bytes(column: &ArrayRef) -> Result<Vec<u8>, String> {
    let image = column.as_struct_opt().and_then(|column| column.column_by_name("bytes"));
    let image = image.and_then(|bytes| bytes.as_binary_opt::<i32>()).filter(|bytes| !bytes.is_empty());
    image.filter(|bytes| bytes.is_valid(0)).map(|bytes| bytes.value(0).to_vec()).ok_or("there is no image".into())
}

/// One value of a column.
fn value(column: &ArrayRef, at: usize) -> Result<Value, String> {
    if at >= column.len() || column.is_null(at) {
        return Ok(Value::Null);
    }
    Ok(match column.data_type() {
        DataType::Utf8 => column.as_string::<i32>().value(at).into(),
        DataType::Int32 => column.as_primitive::<Int32Type>().value(at).into(),
        DataType::Int64 => column.as_primitive::<Int64Type>().value(at).into(),
        DataType::UInt64 => column.as_primitive::<UInt64Type>().value(at).into(),
        DataType::Float64 => {
            let number = column.as_primitive::<Float64Type>().value(at);
            Number::from_f64(number).map(Value::Number).ok_or_else(|| format!("it is {number}"))?
        }
        DataType::Struct(fields) => {
            let children = fields.iter().zip(column.as_struct().columns());
            let children = children.map(|(field, child)| Ok((field.name().clone(), value(child, at)?)));
            Value::Object(children.collect::<Result<_, String>>()?)
        }
        DataType::List(_) => all(&column.as_list::<i32>().value(at))?,
        DataType::FixedSizeList(..) => all(&column.as_fixed_size_list().value(at))?,
        other => return Err(format!("it is {other}, which no dataset holds")),
    })
}

fn all(list: &ArrayRef) -> Result<Value, String> {
    (0..list.len()).map(|at| value(list, at)).collect::<Result<Vec<_>, _>>().map(Value::Array)
}
