//! Range is 0 exactly where reflectance and scatter are 0.

use super::{Code, REMAKE_OR_REPORT, Rule, ValidationReport};
use crate::validate::decoded_images::DecodedImages;

pub(super) const RULE: Rule =
    Rule { meaning: "Range is missing where light was measured, or the other way round.", remedy: REMAKE_OR_REPORT };

/// Checks the PNG images: EXR files hold numbers before they are rounded to 0.
pub(super) fn check(decoded: &DecodedImages, place: &str, report: &mut ValidationReport) {
    let Some(range) = decoded.get("range") else { return };
    let (reflectance, scatter) = (decoded.get("reflectance"), decoded.get("scatter"));
    let light = |map: Option<&[u16]>, i: usize| map.is_some_and(|map| map[i] > 0);
    let both = reflectance.is_some() && scatter.is_some();
    let broken = |&i: &usize| {
        let lit = light(reflectance, i) || light(scatter, i);
        if range[i] == 0 { lit } else { both && !lit }
    };
    let count = (0..range.len()).filter(broken).count();
    if count > 0 {
        let what = format!("{count} pixels have range without light, or light without range");
        report.fault(Code::MissingRule, place, what);
    }
}
