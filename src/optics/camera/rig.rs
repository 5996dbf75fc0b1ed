//! Geometry of lens and sensor from the numbers of a bench.

use crate::frame::Rig;
use crate::lens::{Distortion, image_distance, scheimpflug};
use crate::parameters::Bench;
use crate::settings::{Scheimpflug, Size};

/// Geometry of rig and sensor for a bench.
pub fn rig(bench: &Bench, size: &Size) -> Rig {
    let camera = &bench.camera;
    let (f, tilt) = (camera.focal_length_mm, camera.tilt_deg.to_radians());
    let (sharp, sensor_tilt) = match bench.optics.scheimpflug {
        Scheimpflug::Solved => (camera.distance_mm, scheimpflug(f, camera.distance_mm, tilt)),
        Scheimpflug::Given => (camera.focus_distance_mm, camera.sensor_tilt_deg.to_radians()),
    };
    Rig {
        distance: camera.distance_mm,
        tilt,
        focal_length: f,
        image_distance: image_distance(f, sharp),
        sensor_tilt,
        distortion: Distortion {
            radial: [camera.distortion_k1, camera.distortion_k2, camera.distortion_k3],
            tangential: [camera.distortion_p1, camera.distortion_p2],
        },
        pixel: camera.pixel_um * 1e-3,
        centre_col: 0.5 * (size.columns as f64 - 1.0) - bench.optics.offset_columns,
        centre_row: 0.5 * (size.rows as f64 - 1.0) - bench.optics.offset_rows,
    }
}
