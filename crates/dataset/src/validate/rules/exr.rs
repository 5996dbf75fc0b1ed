//! The EXR file of a sample, decoded once: declared channels, the same content as the row and its images. The rules of
//! reading it are one file.

use output_schema::DatasetHead;
use output_schema::row::CALIBRATION;
use serde_json::Value;

use super::profile_differs::RowComparison;
use super::{Code, REMAKE_OR_REPORT, Rule, header_differs, truth_differs};
use crate::validate::decoded_images::image_of_channel;
use crate::validate::report::ValidationReport;
use crate::validate::sample_to_check::SampleToCheck;
use crate::{ExrChannel, ExrSize, channel_types, exr_header, read_exr_of};

pub(super) const UNREADABLE: Rule = Rule { meaning: "An EXR file cannot be read.", remedy: REMAKE_OR_REPORT };
pub(super) const CHANNELS: Rule =
    Rule { meaning: "An EXR file has other channels, types or size than declared.", remedy: REMAKE_OR_REPORT };
pub(super) const DIFFERS: Rule =
    Rule { meaning: "An EXR file says something else than the row's images.", remedy: REMAKE_OR_REPORT };

/// Checks the EXR file of a sample, which lies at `place`, against its declaration in the head, the row, its images,
/// what the body shows and what is `exposed` again in some rows; its channels, where they can be read.
pub(in crate::validate) fn check(
    bytes: &[u8],
    sample: &SampleToCheck,
    exposed: &mut RowComparison,
    place: &str,
    report: &mut ValidationReport,
) -> Option<Vec<ExrChannel>> {
    let (head, row) = (sample.task.head, &sample.row);
    let declared = head.channels();
    let header = exr_header(bytes).map_err(|what| report.fault(Code::ExrUnreadable, place, what)).ok()?;
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
        return None;
    }
    let content = read_exr_of(bytes, &ExrSize::of(head));
    let (.., channels, text) = content.map_err(|what| report.fault(Code::ExrUnreadable, place, what)).ok()?;
    report.images += channels.len() as u64;
    let description: Value = serde_json::from_str(&text).unwrap_or_default();
    let before = report.faults.len();
    attribute(&description, sample, place, report);
    for channel in declared.iter().filter(|c| description["units"][c.name] != c.unit) {
        let what = format!(
            "its attribute gives {} in {}, not in {}",
            channel.name, description["units"][channel.name], channel.unit
        );
        report.fault(Code::ExrDiffers, place, what);
    }
    if report.faults.len() == before {
        header_differs::check(&header, sample, place, report);
    }
    for channel in &channels {
        let numbers = channel.as_numbers();
        let ((low, high), missing) = range(&channel.name, head);
        // Without branches: of every number of every channel.
        let inside = |n: f32| (n >= low) & (n <= high) | (missing & n.is_nan());
        let outside = numbers.iter().filter(|n| !inside(**n)).count();
        if outside > 0 {
            let what = format!("{outside} samples of {} are outside of the declared range", channel.name);
            report.fault(Code::ValueRange, place, what);
        }
        truth_differs::rows(sample, channel, place, report);
        exposed.channel(channel);
        compare(channel, &numbers, sample, place, report);
    }
    Some(channels)
}

/// The label image of an EXR file that is as its head declares it.
pub(in crate::validate) fn label(bytes: &[u8], head: &DatasetHead) -> Option<Vec<u16>> {
    let (_, _, channels, _) = read_exr_of(bytes, &ExrSize::of(head)).ok()?;
    let label = channels.iter().find(|channel| channel.name == "Label")?.as_numbers();
    Some(label.iter().map(|&class| class as u16).collect())
}

/// The text attribute repeats what the row says.
fn attribute(description: &Value, sample: &SampleToCheck, place: &str, report: &mut ValidationReport) {
    let (head, row) = (sample.task.head, &sample.row);
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
        report.fault(Code::ExrDiffers, place, what);
    }
    let bench = row.derived.iter().take_while(|(name, _)| CALIBRATION.iter().any(|field| field.name == name));
    for (name, value) in bench.filter(|(name, value)| description["calibration"][name] != *value) {
        let what = format!("its attribute gives {name} as {}, the row as {value}", description["calibration"][name]);
        report.fault(Code::ExrDiffers, place, what);
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
        "FibreAzimuth" | "FibreDive" => ((-90.0, 90.0), true),
        _ => ((f32::MIN, f32::MAX), true),
    }
}

fn compare(channel: &ExrChannel, exr: &[f32], sample: &SampleToCheck, place: &str, report: &mut ValidationReport) {
    let (row, name) = (&sample.row, image_of_channel(&channel.name));
    let Some(png) = sample.images.get(&name) else { return };
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
        report.fault(Code::ExrDiffers, place, what);
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
