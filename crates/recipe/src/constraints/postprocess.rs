//! Constraints between the order of the thesis' scripts and the sensor that they know nothing of.

use super::bounds::DrawBounds;
use super::needs;
use crate::keys::settings::Settings;
use optical_bench::parameters::SpeckleParameters;
use optical_bench::settings::{Order, Script};
use yaml::YamlReader;

/// What the scripts take for granted of other settings.
pub(super) fn settings(yaml: &mut YamlReader, settings: &Settings) {
    let speckle = settings.postprocess.order.steps().contains(&Script::Speckle);
    let (size, mask) = (settings.postprocess.pattern_px, settings.postprocess.mask_px);
    if speckle && 2 * mask > size {
        let keys = ["postprocess.mask_px", "postprocess.pattern_px"];
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
    for key in needs::not_zero(settings, scene, "postprocess.order") {
        let problem = format!("`{key}` can be above 0 and has no effect on order `{name}`");
        scene.fault(yaml, &[&key, "postprocess.order"], problem, "set it to 0, or give `order: physical`");
    }
    for parameter in SpeckleParameters::PARAMETERS {
        let path = parameter.path();
        if (scene.least(&path), scene.most(&path)) != (parameter.default, parameter.default) {
            let problem = format!("has no effect on order `{name}`, which has a pattern of its own");
            scene.fault(yaml, &[&path], problem, "remove it, or give `order: physical`");
        }
    }
}
