//! Table of reflection and transmission of films, measured by Monte Carlo and kept beside this file as `film.bin`.
//!
//! Three axes: index, reduced scattering times thickness, absorption times thickness. Lengths are in thicknesses,
//! frequencies in 1 / thickness. Transmitted light is kept times 1 + 3/4 of the scattering, which leaves little to
//! interpolate (the two-stream law). `make film-table` makes it anew.

use super::spectrum::{RATIO_LN, UnitSpectrum};
use crate::stack::Foil;

/// Refractive indices of the table [1].
pub const N: [f64; 2] = [1.45, 1.58];
/// Indices that films may have: between those of the table, and as far beyond them as they are extrapolated [1].
pub(crate) const FILM_INDICES: [f32; 2] = [1.4, 1.65];
/// Reduced scattering times thickness: none, then a factor of 2 from one to the next [1].
pub const TURNS: [f64; 15] =
    [0.0, 0.02, 0.04, 0.08, 0.16, 0.32, 0.64, 1.28, 2.56, 5.12, 10.24, 20.48, 40.96, 81.92, 163.84];
/// Absorption times thickness [1].
pub const ABSORBED: [f64; 13] = [0.0, 0.02, 0.05, 0.1, 0.2, 0.4, 0.8, 1.2, 1.8, 2.7, 4.0, 6.0, 10.0];
/// Path of light in a film about which interpolation over absorption is exact [thicknesses].
const TYPICAL_PATH: f32 = 4.0;
/// Lowest frequency of a transform [1 / thickness].
pub(crate) const LOWEST_FREQUENCY: f64 = 0.02;
/// Frequencies of a transform.
pub const TABLE_FREQUENCIES: usize = 20;
/// Bins of directions of exit, even in the square of the sine.
pub const EXIT_BINS: usize = 8;
/// Transforms kept of a film.
const TRANSFORMS: usize = 6;
/// Laws of exit kept of a film.
const EXIT_LAWS: usize = 3;
/// Numbers kept of a film: transforms, laws of exit, and the shares of Lambert light that passes unturned and of straight
/// light that leaves a sealed film as the foil mirrored it.
pub const NODE: usize = TRANSFORMS * TABLE_FREQUENCIES + EXIT_LAWS * EXIT_BINS + 2;
/// Foil below the sealed films of the table.
pub const SEALED: Foil = Foil { reflectance: 0.9, roughness: [0.2, 0.2] };

/// Frequencies of the transforms [1 / thickness].
pub fn frequencies() -> [f64; TABLE_FREQUENCIES] {
    std::array::from_fn(|i| LOWEST_FREQUENCY * libm::exp(i as f64 * RATIO_LN))
}

/// How much larger the table keeps transmitted light [1].
pub fn transmission_scale(turns: f64) -> f64 {
    1.0 + 0.75 * turns
}

/// `film.bin`: f32, little-endian.
const BYTES: &[u8] = include_bytes!("film.bin");
const _: () = assert!(BYTES.len() == 4 * NODE * N.len() * PER_INDEX, "film.bin has other axes");
/// Films of one index.
const PER_INDEX: usize = TURNS.len() * ABSORBED.len();

/// Films of one index, `[TURNS][ABSORBED]`.
#[derive(Debug, Clone)]
pub(crate) struct FilmTable {
    n: f32,
    nodes: Vec<[f32; NODE]>,
    absorbed: [f32; ABSORBED.len()],
}

impl FilmTable {
    /// Films of index `n`, clamped to [1.4, 1.65] [1].
    pub fn of(n: f32) -> Self {
        let word = |i: usize| f32::from_le_bytes(BYTES.as_chunks().0[i]);
        let [low, high] = N.map(|n| n as f32);
        let f = (n.clamp(FILM_INDICES[0], FILM_INDICES[1]) - low) / (high - low);
        let value = |i: usize| word(i) * (1.0 - f) + word(i + PER_INDEX * NODE) * f;
        let nodes = (0..PER_INDEX).map(|film| std::array::from_fn(|i| value(film * NODE + i))).collect();
        Self { n, nodes, absorbed: ABSORBED.map(|a| absorption_axis(a as f32)) }
    }

    /// Their index [1].
    pub fn n(&self) -> f32 {
        self.n
    }

    /// The film with this reduced scattering and absorption times thickness, clamped to the table's ends.
    #[inline(always)]
    pub fn at(&self, turns: f32, absorbed: f32) -> FilmNode {
        let (rows, along) = rows(turns);
        let (j, g) = between(&self.absorbed, absorption_axis(absorbed));
        let mut node = [0.0f32; NODE];
        for (row, weight) in rows.into_iter().zip(along) {
            let first = row * ABSORBED.len() + j;
            let (less, more) = (&self.nodes[first], &self.nodes[first + 1]);
            for l in 0..NODE {
                node[l] += weight * ((1.0 - g) * less[l] + g * more[l]);
            }
        }
        FilmNode { node, scale: 1.0 / transmission_scale(f64::from(turns)) as f32 }
    }
}

