//! Table of reflection and transmission of films, measured by Monte Carlo and kept beside this file as `film.bin`.
//!
//! Three axes: index, reduced scattering times thickness, absorption times thickness; of films sealed to foil also its
//! reflectance and roughness. Lengths are in thicknesses, frequencies in 1 / thickness. Transmitted light is kept times
//! 1 + 3/4 of the scattering, which leaves little to interpolate (the two-stream law). `make film-table` makes it anew.

use std::sync::{Arc, Mutex, PoisonError};

use super::sealed::HOP;
use super::spectrum::{RATIO_LN, UnitSpectrum, kept, nearly_lambert};

/// Refractive indices of the table [1].
pub const N: [f64; 2] = [1.45, 1.58];
/// Indices that films may have: between those of the table, and as far beyond them as they are extrapolated [1].
pub(crate) const FILM_INDICES: [f32; 2] = [1.4, 1.65];
/// Reduced scattering times thickness: none, then a factor of 2 from one to the next [1].
pub const TURNS: [f64; 15] =
    [0.0, 0.02, 0.04, 0.08, 0.16, 0.32, 0.64, 1.28, 2.56, 5.12, 10.24, 20.48, 40.96, 81.92, 163.84];
/// Absorption times thickness [1].
pub const ABSORBED: [f64; 13] = [0.0, 0.02, 0.05, 0.1, 0.2, 0.4, 0.8, 1.2, 1.8, 2.7, 4.0, 6.0, 10.0];
/// Absorption up to which what is left of light goes on as 1 - a, rather than by the logarithm of a [1].
const LITTLE: f32 = 0.05;
/// ln(1 + a / [`LITTLE`]) of [`ABSORBED`]: whatever the paths of light are, what absorption leaves of it is smooth in
/// this. Between the nodes paths of a median of 0.1 to 3 thicknesses, spread 1.6 to 3.7-fold, leave what cubic
/// polynomials say within 0.001, where an exponential of one path is off by up to 0.04.
const ABSORBED_LN: [f32; ABSORBED.len()] = [
    0.0,
    0.336_472,
    std::f32::consts::LN_2,
    1.098_612,
    1.609_438,
    2.197_225,
    2.833_213,
    3.218_876,
    3.610_918,
    4.007_333,
    4.394_449,
    4.795_791,
    5.303_305,
];
/// Lowest frequency of a transform [1 / thickness].
pub(crate) const LOWEST_FREQUENCY: f64 = 0.02;
/// Frequencies of a transform.
pub const TABLE_FREQUENCIES: usize = 20;
/// Bins of directions of exit, even in the square of the sine.
pub const EXIT_BINS: usize = 8;
/// Transforms kept of a film in air.
const TRANSFORMS: usize = 5;
/// Laws of exit kept of a film in air.
const EXIT_LAWS: usize = 2;
/// Numbers kept of a film in air: transforms, laws of exit, and the share of Lambert light that passes unturned.
pub const NODE: usize = TRANSFORMS * TABLE_FREQUENCIES + EXIT_LAWS * EXIT_BINS + 1;
/// Reflectances of the foils below sealed films [1].
pub const FOIL_REFLECTANCES: [f64; 2] = [0.51, 0.95];
/// Their roughnesses, alike along and across [1].
pub const FOIL_ROUGHNESSES: [f64; 4] = [0.04, 0.15, 0.4, 1.0];
/// Foils below a film.
const FOILS: usize = FOIL_REFLECTANCES.len() * FOIL_ROUGHNESSES.len();
/// Numbers kept of a film on one foil: the transform of turned light, its law of exit, and the share of straight light
/// that leaves as the foil mirrored it.
pub const SEALED_NODE: usize = TABLE_FREQUENCIES + EXIT_BINS + 1;
/// Numbers kept of a film in all: in air, then on each foil, `[FOIL_REFLECTANCES][FOIL_ROUGHNESSES][SEALED_NODE]`.
pub const FILM_NUMBERS: usize = NODE + FOILS * SEALED_NODE;
/// For interpolation over the reflectance m of foil, with which what leaves goes as m / (1 - s m): the share s of the
/// light that foil sends into a film and that comes back to it, however far aside. A clear film lets FILM_LETS_OUT of
/// it out, pigment less, and absorption takes some on the way. Fitted between the table's two reflectances: R of films
/// of 3 and 5 turns at 0.7 to 0.9, within 0.01 [1].
const FILM_LETS_OUT: f32 = 0.35;
const PIGMENT_HOLDS: f32 = 0.38;
const WAY_BACK: f32 = 3.0;

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
const _: () = assert!(BYTES.len() == 4 * FILM_NUMBERS * N.len() * PER_INDEX, "film.bin has other axes");
/// Films of one index.
const PER_INDEX: usize = TURNS.len() * ABSORBED.len();

