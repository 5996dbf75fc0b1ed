//! Table reader: `data/*.parquet` and `stacks/*.parquet` -> some rows at a time, some columns of them, as plain values.
//!
//! A table of any length takes the memory of the rows that are asked for at once. Groups of rows without any of them
//! are passed over unread. What is wrong with a value is a reason in words: who asks knows the sample.

use std::fs::File;
use std::io;
use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use arrow_array::cast::AsArray;
use arrow_array::types::{Float64Type, Int32Type, Int64Type, UInt64Type};
use arrow_array::{Array, ArrayRef, RecordBatch, StructArray};
use arrow_schema::DataType;
use output_schema::Images;
use output_schema::row::IMAGES;
use parquet::arrow::ProjectionMask;
use parquet::arrow::arrow_reader::{ParquetRecordBatchReader, RowSelection};
use serde_json::{Map, Number, Value};

use super::{Fault, Grey, TableBounds, check_lengths, enclosed, own_remedy, read_png_of};
use optical_bench::split::Split;

/// Rows that are read at once where they have no images.
const ROWS_AT_ONCE: usize = 256;

/// Rows of one split in one shard.
#[derive(Debug, Clone)]
pub struct Table {
    /// Where it is.
    pub path: PathBuf,
    /// The same, relative to the folder.
    pub relative: String,
    /// Number of the shard.
    pub shard: u64,
    /// The split.
    pub split: Split,
    /// The dataset's folder.
    pub(super) root: PathBuf,
    /// Most bytes that it can have.
    pub(super) most_bytes: u64,
    /// What it may hold.
    pub(super) bounds: TableBounds,
}

/// What is read of a table.
#[derive(Clone)]
pub struct RowQuery<'a> {
    /// Whether a column of that name is wanted.
    pub columns: &'a dyn Fn(&str) -> bool,
    /// Numbers of the wanted rows, in order; `None` for all, those beyond the table's end are left out.
    pub ranges: Option<Vec<Range<usize>>>,
    /// Rows in a batch: a bound on memory where they hold images.
    pub at_once: usize,
}

impl<'a> RowQuery<'a> {
    /// These columns of all rows, for columns without images.
    pub fn of(columns: &'a dyn Fn(&str) -> bool) -> Self {
        Self { columns, ranges: None, at_once: ROWS_AT_ONCE }
    }
}

impl Table {
    /// Opens the table.
    ///
    /// # Errors
    /// Why it cannot be read.
    pub fn rows(&self, query: &RowQuery) -> Result<Rows, Fault> {
        Self::read(&self.path, enclosed::open(&self.root, &self.relative, self.most_bytes), &self.bounds, query)
    }

    /// One row.
    ///
    /// # Errors
    /// Why it cannot be read, or that there is none.
    pub fn row(&self, row: usize, columns: &dyn Fn(&str) -> bool) -> Result<RowBatch, Fault> {
        let one = RowQuery { columns, ranges: Some(std::iter::once(row..row + 1).collect()), at_once: 1 };
        self.rows(&one)?.next().unwrap_or_else(|| Err(self.damaged(format!("it has no row {row}"))))
    }

    /// A fault of the table's content.
    pub fn damaged(&self, what: impl Into<String>) -> Fault {
        Fault::damaged(&self.path, what)
    }

    /// Reads any table of a dataset: the `file` at `path`.
    pub(super) fn read(
        path: &Path,
        file: io::Result<File>,
        bounds: &TableBounds,
        query: &RowQuery,
    ) -> Result<Rows, Fault> {
        let file = file.map_err(|e| match own_remedy(&e) {
            Some(remedy) => Fault::at(path, e.to_string(), remedy),
            None => Fault::damaged(path, e.to_string()),
        })?;
        let open = || {
            let builder = bounds.open(file, query.columns)?;
            let count = u64::try_from(builder.metadata().file_metadata().num_rows()).unwrap_or(0);
            let fields = builder.schema().fields().iter().enumerate();
            let roots: Vec<usize> = fields.filter(|(_, field)| (query.columns)(field.name())).map(|(i, _)| i).collect();
            let mask = ProjectionMask::roots(builder.parquet_schema(), roots);
            let mut builder = builder.with_projection(mask).with_batch_size(query.at_once.max(1));
            if let Some(ranges) = &query.ranges {
                let sizes = builder.metadata().row_groups().iter().map(|group| group.num_rows());
                let (groups, rows) = selected(sizes, ranges);
                builder = builder.with_row_groups(groups).with_row_selection(rows);
            }
            let reader = builder.build().map_err(|e| e.to_string())?;
            Ok(Rows { path: path.into(), count, reader })
        };
        guarded(open).map_err(|what| Fault::damaged(path, what))
    }
}

