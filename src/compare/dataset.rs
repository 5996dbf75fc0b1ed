//! Samples of a dataset: maps from its EXR files, else from the images in its tables, and kept sensor frames.

use std::fs::{self, File};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use arrow_array::cast::AsArray;
use arrow_array::types::{Float64Type, Int64Type};
use arrow_array::{Array, RecordBatch};
use output_schema::file::{data_path, exr_path, stack_path};
use output_schema::{DatasetHead, Images, Manifest};
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;

use super::{RangeUnit, ScanMaps, SensorFrame, SourceError, exr_frame, to_eight_bits};
use crate::dataset::{DatasetFolder, frame_numbers, read_png};

/// Most sensor frames of a sample that are read: the middle ones.
const MAX_SENSOR_FRAMES: usize = 16;
/// What to do about a damaged dataset.
const CHECK: &str = "`gen validate` says what is damaged";

/// An open dataset.
#[derive(Debug)]
pub struct Dataset(DatasetFolder);

impl Dataset {
    /// Opens a folder.
    ///
    /// # Errors
    /// Where it holds no dataset that this program reads.
    pub fn open(path: &Path) -> Result<Self, SourceError> {
        let told = |e: crate::dataset::ShardError| SourceError::at(path, e.to_string(), "name the folder of a dataset");
        DatasetFolder::open(path).map(Self).map_err(told)
    }

    /// Sensor columns that are averaged into one column of the images.
    pub fn binned_columns(&self) -> u64 {
        self.0.head().images.sensor_cols / self.0.head().images.cols.max(1)
    }

    /// How many samples it has or will have.
    pub fn samples(&self) -> u64 {
        self.0.head().samples
    }

    /// One sample with the sensor frames that were kept, at most 16.
    ///
    /// # Errors
    /// Where it is not there, not finished, damaged, or has no heights.
    pub fn frame(&self, index: u64) -> Result<ScanMaps, SourceError> {
        let (head, root) = (self.0.head(), self.0.root());
        if index >= head.samples {
            let what = format!("there is no sample {index}");
            return Err(SourceError::at(root, what, &format!("give --index 0 to {}", head.samples.saturating_sub(1))));
        }
        let shard = index / head.samples_per_shard.max(1);
        let unfinished =
            || SourceError::at(root, format!("sample {index} is not finished"), "run gen again to finish it");
        let told = |e: crate::dataset::ShardError| SourceError::at(root, e.to_string(), CHECK);
        let manifest = self.0.read_manifest(shard).map_err(told)?.ok_or_else(unfinished)?;
        self.frame_of(&manifest, index, true)
    }

    /// The same where the manifest of its shard is known; without sensor frames unless they are asked for.
    ///
    /// # Errors
    /// Where it is not there, damaged, or has no heights.
    pub fn frame_of(&self, manifest: &Manifest, index: u64, exposed: bool) -> Result<ScanMaps, SourceError> {
        let (head, root) = (self.0.head(), self.0.root());
        let shard = index / head.samples_per_shard.max(1);
        let listed = manifest.samples.iter().find(|sample| sample.index == index && !sample.id.contains('/'));
        let listed = listed.ok_or_else(|| SourceError::at(root, format!("no manifest names sample {index}"), CHECK))?;
        let has = |images: &[String]| images.iter().any(|image| image == "range");
        let mut frame = if has(&head.images.exr) {
            let path = root.join(exr_path(shard, &listed.id));
            let bytes =
                fs::read(&path).map_err(|e| SourceError::at(&path, format!("it cannot be read: {e}"), CHECK))?;
            exr_frame::frame(&path, &bytes)?
        } else if has(&head.images.png) {
            let before = manifest.samples.iter().filter(|sample| sample.split == listed.split && sample.index < index);
            guarded(&root.join(data_path(&listed.split, shard)), |path| row(path, head, before.count(), index))?
        } else {
            let remedy = "set `output: {exr: [range, reflectance]}` in the recipe and make it anew";
            return Err(SourceError::at(root, "it was made without range images", remedy));
        };
        frame.name = format!("sample {index}");
        frame.bits = head.images.bits;
        if exposed && head.images.stack_every.is_some() {
            frame.exposures =
                guarded(&root.join(stack_path(shard)), |path| exposures(path, manifest, index, &head.images))?;
        }
        Ok(frame)
    }
}

