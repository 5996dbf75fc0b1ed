//! Constraints between the order of the thesis' scripts and the sensor that they know nothing of.

use super::bounds::DrawBounds;
use crate::keys::settings::Settings;
use bench::parameters::SpeckleParameters;
use bench::settings::{Hdr, Order, Script};
use yaml::YamlReader;

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

/// What the scripts take for granted of other settings.
pub(super) fn settings(yaml: &mut YamlReader, settings: &Settings) {
    let order = settings.postprocess.order;
    let speckle = order.steps().contains(&Script::Speckle);
    if order == Order::Physical {
        return;
    }
    let idle = format!("has no effect on order `{}`", order.name());
    let law = "speckle.law";
    if yaml.has(law) && !speckle {
        yaml.joint_fault(&[law.to_owned()], &*idle, "remove it");
    }
    if settings.exposure.hdr != Hdr::None {
        yaml.joint_fault(&["exposure.hdr".to_owned()], &*idle, "remove it, or give `order: physical`");
    }
    let (size, mask) = (settings.postprocess.pattern_px, settings.postprocess.mask_px);
    if speckle && 2 * mask > size {
        let keys = ["mask_px", "pattern_px"].map(|name| format!("postprocess.{name}"));
        yaml.joint_fault(&keys, format!("a disc of {mask} in a square of {size}"), "it is at most half as wide");
    }
}

/// What the scripts take for granted of the parameters of a class or of the top level.
pub(super) fn scene(yaml: &mut YamlReader, settings: &Settings, scene: &DrawBounds) {
    let order = settings.postprocess.order;
    if order == Order::Physical {
        return;
    }
    let name = order.name();
    for key in SENSOR.iter().filter(|key| scene.most(key) > 0.0) {
        let problem = format!("`{key}` can be above 0 and has no effect on order `{name}`");
        scene.fault(yaml, &[key, "postprocess.order"], problem, "set it to 0, or give `order: physical`");
    }
    for parameter in SpeckleParameters::PARAMETERS {
        let path = parameter.path();
        if (scene.least(&path), scene.most(&path)) != (parameter.default, parameter.default) {
            let problem = format!("has no effect on order `{name}`, which has a pattern of its own");
            scene.fault(yaml, &[&path], problem, "remove it, or give `order: physical`");
        }
    }
}
