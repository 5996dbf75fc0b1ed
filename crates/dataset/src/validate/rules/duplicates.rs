//! Duplicates, found in one search: samples that are there twice: identical maps, or maps that share their noise.
//! Warnings of datasets of which no row is exposed again: a copy differs in every row that is, and what a recipe makes
//! alike is no fault.
//!
//! Two samples may show the same thing: a recipe whose numbers are all fixed draws one board again and again. What they
//! never share is shot noise: it is keyed by the index. So a sample is told by small contrasts, a checkerboard over
//! each of 256 blocks of 4 x 4 pixels of Scatter, which structure leaves to noise. Blocks whose contrast has the same
//! sign in most samples are structure that the recipe gives to all, and are left out. Of two strangers half of the
//! signs agree.
//!
//! Signs alone find candidates and no more: speckle is cut from patterns of 128 pixels that samples with a like grain
//! share, and of some ten thousand pairs one enters them at the same place. So the numbers have to agree too, within
//! the step of a digital number, which shot noise keeps strangers from; and samples whose drawn numbers are the same
//! are like each other because the recipe says so, and are not compared.

use std::collections::HashMap;

use output_schema::file::DATASET;
use output_schema::row::MEASURED;

use super::{Code, Finding, Rule};
use crate::validate::decoded_images::DecodedImages;

pub(super) const REPEATED: Rule =
    Rule { meaning: "Warning: two samples have the same measured maps.", remedy: LOOK_AT_BOTH };
pub(super) const ALIKE: Rule = Rule {
    meaning: "Warning: two samples seem to share their noise: one is a copy of the other with small changes.",
    remedy: LOOK_AT_BOTH,
};
/// What to do about two samples.
const LOOK_AT_BOTH: &str =
    "look at both samples: this is an estimate; --rows 1 compares them exactly, with the version that wrote them";
/// Blocks along each side of an image.
const BLOCKS_PER_SIDE: usize = 16;
/// Blocks.
const BLOCKS: usize = BLOCKS_PER_SIDE * BLOCKS_PER_SIDE;
/// Half the side of a block [px].
const BLOCK_HALF_PX: usize = 2;
/// Pixels of a block.
const BLOCK_PIXELS: f64 = (4 * BLOCK_HALF_PX * BLOCK_HALF_PX) as f64;
/// Signs that two samples must have in common to be compared.
const MIN_COMMON_SIGNS: u32 = 96;
/// Share of unlike signs up to which two samples are alike [1].
///
/// By chance, at least 91 of 96 signs agree with a probability below 1e-21.
const MAX_UNLIKE_SHARE: f64 = 0.06;
/// Furthest that pixels of a copy are from the original, root mean square [DN]: by 1 DN up, down or not at all they are
/// 0.82 DN away.
const MAX_RMS_DN: f64 = 1.0;
/// A block is structure where more than this share of at least [`MIN_SAMPLES_FOR_STRUCTURE`] samples has one sign [1].
const STRUCTURE_SHARE: f64 = 0.75;
/// Samples from which on structure can be told.
const MIN_SAMPLES_FOR_STRUCTURE: u32 = 24;
/// Keys of each sample, and signs in a key: a pair with 6 % unlike signs has a key in common with a probability above
/// 0.998, were keys independent.
const KEYS: usize = 16;
const KEY_BITS: usize = 16;
/// 2^64 over the golden ratio, odd.
const HASH_FACTOR: u64 = 0x9e37_79b9_7f4a_7c15;
/// Faults that one search gives at most.
const MAX_FINDINGS: usize = 1000;

type BlockBits = [u64; BLOCKS / 64];

/// What tells a sample: 1.1 kB, whatever the size of its images.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(in crate::validate) struct NoisePrint {
    /// Of every measured pixel.
    sum: u64,
    /// Of every drawn number.
    drawn: u64,
    sign: BlockBits,
    known: BlockBits,
    /// Contrast of each block, the sum of 16 pixels of either sign [DN].
    contrast: [i16; BLOCKS],
    /// Mean of each block [DN].
    mean: [u16; BLOCKS],
}

