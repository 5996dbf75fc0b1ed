//! OpenEXR files of a scan: channels `Range`, `Reflectance` (or `Y`) and `Scatter`, with units and pitches in their
//! header.

use std::path::Path;

use super::scan_format::{ScanContent, ScanFormat, read_file};
use super::{RangeUnit, ScanMaps, to_eight_bits};
use dataset::{ExrMaps, Fault};

/// Most bytes of a file that is read.
const MAX_FILE_BYTES: u64 = 4 << 30;

/// OpenEXR.
pub(super) const FORMAT: ScanFormat =
    ScanFormat { endings: &[("exr", ".exr", true)], stated: None, read: |path, _| read(path) };

fn read(path: &Path) -> Result<ScanContent, Fault> {
    let maps = ExrMaps::decode(path, &read_file(path, MAX_FILE_BYTES, "allow it")?);
    let maps = frame(&maps.map_err(|what| Fault::at(path, what, "copy it again, or have it made again"))?)?;
    Ok(ScanContent::Scan(Box::new(maps)))
}

/// The maps of an EXR file.
fn frame(maps: &ExrMaps) -> Result<ScanMaps, Fault> {
    let find =
        |name: &str| maps.channels.iter().find(|channel| channel.name == name).map(|channel| channel.numbers.clone());
    let remedy = "name the dataset's folder, or set `output: {exr: all}` in the recipe";
    let missing = || Fault::at(&maps.path, "it has no channel Range", remedy);
    let range = find("Range").ok_or_else(missing)?.into_iter().map(f64::from).collect();
    let description: serde_json::Value = serde_json::from_str(&maps.description).unwrap_or_default();
    let name = maps.path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let bits = description["bits"].as_u64().unwrap_or(0);
    let seen = |v: f32| if v.is_nan() { 0.0 } else { v * to_eight_bits(bits) };
    let light = |map: Vec<f32>| map.into_iter().map(seen).collect();
    let sensor_rows = description["sensor_rows"].as_u64().and_then(|rows| u32::try_from(rows).ok()).unwrap_or(0);
    Ok(ScanMaps {
        name,
        cols: maps.cols,
        rows: maps.rows,
        bits,
        unit: if description["units"]["Range"] == "px" { RangeUnit::Px { sensor_rows } } else { RangeUnit::Mm },
        first_mm: description["calibration"]["x_first_mm"].as_f64(),
        col_mm: description["col_mm"].as_f64(),
        row_mm: description["row_mm"].as_f64(),
        range,
        reflectance: find("Reflectance").or_else(|| find("Y")).map(light),
        scatter: find("Scatter").map(light),
        ..ScanMaps::default()
    })
}
