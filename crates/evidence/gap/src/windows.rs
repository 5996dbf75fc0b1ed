//! Windows of scans for the classifier of the gap.
//!
//! **A window** is 32 x 32 pixels of which at least half count (of the object, where that is known) and have a height.
//! What is missing beyond that is counted by the share of missing heights, and would here only tell how much of the
//! field the object fills; single missing pixels stay, as a mask. From its heights the plane through the measured ones
//! (least squares) is taken out, for height and slope of a part say nothing about the instrument. Reflectance is
//! rounded to whole digital numbers of 8 bits, which is all that cameras of this kind give: their fractions would give
//! away any simulation. Without a height there is no light either, as files differ in what they leave there.
//!
//! **Parts.** Windows of a scan are not independent. Those of a part stay together: in one fold, and in one term of the
//! variance. A side of four scans or more is tiled without gaps, and a scan is a part. With fewer scans the windows
//! form blocks of 2 x 2 with a band of 16 px between blocks that is in no window. A side of two or three scans has
//! scans as parts too, and needs its blocks for the control alone; of one scan the blocks are the parts.

use std::collections::BTreeMap;

use tools::compare::ScanMaps;

/// Side of a window [px].
pub const WINDOW_SIDE_PX: usize = 32;
/// Band between blocks of windows where blocks are parts [px].
pub const GUARD_PX: usize = 16;
/// Windows along one side of a block.
const BLOCK_WINDOWS: usize = 2;
/// Pixels of a window.
pub(crate) const WINDOW_PIXELS: usize = WINDOW_SIDE_PX * WINDOW_SIDE_PX;
/// Most windows of a side; more are left out evenly. Ten times as many would tell no more, and take ten times the
/// memory.
const MOST_WINDOWS: usize = 1600;
/// Scans from which on they are halved for the control, and tiled without gaps.
const ENOUGH_SCANS: usize = 4;
/// Steps of Range in a unit, mm to um and px to mpx [1].
const THOUSANDTHS: f64 = 1000.0;

/// Maps of light.
pub(crate) const LIGHT_MAPS: [&str; 2] = ["reflectance", "scatter"];

/// One window.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct GapWindow {
    /// Scan that it is from.
    pub scan: usize,
    /// Block that it is from, counted over all scans.
    pub block: usize,
    /// Heights about their plane [um or mpx]; NaN where missing.
    pub range: Vec<f32>,
    /// [`LIGHT_MAPS`] [DN]; 0 where missing.
    pub light: [Option<Vec<f32>>; 2],
}

/// Windows of one side.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct GapSide {
    scans: usize,
    added: usize,
    blocks: usize,
    pitch_mm: [Option<f64>; 2],
    pub(crate) windows: Vec<GapWindow>,
}

/// What a part of a side is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GapPart {
    /// A scan.
    Scan,
    /// A block of windows, with a band of `GUARD_PX` around it.
    Block,
}

impl GapPart {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Scan => "scan",
            Self::Block => "block",
        }
    }
}

impl GapSide {
    /// For a side of so many scans.
    pub fn new(scans: usize) -> Self {
        Self { scans, ..Self::default() }
    }

    /// Cuts the windows of a scan, of which pixels that `ignored` marks don't count, `[rows, cols]`.
    pub fn add(&mut self, maps: &ScanMaps, ignored: Option<&[bool]>) {
        let scan = self.added;
        self.added += 1;
        if maps.range.is_empty() {
            return;
        }
        self.pitch_mm = std::array::from_fn(|i| self.pitch_mm[i].or([maps.col_mm, maps.row_mm][i]));
        let is_tiled = self.scans >= ENOUGH_SCANS;
        let starts = |length: usize| starts(length, is_tiled);
        let across = starts(maps.cols);
        let per_row = across.last().map_or(0, |(block, _)| block + 1);
        let rows = starts(maps.rows);
        let is_measured = |row: usize, col: usize| {
            let pixels = (row..row + WINDOW_SIDE_PX)
                .flat_map(|row| row * maps.cols + col..row * maps.cols + col + WINDOW_SIDE_PX);
            let counts = |i: &usize| maps.range[*i].is_finite() && ignored.is_none_or(|ignored| !ignored[*i]);
            2 * pixels.filter(counts).count() >= WINDOW_PIXELS
        };
        let places: Vec<[usize; 3]> = rows
            .iter()
            .flat_map(|&(block_row, row)| {
                across.iter().map(move |&(block_col, col)| [block_row * per_row + block_col, row, col])
            })
            .filter(|&[_, row, col]| is_measured(row, col))
            .collect();
        let most = MOST_WINDOWS.div_ceil(self.scans.max(1));
        for i in evenly(places.len(), most) {
            let [block, row, col] = places[i];
            self.windows.push(window(maps, scan, self.blocks + block, row, col));
        }
        self.blocks += per_row * rows.last().map_or(0, |(block, _)| block + 1);
    }

