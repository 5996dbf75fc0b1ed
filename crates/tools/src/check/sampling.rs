//! Stratified sampling of pixels and objects: the same ones each time, and as many of each class as can be.
//!
//! For each class of the model `N = patches_per_class` pixels are wanted in the whole split. They are shared evenly
//! among the samples that show the class: of S such samples number r, in the order of the tables (shards, then splits,
//! then indices), gets `floor((r+1)N/S) - floor(rN/S)`. In a sample the places are pixels of the class drawn without
//! replacement, each as likely as the others, from the stream seed / "check" / index / class. Only pixels whose window
//! lies inside the image are drawn. So the classes are as frequent as each other unless a sample has too few pixels of
//! one; the report counts what was found.
//!
//! Of objects, where there are more than N of a class, every so-many-th is taken: number g of T where
//! `floor((g+1)N/T) > floor(gN/T)`.

use base::Stream;
use rand::RngExt;

/// How many places of `total` entry number `rank` of `count` gets.
pub(crate) fn even_share(total: u64, rank: u64, count: u64) -> u64 {
    let end = |r: u64| (u128::from(r) * u128::from(total) / u128::from(count.max(1))) as u64;
    end(rank + 1) - end(rank)
}

/// The part of an image in which windows may have their centres: first and end of rows and columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct CentreRegion {
    rows: [usize; 2],
    cols: [usize; 2],
}

impl CentreRegion {
    /// For windows of `window` in images of `image`, both `[rows, columns]`.
    pub fn new(window: [usize; 2], image: [usize; 2]) -> Self {
        // A window of w begins w/2 before its centre.
        let span = |w: usize, n: usize| if w > n { [0, 0] } else { [w / 2, n - w + w / 2 + 1] };
        Self { rows: span(window[0], image[0]), cols: span(window[1], image[1]) }
    }
}

/// Pixels `[row, column]` of each class, `wanted[class]` of them at most, in the order of the image. `classes` says the
/// class of each label value, `stream` is the sample's.
pub(crate) fn draw_pixels(
    labels: &[u8],
    cols: usize,
    inside: CentreRegion,
    classes: &[Option<usize>],
    wanted: &[u64],
    stream: Stream,
) -> Vec<Vec<[usize; 2]>> {
    let class: [Option<usize>; 256] = std::array::from_fn(|label| classes.get(label).copied().flatten());
    let row_of = |row: usize| &labels[row * cols + inside.cols[0]..row * cols + inside.cols[1]];
    // Like labels lie side by side, and a count waits for the one before: neighbours are counted apart.
    let mut by_label = [[0_u64; 256]; 4];
    for row in inside.rows[0]..inside.rows[1] {
        for few in row_of(row).chunks(by_label.len()) {
            few.iter().zip(&mut by_label).for_each(|(&label, counts)| counts[usize::from(label)] += 1);
        }
    }
    let mut counts = vec![0_u64; wanted.len()];
    for (label, class) in class.iter().enumerate() {
        if let Some(class) = class {
            counts[*class] += by_label.iter().map(|counts| counts[label]).sum::<u64>();
        }
    }
    let ranks: Vec<Vec<u64>> =
        (0..wanted.len()).map(|class| draw_ranks(counts[class], wanted[class], stream.index(class as u64))).collect();
    let (mut next, mut seen) = (vec![0; wanted.len()], vec![0_u64; wanted.len()]);
    let mut found = vec![Vec::new(); wanted.len()];
    for row in inside.rows[0]..inside.rows[1] {
        for (i, &label) in row_of(row).iter().enumerate() {
            let Some(class) = class[usize::from(label)] else { continue };
            if ranks[class].get(next[class]) == Some(&seen[class]) {
                found[class].push([row, inside.cols[0] + i]);
                next[class] += 1;
            }
            seen[class] += 1;
        }
    }
    found
}

/// `wanted` different numbers below `count`, each set as likely as any other (Floyd 1987), in order.
fn draw_ranks(count: u64, wanted: u64, stream: Stream) -> Vec<u64> {
    let wanted = wanted.min(count);
    let mut rng = stream.rng();
    let mut chosen = std::collections::BTreeSet::new();
    for j in count - wanted..count {
        let pick = rng.random_range(0..=j);
        if !chosen.insert(pick) {
            chosen.insert(j);
        }
    }
    chosen.into_iter().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Shares add up to what is wanted and differ by one at most.
    #[test]
    fn portions_add_up() {
        for (total, count) in [(1000, 7), (3, 5), (0, 4), (8, 8)] {
            let all: Vec<u64> = (0..count).map(|rank| even_share(total, rank, count)).collect();
            assert_eq!(all.iter().sum::<u64>(), total);
            assert!(all.iter().max().expect("some") - all.iter().min().expect("some") <= 1);
        }
    }

    /// Windows of drawn centres lie inside; a window as large as the image has one centre, a larger one none.
    #[test]
    fn windows_stay_inside() {
        let labels = vec![1; 30 * 20];
        for window in [[1, 1], [4, 3], [5, 20], [30, 20]] {
            let places = draw_pixels(
                &labels,
                20,
                CentreRegion::new(window, [30, 20]),
                &[None, Some(0)],
                &[10_000],
                Stream::root(0),
            );
            let (rows, cols) = (30 - window[0] + 1, 20 - window[1] + 1);
            assert_eq!(places[0].len(), rows * cols, "{window:?}");
            for [row, col] in &places[0] {
                let (first, left) = (row - window[0] / 2, col - window[1] / 2);
                assert!(first + window[0] <= 30 && left + window[1] <= 20);
            }
        }
        for window in [[31, 1], [1, 21], [500, 500]] {
            let places =
                draw_pixels(&labels, 20, CentreRegion::new(window, [30, 20]), &[None, Some(0)], &[9], Stream::root(0));
            assert!(places[0].is_empty(), "{window:?}");
        }
    }

    /// Drawn pixels have the class, are different, are the same each time, and another seed gives others.
    #[test]
    fn draws_are_of_the_class_and_repeat() {
        let labels: Vec<u8> = (0..100 * 100).map(|i| (i % 3) as u8).collect();
        let draw = |seed| {
            let inside = CentreRegion::new([5, 5], [100, 100]);
            draw_pixels(&labels, 100, inside, &[None, Some(1), Some(0)], &[40, 7], Stream::root(seed))
        };
        let found = draw(0);
        assert_eq!((found[0].len(), found[1].len()), (40, 7));
        assert!(found[0].iter().all(|[r, c]| labels[r * 100 + c] == 2));
        assert!(found[1].iter().all(|[r, c]| labels[r * 100 + c] == 1));
        assert!(found[0].is_sorted() && found[0].windows(2).all(|two| two[0] != two[1]));
        assert_eq!(found, draw(0));
        assert_ne!(found, draw(1));
    }

    /// Each of ten is drawn as often as the others: chi-square with 9 degrees of freedom over 3000 draws of 3 stays
    /// below 33.7, which fair draws exceed once in ten thousand seeds; draws without replacement spread less still.
    #[test]
    fn draws_are_fair() {
        let mut hits = [0_u32; 10];
        for seed in 0..3000 {
            draw_ranks(10, 3, Stream::root(seed)).iter().for_each(|&rank| hits[rank as usize] += 1);
        }
        let square: f64 = hits.iter().map(|&h| (f64::from(h) - 900.0).powi(2) / 900.0).sum();
        assert!(square < 33.7, "{hits:?}");
        assert_eq!(draw_ranks(4, 9, Stream::root(0)), [0, 1, 2, 3]);
        assert!(draw_ranks(0, 9, Stream::root(0)).is_empty());
    }
}