/// The print of a sample with these drawn numbers; `None` where its maps are too small or show nothing.
pub(in crate::validate) fn print(cols: usize, decoded: &DecodedImages, drawn: &[f64]) -> Option<NoisePrint> {
    let maps = MEASURED.map(|name| decoded.get(name));
    let map = maps[2].or(maps[1]).or(maps[0]).or(maps[3])?;
    let rows = map.len() / cols.max(1);
    if cols < BLOCKS_PER_SIDE * BLOCK_HALF_PX
        || rows < BLOCKS_PER_SIDE * BLOCK_HALF_PX
        || map.iter().all(|&number| number == 0)
    {
        return None;
    }
    let sums = maps.into_iter().flatten().map(sum);
    let all = sums.fold(0u64, |all, sum| all.rotate_left(21).wrapping_mul(HASH_FACTOR) ^ sum);
    let drawn = drawn
        .iter()
        .fold(HASH_FACTOR, |all, number| (all ^ number.to_bits()).wrapping_mul(HASH_FACTOR).rotate_left(29));
    let mut print = NoisePrint::blank(all, drawn);
    for y in 0..BLOCKS_PER_SIDE {
        for x in 0..BLOCKS_PER_SIDE {
            let (column, row) = (middle(x, cols), middle(y, rows));
            let lines = (row - BLOCK_HALF_PX..row + BLOCK_HALF_PX).map(|r| &map[r * cols..(r + 1) * cols]);
            let (mut balance, mut total, mut whole) = (0i32, 0u32, true);
            for (r, line) in lines.enumerate() {
                for (c, &number) in line[column - BLOCK_HALF_PX..column + BLOCK_HALF_PX].iter().enumerate() {
                    whole &= number > 0;
                    total += u32::from(number);
                    balance += if (r + c).is_multiple_of(2) { i32::from(number) } else { -i32::from(number) };
                }
            }
            if whole && balance != 0 {
                let block = y * BLOCKS_PER_SIDE + x;
                set(&mut print.known, block);
                if balance > 0 {
                    set(&mut print.sign, block);
                }
                print.contrast[block] = balance.clamp(-i32::from(i16::MAX), i32::from(i16::MAX)) as i16;
                print.mean[block] = (f64::from(total) / BLOCK_PIXELS).round() as u16;
            }
        }
    }
    Some(print)
}

/// 64 bits of all numbers and their order: equal for equal images, and for others once in 2^64.
pub(in crate::validate) fn sum(numbers: &[u16]) -> u64 {
    // Four chains side by side: each step of one waits for its product.
    let mut chains = [HASH_FACTOR, !HASH_FACTOR, HASH_FACTOR.rotate_left(17), HASH_FACTOR.rotate_left(43)];
    let mut add = |part: &[u16]| {
        for (chain, four) in chains.iter_mut().zip(part.chunks(4)) {
            let word = four.iter().fold(0u64, |word, &number| word << 16 | u64::from(number));
            *chain = (*chain ^ word).wrapping_mul(HASH_FACTOR).rotate_left(29);
        }
    };
    let mut parts = numbers.chunks_exact(16);
    parts.by_ref().for_each(&mut add);
    add(parts.remainder());
    let [a, b, c, d] = chains;
    [b, c, d, numbers.len() as u64]
        .into_iter()
        .fold(a, |all, chain| (all ^ chain).wrapping_mul(HASH_FACTOR) ^ all >> 31)
}

/// Middle of block `i` along a side; those of an image and of its mirror image fall on each other.
fn middle(i: usize, length: usize) -> usize {
    let middle = |i: usize| ((2 * i + 1) * length / (2 * BLOCKS_PER_SIDE)).max(BLOCK_HALF_PX);
    if i < BLOCKS_PER_SIDE / 2 { middle(i) } else { length - middle(BLOCKS_PER_SIDE - 1 - i) }
}