    /// Pitch along the line and across profiles of the first scan that says it [mm].
    pub(crate) fn pitch_mm(&self) -> [Option<f64>; 2] {
        self.pitch_mm
    }

    /// What its parts are.
    pub(crate) fn part(&self) -> GapPart {
        if self.scans > 1 { GapPart::Scan } else { GapPart::Block }
    }

    /// What the halves of the control consist of.
    pub(crate) fn control_part(&self) -> GapPart {
        if self.scans >= ENOUGH_SCANS { GapPart::Scan } else { GapPart::Block }
    }
}

impl GapWindow {
    /// Number of its part.
    pub(crate) fn part(&self, part: GapPart) -> usize {
        match part {
            GapPart::Scan => self.scan,
            GapPart::Block => self.block,
        }
    }
}

/// Block and first pixel of each window along a side of so many pixels.
fn starts(length: usize, is_tiled: bool) -> Vec<(usize, usize)> {
    let guard = if is_tiled { 0 } else { GUARD_PX };
    let all = (0..length / WINDOW_SIDE_PX).map(|i| {
        let block = i / BLOCK_WINDOWS;
        (block, i * WINDOW_SIDE_PX + block * guard)
    });
    all.filter(|(_, start)| start + WINDOW_SIDE_PX <= length).collect()
}

/// `most` numbers below `count`, spread evenly; all where there are no more.
pub(crate) fn evenly(count: usize, most: usize) -> impl Iterator<Item = usize> {
    let kept = most.min(count);
    // Middles of as many equal stretches.
    (0..kept).map(move |j| (2 * j + 1) * count / (2 * kept))
}

/// Windows by part.
pub(crate) fn by_part<'w>(windows: &[&'w GapWindow], part: GapPart) -> BTreeMap<usize, Vec<&'w GapWindow>> {
    let mut parts: BTreeMap<usize, Vec<&GapWindow>> = BTreeMap::new();
    for &window in windows {
        parts.entry(window.part(part)).or_default().push(window);
    }
    parts
}

fn window(maps: &ScanMaps, scan: usize, block: usize, row: usize, col: usize) -> GapWindow {
    let at = |i: usize| (row + i / WINDOW_SIDE_PX) * maps.cols + col + i % WINDOW_SIDE_PX;
    let heights: Vec<f64> = (0..WINDOW_PIXELS).map(|i| maps.range[at(i)] * THOUSANDTHS).collect();
    let plane = plane(&heights);
    let range = (0..WINDOW_PIXELS).map(|i| (heights[i] - plane_at(plane, i)) as f32).collect();
    let light = |map: &Option<Vec<f32>>| {
        let dn = |map: &Vec<f32>, i: usize| if heights[i].is_finite() { map[at(i)].round() } else { 0.0 };
        map.as_ref().map(|map| (0..WINDOW_PIXELS).map(|i| dn(map, i)).collect())
    };
    GapWindow { scan, block, range, light: [light(&maps.reflectance), light(&maps.scatter)] }
}

/// Place of pixel `i` of a window from its middle [px].
fn place(i: usize) -> [f64; 2] {
    let from_middle = |i: usize| i as f64 - 0.5 * (WINDOW_SIDE_PX - 1) as f64;
    [from_middle(i % WINDOW_SIDE_PX), from_middle(i / WINDOW_SIDE_PX)]
}

fn plane_at([level, along, across]: [f64; 3], i: usize) -> f64 {
    let [x, y] = place(i);
    level + along * x + across * y
}

