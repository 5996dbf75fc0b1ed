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
use crate::column::Source::*;
use crate::column::Values::*;

/// Fields of `calibration`.
pub const CALIBRATION: [Column; 13] = [
    Column::new("distance_mm", Float64, "mm", Positive).follows(Scene).means("From the lens to the origin."),
    Column::new("tilt_deg", Float64, "deg", Within(0.0, 90.0))
        .follows(Scene)
        .means("Between the optical axis and the laser plane."),
    Column::new("image_distance_mm", Float64, "mm", Positive)
        .follows(Scene)
        .means("From the lens to the sensor along the axis."),
    Column::new("sensor_tilt_deg", Float64, "deg", Within(-90.0, 90.0))
        .follows(Scene)
        .means("Tilt of the sensor about its rows."),
    Column::new("pixel_um", Float64, "um", Positive).follows(Scene).means("Pitch of the pixels."),
    Column::new("centre_col_px", Float64, "px", Any).follows(Scene).means("Sensor column of the optical axis."),
    Column::new("centre_row_px", Float64, "px", Any).follows(Scene).means("Sensor row of the optical axis."),
    Column::new("k1", Float64, "1", Any).follows(Scene).means("Radial distortion, r^2 (Brown and Conrady)."),
    Column::new("k2", Float64, "1", Any).follows(Scene).means("Radial distortion, r^4."),
    Column::new("k3", Float64, "1", Any).follows(Scene).means("Radial distortion, r^6."),
    Column::new("p1", Float64, "1", Any).follows(Scene).means("Tangential distortion along the rows."),
    Column::new("p2", Float64, "1", Any).follows(Scene).means("Tangential distortion along the columns."),
    Column::new("x_first_mm", Float64, "mm", Any)
        .missing("null where Range is not rectified")
        .follows(Scene)
        .means("Place along the laser line of the middle of image column 0."),
];
