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
        (if response == DEFECT { 0.0 } else { responds }, if offset == DEFECT { FULL } else { shifts })
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

#[cfg(test)]
mod tests {
    use procedural::Parameter;

    use super::*;

    const SIZE: Size = Size { columns: 512, rows: 400, profiles: 1 };

    fn pixels(set: impl Fn(&mut Exposure)) -> Option<Pixels> {
        let mut exposure = Exposure::from_values(&mut |p: &'static Parameter| p.default);
        set(&mut exposure);
        Pixels::new(&exposure, 1.0, &SIZE, Stream::root(3))
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
        let all = |p: &Pixels| {
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
        for n in [count(&|v| v.0 == 0.0), count(&|v| v.1 == FULL)] {
            assert!((n - 1024.0).abs() < 128.0, "{n} defects");
        }
    }

    /// Windows show the pixels of the sensor that they lie on, and the edge's beyond it.
    #[test]
    fn windows_lie_on_the_sensor() {
        let pixels = pixels(|e| (e.prnu, e.dsnu_dn, e.column_pattern_dn) = (0.01, 0.25, 0.1)).expect("pixels differ");
        let first: [i32; TILE] = std::array::from_fn(|c| c as i32 - 20);
        let (response, offset) = pixels.line(2, &first, 30);
        for c in 0..TILE {
            let row = (first[c] + 30).clamp(0, SIZE.rows as i32 - 1) as usize;
            assert_eq!((response[c], offset[c]), pixels.at(row, 2 * TILE + c), "column {c}");
        }
        assert_eq!(pixels.line(0, &[-100; TILE], 3).0[9], pixels.at(0, 9).0);
        assert_eq!(pixels.line(0, &[1000; TILE], 3).0[9], pixels.at(SIZE.rows - 1, 9).0);
    }
}