/// Level and slopes of the plane through the heights that are there, by least squares [unit, unit/px]; level where they
/// lie on a line.
fn plane(heights: &[f64]) -> [f64; 3] {
    let known = || heights.iter().enumerate().filter(|(_, z)| z.is_finite()).map(|(i, z)| (place(i), *z));
    let n = known().count().max(1) as f64;
    let mean = known().fold([0.0; 3], |[sx, sy, sz], ([x, y], z)| [sx + x / n, sy + y / n, sz + z / n]);
    let [mut xx, mut xy, mut yy, mut xz, mut yz] = [0.0; 5];
    for ([x, y], z) in known() {
        let (x, y, z) = (x - mean[0], y - mean[1], z - mean[2]);
        xx += x * x;
        xy += x * y;
        yy += y * y;
        xz += x * z;
        yz += y * z;
    }
    let determinant = xx * yy - xy * xy;
    if determinant <= 1e-9 * xx * yy {
        return [mean[2], 0.0, 0.0];
    }
    let (along, across) = ((xz * yy - yz * xy) / determinant, (yz * xx - xz * xy) / determinant);
    [mean[2] - along * mean[0] - across * mean[1], along, across]
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A scan of heights that a function of column and profile gives, with light everywhere [mm].
    pub(crate) fn scan(cols: usize, rows: usize, height: impl Fn(usize, usize) -> f64) -> ScanMaps {
        let range: Vec<f64> = (0..rows * cols).map(|i| height(i % cols, i / cols)).collect();
        ScanMaps { cols, rows, reflectance: Some(vec![100.4; range.len()]), range, ..ScanMaps::default() }
    }

    /// Planes vanish, missing pixels stay missing and dark, and light is rounded.
    #[test]
    fn a_plane_is_taken_out() {
        let mut side = GapSide::new(4);
        let tilted = |x: usize, y: usize| if x == 5 { f64::NAN } else { 40.0 + 0.2 * x as f64 - 0.05 * y as f64 };
        side.add(&scan(40, 33, tilted), None);
        let [window] = side.windows.as_slice() else { panic!("{} windows", side.windows.len()) };
        for (i, z) in window.range.iter().enumerate() {
            let light = window.light[0].as_ref().map(|dn| dn[i]);
            let expected = if i % WINDOW_SIDE_PX == 5 { (true, Some(0.0)) } else { (false, Some(100.0)) };
            assert_eq!((z.is_nan(), light), expected, "pixel {i}");
            assert!(z.is_nan() || z.abs() < 1e-6, "{z} um");
        }
    }

    /// Many scans are tiled; one is cut into blocks of four windows that lie a band apart.
    #[test]
    fn blocks_keep_their_distance() {
        let cut = |scans: usize| {
            let mut side = GapSide::new(scans);
            side.add(&scan(160, 96, |_, _| 0.0), None);
            side.windows.iter().map(|window| window.block).collect::<Vec<_>>()
        };
        assert_eq!(cut(4).len(), 15);
        assert_eq!(cut(1), [0, 0, 1, 1, 0, 0, 1, 1]);
        assert_eq!(starts(160, false), [(0, 0), (0, 32), (1, 80), (1, 112)]);
        assert_eq!(starts(79, true), [(0, 0), (0, 32)]);
    }

    /// A window with fewer than half of its heights is left out; blocks of several scans are told apart.
    #[test]
    fn half_of_the_heights_are_needed() {
        let mut side = GapSide::new(2);
        side.add(&scan(32, 32, |_, y| if y < 15 { 1.0 } else { f64::NAN }), None);
        assert_eq!(side.windows.len(), 0);
        side.add(&scan(32, 32, |_, y| if y < 16 { 1.0 } else { f64::NAN }), None);
        side.add(&scan(32, 32, |_, _| 1.0), None);
        let parts: Vec<_> = side.windows.iter().map(|window| (window.scan, window.block)).collect();
        assert_eq!(parts, [(1, 1), (2, 2)]);
    }

    /// What is left out is left out evenly.
    #[test]
    fn few_of_many_are_spread() {
        assert_eq!(evenly(10, 3).collect::<Vec<_>>(), [1, 5, 8]);
        assert_eq!(evenly(3, 9).collect::<Vec<_>>(), [0, 1, 2]);
        assert_eq!(evenly(0, 9).count(), 0);
    }
}
