//! Stratified selection of the samples that the page shows: as many of each class as of any other, evenly spaced.

/// How many samples of each class are shown, of `most` in all; `counts` are the samples that each has.
pub(super) fn quotas(counts: &[u64], most: u64) -> Vec<u64> {
    let mut quotas = vec![0; counts.len()];
    let mut left = most.min(counts.iter().sum());
    while left > 0 {
        for (quota, &count) in quotas.iter_mut().zip(counts) {
            if left > 0 && *quota < count {
                *quota += 1;
                left -= 1;
            }
        }
    }
    quotas
}

/// Whether number `rank` of `count` samples is among `quota` of them in even steps.
pub(super) fn is_shown(rank: u64, count: u64, quota: u64) -> bool {
    let place = |j: u64| (2 * u128::from(j) + 1) * u128::from(count) / (2 * u128::from(quota.max(1)));
    let guess = (u128::from(rank) * u128::from(quota) / u128::from(count.max(1))) as u64;
    (guess.saturating_sub(1)..=guess + 1).any(|j| j < quota && place(j) == u128::from(rank))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every class gets as many as the others or all that it has, and as many ranks are shown as were promised.
    #[test]
    fn each_class_has_its_share() {
        assert_eq!(quotas(&[100, 2, 50, 0], 14), [6, 2, 6, 0]);
        assert_eq!(quotas(&[3, 1], 24), [3, 1]);
        assert_eq!(quotas(&[], 24), Vec::<u64>::new());
        for (count, quota) in [(1, 1), (7, 3), (100, 24), (24, 24), (1000, 7)] {
            let shown = (0..count).filter(|&rank| is_shown(rank, count, quota)).count();
            assert_eq!(shown as u64, quota, "{quota} of {count}");
        }
    }
}
