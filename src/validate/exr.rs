//! EXR files: declared channels, ranges, and the same content as the row's images.

use output_schema::DatasetHead;
use output_schema::row::{CALIBRATION, IMAGES};
use serde_json::Value;

use super::columns::StoredRow;
use super::images::Decoded;
use super::pixels;
use super::report::{Code, Fault, Report};
use crate::shard::{ExrChannel, read_exr};

/// Checks one EXR file against its declaration in the head and the images of its row; adds label and instance to the images where
/// the row has none.
pub(super) fn check(
    bytes: &[u8],
    head: &DatasetHead,
    row: &StoredRow,
    decoded: &mut Decoded,
    place: &str,
    report: &mut Report,
) {
    let declared = head.channels();
    let (cols, rows, channels, text) = match read_exr(bytes) {
        Ok(content) => content,
        Err(e) => return report.faults.push(Fault::new(Code::ExrUnreadable, place, e)),
    };
    report.images += channels.len() as u64;
    let expected: Vec<_> = head.channels().iter().map(|c| (c.name, c.samples)).collect();
    let found: Vec<_> = channels.iter().map(|c| (c.name.as_str(), c.sample_type())).collect();
    if expected != found || (cols, rows) != (row.cols as usize, row.rows as usize) {
        let what = format!("it holds {cols} x {rows} of {found:?}, not {} x {} of {expected:?}", row.cols, row.rows);
        return report.faults.push(Fault::new(Code::ExrChannels, place, what));
    }
    let description: Value = serde_json::from_str(&text).unwrap_or_default();
    attribute(&description, row, head, place, report);
    for channel in declared.iter().filter(|c| description["units"][c.name] != c.unit) {
        let what = format!(
            "its attribute gives {} in {}, not in {}",
            channel.name, description["units"][channel.name], channel.unit
        );
        report.faults.push(Fault::new(Code::ExrDiffers, place, what));
    }
    for channel in &channels {
        let numbers = channel.numbers();
        let outside = numbers.iter().filter(|&&n| !in_range(&channel.name, head, n)).count();
        if outside > 0 {
            let what = format!("{outside} samples of {} are outside of the declared range", channel.name);
            report.faults.push(Fault::new(Code::ValueRange, place, what));
        }
        compare(channel, &numbers, row, decoded, place, report);
        let number = |n: &f32| match channel.name.as_str() {
            // As the image of that name would have it.
            "Range" if n.is_nan() => 0,
            "Range" => ((f64::from(*n) - row.range_offset) / row.range_scale).round().clamp(1.0, 65535.0) as u16,
            _ => n.round() as u16,
        };
        let name = if channel.name == "Y" { "reflectance".into() } else { channel.name.to_lowercase() };
        if IMAGES.contains(&name.as_str()) {
            decoded.add(&name, numbers.iter().map(number).collect());
        }
    }
    pixels::truth(row, head, &channels, decoded, place, report);
}

/// The text attribute repeats what the row says.
fn attribute(description: &Value, row: &StoredRow, head: &DatasetHead, place: &str, report: &mut Report) {
    let class = usize::try_from(row.class).ok().and_then(|class| head.classes.get(class));
    let expected = [
        ("id", Value::from(row.id.as_str())),
        ("index", row.index.into()),
        ("split", row.split.as_str().into()),
        ("class", class.map(String::as_str).into()),
        ("row_mm", row.row_mm.into()),
        ("col_mm", row.col_mm.into()),
        ("bits", head.images.bits.into()),
        ("range", head.images.range.as_str().into()),
        ("sensor_rows", head.images.sensor_rows.into()),
    ];
    for (key, expected) in expected.iter().filter(|(key, expected)| description[key] != *expected) {
        let what = format!("its attribute gives {key} as {}, the row as {expected}", description[key]);
        report.faults.push(Fault::new(Code::ExrDiffers, place, what));
    }
    let bench = row.derived.iter().take_while(|(name, _)| CALIBRATION.iter().any(|field| field.name == name));
    for (name, value) in bench.filter(|(name, value)| description["calibration"][name] != *value) {
        let what = format!("its attribute gives {name} as {}, the row as {value}", description["calibration"][name]);
        report.faults.push(Fault::new(Code::ExrDiffers, place, what));
    }
}

fn in_range(channel: &str, head: &DatasetHead, value: f32) -> bool {
    let most = f32::from(head.images.most_dn());
    match channel {
        "Range" if head.range_unit() == "px" => {
            value.is_nan() || (0.0..head.images.sensor_rows as f32).contains(&value)
        }
        "Reflectance" => value.is_nan() || (0.0..=most).contains(&value),
        "Y" => (0.0..=most).contains(&value),
        "Scatter" => value.is_nan() || (value >= 0.0 && value.is_finite()),
        "FibreAzimuth" => value.is_nan() || (-90.0..=90.0).contains(&value),
        "FilmGap" | "FilmThickness" => value.is_nan() || (value >= 0.0 && value.is_finite()),
        "FibreDive" => value.is_nan() || (0.0..=90.0).contains(&value),
        _ => !value.is_infinite(),
    }
}

fn compare(channel: &ExrChannel, exr: &[f32], row: &StoredRow, decoded: &Decoded, place: &str, report: &mut Report) {
    let name = if channel.name == "Y" { "reflectance".into() } else { channel.name.to_lowercase() };
    let Some(png) = decoded.get(&name) else { return };
    let same = |exr: f32, png: u16| match name.as_str() {
        "range" => same_range(exr, png, row),
        "reflectance" | "scatter" if exr.is_nan() => png == 0,
        // Rounded to whole numbers, and to half precision before: 2^-4 at most below 256.
        "reflectance" => (exr - f32::from(png)).abs() <= 0.5 + 0.0625,
        "scatter" => (exr - f32::from(png)).abs() <= 0.5 || (png == u16::MAX && exr > 65535.0),
        _ => exr == f32::from(png),
    };
    let other = exr.iter().zip(png).filter(|(exr, png)| !same(**exr, **png)).count();
    if other > 0 {
        let what = format!("{other} samples of {} are not those of the image `{name}`", channel.name);
        report.faults.push(Fault::new(Code::ExrDiffers, place, what));
    }
}

/// Half the step in which EXR files give Range, 2^-13 [mm or px].
const HALF_STEP: f64 = 1.0 / 16384.0;

/// Within half a step of both, or beyond the ends where the image saturates.
fn same_range(exr: f32, png: u16, row: &StoredRow) -> bool {
    let exact = (f64::from(exr) - row.range_offset) / row.range_scale;
    let half = 0.5 + HALF_STEP / row.range_scale + 1e-6;
    match png {
        0 => exr.is_nan(),
        1 => exact <= 1.0 + half,
        u16::MAX => exact >= 65535.0 - half,
        _ => (exact - f64::from(png)).abs() <= half,
    }
}
