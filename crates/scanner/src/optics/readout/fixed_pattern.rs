//! Fixed-pattern noise of a sensor: non-uniform response (PRNU) and dark signal (DSNU), column pattern, defects.
//!
//! EMVA 1288 (release 4.0): PRNU and DSNU are standard deviations over the pixels of a sensor, here normal and without
//! correlation but for the columns. Drawn by sample and pixel `[row, column]` of its camera, so every profile sees the
//! same, wherever the line lies; a row of a tile is drawn when it is first looked at. Each pixel is two bytes, in steps
//! of 1/20 of a standard deviation, which adds 2e-4 to a variance and leaves out what lies beyond 6.3 of them. Of the
//! defects one half is dead (no response), the other always full. Neglected: slow shading over the sensor (it is in the
//! lens), clusters, dark current of single pixels.

use std::sync::OnceLock;

use crate::optics::speckle::TILE;
use base::Stream;
use numerics::lanes::{hash, normals};
use optical_bench::parameters::ExposureParameters;
use optical_bench::settings::Size;

/// Steps in a standard deviation.
const CODES_PER_SIGMA: f64 = 20.0;
/// The code of a defect.
const DEFECT_CODE: i8 = i8::MIN;
/// What an always full pixel adds [DN], far above any converter's end.
const ALWAYS_FULL_DN: f32 = 1e6;

/// Most runs of columns that are copied whole; more are looked up column by column.
const MAX_COPIED_RUNS: usize = 12;

/// The pixels of one sensor.
#[derive(Debug, Clone)]
pub(crate) struct FixedPattern {
    /// Codes of response and of offset, `[tiles][rows]`, as far as they were asked for.
    codes: Vec<OnceLock<PixelCodes>>,
    rows: usize,
    /// How a row is drawn.
    law: PixelLaw,
    /// What a step is.
    pub steps: CodeSteps,
}

/// How codes of pixels are drawn.
#[derive(Debug, Clone)]
struct PixelLaw {
    /// Keys of the pixels' own normals, and of their defects.
    pixel: [u32; 2],
    defect: u32,
    /// Steps of a standard deviation of the response [1].
    response: f32,
    /// The same of the pixel's own part of the offset [1].
    offset: f32,
    /// What each column adds to the offset [steps].
    columns: Vec<f32>,
    /// Hashes below this are dead pixels, those as far from the other end always full ones.
    half: u32,
}

/// Codes of response and of offset in a row of a tile.
pub(crate) type PixelCodes = [[i8; TILE]; 2];

/// Pixels that are all alike.
pub(crate) const UNIFORM_CODES: PixelCodes = [[0; TILE]; 2];

/// A step of response [1], a step of offset [DN].
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct CodeSteps([f32; 2]);

impl CodeSteps {
    /// Response [1] and offset [DN] of column `c` of a tile's row.
    #[inline(always)]
    pub fn decode(self, codes: &PixelCodes, c: usize) -> (f32, f32) {
        let [response, offset] = [codes[0][c], codes[1][c]];
        let responds = (1.0 + self.0[0] * f32::from(response)).max(0.0);
        let shifts = self.0[1] * f32::from(offset);
        (
            if response == DEFECT_CODE { 0.0 } else { responds },
            if offset == DEFECT_CODE { ALWAYS_FULL_DN } else { shifts },
        )
    }
}

/// Neighbouring columns of a tile whose windows begin in the same row of the sensor.
#[derive(Debug)]
pub(crate) struct WindowRuns {
    /// First column and first row of each, one more at the end.
    starts: [(usize, i32); TILE + 1],
    count: usize,
}

impl WindowRuns {
    /// Of windows that begin at `first_row` in each column.
    pub fn new(first_row: &[i32; TILE]) -> Self {
        let (mut starts, mut count) = ([(TILE, 0); TILE + 1], 0);
        for c in 0..TILE {
            if c == 0 || first_row[c] != first_row[c - 1] {
                starts[count] = (c, first_row[c]);
                count += 1;
            }
        }
        Self { starts, count }
    }
}

