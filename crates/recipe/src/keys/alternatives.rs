//! Alternatives: keys in the words of data sheets, each of which stands for others and is turned into them where it is
//! read.
//!
//! | key | stands for | by |
//! |---|---|---|
//! | `laser.waist_fwhm_mm` | `waist_mm` | FWHM = w sqrt(2 ln 2) of a Gaussian beam |
//! | `motion.speed_mm_per_s` | `step_mm` | speed / `line_rate_hz`, a number |
//! | `camera.working_distance_mm`, `camera.baseline_mm` | `distance_mm`, `tilt_deg` | legs of the triangle of lens, laser plane and origin, numbers |
//!
//! Of a key and what stands for it, one is given. The canonical form has the keys that were stood for.

use std::collections::BTreeMap;

use base::Parameter;
use serde_json::{Value as Json, json};

use super::super::distribution::{self, Distribution};
use optical_bench::parameters::{CameraParameters, LaserParameters, MotionParameters};
use yaml::{Mapping, NumberRange, YamlNode, YamlReader, number_text};

/// Full width at half maximum over the half width at 1/e^2 of a Gaussian beam, sqrt(2 ln 2) [1].
const FWHM: f64 = 1.177_410_022_515_474_7;

/// A key that stands for others of its section.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Alternative {
    /// The section.
    pub section: &'static str,
    /// Its name.
    pub name: &'static str,
    /// What it means.
    pub doc: &'static str,
    /// The keys that it stands for.
    pub of: &'static [&'static str],
    /// Whether it can be a distribution.
    pub is_drawn: bool,
}

/// Every alternative.
pub(crate) const ALTERNATIVES: [Alternative; 4] = [
    Alternative {
        section: MotionParameters::GROUP,
        name: "speed_mm_per_s",
        doc: "Speed of the object; needs `line_rate_hz` as a number.",
        of: &["step_mm"],
        is_drawn: true,
    },
    Alternative {
        section: LaserParameters::GROUP,
        name: "waist_fwhm_mm",
        doc: "Full width of the waist at half of its light, across the line.",
        of: &["waist_mm"],
        is_drawn: true,
    },
    Alternative {
        section: CameraParameters::GROUP,
        name: "working_distance_mm",
        doc: "Height of the lens over the origin; beside `baseline_mm`.",
        of: &["distance_mm", "tilt_deg"],
        is_drawn: false,
    },
    Alternative {
        section: CameraParameters::GROUP,
        name: "baseline_mm",
        doc: "From the laser plane to the lens; beside `working_distance_mm`.",
        of: &["distance_mm", "tilt_deg"],
        is_drawn: false,
    },
];

impl Alternative {
    /// What it may be, as JSON Schema.
    pub fn schema(&self) -> Json {
        let number = json!({ "type": "number", "exclusiveMinimum": 0 });
        let of: Vec<_> = self.of.iter().map(|key| format!("`{key}`")).collect();
        let mut schema =
            if self.is_drawn { json!({ "oneOf": [number, { "$ref": "#/$defs/distribution" }] }) } else { number };
        schema["description"] = format!("{} Stands for {}.", self.doc, of.join(" and ")).into();
        schema
    }
}

/// The alternatives of a section.
pub(crate) fn alternatives(section: &str) -> impl Iterator<Item = &'static Alternative> {
    ALTERNATIVES.iter().filter(move |alternative| alternative.section == section)
}

/// Takes the alternatives of `section` from `map` and puts what they stand for into `parameters`.
pub(crate) fn take(
    yaml: &mut YamlReader,
    map: &mut Mapping,
    section: &str,
    parameters: &mut BTreeMap<String, Distribution>,
) {
    let mut given: Vec<(&Alternative, &YamlNode)> = Vec::new();
    for alternative in alternatives(section) {
        let Some(node) = map.take(yaml, alternative.name) else { continue };
        let path = map.path_of(alternative.name);
        let clash = alternative.of.iter().find(|key| yaml.has(&map.path_of(key)));
        if let Some(key) = clash {
            let problem = format!("stands for `{key}`, which is given too");
            yaml.joint_fault(&[path], problem, "remove one of them");
            continue;
        }
        given.push((alternative, node));
    }
    // Checks of keys together find them where their alternatives stand.
    for (alternative, _) in &given {
        alternative.of.iter().for_each(|key| yaml.stands_for(&map.path_of(alternative.name), &map.path_of(key)));
    }
    let find = |name: &str| given.iter().find(|(alternative, _)| alternative.name == name).map(|(_, node)| *node);
    let rate = match parameters.get("motion.line_rate_hz") {
        Some(&Distribution::Fixed(rate)) if rate > 0.0 => Some(rate),
        _ => None,
    };
    for (name, of, factor) in
        [("waist_fwhm_mm", "laser.waist_mm", Some(FWHM)), ("speed_mm_per_s", "motion.step_mm", rate)]
    {
        let (Some(node), Some(own)) = (find(name), super::parameter(None, of)) else { continue };
        let path = map.path_of(name);
        let Some(factor) = factor else {
            let remedy = "give `line_rate_hz` beside it, a number above 0, or `step_mm` in its place";
            yaml.fault(node.place, &path, "is a distance between profiles only beside their rate", remedy);
            continue;
        };
        let shown = Parameter { min: own.min * factor, max: own.max * factor, ..*own };
        let read = distribution::distribution(yaml, node, &path, &shown);
        parameters.extend(read.map(|read| (of.to_owned(), read.scaled(1.0 / factor))));
    }
    triangle(yaml, map, (find("working_distance_mm"), find("baseline_mm")), parameters);
}

/// Distance and tilt from the legs of the triangle.
fn triangle(
    yaml: &mut YamlReader,
    map: &Mapping,
    (height, baseline): (Option<&YamlNode>, Option<&YamlNode>),
    parameters: &mut BTreeMap<String, Distribution>,
) {
    let names = ["working_distance_mm", "baseline_mm"];
    let mut number = |name: &str, node: &YamlNode| {
        let range = NumberRange { min: 1.0, max: 5000.0, whole: false, unit: "mm" };
        yaml.number_in(node, &map.path_of(name), range)
    };
    let (node, legs) = match (height, baseline) {
        (None, None) => return,
        (Some(height), Some(baseline)) => (height, [number(names[0], height), number(names[1], baseline)]),
        (Some(alone), None) | (None, Some(alone)) => {
            let (name, other) = if height.is_some() { (names[0], names[1]) } else { (names[1], names[0]) };
            let remedy = format!("give `{other}` beside it, or `distance_mm` and `tilt_deg` in place of both");
            yaml.fault(alone.place, &map.path_of(name), "is one leg of a triangle", remedy);
            return;
        }
    };
    let [Some(height), Some(baseline)] = legs else { return };
    let (distance, tilt) = (height.hypot(baseline), libm::atan2(baseline, height).to_degrees());
    for (name, value) in [("distance_mm", distance), ("tilt_deg", tilt)] {
        let own = CameraParameters::PARAMETERS.iter().find(|parameter| parameter.name == name);
        let Some(own) = own else { continue };
        if !(own.min..=own.max).contains(&value) {
            let problem = format!("makes `{name}` {value:.2} with `{}`", names[1]);
            let remedy = format!("choose both so that it is {} to {}", number_text(own.min), number_text(own.max));
            yaml.fault(node.place, &map.path_of(names[0]), problem, remedy);
            continue;
        }
        parameters.insert(own.path(), Distribution::Fixed(value));
    }
}
