//! The laser's settings, and which of its numbers, of the movement's and of a material's mean anything beside which others.
//!
//! A number that has no effect under the other keys of a recipe is a fault where a recipe gives it another value than its
//! default: nothing that is written is passed over in silence.

use std::collections::BTreeMap;

use procedural::Parameter;

use super::dist::Distribution;
use super::motion;
use super::picture;
use super::setting::{Kind, Setting, Value};
use super::settings::Settings;
use super::table;
use super::together::Together;
use super::{Class, Subject};
use crate::settings::{Fan, Shape, Transport};
use crate::yaml::walk::{Walk, shown};

/// The settings.
pub(super) const TABLE: &[Setting] = &[
    Setting {
        name: "fan",
        kind: Kind::Word(&Fan::NAMES),
        default: Value::Word(Fan::NAMES[0]),
        doc: "Lens that makes the line: `powell` lights a plane evenly, `cylindrical` leaves a hot spot in the middle.",
        source: "[V]",
    },
    Setting {
        name: "profile",
        kind: Kind::Word(&Shape::NAMES),
        default: Value::Word(Shape::NAMES[0]),
        doc: "Light across the line: a `gaussian` beam; a `slit`, even with hard edges, as wide as its shadow is; a `texture` \
              thrown by a projector; or a `point`, a round spot stepped along the line.",
        source: "[T] slit and texture; [V]",
    },
    Setting {
        name: "texture",
        kind: Kind::File { most_mb: 64, built_in: &[] },
        default: Value::Word("none"),
        doc: "Grey PNG that a projector throws, 8 or 16 bits, proportional to light; rows across the line, columns along it. \
              `none` is the line of the thesis: three pixels wide of 61, blurred by a Gaussian of five.",
        source: "[T] 3.2.1",
    },
];

/// Most rows of the scan between two lines: a band of profiles keeps all of them in memory.
const MOST_ROWS: f64 = 300.0;

/// Reflectance above which facets are taken for metal ([`procedural::Gloss::is_metal`]) [1].
const LEAST_METAL: f64 = 0.5;

/// Shapes that have a use for a number; all where none is told.
fn shapes(name: &str) -> &'static [Shape] {
    use Shape::{Gaussian, Point, Slit, Texture};
    match name {
        "waist_mm" | "waist_height_mm" | "m_squared" => &[Gaussian, Point],
        "fan_angle_deg" | "fan_ripple" | "width_jitter" | "width_jitter_mm" => &[Gaussian, Slit],
        "smile_um" | "smile_cubic_um" | "second_line_mm" | "second_line_share" => &[Gaussian, Slit, Texture],
        "fan_soft_ends" => &[Gaussian, Slit],
        "lobe_share" | "lobe_pairs" | "lobe_distance" | "skirt_share" | "skirt_width" => &[Gaussian],
        "line_width_mm" => &[Slit],
        "texture_length_mm" | "texture_width_mm" => &[Texture],
        "point_x_mm" | "point_step_mm" | "point_span_mm" => &[Point],
        _ => &Shape::ALL,
    }
}

/// The amount without which a number has no effect.
fn amount(name: &str) -> Option<&'static str> {
    Some(match name {
        "second_line_share" => "second_line_mm",
        "lobe_pairs" | "lobe_distance" => "lobe_share",
        "skirt_width" => "skirt_share",
        "width_jitter_mm" => "width_jitter",
        "streak_width_um" | "streak_length_mm" | "streak_share" => "streaks_per_mm",
        "glint_gain" | "glint_length_mm" => "glints_per_mm",
        "wow_period_mm" => "motion.wow_um",
        "fibre_azimuth_deg" | "fibre_dive_deg" => "material.k_per_mm",
        _ => return None,
    })
}

/// What models of light that know one Gaussian line alone do not know.
const UNKNOWN: [&str; 7] =
    ["second_line_mm", "smile_um", "smile_cubic_um", "lobe_share", "skirt_share", "width_jitter", "streaks_per_mm"];

/// Notes numbers of laser, movement and material that have no effect, at the top level and in each class.
pub(super) fn idle(
    walk: &mut Walk,
    subject: Option<Subject>,
    settings: &Settings,
    base: &BTreeMap<String, Distribution>,
    classes: &[Class],
) {
    let none = BTreeMap::new();
    let top = Together { prefix: "", base, overrides: &none };
    let prefixes: Vec<_> = classes.iter().map(|class| format!("classes.{}.", class.name)).collect();
    let scenes: Vec<_> = classes
        .iter()
        .zip(&prefixes)
        .map(|(class, prefix)| Together { prefix, base, overrides: &class.overrides })
        .collect();
    let judged = |parameter: &&Parameter| matches!(parameter.group, "laser" | "motion" | "material");
    for parameter in table::parameters(subject).filter(judged) {
        let path = parameter.path();
        let usual = Distribution::Fixed(parameter.default);
        let why = |scene: &Together| why(parameter.name, subject, settings, scene);
        if base.get(&path) != Some(&usual)
            && scenes.iter().all(|scene| why(scene).is_some())
            && let Some((problem, remedy)) = why(&top).or_else(|| scenes.iter().find_map(why))
        {
            walk.joint_fault(std::slice::from_ref(&path), problem, remedy);
        }
        for (class, scene) in classes.iter().zip(&scenes) {
            let own = class.overrides.get(&path).filter(|own| **own != usual);
            if let (Some(_), Some((problem, remedy))) = (own, why(scene)) {
                walk.joint_fault(&[format!("{}{path}", scene.prefix)], problem, remedy);
            }
        }
    }
}

