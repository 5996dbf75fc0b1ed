//! Patches of one class in a raster of classes, each with a number.
//!
//! Model: pixels that share a side and a class are one patch; clear wood is none. Patches are numbered by their first
//! pixel, row by row.

use base::Class;

/// A patch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Patch {
    /// What it is.
    pub class: Class,
    /// Sums of its pixels' rows and columns.
    sums: [f64; 2],
    /// First and last row, first and last column.
    pub rows: [usize; 2],
    pub cols: [usize; 2],
    count: f64,
}

impl Patch {
    /// Middle of its pixels, row and column.
    pub fn middle(&self) -> [f64; 2] {
        self.sums.map(|sum| sum / self.count)
    }
}

/// Pixels that are reached from the first over sides that they share; `take` says whether a pixel belongs to them and
/// is new, and notes it; the first is the caller's to note.
pub(crate) fn flood(first: usize, [rows, cols]: [usize; 2], mut take: impl FnMut(usize) -> bool) -> Vec<usize> {
    let (mut reached, mut next) = (vec![first], 0);
    while next < reached.len() {
        let (row, col) = (reached[next] / cols, reached[next] % cols);
        next += 1;
        for (r, c) in [(row.wrapping_sub(1), col), (row + 1, col), (row, col.wrapping_sub(1)), (row, col + 1)] {
            if r < rows && c < cols && take(r * cols + c) {
                reached.push(r * cols + c);
            }
        }
    }
    reached
}

/// Number of the patch of every pixel, 0 in clear wood, and the patches from number 1 on.
pub(crate) fn patches(classes: &[Class], [rows, cols]: [usize; 2]) -> (Vec<u32>, Vec<Patch>) {
    let mut numbers = vec![0_u32; rows * cols];
    let mut found: Vec<Patch> = Vec::new();
    for first in 0..rows * cols {
        let class = classes[first];
        if class == Class::Clear || numbers[first] > 0 {
            continue;
        }
        let number = found.len() as u32 + 1;
        let mut patch = Patch { class, sums: [0.0; 2], rows: [rows, 0], cols: [cols, 0], count: 0.0 };
        numbers[first] = number;
        let pixels = flood(first, [rows, cols], |next| {
            let is_new = numbers[next] == 0 && classes[next] == class;
            numbers[next] = if is_new { number } else { numbers[next] };
            is_new
        });
        for pixel in pixels {
            let (row, col) = (pixel / cols, pixel % cols);
            patch.sums[0] += row as f64;
            patch.sums[1] += col as f64;
            patch.count += 1.0;
            patch.rows = [patch.rows[0].min(row), patch.rows[1].max(row)];
            patch.cols = [patch.cols[0].min(col), patch.cols[1].max(col)];
        }
        found.push(patch);
    }
    (numbers, found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patches_share_sides_and_a_class() {
        let (o, k, d) = (Class::Clear, Class::SoundKnot, Class::DeadKnot);
        let classes = [o, k, k, o, k, o, k, d, d, o, o, k];
        let (numbers, found) = patches(&classes, [3, 4]);
        assert_eq!(numbers, [0, 1, 1, 0, 2, 0, 1, 3, 4, 0, 0, 5]);
        assert_eq!(found.iter().map(|patch| patch.class).collect::<Vec<_>>(), [k, k, d, d, k]);
        assert_eq!((found[0].rows, found[0].cols), ([0, 1], [1, 2]));
        let [row, col] = found[0].middle();
        assert!((row - 1.0 / 3.0).abs() < 1e-12 && (col - 5.0 / 3.0).abs() < 1e-12);
    }
}
