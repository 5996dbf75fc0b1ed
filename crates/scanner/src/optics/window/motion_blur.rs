//! Motion blur: a global shutter stays open while the object moves on.
//!
//! An exposure begins where its profile stands and lasts the share phi = rate x time of the way to the next one, so its
//! light is the mean over that way. Between two profiles the light is taken as linear in the way, as a line of the
//! object between two sampled lines is:
//!
//! ```text
//! mean over 0 <= u <= phi of ((1 - u) E_n + u E_{n+1}) = (1 - phi / 2) E_n + (phi / 2) E_{n+1}
//! ```
//!
//! Exact for what is linear between profiles, and on average over where between two profiles an edge lies; no light is
//! lost or made along the scan. Where the next line stands apart, over an upright edge, it has a window of its own, and
//! the sensor sees both lines. The next profile's light is kept, so that an exposure costs a blend and no second
//! drawing. Neglected: texture finer than a step, which is not sampled either; a rolling shutter.

use multiversion::multiversion;

use super::compositing::add_shifted;
use super::electrons::{ExposureKey, Scratch, Window};
use crate::optics::light::{ROWS, needs_own_window, without_overlap};
use crate::optics::speckle::TILE;

/// How far an exposure is blurred.
#[derive(Debug, Clone, Copy)]
pub(crate) struct MotionBlur {
    /// Weight of the next profile's light, half of the share of a step that the object moves while it is exposed [1].
    pub share: f32,
    /// Light in one pixel under which no second window is given to it [e-].
    pub faint: f32,
}

/// Fills `scratch` with the mean light of one tile over the way that the object moves while it is exposed; `draw` fills
/// a scratch with the light of the tile in a profile, as if the object stood still.
pub fn window(blur: MotionBlur, key: ExposureKey, scratch: &mut Scratch, draw: impl Fn(usize, &mut Scratch)) {
    let mut next = scratch.next.take().unwrap_or_default();
    if next.key == Some(key) {
        // What is kept becomes this profile's; its buffers take the next one's.
        std::mem::swap(&mut scratch.windows, &mut next.light.windows);
        (scratch.used, scratch.columns) = (next.light.used, next.light.columns);
    } else {
        draw(key.profile, scratch);
    }
    draw(key.profile + 1, &mut next.light);
    next.key = Some(ExposureKey { profile: key.profile + 1, ..key });
    blend(scratch, &next.light, blur);
    scratch.next = Some(next);
}

/// Takes `share` of the next light into `own`; lines that stand apart and are brighter than `faint` get a window.
fn blend(own: &mut Scratch, next: &Scratch, MotionBlur { share, faint }: MotionBlur) {
    if own.used == 1 {
        let separate = needing_windows(&own.windows[0], next, faint);
        if separate.iter().any(Option::is_some) {
            own.used = 2;
            let [first, second] = &mut own.windows;
            second.darken();
            for c in 0..TILE {
                let stand = separate[c].unwrap_or(first.first_row[c] - ROWS as i32);
                second.first_row[c] = without_overlap(stand, first.first_row[c]);
            }
        }
    }
    let windows = &mut own.windows[..own.used];
    windows.iter_mut().for_each(|window| scale(window, 1.0 - share));
    for from in &next.windows[..next.used] {
        add_shifted(from, windows, &[], share);
    }
}

/// Where the next light of each column stands, if it does not fit the one window there is and is bright enough.
fn needing_windows(own: &Window, next: &Scratch, faint: f32) -> [Option<i32>; TILE] {
    std::array::from_fn(|c| {
        let bright = |from: &&Window| (0..ROWS).any(|k| from.volume[k][c] + from.surface[k][c] > faint);
        let beyond =
            next.windows[..next.used].iter().filter(|from| needs_own_window(from.first_row[c], own.first_row[c]));
        beyond.filter(bright).map(|from| from.first_row[c]).next()
    })
}

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn scale(window: &mut Window, by: f32) {
    for k in 0..ROWS {
        for c in 0..TILE {
            window.volume[k][c] *= by;
            window.surface[k][c] *= by;
        }
    }
}