fn set(bits: &mut BlockBits, i: usize) {
    bits[i / 64] |= 1 << (i % 64);
}

fn is_set(bits: &BlockBits, i: usize) -> bool {
    bits[i / 64] >> (i % 64) & 1 == 1
}

impl NoisePrint {
    fn blank(sum: u64, drawn: u64) -> Self {
        let (sign, known) = (BlockBits::default(), BlockBits::default());
        Self { sum, drawn, sign, known, contrast: [0; BLOCKS], mean: [0; BLOCKS] }
    }

    /// The print of the image mirrored left to right, top to bottom, or both.
    fn turned(&self, across: bool, down: bool) -> Self {
        let mut turned = Self::blank(self.sum, self.drawn);
        for i in (0..BLOCKS).filter(|&i| is_set(&self.known, i)) {
            let (x, y) = (i % BLOCKS_PER_SIDE, i / BLOCKS_PER_SIDE);
            let to = if down { BLOCKS_PER_SIDE - 1 - y } else { y } * BLOCKS_PER_SIDE
                + if across { BLOCKS_PER_SIDE - 1 - x } else { x };
            set(&mut turned.known, to);
            // A mirrored checkerboard has its colours changed.
            if is_set(&self.sign, i) != (across != down) {
                set(&mut turned.sign, to);
            }
            turned.contrast[to] = if across == down { self.contrast[i] } else { -self.contrast[i] };
            turned.mean[to] = self.mean[i];
        }
        turned
    }

    /// Whether the numbers of both are the same but for a factor and the rounding to whole numbers.
    fn agrees(&self, other: &Self, kept: &BlockBits) -> bool {
        let both: Vec<usize> =
            (0..BLOCKS).filter(|&i| [kept, &self.known, &other.known].iter().all(|bits| is_set(bits, i))).collect();
        let light = |print: &Self| both.iter().map(|&i| f64::from(print.mean[i])).sum::<f64>();
        // Every mean of a known block is above 0.
        let factor = light(self) / light(other);
        let away = |difference: &dyn Fn(usize) -> f64| {
            let sum: f64 = both.iter().map(|&i| difference(i) * difference(i)).sum();
            (sum / both.len() as f64).sqrt()
        };
        let contrast = away(&|i: usize| f64::from(self.contrast[i]) - factor * f64::from(other.contrast[i]));
        let mean = away(&|i: usize| f64::from(self.mean[i]) - factor * f64::from(other.mean[i]));
        let most = MAX_RMS_DN * factor.max(1.0);
        contrast <= most * BLOCK_PIXELS.sqrt() && mean <= most
    }

    /// Unlike signs among those in common; `None` where these are too few.
    fn unlike(&self, other: &Self, kept: &BlockBits) -> Option<f64> {
        let (mut common, mut unlike) = (0, 0);
        for (i, kept) in kept.iter().enumerate() {
            let both = self.known[i] & other.known[i] & kept;
            common += both.count_ones();
            unlike += ((self.sign[i] ^ other.sign[i]) & both).count_ones();
        }
        (common >= MIN_COMMON_SIGNS).then(|| f64::from(unlike) / f64::from(common))
    }
}

/// One sample to be compared.
pub(in crate::validate) struct PrintedSample<'a> {
    pub(in crate::validate) index: u64,
    pub(in crate::validate) split: &'a str,
    pub(in crate::validate) print: &'a NoisePrint,
}

