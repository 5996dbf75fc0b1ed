//! Constraints between the movement and everything that it moves.

use super::bounds::DrawBounds;
use crate::keys::settings::Settings;
use crate::subject::Subject;
use optical_bench::settings::{LineShape, Movement, TransportName};
use yaml::{YamlReader, number_text};

/// Largest share of a step that the periodic error of the place takes [1].
const MAX_STEP_ERROR: f64 = 0.5;
/// Most profiles by which an encoder's error may move what the second line lights.
const MAX_WANDER: f64 = 3.0;

/// What the settings of the movement must mean beside those of other sections.
pub(super) fn settings(yaml: &mut YamlReader, subject: Option<Subject>, settings: &Settings) {
    if settings.motion.kind == Movement::Linear {
        return;
    }
    if subject == Some(Subject::Blister) {
        let problem = "a pack hides and lights itself, which is worked out for a straight way alone";
        yaml.joint_fault(&["motion.kind", "subject"], problem, "give `kind: linear`, or another subject");
    }
    if settings.transport.model != TransportName::Kernel {
        let problem = format!("`transport: {}` knows a straight way alone", settings.transport.model.name());
        yaml.joint_fault(&["motion.kind", "transport.model"], problem, "give `kind: linear` or `transport: kernel`");
    }
}

/// What the movement's numbers must mean together.
pub(super) fn scene(yaml: &mut YamlReader, settings: &Settings, scene: &DrawBounds) {
    let keys = ["motion.wow_um", "motion.wow_period_mm"];
    let (wow, period) = (scene.most(keys[0]), scene.least(keys[1]));
    let steep = std::f64::consts::TAU * wow * 1e-3 / period;
    if steep > MAX_STEP_ERROR {
        let problem = format!(
            "an error of {} um that comes again after {} mm makes steps {:.0} % too short",
            number_text(wow),
            number_text(period),
            100.0 * steep
        );
        let remedy = "at most 50 %, so that profiles stay in order: lower wow_um or raise wow_period_mm";
        scene.fault(yaml, &keys, problem, remedy);
    }
    let second = "laser.second_line_mm";
    let drawn = |key: &str| scene.least(key) != 0.0 || scene.most(key) != 0.0;
    if settings.motion.kind == Movement::Turntable {
        for (key, problem) in [
            (second, "a second line would light places that the turntable brings elsewhere"),
            ("laser.streaks_per_mm", "fibres that shine would not turn with the object"),
            ("laser.glints_per_mm", "facets that shine would not turn with the object"),
        ] {
            if drawn(key) {
                scene.fault(yaml, &[key], problem.to_owned(), "remove it, or give `motion.kind: linear`");
            }
        }
    }
    if settings.laser.profile == LineShape::Point && scene.most("motion.line_rate_hz") > 0.0 {
        let problem = "a stepped point stands still while it is exposed, and so does what it lights".to_owned();
        let remedy = "give 0, or a laser.profile other than `point`";
        scene.fault(yaml, &["motion.line_rate_hz"], problem, remedy);
    }
    let wander = 2e-3 * wow / scene.least("motion.step_mm");
    if drawn(second) && wander > MAX_WANDER {
        let problem = format!("the wheel's error moves what the second line lights by {wander:.0} profiles");
        let remedy = "at most 3: lower wow_um, or raise step_mm";
        scene.fault(yaml, &[keys[0], second, "motion.step_mm"], problem, remedy);
    }
}
