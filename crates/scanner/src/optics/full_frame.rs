//! Full frames of the sensor: those that recipes keep, and those that the thesis' scripts work on.

use super::expose::TileOfProfile;
use super::light::ROWS;
use super::readout::FrameLight;
use super::sensor::Sensor;
use super::speckle::TILE;
use super::window::{Band, Scratch};
use crate::frame::Frame;
use numerics::lanes;

impl Sensor {
    /// Light of exposure `profile` without speckle and noise, in the rows that hold some.
    pub fn light(&self, band: &Band, profile: usize) -> FrameLight {
        let (rows, columns) = (self.size.rows, self.size.columns);
        let mut places = Vec::new();
        let mut scratch = Scratch::default();
        for tile in 0..columns.div_ceil(TILE) {
            self.window(band, profile, tile, &mut scratch);
            for window in &scratch.windows[..scratch.used] {
                for k in 0..ROWS {
                    for c in 0..scratch.columns {
                        let (row, light) = (window.first_row[c] + k as i32, window.volume[k][c] + window.surface[k][c]);
                        if light > 0.0 && (0..rows as i32).contains(&row) {
                            places.push((row as usize, tile * TILE + c, self.chain.gain * light));
                        }
                    }
                }
            }
        }
        let first_row = places.iter().map(|place| place.0).min().unwrap_or(0);
        let last = places.iter().map(|place| place.0 + 1).max().unwrap_or(0);
        let mut numbers = vec![0.0; (last - first_row) * columns];
        // Windows that lie over each other hold the same light.
        places.iter().for_each(|&(row, column, light)| numbers[(row - first_row) * columns + column] = light);
        FrameLight { columns, first_row, numbers }
    }

    /// The whole sensor in exposure `profile` by the thesis' scripts; no rows where there are none.
    pub fn processed(&self, band: &Band, profile: usize) -> Frame {
        let Some(scripts) = &self.scripts else { return Frame::default() };
        let (rows, cols) = (self.size.rows, self.size.columns);
        let dn = scripts.frame(self.light(band, profile), rows, profile);
        Frame { cols, rows, first_col: 0, first_row: vec![0; cols], dn }
    }

    /// The whole sensor in exposure `profile`, `[rows, columns]`, row-major [DN]; rows outside the windows are dark.
    pub fn full_frame(&self, band: &Band, profile: usize) -> Vec<u16> {
        let (rows, columns) = (self.size.rows, self.size.columns);
        let mut offsets = Vec::new();
        self.row_offsets(profile, &mut offsets);
        let keys = self.chain.keys("dark", profile);
        let lit = self.drawing(band, profile).lit;
        let mut sensor: Vec<u16> = (0..rows * columns)
            .map(|pixel| {
                let (row, column) = (pixel / columns, pixel % columns);
                let (normal, _) = lanes::normals(pixel as u32, keys);
                let light = lit.ambient_in([row, column]) + lit.glare_in([row, column]);
                self.chain.number([row, column], light, normal, offsets[row])
            })
            .collect();
        let (mut scratch, mut frames) = (Scratch::default(), <[Frame; 2]>::default());
        for tile in 0..columns.div_ceil(TILE) {
            self.expose(&TileOfProfile { band, profile, tile, offsets: &offsets }, &mut scratch, &mut frames);
            for (k, frame) in frames.iter().flat_map(|frame| (0..frame.rows).map(move |k| (k, frame))) {
                for column in 0..frame.cols {
                    let row = frame.first_row[column] + k as i32;
                    if (0..rows as i32).contains(&row) {
                        sensor[row as usize * columns + frame.first_col + column] = frame.dn[k * frame.cols + column];
                    }
                }
            }
        }
        sensor
    }
}
