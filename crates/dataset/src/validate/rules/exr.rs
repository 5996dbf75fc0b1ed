//! The EXR file of a sample, decoded once: declared channels, the same content as the row and its images. The rules of
//! reading it are one file.

use output_schema::row::CALIBRATION;
use output_schema::{Channel, DatasetHead};
use serde_json::Value;

use super::profile_differs::RowComparison;
use super::{Code, REMAKE_OR_REPORT, Rule, SampleToCheck, ValidationReport, header_differs, truth_differs};
use crate::validate::decoded_images::image_of_channel;
use crate::validate::whole_range;
use crate::{ExrChannel, ExrDescription, ExrSize, channel_types, exr_header, read_exr_of};

pub(super) const UNREADABLE: Rule = Rule { meaning: "An EXR file cannot be read.", remedy: REMAKE_OR_REPORT };
pub(super) const CHANNELS: Rule =
    Rule { meaning: "An EXR file has other channels, types or size than declared.", remedy: REMAKE_OR_REPORT };
pub(super) const DIFFERS: Rule =
    Rule { meaning: "An EXR file says something else than the row's images.", remedy: REMAKE_OR_REPORT };

/// Checks the EXR file of a sample, where that is whole, against its declaration in the head, the row, its images, what
/// the body shows and what is `exposed` again in some rows; its channels, where they can be read.
pub(in crate::validate) fn check(
    sample: &SampleToCheck,
    exposed: &mut RowComparison,
    report: &mut ValidationReport,
) -> Vec<ExrChannel> {
    let (head, row, place) = (sample.task.head, &sample.row, &sample.exr_path());
    let Some(bytes) = sample.exr else { return Vec::new() };
    let unreadable = |what: String, report: &mut ValidationReport| {
        report.fault(Code::ExrUnreadable, place, what);
        Vec::new()
    };
    let declared = head.channels();
    let header = match exr_header(bytes) {
        Ok(header) => header,
        Err(what) => return unreadable(what, report),
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
        report.fault(Code::ExrChannels, place, what);
        return Vec::new();
    }
    let (.., channels, text) = match read_exr_of(bytes, &ExrSize::of(head)) {
        Ok(content) => content,
        Err(what) => return unreadable(what, report),
    };
    report.images += channels.len() as u64;
    let channels = match whole_range::joined(channels, sample) {
        Ok(channels) => channels,
        Err(what) => {
            report.fault(Code::ExrDiffers, place, what);
            return Vec::new();
        }
    };
    let (found, expected) = (serde_json::from_str(&text).unwrap_or_default(), description(sample, &declared));
    let other = attribute(&found, &expected, sample, &declared);
    if other.is_empty() {
        header_differs::check(&header, &expected, sample, report);
    }
    other.into_iter().for_each(|what| report.fault(Code::ExrDiffers, place, what));
    for channel in &channels {
        let ((low, high), missing) = range(&channel.name, head);
        // Without branches: of every number of every channel.
        let inside = |n: f32| (n >= low) & (n <= high) | (missing & n.is_nan());
        let outside = channel.numbers.iter().filter(|n| !inside(**n)).count();
        if outside > 0 {
            let what = format!("{outside} samples of {} are outside of the declared range", channel.name);
            report.fault(Code::ValueRange, place, what);
        }
        truth_differs::rows(sample, channel, report);
        exposed.channel(channel);
        compare(channel, sample, report);
    }
    channels
}

/// The label image of an EXR file that is as its head declares it.
pub(in crate::validate) fn label(bytes: &[u8], head: &DatasetHead) -> Option<Vec<u16>> {
    let (_, _, channels, _) = read_exr_of(bytes, &ExrSize::of(head)).ok()?;
    let label = channels.iter().find(|channel| channel.name == "Label")?;
    Some(label.numbers.iter().map(|&class| class as u16).collect())
}

/// The numbers of the camera that a row has, by name.
fn calibration<'a>(sample: &'a SampleToCheck) -> impl Iterator<Item = (&'a str, f64)> {
    let of_camera = |(name, _): &&(String, f64)| CALIBRATION.iter().any(|field| field.name == name);
    sample.row.derived.iter().filter(of_camera).map(|(name, value)| (name.as_str(), *value))
}

