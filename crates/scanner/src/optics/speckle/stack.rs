//! Bergmann's stack of speckle patterns, each of which boils into the next, and the cache of stacks.
//!
//! The pupils of the patterns are cut from the same random phases, neighbours 1/16 of the pupil apart. Two pupils s
//! diameters apart give intensities correlated by g^2, g = (2 / pi) [acos s - s sqrt(1 - s^2)]. In Bergmann et al. 2016
//! the pupils stand on a circle, where the distance between pattern m and n is the chord sin(pi |m - n| / 2M), right
//! from pattern 0 and too short elsewhere. Here phases pass straight through a pupil that stands, so a movement of the
//! pupil by a_p is a_p / D diameters wherever it starts; after two diameters the phases repeat. Nothing is interpolated
//! between two patterns of the stack, which would lower the contrast by up to 10 %: each point of the object changes
//! from one pattern to the next at a time of its own. Intensity distribution and contrast are then those of the
//! patterns, and the correlation is g^2 between whole steps and linear inside a step.

use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use super::pupil::{Pupil, TILE, gather};
use base::Stream;
use optical_bench::settings::SpeckleLaw;

/// Patterns of a stack; those half a stack apart have pupils one diameter apart.
pub(crate) const STACK_PATTERNS: usize = 32;
/// Ratio of the grain sizes of neighbouring stacks [1].
const GRAIN_STEP: f64 = 1.03;
/// Fewest fine rows per pixel, so that a pixel can start nearly anywhere along the motion.
const MIN_FINE_ROWS: usize = 6;
/// Most fine rows per pixel, which bound the memory of a pattern.
const MAX_FINE_ROWS: usize = 24;
/// Rows after which a pattern repeats, at another place of it: more than a window has, for a transform that is a small
/// scan's largest cost [px].
const PATTERN_ROWS: usize = TILE / 2;
/// Most that the stacks in a cache take, the latest used first; the latest alone may take more [bytes].
pub const MAX_CACHED_BYTES: usize = 100 << 20;
/// Numbers of independent looks that can be averaged: a pattern and its mirror images.
const LOOK_COUNTS: [usize; 3] = [4, 2, 1];

/// Stacks made so far. A stack depends on its key alone, not on the order of requests or on what was dropped.
#[derive(Debug)]
pub struct PatternCache {
    stream: Stream,
    /// Pairs of unlike patterns in its stacks, after which they begin again.
    unlike_pairs: usize,
    /// Most that the stacks take that are kept, the latest among them unless it alone takes more [bytes].
    most: usize,
    kept: Mutex<Vec<Arc<PatternStack>>>,
}

impl PatternCache {
    /// An empty cache.
    pub fn new(seed: u64) -> Self {
        Self::of_pairs(seed, STACK_PATTERNS / 2, MAX_CACHED_BYTES)
    }

    /// An empty cache whose stacks repeat one pair of patterns: each is the speckle that it is in [`Self::new`], but
    /// changes with the height only between two patterns. For a look at few profiles, at one transform in place of
    /// sixteen.
    pub fn repeating(seed: u64) -> Self {
        Self::of_pairs(seed, 1, MAX_CACHED_BYTES)
    }

    /// An empty cache that keeps the stack used last alone, for where there are many caches.
    pub fn keeping_one(seed: u64) -> Self {
        Self::of_pairs(seed, STACK_PATTERNS / 2, 0)
    }

    fn of_pairs(seed: u64, unlike_pairs: usize, most: usize) -> Self {
        Self { stream: Stream::root(seed).child("speckle"), unlike_pairs, most, kept: Mutex::new(Vec::new()) }
    }

    /// The stack for speckle of `grain` pixels; `patterns` are the numbers of independent ones in light from the
    /// surface and from below.
    pub fn get(&self, grain: f64, law: SpeckleLaw, patterns: [f64; 2]) -> Arc<PatternStack> {
        let (step, looks) = (grain_step(grain), patterns.map(looks_in));
        let is_alike = |stack: &PatternStack| stack.single.step == step && stack.single.law == law;
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        let stack = match kept.iter().position(|known| is_alike(known) && known.looks == looks) {
            Some(index) => kept.remove(index),
            None => {
                let single = match kept.iter().find(|known| is_alike(known)) {
                    Some(relative) => relative.single.clone(),
                    None => Arc::new(SinglePatterns::new(GRAIN_STEP.powi(step), law, self.unlike_pairs, self.stream)),
                };
                Arc::new(PatternStack::averaging(single, looks))
            }
        };
        kept.insert(0, stack.clone());
        let mut bytes = 0;
        let fitting = kept.iter().take_while(|stack| {
            bytes += stack_bytes(stack.single.fine, stack.looks);
            bytes <= self.most
        });
        let fitting = fitting.count().max(1);
        kept.truncate(fitting);
        stack
    }
}

