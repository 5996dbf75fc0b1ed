//! Samples of a dataset: maps from its EXR files, else from the images in its tables, and kept sensor frames.

use base::Class;
use output_schema::{Manifest, ManifestSample};

use super::{RangeUnit, ScanMaps, SensorFrame, exr_frame, to_eight_bits};
use dataset::record::StackFrame;
use dataset::{Dataset, Fault, RowBatch};

/// Name of the label image.
const LABEL: &str = "label";
/// Most sensor frames of a sample that are read: the middle ones.
const MAX_SENSOR_FRAMES: usize = 16;

/// One sample with the sensor frames that were kept, at most 16.
///
/// # Errors
/// Where it is not there, not finished, damaged, or has no heights.
pub(super) fn frame(dataset: &Dataset, index: u64) -> Result<ScanMaps, Fault> {
    let (head, root) = (dataset.head(), dataset.root());
    if index >= head.samples {
        let remedy = format!("give --index 0 to {}", head.samples.saturating_sub(1));
        return Err(Fault::at(root, format!("there is no sample {index}"), remedy));
    }
    let manifest = dataset.manifest(dataset.shard_of(index))?;
    let unfinished = || Fault::at(root, format!("sample {index} is not finished"), "run gen again to finish it");
    frame_of(dataset, &manifest.ok_or_else(unfinished)?, index, true)
}

/// The same where the manifest of its shard is known; without sensor frames unless they are asked for.
///
/// # Errors
/// Where it is not there, damaged, or has no heights.
pub(crate) fn frame_of(dataset: &Dataset, manifest: &Manifest, index: u64, exposed: bool) -> Result<ScanMaps, Fault> {
    let (head, root) = (dataset.head(), dataset.root());
    let listed = manifest.samples.iter().find(|sample| sample.index == index);
    let listed = listed.ok_or_else(|| Fault::damaged(root, format!("no manifest names sample {index}")))?;
    let has = |images: &[String]| images.iter().any(|image| image == "range");
    let mut frame = if has(&head.images.exr) {
        exr_frame::frame(&dataset.exr(dataset.shard_of(index), &listed.id)?)?
    } else if has(&head.images.png) {
        table_frame(dataset, manifest, listed)?
    } else {
        let remedy = "set `output: {exr: [range, reflectance]}` in the recipe and make it anew";
        return Err(Fault::at(root, "it was made without range images", remedy));
    };
    frame.name = format!("sample {index}");
    frame.bits = head.images.bits;
    if exposed && head.images.stack_every.is_some() {
        let scale = to_eight_bits(head.images.bits);
        let eight = |dn: u16| (scale * f32::from(dn)).round() as u8;
        let frames = dataset.sensor_frames(manifest, index, MAX_SENSOR_FRAMES)?.into_iter();
        let cols = head.images.sensor_cols as usize;
        frame.exposures = frames
            .map(|StackFrame { profile, dn }| SensorFrame {
                cols,
                profile: Some(profile as usize),
                dn: dn.into_iter().map(eight).collect(),
            })
            .collect();
    }
    Ok(frame)
}

/// Class of each pixel of a sample that has this frame, by its labels `[rows, cols]`; `None` where none are kept.
///
/// # Errors
/// Where it is damaged.
pub(super) fn classes(dataset: &Dataset, index: u64, frame: &ScanMaps) -> Result<Option<Vec<u8>>, Fault> {
    let images = &dataset.head().images;
    let manifest = dataset.manifest(dataset.shard_of(index))?;
    let missing = || Fault::damaged(dataset.root(), format!("no manifest names sample {index}"));
    let manifest = manifest.ok_or_else(missing)?;
    let listed = manifest.samples.iter().find(|sample| sample.index == index).ok_or_else(missing)?;
    let labels: Vec<u8> = if images.png.iter().any(|image| image == LABEL) {
        let row = dataset.row(&manifest, listed, &|name| ["index", "id", LABEL].contains(&name))?;
        let label = row.image(0, LABEL, images).map_err(|what| row.damaged(what))?;
        label.grey.numbers().into_iter().map(|label| label as u8).collect()
    } else if images.exr.iter().any(|image| image == LABEL) {
        let maps = dataset.exr(dataset.shard_of(index), &listed.id)?;
        let label = maps.channel(LABEL).ok_or_else(|| Fault::damaged(&maps.path, "it has no labels"))?;
        label.numbers.iter().map(|&label| label as u8).collect()
    } else {
        return Ok(None);
    };
    if labels.len() != frame.range.len() {
        let what = format!("sample {index} has {} labels for {} pixels", labels.len(), frame.range.len());
        return Err(Fault::damaged(dataset.root(), what));
    }
    Ok(Some(labels))
}

