//! What a band saw has left: ridges across the board, taken out of a picture.
//!
//! Model: ridges run across the board, slanted by some degrees, so the light of a row, followed along that slant, goes
//! up and down with them as a whole, while streaks and rings of the board's length change within millimetres. The slant
//! is the one under which the mean profile along the board varies most; the ridges are then the mean along it under a
//! Gaussian of 8 mm, which is taken away. Neither pitch nor phase is asked for: both drift along a board, and ridges
//! under gloss are no sine. Source: the ridges of `procedural`'s sawn surface (docs/theory/wood.md). The law and its
//! sizes are engineering estimates. Limits: only ridges within 7 degrees of a row; where rings cross the board for 20
//! mm and more they go too. Boards that lie across the picture keep their ridges. Marks closer than 4 mm are those of
//! `marks`.

use crate::raster::{Beyond, around, smooth};
use crate::texture::Cells;

/// Side of the cells [mm]: a tenth of the closest pitch, 5 mm.
const CELL_MM: f32 = 0.5;
/// Standard deviation of the mean along ridges [mm]: four rings, and within the reach of a knot's gloss.
const ALONG_MM: f32 = 8.0;
/// Gaussian along the board whose mean is no ridge [mm].
const TREND_MM: f32 = 6.0;
/// Steps of the slant to either side, and their size [1]: ridges lie within 0.12 of a row.
const SLANTS: i32 = 24;
const SLANT_STEP: f32 = 0.005;

/// Takes ridges out of the logarithm of light; `counts` says which pixels are clear wood.
pub(crate) fn take_out(log_light: &mut [f32], size: [usize; 2], pixel_mm: [f32; 2], counts: &[bool]) {
    let cells = Cells::with_side(size, pixel_mm, CELL_MM);
    let [mut sums, mut weights] = [vec![0.0_f32; cells.count()], vec![0.0_f32; cells.count()]];
    for pixel in (0..log_light.len()).filter(|&pixel| counts[pixel]) {
        let cell = cells.of([pixel / size[1], pixel % size[1]], pixel_mm);
        sums[cell] += log_light[pixel];
        weights[cell] += 1.0;
    }
    // Without the mean of each column: rings and lamps differ across the board.
    let cols = cells.size[1];
    for col in 0..cols {
        let column = || (col..cells.count()).step_by(cols);
        let count = column().map(|cell| weights[cell]).sum::<f32>().max(1.0);
        let mean = column().map(|cell| sums[cell]).sum::<f32>() / count;
        column().for_each(|cell| sums[cell] -= mean * weights[cell]);
    }
    let slant = slant(&sums, &weights, &cells);
    let along = [0.0, ALONG_MM / cells.side_mm];
    let [sums, weights] =
        [&sums, &weights].map(|values| smooth(&sheared(values, &cells, slant), cells.size, along, Beyond::Zero));
    let trace = 1.0e-3 * weights.iter().fold(0.0_f32, |most, &weight| most.max(weight)).max(f32::MIN_POSITIVE);
    let ridges: Vec<f32> = sums.iter().zip(&weights).map(|(sum, weight)| sum / (weight + trace)).collect();
    let ridges = sheared(&ridges, &cells, -slant);
    for (pixel, light) in log_light.iter_mut().enumerate() {
        let place = [
            ((pixel / size[1]) as f32 + 0.5) * pixel_mm[0] / cells.side_mm - 0.5,
            ((pixel % size[1]) as f32 + 0.5) * pixel_mm[1] / cells.side_mm - 0.5,
        ];
        *light -= around(cells.size, place).iter().map(|&(cell, weight)| weight * ridges[cell]).sum::<f32>();
    }
}

/// Values with each column moved by its distance from the middle times the slant, between two rows in proportion.
fn sheared(values: &[f32], cells: &Cells, slant: f32) -> Vec<f32> {
    let [rows, cols] = cells.size;
    let at = |i: usize| {
        let row = (i / cols) as f32 + slant * ((i % cols) as f32 - 0.5 * (cols - 1) as f32);
        let row = row.clamp(0.0, (rows - 1) as f32);
        let low = (row as usize).min(rows - 2);
        let [upper, lower] = [values[low * cols + i % cols], values[(low + 1) * cols + i % cols]];
        upper + (row - low as f32) * (lower - upper)
    };
    (0..rows * cols).map(at).collect()
}

/// The slant along which the mean profile down the board varies most [1].
fn slant(sums: &[f32], weights: &[f32], cells: &Cells) -> f32 {
    let [rows, cols] = cells.size;
    let variance = |slant: f32| {
        let row_sums = |values: &[f32]| -> Vec<f32> {
            sheared(values, cells, slant).chunks(cols).map(|row| row.iter().sum()).collect()
        };
        let profile: Vec<f32> =
            row_sums(sums).iter().zip(row_sums(weights)).map(|(sum, weight)| sum / weight.max(1.0)).collect();
        let trend = smooth(&profile, [rows, 1], [TREND_MM / cells.side_mm, 0.0], Beyond::Same);
        profile.iter().zip(trend).map(|(value, mean)| (value - mean).powi(2)).sum::<f32>()
    };
    let slants = (-SLANTS..=SLANTS).map(|step| step as f32 * SLANT_STEP);
    slants.map(|slant| (variance(slant), slant)).max_by(|a, b| a.0.total_cmp(&b.0)).map_or(0.0, |(_, slant)| slant)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slanted_ridges_go_and_streaks_stay() {
        let (size, pixel_mm) = ([600, 400], [0.1, 0.15]);
        let place = |i: usize| [(i / 400) as f32 * 0.1, (i % 400) as f32 * 0.15];
        let streaks: Vec<f32> = (0..240_000).map(|i| 0.05 * (9.0 * place(i)[1]).sin()).collect();
        for (pitch, slant) in [(5.0, 0.08), (12.0, -0.03), (25.0, 0.0)] {
            let ridge = |i: usize| {
                let [y, x] = place(i);
                0.1 * (std::f32::consts::TAU * (y + slant * x) / pitch).sin()
            };
            let mut light: Vec<f32> = (0..240_000).map(|i| streaks[i] + ridge(i)).collect();
            take_out(&mut light, size, pixel_mm, &[true; 240_000]);
            let left = |i: &usize| (light[*i] - streaks[*i]).powi(2);
            // Places between cells are read in proportion, which keeps 1 - (pi / 10)^2 / 3 of a wave of 5 mm, twice,
            // and what lies beyond the border is not known: a tenth of the squares within 4 mm of it.
            let inner: Vec<usize> = (0..240_000).filter(|i| (40..560).contains(&(i / 400))).collect();
            let rms = (inner.iter().map(left).sum::<f32>() / inner.len() as f32).sqrt();
            assert!(rms < 0.012, "pitch {pitch}, slant {slant}: {rms} of 0.07 left");
        }
    }
}
