//! Columns of a sensor with a line in them, and what is read from them.

use optical_bench::lens::{Distortion, image_distance, scheimpflug};
use optical_bench::settings::{Extraction, PeakMethod, RangeForm};
use recipe::Recipe;
use scanner::extract::{MeasuredProfile, extract};
use scanner::frame::{Calibration, Frame, Rig};

/// Rows of the sensor.
pub const SENSOR: usize = 240;

/// The default bench over some columns.
pub fn rig(columns: usize) -> Rig {
    Rig {
        distance: 410.0,
        tilt: 25f64.to_radians(),
        focal_length: 25.0,
        image_distance: image_distance(25.0, 410.0),
        sensor_tilt: scheimpflug(25.0, 410.0, 25f64.to_radians()),
        distortion: Distortion { radial: [0.0; 3], tangential: [0.0; 2] },
        pixel: 6e-3,
        centre_col: 0.5 * (columns as f64 - 1.0),
        centre_row: 0.5 * (SENSOR as f64 - 1.0),
    }
}

/// The default extraction, giving unrounded sensor rows.
pub fn settings() -> Extraction {
    let settings = Recipe::load("wood-small.yaml").expect("the embedded recipe loads").extraction();
    Extraction { subpixel_steps: 0, threshold_dn: 17.0, range: RangeForm::Uncalibrated, ..settings }
}

/// The same by a method over `window_rows` on each side.
pub fn by(method: PeakMethod, window_rows: usize) -> Extraction {
    Extraction { method, window_rows, scatter_width_rows: 1, ..settings() }
}

/// A frame of all sensor rows from its columns.
pub fn frame(columns: &[Vec<u16>]) -> Frame {
    let (cols, rows) = (columns.len(), columns[0].len());
    let dn = (0..rows * cols).map(|i| columns[i % cols][i / cols]).collect();
    Frame { cols, rows, first_col: 0, first_row: vec![0; cols], dn }
}

/// Range, Reflectance and Scatter of every column of two windows over the default bench.
pub fn read_both(frames: &[Frame; 2], dark: f32, settings: &Extraction) -> [Vec<f32>; 3] {
    let cols = frames[0].cols;
    let calibration = Calibration::new(rig(cols), [cols, SENSOR], dark);
    let [mut range, mut reflectance, mut scatter] = [0, 1, 2].map(|_| vec![0.0; cols]);
    let mut out = MeasuredProfile { range: &mut range, reflectance: &mut reflectance, scatter: &mut scatter };
    extract(frames, &calibration, settings, &mut out);
    [range, reflectance, scatter]
}

/// The same of one frame.
pub fn read(frame: Frame, dark: f32, settings: &Extraction) -> [Vec<f32>; 3] {
    read_both(&[frame, Frame::default()], dark, settings)
}

/// A column that is `dark` but for `levels` from row `first` on.
pub fn column(dark: u16, first: usize, levels: &[u16]) -> Vec<u16> {
    let mut column = vec![dark; SENSOR];
    column[first..first + levels.len()].copy_from_slice(levels);
    column
}
