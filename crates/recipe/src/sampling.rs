//! Sampling: how the samples of a class are laid out over the ranges of the keys that are drawn: each by itself, or so
//! that they cover each range evenly in every prefix (low discrepancy).
//!
//! **Model.** For `sampling: low_discrepancy` the r-th sample of a class takes, for each key, the quantile of the key's
//! distribution at the r-th point u of a sequence of its own. The number r is the rank of the sample within its class
//! ([`super::balance`]), the key of the sequence is seed / family / class / path. Any point is computed alone, and a
//! key that is added, fixed or correlated leaves the points of the others as they were. Classes have sequences of their
//! own, since samples of one rank in two classes would else share every number.
//!
//! **Equation.** With S a nested uniform scramble of 64 binary digits, each turned over or not by a hash of the digits
//! above it:
//!
//! ```text
//! u = S_value(reverse(S_order(r)))          (reverse: first digit last, van der Corput 1935)
//! ```
//!
//! Each u is uniform in (0, 1), and of the 2^m points with ranks k 2^m to (k + 1) 2^m - 1 exactly one lies in each of
//! the 2^m equal cells. A prefix of n points is made of as many such blocks as n has binary digits 1, so below any x
//! lie n x points within that number, at most log2(n) + 1; of independent draws it is within some sqrt(n) / 2.
//!
//! **Source.** Nested scrambling: Owen 1995. Sequences of one dimension put together by scrambling the order of each:
//! Burley 2020, *Practical Hash-based Owen Scrambling*; of n = 2^m points that is a Latin hypercube (McKay, Beckman and
//! Conover 1979) whose blocks are Latin hypercubes too.
//!
//! **Why this and nothing with structure between keys.** Recipes draw up to 160 keys, each of which must depend on its
//! own path alone, and data sets hold hundreds of samples. Squared centred discrepancies of the two-dimensional
//! projections of 100 keys over those of independent draws (mean of all pairs, worst pair, each the mean of several
//! scrambles; of this sequence 66 pairs of 12 keys):
//!
//! | sequence | 64 mean | worst | 256 mean | worst |
//! |---|---|---|---|---|
//! | this one | 0.11 | 0.2 | 0.09 | 0.2 |
//! | Latin hypercube | 0.09 | 0.2 | 0.08 | 0.2 |
//! | Sobol', Owen-scrambled, directions of Joe and Kuo 2008 | 0.10 | 1.4 | 0.05 | 1.6 |
//! | Kronecker, R-sequence (Roberts 2018) | 0.6 | 15 | 0.2 | 3 |
//! | Kronecker, a random irrational for each key | 1.0 | 8 | 0.3 | 5 |
//!
//! It is a little behind a Latin hypercube, which has no prefixes: neighbours of rank lie in opposite halves of every
//! key. Sobol' sequences are better in their first dozen dimensions and leave stripes in others; which two keys then
//! miss half of their plane would depend on their places in a table. Here all pairs are alike.
//!
//! **Splits.** Test samples are every tenth of a class, and plain van der Corput points of every tenth rank all lie in
//! one half. S_order prevents that: two samples of a class, with m the highest binary digit in which their ranks
//! differ, have independent first m digits, and if these agree then opposite next ones. They are never nearer to each
//! other than independent draws would be: negatively quadrant dependent, and so is what rises with several such keys
//! (Lehmann 1966). The empirical distribution function of any choice of ranks (a split, a part of a data set, every
//! k-th) thus has at most the variance of independent draws. That is why the tests of laws in `gen validate`, which
//! alarm where numbers are too far from their law, hold here too: they only become blunter.
//!
//! **Limits.** Only single keys are even in every prefix, and of correlated keys, which mix the points of several, only
//! the first. Two keys are a random pairing of even points: better than independent by what each key adds alone, no
//! better in what needs both. A split is no better than independent draws, and the tests of `gen validate` find smaller
//! departures from a law later than their number of samples says.

use base::{Stream, words};

/// The key of a recipe that says it.
pub(super) const SAMPLING: &str = "sampling";
/// What it is about.
pub(super) const SAMPLING_DOC: &str = "\
How samples are laid out over what is drawn: `independent`, or `low_discrepancy`, which covers the range of each key \
evenly \
with the samples of each class.";

words! {
    /// How samples are laid out over the ranges of what is drawn.
    Sampling {
        /// Each sample by itself.
        Independent = "independent",
        /// Evenly over the range of each key, in every prefix of each class.
        LowDiscrepancy = "low_discrepancy",
    }
}

