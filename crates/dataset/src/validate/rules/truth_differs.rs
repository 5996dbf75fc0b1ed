//! Truth maps of an EXR file against the body that the recipe makes, grown again without light, in some rows, number by
//! number; and against the labels in every pixel: both come from one noise-free hit, so they agree exactly. Of what
//! another program wrote that is not known, and the sample is to be looked at.

use exr::prelude::f16;
use output_schema::SampleType;

use super::{Code, REMAKE_OR_REPORT, Rule, SampleToCheck, ValidationReport};
use crate::{ExrChannel, truth_channel};

pub(super) const RULE: Rule = Rule {
    meaning: "Labels or objects are not what the truth maps show; a warning where the recipe cannot be drawn again.",
    remedy: REMAKE_OR_REPORT,
};

/// A channel of truth maps of an EXR file, number by number: both are made from one noise-free hit and rounded alike.
pub(super) fn rows(sample: &SampleToCheck, channel: &ExrChannel, report: &mut ValidationReport) {
    let (rows, cols) = (sample.true_rows(), sample.cols());
    let is_half = channel.samples == SampleType::Half;
    let rounded = |made: f32| if is_half { f16::from_f32(made).to_f32() } else { made };
    let other = |(found, made): (&f32, f32)| *found != rounded(made) && !(found.is_nan() && made.is_nan());
    let (mut count, mut compared) = (0, 0);
    for row in rows {
        let Some(made) = truth_channel(&row.truth, &channel.name) else { return };
        let Some(line) = channel.numbers.get(row.row * cols..(row.row + 1) * cols) else { continue };
        count += line.iter().zip(made).filter(|pair| other(*pair)).count();
        compared += 1;
    }
    if count > 0 {
        let what = format!("{} of {count} pixels of {compared} rows is not the body's", channel.name);
        report.fault(Code::TruthDiffers, sample.exr_path(), what);
    }
}

/// Labels against the truth maps of the EXR file.
pub(in crate::validate) fn labels(sample: &SampleToCheck, report: &mut ValidationReport) {
    let SampleToCheck { task, images: decoded, .. } = sample;
    let mut fault = |what: String| report.tell(task.is_exact(), Code::TruthDiffers, sample.exr_path(), what);
    let bin = &task.head.recipe.canonical["output"]["bin"];
    // A binned pixel is of the most frequent class, its truth a mean of what is known.
    let whole = bin["columns"] == 1 && bin["profiles"] == 1;
    if let (Some(height), Some(label)) = (sample.channel("Height"), decoded.get("label")) {
        let wrong =
            |(z, label): &(&f32, &u16)| if whole { z.is_nan() != (**label == 0) } else { z.is_nan() && **label != 0 };
        let count = height.iter().zip(label).filter(wrong).count();
        if count > 0 {
            fault(format!("{count} pixels have a height on the background, or none on the object"));
        }
    }
    let Some(instance) = decoded.get("instance") else { return };
    if let Some(gap) = sample.channel("FilmGap").filter(|_| whole) {
        let count = gap.iter().zip(instance).filter(|(gap, instance)| **gap > 0.0 && **instance == 0).count();
        if count > 0 {
            fault(format!("{count} pixels of the flange have air below the film"));
        }
    }
}
