//! What lamps do to a board: light that changes over centimetres, taken off by the board itself.
//!
//! Model: the logarithm of light of clear wood is a plane around each place, fitted under a Gaussian of some
//! centimetres (local linear regression, Cleveland 1979), which follows lamps right to the board's edges where a mean
//! of one side would not. What is far darker or brighter than it (knots, resin, torn fibres, gloss) is left out in four
//! rounds. Limits: a board whose own tone changes over such lengths (heartwood, blue stain) loses that change.

use glam::{Mat3, Vec2, Vec3};

use crate::raster::{Beyond, around, filter, gaussian};
use crate::texture::Cells;

/// Side of the cells [mm].
const CELL_MM: f32 = 1.0;
/// What counts as clear wood over what is around it [1].
const CLEAR: std::ops::Range<f32> = 0.82..1.25;
/// Rounds.
const ROUNDS: usize = 4;
/// Cells below this part of the mean count as this part [1]: a logarithm has no end.
const DARKEST: f32 = 0.1;
/// Added to the plane's second moments, over the square of the Gaussian's width [1]: where all lies in one line there
/// is no slope across it.
const RIDGE: f32 = 1.0e-6;

/// Light of a picture over that of clear wood within `sigma_mm` around it [1].
pub(crate) fn evened(light: &[f32], size: [usize; 2], pixel_mm: [f32; 2], sigma_mm: f32) -> Vec<f32> {
    let cells = Cells::with_side(size, pixel_mm, CELL_MM);
    let [mut sums, mut counts] = [vec![0.0_f32; cells.count()], vec![0.0_f32; cells.count()]];
    for (pixel, light) in light.iter().enumerate() {
        let cell = cells.of([pixel / size[1], pixel % size[1]], pixel_mm);
        sums[cell] += light;
        counts[cell] += 1.0;
    }
    let darkest = (DARKEST * sums.iter().sum::<f32>() / light.len() as f32).max(f32::MIN_POSITIVE);
    let logs: Vec<f32> =
        sums.iter().zip(&counts).map(|(sum, count)| libm::logf((sum / count.max(1.0)).max(darkest))).collect();
    let mut weights: Vec<f32> = counts.iter().map(|count| count.min(1.0)).collect();
    let mut around_it = Vec::new();
    for _ in 0..ROUNDS {
        around_it = planes(&logs, &weights, cells.size, sigma_mm / cells.side_mm);
        for (cell, weight) in weights.iter_mut().enumerate().filter(|(cell, _)| counts[*cell] > 0.0) {
            *weight = if CLEAR.contains(&libm::expf(logs[cell] - around_it[cell])) { 1.0 } else { 1.0e-3 };
        }
    }
    let lamps: Vec<f32> = around_it.into_iter().map(libm::expf).collect();
    let mut even = Vec::with_capacity(light.len());
    for (pixel, light) in light.iter().enumerate() {
        let (row, col) = (pixel / size[1], pixel % size[1]);
        let place = Vec2::new((col as f32 + 0.5) * pixel_mm[1], (row as f32 + 0.5) * pixel_mm[0]);
        let near = around(cells.size, cells.at(place));
        even.push(light / near.iter().map(|&(cell, weight)| weight * lamps[cell]).sum::<f32>());
    }
    even
}

/// Values at each place of the planes that fit best around it, under a Gaussian of so many places.
fn planes(values: &[f32], weights: &[f32], size: [usize; 2], sigma: f32) -> Vec<f32> {
    let kernel = gaussian(sigma);
    let middle = (kernel.len() / 2) as f32;
    let moments = [0, 1, 2].map(|power| -> Vec<f32> {
        kernel.iter().enumerate().map(|(i, weight)| weight * ((i as f32 - middle) / sigma).powi(power)).collect()
    });
    let moment =
        |data: &[f32], [down, across]: [usize; 2]| filter(data, size, [&moments[down], &moments[across]], Beyond::Zero);
    let [all, down, across, down_down, both, across_across] =
        [[0, 0], [1, 0], [0, 1], [2, 0], [1, 1], [0, 2]].map(|powers| moment(weights, powers));
    let weighted: Vec<f32> = values.iter().zip(weights).map(|(value, weight)| value * weight).collect();
    let sums = [[0, 0], [1, 0], [0, 1]].map(|powers| moment(&weighted, powers));
    let at = |i: usize| {
        let ridge = RIDGE * all[i];
        let matrix = Mat3::from_cols(
            Vec3::new(all[i], down[i], across[i]),
            Vec3::new(down[i], down_down[i] + ridge, both[i]),
            Vec3::new(across[i], both[i], across_across[i] + ridge),
        );
        let seen = Vec3::from_array([0, 1, 2].map(|moment| sums[moment][i]));
        (matrix.inverse() * seen).x
    };
    (0..values.len()).map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lamps that leave half of the light at the edges of a board with rings and a knot: they go, right to the edges,
    /// and rings and knot stay. A plane is exact; a bow of light leaves a twentieth of it, and the knot's rim as much.
    #[test]
    fn lamps_go_to_the_edges_and_wood_stays() {
        let (size, pixel_mm) = ([400, 600], [0.2, 0.2]);
        let place = |i: usize| Vec2::new((i % 600) as f32, (i / 600) as f32) * 0.2;
        let wood = |i: usize| {
            let rings = 1.0 + 0.06 * libm::sinf(3.5 * place(i).x);
            if place(i).distance(Vec2::new(70.0, 40.0)) < 6.0 { 0.5 } else { rings }
        };
        let lamps = |i: usize| {
            let off = (place(i) - Vec2::new(55.0, 40.0)) / 60.0;
            libm::powf(1.0 / (1.0 + off.length_squared()), 1.3) * (1.0 + 0.1 * off.y)
        };
        let light: Vec<f32> = (0..240_000).map(|i| 0.6 * wood(i) * lamps(i)).collect();
        let even = evened(&light, size, pixel_mm, 10.0);
        let offs: Vec<f32> = (0..240_000).map(|i| (even[i] / wood(i) - 1.0).abs()).collect();
        let most = offs.iter().copied().fold(0.0, f32::max);
        let edges = (0..240_000).filter(|i| i % 600 < 20).map(|i| offs[i]).sum::<f32>() / (400.0 * 20.0);
        println!("off by {most:.3} at most, {edges:.3} along an edge; lamps leave {:.2} there", lamps(119_999));
        assert!(lamps(119_999) < 0.5 && most < 0.1 && edges < 0.03, "{most}, {edges}");
    }
}
