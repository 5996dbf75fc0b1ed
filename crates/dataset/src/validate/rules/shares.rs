//! The shares of a row against its images, and what makes a sample of little use though nothing is wrong with it.
//! Pixels are counted once, so these rules are one file.

use output_schema::row::SHARES;

use super::{Code, REMAKE_OR_REPORT, Rule, SampleToCheck, ValidationReport};
use crate::shares::{ObjectPixels, SampleShares, Shortfall};

pub(super) const DIFFERS: Rule =
    Rule { meaning: "The measured or the saturated share is not what the images show.", remedy: REMAKE_OR_REPORT };
pub(super) const OBJECT_OUT_OF_VIEW: Rule = Rule {
    meaning: "Warning: less than two thirds of the object lie in the field of the images, or no pixel shows it.",
    remedy: Shortfall::ObjectOutOfView.remedy(),
};
pub(super) const HARDLY_MEASURED: Rule = Rule {
    meaning: "Warning: Range is measured in less than a tenth of the pixels that show the object.",
    remedy: Shortfall::HardlyMeasured.remedy(),
};
pub(super) const PARTLY_MEASURED: Rule = Rule {
    meaning: "Warning: Range is measured in less than 80 % of the pixels that show matter without defect.",
    remedy: Shortfall::PartlyMeasured.remedy(),
};
pub(super) const SATURATED: Rule = Rule {
    meaning: "Warning: the line saturates in 95 % of the object's measured pixels, or more.",
    remedy: Shortfall::Saturated.remedy(),
};

impl From<Shortfall> for Code {
    fn from(shortfall: Shortfall) -> Self {
        match shortfall {
            Shortfall::ObjectOutOfView => Self::ObjectOutOfView,
            Shortfall::HardlyMeasured => Self::HardlyMeasured,
            Shortfall::PartlyMeasured => Self::PartlyMeasured,
            Shortfall::Saturated => Self::Saturated,
        }
    }
}

pub(super) fn check(sample: &SampleToCheck, report: &mut ValidationReport) {
    let SampleToCheck { task, row, images: decoded, place, .. } = sample;
    let Some(shares) = row.shares else { return };
    let SampleShares { measured, saturated, in_view, .. } = shares;
    let mut fault = |code, what: String| report.fault(code, place, what);
    let stored = SHARES.into_iter().zip([measured, saturated, in_view]);
    let outside: Vec<String> = stored
        .filter(|(_, share)| !share.is_nan() && !(0.0..=1.0).contains(share))
        .map(|(name, share)| format!("{name} is {share}"))
        .collect();
    if !outside.is_empty() {
        return fault(Code::ValueRange, outside.join("; "));
    }
    // EXR files hold Reflectance before it is rounded, and in half precision.
    let is_rounded = task.head.images.png.iter().any(|name| name == "reflectance");
    let reflectance = decoded.get("reflectance").filter(|_| is_rounded);
    let most = task.head.images.most_dn();
    let made = decoded.get("label").zip(decoded.get("range")).map(|(label, range)| {
        let greatest = |i: usize| reflectance.and_then(|dn| dn.get(i)).is_some_and(|dn| *dn >= most);
        let pixels = label.iter().zip(range).enumerate();
        ObjectPixels::count(pixels.map(|(i, (label, range))| (*label, [*range > 0, greatest(i)]))).shares()
    });
    let sound = made.map_or(f64::NAN, |[_, sound, _]| sound);
    let made = [made.map(|[measured, ..]| measured), made.and_then(|[.., saturated]| reflectance.map(|_| saturated))];
    // Whether any pixel shows the object the row says without images too.
    let background = task.head.shown_classes().position(|(value, _)| value == 0);
    let bare = background.and_then(|place| row.class_area_px.get(place)).copied().unwrap_or(0);
    let is_shown = row.class_area_px.iter().sum::<i64>() > bare;
    let text = |share: f64| if share.is_nan() { "missing".to_owned() } else { format!("{share:?}") };
    let mut other = Vec::new();
    let is_measured = is_shown && measured != 0.0;
    let stored = SHARES.into_iter().zip([(measured, is_shown), (saturated, is_measured)]);
    for ((name, (stored, has_one)), made) in stored.zip(made) {
        match made {
            Some(made) if stored != made && !(stored.is_nan() && made.is_nan()) => {
                other.push(format!("{name} is {}, the images show {}", text(stored), text(made)));
            }
            None if stored.is_nan() == has_one => {
                let shown = if has_one { "pixels that it is of" } else { "no pixels that it could be of" };
                other.push(format!("{name} is {}, and there are {shown}", text(stored)));
            }
            _ => {}
        }
    }
    if !other.is_empty() {
        return fault(Code::ShareDiffers, other.join("; "));
    }
    let shares = SampleShares { sound, ..shares };
    for short in shares.shortfalls() {
        report.warn(short.into(), place, shares.describe(short));
    }
}