/// Places and weights of four films whose scattering is about `turns`: cubic in its logarithm, so that what is thrown back
/// and what passes still add up; linear below the first film that scatters.
#[inline(always)]
fn rows(turns: f32) -> ([usize; 4], [f32; 4]) {
    let first = TURNS[1] as f32;
    if turns < first {
        let f = (turns / first).max(0.0);
        return ([0, 1, 1, 1], [1.0 - f, f, 0.0, 0.0]);
    }
    let steps = numerics::lanes::ln(turns * (1.0 / first)) * (1.0 / std::f32::consts::LN_2);
    let steps = steps.min((TURNS.len() - 2) as f32);
    let low = ((steps as usize).max(1) - 1).min(TURNS.len() - 5);
    let x = steps - low as f32;
    let (a, b, c, d) = (x, x - 1.0, x - 2.0, x - 3.0);
    let weights = [b * c * d * (-1.0 / 6.0), a * c * d * 0.5, a * b * d * -0.5, a * b * c * (1.0 / 6.0)];
    (std::array::from_fn(|i| 1 + low + i), weights)
}

/// The axis of absorption: what is left after a typical path, rising with absorption [1].
#[inline(always)]
fn absorption_axis(absorbed: f32) -> f32 {
    -numerics::lanes::exp(-TYPICAL_PATH * absorbed)
}

/// The place of `x` among rising values: the one below it, and how far it is on the way to the next.
#[inline(always)]
fn between(values: &[f32], x: f32) -> (usize, f32) {
    let low = values[1..values.len() - 1].iter().filter(|&&value| x >= value).count();
    (low, ((x - values[low]) / (values[low + 1] - values[low])).clamp(0.0, 1.0))
}

/// What one film does. All shares but `sealed` are of a film in air.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FilmNode {
    node: [f32; NODE],
    scale: f32,
}

impl FilmNode {
    /// Straight light that entered from one side and leaves on it, turned.
    #[inline(always)]
    pub fn back(&self) -> UnitSpectrum<TABLE_FREQUENCIES> {
        self.transform(0, 1.0)
    }

    /// Straight light that entered and leaves on the other side, turned.
    #[inline(always)]
    pub fn on(&self) -> UnitSpectrum<TABLE_FREQUENCIES> {
        self.transform(1, self.scale)
    }

    /// Lambert light that arrived and leaves on the same side, turned or not.
    #[inline(always)]
    pub(crate) fn diffuse_back(&self) -> UnitSpectrum<TABLE_FREQUENCIES> {
        self.transform(2, 1.0)
    }

    /// Lambert light that arrived and leaves on the other side, turned.
    #[inline(always)]
    pub(crate) fn diffuse_on(&self) -> UnitSpectrum<TABLE_FREQUENCIES> {
        self.transform(3, self.scale)
    }

    /// Straight light that entered a film sealed to foil and leaves turned by the film.
    #[inline(always)]
    pub fn sealed(&self) -> UnitSpectrum<TABLE_FREQUENCIES> {
        self.transform(4, 1.0)
    }

    /// Slopes of the directions of [`Self::on`], frequencies in 1 / slope.
    #[inline(always)]
    pub fn slopes(&self) -> UnitSpectrum<TABLE_FREQUENCIES> {
        self.transform(5, 1.0)
    }

    /// Radiance factors, against light that leaves by Lambert's law, under cosine `up`: of [`Self::back`],
    /// [`Self::diffuse_on`] and [`Self::sealed`] [1].
    #[inline(always)]
    pub fn laws(&self, up: f32) -> [f32; EXIT_LAWS] {
        let place = ((1.0 - up * up) * EXIT_BINS as f32 - 0.5).clamp(0.0, (EXIT_BINS - 1) as f32 - 1e-3);
        let (bin, f) = (place as usize, place - place.floor());
        std::array::from_fn(|law| {
            let at = TRANSFORMS * TABLE_FREQUENCIES + law * EXIT_BINS + bin;
            self.node[at] * (1.0 - f) + self.node[at + 1] * f
        })
    }

    /// Lambert light that arrived and passes without being turned [1].
    pub(crate) fn diffuse_straight(&self) -> f32 {
        self.node[NODE - 2]
    }

    /// Straight light that entered a film sealed to foil and leaves as the foil mirrored it [1].
    pub(crate) fn sealed_straight(&self) -> f32 {
        self.node[NODE - 1]
    }

    #[inline(always)]
    fn transform(&self, i: usize, scale: f32) -> UnitSpectrum<TABLE_FREQUENCIES> {
        UnitSpectrum(std::array::from_fn(|l| self.node[i * TABLE_FREQUENCIES + l] * scale))
    }
}