/// Binary digits of a rank, and of a point before it is cut to [`POINT_BITS`].
const BITS: u32 = 64;
/// Binary digits of a point, with half of the last added: neither 0 nor 1 comes out.
const POINT_BITS: u32 = 52;

/// The point of `rank` in the sequence that `stream` names, in (0, 1).
pub(super) fn point(stream: Stream, rank: u64) -> f64 {
    let order = scrambled(stream.child("order"), rank, BITS);
    open_unit(scrambled(stream.child("value"), order.reverse_bits(), POINT_BITS))
}

/// The first 52 binary digits of `word` as a number of (0, 1).
pub(super) fn open_unit(word: u64) -> f64 {
    ((word >> (BITS - POINT_BITS)) as f64 + 0.5) / (1u64 << POINT_BITS) as f64
}

/// `word` with each of its `digits` first binary digits turned over or not, as those above it say; the others as they
/// are.
fn scrambled(stream: Stream, word: u64, digits: u32) -> u64 {
    let mut flips = 0;
    for digit in 0..digits {
        // Nodes of a binary tree, counted from 1 row by row: a word of its own for every prefix of every length.
        let above = if digit == 0 { 0 } else { word >> (BITS - digit) };
        let node = (1 << digit) | above;
        flips |= (stream.index(node).key() >> (BITS - 1)) << (BITS - 1 - digit);
    }
    word ^ flips
}

#[cfg(test)]
mod tests {
    use super::*;
    use exact::{UnitHistogram, binomial, kolmogorov_smirnov};

    fn points(stream: Stream, ranks: impl Iterator<Item = u64>) -> Vec<f64> {
        ranks.map(|rank| point(stream, rank)).collect()
    }

    fn key(seed: u64, name: usize) -> Stream {
        Stream::root(seed).child("sequence").index(name as u64)
    }

    /// Of every aligned block of 2^m ranks each of 2^m cells has one.
    #[test]
    fn every_aligned_block_has_one_point_in_each_cell() {
        for (seed, m, block) in [(0, 1, 77), (1, 4, 0), (2, 6, 3), (3, 8, 1), (4, 10, 0), (5, 3, (1u64 << 61) - 1)] {
            let size = 1u64 << m;
            let mut cells: Vec<u64> = points(key(seed, 0), (0..size).map(|i| block * size + i))
                .iter()
                .map(|u| (u * size as f64) as u64)
                .collect();
            cells.sort_unstable();
            assert!(cells.into_iter().eq(0..size), "block {block} of {size}");
        }
    }

    /// Every prefix has n x points below x, within the number of binary digits 1 of n.
    #[test]
    fn every_prefix_is_balanced() {
        for seed in 0..20 {
            let all = points(key(seed, 1), 0..2000);
            for edge in [0.03, 0.25, 0.5, 0.618, 0.97] {
                let mut below = 0u32;
                for (n, u) in (1u32..).zip(&all) {
                    below += u32::from(*u < edge);
                    let far = (f64::from(below) - f64::from(n) * edge).abs();
                    assert!(far <= f64::from(n.count_ones()), "{far} of {n} below {edge}");
                }
            }
        }
    }

    /// A point is a function of its key and rank alone, in (0, 1) up to the last rank there is.
    #[test]
    fn points_stand_alone() {
        let key = key(3, 5);
        let forwards = points(key, 0..300);
        let mut backwards = points(key, (0..300).rev());
        backwards.reverse();
        assert_eq!(forwards, backwards);
        for rank in [0, 1, u64::MAX - 1, u64::MAX] {
            let u = point(key, rank);
            assert!(0.0 < u && u < 1.0, "{u}");
        }
        assert!(0.0 < open_unit(0) && open_unit(u64::MAX) < 1.0);
    }

    /// Every single point is uniform over the seeds, whatever its rank.
    #[test]
    fn a_point_is_uniform_over_the_seeds() {
        for rank in [0, 1, 6, 1000] {
            let mut histogram = UnitHistogram::default();
            (0..4000).for_each(|seed| histogram.add(point(key(seed, 2), rank)));
            let p = kolmogorov_smirnov(4000, histogram.distance());
            assert!(p > 1e-5, "rank {rank}: chance {p:e}");
        }
    }