/// The text attribute that the row makes.
fn description(sample: &SampleToCheck, declared: &[Channel]) -> Value {
    let (head, row) = (sample.task.head, &sample.row);
    let class = usize::try_from(row.class).ok().and_then(|class| head.classes.get(class));
    let description = ExrDescription {
        id: &row.id,
        index: row.index.unsigned_abs(),
        split: &row.split,
        class: class.map(String::as_str),
        pitch_mm: [row.row_mm, row.col_mm],
        bits: head.images.bits,
        range: &head.images.range,
        sensor_rows: head.images.sensor_rows,
        calibration: calibration(sample).collect(),
        channels: declared,
    };
    description.json()
}

/// In what the text attribute differs from the one that the row makes.
fn attribute(found: &Value, expected: &Value, sample: &SampleToCheck, declared: &[Channel]) -> Vec<String> {
    let plain = expected.as_object().into_iter().flatten().filter(|(_, value)| !value.is_object());
    let plain = plain.filter(|(key, value)| found[*key] != **value);
    let said = plain.map(|(key, value)| format!("its attribute gives {key} as {}, the row as {value}", found[key]));
    let camera = calibration(sample).filter(|(name, value)| found["calibration"][name] != *value);
    let camera = camera.map(|(name, value)| {
        format!("its attribute gives {name} as {}, the row as {value}", found["calibration"][name])
    });
    let units = declared
        .iter()
        .filter(|c| found["units"][c.name] != c.unit)
        .map(|c| format!("its attribute gives {} in {}, not in {}", c.name, found["units"][c.name], c.unit));
    said.chain(camera).chain(units).collect()
}

/// Smallest and largest number that a channel may have, and whether it may be missing.
fn range(channel: &str, head: &DatasetHead) -> ((f32, f32), bool) {
    let most = f32::from(head.images.most_dn());
    match channel {
        "Range" if head.range_unit() == "px" => ((0.0, (head.images.sensor_rows as f32).next_down()), true),
        "Reflectance" | "Grey" => ((0.0, most), true),
        "Y" => ((0.0, most), false),
        "Scatter" | "FilmGap" | "FilmThickness" => ((0.0, f32::MAX), true),
        "FibreAzimuth" | "FibreDive" => ((-90.0, 90.0), true),
        _ => ((f32::MIN, f32::MAX), true),
    }
}

fn compare(channel: &ExrChannel, sample: &SampleToCheck, report: &mut ValidationReport) {
    let (row, exr, name) = (&sample.row, &channel.numbers, image_of_channel(&channel.name));
    let Some(png) = sample.images.get(&name) else { return };
    // One loop for each rule: a name that is asked at every pixel costs more than the pixel.
    let other = match name.as_str() {
        "range" => {
            let half = 0.5 + HALF_STEP / row.range_scale + 1e-6;
            unlike(exr, png, |exr, png| same_range((f64::from(exr) - row.range_offset) / row.range_scale, png, half))
        }
        // Rounded to whole numbers, and to half precision before: 2^-4 at most below 256.
        "reflectance" | "grey" => {
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
        report.fault(Code::ExrDiffers, sample.exr_path(), what);
    }
}

/// Pixels that are not the same by a rule.
fn unlike(exr: &[f32], png: &[u16], same: impl Fn(f32, u16) -> bool) -> usize {
    exr.iter().zip(png).filter(|(exr, png)| !same(**exr, **png)).count()
}

/// Half the step in which EXR files give Range, 2^-13 [mm or px].
const HALF_STEP: f64 = 1.0 / 16384.0;

/// Whether `exact`, a range number before it is rounded, is within `half` a step of both, or beyond the ends where the
/// image saturates.
fn same_range(exact: f64, png: u16, half: f64) -> bool {
    match png {
        0 => exact.is_nan(),
        1 => exact <= 1.0 + half,
        u16::MAX => exact >= 65535.0 - half,
        _ => (exact - f64::from(png)).abs() <= half,
    }
}
