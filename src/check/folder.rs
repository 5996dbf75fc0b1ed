//! The samples of a split as a check needs them: first what the tables say of them, then their maps.

use std::fs::{self, File};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

use arrow_array::cast::AsArray;
use arrow_array::types::{Float64Type, Int32Type, Int64Type};
use arrow_array::{Array, ArrayRef, RecordBatch, StructArray};
use output_schema::DatasetHead;
use output_schema::file::{data_path, exr_path};
use parquet::arrow::ProjectionMask;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;

use super::CheckError;
use super::cut::{Picture, Plane};
use crate::record::Split;
use crate::shard::{DatasetFolder, Grey, read_exr, read_png};

/// What to do about a damaged dataset.
const CHECK: &str = "`gen validate` says what is damaged";

/// Rows of one split in one shard.
#[derive(Debug, Clone)]
pub struct Table {
    path: PathBuf,
    shard: u64,
}

/// A split of a dataset.
#[derive(Debug)]
pub struct Folder {
    folder: DatasetFolder,
    /// Tables in the order of shards, then of splits.
    pub tables: Vec<Table>,
    /// Shards that are not finished.
    pub unfinished: u64,
}

/// What a row says of its sample beside the maps.
#[derive(Debug, Clone, PartialEq)]
pub struct Facts {
    /// Number in the dataset.
    pub index: u64,
    /// Name.
    pub id: String,
    /// Class of the recipe.
    pub class: usize,
    /// Pixels of each pixel class, by its value.
    pub area: Vec<u64>,
    /// Objects that lie in no other: pixel class of the whole, and middle of the box: row and column [px].
    pub objects: Vec<(usize, [i64; 2])>,
    /// The numbers that were asked for; NaN where there is none.
    pub numbers: Vec<f64>,
}

impl Folder {
    /// Opens the finished shards of a dataset, one split or all.
    ///
    /// # Errors
    /// Where it holds no dataset that this program reads, or nothing of the split.
    pub fn open(path: &Path, split: Option<Split>) -> Result<Self, CheckError> {
        let told = |e: crate::shard::ShardError| CheckError::at(path, e.to_string(), "name the folder of a dataset");
        let folder = DatasetFolder::open(path).map_err(told)?;
        let (mut tables, mut unfinished) = (Vec::new(), 0);
        for shard in 0..folder.head().shards {
            let Some(manifest) = folder.read_manifest(shard).map_err(told)? else {
                unfinished += 1;
                continue;
            };
            for split in Split::ALL.into_iter().filter(|known| split.is_none_or(|split| split == *known)) {
                let relative = data_path(split.name(), shard);
                if manifest.files.iter().any(|file| file.path == relative) {
                    tables.push(Table { path: folder.root().join(relative), shard });
                }
            }
        }
        if tables.is_empty() {
            let (what, remedy) = match split {
                _ if unfinished == folder.head().shards => {
                    ("no shard of it is finished".into(), "run gen again to finish it")
                }
                Some(split) => (
                    format!("it has no samples of the split `{}`", split.name()),
                    "give --split all, or make more samples",
                ),
                None => ("it has no samples".into(), "make some"),
            };
            return Err(CheckError::at(path, what, remedy));
        }
        Ok(Self { folder, tables, unfinished })
    }

    /// `dataset.json`.
    pub fn head(&self) -> &DatasetHead {
        self.folder.head()
    }

    /// What the rows say, in the order of tables; `numbers` are paths of drawn and derived numbers.
    ///
    /// # Errors
    /// Where a table is damaged.
    pub fn facts(&self, numbers: &[String]) -> Result<Vec<Vec<Facts>>, CheckError> {
        let head = self.head();
        let wanted = |name: &str| {
            let group = |path: &String| path.split_once('.').map_or("physics", |(group, _)| group) == name;
            ["index", "id", "class", "class_area_px", "objects"].contains(&name) || numbers.iter().any(group)
        };
        let table = |table: &Table| {
            guarded(&table.path, || {
                let mut facts = Vec::new();
                for batch in reader(&table.path, &wanted, 256)? {
                    let batch = batch?;
                    for row in 0..batch.num_rows() {
                        facts.push(facts_of(&batch.slice(row, 1), head, numbers)?);
                    }
                }
                Ok(facts)
            })
        };
        self.tables.iter().map(table).collect()
    }

