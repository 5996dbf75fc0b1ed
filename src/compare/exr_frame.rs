//! OpenEXR files of a scan: channels `Range`, `Reflectance` (or `Y`) and `Scatter`, with units and pitches in their header.

use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use super::{RangeUnit, ScanMaps, SourceError, to_eight_bits};
use crate::dataset::{ExrChannel, read_exr};

/// Reads a file.
pub(super) fn read(path: &Path) -> Result<ScanMaps, SourceError> {
    let bytes = fs::read(path).map_err(|e| SourceError::at(path, format!("it cannot be read: {e}"), "allow it"))?;
    frame(path, &bytes)
}

/// The maps of an EXR file.
pub(super) fn frame(path: &Path, bytes: &[u8]) -> Result<ScanMaps, SourceError> {
    let whole = "copy it again, or have it made again";
    // Readers of other crates may panic on content that was made to mislead; that is a fault of the file.
    let read = catch_unwind(AssertUnwindSafe(|| read_exr(bytes)));
    let read = read.unwrap_or_else(|_| Err("the reader gave up on its content".into()));
    let (cols, rows, channels, text) = read.map_err(|what| SourceError::at(path, what, whole))?;
    let find = |name: &str| channels.iter().find(|channel| channel.name == name).map(ExrChannel::numbers);
    let missing =
        || SourceError::at(path, "it has no channel Range", "set `output: {exr: [range, reflectance]}` in the recipe");
    let range = find("Range").ok_or_else(missing)?.into_iter().map(f64::from).collect();
    let seen = |map: Vec<f32>| map.into_iter().map(|v| if v.is_nan() { 0.0 } else { v }).collect::<Vec<f32>>();
    let description: serde_json::Value = serde_json::from_str(&text).unwrap_or_default();
    let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let bits = description["bits"].as_u64().unwrap_or(0);
    let scaled = |map: Vec<f32>| map.into_iter().map(|v| v * to_eight_bits(bits)).collect::<Vec<f32>>();
    let sensor_rows = description["sensor_rows"].as_u64().and_then(|rows| u32::try_from(rows).ok()).unwrap_or(0);
    Ok(ScanMaps {
        name,
        cols,
        rows,
        bits,
        unit: if description["units"]["Range"] == "px" { RangeUnit::Px { sensor_rows } } else { RangeUnit::Mm },
        first_mm: description["calibration"]["x_first_mm"].as_f64(),
        col_mm: description["col_mm"].as_f64(),
        row_mm: description["row_mm"].as_f64(),
        range,
        reflectance: find("Reflectance").or_else(|| find("Y")).map(seen).map(scaled),
        scatter: find("Scatter").map(seen).map(scaled),
        exposures: Vec::new(),
    })
}