/// Steps of absorption, even in ln(1 + a / [`LITTLE`]), between which films are linear.
const STEPS: usize = 65;

/// Films of one index, `[TURNS][STEPS]`.
#[derive(Debug, Clone)]
pub(crate) struct FilmTable {
    /// Their index [1].
    pub n: f32,
    nodes: Vec<[f32; NODE]>,
    /// The same films on each foil.
    sealed: Vec<[[f32; SEALED_NODE]; FOILS]>,
    /// Natural logarithms of [`FOIL_ROUGHNESSES`].
    roughnesses: [f32; FOIL_ROUGHNESSES.len()],
    /// [`frequencies`] [1 / thickness].
    waves: [f32; TABLE_FREQUENCIES],
}

/// Foil that a film of the table is sealed to.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TableFoil {
    /// Share of light that it throws back [1].
    pub reflectance: f32,
    /// Roughness of foil alike in all directions that throws back as much [1].
    pub roughness: f32,
    /// The same of foil that spreads light as far across the line [1].
    pub spreading: f32,
}

impl FilmTable {
    /// Films of index `n`, clamped to [1.4, 1.65] [1]; the last ones are kept for whoever asks next, as all threads do
    /// about a pack.
    pub fn of(n: f32) -> Arc<Self> {
        static LAST: Mutex<Option<Arc<FilmTable>>> = Mutex::new(None);
        let mut last = LAST.lock().unwrap_or_else(PoisonError::into_inner);
        match &*last {
            Some(table) if table.n == n => table.clone(),
            _ => last.insert(Arc::new(Self::make(n))).clone(),
        }
    }

    fn make(n: f32) -> Self {
        let word = |i: usize| f32::from_le_bytes(BYTES.as_chunks().0[i]);
        let [low, high] = N.map(|n| n as f32);
        let f = (n.clamp(FILM_INDICES[0], FILM_INDICES[1]) - low) / (high - low);
        let value = |i: usize| word(i) * (1.0 - f) + word(i + PER_INDEX * FILM_NUMBERS) * f;
        let steps =
            || (0..TURNS.len()).flat_map(|row| (0..STEPS).map(move |step| (row * ABSORBED.len(), columns(step))));
        let step = |(row, (first, weights)): (usize, (usize, [f32; 4])), i: usize| -> f32 {
            (0..4).map(|at| weights[at] * value((row + first + at) * FILM_NUMBERS + i)).sum()
        };
        let on_foil = |film, foil: usize| std::array::from_fn(|i| step(film, NODE + foil * SEALED_NODE + i));
        Self {
            n,
            nodes: steps().map(|film| std::array::from_fn(|i| step(film, i))).collect(),
            sealed: steps().map(|film| std::array::from_fn(|foil| on_foil(film, foil))).collect(),
            roughnesses: FOIL_ROUGHNESSES.map(|alpha| libm::log(alpha) as f32),
            waves: frequencies().map(|wave| wave as f32),
        }
    }

    /// The film with this reduced scattering and absorption times thickness, clamped to the table's ends.
    #[inline(always)]
    pub fn at(&self, turns: f32, absorbed: f32) -> FilmNode {
        let mut node = [0.0f32; NODE];
        for (film, weight) in near(turns, absorbed) {
            for (sum, value) in node.iter_mut().zip(&self.nodes[film]) {
                *sum += weight * value;
            }
        }
        let scale = 1.0 / transmission_scale(f64::from(turns)) as f32;
        FilmNode {
            back: transform(&node, 0, 1.0),
            on: transform(&node, 1, scale),
            diffuse_back: transform(&node, 2, 1.0),
            diffuse_on: transform(&node, 3, scale),
            slopes: transform(&node, 4, 1.0),
            laws: std::array::from_fn(|i| node[TRANSFORMS * TABLE_FREQUENCIES + i]),
            diffuse_straight: node[NODE - 1],
        }
    }

