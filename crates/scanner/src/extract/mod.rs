//! Extraction: from frames to Range, Reflectance and Scatter, as blind as the real instrument; nothing here knows the
//! object.
//!
//! Model: the behaviour of a laser triangulation camera's extractor (SICK Ranger3,
//! docs/theory/instrument/extraction.md). The
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

use self::block::{ColumnBlock, LANES};
use crate::frame::{Calibration, Frame};
use optical_bench::settings::{Extraction, PeakChoice, PeakMethod, RangeForm};

pub use self::block::MeasuredProfile;
pub use self::rectify::{MAX_SURFACE_SLOPE, RectifiedGrid, rectify};
pub use self::scatter::{DarkSum, scatter_dark, scatter_pixels};

/// Rows that a measurement needs on each side of its peak [px].
pub fn margin(settings: &Extraction) -> usize {
    let position = match settings.method {
        PeakMethod::Parabola | PeakMethod::Gaussian => 1,
        PeakMethod::CentreOfGravity | PeakMethod::BlaisRioux { .. } | PeakMethod::Fir { .. } => settings.window_rows,
    };
    position.max(settings.scatter_offset_rows + settings.scatter_width_rows - 1)
}

/// Rows that a measurement looks at on each side of its peak, beyond its [`margin`] too [px].
pub(crate) fn reach(settings: &Extraction) -> usize {
    let position = match settings.method {
        PeakMethod::Parabola | PeakMethod::Gaussian => 1,
        PeakMethod::CentreOfGravity => settings.window_rows,
        // The slope one row behind the window, and the rows that it is made from.
        PeakMethod::BlaisRioux { order } => settings.window_rows + 1 + order / 2,
        PeakMethod::Fir { length } => settings.window_rows + 2 + length / 2,
    };
    position.max(margin(settings))
}

/// What the peaks of a block of columns tell of rows that were not read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PeakLevels {
    /// Whether a peak lies nearer to an end of its window than a measurement looks.
    pub at_an_end: bool,
    /// Level that a pixel in further rows would have to reach for its column to be read otherwise; infinite where there
    /// is no column [DN].
    pub to_outshine: [f32; LANES],
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
    for first in (0..frame.cols).step_by(LANES) {
        let columns = LANES.min(frame.cols - first);
        read_columns(ColumnBlock { frame, first, columns }, calibration, settings, out);
    }
}

/// Reads the columns of one tile's window, and tells their peaks.
pub(crate) fn extract_tile(
    frame: &Frame,
    calibration: &Calibration,
    settings: &Extraction,
    out: &mut MeasuredProfile<'_>,
) -> PeakLevels {
    read_columns(ColumnBlock { frame, first: 0, columns: frame.cols }, calibration, settings, out)
}

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn read_columns(
    block: ColumnBlock<'_>,
    calibration: &Calibration,
    settings: &Extraction,
    out: &mut MeasuredProfile<'_>,
) -> PeakLevels {
    let ColumnBlock { frame, first, columns } = block;
    let dark = calibration.dark_level;
    let (best, at) = peak::peaks(block, settings);
    let (shift, scatter) = match settings.method {
        PeakMethod::CentreOfGravity => position::centre_of_gravity(block, &at, dark, settings),
        method => {
            let shift = position::by_neighbouring_rows(block, &at, dark, method, settings.window_rows);
            (shift, scatter::scatter_sums(block, &at, settings))
        }
    };
    let (margin, reach) = (margin(settings) as i32, reach(settings) as i32);
    let mut peaks = PeakLevels { at_an_end: false, to_outshine: [f32::INFINITY; LANES] };
    let strongest = settings.peak == PeakChoice::Strongest;
    let steps = settings.subpixel_steps as f32;
    let dark_sum = scatter_dark(settings, dark);
    let range = &mut out.range[first..first + columns];
    for c in 0..columns {
        let peak = i32::from(at[c]);
        let row = frame.first_row[first + c] + peak;
        let bright = f64::from(best[c]) >= settings.threshold_dn;
        peaks.at_an_end |= bright && (peak < reach || peak + reach >= frame.rows as i32);
        peaks.to_outshine[c] = if bright && strongest { f32::from(best[c]) } else { settings.threshold_dn as f32 };
        let found = bright
            && peak >= margin
            && peak + margin < frame.rows as i32
            && row >= margin
            && row + margin < calibration.sensor_rows as i32
            && !shift[c].is_nan();
        let mut position = row as f32 + shift[c];
        if settings.subpixel_steps > 0 {
            position = (position * steps).round() / steps;
        }
        let column = first + c;
        range[c] = if found { position } else { f32::NAN };
        out.reflectance[column] = if found { f32::from(best[c]) } else { 0.0 };
        out.scatter[column] = if found { scatter::as_written(scatter[c], dark_sum) } else { 0.0 };
    }
    if settings.range == RangeForm::Calibrated {
        calibration.locator.heights(frame.first_col + first, range);
    }
    peaks
}
