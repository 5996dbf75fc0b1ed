//! The section `postprocess`: which of its keys, and which of the bench's, have an effect under which order.

use std::collections::BTreeMap;

use super::dist::Distribution;
use super::setting::{Kind, Setting, Value};
use super::settings::Settings;
use super::together::Together;
use crate::parameters::SpeckleParameters;
use crate::settings::{Order, Step};
use crate::yaml::walk::Walk;

/// Path of the section.
pub(super) const SECTION: &str = "postprocess";

/// What the section is about.
pub(super) const DOC: &str = "\
What is done to the light of whole frames before they are read. `physical` leaves it to laser, lens, speckle and sensor;
the others are the orders of the thesis' scripts, each on noise-free frames without speckle. A key beside an order that it
has no effect on is a fault.";

/// The settings.
pub(super) const TABLE: &[Setting] = &[
    Setting {
        name: "order",
        kind: Kind::Word(&Order::NAMES),
        default: Value::Word(Order::NAMES[0]),
        doc: "The scripts, first one first.",
        source: "[T] section 3.3; `physical` is ours",
    },
    Setting {
        name: "blur_radius_px",
        kind: Kind::Number { min: 0.05, max: 20.0, unit: "px" },
        default: Value::Number(0.5),
        doc: "Standard deviation of the Gaussian blur.",
        source: "[T] 0.5, wood 1; the thesis says radius",
    },
    Setting {
        name: "intensity_scale",
        kind: Kind::Number { min: 0.01, max: 100.0, unit: "" },
        default: Value::Number(3.5),
        doc: "Mean of the pattern of speckle that light is multiplied by.",
        source: "[T] saw-tooth 3.5, wood 6, pack 7",
    },
    Setting {
        name: "pattern_px",
        kind: Kind::Count { min: 64, max: 4096, unit: "" },
        default: Value::Count(1000),
        doc: "Side of the pattern.",
        source: "[T]",
    },
    Setting {
        name: "mask_px",
        kind: Kind::Count { min: 8, max: 2048, unit: "" },
        default: Value::Count(500),
        doc: "Diameter of the disc of random phases, at most half of the side: a speckle is side / diameter wide.",
        source: "[T]",
    },
    Setting {
        name: "sampling_factor",
        kind: Kind::Count { min: 1, max: 32, unit: "" },
        default: Value::Count(5),
        doc: "Pattern pixels along a sensor pixel; 6 makes the speckles of the default bench as large as they are.",
        source: "[T] 5",
    },
];

/// Keys of the sensor that the scripts know nothing of; they must be 0 there, so that the recipe says what is made.
const SENSOR: [&str; 10] = [
    "camera.ambient_w_per_m2_nm",
    "exposure.shot_noise",
    "exposure.row_noise_dn",
    "exposure.row_pattern_dn",
    "exposure.column_pattern_dn",
    "exposure.dsnu_dn",
    "exposure.prnu",
    "exposure.dark_current_e_per_s",
    "exposure.blooming",
    "exposure.defect_share",
];

/// The order that is chosen.
fn order(settings: &BTreeMap<String, Value>) -> Order {
    match settings.get(&format!("{SECTION}.order")) {
        Some(Value::Word(word)) => Order::ALL.into_iter().find(|order| order.name() == *word),
        _ => None,
    }
    .unwrap_or(Order::Physical)
}

/// Whether a setting has an effect under an order.
fn used(name: &str, order: Order) -> bool {
    match name {
        "order" => true,
        "blur_radius_px" => order.steps().contains(&Step::Blur),
        _ => order.steps().contains(&Step::Speckle),
    }
}

/// Faults of keys that were given and have no effect.
pub(super) fn idle(walk: &mut Walk, given: &BTreeMap<String, Value>) {
    let order = order(given);
    for setting in TABLE.iter().filter(|setting| !used(setting.name, order)) {
        let path = format!("{SECTION}.{}", setting.name);
        if given.contains_key(&path) {
            let others: Vec<_> =
                Order::ALL.into_iter().filter(|&other| used(setting.name, other)).map(Order::name).collect();
            let remedy = format!("it is for `order: {}`: give one of them, or remove it", others.join("` or `"));
            walk.joint_fault(&[path], format!("has no effect on order `{}`", order.name()), remedy);
        }
    }
    let law = "speckle.law".to_owned();
    if given.contains_key(&law) && order != Order::Physical && !order.steps().contains(&Step::Speckle) {
        walk.joint_fault(&[law], format!("has no effect on order `{}`", order.name()), "remove it");
    }
}

/// Leaves out of `settings` what has no effect.
pub(super) fn leave_out(settings: &mut BTreeMap<String, Value>) {
    let order = order(settings);
    for setting in TABLE.iter().filter(|setting| !used(setting.name, order)) {
        settings.remove(&format!("{SECTION}.{}", setting.name));
    }
}

/// What the scripts take for granted, for the parameters of a class or of the top level.
pub(super) fn scene(
    walk: &mut Walk,
    settings: &Settings,
    prefix: &str,
    base: &BTreeMap<String, Distribution>,
    overrides: &BTreeMap<String, Distribution>,
) {
    let order = order(&settings.0);
    if order == Order::Physical {
        return;
    }
    let scene = Together { prefix, base, overrides };
    let name = order.name();
    for key in SENSOR.iter().filter(|key| scene.most(key) > 0.0) {
        let problem = format!("`{key}` can be above 0 and has no effect on order `{name}`");
        scene.fault(walk, &[key, "postprocess.order"], problem, "set it to 0, or give `order: physical`");
    }
    for parameter in SpeckleParameters::PARAMETERS {
        let path = parameter.path();
        if (scene.least(&path), scene.most(&path)) != (parameter.default, parameter.default) {
            let problem = format!("has no effect on order `{name}`, which has a pattern of its own");
            scene.fault(walk, &[&path], problem, "remove it, or give `order: physical`");
        }
    }
    if !prefix.is_empty() {
        return;
    }
    if settings.word_or_none("exposure.hdr") != Some("none") {
        let problem = format!("has no effect on order `{name}`");
        walk.joint_fault(&["exposure.hdr".to_owned()], problem, "remove it, or give `order: physical`");
    }
    if let (Some(Value::Count(size)), Some(Value::Count(mask))) =
        (settings.0.get("postprocess.pattern_px"), settings.0.get("postprocess.mask_px"))
        && 2 * mask > *size
    {
        let keys = ["mask_px", "pattern_px"].map(|name| format!("{SECTION}.{name}"));
        walk.joint_fault(&keys, format!("a disc of {mask} in a square of {size}"), "it is at most half as wide");
    }
}
