//! EXR files: declared channels, ranges, and the same content as the row's images.

use output_schema::DatasetHead;
use output_schema::row::{CALIBRATION, IMAGES};
use serde_json::Value;

use super::columns::StoredRow;
use super::finding::{Code, Finding};
use super::images::DecodedImages;
use super::report::ValidationReport;
use super::{pixels, true_rows};
use crate::record::TrueRow;
use crate::{ExrChannel, read_exr};

/// Checks one EXR file against its declaration in the head and the images of its row; adds label and instance to the images where
/// the row has none. `rows` is what the body shows in some rows.
pub(super) fn check(
    bytes: &[u8],
    head: &DatasetHead,
    row: &StoredRow,
    (decoded, rows): (&mut DecodedImages, &[TrueRow]),
    place: &str,
    report: &mut ValidationReport,
) {
    let declared = head.channels();
    let (cols, lines, channels, text) = match read_exr(bytes) {
        Ok(content) => content,
        Err(e) => return report.faults.push(Finding::new(Code::ExrUnreadable, place, e)),
    };
    report.images += channels.len() as u64;
    let expected: Vec<_> = head.channels().iter().map(|c| (c.name, c.samples)).collect();
    let found: Vec<_> = channels.iter().map(|c| (c.name.as_str(), c.sample_type())).collect();
    if expected != found || (cols, lines) != (row.cols as usize, row.rows as usize) {
        let what = format!("it holds {cols} x {lines} of {found:?}, not {} x {} of {expected:?}", row.cols, row.rows);
        return report.faults.push(Finding::new(Code::ExrChannels, place, what));
    }
    let description: Value = serde_json::from_str(&text).unwrap_or_default();
    attribute(&description, row, head, place, report);
    for channel in declared.iter().filter(|c| description["units"][c.name] != c.unit) {
        let what = format!(
            "its attribute gives {} in {}, not in {}",
            channel.name, description["units"][channel.name], channel.unit
        );
        report.faults.push(Finding::new(Code::ExrDiffers, place, what));
    }
    for channel in &channels {
        let numbers = channel.as_numbers();
        let ((low, high), missing) = range(&channel.name, head);
        // Without branches: of every number of every channel.
        let inside = |n: f32| (n >= low) & (n <= high) | (missing & n.is_nan());
        let outside = numbers.iter().filter(|n| !inside(**n)).count();
        if outside > 0 {
            let what = format!("{outside} samples of {} are outside of the declared range", channel.name);
            report.faults.push(Finding::new(Code::ValueRange, place, what));
        }
        if channel.name == "Height" {
            true_rows::height(rows, cols, &numbers, place, report);
        }
        compare(channel, &numbers, row, decoded, place, report);
        let name = if channel.name == "Y" { "reflectance".into() } else { channel.name.to_lowercase() };
        if IMAGES.contains(&name.as_str()) && decoded.get(&name).is_none() {
            // As the image of that name would have it.
            let height = |z: f32| ((f64::from(z) - row.range_offset) / row.range_scale).round().clamp(1.0, 65535.0);
            let numbers: Vec<u16> = match name.as_str() {
                "range" => numbers.iter().map(|&z| if z.is_nan() { 0 } else { height(z) as u16 }).collect(),
                "label" | "instance" => numbers.iter().map(|&n| n as u16).collect(),
                _ => numbers.iter().map(|n| n.round() as u16).collect(),
            };
            decoded.add(&name, numbers);
        }
    }
    pixels::truth(row, head, &channels, decoded, place, report);
}

/// The text attribute repeats what the row says.
fn attribute(description: &Value, row: &StoredRow, head: &DatasetHead, place: &str, report: &mut ValidationReport) {
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
        report.faults.push(Finding::new(Code::ExrDiffers, place, what));
    }
    let bench = row.derived.iter().take_while(|(name, _)| CALIBRATION.iter().any(|field| field.name == name));
    for (name, value) in bench.filter(|(name, value)| description["calibration"][name] != *value) {
        let what = format!("its attribute gives {name} as {}, the row as {value}", description["calibration"][name]);
        report.faults.push(Finding::new(Code::ExrDiffers, place, what));
    }
}

/// Smallest and largest number that a channel may have, and whether it may be missing.
fn range(channel: &str, head: &DatasetHead) -> ((f32, f32), bool) {
    let most = f32::from(head.images.most_dn());
    match channel {
        "Range" if head.range_unit() == "px" => ((0.0, (head.images.sensor_rows as f32).next_down()), true),
        "Reflectance" => ((0.0, most), true),
        "Y" => ((0.0, most), false),
        "Scatter" | "FilmGap" | "FilmThickness" => ((0.0, f32::MAX), true),
        "FibreAzimuth" => ((-90.0, 90.0), true),
        "FibreDive" => ((0.0, 90.0), true),
        _ => ((f32::MIN, f32::MAX), true),
    }
}

fn compare(
    channel: &ExrChannel,
    exr: &[f32],
    row: &StoredRow,
    decoded: &DecodedImages,
    place: &str,
    report: &mut ValidationReport,
) {
    let name = if channel.name == "Y" { "reflectance".into() } else { channel.name.to_lowercase() };
    let Some(png) = decoded.get(&name) else { return };
    // One loop for each rule: a name that is asked at every pixel costs more than the pixel.
    let other = match name.as_str() {
        "range" => {
            let half = 0.5 + HALF_STEP / row.range_scale + 1e-6;
            unlike(exr, png, |exr, png| same_range((f64::from(exr) - row.range_offset) / row.range_scale, png, half))
        }
        // Rounded to whole numbers, and to half precision before: 2^-4 at most below 256.
        "reflectance" => {
            unlike(
                exr,
                png,
                |exr, png| {
                    if exr.is_nan() { png == 0 } else { (exr - f32::from(png)).abs() <= 0.5 + 0.0625 }
                },
            )
        }
        "scatter" => unlike(exr, png, |exr, png| {
            let same = (exr - f32::from(png)).abs() <= 0.5 || (png == u16::MAX && exr > 65535.0);
            if exr.is_nan() { png == 0 } else { same }
        }),
        _ => unlike(exr, png, |exr, png| exr == f32::from(png)),
    };
    if other > 0 {
        let what = format!("{other} samples of {} are not those of the image `{name}`", channel.name);
        report.faults.push(Finding::new(Code::ExrDiffers, place, what));
    }
}

/// Pixels that are not the same by a rule.
fn unlike(exr: &[f32], png: &[u16], same: impl Fn(f32, u16) -> bool) -> usize {
    exr.iter().zip(png).filter(|(exr, png)| !same(**exr, **png)).count()
}

/// Half the step in which EXR files give Range, 2^-13 [mm or px].
const HALF_STEP: f64 = 1.0 / 16384.0;

/// Whether `exact`, a range number before it is rounded, is within `half` a step of both, or beyond the ends where the image
/// saturates.
fn same_range(exact: f64, png: u16, half: f64) -> bool {
    match png {
        0 => exact.is_nan(),
        1 => exact <= 1.0 + half,
        u16::MAX => exact >= 65535.0 - half,
        _ => (exact - f64::from(png)).abs() <= half,
    }
}
