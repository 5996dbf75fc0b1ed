//! The settings by which profiles are read, and which of them have an effect beside which others.

use std::collections::BTreeMap;

use super::setting::{Kind, Setting, Value, setting};
use crate::settings::{Direction, Method, Peak, RangeForm, ScatterDark, ScatterMode};
use crate::yaml::walk::Walk;

/// From frames to measures.
pub(super) const EXTRACTION: &[Setting] = &[
    setting(
        "method",
        Kind::Word(&Method::NAMES),
        Value::Word(Method::NAMES[0]),
        "How the peak is placed between the rows.",
        "[T] centre of gravity",
    ),
    setting(
        "blais_rioux_order",
        Kind::OneOf(&[2, 4, 8]),
        Value::Count(4),
        "For `blais_rioux`: rows of the derivative, half of them on each side.",
        "Blais and Rioux 1986",
    ),
    setting(
        "fir_length",
        Kind::OneOf(&[3, 5, 7, 9]),
        Value::Count(5),
        "For `fir`: taps of the binomial smoothing before the derivative.",
        "free",
    ),
    setting(
        "window_rows",
        Kind::OneOf(&[3, 7, 15]),
        Value::Count(7),
        "Rows on each side of the peak that the position is made from; `parabola` and `gaussian` have one.",
        "window around the maximum of the real camera",
    ),
    setting(
        "peak",
        Kind::Word(&Peak::NAMES),
        Value::Word(Peak::NAMES[0]),
        "Which peak of a column counts: the `strongest`, or the `first` that reaches the threshold.",
        "GlobalMax and FirstLocalMax of the real camera",
    ),
    setting(
        "direction",
        Kind::Word(&Direction::NAMES),
        Value::Word(Direction::NAMES[0]),
        "From where peaks are searched: `standard` from row 0, `reverse` from the last; a plateau counts from its first row.",
        "search direction of the real camera",
    ),
    setting(
        "threshold_dn",
        Kind::Number { min: 0.0, max: 255.0, unit: "DN" },
        Value::Number(17.0),
        "Smallest digital number of a peak, on the scale of 8 bits.",
        "dark level plus five standard deviations",
    ),
    setting(
        "subpixel_steps",
        Kind::Count { min: 0, max: 256, unit: "" },
        Value::Count(16),
        "Steps per row in which the peak position is given; 0 leaves it unrounded.",
        "1/16 px of the real camera",
    ),
    setting(
        "scatter_mode",
        Kind::Word(&ScatterMode::NAMES),
        Value::Word("symmetric"),
        "Which side windows Scatter sums: both, `front` (smaller row numbers) or `back`.",
        "modes of the real camera",
    ),
    setting(
        "scatter_offset_rows",
        Kind::Count { min: 0, max: 15, unit: "px" },
        Value::Count(1),
        "Distance from the peak to the first summed row; 0 includes the peak.",
        "[T] wood",
    ),
    setting(
        "scatter_width_rows",
        Kind::Count { min: 1, max: 16, unit: "px" },
        Value::Count(8),
        "Rows that are summed on each side; offset and width together at most 16, at most 29 rows in all.",
        "[T] wood",
    ),
    setting(
        "scatter_dark",
        Kind::Word(&ScatterDark::NAMES),
        Value::Word(ScatterDark::NAMES[0]),
        "Whether the dark level stays in Scatter or is taken out, ending at 0.",
        "the real camera sums plain numbers",
    ),
    setting(
        "range",
        Kind::Word(&RangeForm::NAMES),
        Value::Word(RangeForm::NAMES[0]),
        "What Range is: height at each sensor column [mm], sensor row [px], or height on an even grid of x [mm].",
        "CalibratedAC, UncalibratedC and RectifiedC of the real camera",
    ),
    setting(
        "rectified_pitch_mm",
        Kind::NumberOrAuto { min: 0.001, max: 10.0, unit: "mm" },
        Value::Word("auto"),
        "For `range: rectified`: distance of the grid's columns; `auto` is that of the sensor's columns at z = 0.",
        "free",
    ),
];

/// The setting that `name` depends on, the words of it beside which it has an effect, and which of them is usual.
fn user(name: &str) -> Option<(&'static str, &'static [&'static str], &'static str)> {
    match name {
        "blais_rioux_order" => Some(("method", &["blais_rioux"], Method::NAMES[0])),
        "fir_length" => Some(("method", &["fir"], Method::NAMES[0])),
        "window_rows" => Some(("method", &["centre_of_gravity", "blais_rioux", "fir"], Method::NAMES[0])),
        "rectified_pitch_mm" => Some(("range", &["rectified"], RangeForm::NAMES[0])),
        _ => None,
    }
}

/// The setting and its word beside which `name` has no effect, and the words beside which it has one.
fn idle(
    name: &str,
    settings: &BTreeMap<String, Value>,
) -> Option<(&'static str, &'static str, &'static [&'static str])> {
    let (key, words, default) = user(name)?;
    let chosen = match settings.get(&format!("extraction.{key}")) {
        Some(Value::Word(word)) => word,
        _ => default,
    };
    (!words.contains(&chosen)).then_some((key, chosen, words))
}

/// Notes each setting that the recipe gives and that has no effect.
pub(super) fn refuse_idle(walk: &mut Walk, given: &BTreeMap<String, Value>) {
    for setting in EXTRACTION {
        let path = format!("extraction.{}", setting.name);
        if let Some((key, chosen, words)) = idle(setting.name, given).filter(|_| given.contains_key(&path)) {
            let remedy = format!("it is for `{key}: {}`: give one of them, or remove it", words.join("` or `"));
            let remedy = if words.len() == 1 { remedy.replace("give one of them", "give that") } else { remedy };
            walk.joint_fault(&[path], format!("has no effect beside `{key}: {chosen}`"), remedy);
        }
    }
}

/// Takes out what has no effect, defaults included, so that it is no part of what the recipe means.
pub(super) fn leave_out_idle(settings: &mut BTreeMap<String, Value>) {
    for setting in EXTRACTION {
        if idle(setting.name, settings).is_some() {
            settings.remove(&format!("extraction.{}", setting.name));
        }
    }
}
