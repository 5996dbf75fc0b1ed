//! Which row of a column is its peak.
//!
//! Model: GlobalMax takes the greatest digital number, FirstLocalMax the first at or above the threshold after which
//! numbers do not rise; rows are searched from row 0 on or from the last row on. So a saturated plateau counts from its
//! first saturated row in the direction of the search (the makers' manual; docs/instrument/extraction.md). How a real
//! camera tells a local maximum from noise on a flank is not published: here any fall of one digital number ends a rise.

use std::ops::Range;

use super::{LANES, line};
use crate::frame::Frame;
use crate::settings::{Direction, Extraction, Peak};

/// Rows before and behind the peak that a reading may use.
const ABOUT: usize = 22;

/// Level [DN] and window row of the peak of each column; level 0 where there is none.
#[inline(always)]
pub(super) fn peaks(frame: &Frame, columns: &Range<usize>, settings: &Extraction) -> ([u16; LANES], [u16; LANES]) {
    let (mut best, mut at) = ([0u16; LANES], [0u16; LANES]);
    match (settings.peak, settings.direction) {
        (Peak::Strongest, Direction::Standard) => {
            for k in 0..frame.rows {
                let dn = line(frame, columns, k);
                for c in 0..LANES {
                    let higher = dn[c] > best[c];
                    best[c] = if higher { dn[c] } else { best[c] };
                    at[c] = if higher { k as u16 } else { at[c] };
                }
            }
        }
        (Peak::Strongest, Direction::Reverse) => {
            for k in 0..frame.rows {
                let dn = line(frame, columns, k);
                for c in 0..LANES {
                    let higher = dn[c] >= best[c];
                    best[c] = if higher { dn[c] } else { best[c] };
                    at[c] = if higher { k as u16 } else { at[c] };
                }
            }
        }
        (Peak::First, direction) => {
            let least = least(settings);
            for step in 0..frame.rows {
                let (k, next) = match direction {
                    Direction::Standard => (step, Some(step + 1).filter(|next| *next < frame.rows)),
                    Direction::Reverse => (frame.rows - 1 - step, (frame.rows - 1 - step).checked_sub(1)),
                };
                let dn = line(frame, columns, k);
                let then = next.map_or([0; LANES], |next| line(frame, columns, next));
                for c in 0..LANES {
                    let found = best[c] == 0 && dn[c] >= least && then[c] <= dn[c];
                    best[c] = if found { dn[c] } else { best[c] };
                    at[c] = if found { k as u16 } else { at[c] };
                }
            }
        }
    }
    (best, at)
}

/// Least digital number of a peak; at least 1, since 0 means none.
fn least(settings: &Extraction) -> u16 {
    (settings.threshold_dn.ceil() as u16).max(1)
}

/// One window about the peak of each column, from the two in `frames` and `dark` where neither is.
pub(super) fn about_peaks(frames: &[Frame; 2], dark: u16, settings: &Extraction) -> Frame {
    let (cols, first_col) = (frames[0].cols, frames[0].first_col);
    let rows = 2 * ABOUT + 1;
    let mut merged = Frame { cols, rows, first_col, first_row: Vec::new(), dn: vec![dark; rows * cols] };
    for start in (0..cols).step_by(LANES) {
        let columns = start..(start + LANES).min(cols);
        let peaks = frames.each_ref().map(|frame| peaks(frame, &columns, settings));
        for column in columns {
            let [a, b] = [0, 1].map(|number: usize| {
                let (best, at) = &peaks[number];
                let row = frames[number].first_row[column] + i32::from(at[column - start]);
                (best[column - start], row)
            });
            let first = peak_of(a, b, settings) - ABOUT as i32;
            merged.first_row.push(first);
            for frame in frames {
                let off = frame.first_row[column] - first;
                for k in (-off).max(0)..(rows as i32 - off).min(frame.rows as i32) {
                    merged.dn[(k + off) as usize * cols + column] = frame.dn[k as usize * cols + column];
                }
            }
        }
    }
    merged
}

/// Row of the peak of a column, from level and row of the peak of either window.
fn peak_of(a: (u16, i32), b: (u16, i32), settings: &Extraction) -> i32 {
    let earlier = match settings.direction {
        Direction::Standard => b.1 < a.1,
        Direction::Reverse => b.1 > a.1,
    };
    let second = match settings.peak {
        Peak::Strongest => b.0 > a.0 || (b.0 == a.0 && earlier),
        Peak::First => b.0 > 0 && (a.0 == 0 || earlier),
    };
    if second { b.1 } else { a.1 }
}
