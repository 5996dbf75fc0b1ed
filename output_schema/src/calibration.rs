//! The camera of a sample as numbers: from a column and a row of the sensor to a place in the laser plane.
//!
//! With the pixel p, the image distance v0, the sensor's tilt b, the distance d and the camera's tilt a:
//!
//! ```text
//! s = (centre_row - row) p          v = v0 + s sin b
//! (xd, yd) = ((col - centre_col) p, s cos b) / v         straightened by k1 .. p2: (xn, yn)
//! z = yn d / (sin a + yn cos a)     x = xn (d - z cos a)
//! ```

use crate::column::{Column, ColumnKind};

/// Fields of `calibration`.
pub const CALIBRATION: [Column; 13] = [
    Column {
        name: "distance_mm",
        kind: ColumnKind::Float64,
        unit: "mm",
        range: "above 0",
        missing: "never",
        doc: "From the lens to the origin.",
    },
    Column {
        name: "tilt_deg",
        kind: ColumnKind::Float64,
        unit: "deg",
        range: "0 to 90",
        missing: "never",
        doc: "Between the optical axis and the laser plane.",
    },
    Column {
        name: "image_distance_mm",
        kind: ColumnKind::Float64,
        unit: "mm",
        range: "above 0",
        missing: "never",
        doc: "From the lens to the sensor along the axis.",
    },
    Column {
        name: "sensor_tilt_deg",
        kind: ColumnKind::Float64,
        unit: "deg",
        range: "-90 to 90",
        missing: "never",
        doc: "Tilt of the sensor about its rows.",
    },
    Column {
        name: "pixel_um",
        kind: ColumnKind::Float64,
        unit: "um",
        range: "above 0",
        missing: "never",
        doc: "Pitch of the pixels.",
    },
    Column {
        name: "centre_col_px",
        kind: ColumnKind::Float64,
        unit: "px",
        range: "any",
        missing: "never",
        doc: "Sensor column of the optical axis.",
    },
    Column {
        name: "centre_row_px",
        kind: ColumnKind::Float64,
        unit: "px",
        range: "any",
        missing: "never",
        doc: "Sensor row of the optical axis.",
    },
    Column {
        name: "k1",
        kind: ColumnKind::Float64,
        unit: "1",
        range: "any",
        missing: "never",
        doc: "Radial distortion, r^2 (Brown and Conrady).",
    },
    Column {
        name: "k2",
        kind: ColumnKind::Float64,
        unit: "1",
        range: "any",
        missing: "never",
        doc: "Radial distortion, r^4.",
    },
    Column {
        name: "k3",
        kind: ColumnKind::Float64,
        unit: "1",
        range: "any",
        missing: "never",
        doc: "Radial distortion, r^6.",
    },
    Column {
        name: "p1",
        kind: ColumnKind::Float64,
        unit: "1",
        range: "any",
        missing: "never",
        doc: "Tangential distortion along the rows.",
    },
    Column {
        name: "p2",
        kind: ColumnKind::Float64,
        unit: "1",
        range: "any",
        missing: "never",
        doc: "Tangential distortion along the columns.",
    },
    Column {
        name: "x_first_mm",
        kind: ColumnKind::Float64,
        unit: "mm",
        range: "any",
        missing: "null where Range is not rectified",
        doc: "Place along the laser line of the middle of image column 0.",
    },
];