    /// The rows of a table with their images, `step` at a time.
    ///
    /// # Errors
    /// Where it cannot be opened.
    pub fn images<'a>(
        &self,
        table: &'a Table,
        names: &'a [String],
        step: usize,
    ) -> Result<impl Iterator<Item = Result<RecordBatch, CheckError>> + 'a, CheckError> {
        let range = |name: &str| name.starts_with("range_offset_") || name.starts_with("range_scale_");
        let wanted =
            |name: &str| ["index", "cols", "rows"].contains(&name) || range(name) || names.iter().any(|n| n == name);
        let rows = guarded(&table.path, || reader(&table.path, &wanted, step))?;
        Ok(rows.map(move |batch| batch.map_err(|what| CheckError::at(&table.path, what, CHECK))))
    }

    /// The maps of the first row of `batch`, which is to be `facts`: planes in the order of `channels`, and labels where
    /// they are asked for.
    ///
    /// # Errors
    /// Where an image is missing or damaged.
    pub fn picture(
        &self,
        table: &Table,
        batch: &RecordBatch,
        facts: &Facts,
        channels: &[String],
        labels: bool,
    ) -> Result<Picture, CheckError> {
        let head = self.head();
        let mut exr = None;
        guarded(&table.path, || {
            if number::<Int64Type>(batch, "index")? as u64 != facts.index {
                return Err(format!("its rows changed while sample {} was read", facts.index));
            }
            let side = |name: &str| Ok::<_, String>(usize::try_from(number::<Int32Type>(batch, name)?).unwrap_or(0));
            let size = [side("rows")?, side("cols")?];
            let mut plane = |name: &str| -> Result<Plane, String> {
                let plane = if head.images.png.iter().any(|png| png == name) {
                    png_plane(batch, name)
                } else {
                    if exr.is_none() {
                        let path = self.folder.root().join(exr_path(table.shard, &facts.id));
                        let told = |e: std::io::Error| format!("{}: {e}", path.display());
                        exr = Some(read_exr(&fs::read(&path).map_err(told)?)?.2);
                    }
                    let found = exr.iter().flatten().find(|channel| channel.name.eq_ignore_ascii_case(name));
                    found
                        .map(|channel| Plane::Float(channel.numbers()))
                        .ok_or_else(|| format!("no EXR channel `{name}`"))
                };
                let plane = plane.map_err(|what| format!("sample {}: {what}", facts.index))?;
                if plane.len() != size[0] * size[1] {
                    return Err(format!("sample {}: `{name}` has not {} x {} pixels", facts.index, size[0], size[1]));
                }
                Ok(plane)
            };
            let planes = channels.iter().map(|name| plane(name)).collect::<Result<_, _>>()?;
            let labels = match if labels { Some(plane("label")?) } else { None } {
                None => Vec::new(),
                Some(Plane::Eight(labels)) => labels,
                Some(Plane::Float(labels)) => labels.into_iter().map(|label| label as u8).collect(),
                Some(Plane::Sixteen { .. }) => return Err(format!("sample {}: labels have 16 bits", facts.index)),
            };
            Ok(Picture { size, planes, labels })
        })
    }
}

/// Readers of other crates may panic on content that was made to mislead; that is a fault of the file.
fn guarded<T>(path: &Path, read: impl FnOnce() -> Result<T, String>) -> Result<T, CheckError> {
    let result = catch_unwind(AssertUnwindSafe(read));
    let result = result.unwrap_or_else(|_| Err("the reader gave up on its content".into()));
    result.map_err(|what| CheckError::at(path, what, CHECK))
}

/// The rows of a table, `step` at a time, of the columns that are wanted.
fn reader(
    path: &Path,
    wanted: &dyn Fn(&str) -> bool,
    step: usize,
) -> Result<impl Iterator<Item = Result<RecordBatch, String>> + use<>, String> {
    let file = File::open(path).map_err(|e| e.to_string())?;
    let builder = ParquetRecordBatchReaderBuilder::try_new(file).map_err(|e| e.to_string())?;
    let fields = builder.schema().fields().iter().enumerate();
    let roots: Vec<usize> = fields.filter(|(_, field)| wanted(field.name())).map(|(i, _)| i).collect();
    let mask = ProjectionMask::roots(builder.parquet_schema(), roots);
    let reader = builder.with_projection(mask).with_batch_size(step.max(1)).build().map_err(|e| e.to_string())?;
    Ok(reader.map(|batch| batch.map_err(|e| e.to_string())))
}

