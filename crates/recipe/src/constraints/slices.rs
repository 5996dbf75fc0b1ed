//! Constraints between a board and the stack of slices that it is cut from.

use super::bounds::DrawBounds;
use super::picture::refuse_elsewhere;
use crate::distribution::Distribution;
use crate::keys::settings::{Settings, SlicesSettings};
use crate::subject::Subject;
use bench::settings::LogSource;
use wood_picture::WoodVolume;
use yaml::{YamlReader, number_text};

/// The parameter that says which side of the stack lies up.
const TURNS: &str = "slices.quarter_turns";

/// A board from slices has some, their grey is a density and latewood the denser wood; what is said of slices has an effect on
/// such boards alone.
pub(super) fn settings(yaml: &mut YamlReader, subject: Option<Subject>, settings: &Settings) {
    if subject != Some(Subject::Wood) {
        return;
    }
    if settings.log.source != LogSource::Slices {
        refuse_elsewhere(yaml, settings, SlicesSettings::SETTINGS, LogSource::Slices);
        return;
    }
    let own = &settings.slices;
    // Slices that are named and cannot be read are a fault of their own.
    if own.stack.asset().is_none() && !yaml.has_fault_of("slices.stack") {
        let remedy = "give `slices: {stack: ..., pixel_mm: ..., white_kg_per_m3: ...}`";
        yaml.joint_fault(&["log.source".to_owned()], "is `slices`, and no stack of slices is named", remedy);
    }
    // Nor does one default beside a setting at fault say what was meant.
    if yaml.has_fault_of("slices") {
        return;
    }
    if own.black_kg_per_m3 == own.white_kg_per_m3 {
        let keys = ["slices.white_kg_per_m3", "slices.black_kg_per_m3"].map(str::to_owned);
        let problem = format!("black and white are both {} kg/m3", number_text(own.white_kg_per_m3));
        yaml.joint_fault(&keys, problem, "give the densities at grey 0 and at the end of the scale");
    }
    if own.earlywood_kg_per_m3 >= own.latewood_kg_per_m3 {
        let keys = ["slices.latewood_kg_per_m3", "slices.earlywood_kg_per_m3"].map(str::to_owned);
        let [early, late] = [own.earlywood_kg_per_m3, own.latewood_kg_per_m3].map(number_text);
        yaml.joint_fault(&keys, format!("latewood has {late} kg/m3, and earlywood {early}"), "latewood is the denser");
    }
}

/// Boards are no larger than what the slices show, whichever of its sides lies up.
pub(super) fn scene(yaml: &mut YamlReader, slices: Option<&WoodVolume>, scene: &DrawBounds) {
    let Some(slices) = slices else { return };
    let [length, width, depth] = slices.extent_mm().map(f64::from);
    let few = scene.distribution(TURNS).and_then(Distribution::values);
    let drawn = |turn: &f64| match &few {
        Some(values) => values.iter().any(|value| value.round() == *turn),
        None => (scene.least(TURNS)..=scene.most(TURNS)).contains(turn),
    };
    let turns = |sides: [f64; 2]| sides.iter().any(drawn);
    // Of two ways to lie the narrower one counts.
    let across = |straight: f64, turned: f64| {
        let ways = [(turns([0.0, 2.0]), straight), (turns([1.0, 3.0]), turned)];
        ways.into_iter().filter(|(lies, _)| *lies).map(|(_, mm)| mm).fold(f64::INFINITY, f64::min)
    };
    for (key, way, shown) in [
        ("board.length_mm", "long", length),
        ("board.width_mm", "wide", across(width, depth)),
        ("board.thickness_mm", "thick", across(depth, width)),
    ] {
        if scene.most(key) > shown + 1.0e-3 {
            let [most, shown] = [scene.most(key), shown].map(|mm| number_text((mm * 100.0 + 0.1).floor() / 100.0));
            let problem = format!("the board can be {most} mm {way}, and its slices cover {shown} mm there");
            let remedy = format!("give at most {shown} mm, more slices, or the right size of a voxel");
            scene.fault(yaml, &[key, TURNS], problem, &remedy);
        }
    }
}
