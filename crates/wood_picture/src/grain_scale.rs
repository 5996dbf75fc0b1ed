//! Whether the grain is as wide as wood's at the stated size of pixels.
//!
//! Model: energy of the texture that has a direction, E(s) = s^2 |mean of (gx + i gy)^2| under Gaussians of scale s, is
//! largest at the half width of what is seen (Lindeberg 1998); noise has no direction and drops out. The centre of E
//! over the logarithm of s is held to what boards have. Limits: on pictures that show few pixels a mm the finest scales
//! are missing. Sizes that are wrong by less than the spread of boards pass: a factor of ten is told, two is not.

use crate::PictureFault;
use crate::raster::{Beyond, filter, gaussian, gaussian_slope};

/// Centres of the energy that wood has [mm]: 15 boards of `procedural` had 0.48 to 1.57; twice as much to either side.
const WOOD_MM: [f32; 2] = [0.24, 3.2];

/// The scale at which the grain is strongest [mm].
pub(crate) fn grain_scale(log_light: &[f32], size: [usize; 2], pixel_mm: [f32; 2], clear: &[bool]) -> f32 {
    let long = pixel_mm[0].max(pixel_mm[1]);
    let extent = (size[0] as f32 * pixel_mm[0]).min(size[1] as f32 * pixel_mm[1]);
    let (mut sum, mut logs) = (0.0_f64, 0.0_f64);
    let (mut data, mut size, mut pixel, mut counts) = (log_light.to_vec(), size, pixel_mm, clear.to_vec());
    let mut scale = long;
    while scale < extent / 12.0 {
        // Where pixels are small against the scale, four make one.
        while scale > 3.0 * pixel[0].max(pixel[1]) && size[0].min(size[1]) >= 16 {
            (data, counts, size) = halved(&data, &counts, size);
            pixel = pixel.map(|mm| 2.0 * mm);
        }
        let sigma = pixel.map(|mm| (scale / mm).max(0.9));
        let [smooth_down, smooth_across] = sigma.map(gaussian);
        let [slope_down, slope_across] = sigma.map(gaussian_slope);
        let down = filter(&data, size, [&slope_down, &smooth_across], Beyond::Same);
        let across = filter(&data, size, [&smooth_down, &slope_across], Beyond::Same);
        let (mut re, mut im, mut n) = (0.0_f64, 0.0_f64, 0.0_f64);
        for i in (0..data.len()).filter(|&i| counts[i]) {
            let (gx, gy) = (f64::from(across[i] / pixel[1]), f64::from(down[i] / pixel[0]));
            (re, im, n) = (re + gx * gx - gy * gy, im + 2.0 * gx * gy, n + 1.0);
        }
        let energy = f64::from(scale).powi(2) * libm::hypot(re, im) / n.max(1.0);
        (sum, logs) = (sum + energy, logs + energy * libm::log(f64::from(scale)));
        scale *= std::f32::consts::SQRT_2;
    }
    if sum > 0.0 { libm::exp(logs / sum) as f32 } else { f32::NAN }
}

/// Means of two by two pixels; one counts where all four do.
fn halved(data: &[f32], counts: &[bool], [rows, cols]: [usize; 2]) -> (Vec<f32>, Vec<bool>, [usize; 2]) {
    let size = [rows / 2, cols / 2];
    let four = |i: usize| {
        let corner = 2 * (i / size[1]) * cols + 2 * (i % size[1]);
        [corner, corner + 1, corner + cols, corner + cols + 1]
    };
    let pixels = 0..size[0] * size[1];
    let means = pixels.clone().map(|i| four(i).iter().map(|&j| data[j]).sum::<f32>() / 4.0).collect();
    (means, pixels.map(|i| four(i).iter().all(|&j| counts[j])).collect(), size)
}

/// Refuses grain that is no wood's.
pub(crate) fn check(
    log_light: &[f32],
    size: [usize; 2],
    pixel_mm: [f32; 2],
    clear: &[bool],
) -> Result<(), PictureFault> {
    let found_mm = grain_scale(log_light, size, pixel_mm, clear);
    if (WOOD_MM[0]..=WOOD_MM[1]).contains(&found_mm) {
        return Ok(());
    }
    Err(PictureFault::Scale { found_mm, range_mm: WOOD_MM })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stripes_have_the_scale_of_their_width() {
        let size = [300, 300];
        let stripes = |period: f32| -> Vec<f32> {
            (0..90_000).map(|i| (std::f32::consts::TAU * (i % 300) as f32 / period).sin()).collect()
        };
        for (period, pixel) in [(30.0, 0.1), (40.0, 0.1), (40.0, 0.2)] {
            let found = grain_scale(&stripes(period), size, [pixel; 2], &[true; 90_000]);
            // s^2 exp(-(2 pi s / period)^2) is largest at period / 2 pi; its mean over log s lies exp(-0.29) below
            // (Euler's constant over 2), and steps of sqrt 2 and the ends of the range move that by a fifth.
            let told = pixel * period / std::f32::consts::TAU * libm::expf(-0.29);
            assert!((found / told - 1.0).abs() < 0.2, "period {period} of {pixel} mm: {found} against {told}");
        }
        // Stripes of 4 mm are wood's; ten times as wide or as narrow they are not.
        for (period, pixel, fits) in [(40.0, 0.1, true), (100.0, 0.4, false), (40.0, 0.01, false)] {
            assert_eq!(
                check(&stripes(period), size, [pixel; 2], &[true; 90_000]).is_ok(),
                fits,
                "{period} of {pixel} mm"
            );
        }
    }
}
