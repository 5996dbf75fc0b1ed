//! True rows: some rows of the images against the body that the recipe makes, grown again without light: label and instance pixel by
//! pixel, truth maps number by number, and whether Range is anywhere near it.
//!
//! Range is no truth: it lies below the surface of what lets light in, and is the tablet's under clear film. Where no
//! row is exposed again, which tells it exactly, it is held to what hardly a measurement misses, and a warning says so:
//! the median distance of well lit pixels from between the surface and what lies below a film is [`FAR_MM`] at most.
//! Pixels at the greatest digital number are left out: a line that is saturated over many rows is measured in the
//! middle of these.

use exr::prelude::f16;
use output_schema::SampleType;

use super::finding::{Code, Finding};
use super::images::DecodedImages;
use super::report::ValidationReport;
use crate::record::TrueRow;
use crate::{ExrChannel, truth_channel};

/// Median distance of Range from the body that is told [mm].
const FAR_MM: f32 = 2.0;
/// A pixel is well lit from this share of the greatest digital number on, if it is below that [1].
const LIT: f32 = 0.25;
/// Pixels that it takes to judge Range [px].
const MIN_PIXELS: usize = 64;

/// Label and instance images.
pub(super) fn labels(
    rows: &[TrueRow],
    cols: usize,
    decoded: &DecodedImages,
    place: &str,
    report: &mut ValidationReport,
) {
    let [label, instance] = ["label", "instance"].map(|name| decoded.get(name));
    let (mut wrong, mut first) = (0_usize, None);
    for row in rows {
        let line = row.row * cols..(row.row + 1) * cols;
        let [label, instance] = [label, instance].map(|image| image.and_then(|image| image.get(line.clone())));
        let classes = label.is_some_and(|label| label.iter().zip(&row.class).any(|(a, b)| *a != u16::from(*b)));
        if !classes && instance.is_none_or(|instance| instance == row.instance) {
            continue;
        }
        for column in 0..cols {
            let found = [label, instance].map(|line| line.and_then(|line| line.get(column).copied()));
            let made = [row.class.get(column).map(|class| u16::from(*class)), row.instance.get(column).copied()];
            if found.iter().zip(made).any(|(found, made)| found.is_some() && *found != made) {
                wrong += 1;
                first = first.or(Some((row.row, column, made)));
            }
        }
    }
    if let Some((row, column, [class, instance])) = first {
        let what = format!(
            "{wrong} pixels of {} rows are not as the body has them; the first, column {column} row {row}, is class {} of instance {}",
            rows.len(),
            class.unwrap_or_default(),
            instance.unwrap_or_default()
        );
        report.faults.push(Finding::new(Code::LabelDiffers, place, what));
    }
}

/// A channel of truth maps of an EXR file, number by number: both are made from one noise-free hit and rounded alike.
pub(super) fn truth(rows: &[TrueRow], cols: usize, channel: &ExrChannel, place: &str, report: &mut ValidationReport) {
    let numbers = channel.as_numbers();
    let is_half = channel.sample_type() == SampleType::Half;
    let rounded = |made: f32| if is_half { f16::from_f32(made).to_f32() } else { made };
    let other = |(found, made): (&f32, f32)| *found != rounded(made) && !(found.is_nan() && made.is_nan());
    let (mut count, mut compared) = (0, 0);
    for row in rows {
        let Some(made) = truth_channel(&row.truth, &channel.name) else { return };
        let Some(line) = numbers.get(row.row * cols..(row.row + 1) * cols) else { continue };
        count += line.iter().zip(made).filter(|pair| other(*pair)).count();
        compared += 1;
    }
    if count > 0 {
        let what = format!("{} of {count} pixels of {compared} rows is not the body's", channel.name);
        report.faults.push(Finding::new(Code::TruthDiffers, place, what));
    }
}

/// Range, whose number r > 0 means `scale[0] + r * scale[1]` [mm], where Reflectance says that light came; `most` is the
/// greatest digital number.
pub(super) fn range(
    rows: &[TrueRow],
    (cols, scale, most): (usize, [f64; 2], u16),
    decoded: &DecodedImages,
    place: &str,
    report: &mut ValidationReport,
) {
    let (Some(range), Some(light)) = (decoded.get("range"), decoded.get("reflectance")) else { return };
    let mut apart = Vec::new();
    for row in rows {
        let line = row.row * cols..(row.row + 1) * cols;
        let (Some(range), Some(light)) = (range.get(line.clone()), light.get(line)) else { continue };
        let bodies = row.truth.height.iter().zip(&row.lower);
        for ((&range, &light), (&height, &below)) in range.iter().zip(light).zip(bodies) {
            if range > 0 && light < most && f32::from(light) >= LIT * f32::from(most) && !height.is_nan() {
                let measured = (scale[0] + f64::from(range) * scale[1]) as f32;
                apart.push((measured - height).max(0.0) - (below - measured).max(0.0));
            }
        }
    }
    if apart.len() < MIN_PIXELS {
        return;
    }
    let middle = apart.len() / 2;
    let median = *apart.select_nth_unstable_by(middle, f32::total_cmp).1;
    if median.abs() > FAR_MM {
        let side = if median > 0.0 { "above" } else { "below" };
        let what = format!(
            "Range of {} well lit pixels lies {:.1} mm {side} the body in the middle, of {} rows",
            apart.len(),
            median.abs(),
            rows.len()
        );
        report.warnings.push(Finding::new(Code::RangeDiffers, place, what));
    }
}