fn facts_of(row: &RecordBatch, head: &DatasetHead, numbers: &[String]) -> Result<Facts, String> {
    let id = column(row, "id")?.as_string_opt::<i32>().map(|c| c.value(0).to_owned()).ok_or("`id` is no text")?;
    if id.contains(['/', '\\']) {
        return Err(format!("`{id}` is no id"));
    }
    let areas = structure(&column(row, "class_area_px")?, "class_area_px")?;
    let mut area = vec![0; head.pixel_classes.len()];
    for (value, name) in head.shown_classes() {
        let counts = areas.column_by_name(name).and_then(|column| column.as_primitive_opt::<Int64Type>());
        let count =
            counts.filter(|counts| !counts.is_empty()).ok_or_else(|| format!("`class_area_px.{name}` is missing"))?;
        area[value] = u64::try_from(count.value(0)).unwrap_or(0);
    }
    let list = column(row, "objects")?;
    let list = list.as_list_opt::<i32>().ok_or("`objects` is no list")?.value(0);
    let number_of = |path: &String| {
        let (group, key) = path.split_once('.').unwrap_or(("physics", path));
        let group = structure(&column(row, group)?, group)?;
        let column = group.column_by_name(key).and_then(|column| column.as_primitive_opt::<Float64Type>());
        let column = column.filter(|column| !column.is_empty()).ok_or_else(|| format!("`{path}` is missing"))?;
        Ok::<_, String>(if column.is_null(0) { f64::NAN } else { column.value(0) })
    };
    Ok(Facts {
        index: number::<Int64Type>(row, "index")? as u64,
        id,
        class: usize::try_from(number::<Int64Type>(row, "class")?).map_err(|_| "`class` is negative")?,
        area,
        objects: objects(&list)?,
        numbers: numbers.iter().map(number_of).collect::<Result<_, _>>()?,
    })
}

/// State and middle of every object that lies in no other.
fn objects(list: &ArrayRef) -> Result<Vec<(usize, [i64; 2])>, String> {
    let fields = structure(list, "objects")?;
    let field = |name: &str| fields.column_by_name(name).cloned().ok_or_else(|| format!("`objects.{name}` is missing"));
    let (state, within, bbox) = (field("state")?, field("within")?, field("bbox")?);
    let state = state.as_primitive_opt::<Int64Type>().ok_or("`objects.state` is not int64")?;
    let within = within.as_primitive_opt::<Int32Type>().ok_or("`objects.within` is not int32")?;
    let bbox = bbox.as_fixed_size_list_opt().ok_or("`objects.bbox` is no fixed list")?;
    let mut found = Vec::new();
    for i in (0..fields.len()).filter(|&i| within.value(i) == 0) {
        let sides = bbox.value(i);
        let sides = sides.as_primitive_opt::<Int32Type>().map(|sides| sides.values().to_vec());
        let Some([left, top, cols, rows]) = sides.as_deref() else { return Err("`objects.bbox` holds no box".into()) };
        let middle = |first: i32, length: i32| i64::from(first) + i64::from(length) / 2;
        let class = usize::try_from(state.value(i)).map_err(|_| "`objects.state` is negative")?;
        found.push((class, [middle(*top, *rows), middle(*left, *cols)]));
    }
    Ok(found)
}

fn png_plane(row: &RecordBatch, name: &str) -> Result<Plane, String> {
    let bytes = structure(&column(row, name)?, name)?;
    let bytes = bytes.column_by_name("bytes").and_then(|bytes| bytes.as_binary_opt::<i32>());
    let bytes = bytes.filter(|bytes| bytes.is_valid(0)).ok_or_else(|| format!("`{name}` is empty"))?;
    let (_, _, grey) = read_png(bytes.value(0)).map_err(|e| format!("`{name}`: {e}"))?;
    // In millimetres or in sensor rows, whichever the dataset has.
    let float = |what: &str| {
        let unit = if row.column_by_name("range_offset_px").is_some() { "px" } else { "mm" };
        number::<Float64Type>(row, &format!("range_{what}_{unit}"))
    };
    Ok(match grey {
        Grey::Eight(pixels) => Plane::Eight(pixels),
        Grey::Sixteen(pixels) if name == "range" => {
            Plane::Sixteen { pixels, offset: float("offset")?, scale: float("scale")? }
        }
        Grey::Sixteen(pixels) => Plane::Sixteen { pixels, offset: 0.0, scale: 1.0 },
    })
}

fn column(row: &RecordBatch, name: &str) -> Result<ArrayRef, String> {
    let column = row.column_by_name(name).filter(|column| !column.is_empty() && column.is_valid(0));
    column.cloned().ok_or_else(|| format!("`{name}` is missing"))
}

fn structure(column: &ArrayRef, name: &str) -> Result<StructArray, String> {
    column.as_struct_opt().cloned().ok_or_else(|| format!("`{name}` is no struct"))
}

fn number<T: arrow_array::types::ArrowPrimitiveType>(row: &RecordBatch, name: &str) -> Result<T::Native, String> {
    let column = column(row, name)?;
    column.as_primitive_opt::<T>().map(|c| c.value(0)).ok_or_else(|| format!("`{name}` has another type"))
}