impl PixelLaw {
    /// Draws a row of a tile.
    fn row(&self, tile: usize, row: u32) -> PixelCodes {
        let code = |steps: f32| steps.round().clamp(-127.0, 127.0) as i8;
        let first = tile * TILE;
        let mut line = UNIFORM_CODES;
        for (c, own) in self.columns[first..][..TILE].iter().enumerate() {
            let counter = row << 14 | (first + c) as u32;
            let (a, b) = normals(counter, self.pixel);
            let drawn = hash(counter ^ self.defect);
            line[0][c] = if drawn < self.half { DEFECT_CODE } else { code(self.response * a) };
            let shifts = code(self.offset * b + own);
            line[1][c] = if drawn > u32::MAX - self.half { DEFECT_CODE } else { shifts };
        }
        line
    }
}

impl FixedPattern {
    /// Whether some pixels are dead or always full.
    pub fn has_defects(&self) -> bool {
        self.law.half > 0
    }

    /// The pixels of a sensor of `size` whose numbers are `scale` times those of 8 bits; `None` where all are alike.
    pub fn new(exposure: &ExposureParameters, scale: f64, size: &Size, stream: Stream) -> Option<Self> {
        let offset = (exposure.dsnu_dn.powi(2) + exposure.column_pattern_dn.powi(2)).sqrt();
        if exposure.prnu == 0.0 && offset == 0.0 && exposure.defect_share == 0.0 {
            return None;
        }
        let keys = |name: &str| {
            let key = stream.child(name).key();
            [key as u32, (key >> 32) as u32]
        };
        let column = keys("column");
        // Shares of a standard deviation of the offset.
        let parts = [exposure.dsnu_dn, exposure.column_pattern_dn]
            .map(|part| (CODES_PER_SIGMA * part / offset.max(1e-9)) as f32);
        let tiles = size.columns.div_ceil(TILE);
        let law = PixelLaw {
            pixel: keys("noise"),
            defect: keys("defect")[0],
            response: if exposure.prnu > 0.0 { CODES_PER_SIGMA as f32 } else { 0.0 },
            offset: parts[0],
            columns: (0..(tiles * TILE) as u32).map(|c| parts[1] * normals(c, column).0).collect(),
            half: (0.5 * exposure.defect_share * f64::from(u32::MAX)) as u32,
        };
        let steps =
            CodeSteps([exposure.prnu / CODES_PER_SIGMA, offset * scale / CODES_PER_SIGMA].map(|step| step as f32));
        let codes = std::iter::repeat_with(OnceLock::new).take(tiles * size.rows).collect();
        Some(Self { codes, rows: size.rows, law, steps })
    }

    /// A row of a tile; rows beyond the edge take the edge's.
    fn row(&self, tile: usize, row: i32) -> &PixelCodes {
        let row = row.clamp(0, self.rows as i32 - 1);
        self.codes[tile * self.rows + row as usize].get_or_init(|| self.law.row(tile, row as u32))
    }

    /// Fills `line` with row `k` of windows in a tile.
    pub(crate) fn window_row(&self, tile: usize, runs: &WindowRuns, k: usize, line: &mut PixelCodes) {
        let starts = &runs.starts[..=runs.count];
        for (&(start, first_row), &(end, _)) in starts.iter().zip(&starts[1..]) {
            let [responses, offsets] = self.row(tile, first_row + k as i32);
            if runs.count <= MAX_COPIED_RUNS {
                line[0][start..end].copy_from_slice(&responses[start..end]);
                line[1][start..end].copy_from_slice(&offsets[start..end]);
            } else {
                (start..end).for_each(|c| (line[0][c], line[1][c]) = (responses[c], offsets[c]));
            }
        }
    }

    /// The greatest response that a pixel can have [1].
    pub fn greatest_response(&self) -> f32 {
        1.0 + self.steps.0[0] * f32::from(i8::MAX)
    }

    /// The greatest offset that a pixel without defect can have [DN].
    pub fn greatest_offset(&self) -> f32 {
        self.steps.0[1] * f32::from(i8::MAX)
    }

    /// Response [1] and offset [DN] of the pixel in a row and column of the sensor.
    pub fn at(&self, row: usize, column: usize) -> (f32, f32) {
        self.steps.decode(self.row(column / TILE, row as i32), column % TILE)
    }
}

