//! What the whole numbers of Range leave of it, so that tables and EXR files give it to the last bit together.
//!
//! A sensor reads steps of rows, and a column sees the same step at the same height, profile after profile: a number
//! has left as much before. So what a column's number leaves is written where it is new, and 0 where it is not: of ten
//! million pixels of noise a few hundred thousand remain.

use multiversion::multiversion;

use crate::png::{HEIGHT_STEPS, range_numbers, range_value, stepped};

/// What is written for a height that is its number's.
const NONE_LEFT: f32 = 32768.0;
/// Columns that are looked at together: what their numbers have left fits a cache.
const TILE: usize = 16;

/// What the numbers of some columns have left when they were last seen, 0 for those that were not.
struct LeftBefore {
    lowest: u16,
    numbers: usize,
    left: Vec<u16>,
}

impl LeftBefore {
    /// For images of these numbers.
    fn of(numbers: impl Iterator<Item = u16> + Clone) -> Self {
        let seen = numbers.filter(|&number| number > 0);
        let (lowest, highest) = (seen.clone().min().unwrap_or(1), seen.max().unwrap_or(1));
        let numbers = usize::from(highest - lowest) + 1;
        Self { lowest, numbers, left: vec![0; TILE * numbers] }
    }

    fn at(&mut self, column: usize, number: u16) -> &mut u16 {
        &mut self.left[column % TILE * self.numbers + usize::from(number - self.lowest)]
    }
}

/// Calls `of` with each pixel of images of `cols` columns, those of a column from the top, and what its numbers have
/// left; a number of 0 is missing.
fn each_pixel(numbers: &[u16], cols: usize, mut of: impl FnMut(usize, &mut u16)) {
    let mut before = LeftBefore::of(numbers.iter().copied());
    for first in (0..cols).step_by(TILE) {
        before.left.fill(0);
        for row in (0..numbers.len()).step_by(cols) {
            for column in first..cols.min(first + TILE) {
                let number = numbers[row + column];
                if number > 0 {
                    of(row + column, before.at(column, number));
                }
            }
        }
    }
}

/// What the numbers of heights `[rows, cols]` leave of these, row-major: 2^15 and steps of 2^-13 mm or px more or less;
/// 0 where the same number has left as much before, higher up in its column, and where nothing is measured. `offset`
/// and `scale` as of [`crate::range_numbers`].
///
/// # Panics
/// Where the heights are not whole rows of `cols`.
pub(crate) fn range_rest(range: &[f32], cols: usize, offset: f64, scale: f64) -> Vec<f32> {
    assert!(cols > 0 && range.len().is_multiple_of(cols), "{} heights are not whole rows of {cols}", range.len());
    let numbers = range_numbers(range, offset, scale);
    let mut rest = vec![0.0; range.len()];
    leave(range, &numbers, offset, scale, &mut rest);
    each_pixel(&numbers, cols, |pixel, before| {
        let left = rest[pixel] as u16;
        if left == *before {
            rest[pixel] = 0.0;
        }
        *before = left;
    });
    rest
}

/// What each number leaves; 0 where it is missing.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn leave(range: &[f32], numbers: &[u16], offset: f64, scale: f64, rest: &mut [f32]) {
    for ((rest, &z), &number) in rest.iter_mut().zip(range).zip(numbers) {
        // Both heights are whole steps, and near each other: their difference is exact.
        let steps = HEIGHT_STEPS * (stepped(z) - range_value(number, offset, scale));
        *rest = if number == 0 { 0.0 } else { (NONE_LEFT + steps).clamp(1.0, f32::from(u16::MAX)) };
    }
}

/// Heights `[rows, cols]` to the last bit that files keep, out of their numbers and what these leave; NaN where missing
/// [mm or px].
///
/// # Errors
/// Where these are not as many as numbers, or not whole rows of `cols`.
pub fn range_joined(numbers: &[u16], rest: &[f32], cols: usize, offset: f64, scale: f64) -> Result<Vec<f32>, String> {
    if cols == 0 || !numbers.len().is_multiple_of(cols) || numbers.len() != rest.len() {
        return Err(format!("{} numbers of Range and {} rests are no rows of {cols}", numbers.len(), rest.len()));
    }
    let mut range = vec![f32::NAN; numbers.len()];
    each_pixel(numbers, cols, |pixel, before| {
        if rest[pixel] > 0.0 {
            *before = rest[pixel] as u16;
        }
        range[pixel] = range_value(numbers[pixel], offset, scale) + (f32::from(*before) - NONE_LEFT) / HEIGHT_STEPS;
    });
    Ok(range)
}
