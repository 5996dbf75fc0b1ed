//! From frames to numbers, as blind as the real instrument: nothing here knows the object.
//!
//! Model: the behaviour of a laser triangulation camera's extractor (SICK Ranger3, docs/instrument.md). The peak is the
//! first greatest digital number of a column, so a saturated plateau counts from its first saturated row; the position
//! is the centre of gravity of the dark-corrected numbers in a window around it, given in fractions of a row;
//! Reflectance is the number at the peak; Scatter is the plain sum of numbers (dark level included, as the camera has
//! it) in windows beside the peak. A peak under the threshold, or too near the sensor's edge for its windows, is missing.
//! Frames keep the rows of a column that hold light, in one window or in two; what lies outside counts as dark.

use multiversion::multiversion;

use crate::frame::{Calibration, Frame};
use crate::settings::{Extraction, ScatterMode};

/// Largest number of columns worked on together.
const LANES: usize = 128;

/// Where the numbers of one profile go, one a column of the frame.
#[derive(Debug)]
pub struct Profile<'a> {
    /// Height [mm]; NaN where missing.
    pub range: &'a mut [f32],
    /// Digital number at the peak [DN]; 0 where missing.
    pub reflectance: &'a mut [f32],
    /// Sum of the side windows [DN]; 0 where missing.
    pub scatter: &'a mut [f32],
}

/// Rows that a reading needs on each side of its peak.
pub fn margin(settings: &Extraction) -> usize {
    settings.window_rows.max(settings.scatter_offset_rows + settings.scatter_width_rows - 1)
}

/// Number of pixels that Scatter sums.
pub fn scatter_pixels(settings: &Extraction) -> usize {
    let side = settings.scatter_width_rows;
    match settings.scatter_mode {
        ScatterMode::Symmetric if settings.scatter_offset_rows == 0 => 2 * side - 1,
        ScatterMode::Symmetric => 2 * side,
        ScatterMode::Front | ScatterMode::Back => side,
    }
}

/// Rows before and behind the peak that a reading may use.
const ABOUT: usize = 22;

/// Reads every column of the windows in `frames`; the second has no rows where one is enough.
pub fn extract(frames: &[Frame; 2], calibration: &Calibration, settings: &Extraction, out: &mut Profile<'_>) {
    let [frame, beside] = frames;
    if beside.rows == 0 {
        return one(frame, calibration, settings, out);
    }
    one(&about_peaks(frames, calibration.dark_level.round() as u16), calibration, settings, out);
}

/// One window about the peak of each column, from the two in `frames` and `dark` where neither is.
fn about_peaks(frames: &[Frame; 2], dark: u16) -> Frame {
    let cols = frames[0].cols;
    let rows = 2 * ABOUT + 1;
    let mut merged =
        Frame { cols, rows, first_col: frames[0].first_col, first_row: Vec::new(), dn: vec![dark; rows * cols] };
    let peaks = frames.each_ref().map(peaks);
    for column in 0..cols {
        let [(a, at), (b, beside)] = [0, 1].map(|number| {
            let (level, k) = peaks[number][column];
            (level, frames[number].first_row[column] + k)
        });
        // The brighter peak; of two alike the one in the smaller row.
        let peak = if b > a || (b == a && beside < at) { beside } else { at };
        let first = peak - ABOUT as i32;
        merged.first_row.push(first);
        for frame in frames {
            let off = frame.first_row[column] - first;
            for k in (-off).max(0)..(rows as i32 - off).min(frame.rows as i32) {
                merged.dn[(k + off) as usize * cols + column] = frame.dn[k as usize * cols + column];
            }
        }
    }
    merged
}

/// Level [DN] and row of the first greatest level of each column of a window.
fn peaks(frame: &Frame) -> Vec<(u16, i32)> {
    let mut peaks = vec![(0u16, 0i32); frame.cols];
    for (k, row) in frame.dn.chunks_exact(frame.cols).take(frame.rows).enumerate() {
        for (peak, &dn) in peaks.iter_mut().zip(row) {
            if dn > peak.0 {
                *peak = (dn, k as i32);
            }
        }
    }
    peaks
}

