//! Cracks: checks, shakes and splits.
//!
//! Models: a wedge. At the distance c from its line the depth is d (1 - |c| / w), with half width w(s) and depth d(s)
//! along it, both zero at closed ends. The line of a check runs along the grain and wanders; that of a shake follows a
//! ring of the face; a split is a check that begins at an end of the board with its full width. A line on the sensor
//! cannot be found deeper in a crack than some widths, so cracks end at [`DEEPEST_WIDTHS`] of their width. Sources:
//! widths and depths in docs/theory/wood.md. Limits: cracks stand upright to the face.

use std::sync::Arc;

use base::Need::{self, Any};
use base::{Class, lognormal, parameters};
use glam::Vec2;
use rand::RngExt;

use super::board_face::BoardFace;
use super::opening_floor::Floor;
use super::openings::{DEEPEST_WIDTHS, LABELLED_MM, LOG_SD, OpenedBoard, Opening, OpeningForm, Openings};
use super::pith::Trunk;
use crate::noise::Noise;

/// Step of the tables of cracks along them [mm].
const STEP_MM: f32 = 0.5;
/// Most entries of such a table.
const MAX_STEPS: f32 = 20_000.0;
/// Wander of a check's line, root mean square over its length [1], and its cells along it [mm].
const WANDER: [f32; 2] = [0.004, 18.0];
/// Unevenness of a crack's width along it, root mean square [1], and its cell [mm].
const UNEVEN: [f32; 2] = [0.3, 5.0];
const CRACKS: Need = Any(&["cracks.check_count", "cracks.shake_count", "cracks.split_count"]);

parameters! {
    /// Cracks that are open in the upper surface.
    cracks: Cracks {
        /// Drying checks: radial cracks along the grain.
        check_count: 0.0, 100.0, 0.0, "per board", fixed, count;
        /// Ring shakes: cracks along a ring.
        shake_count: 0.0, 20.0, 0.0, "per board", fixed, count;
        /// Splits that run in from the ends.
        split_count: 0.0, 20.0, 0.0, "per board", fixed, count;
        /// Median length.
        length_mm: 2.0, 3000.0, 60.0, "[E]", log_uniform(30.0, 120.0), of [CRACKS];
        /// Median width at the surface, at the widest place.
        width_mm: 0.05, 10.0, 0.5, "[L] 0.05 to 1; spread [M]", log_uniform(0.2, 1.0), of [CRACKS];
        /// Median depth at the deepest place; what is deeper than 25 widths is not seen.
        depth_mm: 0.2, 100.0, 6.0, "[L] 2 to 20", log_uniform(2.0, 20.0), of [CRACKS];
    }
}

/// A crack.
#[derive(Debug)]
struct Crack {
    /// First entry's place along the log, from the board's middle [mm].
    start: f32,
    /// Distance of two entries [mm].
    step: f32,
    /// At each step: place across the log, half width, depth [mm].
    table: Vec<[f32; 3]>,
}

/// Makes the cracks that are asked for.
pub(super) fn grow(openings: &mut Openings, board: &mut OpenedBoard) {
    let (asked, face, trunk) = (&board.wood.cracks, openings.face, board.trunk);
    for (class, name, count) in [
        (Class::Check, "check", asked.check_count),
        (Class::Shake, "shake", asked.shake_count),
        (Class::Split, "split", asked.split_count),
    ] {
        for index in 0..count.round() as u64 {
            let own = board.stream.child(name).index(index);
            let mut rng = own.rng();
            let mut spot = face.spot([rng.random(), rng.random()]);
            let (end, towards) = (rng.random::<f32>() < 0.5, [1.0, -1.0]);
            let mut about = |median: f64| lognormal(&mut rng, median, LOG_SD) as f32;
            let (length, width, depth) = (about(asked.length_mm), about(asked.width_mm), about(asked.depth_mm));
            let side = towards[usize::from(end)];
            if class == Class::Split {
                spot.y = face.middle.y - side * face.half.y;
            }
            let depth = depth.min(DEEPEST_WIDTHS * width).min(openings.room());
            let Vec2 { x: across, y: along } = face.log_place(spot);
            // A split goes on as far beyond the end as into the board, so that it is widest there.
            let reach = if class == Class::Split { length } else { 0.5 * length };
            let steps = (2.0 * reach / STEP_MM).ceil().clamp(4.0, MAX_STEPS);
            let (wander, uneven) = (Noise::new(own.child("wander")), Noise::new(own.child("uneven")));
            let ring = trunk.layer(&trunk.place(spot.x, spot.y, face.height));
            let mut line = across;
            let step = 2.0 * reach / steps;
            let table: Vec<[f32; 3]> = (0..=steps as usize)
                .map(|i| {
                    let s = -reach + i as f32 * step;
                    let place = match class {
                        Class::Shake => {
                            line = on_ring(&face, trunk, ring, line, along + s);
                            line
                        }
                        _ => across + WANDER[0] * length * wander.line(s / WANDER[1]).0,
                    };
                    let q = s / reach;
                    let taper = (1.0 - q * q).max(0.0);
                    let uneven = (1.0 + UNEVEN[0] * uneven.line(s / UNEVEN[1]).0).max(0.2);
                    [place, 0.5 * width * taper * uneven, depth * taper.sqrt()]
                })
                .collect();
            let id = openings.note(board.instances, class, spot, [length, depth], None);
            let start = along - reach;
            let widest = table.iter().fold([f32::MAX, f32::MIN], |[low, high], &[place, half, _]| {
                [low.min(place - half), high.max(place + half)]
            });
            let corners =
                [0, 1].map(|end| [0, 1].map(|side| face.face_place(widest[side], start + end as f32 * 2.0 * reach)));
            let corners = corners.as_flattened();
            let low = corners.iter().copied().reduce(Vec2::min).unwrap_or(spot);
            let high = corners.iter().copied().reduce(Vec2::max).unwrap_or(spot);
            let form = Arc::new(Crack { start, step, table });
            openings.add(Opening { class, id, low, high, labelled: LABELLED_MM, form });
        }
    }
}

/// Place across the log where the face at `along` shows the ring `ring`, nearest to `line` [mm].
fn on_ring(face: &BoardFace, trunk: &Trunk, ring: f32, line: f32, along: f32) -> f32 {
    let mut across = line;
    for _ in 0..4 {
        let spot = face.face_place(across, along);
        let place = trunk.place(spot.x, spot.y, face.height);
        // Right above the pith rings lie flat on the face: a step no longer than a millimetre keeps to one line.
        let slope = place.outward.x;
        across -= ((trunk.layer(&place) - ring) * slope / (slope * slope + 0.01)).clamp(-1.0, 1.0);
    }
    across
}

impl OpeningForm for Crack {
    fn depth(&self, face: &BoardFace, spot: Vec2, _: &Trunk) -> (f32, Floor) {
        let Self { start, step, table } = self;
        let Vec2 { x: across, y: along } = face.log_place(spot);
        let at = (along - start) / step;
        let last = table.len() - 2;
        if at < 0.0 || at >= (last + 1) as f32 {
            return (0.0, Floor::Wood);
        }
        let i = at as usize;
        let part = at - i as f32;
        let [place, half, depth] = std::array::from_fn(|n| table[i][n] + part * (table[i + 1][n] - table[i][n]));
        let aside = (across - place).abs();
        let inside = aside < half;
        (if inside { depth * (1.0 - aside / half) } else { 0.0 }, Floor::Wood)
    }
}
