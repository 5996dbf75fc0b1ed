//! The camera of a sample as numbers: from a column and a row of the sensor to a place in the laser plane.
//!
//! With the pixel p, the image distance v0, the sensor's tilt b, the distance d and the camera's tilt a:
//!
//! ```text
//! s = (centre_row - row) p          v = v0 + s sin b
//! (xd, yd) = ((col - centre_col) p, s cos b) / v         straightened by k1 .. p2: (xn, yn)
//! z = yn d / (sin a + yn cos a)     x = xn (d - z cos a)
//! ```

use crate::column::{Column, Kind};
use crate::row::column;

/// Fields of `calibration`.
pub const CALIBRATION: [Column; 13] = [
    column("distance_mm", Kind::Float64, "mm", "above 0", "never", "From the lens to the origin."),
    column("tilt_deg", Kind::Float64, "deg", "0 to 90", "never", "Between the optical axis and the laser plane."),
    column("image_distance_mm", Kind::Float64, "mm", "above 0", "never", "From the lens to the sensor along the axis."),
    column("sensor_tilt_deg", Kind::Float64, "deg", "-90 to 90", "never", "Tilt of the sensor about its rows."),
    column("pixel_um", Kind::Float64, "um", "above 0", "never", "Pitch of the pixels."),
    column("centre_col_px", Kind::Float64, "px", "any", "never", "Sensor column of the optical axis."),
    column("centre_row_px", Kind::Float64, "px", "any", "never", "Sensor row of the optical axis."),
    column("k1", Kind::Float64, "1", "any", "never", "Radial distortion, r^2 (Brown and Conrady)."),
    column("k2", Kind::Float64, "1", "any", "never", "Radial distortion, r^4."),
    column("k3", Kind::Float64, "1", "any", "never", "Radial distortion, r^6."),
    column("p1", Kind::Float64, "1", "any", "never", "Tangential distortion along the rows."),
    column("p2", Kind::Float64, "1", "any", "never", "Tangential distortion along the columns."),
    column(
        "x_first_mm",
        Kind::Float64,
        "mm",
        "any",
        "null where Range is not rectified",
        "Place along the laser line of the middle of image column 0.",
    ),
];