/// What a stack takes when all of its patterns are made, for speckle of `grain` pixels and so many independent patterns
/// in light from the surface and from below [bytes].
pub fn bytes_of_stack(grain: f64, patterns: [f64; 2]) -> usize {
    stack_bytes(fine_rows(GRAIN_STEP.powi(grain_step(grain))), patterns.map(looks_in))
}

fn stack_bytes(fine: usize, looks: [usize; 2]) -> usize {
    // Those of one look, of light from below, and of light from the surface where these are not the first.
    let lights = if looks[0] == 1 { 2 } else { 3 };
    lights * STACK_PATTERNS * (fine * PATTERN_ROWS + 1) * TILE * size_of::<f32>()
}

fn grain_step(grain: f64) -> i32 {
    (libm::log(grain) / libm::log(GRAIN_STEP)).round() as i32
}

/// Fine rows of a pixel: two samples a grain hold the intensity (Nyquist).
fn fine_rows(grain: f64) -> usize {
    ((2.0 / grain).ceil() as usize).clamp(MIN_FINE_ROWS, MAX_FINE_ROWS)
}

fn looks_in(patterns: f64) -> usize {
    LOOK_COUNTS.into_iter().find(|looks| *looks as f64 <= patterns).unwrap_or(1)
}

/// Patterns that boil into each other, made when they are first used.
#[derive(Debug)]
pub struct PatternStack {
    single: Arc<SinglePatterns>,
    looks: [usize; 2],
    pairs: [OnceLock<[IntensityPattern; 2]>; STACK_PATTERNS / 2],
}

/// One pattern less its mean of 1, `[fine rows + 1, TILE]`, its first row again behind its last, for light from the
/// surface and from below.
#[derive(Debug)]
struct IntensityPattern {
    surface: Arc<[f32]>,
    volume: Arc<[f32]>,
}

/// Patterns of one look, which stacks of several numbers of looks share.
#[derive(Debug)]
struct SinglePatterns {
    pupil: Pupil,
    law: SpeckleLaw,
    /// Size of the grain that was asked for, in steps of [`GRAIN_STEP`].
    step: i32,
    /// Grain that the patterns have [px].
    grain: f64,
    fine: usize,
    rows: usize,
    /// Pairs of unlike patterns, after which they begin again.
    unlike_pairs: usize,
    /// Two patterns each, since one transform makes two; their first row stands behind their last once more.
    pairs: [OnceLock<[Arc<[f32]>; 2]>; STACK_PATTERNS / 2],
}

impl SinglePatterns {
    fn new(grain: f64, law: SpeckleLaw, unlike_pairs: usize, stream: Stream) -> Self {
        let (step, fine) = (grain_step(grain), fine_rows(grain));
        let grain = grain.max(2.0 / fine as f64);
        let rows = fine * PATTERN_ROWS;
        let pupil = Pupil::new([TILE * fine, rows], grain * fine as f64, stream);
        Self { pupil, law, step, grain, fine, rows, unlike_pairs, pairs: Default::default() }
    }

    fn pair(&self, number: usize) -> &[Arc<[f32]>; 2] {
        self.pairs[number].get_or_init(|| {
            let shifts = [0, 1].map(|i| (2 * number + i) * self.pupil.phase_rows() / STACK_PATTERNS);
            gather(&self.pupil, shifts, self.law, self.fine)
                .map(|pattern| [&pattern[..], &pattern[..TILE]].concat().into())
        })
    }
}

impl PatternStack {
    #[cfg(test)]
    pub(super) fn new(grain: f64, law: SpeckleLaw, looks: [usize; 2], stream: Stream) -> Self {
        Self::averaging(Arc::new(SinglePatterns::new(grain, law, STACK_PATTERNS / 2, stream)), looks)
    }

    fn averaging(single: Arc<SinglePatterns>, looks: [usize; 2]) -> Self {
        Self { single, looks, pairs: Default::default() }
    }

    /// Patterns without contrast, which take no transform.
    pub(super) fn even(law: SpeckleLaw) -> Self {
        let single = SinglePatterns::new(1.0, law, 1, Stream::root(0));
        let light: Arc<[f32]> = vec![0.0; (single.rows + 1) * TILE].into();
        let even = || IntensityPattern { surface: light.clone(), volume: light.clone() };
        let pairs = std::array::from_fn(|_| OnceLock::from([even(), even()]));
        Self { single: Arc::new(single), looks: [1, 1], pairs }
    }

    /// Grain of the patterns: the nearest step to what was asked for, and no less than the finest pattern holds [px].
    pub fn grain(&self) -> f64 {
        self.single.grain
    }

    /// Looks (independent patterns averaged), for light from the surface and from below.
    pub fn looks(&self) -> [usize; 2] {
        self.looks
    }

    /// Fine rows of a pixel.
    pub fn fine(&self) -> usize {
        self.single.fine
    }

    /// Fine rows after which a pattern repeats.
    pub fn rows(&self) -> usize {
        self.single.rows
    }

