//! Speckle as a pattern that lies on the object: it moves with the object's image, and boils while it does.
//!
//! - [`field`]: light behind a disc of random phases (Duncan and Kirkpatrick 2008; Bergmann et al. 2016)
//! - [`pixels`]: the same, gathered by square pixels
//! - [`goodman`]: what contrast theory leaves of it
//! - [`boil`]: how far a movement takes the pupil's speckle across the pupil
//! - [`anchor`]: which row of which pattern a pixel sees
//!
//! Bergmann's stack: patterns whose pupils are cut from the same random phases, neighbours 1/16 of the pupil apart. Two
//! pupils s diameters apart give intensities correlated by g^2, g = (2 / pi) [acos s - s sqrt(1 - s^2)]. His discs stand
//! on a circle, where the distance between pattern m and n is the chord sin(pi |m - n| / 2M), right from pattern 0 and
//! too short elsewhere. Here phases pass straight through a disc that stands, so a movement of the pupil by a_p is a_p / D
//! diameters wherever it starts; after two diameters the phases come again. Between two patterns of the stack nothing is
//! interpolated, which would lower the contrast by up to 10 %: each place of the object changes from one pattern to the
//! next at a time of its own. Law and contrast are then those of the patterns, and the correlation is g^2 between whole
//! steps and linear inside a step.
//!
//! Neglected: how the pattern of one column is sheared by movement at an angle to the columns; a pattern repeats after
//! [`TILE`] pixels along the line, under another offset.

pub mod anchor;
pub mod boil;
pub mod field;
pub mod goodman;
pub mod pixels;
#[cfg(test)]
mod tests;

use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use procedural::Stream;

use self::field::Pupil;
use crate::settings::SpeckleLaw;

/// Pixels along the line after which a pattern repeats.
pub const TILE: usize = 128;
/// Patterns of a stack; half of them are one pupil apart.
pub const SLICES: usize = 32;
/// Step of the grain's size between stacks, as a ratio.
const GRAIN_STEP: f64 = 1.03;
/// Fewest fine rows of a pixel, so that a pixel can start nearly anywhere along the motion, and most.
const FINE: (usize, usize) = (6, 24);
/// Fine rows of a pixel above which a pattern is shorter along the motion.
const LONG: usize = 8;
/// Stacks that are kept, the latest used first.
const KEPT: usize = 8;
/// Numbers of patterns that can be averaged: a pattern and its mirror images.
const LOOKS: [usize; 3] = [4, 2, 1];

/// What decides the patterns of a stack.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Key {
    /// Size of the grain in steps of [`GRAIN_STEP`].
    grain: i32,
    law: SpeckleLaw,
    /// Independent patterns averaged, for light from the surface and from below.
    looks: [usize; 2],
}

/// Stacks made so far. Values depend on the key alone, not on who asked or on what was dropped.
#[derive(Debug)]
pub struct Tiles {
    stream: Stream,
    kept: Mutex<Vec<(Key, Arc<Stack>)>>,
}

impl Tiles {
    /// No patterns yet.
    pub fn new(seed: u64) -> Self {
        Self { stream: Stream::root(seed).child("speckle"), kept: Mutex::new(Vec::new()) }
    }

    /// The stack for speckle of `grain` pixels; `patterns` are the independent ones in light from the surface and from below.
    pub fn get(&self, grain: f64, law: SpeckleLaw, patterns: [f64; 2]) -> Arc<Stack> {
        let step = (libm::log(grain) / libm::log(GRAIN_STEP)).round() as i32;
        let looks = patterns.map(|n| LOOKS.into_iter().find(|looks| *looks as f64 <= n).unwrap_or(1));
        let key = Key { grain: step, law, looks };
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        let place = kept.iter().position(|(known, _)| *known == key);
        let stack = match place {
            Some(place) => kept.remove(place).1,
            None => Arc::new(Stack::new(GRAIN_STEP.powi(step), law, looks, self.stream)),
        };
        kept.insert(0, (key, stack.clone()));
        kept.truncate(KEPT);
        stack
    }
}

/// Patterns that go over into each other, made when they are first looked at.
#[derive(Debug)]
pub struct Stack {
    pupil: Pupil,
    law: SpeckleLaw,
    looks: [usize; 2],
    /// Grain that the patterns have [px].
    grain: f64,
    fine: usize,
    rows: usize,
    /// Two patterns each, since they are made together.
    pairs: [OnceLock<[Slice; 2]>; SLICES / 2],
}

/// One pattern less its mean of 1, `[fine rows, TILE]`: of light from the surface and from below.
#[derive(Debug)]
struct Slice([Vec<f32>; 2]);

impl Stack {
    fn new(grain: f64, law: SpeckleLaw, looks: [usize; 2], stream: Stream) -> Self {
        // Two samples a grain hold the intensity (Nyquist).
        let fine = ((2.0 / grain).ceil() as usize).clamp(FINE.0, FINE.1);
        let grain = grain.max(2.0 / fine as f64);
        let rows = fine * if fine > LONG { TILE / 2 } else { TILE };
        let pupil = Pupil::new([TILE * fine, rows], grain * fine as f64, stream);
        Self { pupil, law, looks, grain, fine, rows, pairs: Default::default() }
    }

    /// Grain of the patterns: the nearest step to what was asked for, and no less than the finest pattern holds [px].
    pub fn grain(&self) -> f64 {
        self.grain
    }

    /// Independent patterns averaged, for light from the surface and from below.
    pub fn looks(&self) -> [usize; 2] {
        self.looks
    }

    /// Fine rows of a pixel.
    pub fn fine(&self) -> usize {
        self.fine
    }

    /// Fine rows after which a pattern repeats.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Fine row `row` of pattern `slice`, any whole numbers, less its mean of 1: of light from the surface and from below.
    pub fn row(&self, slice: i64, row: i64) -> [&[f32; TILE]; 2] {
        self.at(slice.rem_euclid(SLICES as i64) as usize, row.rem_euclid(self.rows as i64) as usize)
    }

    /// The same for a pattern and a row that the stack has.
    #[inline(always)]
    fn at(&self, slice: usize, row: usize) -> [&[f32; TILE]; 2] {
        let Slice(patterns) = &self.pairs[slice / 2].get_or_init(|| self.pair(slice / 2))[slice % 2];
        let start = row * TILE;
        [0, 1].map(|which: usize| patterns[which][start..].first_chunk().expect("rows have TILE columns"))
    }

    fn pair(&self, number: usize) -> [Slice; 2] {
        let shifts = [0, 1].map(|i| (2 * number + i) * self.pupil.round() / SLICES);
        let patterns = pixels::gather(&self.pupil, shifts, self.law, self.fine);
        patterns.map(|pattern| Slice([0, 1].map(|which| self.averaged(&pattern, which))))
    }

    /// The mean of a pattern and its mirror images, each at another place: nowhere alike, and each with the law, the
    /// correlation and the boiling of the pattern.
    fn averaged(&self, pattern: &[f32], which: usize) -> Vec<f32> {
        let (looks, rows) = (self.looks[which], self.rows);
        let mut mean = vec![0.0f32; pattern.len()];
        for image in 0..looks {
            // Light from below has images of its own.
            let place = 3 * image + 5 * which;
            let (down, right) = (rows * place / 13 + 3 * image, TILE * place / 13 + image);
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
        mean
    }
}
