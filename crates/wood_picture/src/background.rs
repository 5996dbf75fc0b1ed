//! What lamps do to a board: light that changes over centimetres, taken off by the board itself.
//!
//! Model: the mean of clear wood over some centimetres, where what is far darker or brighter than it (knots, resin,
//! torn fibres, gloss) is left out in four rounds. Limits: a board whose own tone changes over such lengths (heartwood,
//! blue stain) loses that change.

use glam::Vec2;

use crate::raster::{Beyond, around, smooth};
use crate::texture::Cells;

/// Side of the cells [mm].
const CELL_MM: f32 = 1.0;
/// What counts as clear wood over the mean around it [1].
const CLEAR: std::ops::Range<f32> = 0.82..1.25;
/// Rounds.
const ROUNDS: usize = 4;

/// Light of a picture over that of clear wood within `sigma_mm` around it [1].
pub(crate) fn evened(light: &[f32], size: [usize; 2], pixel_mm: [f32; 2], sigma_mm: f32) -> Vec<f32> {
    let cells = Cells::with_side(size, pixel_mm, CELL_MM);
    let [mut sums, mut counts] = [vec![0.0_f32; cells.count()], vec![0.0_f32; cells.count()]];
    for (pixel, light) in light.iter().enumerate() {
        let cell = cells.of([pixel / size[1], pixel % size[1]], pixel_mm);
        sums[cell] += light;
        counts[cell] += 1.0;
    }
    let means: Vec<f32> = sums.iter().zip(&counts).map(|(sum, count)| sum / count.max(1.0)).collect();
    let mut weights: Vec<f32> = counts.iter().map(|count| count.min(1.0)).collect();
    let mut around_it = Vec::new();
    for _ in 0..ROUNDS {
        let weighted: Vec<f32> = means.iter().zip(&weights).map(|(mean, weight)| mean * weight).collect();
        let width = [sigma_mm / cells.side_mm; 2];
        let [sums, all] = [&weighted, &weights].map(|values| smooth(values, cells.size, width, Beyond::Zero));
        around_it =
            sums.iter().zip(all).map(|(sum, all)| (sum / all.max(f32::MIN_POSITIVE)).max(f32::MIN_POSITIVE)).collect();
        for (cell, weight) in weights.iter_mut().enumerate().filter(|(cell, _)| counts[*cell] > 0.0) {
            *weight = if CLEAR.contains(&(means[cell] / around_it[cell])) { 1.0 } else { 1.0e-3 };
        }
    }
    let mut even = Vec::with_capacity(light.len());
    for (pixel, light) in light.iter().enumerate() {
        let (row, col) = (pixel / size[1], pixel % size[1]);
        let place = Vec2::new((col as f32 + 0.5) * pixel_mm[1], (row as f32 + 0.5) * pixel_mm[0]);
        let near = around(cells.size, cells.at(place));
        even.push(light / near.iter().map(|&(cell, weight)| weight * around_it[cell]).sum::<f32>());
    }
    even
}
