//! Rings taken out of a picture, so that what is left are the streaks of fibre bundles.
//!
//! Why: on a sawn face a ring shows as the line in which its layer cuts the face. Fibres lie in the layer but need not
//! run along that line. It turns from their azimuth by up to the dive over the slope of the layer, so on flat-sawn wood
//! a dive of a degree turns rings by five and more, and at the tips of cathedral arches rings cross the fibres. Rings
//! have far more contrast than streaks. Model: the line of the rings is the orientation of the plain structure tensor
//! (scale 0.4 mm, window 0.8 mm). Light is averaged along it, step by step with the line as it turns (line integral
//! convolution, Cabral and Leedom 1993), under a Gaussian of 5 mm, and the mean is taken away. A streak of a fibre's
//! length, 3 mm, stays for the most part, also where it runs along the rings. On boards of `procedural` the median
//! error of clear wood is 1.8 degrees with 3 mm and 1.2 with 6 mm. Limits: streaks of 15 mm and longer along the rings
//! are lost; rings that bend within some mm stay in part.

use glam::Vec2;

use crate::raster::{Beyond, filter, gaussian, gaussian_slope, smooth};
use crate::texture::Cells;

/// Scale of the gradient [mm].
const SCALE_MM: f32 = 0.4;
/// Window of the orientation [mm].
const WINDOW_MM: f32 = 0.8;
/// Step along the line [mm].
const STEP_MM: f32 = 0.7;
/// Standard deviation of the mean along the line [mm].
const ALONG_MM: f32 = 5.0;

/// The logarithm of light less its mean along the rings; `counts` says which pixels are clear wood.
pub(crate) fn without_rings(
    log_light: &[f32],
    size: [usize; 2],
    pixel_mm: [f32; 2],
    cells: &Cells,
    counts: &[bool],
) -> Vec<f32> {
    let lines = lines(log_light, size, pixel_mm, cells, counts);
    let mut left = along_lines(log_light, size, pixel_mm, cells, &lines, counts, [ALONG_MM, STEP_MM]);
    for (pixel, left) in left.iter_mut().enumerate() {
        *left = if counts[pixel] { log_light[pixel] - *left } else { 0.0 };
    }
    left
}

/// Means along lines of those directions (x, y) in cells, under a Gaussian cut at two standard deviations: `lengths`
/// are the standard deviation and the step [mm]. Pixels that do not count end a line and stay 0.
pub(crate) fn along_lines(
    log_light: &[f32],
    size: [usize; 2],
    pixel_mm: [f32; 2],
    cells: &Cells,
    lines: &[Vec2],
    counts: &[bool],
    [sigma_mm, step_mm]: [f32; 2],
) -> Vec<f32> {
    let steps = (2.0 * sigma_mm / step_mm).round() as usize;
    let weights: Vec<f32> = (1..=steps).map(|i| libm::expf(-0.5 * (i as f32 * step_mm / sigma_mm).powi(2))).collect();
    let step = step_mm / Vec2::new(pixel_mm[1], pixel_mm[0]);
    let to_cells = Vec2::new(pixel_mm[1], pixel_mm[0]) / cells.side_mm;
    let last = Vec2::new(size[1] as f32 - 0.5, size[0] as f32 - 0.5);
    let mut means = vec![0.0_f32; log_light.len()];
    for row in 0..size[0] {
        for col in 0..size[1] {
            let pixel = row * size[1] + col;
            if !counts[pixel] {
                continue;
            }
            // Places in pixels, (column, row), with middles at whole numbers and a half.
            let start = Vec2::new(col as f32 + 0.5, row as f32 + 0.5);
            let (mut sum, mut all) = (log_light[pixel], 1.0);
            for end in [1.0, -1.0] {
                let (mut place, mut ahead) = (start, end * lines[cells.of([row, col], pixel_mm)]);
                for weight in &weights {
                    place += ahead * step;
                    if place.cmplt(Vec2::splat(0.5)).any() || place.cmpge(last).any() {
                        break;
                    }
                    if !counts[place.y as usize * size[1] + place.x as usize] {
                        break;
                    }
                    let (c, r) = ((place.x - 0.5) as usize, (place.y - 0.5) as usize);
                    let (u, v) = (place.x - 0.5 - c as f32, place.y - 0.5 - r as f32);
                    let upper = &log_light[r * size[1] + c..][..2];
                    let lower = &log_light[(r + 1) * size[1] + c..][..2];
                    let above = upper[0] + u * (upper[1] - upper[0]);
                    let below = lower[0] + u * (lower[1] - lower[0]);
                    sum += weight * (above + v * (below - above));
                    all += weight;
                    let cell = place * to_cells;
                    let cell = [cell.y as usize, cell.x as usize];
                    let line = lines[cell[0].min(cells.size[0] - 1) * cells.size[1] + cell[1].min(cells.size[1] - 1)];
                    ahead = if line.dot(ahead) < 0.0 { -line } else { line };
                }
            }
            means[pixel] = sum / all;
        }
    }
    means
}

/// Directions of the rings' lines in cells (x, y) [1].
fn lines(log_light: &[f32], size: [usize; 2], pixel_mm: [f32; 2], cells: &Cells, counts: &[bool]) -> Vec<Vec2> {
    let sigma = pixel_mm.map(|pixel| (SCALE_MM / pixel).max(0.9));
    let [smooth_down, smooth_across] = sigma.map(gaussian);
    let [slope_down, slope_across] = sigma.map(gaussian_slope);
    let down = filter(log_light, size, [&slope_down, &smooth_across], Beyond::Same);
    let across = filter(log_light, size, [&smooth_down, &slope_across], Beyond::Same);
    let mut sums = [vec![0.0_f32; cells.count()], vec![0.0_f32; cells.count()]];
    for pixel in (0..log_light.len()).filter(|&pixel| counts[pixel]) {
        let (gx, gy) = (across[pixel] / pixel_mm[1], down[pixel] / pixel_mm[0]);
        let cell = cells.of([pixel / size[1], pixel % size[1]], pixel_mm);
        sums[0][cell] += gx * gx - gy * gy;
        sums[1][cell] -= 2.0 * gx * gy;
    }
    let width = WINDOW_MM / cells.side_mm;
    let [re, im] = sums.map(|sum| smooth(&sum, cells.size, [width; 2], Beyond::Zero));
    re.iter().zip(im).map(|(&re, im)| crate::knots::direction(0.5 * base::atan2(im, re))).collect()
}
