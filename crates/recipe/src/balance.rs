//! Balance: which class the i-th sample has, its rank among the samples of that class, and the split of the k-th.
//!
//! **Classes** go by index: sample i stands at the point (offset + i / golden ratio) mod 1 of the shares (Weyl 1916).
//! By Denjoy and Koksma any prefix of n samples holds each class within 2 + log_phi(n) of its share of n.
//!
//! **Splits** go by rank in the class: of the first k samples of a class, floor(k s + phase) are for training where s
//! is their share (Beatty 1926), and of the others as many are for validation as its share of them, in the same way. In
//! any prefix, each split of each class is then within two samples of its share. The phases of the classes are those of
//! a rotation by the golden ratio too, so that what is rounded up in one class is rounded down in another: with random
//! phases twelve classes of a few samples each would all but add up their errors.
//!
//! A rank is counted without walking over the samples before: points of a rotation below a bound are a difference of
//! two sums of floor((a j + b) / m), which fold like Euclid's algorithm (Graham, Knuth and Patashnik, *Concrete
//! Mathematics*, 3.5).
//!
//! **Groups.** Samples that must stay on one side of the splits, because they show one log ([`super::log_group`]), are
//! one unit here: what is said of samples and indices then holds for logs and their numbers.

use base::Stream;
use optical_bench::settings::Splits;
use optical_bench::split::Split;

/// 2^64 over the golden ratio, odd: the step of the rotation.
const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;
/// A whole turn: shares are counted in its parts.
const TURN: u128 = 1 << 64;

/// The classes of a recipe over the indices, for one seed.
pub(super) struct ClassRotation {
    offset: u64,
    /// Where each class ends; the last with a share ends the turn.
    ends: Vec<u128>,
}

impl ClassRotation {
    /// For these shares; `stream` is that of the classes.
    pub(super) fn new(shares: impl Iterator<Item = f64> + Clone, stream: Stream) -> Self {
        let sum: f64 = shares.clone().sum();
        let mut before = 0.0;
        let mut ends: Vec<u128> = shares
            .map(|share| {
                before += share;
                parts(before / sum)
            })
            .collect();
        // Rounding can leave a last crumb, which belongs to the last class.
        if let Some(last) = ends.last_mut() {
            *last = TURN;
        }
        Self { offset: stream.key(), ends }
    }

    /// Number of the class of sample `index`.
    pub(super) fn class(&self, index: u64) -> usize {
        let at = self.offset.wrapping_add(index.wrapping_mul(GOLDEN));
        self.ends.iter().position(|end| u128::from(at) < *end).unwrap_or(0)
    }

    /// Samples of the class `class` among the first `index`.
    pub(super) fn rank(&self, class: usize, index: u64) -> u64 {
        let start = if class == 0 { 0 } else { self.ends[class - 1] };
        (self.below(self.ends[class], index) - self.below(start, index)) as u64
    }

    /// How many of the first `n` points are below `end`.
    fn below(&self, end: u128, n: u64) -> u128 {
        let (n, step, offset) = (u128::from(n), u128::from(GOLDEN), u128::from(self.offset));
        // x mod m < t counts floor(x / m) - floor((x - t) / m); a turn more keeps the second above 0.
        let upper = floor_sum(n, TURN, step, offset);
        upper.wrapping_sub(floor_sum(n, TURN, step, offset + TURN - end)).wrapping_add(n)
    }
}

/// The split of the sample that is the `rank`-th of its class, and how many before it are of each: train, validation,
/// test; `stream` is that of the splits.
pub(super) fn split(splits: Splits, stream: Stream, class: usize, rank: u64) -> (Split, [u64; 3]) {
    let phase = |name| stream.child(name).key().wrapping_add((class as u64).wrapping_mul(GOLDEN));
    let others = splits.validation + splits.test;
    let (is_train, train) = beatty(splits.train / (splits.train + others), phase("train"), rank);
    // Without others all are for training.
    let share = if others > 0.0 { splits.validation / others } else { 0.0 };
    let (is_validation, validation) = beatty(share, phase("validation"), rank - train);
    let split = match (is_train, is_validation) {
        (true, _) => Split::Train,
        (_, true) => Split::Validation,
        _ => Split::Test,
    };
    (split, [train, validation, rank - train - validation])
}

/// Whether the number `k` is of the sequence with this share and this phase, and how many before it are.
fn beatty(share: f64, phase: u64, k: u64) -> (bool, u64) {
    let part = parts(share);
    let reached = u128::from(k) * part + u128::from(phase);
    let (before, rest) = (reached >> 64, reached & (TURN - 1));
    (rest + part >= TURN, before as u64)
}