    /// Squared centred discrepancy of points in the plane (Hickernell 1998).
    fn centred(points: &[[f64; 2]]) -> f64 {
        let n = points.len() as f64;
        let far = |x: f64| (x - 0.5).abs();
        let alone = |p: &[f64; 2]| p.iter().map(|x| 1.0 + 0.5 * far(*x) - 0.5 * far(*x) * far(*x)).product::<f64>();
        let both = |p: &[f64; 2], q: &[f64; 2]| {
            let one = |x: f64, y: f64| 1.0 + 0.5 * (far(x) + far(y) - (x - y).abs());
            one(p[0], q[0]) * one(p[1], q[1])
        };
        let pairs: f64 = points.iter().map(|p| points.iter().map(|q| both(p, q)).sum::<f64>()).sum();
        (13.0f64 / 12.0).powi(2) - 2.0 / n * points.iter().map(alone).sum::<f64>() + pairs / (n * n)
    }

    /// Of independent draws its mean is ((5/4)^2 - (13/12)^2) / n. All 66 pairs of 12 keys stay below it on the mean of
    /// the seeds, the mean of all pairs below a fifth of it.
    #[test]
    fn pairs_of_keys_fill_their_plane_better_than_independent_draws() {
        const KEYS: usize = 12;
        const SEEDS: u64 = 10;
        const PLANES: usize = 6;
        for n in [64u64, 256] {
            let independent = (25.0 / 16.0 - 169.0 / 144.0) / n as f64;
            let (mut worst, mut sum, mut single, mut pairs) = (0.0f64, 0.0, 0.0f64, 0.0);
            let mut of_pairs = vec![0.0; KEYS * KEYS];
            let mut drawn = 0.0;
            for seed in 0..SEEDS {
                let keys: Vec<_> = (0..KEYS).map(|name| points(key(seed, name), 0..n)).collect();
                for a in 0..KEYS {
                    for b in 0..a {
                        let plane: Vec<_> = keys[a].iter().zip(&keys[b]).map(|(x, y)| [*x, *y]).collect();
                        let ratio = centred(&plane) / independent;
                        of_pairs[a * KEYS + b] += ratio / SEEDS as f64;
                        single = single.max(ratio);
                        sum += ratio;
                        pairs += 1.0;
                    }
                }
                let free = |name: usize, i: u64| open_unit(key(seed, name).child("free").index(i).key());
                for pair in 0..PLANES {
                    let plane: Vec<_> = (0..n).map(|i| [free(2 * pair, i), free(2 * pair + 1, i)]).collect();
                    drawn += centred(&plane) / independent / (SEEDS * PLANES as u64) as f64;
                }
            }
            worst = of_pairs.iter().fold(worst, |worst, ratio| worst.max(*ratio));
            println!(
                "n {n}: mean {:.3}, worst pair {worst:.3}, worst plane {single:.3}; drawn {drawn:.2}",
                sum / pairs
            );
            assert!(worst < 0.4 && sum / pairs < 0.2, "n {n}: worst {worst}, mean {}", sum / pairs);
            // One plane of independent draws has a relative standard deviation of about 0.6.
            assert!((drawn - 1.0).abs() < 4.0 * 0.6 / ((SEEDS * PLANES as u64) as f64).sqrt(), "{drawn}");
        }
    }

    /// Whether a rank is one of a choice.
    type ChosenRank = fn(u64) -> bool;

    /// What is chosen by rank follows the law as well as independent draws: every second, tenth and sixteenth, blocks
    /// of 16 of every 32, and blocks of 5 of 40. Plain van der Corput points of every tenth rank lie in one half.
    #[test]
    fn choices_by_rank_follow_the_law() {
        let choices: [(&str, ChosenRank); 5] = [
            ("every second", |rank| rank % 2 == 1),
            ("every tenth", |rank| rank % 10 == 3),
            ("every sixteenth", |rank| rank % 16 == 5),
            ("blocks of 16", |rank| rank / 16 % 2 == 0),
            ("blocks of 5", |rank| rank / 5 % 8 == 7),
        ];
        for (name, chosen) in choices {
            let (mut low, mut samples) = (0, 0);
            for seed in 0..200 {
                let some = points(key(seed, 0), (0..1600).filter(|rank| chosen(*rank)));
                let mut histogram = UnitHistogram::default();
                some.iter().for_each(|u| histogram.add(*u));
                let p = kolmogorov_smirnov(histogram.samples(), histogram.distance());
                // 1000 tests, each wrong with this chance at most.
                assert!(p > 1e-8, "{name}, seed {seed}: chance {p:e}");
                low += some.iter().filter(|u| **u < 0.5).count() as u64;
                samples += histogram.samples();
            }
            assert!(binomial(samples, low, 0.5) > 1e-6, "{name}: {low} of {samples} are in the lower half");
        }
    }
}
