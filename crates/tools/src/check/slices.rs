//! Sliced evaluation: accuracy by a number of the sample, such as knot width, film pigment or exposure.
//!
//! Samples are sorted by the number and cut at its quantiles into groups of like size; samples with the same number
//! stay together, so a number with few values has fewer groups. Samples without the number, or without what it
//! describes, are a group of their own.

use super::accuracy::Accuracy;

/// Groups where the number has enough values.
pub(crate) const MAX_GROUPS: usize = 4;

/// One sample in a slice.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SlicePoint {
    /// The number; NaN where there is none.
    pub value: f64,
    /// Right guesses.
    pub right: u64,
    /// Guesses.
    pub of: u64,
}

/// Samples of like number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SliceGroup {
    /// Smallest and largest number; `None` where there is none.
    pub span: Option<[f64; 2]>,
    /// Their guesses.
    pub share: Accuracy,
}

/// The groups of `points`, by number, those without one last.
pub(crate) fn group_by_quantiles(points: &[SlicePoint]) -> Vec<SliceGroup> {
    let mut known: Vec<SlicePoint> = points.iter().filter(|p| p.of > 0 && !p.value.is_nan()).copied().collect();
    known.sort_by(|a, b| a.value.total_cmp(&b.value));
    let mut found: Vec<SliceGroup> = Vec::new();
    let mut begin = 0;
    for group in 1..=MAX_GROUPS {
        let mut end = (known.len() * group / MAX_GROUPS).max(begin);
        // The same number is never cut in two.
        while end > begin && end < known.len() && known[end].value == known[end - 1].value {
            end += 1;
        }
        if end > begin {
            let mut share = Accuracy::default();
            known[begin..end].iter().for_each(|p| share.add(p.right, p.of));
            found.push(SliceGroup { span: Some([known[begin].value, known[end - 1].value]), share });
        }
        begin = end;
    }
    let mut without = Accuracy::default();
    points.iter().filter(|p| p.value.is_nan()).for_each(|p| without.add(p.right, p.of));
    if without.of > 0 {
        found.push(SliceGroup { span: None, share: without });
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(value: f64, right: u64, of: u64) -> SlicePoint {
        SlicePoint { value, right, of }
    }

    /// Eight numbers are four groups of two; what is right in each is what was put there.
    #[test]
    fn quartiles_hold_as_many() {
        let points: Vec<_> = (0..8).rev().map(|i| point(f64::from(i), u64::from(i >= 4), 1)).collect();
        let found = group_by_quantiles(&points);
        let spans: Vec<_> = found.iter().map(|g| g.span.expect("numbers")).collect();
        assert_eq!(spans, [[0.0, 1.0], [2.0, 3.0], [4.0, 5.0], [6.0, 7.0]]);
        let rights: Vec<_> = found.iter().map(|g| (g.share.right, g.share.of)).collect();
        assert_eq!(rights, [(0, 2), (0, 2), (2, 2), (2, 2)]);
    }

    /// Equal numbers stay together, a constant is one group, and missing numbers are told apart.
    #[test]
    fn ties_and_gaps() {
        let tied: Vec<_> = [1.0, 1.0, 1.0, 1.0, 1.0, 2.0, 2.0, 9.0].map(|v| point(v, 1, 2)).to_vec();
        let spans: Vec<_> = group_by_quantiles(&tied).iter().map(|g| (g.span, g.share.samples)).collect();
        assert_eq!(spans, [(Some([1.0, 1.0]), 5), (Some([2.0, 2.0]), 2), (Some([9.0, 9.0]), 1)]);
        let gaps = group_by_quantiles(&[point(f64::NAN, 1, 3), point(5.0, 2, 2), point(5.0, 0, 2), point(6.0, 0, 0)]);
        assert_eq!(
            gaps.iter().map(|g| (g.span, g.share.right, g.share.of)).collect::<Vec<_>>(),
            [(Some([5.0, 5.0]), 2, 4), (None, 1, 3)]
        );
        assert!(group_by_quantiles(&[]).is_empty());
    }
}
