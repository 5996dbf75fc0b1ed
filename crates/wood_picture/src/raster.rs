//! Filters and samples on rasters `[rows, cols]`, row-major.
//!
//! Model: separable Gaussians sampled at pixels, cut at four standard deviations, whose weights sum to 1; the
//! derivative of a Gaussian, normalised so that a ramp keeps its slope. Limits: below 0.8 pixels a sampled derivative
//! turns directions.

use multiversion::multiversion;

/// Kernels reach this many standard deviations [1]: 6e-5 of the weight lies beyond.
const REACH: f32 = 4.0;

/// What lies beyond the border of a raster.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Beyond {
    /// The pixel at the border again.
    Same,
    /// Nothing.
    Zero,
}

/// Weights of a Gaussian of that standard deviation [pixel].
pub(crate) fn gaussian(sigma: f32) -> Vec<f32> {
    let reach = (REACH * sigma).ceil().max(0.0) as i32;
    let weight = |i: i32| if sigma > 0.0 { libm::expf(-0.5 * (i as f32 / sigma).powi(2)) } else { 1.0 };
    let sum: f32 = (-reach..=reach).map(weight).sum();
    (-reach..=reach).map(|i| weight(i) / sum).collect()
}

/// Weights whose sum with the pixels is the slope of the smoothed raster [pixel^-1].
pub(crate) fn gaussian_slope(sigma: f32) -> Vec<f32> {
    let reach = (REACH * sigma).ceil() as i32;
    let weight = |i: i32| i as f32 * libm::expf(-0.5 * (i as f32 / sigma).powi(2));
    let sum: f32 = (-reach..=reach).map(|i| i as f32 * weight(i)).sum();
    (-reach..=reach).map(|i| weight(i) / sum).collect()
}

/// Weighted sums along the rows of the raster, then along its columns: `kernels` for the change of row and of column.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
pub(crate) fn filter(data: &[f32], [rows, cols]: [usize; 2], kernels: [&[f32]; 2], beyond: Beyond) -> Vec<f32> {
    let [down, along] = kernels.map(|kernel| (kernel, kernel.len() / 2));
    let mut padded = vec![0.0_f32; cols + 2 * along.1];
    // Of the sums along rows only those are kept that the kernel down the columns still reaches, in turn.
    let kept = down.0.len().min(rows);
    let mut across = vec![0.0_f32; kept * cols];
    let mut sum_along = |row: usize, out: &mut [f32]| {
        let line = &data[row * cols..(row + 1) * cols];
        let (first, last) = match beyond {
            Beyond::Same => (line[0], line[cols - 1]),
            Beyond::Zero => (0.0, 0.0),
        };
        padded[..along.1].fill(first);
        padded[along.1..along.1 + cols].copy_from_slice(line);
        padded[along.1 + cols..].fill(last);
        out.fill(0.0);
        for (tap, &weight) in along.0.iter().enumerate() {
            for (sum, &value) in out.iter_mut().zip(&padded[tap..]) {
                *sum += weight * value;
            }
        }
    };
    let mut filtered = vec![0.0_f32; rows * cols];
    let mut ahead = 0;
    for row in 0..rows {
        while ahead < rows && ahead <= row + down.1 {
            sum_along(ahead, &mut across[ahead % kept * cols..][..cols]);
            ahead += 1;
        }
        let out = &mut filtered[row * cols..(row + 1) * cols];
        for (tap, &weight) in down.0.iter().enumerate() {
            let at = row as isize + tap as isize - down.1 as isize;
            if beyond == Beyond::Zero && !(0..rows as isize).contains(&at) {
                continue;
            }
            let at = at.clamp(0, rows as isize - 1) as usize;
            for (sum, &value) in out.iter_mut().zip(&across[at % kept * cols..][..cols]) {
                *sum += weight * value;
            }
        }
    }
    filtered
}

/// The raster under a Gaussian of those standard deviations, down and across [pixel].
pub(crate) fn smooth(data: &[f32], size: [usize; 2], sigma: [f32; 2], beyond: Beyond) -> Vec<f32> {
    let [down, along] = sigma.map(gaussian);
    filter(data, size, [&down, &along], beyond)
}

/// Four pixels around a place and their weights: `at` is (row, column), pixel centres are whole numbers.
pub(crate) fn around([rows, cols]: [usize; 2], at: [f32; 2]) -> [(usize, f32); 4] {
    let split = |p: f32, count: usize| {
        let p = p.clamp(0.0, (count - 1) as f32);
        let low = (p as usize).min(count.saturating_sub(2));
        (low, (low + 1).min(count - 1), p - low as f32)
    };
    let ((r0, r1, v), (c0, c1, u)) = (split(at[0], rows), split(at[1], cols));
    [
        (r0 * cols + c0, (1.0 - v) * (1.0 - u)),
        (r0 * cols + c1, (1.0 - v) * u),
        (r1 * cols + c0, v * (1.0 - u)),
        (r1 * cols + c1, v * u),
    ]
}