/// Readers of other crates may panic on content that was made to mislead; that is a fault of the file.
fn guarded<T>(path: &Path, read: impl FnOnce(&Path) -> Result<T, String>) -> Result<T, SourceError> {
    let result = catch_unwind(AssertUnwindSafe(|| read(path)));
    result
        .unwrap_or_else(|_| Err("the reader gave up on its content".into()))
        .map_err(|what| SourceError::at(path, what, CHECK))
}

/// The rows `first` to `first + count` of a table.
fn batches(path: &Path, first: usize, count: usize) -> Result<Vec<RecordBatch>, String> {
    let file = File::open(path).map_err(|e| e.to_string())?;
    let builder = ParquetRecordBatchReaderBuilder::try_new(file).map_err(|e| e.to_string())?;
    // Groups of rows before the first are passed over unread.
    let (mut groups, mut before, mut skipped) = (Vec::new(), 0, 0);
    for (i, group) in builder.metadata().row_groups().iter().enumerate() {
        let after = usize::try_from(group.num_rows()).map_or(usize::MAX, |rows| rows.saturating_add(before));
        if after <= first {
            skipped = after;
        } else if before < first.saturating_add(count) {
            groups.push(i);
        }
        before = after;
    }
    let (first, builder) = (first - skipped, builder.with_row_groups(groups));
    let reader = builder.with_batch_size(count.clamp(1, 8)).with_offset(first).with_limit(count);
    let batches: Result<Vec<_>, _> = reader.build().map_err(|e| e.to_string())?.collect();
    batches.map_err(|e| e.to_string())
}

fn is_index(batch: &RecordBatch, row: usize, index: u64) -> bool {
    let column = batch.column_by_name("index").and_then(|column| column.as_primitive_opt::<Int64Type>());
    column.is_some_and(|column| column.value(row) == index as i64)
}

/// The maps of a row that holds images.
fn row(path: &Path, head: &DatasetHead, place: usize, index: u64) -> Result<ScanMaps, String> {
    let batches = batches(path, place, 1)?;
    let batch = batches.iter().find(|batch| batch.num_rows() > 0).ok_or("it has too few rows")?;
    if !is_index(batch, 0, index) {
        return Err(format!("row {place} is not sample {index}"));
    }
    let number = |name: &str| {
        let column = batch.column_by_name(name).and_then(|column| column.as_primitive_opt::<Float64Type>());
        column.map(|column| column.value(0)).ok_or_else(|| format!("`{name}` is missing"))
    };
    let image = |name: &str| -> Result<Option<(usize, usize, Vec<u16>)>, String> {
        let bytes = batch.column_by_name(name).and_then(|column| column.as_struct_opt());
        let bytes = bytes.and_then(|column| column.column_by_name("bytes")).and_then(|b| b.as_binary_opt::<i32>());
        let Some(bytes) = bytes.filter(|bytes| !bytes.is_null(0)) else { return Ok(None) };
        let (cols, rows, grey) = read_png(bytes.value(0)).map_err(|e| format!("`{name}`: {e}"))?;
        Ok(Some((cols as usize, rows as usize, grey.numbers())))
    };
    let (cols, rows, steps) = image("range")?.ok_or("`range` is missing")?;
    let to_eight = to_eight_bits(head.images.bits);
    let unit = head.range_unit();
    let (offset, scale) = (number(&format!("range_offset_{unit}"))?, number(&format!("range_scale_{unit}"))?);
    let height = |&n: &u16| if n == 0 { f64::NAN } else { offset + f64::from(n) * scale };
    let map = |name: &str| -> Result<Option<Vec<f32>>, String> {
        match image(name)? {
            Some((w, h, _)) if (w, h) != (cols, rows) => Err(format!("`{name}` is {w} x {h}, not {cols} x {rows}")),
            found => Ok(found.map(|(_, _, numbers)| numbers.into_iter().map(|n| to_eight * f32::from(n)).collect())),
        }
    };
    let calibration = batch.column_by_name("calibration").and_then(|column| column.as_struct_opt());
    let of_rig = |name: &str| {
        let column = calibration.and_then(|column| column.column_by_name(name)).filter(|column| !column.is_null(0));
        column.and_then(|column| column.as_primitive_opt::<Float64Type>()).map(|column| column.value(0))
    };
    let col_mm = number("col_mm")?;
    // On sensor columns the optical axis stands at x = 0; a written column is the middle of those that it averages.
    let binned = head.images.sensor_cols as f64 / cols.max(1) as f64;
    let on_columns = |centre: f64| (0.5 * (binned - 1.0) - centre) * col_mm / binned;
    let first = of_rig("x_first_mm").or_else(|| of_rig("centre_col_px").map(on_columns));
    Ok(ScanMaps {
        cols,
        rows,
        unit: if unit == "px" { RangeUnit::Px { sensor_rows: head.images.sensor_rows as u32 } } else { RangeUnit::Mm },
        first_mm: first,
        col_mm: Some(col_mm),
        row_mm: Some(number("row_mm")?),
        range: steps.iter().map(height).collect(),
        reflectance: map("reflectance")?,
        scatter: map("scatter")?,
        ..ScanMaps::default()
    })
}

