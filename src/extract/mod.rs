//! From frames to numbers, as blind as the real instrument: nothing here knows the object.
//!
//! Model: the behaviour of a laser triangulation camera's extractor (SICK Ranger3, docs/instrument/extraction.md). The
//! `peak` of a column is placed between the rows by a method of `position`; Reflectance is the number at the peak;
//! Scatter is the sum of numbers beside it (`scatter`). A peak under the threshold, or too near the sensor's edge for its
//! windows, is missing. Range is the sensor row, the height of the laser plane there, or that height on an even grid
//! (`rectify`).
//!
//! Frames keep the rows of a column that hold light, in one window or in two; what lies outside counts as dark.

mod peak;
mod position;
mod rectify;
mod scatter;

use multiversion::multiversion;

use crate::frame::{Calibration, Frame};
use crate::settings::{Extraction, Method, RangeForm};

pub use self::rectify::{Grid, rectify};
pub use self::scatter::{scatter_dark, scatter_pixels};

/// Largest number of columns worked on together.
const LANES: usize = 128;

/// Where the numbers of one profile go, one a column of the frame.
#[derive(Debug)]
pub struct Profile<'a> {
    /// Height [mm] where Range is calibrated, else the sensor row [px]; NaN where missing.
    pub range: &'a mut [f32],
    /// Digital number at the peak [DN]; 0 where missing.
    pub reflectance: &'a mut [f32],
    /// Sum of the side windows [DN]; 0 where missing.
    pub scatter: &'a mut [f32],
}

/// Rows that a reading needs on each side of its peak.
pub fn margin(settings: &Extraction) -> usize {
    let position = match settings.method {
        Method::Parabola | Method::Gaussian => 1,
        Method::CentreOfGravity | Method::BlaisRioux { .. } | Method::Fir { .. } => settings.window_rows,
    };
    position.max(settings.scatter_offset_rows + settings.scatter_width_rows - 1)
}

/// Reads every column of the windows in `frames`; the second has no rows where one is enough.
///
/// Rectified scans are read as uncalibrated ones first: `rectify` needs a whole profile.
pub fn extract(frames: &[Frame; 2], calibration: &Calibration, settings: &Extraction, out: &mut Profile<'_>) {
    if frames[1].rows == 0 {
        return one(&frames[0], calibration, settings, out);
    }
    let dark = calibration.dark_level.round() as u16;
    one(&peak::about_peaks(frames, dark, settings), calibration, settings, out);
}

/// Reads every column of one window.
fn one(frame: &Frame, calibration: &Calibration, settings: &Extraction, out: &mut Profile<'_>) {
    for start in (0..frame.cols).step_by(LANES) {
        let columns = start..(start + LANES).min(frame.cols);
        read(frame, columns, calibration, settings, out);
    }
}

/// A row of some columns of a frame.
#[inline(always)]
fn line(frame: &Frame, columns: &std::ops::Range<usize>, k: usize) -> [u16; LANES] {
    let mut lanes = [0u16; LANES];
    lanes[..columns.len()].copy_from_slice(&frame.dn[k * frame.cols + columns.start..][..columns.len()]);
    lanes
}

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn read(
    frame: &Frame,
    columns: std::ops::Range<usize>,
    calibration: &Calibration,
    settings: &Extraction,
    out: &mut Profile<'_>,
) {
    let n = columns.len();
    let dark = calibration.dark_level;
    let (best, at) = peak::peaks(frame, &columns, settings);
    let (shift, scatter) = match settings.method {
        Method::CentreOfGravity => position::centre_of_gravity(frame, &columns, &at, dark, settings),
        method => {
            let shift = position::by_rows(frame, &columns, &at, dark, method, settings.window_rows);
            (shift, scatter::sums(frame, &columns, &at, settings))
        }
    };
    let need = margin(settings) as i32;
    let steps = settings.subpixel_steps as f32;
    let under = scatter_dark(settings, dark);
    let range = &mut out.range[columns.clone()];
    for c in 0..n {
        let peak = i32::from(at[c]);
        let row = frame.first_row[columns.start + c] + peak;
        let found = f64::from(best[c]) >= settings.threshold_dn
            && peak >= need
            && peak + need < frame.rows as i32
            && row >= need
            && row + need < calibration.sensor_rows as i32
            && !shift[c].is_nan();
        let mut position = row as f32 + shift[c];
        if settings.subpixel_steps > 0 {
            position = (position * steps).round() / steps;
        }
        let place = columns.start + c;
        range[c] = if found { position } else { f32::NAN };
        out.reflectance[place] = if found { f32::from(best[c]) } else { 0.0 };
        out.scatter[place] = if found { scatter::as_written(scatter[c], under) } else { 0.0 };
    }
    if settings.range == RangeForm::Calibrated {
        calibration.locator.heights(frame.first_col + columns.start, range);
    }
}