/// Why a number has no effect, and what to do.
fn why(name: &str, subject: Option<Subject>, settings: &Settings, scene: &Together) -> Option<(String, String)> {
    if let Some(idle) = motion::why(name, settings) {
        return Some(idle);
    }
    let (chosen_fan, chosen) = settings.fan();
    let (fan, shape) = (Fan::NAMES[chosen_fan as usize], Shape::NAMES[chosen as usize]);
    let shapes = shapes(name);
    if !shapes.contains(&chosen) {
        let names: Vec<_> = shapes.iter().map(|shape| Shape::NAMES[*shape as usize]).collect();
        let remedy = format!("it is for `profile: {}`: give that, or remove it", names.join("` or `profile: "));
        return Some((format!("has no effect on `profile: {shape}`"), remedy));
    }
    if name == "fan_soft_ends" && chosen_fan != Fan::Powell {
        let remedy = "it is for `fan: powell`: give that, or remove it".to_owned();
        return Some((format!("has no effect on `fan: {fan}`"), remedy));
    }
    let solid = matches!(subject, Some(Subject::Sawtooth | Subject::Mesh));
    let dull = || scene.most("material.gloss") == 0.0 || scene.most("material.reflectance") <= LEAST_METAL;
    let strange = match (name, subject) {
        ("glints_per_mm", Some(Subject::Wood)) => Some(("boards have no metal", "remove it")),
        ("streaks_per_mm", Some(Subject::Blister)) => Some(("packs have no fibres", "remove it")),
        ("glints_per_mm", _) if solid && dull() => Some((
            "the material has no facets of metal",
            "give `material.gloss` above 0 and `material.reflectance` above 0.5, or remove it",
        )),
        ("streaks_per_mm", _) if solid && scene.most("material.k_per_mm") == 0.0 => {
            Some(("the material has no fibres", "give `material.k_per_mm` above 0, or remove it"))
        }
        _ => None,
    };
    if let Some((strange, remedy)) = strange {
        return Some((format!("has no effect: {strange}"), remedy.to_owned()));
    }
    let amount = amount(name)?;
    let path = if amount.contains('.') { amount.to_owned() } else { format!("laser.{amount}") };
    (scene.least(&path) == 0.0 && scene.most(&path) == 0.0)
        .then(|| (format!("has no effect while `{path}` is 0"), format!("give `{amount}` too, or remove it")))
}

/// What the laser's numbers and settings must mean together.
pub(super) fn together(walk: &mut Walk, settings: &Settings, scene: &Together) {
    let keys = ["laser.lobe_share", "laser.skirt_share"];
    let shares = scene.most(keys[0]) + scene.most(keys[1]);
    if shares > 0.9 {
        let problem = format!("lobes and skirt can take {} of the light", shown(shares));
        scene.fault(walk, &keys, problem, "leave at least 0.1 to the line");
    }
    let keys = ["laser.second_line_mm", "motion.step_mm"];
    let farthest = scene.most(keys[0]).abs().max(scene.least(keys[0]).abs());
    if farthest / scene.least(keys[1]) > MOST_ROWS {
        let problem = format!("the lines can be {} mm apart, over {MOST_ROWS} profiles", shown(farthest));
        scene.fault(walk, &keys, problem, "move them closer, or the profiles further apart");
    }
    if settings.transport() == Transport::Kernel {
        return;
    }
    let model = settings.transport().name();
    let remedy = "the model knows one Gaussian line alone: remove it, or give `transport: kernel`";
    for name in UNKNOWN {
        let path = format!("laser.{name}");
        if scene.least(&path) != 0.0 || scene.most(&path) != 0.0 {
            scene.fault(walk, &[&path], format!("is unknown to `transport: {model}`"), remedy);
        }
    }
}

/// What the laser's settings must mean beside those of other sections.
pub(super) fn settings(walk: &mut Walk, settings: &Settings) {
    let (fan, shape) = settings.fan();
    if settings.transport() != Transport::Kernel && shape != Shape::Gaussian {
        let problem =
            format!("`{}` is unknown to `transport: {}`", Shape::NAMES[shape as usize], settings.transport().name());
        let remedy = "the model knows one Gaussian line alone: give `profile: gaussian` or `transport: kernel`";
        walk.joint_fault(&["laser.profile".to_owned(), "transport.model".to_owned()], problem, remedy);
    }
    if let Some(file) = settings.file("laser.texture") {
        let keys = ["laser.texture".to_owned()];
        if shape != Shape::Texture {
            let problem = format!("has no effect on `profile: {}`", Shape::NAMES[shape as usize]);
            walk.joint_fault(&keys, problem, "give `profile: texture`, or remove it");
        } else if let Err(problem) = picture::read(file.bytes()) {
            let problem = format!("`{}` {problem}", file.name());
            walk.joint_fault(
                &keys,
                problem,
                format!("give a grey PNG of at most {} x {} pixels", picture::MOST, picture::MOST),
            );
        }
    }
    if (shape == Shape::Texture || shape == Shape::Point) && fan != Fan::Powell {
        let problem = format!("has no effect on `profile: {}`", Shape::NAMES[shape as usize]);
        walk.joint_fault(&["laser.fan".to_owned()], problem, "it is for lines with a lens: remove it");
    }
}
