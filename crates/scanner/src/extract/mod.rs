//! Extraction: from frames to Range, Reflectance and Scatter, as blind as the real instrument; nothing here knows the
//! object.
//!
//! Model: the behaviour of a laser triangulation camera's extractor (SICK Ranger3, docs/instrument/extraction.md). The
//! `peak` of a column is located between the rows by a method of `position`; Reflectance is the number at the peak;
//! Scatter is the sum of numbers beside it (`scatter`). A peak under the threshold, or too near the sensor's edge for
//! its windows, is missing. Range is the sensor row, the height of the laser plane there, or that height on an even
//! grid (`rectify`).
//!
//! Frames keep the rows of a column that hold light, in one window or in two; what lies outside counts as dark.

mod block;
mod peak;
mod position;
mod rectify;
mod scatter;

use multiversion::multiversion;

use self::block::LANES;
use crate::frame::{Calibration, Frame};
use bench::settings::{Extraction, PeakMethod, RangeForm};

pub use self::block::MeasuredProfile;
pub use self::rectify::{RectifiedGrid, rectify};
pub use self::scatter::{DarkSum, scatter_dark, scatter_pixels};

/// Rows that a measurement needs on each side of its peak [px].
pub fn margin(settings: &Extraction) -> usize {
    let position = match settings.method {
        PeakMethod::Parabola | PeakMethod::Gaussian => 1,
        PeakMethod::CentreOfGravity | PeakMethod::BlaisRioux { .. } | PeakMethod::Fir { .. } => settings.window_rows,
    };
    position.max(settings.scatter_offset_rows + settings.scatter_width_rows - 1)
}

/// Reads every column of the windows in `frames`; the second has no rows where one is enough.
///
/// Rectified scans are read as uncalibrated ones first: `rectify` needs a whole profile.
pub fn extract(frames: &[Frame; 2], calibration: &Calibration, settings: &Extraction, out: &mut MeasuredProfile<'_>) {
    if frames[1].rows == 0 {
        return read_window(&frames[0], calibration, settings, out);
    }
    let dark = calibration.dark_level.round() as u16;
    read_window(&peak::merge_windows(frames, dark, settings), calibration, settings, out);
}

/// Reads every column of one window.
fn read_window(frame: &Frame, calibration: &Calibration, settings: &Extraction, out: &mut MeasuredProfile<'_>) {
    for start in (0..frame.cols).step_by(LANES) {
        let columns = start..(start + LANES).min(frame.cols);
        read_columns(frame, columns, calibration, settings, out);
    }
}

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn read_columns(
    frame: &Frame,
    columns: std::ops::Range<usize>,
    calibration: &Calibration,
    settings: &Extraction,
    out: &mut MeasuredProfile<'_>,
) {
    let n = columns.len();
    let dark = calibration.dark_level;
    let (best, at) = peak::peaks(frame, &columns, settings);
    let (shift, scatter) = match settings.method {
        PeakMethod::CentreOfGravity => position::centre_of_gravity(frame, &columns, &at, dark, settings),
        method => {
            let shift = position::by_neighbouring_rows(frame, &columns, &at, dark, method, settings.window_rows);
            (shift, scatter::scatter_sums(frame, &columns, &at, settings))
        }
    };
    let margin = margin(settings) as i32;
    let steps = settings.subpixel_steps as f32;
    let dark_sum = scatter_dark(settings, dark);
    let range = &mut out.range[columns.clone()];
    for c in 0..n {
        let peak = i32::from(at[c]);
        let row = frame.first_row[columns.start + c] + peak;
        let found = f64::from(best[c]) >= settings.threshold_dn
            && peak >= margin
            && peak + margin < frame.rows as i32
            && row >= margin
            && row + margin < calibration.sensor_rows as i32
            && !shift[c].is_nan();
        let mut position = row as f32 + shift[c];
        if settings.subpixel_steps > 0 {
            position = (position * steps).round() / steps;
        }
        let column = columns.start + c;
        range[c] = if found { position } else { f32::NAN };
        out.reflectance[column] = if found { f32::from(best[c]) } else { 0.0 };
        out.scatter[column] = if found { scatter::as_written(scatter[c], dark_sum) } else { 0.0 };
    }
    if settings.range == RangeForm::Calibrated {
        calibration.locator.heights(frame.first_col + columns.start, range);
    }
}
