//! Constraints between camera, exposure and movement.

use super::bounds::DrawBounds;
use crate::keys::settings::Settings;
use optical_bench::lens::{Distortion, image_distance, scheimpflug};
use optical_bench::settings::Scheimpflug;
use yaml::{YamlReader, number_text};

/// Time that a sensor needs between two exposures: the real camera's 3 us [us].
const READOUT_US: f64 = 3.0;
/// Least rise of the last row's look over the end of the laser plane, of the middle row's [1].
const MIN_RISE: f64 = 0.05;
/// Most strain of a distortion over the sensor's field: neighbouring directions stay apart.
const MAX_STRAIN: f64 = 0.8;

/// The numbers of a class together.
pub(super) fn scene(yaml: &mut YamlReader, settings: &Settings, scene: &DrawBounds) {
    let keys = ["camera.focal_length_mm", "camera.distance_mm"];
    let (focal, distance) = (scene.most(keys[0]), scene.least(keys[1]));
    if focal >= distance / 2.0 {
        let problem =
            format!("the focal length can be {} mm at a distance of {} mm", number_text(focal), number_text(distance));
        let remedy = "it must stay below half the distance for an image smaller than the object";
        scene.fault(yaml, &keys, problem, remedy);
    }
    let optics = settings.optics();
    let keys = ["camera.focus_distance_mm", "camera.focal_length_mm"];
    let sharp = scene.least(keys[0]);
    if optics.scheimpflug == Scheimpflug::Given && focal >= sharp / 2.0 {
        let problem = format!(
            "the lens can be sharp at {} mm with a focal length of {} mm",
            number_text(sharp),
            number_text(focal)
        );
        scene.fault(yaml, &keys, problem, "it must stay above twice the focal length");
    }

    let keys = ["k1", "k2", "k3", "p1", "p2"].map(|name| format!("camera.distortion_{name}"));
    let keys = [0, 1, 2, 3, 4].map(|i| keys[i].as_str());
    let [k1, k2, k3, p1, p2] = keys.map(|key| scene.ends(key)[1]);
    let distortion = Distortion { radial: [k1, k2, k3], tangential: [p1, p2] };
    let size = settings.size();
    let half = |pixels: usize, offset: f64| 0.5 * pixels as f64 + offset.abs();
    let (across, along) = (half(size.columns, optics.offset_columns), half(size.rows, optics.offset_rows));
    let corner = (across * across + along * along).sqrt() * scene.most("camera.pixel_um") * 1e-3;
    let corner = corner / scene.least("camera.focal_length_mm");
    // The straight direction of a corner is longer by about as much as it is bent.
    let strain = distortion.strain(1.1 * corner);
    if strain > MAX_STRAIN {
        let problem = format!(
            "the distortion can bend the sensor's corner, {corner:.2} focal lengths from the axis, so far that \
                directions meet"
        );
        let own = keys.into_iter().chain(["camera.focal_length_mm", "camera.pixel_um"]);
        scene.fault(yaml, &own.collect::<Vec<_>>(), problem, "make it smaller, or the field of view");
    }

    below_the_horizon(yaml, settings, scene);
    let keys = ["exposure.time_us", "motion.line_rate_hz"];
    let (time, rate) = (scene.most(keys[0]), scene.most(keys[1]));
    if rate > 0.0 && time > 1e6 / rate - READOUT_US {
        let problem = format!(
            "the exposure can take {} us, and a profile comes each {:.1} us and needs {READOUT_US} us to be read",
            number_text(time),
            1e6 / rate
        );
        scene.fault(yaml, &keys, problem, "expose shorter, or lower motion.line_rate_hz");
    }
}

/// The last row of the sensor must meet the laser plane below the lens: with the direction y / z = (cos b) s / (v + s
/// sin b) of a place s on the sensor, sin a + cos a y / z > 0.
fn below_the_horizon(yaml: &mut YamlReader, settings: &Settings, scene: &DrawBounds) {
    let (optics, size) = (settings.optics(), settings.size());
    let rows = 0.5 * size.rows as f64 + optics.offset_rows;
    let place = -rows * scene.most("camera.pixel_um") * 1e-3;
    let (focal, distance) = (scene.least("camera.focal_length_mm"), scene.most("camera.distance_mm"));
    let meets = |tilt: f64, turn: f64, sharp: f64| {
        let (sin, cos) = libm::sincos(turn);
        let depth = image_distance(focal, sharp) + place * sin;
        depth > 0.0 && libm::sin(tilt) * (1.0 - MIN_RISE) + libm::cos(tilt) * place * cos / depth > 0.0
    };
    let met = [scene.least("camera.tilt_deg"), scene.most("camera.tilt_deg")].into_iter().all(|tilt| {
        let tilt = tilt.to_radians();
        match optics.scheimpflug {
            Scheimpflug::Solved => meets(tilt, scheimpflug(focal, distance, tilt), distance),
            Scheimpflug::Given => [scene.least("camera.sensor_tilt_deg"), scene.most("camera.sensor_tilt_deg")]
                .into_iter()
                .all(|turn| meets(tilt, turn.to_radians(), scene.most("camera.focus_distance_mm"))),
        }
    });
    if !met {
        let keys =
            ["camera.tilt_deg", "camera.pixel_um", "camera.focal_length_mm", "camera.rows", "camera.offset_rows"];
        let problem = "the last row of the sensor looks past the end of the laser plane".to_owned();
        let remedy = "tilt the camera more, or take fewer camera.rows, a smaller camera.offset_rows or a longer lens";
        scene.fault(yaml, &keys, problem, remedy);
    }
}
