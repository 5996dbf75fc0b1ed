//! Samples of a dataset: maps from its EXR files, those that these lack from the images in its tables, and kept sensor
//! frames.

use base::Class;
use output_schema::{Manifest, ManifestSample};

use super::{RangeUnit, ScanMaps, SensorFrame, to_eight_bits};
use dataset::record::StackFrame;
use dataset::{Dataset, ExrMaps, Fault, RowBatch, range_joined};

/// Names of the measured images.
const MEASURED: [&str; 3] = ["range", "reflectance", "scatter"];
/// Name of what whole numbers leave of Range.
const REST: &str = "range_rest";
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
    if !has(&head.images.exr) && !has(&head.images.png) {
        let remedy = "set `output: {png: [range, reflectance, scatter, label]}` in the recipe and make it anew";
        return Err(Fault::at(root, "it was made without range images", remedy));
    }
    let is_measured = |image: &String| MEASURED.contains(&image.as_str()) || image == REST;
    let exr = head.images.exr.iter().any(is_measured).then(|| dataset.exr(dataset.shard_of(index), &listed.id));
    let mut frame = joined_frame(dataset, manifest, listed, exr.transpose()?.as_ref())?;
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

/// The maps of a row and of the EXR file of the same sample.
fn joined_frame(
    dataset: &Dataset,
    manifest: &Manifest,
    listed: &ManifestSample,
    exr: Option<&ExrMaps>,
) -> Result<ScanMaps, Fault> {
    let images = &dataset.head().images;
    let wanted = |name: &str| {
        let known = ["index", "id", "cols", "rows", "col_mm", "row_mm", "calibration"].contains(&name);
        let is_in_exr = images.exr.iter().any(|image| image == name);
        known
            || MEASURED.contains(&name) && !is_in_exr
            || name.starts_with("range_offset_")
            || name.starts_with("range_scale_")
    };
    let row = dataset.row(manifest, listed, &wanted)?;
    row_frame(dataset, &row, exr).map_err(|what| row.damaged(what))
}

fn row_frame(dataset: &Dataset, row: &RowBatch, exr: Option<&ExrMaps>) -> Result<ScanMaps, String> {
    let images = &dataset.head().images;
    let number = |path: &str| row.numbers(path)?.first().copied().ok_or_else(|| format!("`{path}` is missing"));
    let (cols, rows) = (images.cols as usize, images.rows as usize);
    let unit = dataset.head().range_unit();
    let [offset, scale] = ["offset", "scale"].map(|what| number(&format!("range_{what}_{unit}")));
    let (offset, scale) = (offset?, scale?);
    let height = |n: u16| if n == 0 { f64::NAN } else { offset + f64::from(n) * scale };
    let rest = exr.and_then(|exr| exr.channel("RangeRest"));
    let numbers = |name: &str| -> Result<Option<Vec<f64>>, String> {
        let numbers: Vec<f64> = match exr.and_then(|exr| exr.channel(name)) {
            Some(channel) => channel.numbers.iter().copied().map(f64::from).collect(),
            None if !images.png.iter().any(|png| png == name) => return Ok(None),
            None => {
                let pixels = row.image(0, name, images)?.grey.numbers();
                match rest.filter(|_| name == "range") {
                    Some(rest) => {
                        let range = range_joined(&pixels, &rest.numbers, cols, offset, scale)?;
                        range.into_iter().map(f64::from).collect()
                    }
                    None if name == "range" => pixels.into_iter().map(height).collect(),
                    None => pixels.into_iter().map(f64::from).collect(),
                }
            }
        };
        if numbers.len() != cols * rows {
            return Err(format!("`{name}` has not {cols} x {rows} pixels"));
        }
        Ok(Some(numbers))
    };
    let to_eight = to_eight_bits(images.bits);
    let seen = |v: f64| if v.is_nan() { 0.0 } else { to_eight * v as f32 };
    let light = |name: &str| Ok::<_, String>(numbers(name)?.map(|map| map.into_iter().map(seen).collect()));
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
        range: numbers("range")?.ok_or("it has no Range")?,
        reflectance: light("reflectance")?,
        scatter: light("scatter")?,
        ..ScanMaps::default()
    })
}
