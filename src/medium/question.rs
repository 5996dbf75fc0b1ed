//! From a node to a question.

use std::f64::consts::FRAC_PI_2;

use glam::DVec3;

use super::read::{number, range};
use crate::transport::answer::Question;
use crate::yaml::{NumberRange, YamlNode, YamlReader, YamlValue};

const KEYS: [&str; 11] = [
    "incidence_deg",
    "diffuse",
    "incidence_azimuth_deg",
    "view_tilt_deg",
    "view_azimuth_deg",
    "line_sd_mm",
    "row_mm",
    "rows",
    "cell_mm",
    "cells",
    "angles",
];
const INCIDENCE: NumberRange = range(0.0, 89.0, "deg");
const AZIMUTH: NumberRange = range(-360.0, 360.0, "deg");
/// Azimuth of the reference camera, on the side of small y [deg].
const VIEW_AZIMUTH: f64 = 180.0;
/// Tilt of the reference camera [deg].
const VIEW_TILT: f64 = 25.0;

const fn count(max: f64) -> NumberRange {
    NumberRange { min: 0.0, max, whole: true, unit: "" }
}

/// Reads the question at `node`.
pub(super) fn read(yaml: &mut YamlReader, node: &YamlNode) -> Option<Question> {
    let usual = Question::default();
    let mut map = yaml.mapping(node, "question");
    let diffuse = map.take(yaml, "diffuse").map(|node| (node, flag(yaml, node, "question.diffuse")));
    let incidence = number(yaml, &mut map, "incidence_deg", INCIDENCE, Some(-1.0));
    let incidence = match (diffuse, incidence) {
        (Some((node, Some(true))), Some(0.0..)) => {
            let remedy = "light is diffuse or has a direction: remove one of them";
            yaml.fault(node.place, "question.diffuse", "stands beside `incidence_deg`", remedy);
            None
        }
        (Some((_, None)), _) => None,
        (Some((_, Some(true))), _) => Some(None),
        (_, angle) => angle.map(|angle| Some(angle.max(0.0).to_radians())),
    };
    let incidence_azimuth = number(yaml, &mut map, "incidence_azimuth_deg", AZIMUTH, Some(0.0));
    let tilt = number(yaml, &mut map, "view_tilt_deg", INCIDENCE, Some(VIEW_TILT));
    let azimuth = number(yaml, &mut map, "view_azimuth_deg", AZIMUTH, Some(VIEW_AZIMUTH));
    let line_mm = number(yaml, &mut map, "line_sd_mm", range(0.0, 10.0, "mm"), Some(usual.line_mm));
    let pitch = range(1e-3, 100.0, "mm");
    let row_mm = number(yaml, &mut map, "row_mm", pitch, Some(usual.row_mm));
    let rows = number(yaml, &mut map, "rows", count(2000.0), Some(usual.rows as f64));
    let cell_mm = number(yaml, &mut map, "cell_mm", pitch, Some(usual.cell_mm));
    let cells = number(yaml, &mut map, "cells", count(200.0), Some(usual.cells as f64));
    let angles = number(yaml, &mut map, "angles", count(180.0), Some(usual.angles as f64));
    map.close(yaml, &KEYS, &|_| None);
    Some(Question {
        incidence: incidence?,
        incidence_azimuth: inward(incidence_azimuth?),
        view: view(tilt?, azimuth?),
        line_mm: line_mm?,
        row_mm: row_mm?,
        rows: rows? as usize,
        cell_mm: cell_mm?,
        cells: cells? as usize,
        angles: angles? as usize,
    })
}

/// An azimuth of a file, from +y towards +x [deg], as the models count it, from +x towards +y [rad].
pub(super) fn inward(azimuth: f64) -> f64 {
    FRAC_PI_2 - azimuth.to_radians()
}

fn view(tilt: f64, azimuth: f64) -> DVec3 {
    let (sin, cos) = libm::sincos(tilt.to_radians());
    if azimuth == VIEW_AZIMUTH {
        return DVec3::new(0.0, -sin, cos);
    }
    let (across, along) = libm::sincos(azimuth.to_radians());
    DVec3::new(sin * across, sin * along, cos)
}

fn flag(yaml: &mut YamlReader, node: &YamlNode, path: &str) -> Option<bool> {
    if let YamlValue::Flag(flag) = node.value {
        return Some(flag);
    }
    yaml.fault(node.place, path, format!("is {}", node.value.kind()), "give true or false");
    None
}
