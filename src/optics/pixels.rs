//! What stays with the pixels of a sensor: unlike response (PRNU), unlike dark level (DSNU), column pattern, defects.
//!
//! EMVA 1288 (release 4.0): PRNU and DSNU are standard deviations over the pixels of a sensor, here normal and without
//! correlation but for the columns. Drawn once a sample by pixel `[row, column]` of its camera, so every profile sees the
//! same, wherever the line lies. Each pixel is two bytes, in steps of 1/20 of a standard deviation, which adds 2e-4 to a
//! variance and leaves out what lies beyond 6.3 of them. Of the defects one half is dead (no response), the other always
//! full. Neglected: slow shading over the sensor (it is in the lens), clusters, dark current of single pixels.

use procedural::Stream;

use super::parameters::Exposure;
use super::speckle::TILE;
use crate::lanes::{hash, normals};
use crate::settings::Size;

/// Steps in a standard deviation.
const STEPS: f64 = 20.0;
/// The code of a defect.
const DEFECT: i8 = i8::MIN;
/// What an always full pixel adds [DN], far above any converter's end.
const FULL: f32 = 1e6;

/// The pixels of one sensor.
#[derive(Debug, Clone)]
pub struct Pixels {
    /// Steps of response and of offset, `[tiles][rows][TILE]`.
    codes: Vec<[i8; 2]>,
    rows: usize,
    /// A step of response [1], a step of offset [DN].
    steps: [f32; 2],
}

/// Response [1] and offset [DN] of a row of a tile.
pub type Line = ([f32; TILE], [f32; TILE]);

impl Pixels {
    /// The pixels of a sensor of `size` whose numbers are `scale` times those of 8 bits; `None` where all are alike.
    pub fn new(exposure: &Exposure, scale: f64, size: &Size, stream: Stream) -> Option<Self> {
        let offset = (exposure.dsnu_dn.powi(2) + exposure.column_pattern_dn.powi(2)).sqrt();
        if exposure.prnu == 0.0 && offset == 0.0 && exposure.defect_share == 0.0 {
            return None;
        }
        let keys = |name: &str| {
            let key = stream.child(name).key();
            [key as u32, (key >> 32) as u32]
        };
        let (pixel, column, defect) = (keys("noise"), keys("column"), keys("defect")[0]);
        // Shares of a standard deviation of the offset.
        let parts = [exposure.dsnu_dn, exposure.column_pattern_dn].map(|part| (STEPS * part / offset.max(1e-9)) as f32);
        let response = if exposure.prnu > 0.0 { STEPS as f32 } else { 0.0 };
        let half = (0.5 * exposure.defect_share * f64::from(u32::MAX)) as u32;
        let code = |steps: f32| steps.round().clamp(-127.0, 127.0) as i8;
        let mut codes = Vec::with_capacity(size.columns.div_ceil(TILE) * TILE * size.rows);
        for tile in 0..size.columns.div_ceil(TILE) {
            let first = (tile * TILE) as u32;
            let columns: [f32; TILE] = std::array::from_fn(|c| parts[1] * normals(first + c as u32, column).0);
            for row in 0..size.rows as u32 {
                for (c, own) in (first..).zip(&columns) {
                    let counter = row << 14 | c;
                    let (a, b) = normals(counter, pixel);
                    let drawn = hash(counter ^ defect);
                    codes.push([
                        if drawn < half { DEFECT } else { code(response * a) },
                        if drawn > u32::MAX - half { DEFECT } else { code(parts[0] * b + own) },
                    ]);
                }
            }
        }
        let steps = [exposure.prnu / STEPS, offset * scale / STEPS].map(|step| step as f32);
        Some(Self { codes, rows: size.rows, steps })
    }

    /// One pixel; rows beyond the edge take the edge's.
    #[inline(always)]
    fn code(&self, tile: usize, row: i32, c: usize) -> [i8; 2] {
        let row = row.clamp(0, self.rows as i32 - 1) as usize;
        self.codes[(tile * self.rows + row) * TILE + c]
    }

    #[inline(always)]
    fn shown(&self, [response, offset]: [i8; 2]) -> (f32, f32) {
        let responds = (1.0 + self.steps[0] * f32::from(response)).max(0.0);
        let shifts = self.steps[1] * f32::from(offset);
        (
            if response == DEFECT { 0.0 } else { responds },
            if offset == DEFECT { FULL } else { shifts },
        )
    }

    /// Row `k` of windows that begin at `first_row` in each column of a tile.
    #[inline(always)]
    pub fn line(&self, tile: usize, first_row: &[i32; TILE], k: usize) -> Line {
        let mut line = ([0.0; TILE], [0.0; TILE]);
        for c in 0..TILE {
            (line.0[c], line.1[c]) = self.shown(self.code(tile, first_row[c] + k as i32, c));
        }
        line
    }

    /// Response [1] and offset [DN] of the pixel in a row and column of the sensor.
    pub fn at(&self, row: usize, column: usize) -> (f32, f32) {
        self.shown(self.code(column / TILE, row as i32, column % TILE))
    }
}