/// A share in parts of a turn.
fn parts(share: f64) -> u128 {
    ((share * TURN as f64).round() as u128).min(TURN)
}

/// Sum of floor((a j + b) / m) over j below `n`, mod 2^128; n and m are at most 2^64, a n + b at most 2^128.
fn floor_sum(mut n: u128, mut m: u128, mut a: u128, mut b: u128) -> u128 {
    let mut sum = 0u128;
    loop {
        if a >= m {
            let pairs =
                if n.is_multiple_of(2) { (n / 2).wrapping_mul(n.wrapping_sub(1)) } else { n.wrapping_mul(n / 2) };
            sum = sum.wrapping_add(pairs.wrapping_mul(a / m));
            a %= m;
        }
        if b >= m {
            sum = sum.wrapping_add(n.wrapping_mul(b / m));
            b %= m;
        }
        let last = a * n + b;
        if last < m {
            return sum;
        }
        (n, b, m, a) = (last / m, last % m, a, m);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_of_floors_are_those_of_a_loop() {
        for (n, m, a, b) in
            [(0, 7, 3, 2), (1, 7, 3, 2), (50, 7, 3, 20), (1000, 97, 1234, 4321), (333, 1 << 40, 987_654_321, 5)]
        {
            let slow: u128 = (0..n).map(|j| (a * j + b) / m).sum();
            assert_eq!(floor_sum(n, m, a, b), slow, "{n} {m} {a} {b}");
        }
    }

    /// Ranks count what a walk over the samples counts, and go on to the last index there is.
    #[test]
    fn ranks_are_those_of_a_walk() {
        let shares = [0.2, 0.25, 0.2, 0.2, 0.15];
        for seed in 0..4 {
            let rotation = ClassRotation::new(shares.into_iter(), Stream::root(seed));
            let mut seen = [0u64; 5];
            for index in 0..5000 {
                let class = rotation.class(index);
                assert_eq!(rotation.rank(class, index), seen[class], "sample {index}");
                seen[class] += 1;
            }
            let last: Vec<u64> = (0..5).map(|class| rotation.rank(class, u64::MAX)).collect();
            for (rank, share) in last.iter().zip(shares) {
                assert!((*rank as f64 / u64::MAX as f64 - share).abs() < 1e-12, "{last:?}");
            }
            assert_eq!(last.iter().map(|rank| u128::from(*rank)).sum::<u128>(), u128::from(u64::MAX));
        }
    }

    /// Every prefix of a class has each split within two samples of its share; splits without a share have none.
    #[test]
    fn every_prefix_of_a_class_is_split_by_its_shares() {
        for shares in [[0.8, 0.1, 0.1], [0.7, 0.3, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.34, 0.33, 0.33]] {
            let [train, validation, test] = shares;
            for seed in 0..20 {
                let stream = Stream::root(seed).child("split");
                let mut counts = [0.0; 3];
                for rank in 0..2000u64 {
                    let (found, before) = split(Splits { train, validation, test }, stream, 3, rank);
                    assert_eq!(before.map(|count| count as f64), counts, "{shares:?} {rank}");
                    counts[found as usize] += 1.0;
                    for (count, share) in counts.iter().zip(shares) {
                        let far: f64 = count - share * (rank + 1) as f64;
                        assert!(far.abs() < 2.0 && (share > 0.0 || *count == 0.0), "{shares:?} {rank}: {counts:?}");
                    }
                }
                split(Splits { train, validation, test }, stream, 3, u64::MAX);
            }
        }
    }

    /// Twelve classes of few samples each: what the splits miss over all of them is a class's error, not the sum of
    /// twelve.
    #[test]
    fn few_samples_of_many_classes_are_split_by_the_shares() {
        let splits = Splits { train: 0.8, validation: 0.1, test: 0.1 };
        let mut square = 0.0;
        const SEEDS: u64 = 400;
        for seed in 0..SEEDS {
            let root = Stream::root(seed);
            let rotation = ClassRotation::new([1.0; 12].into_iter(), root.child("class"));
            let mut train = 0.0;
            for index in 0..40 {
                let class = rotation.class(index);
                let (found, _) = split(splits, root.child("split"), class, rotation.rank(class, index));
                train += f64::from(found == Split::Train);
            }
            square += (train - 32.0) * (train - 32.0) / SEEDS as f64;
        }
        // Each of twelve random phases would leave the variance of a number that is 1 with the chance of what is
        // rounded: of 40 / 12 samples some 0.4 or 0.2, so that twelve have 0.4 * 0.6 * 8 + 0.2 * 0.8 * 4 = 2.6.
        assert!(square < 0.6 * 2.6, "variance {square}");
    }
}
