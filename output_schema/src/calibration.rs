//! The camera of a sample as numbers: from a column and a row of the sensor to a place in the laser plane.
//!
//! With the pixel p, the image distance v0, the sensor's tilt b, the distance d and the camera's tilt a:
//!
//! ```text
//! s = (centre_row - row) p          v = v0 + s sin b
//! (xd, yd) = ((col - centre_col) p, s cos b) / v         straightened by k1 .. p2: (xn, yn)
//! z = yn d / (sin a + yn cos a)     x = xn (d - z cos a)
//! ```

use crate::column::Column;
use crate::column::ColumnKind::*;
use crate::column::Values::*;

/// Fields of `calibration`.
pub const CALIBRATION: [Column; 13] = [
    Column::of_scene("distance_mm", Float64, "mm", Positive).means("From the lens to the origin."),
    Column::of_scene("tilt_deg", Float64, "deg", Within(0.0, 90.0))
        .means("Between the optical axis and the laser plane."),
    Column::of_scene("image_distance_mm", Float64, "mm", Positive).means("From the lens to the sensor along the axis."),
    Column::of_scene("sensor_tilt_deg", Float64, "deg", Within(-90.0, 90.0))
        .means("Tilt of the sensor about its rows."),
    Column::of_scene("pixel_um", Float64, "um", Positive).means("Pitch of the pixels."),
    Column::of_scene("centre_col_px", Float64, "px", Any).means("Sensor column of the optical axis."),
    Column::of_scene("centre_row_px", Float64, "px", Any).means("Sensor row of the optical axis."),
    Column::of_scene("k1", Float64, "1", Any).means("Radial distortion, r^2 (Brown and Conrady)."),
    Column::of_scene("k2", Float64, "1", Any).means("Radial distortion, r^4."),
    Column::of_scene("k3", Float64, "1", Any).means("Radial distortion, r^6."),
    Column::of_scene("p1", Float64, "1", Any).means("Tangential distortion along the rows."),
    Column::of_scene("p2", Float64, "1", Any).means("Tangential distortion along the columns."),
    Column::of_scene("x_first_mm", Float64, "mm", Any)
        .missing("null where Range is not rectified")
        .means("Place along the laser line of the middle of image column 0."),
];