#[cfg(test)]
mod tests {
    use base::Parameter;

    use super::*;

    const SIZE: Size = Size { columns: 512, rows: 400, profiles: 1 };

    fn pixels(set: impl Fn(&mut ExposureParameters)) -> Option<FixedPattern> {
        let mut exposure = ExposureParameters::from_values(&mut |p: &'static Parameter| p.default);
        set(&mut exposure);
        FixedPattern::new(&exposure, 1.0, &SIZE, Stream::root(3))
    }

    fn moments(values: impl Iterator<Item = f32> + Clone) -> (f64, f64) {
        let n = values.clone().count() as f64;
        let mean = values.clone().map(f64::from).sum::<f64>() / n;
        (mean, (values.map(|v| (f64::from(v) - mean).powi(2)).sum::<f64>() / n).sqrt())
    }

    /// Each source has its own spread and leaves the others alone; alike pixels need no map.
    #[test]
    fn sources_are_switched_alone() {
        assert!(pixels(|_| ()).is_none());
        // 204 800 pixels: a spread is known to 0.16 %, four of which.
        let near = |found: f64, set: f64| (found - set).abs() <= 0.0064 * set;
        let all = |p: &FixedPattern| {
            (0..SIZE.rows * SIZE.columns).map(|i| p.at(i / SIZE.columns, i % SIZE.columns)).collect::<Vec<_>>()
        };
        let found = all(&pixels(|e| e.prnu = 0.01).expect("pixels differ"));
        assert!(near(moments(found.iter().map(|v| v.0)).1, 0.01) && found.iter().all(|v| v.1 == 0.0));
        let found = all(&pixels(|e| e.dsnu_dn = 0.25).expect("pixels differ"));
        assert!(near(moments(found.iter().map(|v| v.1)).1, 0.25) && found.iter().all(|v| v.0 == 1.0));
        let found = all(&pixels(|e| e.column_pattern_dn = 0.1).expect("pixels differ"));
        assert!(found.iter().zip(&found[SIZE.columns..]).all(|(a, b)| a == b), "columns are even");
        // 512 columns: 3.1 %, three of which.
        assert!((moments(found[..SIZE.columns].iter().map(|v| v.1)).1 / 0.1 - 1.0).abs() < 0.1);
        let found = all(&pixels(|e| e.defect_share = 0.01).expect("pixels differ"));
        let count = |defect: &dyn Fn(&(f32, f32)) -> bool| found.iter().filter(|v| defect(v)).count() as f64;
        // 1024 of each expected, standard deviation 32.
        for n in [count(&|v| v.0 == 0.0), count(&|v| v.1 == ALWAYS_FULL_DN)] {
            assert!((n - 1024.0).abs() < 128.0, "{n} defects");
        }
    }

    /// Windows show the pixels of the sensor that they lie on, and the edge's beyond it.
    #[test]
    fn windows_lie_on_the_sensor() {
        let pixels = pixels(|e| (e.prnu, e.dsnu_dn, e.column_pattern_dn) = (0.01, 0.25, 0.1)).expect("pixels differ");
        let line = |tile: usize, first: &[i32; TILE], k: usize| {
            let mut codes = UNIFORM_CODES;
            pixels.window_row(tile, &WindowRuns::new(first), k, &mut codes);
            std::array::from_fn::<_, TILE, _>(|c| pixels.steps.decode(&codes, c))
        };
        // A slope, a step, and a level line.
        for first in [|c| c as i32 - 20, |c| 100 + (c / 50) as i32, |_| 7] {
            let first: [i32; TILE] = std::array::from_fn(first);
            for (c, seen) in line(2, &first, 30).into_iter().enumerate() {
                let row = (first[c] + 30).clamp(0, SIZE.rows as i32 - 1) as usize;
                assert_eq!(seen, pixels.at(row, 2 * TILE + c), "column {c}");
            }
        }
        assert_eq!(line(0, &[-100; TILE], 3)[9], pixels.at(0, 9));
        assert_eq!(line(0, &[1000; TILE], 3)[9], pixels.at(SIZE.rows - 1, 9));
    }
}