/// Pairs of samples that are one; each but the first of identical ones, and each pair of others.
pub(in crate::validate) fn check(samples: &[PrintedSample]) -> Vec<Finding> {
    let mut faults = Vec::new();
    let mut told: HashMap<(usize, usize), ()> = HashMap::new();
    let mut first: HashMap<u64, usize> = HashMap::new();
    for (number, sample) in samples.iter().enumerate() {
        let before = *first.entry(sample.print.sum).or_insert(number);
        // A table that a manifest names twice is read twice.
        if before != number && samples[before].index != sample.index {
            told.insert((before, number), ());
            faults.push(fault(Code::SampleRepeated, &samples[before], sample, "have the same measured maps"));
        }
    }
    let kept = kept(samples);
    // A sample that is there twice is told once.
    let own: Vec<usize> = (0..samples.len()).filter(|&i| first.get(&samples[i].print.sum) == Some(&i)).collect();
    let mut known: HashMap<(usize, u16), Vec<usize>> = HashMap::new();
    for &number in &own {
        let print = samples[number].print;
        for (turn, across, down) in
            [("", false, false), ("mirrored, ", true, false), ("mirrored, ", false, true), ("turned, ", true, true)]
        {
            let turned = print.turned(across, down);
            let mut near: Vec<usize> =
                keys(&turned, &kept).flat_map(|key| known.get(&key)).flatten().copied().collect();
            near.sort_unstable();
            near.dedup();
            for other in near {
                let before = samples[other].print;
                let Some(unlike) = before.unlike(&turned, &kept).filter(|unlike| *unlike <= MAX_UNLIKE_SHARE) else {
                    continue;
                };
                if before.drawn == turned.drawn || !before.agrees(&turned, &kept) {
                    continue;
                }
                if faults.len() < MAX_FINDINGS && told.insert((other, number), ()).is_none() {
                    let what = format!("{turn}share their noise ({:.0} % of the signs)", 100.0 * (1.0 - unlike));
                    faults.push(fault(Code::SampleAlike, &samples[other], &samples[number], &what));
                }
            }
        }
        for key in keys(print, &kept) {
            known.entry(key).or_default().push(number);
        }
    }
    faults
}

/// Blocks that are no structure of the whole dataset.
fn kept(samples: &[PrintedSample]) -> BlockBits {
    let mut kept = BlockBits::default();
    for i in 0..BLOCKS {
        let known = samples.iter().filter(|sample| is_set(&sample.print.known, i));
        let (mut count, mut ones) = (0, 0);
        for sample in known {
            count += 1;
            ones += u32::from(is_set(&sample.print.sign, i));
        }
        let share = f64::from(ones.max(count - ones)) / f64::from(count.max(1));
        if count < MIN_SAMPLES_FOR_STRUCTURE || share <= STRUCTURE_SHARE {
            set(&mut kept, i);
        }
    }
    kept
}

/// The keys under which a print is found: signs of blocks that are spread over the image.
fn keys(print: &NoisePrint, kept: &BlockBits) -> impl Iterator<Item = (usize, u16)> {
    let usable: Vec<usize> = (0..BLOCKS).filter(|&i| is_set(kept, i)).collect();
    let (sign, known) = (print.sign, print.known);
    (0..KEYS).filter_map(move |number| {
        if usable.len() < MIN_COMMON_SIGNS as usize {
            return None;
        }
        let (mut key, mut missing) = (0, 0);
        for bit in 0..KEY_BITS {
            // Steps by odd numbers of their own spread each key over all blocks.
            let place = usable[(number * 37 + bit * (2 * number + 11) * 7) % usable.len()];
            key |= u16::from(is_set(&sign, place)) << bit;
            missing += usize::from(!is_set(&known, place));
        }
        // Where most signs are missing, keys tell nothing apart.
        (missing <= KEY_BITS / 2).then_some((number, key))
    })
}

fn fault(code: Code, first: &PrintedSample, second: &PrintedSample, what: &str) -> Finding {
    let (a, b) = (first.index, second.index);
    let splits = if first.split == second.split {
        format!("both in {}", first.split)
    } else {
        format!("one in {}, one in {}: what is learned leaks", first.split, second.split)
    };
    Finding::new(code, format!("{DATASET}, samples {a} and {b}"), format!("they {what}; {splits}"))
}