/// The groups of rows, by their sizes, in which some of `ranges` lie, and which rows of these groups are in `ranges`.
fn selected(sizes: impl Iterator<Item = i64>, ranges: &[Range<usize>]) -> (Vec<usize>, RowSelection) {
    let (mut groups, mut chosen) = (Vec::new(), Vec::new());
    // Rows before a group in the table, and in the groups that are read.
    let (mut before, mut kept) = (0usize, 0usize);
    for (group, size) in sizes.enumerate() {
        let size = usize::try_from(size).unwrap_or(0);
        let within = |range: &Range<usize>| {
            let (start, end) = (range.start.max(before), range.end.min(before.saturating_add(size)));
            (start < end).then(|| start - before + kept..end - before + kept)
        };
        let within: Vec<Range<usize>> = ranges.iter().filter_map(within).collect();
        if !within.is_empty() {
            groups.push(group);
            chosen.extend(within);
            kept += size;
        }
        before = before.saturating_add(size);
    }
    (groups, RowSelection::from_consecutive_ranges(chosen.into_iter(), kept))
}

/// The rows of a table, one batch after the other.
pub struct Rows {
    path: Arc<Path>,
    count: u64,
    reader: ParquetRecordBatchReader,
}

impl Rows {
    /// How many rows the table has, asked for or not.
    pub fn in_table(&self) -> u64 {
        self.count
    }
}

impl Iterator for Rows {
    type Item = Result<RowBatch, Fault>;

    fn next(&mut self) -> Option<Self::Item> {
        let next = guarded(|| {
            let batch = self.reader.next().transpose().map_err(|e| e.to_string())?;
            batch.map(|batch| check_lengths(&batch).map(|()| batch)).transpose()
        });
        let here = |batch| RowBatch { path: self.path.clone(), batch };
        next.map(|batch| batch.map(here)).map_err(|what| Fault::damaged(&self.path, what)).transpose()
    }
}

/// Some rows with the columns that were asked for.
///
/// A path names a column, or as `group.key` a field of a column of structs.
#[derive(Debug, Clone)]
pub struct RowBatch {
    path: Arc<Path>,
    batch: RecordBatch,
}

/// One object of a sample, as far as readers ask for it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ObjectRow {
    /// Pixel class of the thing itself.
    pub class: usize,
    /// Pixel class of the whole, as its state has it.
    pub state: usize,
    /// Number of the object that it lies in; 0 for none.
    pub within: i32,
    /// First column, first row, columns, rows [px].
    pub bbox: [i32; 4],
    /// Diameter [mm]; NaN where it has none.
    pub diameter_mm: f64,
}

/// Every value of one row.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct JsonRow {
    /// Every column but images by name, in the order of columns; null where a number is missing.
    pub values: Map<String, Value>,
    /// The images that were asked for, as they are stored, by name.
    pub images: Vec<(String, Vec<u8>)>,
}

/// A decoded image of a row.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StoredImage {
    /// Columns [px].
    pub cols: usize,
    /// Rows [px].
    pub rows: usize,
    /// Pixels `[rows, cols]`, row-major.
    pub grey: Grey,
}

impl RowBatch {
    /// These rows, which lie in no file.
    pub fn of(batch: RecordBatch) -> Self {
        Self { path: Path::new("").into(), batch }
    }

    /// The rows as Arrow has them.
    pub fn batch(&self) -> &RecordBatch {
        &self.batch
    }

