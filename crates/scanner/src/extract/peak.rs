//! Peak detection: which row of a column is its peak.
//!
//! Model: GlobalMax takes the greatest digital number, FirstLocalMax the first at or above the threshold after which
//! numbers do not rise; rows are searched from row 0 on or from the last row on. So a saturated plateau counts from its
//! first saturated row in the direction of the search (the makers' manual; docs/theory/instrument/extraction.md). How a
//! real camera tells a local maximum from noise on a flank is not published: here any fall of one digital number ends a
//! rise.

use multiversion::multiversion;

use super::block::{ColumnBlock, LANES};
use crate::frame::Frame;
use optical_bench::settings::{Extraction, PeakChoice, SearchDirection};

/// Rows before and behind the peak that a measurement may use [px].
const HALF_WINDOW_ROWS: usize = 22;

/// Level [DN] and window row of the peak of each column; level 0 where there is none.
#[inline(always)]
pub(super) fn peaks(block: ColumnBlock<'_>, settings: &Extraction) -> ([u16; LANES], [u16; LANES]) {
    let (mut best, mut at) = ([0u16; LANES], [0u16; LANES]);
    let rows = block.frame.rows;
    match (settings.peak, settings.direction) {
        (PeakChoice::Strongest, SearchDirection::Standard) => {
            for k in 0..rows {
                let dn = block.row(k);
                for c in 0..LANES {
                    let higher = dn[c] > best[c];
                    best[c] = if higher { dn[c] } else { best[c] };
                    at[c] = if higher { k as u16 } else { at[c] };
                }
            }
        }
        (PeakChoice::Strongest, SearchDirection::Reverse) => {
            for k in 0..rows {
                let dn = block.row(k);
                for c in 0..LANES {
                    let higher = dn[c] >= best[c];
                    best[c] = if higher { dn[c] } else { best[c] };
                    at[c] = if higher { k as u16 } else { at[c] };
                }
            }
        }
        (PeakChoice::First, direction) => {
            let min_peak_level = min_peak_level(settings);
            for step in 0..rows {
                let (k, next) = match direction {
                    SearchDirection::Standard => (step, Some(step + 1).filter(|next| *next < rows)),
                    SearchDirection::Reverse => (rows - 1 - step, (rows - 1 - step).checked_sub(1)),
                };
                let dn = block.row(k);
                let then = next.map_or([0; LANES], |next| block.row(next));
                for c in 0..LANES {
                    let found = best[c] == 0 && dn[c] >= min_peak_level && then[c] <= dn[c];
                    best[c] = if found { dn[c] } else { best[c] };
                    at[c] = if found { k as u16 } else { at[c] };
                }
            }
        }
    }
    (best, at)
}

/// Least digital number of a peak; at least 1, since 0 means none [DN].
fn min_peak_level(settings: &Extraction) -> u16 {
    (settings.threshold_dn.ceil() as u16).max(1)
}

/// One window around the peak of each column, from the two in `frames`, and `dark` where there is neither.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
pub(super) fn merge_windows(frames: &[Frame; 2], dark: u16, settings: &Extraction) -> Frame {
    let (cols, first_col) = (frames[0].cols, frames[0].first_col);
    let rows = 2 * HALF_WINDOW_ROWS + 1;
    let mut merged = Frame { cols, rows, first_col, first_row: Vec::with_capacity(cols), dn: vec![dark; rows * cols] };
    for start in (0..cols).step_by(LANES) {
        let columns = LANES.min(cols - start);
        let peaks = frames.each_ref().map(|frame| peaks(ColumnBlock { frame, first: start, columns }, settings));
        for column in start..start + columns {
            let peak = |number: usize| {
                let (best, at) = &peaks[number];
                let row = frames[number].first_row[column] + i32::from(at[column - start]);
                WindowPeak { level: best[column - start], row }
            };
            merged.first_row.push(winning_row(peak(0), peak(1), settings) - HALF_WINDOW_ROWS as i32);
        }
    }
    for frame in frames {
        let off = |column: usize| frame.first_row[column] - merged.first_row[column];
        let mut start = 0;
        while start < cols {
            // Neighbours whose windows lie alike are copied together.
            let end = (start + 1..cols).find(|&column| off(column) != off(start)).unwrap_or(cols);
            let off = off(start);
            for k in (-off).max(0)..(rows as i32 - off).min(frame.rows as i32) {
                let to = &mut merged.dn[(k + off) as usize * cols..][start..end];
                to.copy_from_slice(&frame.dn[k as usize * cols..][start..end]);
            }
            start = end;
        }
    }
    merged
}

/// Peak of a column in one of its windows.
#[derive(Debug, Clone, Copy)]
struct WindowPeak {
    /// Level; 0 where there is no peak [DN].
    level: u16,
    /// Sensor row [px].
    row: i32,
}

/// Sensor row of the peak of a column, from the peaks of its two windows [px].
fn winning_row(a: WindowPeak, b: WindowPeak, settings: &Extraction) -> i32 {
    let earlier = match settings.direction {
        SearchDirection::Standard => b.row < a.row,
        SearchDirection::Reverse => b.row > a.row,
    };
    let second = match settings.peak {
        PeakChoice::Strongest => b.level > a.level || (b.level == a.level && earlier),
        PeakChoice::First => b.level > 0 && (a.level == 0 || earlier),
    };
    if second { b.row } else { a.row }
}
