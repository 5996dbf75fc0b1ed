//! The samples of a split as a check needs them: first what the tables say of them, then their maps.

use std::fs::{self, File};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

use arrow_array::RecordBatch;
use arrow_array::types::{Int32Type, Int64Type};
use output_schema::DatasetHead;
use output_schema::file::{data_path, exr_path};
use parquet::arrow::ProjectionMask;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;

use super::CheckError;
use super::conditional::deciders;
use super::window::{SampleMaps, StoredMap};
use crate::dataset::{DatasetFolder, ExrChannel, read_exr};
use crate::split::Split;

mod rows;

use rows::{facts_of, number, png_plane};

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
    /// The numbers that were asked for; NaN where there is none, or the sample lacks the thing that it is of.
    pub numbers: Vec<f64>,
}

impl Folder {
    /// Opens the finished shards of a dataset, one split or all.
    ///
    /// # Errors
    /// Where it holds no dataset that this program reads, or nothing of the split.
    pub fn open(path: &Path, split: Option<Split>) -> Result<Self, CheckError> {
        let folder = DatasetFolder::open(path)?;
        let (mut tables, mut unfinished) = (Vec::new(), 0);
        for shard in 0..folder.head().shards {
            let Some(manifest) = folder.read_manifest(shard)? else {
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
            let is_group = |path: &str| path.split_once('.').map_or("physics", |(group, _)| group) == name;
            let group = |path: &String| is_group(path) || deciders(path).any(is_group);
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
    ) -> Result<SampleMaps, CheckError> {
        let is_png = |name: &str| self.head().images.png.iter().any(|png| png == name);
        let needed = channels.iter().map(String::as_str).chain(labels.then_some("label"));
        let exr = if needed.clone().all(is_png) { Vec::new() } else { self.exr(table, facts)? };
        guarded(&table.path, || {
            if number::<Int64Type>(batch, "index")? as u64 != facts.index {
                return Err(format!("its rows changed while sample {} was read", facts.index));
            }
            let side = |name: &str| Ok::<_, String>(usize::try_from(number::<Int32Type>(batch, name)?).unwrap_or(0));
            let size = [side("rows")?, side("cols")?];
            let plane = |name: &str| -> Result<StoredMap, String> {
                let found = exr.iter().find(|channel| channel.name.eq_ignore_ascii_case(name));
                let plane = match found {
                    _ if is_png(name) => png_plane(batch, name),
                    Some(channel) => Ok(StoredMap::Float(channel.numbers())),
                    None => Err(format!("no EXR channel `{name}`")),
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
                Some(StoredMap::Eight(labels)) => labels,
                Some(StoredMap::Float(labels)) => labels.into_iter().map(|label| label as u8).collect(),
                Some(StoredMap::Sixteen { .. }) => return Err(format!("sample {}: labels have 16 bits", facts.index)),
            };
            Ok(SampleMaps { size, planes, labels })
        })
    }

    /// The channels of a sample's EXR file.
    fn exr(&self, table: &Table, facts: &Facts) -> Result<Vec<ExrChannel>, CheckError> {
        let path = self.folder.root().join(exr_path(table.shard, &facts.id));
        let told = |what: String| format!("sample {}: {what}", facts.index);
        guarded(&path, || Ok(read_exr(&fs::read(&path).map_err(|e| told(e.to_string()))?).map_err(told)?.2))
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
