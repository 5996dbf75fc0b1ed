//! Constraints between the laser and the models of light.

use super::bounds::DrawBounds;
use super::needs;
use crate::keys::settings::Settings;
use optical_bench::settings::{LineShape, TransportName};
use yaml::{YamlReader, number_text};

/// Most rows of the scan between two lines: a band of profiles keeps all of them in memory.
const MAX_LINE_DISTANCE_ROWS: f64 = 300.0;

/// What the laser's numbers and settings must mean together.
pub(super) fn scene(yaml: &mut YamlReader, settings: &Settings, scene: &DrawBounds) {
    let keys = ["laser.lobe_share", "laser.skirt_share"];
    let shares = scene.most(keys[0]) + scene.most(keys[1]);
    if shares > 0.9 {
        let problem = format!("lobes and skirt can take {} of the light", number_text(shares));
        scene.fault(yaml, &keys, problem, "leave at least 0.1 to the line");
    }
    let keys = ["laser.second_line_mm", "motion.step_mm"];
    let farthest = scene.most(keys[0]).abs().max(scene.least(keys[0]).abs());
    if farthest / scene.least(keys[1]) > MAX_LINE_DISTANCE_ROWS {
        let problem =
            format!("the lines can be {} mm apart, over {MAX_LINE_DISTANCE_ROWS} profiles", number_text(farthest));
        scene.fault(yaml, &keys, problem, "move them closer, or the profiles further apart");
    }
    let model = settings.transport.model.name();
    let remedy = "the model knows one Gaussian line alone: remove it, or give `transport: kernel`";
    for path in needs::not_zero(settings, scene, "transport.model") {
        scene.fault(yaml, &[&path], format!("is unknown to `transport: {model}`"), remedy);
    }
}

/// What the laser's settings must mean beside those of other sections.
pub(super) fn settings(yaml: &mut YamlReader, settings: &Settings) {
    let shape = settings.laser.profile;
    if settings.transport.model != TransportName::Kernel && shape != LineShape::Gaussian {
        let problem = format!("`{}` is unknown to `transport: {}`", shape.name(), settings.transport.model.name());
        let remedy = "the model knows one Gaussian line alone: give `profile: gaussian` or `transport: kernel`";
        yaml.joint_fault(&["laser.profile", "transport.model"], problem, remedy);
    }
}
