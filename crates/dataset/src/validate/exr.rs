//! EXR files: declared channels, ranges, and the same content as the row's images.

use exr::meta::header::Header;
use output_schema::row::{CALIBRATION, IMAGES};
use output_schema::{DatasetHead, SCHEMA_VERSION};
use serde_json::Value;

use super::columns::StoredRow;
use super::exposed_rows::RowComparison;
use super::finding::{Code, Finding};
use super::images::DecodedImages;
use super::report::ValidationReport;
use super::shard_task::ShardTask;
use super::{pixels, true_rows};
use crate::record::TrueRow;
use crate::{
    ExrChannel, ExrDescription, ExrSize, GENERATOR_VERSION, channel_types, expected_header, exr_header, read_exr_of,
};

/// Checks one EXR file against its declaration in the head and the images of its row; adds label and instance to the images where
/// the row has none. `rows` is what the body shows in some rows, `exposed` what is measured in others.
pub(super) fn check(
    bytes: &[u8],
    task: &ShardTask,
    row: &StoredRow,
    (decoded, rows, exposed): (&mut DecodedImages, &[TrueRow], &mut RowComparison),
    place: &str,
    report: &mut ValidationReport,
) {
    let head = task.head;
    let declared = head.channels();
    let header = match exr_header(bytes) {
        Ok(header) => header,
        Err(what) => return report.faults.push(Finding::new(Code::ExrUnreadable, place, what)),
    };
    // Nothing is decoded that is not as large as declared.
    let expected: Vec<_> = declared.iter().map(|c| (c.name.to_owned(), c.samples)).collect();
    let (found, size) = (channel_types(&header), (header.layer_size.0, header.layer_size.1));
    let wanted = (usize::try_from(row.cols).unwrap_or(0), usize::try_from(row.rows).unwrap_or(0));
    if expected != found || size != wanted {
        report.images += found.len() as u64;
        let (cols, lines) = size;
        let named = &found[..found.len().min(declared.len() + 1)];
        let what = format!("it holds {cols} x {lines} of {named:?}, not {} x {} of {expected:?}", row.cols, row.rows);
        return report.faults.push(Finding::new(Code::ExrChannels, place, what));
    }
    let (cols, _, channels, text) = match read_exr_of(bytes, &ExrSize::of(head)) {
        Ok(content) => content,
        Err(what) => return report.faults.push(Finding::new(Code::ExrUnreadable, place, what)),
    };
    report.images += channels.len() as u64;
    let description: Value = serde_json::from_str(&text).unwrap_or_default();
    let before = report.faults.len();
    attribute(&description, row, head, place, report);
    for channel in declared.iter().filter(|c| description["units"][c.name] != c.unit) {
        let what = format!(
            "its attribute gives {} in {}, not in {}",
            channel.name, description["units"][channel.name], channel.unit
        );
        report.faults.push(Finding::new(Code::ExrDiffers, place, what));
    }
    if report.faults.len() == before {
        form(&header, row, head, place, report);
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
        true_rows::truth(rows, cols, channel, place, report);
        exposed.channel(cols, channel);
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
    pixels::truth(task, &channels, decoded, place, report);
    if !task.is_exact() {
        pixels::dive(row, &channels, decoded, place, report);
    }
}

/// The label image of an EXR file that is as its head declares it.
pub(super) fn label(bytes: &[u8], head: &DatasetHead) -> Option<Vec<u16>> {
    let (_, _, channels, _) = read_exr_of(bytes, &ExrSize::of(head)).ok()?;
    let label = channels.iter().find(|channel| channel.name == "Label")?.as_numbers();
    Some(label.iter().map(|&class| class as u16).collect())
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

/// The header is the one that this program writes: windows, spacing, compression, attributes and the text of its own one. Of
/// another version it may be another one.
fn form(header: &Header, row: &StoredRow, head: &DatasetHead, place: &str, report: &mut ValidationReport) {
    if head.schema_version != SCHEMA_VERSION || head.generator.version != GENERATOR_VERSION {
        return;
    }
    let channels = head.channels();
    let class = usize::try_from(row.class).ok().and_then(|class| head.classes.get(class));
    let calibration = row.derived.iter().filter(|(name, _)| CALIBRATION.iter().any(|field| field.name == name));
    let description = ExrDescription {
        id: &row.id,
        index: row.index.unsigned_abs(),
        split: &row.split,
        class: class.map_or("", String::as_str),
        pitch_mm: [row.row_mm, row.col_mm],
        bits: head.images.bits,
        range: &head.images.range,
        sensor_rows: head.images.sensor_rows,
        calibration: calibration.map(|(name, value)| (name.as_str(), *value)).collect(),
        channels: &channels,
    };
    let size = (header.layer_size.0, header.layer_size.1);
    let expected = expected_header(&channels, size, (row.col_mm, row.row_mm), &description.json());
    let Some(expected) = expected.filter(|expected| expected != header) else { return };
    let [found, made] = [&header, &&expected].map(|header| &header.own_attributes);
    let (shared, own) = (&header.shared_attributes, &expected.shared_attributes);
    let parts = [
        ("data window", found.layer_position != made.layer_position),
        ("display window", shared.display_window != own.display_window),
        ("pixel aspect", shared.pixel_aspect != own.pixel_aspect),
        ("text attribute", shared.other != own.other),
        ("compression", header.compression != expected.compression),
        ("order of lines", header.line_order != expected.line_order),
    ];
    let other: Vec<&str> = parts.iter().filter(|(_, differs)| *differs).map(|(name, _)| *name).collect();
    let named = if other.is_empty() { "attributes".into() } else { other.join(", ") };
    let what = format!("its header is not the one that the program writes: {named}");
    report.faults.push(Finding::new(Code::HeaderDiffers, place, what));
}

/// Smallest and largest number that a channel may have, and whether it may be missing.
fn range(channel: &str, head: &DatasetHead) -> ((f32, f32), bool) {
    let most = f32::from(head.images.most_dn());
    match channel {
        "Range" if head.range_unit() == "px" => ((0.0, (head.images.sensor_rows as f32).next_down()), true),
        "Reflectance" => ((0.0, most), true),
        "Y" => ((0.0, most), false),
        "Scatter" | "FilmGap" | "FilmThickness" => ((0.0, f32::MAX), true),
        "FibreAzimuth" | "FibreDive" => ((-90.0, 90.0), true),
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