/// Sensor frames of a sample: each sample of a shard has as many, in order.
fn exposures(path: &Path, manifest: &Manifest, index: u64, images: &Images) -> Result<Vec<SensorFrame>, String> {
    let scale = to_eight_bits(images.bits);
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let rows = manifest.files.iter().find(|file| file.path.ends_with(name.as_ref()) && file.path.starts_with("stacks"));
    let rows = rows.and_then(|file| file.rows).ok_or("the manifest does not count its rows")?;
    let each = (rows / manifest.samples.len().max(1) as u64) as usize;
    let before = manifest.samples.iter().filter(|sample| sample.index < index).count() * each;
    let take = each.min(MAX_SENSOR_FRAMES);
    let mut found = Vec::new();
    for batch in batches(path, before + (each - take) / 2, take)? {
        let frames = batch.column_by_name("frame").and_then(|column| column.as_fixed_size_list_opt());
        let frames = frames.ok_or("the frames are no tensors")?;
        for row in 0..batch.num_rows() {
            if !is_index(&batch, row, index) {
                return Err(format!("a sensor frame of sample {index} is not where it should be"));
            }
            let pixels = frames.value(row);
            let dn = frame_numbers(&pixels).ok_or("the frames are neither uint8 nor uint16")?;
            let dn = dn.into_iter().map(|dn| (scale * f32::from(dn)).round() as u8).collect();
            found.push(SensorFrame { cols: images.sensor_cols as usize, dn });
        }
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use arrow_array::Int64Array;
    use parquet::arrow::ArrowWriter;
    use parquet::file::properties::WriterProperties;

    use super::*;

    /// Wherever rows begin and end among the groups of a file, they are those rows, and none where there are none.
    #[test]
    fn rows_are_found_in_their_groups() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("rows.parquet");
        let index = Arc::new(Int64Array::from_iter_values(0..10)) as arrow_array::ArrayRef;
        let all = RecordBatch::try_from_iter([("index", index)]).expect("one column");
        let groups_of_three = WriterProperties::builder().set_max_row_group_row_count(Some(3)).build();
        let file = File::create(&path).expect("the folder is ours");
        let mut writer = ArrowWriter::try_new(file, all.schema(), Some(groups_of_three)).expect("it begins");
        writer.write(&all).expect("it is written");
        assert_eq!(writer.close().expect("it ends").num_row_groups(), 4);
        for (first, count) in (0..12).flat_map(|first| (0..12).map(move |count| (first, count))) {
            let found = batches(&path, first, count).expect("it can be read");
            let numbers = |batch: &RecordBatch| batch.column(0).as_primitive::<Int64Type>().values().to_vec();
            let found: Vec<i64> = found.iter().flat_map(numbers).collect();
            assert_eq!(found, (0..10).skip(first).take(count).collect::<Vec<i64>>(), "{count} from {first}");
        }
    }
}