    /// How many rows.
    pub fn len(&self) -> usize {
        self.batch.num_rows()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Row `row` alone, below [`RowBatch::len`].
    pub fn row(&self, row: usize) -> Self {
        Self { path: self.path.clone(), batch: self.batch.slice(row, 1) }
    }

    /// A fault of the content of these rows.
    pub fn damaged(&self, what: impl Into<String>) -> Fault {
        Fault::damaged(&self.path, what)
    }

    /// Whole numbers of a path.
    ///
    /// # Errors
    /// Where there is no such column, it holds something else, or one of them is missing.
    pub fn integers(&self, path: &str) -> Result<Vec<i64>, String> {
        integers(&self.at(path)?, path)
    }

    /// Numbers of a path; NaN where one is missing.
    ///
    /// # Errors
    /// Where there is no such column, or it holds something else.
    pub fn numbers(&self, path: &str) -> Result<Vec<f64>, String> {
        numbers(&self.at(path)?, path)
    }

    /// Texts of a path.
    ///
    /// # Errors
    /// Where there is no such column, it holds something else, or one of them is missing.
    pub(crate) fn texts(&self, path: &str) -> Result<Vec<String>, String> {
        let column = self.at(path)?;
        let texts = column.as_string_opt::<i32>().ok_or_else(|| format!("`{path}` is no text"))?;
        let text = |text: Option<&str>| text.map(str::to_owned).ok_or_else(|| format!("`{path}` is missing"));
        texts.iter().map(text).collect()
    }

    /// Names of the samples.
    ///
    /// # Errors
    /// As `RowBatch::texts`, and where one is no name: it could lead out of the folder.
    pub fn ids(&self) -> Result<Vec<String>, String> {
        let ids = self.texts("id")?;
        ids.into_iter().map(|id| if is_id(&id) { Ok(id) } else { Err(format!("{id:?} is no id")) }).collect()
    }

    /// The objects of each row.
    ///
    /// # Errors
    /// Where they are no list of structs with the fields of an [`ObjectRow`].
    pub fn objects(&self) -> Result<Vec<Vec<ObjectRow>>, String> {
        let column = self.column("objects")?;
        let lists = column.as_list_opt::<i32>().ok_or("`objects` is no list")?;
        guarded(|| (0..lists.len()).map(|row| objects(&lists.value(row))).collect())
    }

    /// The PNG bytes of an image of row `row`.
    ///
    /// # Errors
    /// Where the column is missing, or holds no image there.
    pub fn png(&self, row: usize, name: &str) -> Result<&[u8], String> {
        let bytes = structure(self.column(name)?, name)?.column_by_name("bytes").and_then(|b| b.as_binary_opt::<i32>());
        let bytes = bytes.filter(|bytes| row < bytes.len() && bytes.is_valid(row));
        bytes.map(|bytes| bytes.value(row)).ok_or_else(|| format!("`{name}` is empty"))
    }

    /// An image of row `row`, as large as the dataset's `images` are.
    ///
    /// # Errors
    /// As [`RowBatch::png`], and where it is damaged or has another size.
    pub fn image(&self, row: usize, name: &str, images: &Images) -> Result<StoredImage, String> {
        let png = self.png(row, name)?;
        let size = (images.cols, images.rows);
        let grey = guarded(|| read_png_of(png, size)).map_err(|what| format!("`{name}`: {what}"))?;
        Ok(StoredImage { cols: size.0 as usize, rows: size.1 as usize, grey })
    }

    /// Everything that row `row` says.
    ///
    /// # Errors
    /// Where a value is of a type that no dataset holds, or no JSON number, or an image is missing.
    pub fn json(&self, row: usize) -> Result<JsonRow, String> {
        let mut json = JsonRow::default();
        for (field, column) in self.batch.schema().fields().iter().zip(self.batch.columns()) {
            let name = field.name().as_str();
            let told = |what: String| format!("`{name}`: {what}");
            if IMAGES.contains(&name) {
                let png = self.png(row, name).map_err(|_| told("there is no image".into()))?;
                json.images.push((name.into(), png.to_vec()));
            } else {
                json.values.insert(name.into(), guarded(|| value(column, row)).map_err(told)?);
            }
        }
        Ok(json)
    }

    /// A column.
    pub(super) fn column(&self, name: &str) -> Result<&ArrayRef, String> {
        self.batch.column_by_name(name).ok_or_else(|| format!("`{name}` is missing"))
    }

    /// A column, or a field of a column of structs.
    fn at(&self, path: &str) -> Result<ArrayRef, String> {
        match path.split_once('.') {
            None => self.column(path).cloned(),
            Some((group, key)) => field(structure(self.column(group)?, group)?, key, path),
        }
    }
}

impl JsonRow {
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

/// Whether a sample can have that name: one of a damaged file must not lead out of the folder.
pub(super) fn is_id(id: &str) -> bool {
    !id.is_empty() && id.bytes().all(|c| c.is_ascii_alphanumeric() || c == b'-')
}

/// Readers of other crates may panic on content that was made to mislead; that is a fault of the file.
pub(super) fn guarded<T>(read: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    catch_unwind(AssertUnwindSafe(read)).unwrap_or_else(|_| Err("the reader gave up on its content".into()))
}

fn structure<'a>(column: &'a ArrayRef, name: &str) -> Result<&'a StructArray, String> {
    column.as_struct_opt().ok_or_else(|| format!("`{name}` is no struct"))
}