    /// That film sealed to `foil`, which mirrors out what goes with `mirrors` of its reflectance.
    #[inline(always)]
    pub fn sealed(&self, turns: f32, absorbed: f32, foil: TableFoil, mirrors: impl Fn(f32) -> f32) -> SealedNode {
        let turned = self.between_reflectances(turns, absorbed, foil.reflectance);
        let [low, high] = FOIL_REFLECTANCES.map(|reflectance| reflectance as f32);
        let mirrored = (mirrors(foil.reflectance) - mirrors(low)) / (mirrors(high) - mirrors(low));
        let [alike, spreading] = [foil.roughness, foil.spreading].map(|alpha| self.between_roughnesses(alpha));
        let (mut node, mut all) = ([0.0f32; SEALED_NODE], 0.0);
        for (film, weight) in near(turns, absorbed) {
            let mixed = |foil: usize, i: usize, part: f32| {
                let [dull, bright] = [foil, foil + FOIL_ROUGHNESSES.len()].map(|foil| self.sealed[film][foil][i]);
                dull + (bright - dull) * part
            };
            for (foil, share) in spreading {
                for i in 0..TABLE_FREQUENCIES {
                    node[i] += weight * share * mixed(foil, i, turned[i]);
                }
            }
            for (foil, share) in alike {
                all += weight * share * mixed(foil, 0, turned[0]);
                for i in TABLE_FREQUENCIES..SEALED_NODE - 1 {
                    node[i] += weight * share * mixed(foil, i, turned[0]);
                }
                node[SEALED_NODE - 1] += weight * share * mixed(foil, SEALED_NODE - 1, mirrored);
            }
        }
        let scale = all / node[0].max(f32::MIN_POSITIVE);
        SealedNode {
            turned: UnitSpectrum::of(|l| scale * node[l]),
            law: std::array::from_fn(|i| node[TABLE_FREQUENCIES + i]),
            mirrored: node[SEALED_NODE - 1],
        }
    }

    /// How far a reflectance is on the way between the table's two, for each frequency [1].
    ///
    /// What comes back to foil of what it threw up has hopped aside: at the frequency q the share s of it counts by
    /// that hop's transform. Film that turns much lets light hop less far.
    #[inline(always)]
    fn between_reflectances(&self, turns: f32, absorbed: f32, reflectance: f32) -> [f32; TABLE_FREQUENCIES] {
        let back = (1.0 - FILM_LETS_OUT / (1.0 + PIGMENT_HOLDS * turns)) * numerics::lanes::exp(-WAY_BACK * absorbed);
        let hop = HOP / (1.0 + turns);
        let [low, high] = FOIL_REFLECTANCES.map(|reflectance| reflectance as f32);
        self.waves.map(|wave| {
            let again = back * nearly_lambert(hop * wave);
            let met = |reflectance: f32| reflectance / (1.0 - again * reflectance);
            (met(reflectance) - met(low)) / (met(high) - met(low))
        })
    }

    /// The foils around one of a roughness, and their shares.
    #[inline(always)]
    fn between_roughnesses(&self, roughness: f32) -> [(usize, f32); 2] {
        let (rough, more) = between(&self.roughnesses, numerics::lanes::ln(roughness.max(1e-3)));
        [(rough, 1.0 - more), (rough + 1, more)]
    }
}

/// Transform number `i` of a film, times `scale`.
#[inline(always)]
fn transform(node: &[f32; NODE], i: usize, scale: f32) -> FilmSpectrum {
    UnitSpectrum::of(|l| node[i * TABLE_FREQUENCIES + l] * scale)
}

/// The films around one, and their weights.
#[inline(always)]
fn near(turns: f32, absorbed: f32) -> [(usize, f32); 8] {
    let (rows, along) = rows(turns);
    let place = numerics::lanes::ln(1.0 + absorbed.max(0.0) * (1.0 / LITTLE))
        * ((STEPS - 1) as f32 / ABSORBED_LN[ABSORBED.len() - 1]);
    let low = (place as usize).min(STEPS - 2);
    let f = (place - low as f32).min(1.0);
    std::array::from_fn(|i| {
        let (row, more) = (i / 2, i % 2);
        (rows[row] * STEPS + low + more, along[row] * if more == 1 { f } else { 1.0 - f })
    })
}

/// The first of four films of the table whose absorption is about that of a step, and their weights: cubic in
/// [`ABSORBED_LN`].
fn columns(step: usize) -> (usize, [f32; 4]) {
    let place = ABSORBED_LN[ABSORBED.len() - 1] * step as f32 / (STEPS - 1) as f32;
    let first = ABSORBED_LN[2..ABSORBED.len() - 2].iter().filter(|&&value| place >= value).count();
    let at: [f32; 4] = std::array::from_fn(|i| ABSORBED_LN[first + i]);
    let others = |i: usize| (0..4).filter(move |&j| j != i);
    (first, std::array::from_fn(|i| others(i).map(|j| (place - at[j]) / (at[i] - at[j])).product()))
}