/// The value at a part of a raster's sorted values; it is sorted in the way [1].
pub(crate) fn quantile(values: &mut [f32], part: f32) -> f32 {
    let at = ((values.len() - 1) as f32 * part).round() as usize;
    *values.select_nth_unstable_by(at, f32::total_cmp).1
}

/// The same of values that stay as they are: counted by the upper half of their bits, then by the lower one.
pub(crate) fn quantile_of(values: &[f32], part: f32) -> f32 {
    // Numbers in the order of `f32::total_cmp`, and back.
    let key = |value: f32| {
        let bits = value.to_bits();
        if bits >> 31 == 1 { !bits } else { bits | 1 << 31 }
    };
    let mut before = ((values.len() - 1) as f32 * part).round() as usize;
    let mut found = 0_u32;
    for half in [16, 0] {
        let mut counts = vec![0_usize; 1 << 16];
        for key in values.iter().map(|&value| key(value)) {
            if half == 16 || key >> 16 == found >> 16 {
                counts[(key >> half) as usize & 0xffff] += 1;
            }
        }
        let mut bin = 0;
        while counts[bin] <= before {
            before -= counts[bin];
            bin += 1;
        }
        found |= (bin as u32) << half;
    }
    f32::from_bits(if found >> 31 == 1 { found & !(1 << 31) } else { !found })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ramp_keeps_its_slope_and_a_constant_its_value() {
        let size = [40, 50];
        let ramp: Vec<f32> = (0..2000).map(|i| 0.3 * (i % 50) as f32 - 0.2 * (i / 50) as f32).collect();
        let (g, d) = (gaussian(1.7), gaussian_slope(1.7));
        let middle = 20 * 50 + 25;
        assert!((filter(&ramp, size, [&g, &d], Beyond::Same)[middle] - 0.3).abs() < 1.0e-5);
        assert!((filter(&ramp, size, [&d, &g], Beyond::Same)[middle] + 0.2).abs() < 1.0e-5);
        let smoothed = smooth(&[2.0; 2000], size, [3.0, 0.0], Beyond::Same);
        assert!(smoothed.iter().all(|v| (v - 2.0).abs() < 1.0e-5));
    }

    /// Kernels that are longer than the raster, and shorter: the rows that are kept are those of all rows.
    #[test]
    fn rows_that_are_kept_in_turn_are_those_of_all() {
        for (size, sigma) in [([7, 9], 0.4), ([7, 9], 3.0), ([40, 5], 1.2), ([1, 6], 2.0)] {
            let data: Vec<f32> = (0..size[0] * size[1]).map(|i| ((i * 37) % 101) as f32 - 50.0).collect();
            let kernel = gaussian(sigma);
            let reach = (kernel.len() / 2) as isize;
            for beyond in [Beyond::Same, Beyond::Zero] {
                let along = filter(&data, size, [&[1.0], &kernel], beyond);
                let wanted: Vec<f32> = (0..data.len())
                    .map(|i| {
                        let [row, col] = [i / size[1], i % size[1]];
                        let mut sum = 0.0;
                        for (tap, weight) in kernel.iter().enumerate() {
                            let at = row as isize + tap as isize - reach;
                            let near = at.clamp(0, size[0] as isize - 1);
                            if beyond == Beyond::Same || near == at {
                                sum += weight * along[near as usize * size[1] + col];
                            }
                        }
                        sum
                    })
                    .collect();
                assert_eq!(filter(&data, size, [&kernel, &kernel], beyond), wanted, "{size:?} {sigma} {beyond:?}");
            }
        }
    }

    /// Values that are counted give the value that sorting gives, bit for bit.
    #[test]
    fn a_quantile_needs_no_sorting() {
        let mut values: Vec<f32> = (0..999_u32).map(|i| f32::from_bits(i.wrapping_mul(2_654_435_761))).collect();
        values.extend([0.0, -0.0, 1.0, 1.0, 1.0, f32::INFINITY, -3.5e-40]);
        for length in [1, 2, 17, values.len()] {
            for part in [0.0, 0.05, 0.5, 0.73, 0.95, 1.0] {
                let sorted = quantile(&mut values[..length].to_vec(), part);
                assert_eq!(quantile_of(&values[..length], part).to_bits(), sorted.to_bits(), "{length} {part}");
            }
        }
    }

    #[test]
    fn samples_lie_on_planes() {
        let plane = |r: f32, c: f32| 2.0 * r - c;
        let raster: Vec<f32> = (0..12).map(|i| plane((i / 4) as f32, (i % 4) as f32)).collect();
        for (r, c) in [(0.0, 0.0), (1.3, 2.9), (2.0, 3.0), (0.5, 0.1)] {
            let value: f32 = around([3, 4], [r, c]).iter().map(|&(i, w)| w * raster[i]).sum();
            assert!((value - plane(r, c)).abs() < 1.0e-5);
        }
    }
}