fn field(group: &StructArray, key: &str, path: &str) -> Result<ArrayRef, String> {
    group.column_by_name(key).cloned().ok_or_else(|| format!("`{path}` is missing"))
}

fn integers(column: &ArrayRef, path: &str) -> Result<Vec<i64>, String> {
    let long = column.as_primitive_opt::<Int64Type>().map(|numbers| numbers.values().to_vec());
    let short = || column.as_primitive_opt::<Int32Type>().map(|n| n.values().iter().map(|&n| n.into()).collect());
    match long.or_else(short) {
        Some(_) if column.null_count() > 0 => Err(format!("`{path}` is missing")),
        found => found.ok_or_else(|| format!("`{path}` has another type")),
    }
}

fn numbers(column: &ArrayRef, path: &str) -> Result<Vec<f64>, String> {
    let numbers = column.as_primitive_opt::<Float64Type>().ok_or_else(|| format!("`{path}` has another type"))?;
    Ok(numbers.iter().map(|number| number.unwrap_or(f64::NAN)).collect())
}

/// The objects of one row.
fn objects(list: &ArrayRef) -> Result<Vec<ObjectRow>, String> {
    let fields = list.as_struct_opt().ok_or("`objects` is no list of structs")?;
    let whole = |key: &str| {
        let path = format!("objects.{key}");
        integers(&field(fields, key, &path)?, &path)
    };
    let (class, state, within) = (whole("class")?, whole("state")?, whole("within")?);
    let diameter = numbers(&field(fields, "diameter_mm", "objects.diameter_mm")?, "objects.diameter_mm")?;
    let boxes = field(fields, "bbox", "objects.bbox")?;
    let boxes = boxes.as_fixed_size_list_opt().ok_or("`objects.bbox` is no fixed list")?;
    let one = |i: usize| {
        let sides = boxes.value(i);
        let sides = sides.as_primitive_opt::<Int32Type>().and_then(|sides| sides.values().as_ref().try_into().ok());
        let class_of =
            |value: i64, key: &str| usize::try_from(value).map_err(|_| format!("`objects.{key}` is negative"));
        Ok(ObjectRow {
            class: class_of(class[i], "class")?,
            state: class_of(state[i], "state")?,
            within: i32::try_from(within[i]).map_err(|_| "`objects.within` is no number of an object")?,
            bbox: sides.ok_or("`objects.bbox` holds no box")?,
            diameter_mm: diameter[i],
        })
    };
    (0..fields.len()).map(one).collect()
}

/// One value of a column.
pub(crate) fn value(column: &ArrayRef, at: usize) -> Result<Value, String> {
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

#[cfg(test)]
mod tests {
    use arrow_array::Int64Array;
    use parquet::arrow::ArrowWriter;
    use parquet::file::properties::WriterProperties;

    use super::*;

    /// Wherever rows begin and end among the groups of a file, they are those rows, and none where there are none.
    #[test]
    fn rows_are_found_in_their_groups() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("rows.parquet");
        let index = Arc::new(Int64Array::from_iter_values(0..10)) as ArrayRef;
        let all = RecordBatch::try_from_iter([("index", index)]).expect("one column");
        let groups_of_three = WriterProperties::builder().set_max_row_group_row_count(Some(3)).build();
        let file = File::create(&path).expect("the folder is ours");
        let mut writer = ArrowWriter::try_new(file, all.schema(), Some(groups_of_three)).expect("it begins");
        writer.write(&all).expect("it is written");
        assert_eq!(writer.close().expect("it ends").num_row_groups(), 4);
        for (first, count) in (0..12).flat_map(|first| (0..12).map(move |count| (first, count))) {
            let ranges = vec![first..first + count / 2, first + count / 2 + 1..first + count + 1];
            for ranges in [std::iter::once(first..first + count).collect(), ranges] {
                let query = RowQuery { columns: &|_| true, ranges: Some(ranges.clone()), at_once: count.clamp(1, 8) };
                let rows =
                    Table::read(&path, File::open(&path), &TableBounds::of_count(10), &query).expect("it can be read");
                assert_eq!(rows.in_table(), 10);
                let found: Vec<i64> =
                    rows.flat_map(|batch| batch.expect("whole").integers("index").expect("numbers")).collect();
                let wanted: Vec<i64> = (0..10).filter(|&i| ranges.iter().any(|r| r.contains(&(i as usize)))).collect();
                assert_eq!(found, wanted, "{ranges:?}");
            }
        }
    }
}
