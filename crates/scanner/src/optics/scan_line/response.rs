//! What the matter of a line does to light, whatever light falls on it, and its interpolation between lines.
//!
//! Wood changes little over some tenths of a millimetre along its fibres: every [`KEY_STEP`]th line is a key line,
//! whose light is worked out in every column. A column of a line between two key lines takes what is linear between
//! them where its own matter, slope and view are nearly linear between theirs ([`OFF`]) and theirs nearly alike
//! ([`APART`]); knots, cracks, edges and grain that runs across the scan are not, and are worked out there. Which lines
//! are key lines depends on their number in the scan alone, so no value depends on bands or threads.

use std::ops::Range;

use multiversion::multiversion;

use crate::optics::speckle::coherence::{CONTRAST_COLUMNS, RowContrasts};
use transport::kernel::{SpreadRow, SurfacePoint};

/// Lines from one key line to the next.
pub(crate) const KEY_STEP: isize = 4;
/// Columns that are interpolated together.
const BLOCK: usize = 32;

/// The last key line up to line `profile` of a scan, and the first from there on.
pub(crate) fn key_lines(profile: isize) -> [isize; 2] {
    let before = profile.div_euclid(KEY_STEP) * KEY_STEP;
    [before, if before == profile { profile } else { before + KEY_STEP }]
}

/// What the matter of one line does to light, over sensor columns.
#[derive(Debug, Default)]
pub(crate) struct Response {
    /// Which line of the scan; `None` for a buffer.
    pub profile: Option<isize>,
    /// Place along the motion [mm].
    pub y_mm: f32,
    /// What each column's surface is to the kernel.
    pub points: Vec<SurfacePoint>,
    /// How light spreads that enters there.
    pub spread: SpreadRow,
    /// Contrasts of speckle beside the line, for every [`CONTRAST_COLUMNS`] columns [1].
    pub contrasts: Vec<RowContrasts>,
}

impl Response {
    /// A buffer for `columns` columns.
    pub fn new(columns: usize) -> Self {
        let (points, spread) = (vec![SurfacePoint::BLACK; columns], SpreadRow::new(columns));
        Self { points, spread, ..Self::default() }
    }

    /// How far this line is on the way from one key line to the other [1].
    fn share(&self, [before, after]: [&Self; 2]) -> f32 {
        let way = after.y_mm - before.y_mm;
        if way.abs() > 1e-6 { ((self.y_mm - before.y_mm) / way).clamp(0.0, 1.0) } else { 0.0 }
    }

    /// Takes over what is linear between two key lines in the columns `own`; `exact` is filled with the columns where
    /// it is not.
    pub fn interpolate(&mut self, keys: [&Self; 2], own: Range<usize>, exact: &mut Vec<u32>) {
        let share = self.share(keys);
        exact.clear();
        for start in own.clone().step_by(BLOCK) {
            let block = start..(start + BLOCK).min(own.end);
            let [before, after] = keys.map(|key| &key.points[block.clone()]);
            let unlike = unlike(&self.points[block.clone()], [before, after], share);
            exact
                .extend(block.clone().filter(|column| unlike >> (column - start) & 1 == 1).map(|column| column as u32));
            if unlike.count_ones() as usize == block.len() {
                continue;
            }
            let Self { spread, .. } = self;
            let [before, after] = keys.map(|key| [&key.spread.enter, &key.spread.exit, &key.spread.shift]);
            for (number, arrays) in [&mut spread.enter, &mut spread.exit, &mut spread.shift].into_iter().enumerate() {
                for (j, array) in arrays.iter_mut().enumerate() {
                    let [before, after] = [&before[number][j][block.clone()], &after[number][j][block.clone()]];
                    lerp(&mut array[block.clone()], before, after, share);
                }
            }
            // Empty without lamps.
            let [before, after] = keys.map(|key| &key.spread.diffuse);
            for ((array, before), after) in spread.diffuse.iter_mut().zip(before).zip(after) {
                if let (Some(before), Some(after)) = (before.get(block.clone()), after.get(block.clone())) {
                    array.resize(self.points.len(), 0.0);
                    lerp(&mut array[block.clone()], before, after, share);
                }
            }
        }
    }

    /// Contrasts of speckle about `column`, which stand for it and its neighbours, where it is not among the columns
    /// `exact`.
    pub fn contrasts_between(&self, keys: [&Self; 2], column: usize, exact: &[u32]) -> Option<RowContrasts> {
        if exact.binary_search(&(column as u32)).is_ok() {
            return None;
        }
        let share = self.share(keys);
        let [before, after] = keys.map(|key| key.contrasts[column / CONTRAST_COLUMNS]);
        let between = |side: usize, row: usize| before[side][row] + share * (after[side][row] - before[side][row]);
        Some([0, 1].map(|side| std::array::from_fn(|row| between(side, row))))
    }
}

fn lerp(values: &mut [f32], before: &[f32], after: &[f32], share: f32) {
    for ((value, before), after) in values.iter_mut().zip(before).zip(after) {
        *value = before + share * (after - before);
    }
}

/// Numbers of a surface point.
const NUMBERS: usize = SurfacePoint::NUMBERS;

/// Most that the key lines' numbers may differ by, in the order of [`SurfacePoint::numbers`]; for those with a part in
/// [`RELATIVE`] in parts of the number itself.
const APART: [f32; NUMBERS] = [0.25, 0.25, 0.25, 0.01, 0.5, 0.05, 0.02, 0.04, 0.03, 0.1, 0.03, 0.1];
/// Most that a number may be off the line between them.
const OFF: [f32; NUMBERS] = [0.015, 0.015, 0.015, 0.0005, 0.05, 0.005, 0.002, 0.004, 0.001, 0.004, 0.0015, 0.004];
/// Which numbers are compared with themselves: coefficients and what enters.
const RELATIVE: [f32; NUMBERS] = [1.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
/// Where fibres change from diving one way to diving the other, these numbers turn their sign and nothing else happens.
const TURNED: [f32; NUMBERS] = [1.0, 1.0, 1.0, 1.0, 1.0, 1.0, -1.0, -1.0, -1.0, -1.0, 1.0, 1.0];
/// The cosine that tells which way they dive.
const TRACK: usize = 7;

/// Bits of the points that are not linear between those of the key lines.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn unlike(points: &[SurfacePoint], [before, after]: [&[SurfacePoint]; 2], share: f32) -> u32 {
    let mut bits = 0;
    for (c, ((point, before), after)) in points.iter().zip(before).zip(after).enumerate() {
        let (own, mut before, mut after) = (point.numbers(), before.numbers(), after.numbers());
        for key in [&mut before, &mut after] {
            if key[TRACK] * own[TRACK] < 0.0 {
                for i in 0..NUMBERS {
                    key[i] *= TURNED[i];
                }
            }
        }
        let mut over = false;
        for i in 0..NUMBERS {
            let way = after[i] - before[i];
            let off = own[i] - (before[i] + share * way);
            let scale = 1.0 + RELATIVE[i] * (own[i].abs() - 1.0);
            over |= (off.abs() > OFF[i] * scale) | (way.abs() > APART[i] * scale);
        }
        // Where no light enters nothing is kept.
        bits |= u32::from(over | (point.enter <= 0.0)) << c;
    }
    bits
}