/// Places and weights of four films whose scattering is about `turns`: cubic in its logarithm, so that what is thrown
/// back and what passes still add up; linear below the first film that scatters.
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

/// The place of `x` among rising values: the one below it, and how far it is on the way to the next.
#[inline(always)]
fn between(values: &[f32], x: f32) -> (usize, f32) {
    let low = values[1..values.len() - 1].iter().filter(|&&value| x >= value).count();
    (low, ((x - values[low]) / (values[low + 1] - values[low])).clamp(0.0, 1.0))
}

/// A transform of the table.
type FilmSpectrum = UnitSpectrum<{ kept(TABLE_FREQUENCIES) }>;

/// What one film in air does.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FilmNode {
    /// Straight light that entered from one side and leaves on it, turned.
    pub back: FilmSpectrum,
    /// Straight light that entered and leaves on the other side, turned.
    pub on: FilmSpectrum,
    /// Lambert light that arrived and leaves on the same side, turned or not.
    pub diffuse_back: FilmSpectrum,
    /// Lambert light that arrived and leaves on the other side, turned.
    pub diffuse_on: FilmSpectrum,
    /// Slopes of the directions of [`Self::on`], frequencies in 1 / slope.
    pub slopes: FilmSpectrum,
    /// Laws of exit, bin by bin.
    laws: [f32; EXIT_LAWS * EXIT_BINS],
    /// Lambert light that arrived and passes without being turned [1].
    pub diffuse_straight: f32,
}

impl FilmNode {
    /// Radiance factors, against light that leaves by Lambert's law, under cosine `up`: of [`Self::back`] and
    /// [`Self::diffuse_on`] [1].
    #[inline(always)]
    pub fn laws(&self, up: f32) -> [f32; EXIT_LAWS] {
        std::array::from_fn(|law| law_at(&self.laws[law * EXIT_BINS..], up))
    }
}

/// A law of exit, kept in bins, under cosine `up` [1].
#[inline(always)]
fn law_at(bins: &[f32], up: f32) -> f32 {
    let place = ((1.0 - up * up) * EXIT_BINS as f32 - 0.5).clamp(0.0, (EXIT_BINS - 1) as f32 - 1e-3);
    let (bin, f) = (place as usize, place - place.floor());
    bins[bin] * (1.0 - f) + bins[bin + 1] * f
}

/// What one film sealed to foil does.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SealedNode {
    /// Straight light that entered and leaves turned by the film.
    pub turned: FilmSpectrum,
    law: [f32; EXIT_BINS],
    /// Straight light that entered and leaves as the foil mirrored it [1].
    pub mirrored: f32,
}

impl SealedNode {
    /// Radiance factor of turned light, against light that leaves by Lambert's law, under cosine `up` [1].
    #[inline(always)]
    pub fn law(&self, up: f32) -> f32 {
        law_at(&self.law, up)
    }
}

#[cfg(test)]
mod tests {
    use rand::RngExt;

    use super::*;

    /// What absorption leaves of paths whose logarithm is normal, a median of 0.1 to 3 thicknesses spread 1.6 to
    /// 3.7-fold, by way of the table's nodes and the steps between them: within 0.002 of all light, over all
    /// absorptions.
    #[test]
    fn absorption_between_nodes_leaves_what_it_leaves() {
        let mut rng = base::Stream::root(56).rng();
        for _ in 0..2000 {
            let median = libm::exp(rng.random_range(libm::log(0.1)..libm::log(3.0)));
            let (deviation, absorbed) = (rng.random_range(0.5..1.3f64), libm::exp(rng.random_range(-7.0..2.3f64)));
            let left = |absorbed: f64| {
                let z = |i: i32| -5.0 + (f64::from(i) + 0.5) / 20.0;
                let weight = |i: i32| libm::exp(-0.5 * z(i) * z(i));
                let path = |i: i32| median * libm::exp(deviation * z(i));
                let all: f64 = (0..200).map(weight).sum();
                (0..200).map(|i| weight(i) * libm::exp(-absorbed * path(i))).sum::<f64>() / all
            };
            let step = |step: usize| -> f64 {
                let (first, weights) = columns(step);
                (0..4).map(|at| f64::from(weights[at]) * left(ABSORBED[first + at])).sum()
            };
            let between: f64 = near(0.0, absorbed as f32)[..2].iter().map(|&(at, f)| f64::from(f) * step(at)).sum();
            let off = between - left(absorbed);
            assert!(off.abs() < 0.002, "{median} {deviation} {absorbed}: off by {off}");
        }
    }
}