/// Reads every column of one window.
fn one(frame: &Frame, calibration: &Calibration, settings: &Extraction, out: &mut Profile<'_>) {
    let rig = &calibration.rig;
    let reading = rig.reading();
    let [a, b, c] = reading.straight().map(|number| number as f32);
    let optics = [rig.centre_row as f32, a, b, c];
    for start in (0..frame.cols).step_by(LANES) {
        let columns = start..(start + LANES).min(frame.cols);
        let mut rows = [0.0; LANES];
        read(frame, columns.clone(), calibration, settings, optics, &mut rows, out);
        if !rig.distortion.is_none() {
            for (column, row) in columns.zip(rows) {
                let range = &mut out.range[column];
                if !range.is_nan() {
                    *range = reading.locate((frame.first_col + column) as f64, f64::from(row))[1] as f32;
                }
            }
        }
    }
}

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn read(
    frame: &Frame,
    columns: std::ops::Range<usize>,
    calibration: &Calibration,
    settings: &Extraction,
    optics: [f32; 4],
    rows: &mut [f32; LANES],
    out: &mut Profile<'_>,
) {
    let n = columns.len();
    let line = |k: usize| {
        let mut lanes = [0u16; LANES];
        lanes[..n].copy_from_slice(&frame.dn[k * frame.cols + columns.start..][..n]);
        lanes
    };
    let (mut best, mut at) = ([0u16; LANES], [0u16; LANES]);
    for k in 0..frame.rows {
        let dn = line(k);
        for c in 0..LANES {
            let higher = dn[c] > best[c];
            best[c] = if higher { dn[c] } else { best[c] };
            at[c] = if higher { k as u16 } else { at[c] };
        }
    }
    let window = settings.window_rows as i32;
    let (near, far) = (settings.scatter_offset_rows as i32, settings.scatter_width_rows as i32);
    let (front, back) = match settings.scatter_mode {
        ScatterMode::Symmetric => (1.0, 1.0),
        ScatterMode::Front => (1.0, 0.0),
        ScatterMode::Back => (0.0, 1.0),
    };
    let (mut sum, mut moment, mut scatter) = ([0.0f32; LANES], [0.0f32; LANES], [0.0f32; LANES]);
    for k in 0..frame.rows {
        let dn = line(k);
        for c in 0..LANES {
            let d = k as i32 - i32::from(at[c]);
            let aside = d.abs();
            let level = f32::from(dn[c]);
            let inside = if aside <= window { level - calibration.dark_level } else { 0.0 };
            sum[c] += inside;
            moment[c] += inside * d as f32;
            let side = if d < 0 {
                front
            } else if d > 0 {
                back
            } else {
                1.0
            };
            scatter[c] += if aside >= near && aside < near + far { level * side } else { 0.0 };
        }
    }
    let need = margin(settings) as i32;
    let steps = settings.subpixel_steps as f32;
    let [centre, a, b, rise] = optics;
    for c in 0..n {
        let peak = i32::from(at[c]);
        let row = frame.first_row[columns.start + c] + peak;
        let found = f64::from(best[c]) >= settings.threshold_dn
            && peak >= need
            && peak + need < frame.rows as i32
            && row >= need
            && row + need < calibration.sensor_rows as i32
            && sum[c] > 0.0
            // What lies outside of its own window is noise over noise.
            && moment[c].abs() <= window as f32 * sum[c];
        let mut position = row as f32 + moment[c] / sum[c];
        if settings.subpixel_steps > 0 {
            position = (position * steps).round() / steps;
        }
        rows[c] = position;
        let s = centre - position;
        let place = columns.start + c;
        out.range[place] = if found { a * s / (b + rise * s) } else { f32::NAN };
        out.reflectance[place] = if found { f32::from(best[c]) } else { 0.0 };
        out.scatter[place] = if found { scatter[c] } else { 0.0 };
    }
}