/// Pixels of a sample that show no object, by its labels `[rows, cols]`; `None` where none are kept. What of its sensor
/// frames shows none is darkened.
///
/// # Errors
/// Where it is damaged.
pub(super) fn beside_object(dataset: &Dataset, index: u64, frame: &mut ScanMaps) -> Result<Option<Vec<bool>>, Fault> {
    let Some(labels) = classes(dataset, index, frame)? else { return Ok(None) };
    let ignored: Vec<bool> = labels.iter().map(|label| *label == Class::Background as u8).collect();
    let bin = dataset.head().recipe.canonical["output"]["bin"]["profiles"].as_u64().unwrap_or(1);
    frame.darken_frames(&ignored, bin.max(1) as usize);
    Ok(Some(ignored))
}

/// The maps of a row that holds images.
fn table_frame(dataset: &Dataset, manifest: &Manifest, listed: &ManifestSample) -> Result<ScanMaps, Fault> {
    let wanted = |name: &str| {
        let known =
            ["index", "id", "col_mm", "row_mm", "calibration", "range", "reflectance", "scatter"].contains(&name);
        known || name.starts_with("range_offset_") || name.starts_with("range_scale_")
    };
    let row = dataset.row(manifest, listed, &wanted)?;
    row_frame(dataset, &row).map_err(|what| row.damaged(what))
}

fn row_frame(dataset: &Dataset, row: &RowBatch) -> Result<ScanMaps, String> {
    let images = &dataset.head().images;
    let number = |path: &str| row.numbers(path)?.first().copied().ok_or_else(|| format!("`{path}` is missing"));
    let range = row.image(0, "range", images)?;
    let (cols, rows) = (range.cols, range.rows);
    let to_eight = to_eight_bits(images.bits);
    let unit = dataset.head().range_unit();
    let (offset, scale) = (number(&format!("range_offset_{unit}"))?, number(&format!("range_scale_{unit}"))?);
    let height = |n: u16| if n == 0 { f64::NAN } else { offset + f64::from(n) * scale };
    let map = |name: &str| -> Result<Option<Vec<f32>>, String> {
        if !images.png.iter().any(|png| png == name) {
            return Ok(None);
        }
        let image = row.image(0, name, images)?;
        Ok(Some(image.grey.numbers().into_iter().map(|n| to_eight * f32::from(n)).collect()))
    };
    let of_rig = |name: &str| number(&format!("calibration.{name}")).ok().filter(|number| !number.is_nan());
    let col_mm = number("col_mm")?;
    // On sensor columns the optical axis stands at x = 0; a written column is the middle of those that it averages.
    let binned = images.sensor_cols as f64 / cols.max(1) as f64;
    let on_columns = |centre: f64| (0.5 * (binned - 1.0) - centre) * col_mm / binned;
    let first = of_rig("x_first_mm").or_else(|| of_rig("centre_col_px").map(on_columns));
    Ok(ScanMaps {
        cols,
        rows,
        unit: if unit == "px" { RangeUnit::Px { sensor_rows: images.sensor_rows as u32 } } else { RangeUnit::Mm },
        first_mm: first,
        col_mm: Some(col_mm),
        row_mm: Some(number("row_mm")?),
        range: range.grey.numbers().into_iter().map(height).collect(),
        reflectance: map("reflectance")?,
        scatter: map("scatter")?,
        ..ScanMaps::default()
    })
}