    /// Fine row `row` of pattern number `pattern`, both of which wrap around, less its mean of 1: for light from the
    /// surface and from below.
    pub fn row(&self, pattern: i64, row: i64) -> [&[f32; TILE]; 2] {
        self.at(pattern.rem_euclid(STACK_PATTERNS as i64) as usize, row.rem_euclid(self.rows() as i64) as usize, 0)
    }

    /// [`Self::row`] for numbers within the stack, from column `column` on. Columns behind the last are the first ones
    /// of the next fine row: the pattern repeats along the line, and a fine row is half a grain at most.
    #[inline(always)]
    pub(super) fn at(&self, pattern: usize, row: usize, column: usize) -> [&[f32; TILE]; 2] {
        let pair = (pattern / 2) % self.single.unlike_pairs;
        let IntensityPattern { surface, volume } = &self.pairs[pair].get_or_init(|| self.pair(pair))[pattern % 2];
        let start = row * TILE + column;
        [surface, volume].map(|light| light[start..].first_chunk().expect("rows have TILE columns"))
    }

    fn pair(&self, number: usize) -> [IntensityPattern; 2] {
        self.single
            .pair(number)
            .each_ref()
            .map(|pattern| IntensityPattern { surface: self.averaged(pattern, 0), volume: self.averaged(pattern, 1) })
    }

    /// Mean of a pattern and its mirror images, each at another offset, so that they are uncorrelated everywhere and
    /// keep the distribution, the correlation and the boiling of the pattern; `which` is 0 for light from the surface,
    /// 1 from below.
    fn averaged(&self, pattern: &Arc<[f32]>, which: usize) -> Arc<[f32]> {
        let (looks, rows) = (self.looks[which], self.single.rows);
        // The first image of light from the surface is the pattern itself.
        if looks == 1 && which == 0 {
            return pattern.clone();
        }
        let mut mean = vec![0.0f32; pattern.len()];
        for image in 0..looks {
            // Light from below has images of its own.
            let offset = 3 * image + 5 * which;
            let (down, right) = (rows * offset / 13 + 3 * image, TILE * offset / 13 + image);
            for (row, line) in mean.chunks_exact_mut(TILE).enumerate() {
                let from = if image & 1 == 0 { (row + down) % rows } else { (rows + down - row) % rows };
                let from = &pattern[from * TILE..][..TILE];
                for (column, sum) in line.iter_mut().enumerate() {
                    let column = if image & 2 == 0 { column + right } else { TILE + right - column };
                    *sum += from[column % TILE];
                }
            }
        }
        mean.iter_mut().for_each(|sum| *sum /= looks as f32);
        mean.into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Stacks are shared, and made again alike after they were dropped.
    #[test]
    fn stacks_are_shared_and_few() {
        let patterns = PatternCache::new(7);
        let get = |grain: f64| patterns.get(grain, SpeckleLaw::Exponential, [1.0, 9.0]);
        let first = get(0.335);
        assert!(Arc::ptr_eq(&first, &get(0.336)), "a grain of the same step has the same stack");
        assert_eq!(first.looks(), [1, 4]);
        let others = patterns.get(0.335, SpeckleLaw::Exponential, [2.0, 1.0]);
        assert!(Arc::ptr_eq(&first.single, &others.single), "looks of the same light share its patterns");
        let row = *first.row(3, 17)[0];
        // Stacks of the finest patterns are four times as large as those of the coarsest: two and eight of them fit.
        for (grains, fitting) in [([0.5, 2.0], 8), ([0.03, 0.08], 2)] {
            for i in 0..20 {
                let grain = grains[0] + (grains[1] - grains[0]) * f64::from(i) / 20.0;
                get(grain);
            }
            let stack = get(grains[0]);
            (0..STACK_PATTERNS as i64).for_each(|pattern| _ = stack.row(pattern, 0));
            let lights = stack.pairs.iter().filter_map(OnceLock::get).flatten();
            let lights = lights.flat_map(|pattern| [&pattern.surface, &pattern.volume]);
            let made: usize = lights.map(|light| size_of_val(&light[..])).sum();
            assert_eq!(made, bytes_of_stack(grains[0], [1.0, 9.0]), "{} px", grains[0]);
            let kept = patterns.kept.lock().expect("no other thread has it");
            let bytes: usize = kept.iter().map(|stack| stack_bytes(stack.fine(), stack.looks())).sum();
            assert!(kept.len() == fitting && bytes <= MAX_CACHED_BYTES, "{} stacks, {bytes} bytes", kept.len());
        }
        let one = PatternCache::keeping_one(7);
        for grain in [0.4, 0.5, 0.6] {
            one.get(grain, SpeckleLaw::Exponential, [1.0, 1.0]);
        }
        assert!(one.kept.lock().is_ok_and(|kept| kept.len() == 1));
        assert!(!Arc::ptr_eq(&first, &get(0.335)));
        assert_eq!(&row, get(0.335).row(3, 17)[0]);
    }
}
