//! COCO run-length encoding of masks: column after column, zeros first, and the string that packs the runs.

use super::sample::Region;

/// Lengths of runs of zeros and ones in turn, beginning with zeros [px].
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct RunLengthMask(Vec<u32>);

impl RunLengthMask {
    /// The mask of a picture of `rows` x `cols` that is 0 outside `bbox` and `is_set(row, col)` inside.
    pub fn of(rows: usize, cols: usize, bbox: Region, is_set: impl Fn(usize, usize) -> bool) -> Self {
        let Region { top, left, rows: height, cols: width } = bbox;
        let mut runs = Self(vec![0]);
        let mut at = 0;
        for col in left..left + width {
            runs.push(false, col * rows + top - at);
            for row in top..top + height {
                runs.push(is_set(row, col), 1);
            }
            at = col * rows + top + height;
        }
        runs.push(false, rows * cols - at);
        runs
    }

    fn push(&mut self, set: bool, length: usize) {
        if length == 0 {
            return;
        }
        let length = length as u32;
        // Runs of ones have odd places.
        let is_ones = self.0.len().is_multiple_of(2);
        match self.0.last_mut() {
            Some(last) if is_ones == set => *last += length,
            _ => self.0.push(length),
        }
    }

    /// The lengths.
    pub fn counts(&self) -> &[u32] {
        &self.0
    }

    /// Pixels that are set [px].
    pub fn area(&self) -> u64 {
        self.0.iter().skip(1).step_by(2).map(|&n| u64::from(n)).sum()
    }

    /// The lengths in COCO's packed form: from the fourth on as differences to the last but one, each in groups of five
    /// bits from the lowest, a sixth bit says that more follow, and 48 makes letters of them.
    pub(crate) fn packed(&self) -> String {
        let mut text = String::new();
        for (i, &count) in self.0.iter().enumerate() {
            let before = if i > 2 { i64::from(self.0[i - 2]) } else { 0 };
            let mut rest = i64::from(count) - before;
            loop {
                let group = rest & 0x1f;
                rest >>= 5;
                // Whoever reads takes the highest bit of the last group for the sign.
                let ends = if group & 0x10 == 0 { rest == 0 } else { rest == -1 };
                text.push(char::from(48 + group as u8 + if ends { 0 } else { 0x20 }));
                if ends {
                    break;
                }
            }
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bbox(left: usize, top: usize, cols: usize, rows: usize) -> Region {
        Region { top, left, rows, cols }
    }

    /// Runs by hand: columns first, zeros first, whatever touches the edges.
    #[test]
    fn runs_go_down_the_columns() {
        // 0 1 1
        // 0 1 0
        let mask = [[false, true, true], [false, true, false]];
        let runs = |bbox| RunLengthMask::of(2, 3, bbox, |row, col| mask[row][col]);
        assert_eq!((runs(bbox(0, 0, 3, 2)).counts(), runs(bbox(1, 0, 2, 2))), (&[2, 3, 1][..], runs(bbox(0, 0, 3, 2))));
        assert_eq!(RunLengthMask::of(2, 2, bbox(0, 0, 2, 2), |_, _| true).counts(), [0, 4]);
        assert_eq!(
            (RunLengthMask::of(2, 2, bbox(0, 1, 1, 1), |_, _| true).counts(), runs(bbox(0, 0, 3, 2)).area()),
            (&[1, 1, 2][..], 3)
        );
    }

    /// As pycocotools 2.0.11 packs the same runs.
    #[test]
    fn packing_is_that_of_the_tools() {
        assert_eq!(RunLengthMask(vec![2, 3, 1]).packed(), "231");
        assert_eq!(RunLengthMask(vec![6, 1, 40, 4, 5, 4, 5, 4, 21]).packed(), "61X13mN000`0");
    }
}
