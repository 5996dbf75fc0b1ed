//! Fourier transforms of line spreads on fixed frequencies, and the fit of the fixed widths to them.
//!
//! A line spread f(y) is kept as F(q) = int f(y) cos(q y) dy at [`FREQUENCY_COUNT`] frequencies with a constant ratio:
//! there spreads one after the other are products. A transform that is known for a unit length on the same ratios is
//! shifted by ln(length) to be read, with the same four cubic weights for all frequencies.
//!
//! Light that leaves a plane by Lambert's law from a point arrives at distance d as d^2 / (pi (d^2 + r^2)^2), whose
//! transform is x K1(x), x = q d. That law is a mixture of Gaussians, 1 / variance being even in its own exponential
//! law; so are spreads by diffusion. Weights of the fixed widths are therefore linear in F. The matrix is the one
//! that does best, in least squares with a penalty on large elements. It is made for such spreads of 80 sizes up to
//! 60 mm, each with the weights that give its rows 0 to 12, and some as far as 4 mm, as counted by their importance,
//! best and are not negative.
//!
//! Valid from 0.05 to 50 mm^-1, wider spreads count by their height at the centre. Neglected: shifts.

use super::super::widths::{BASIS, PACK_SPREAD_MM, line_mm2};

/// Number of frequencies.
pub(crate) const FREQUENCY_COUNT: usize = 16;
/// Lowest frequency [mm^-1].
pub(crate) const LOWEST_FREQUENCY: f64 = 0.05;
/// Logarithm of the ratio between neighbouring frequencies: ln(1000) / 15.
pub(crate) const RATIO_LN: f64 = 0.460_517_018_598_809_13;
/// A transform on the fixed frequencies [1].
pub(crate) type Spectrum = [f32; FREQUENCY_COUNT];

/// How much the spreads count that the way back is made for: Gaussians; mixtures whose variance has an exponential law,
/// as diffusion makes them. Those where 1 / variance has, as Lambert's law does; and those of diffusion over a range of
/// sizes, as films make them; for the narrow widths and for the wide ones [1]. Gaussians alone, of which none is one of
/// the fixed widths, would all be fitted with too narrow a peak. Searched at random for the least error on such
/// mixtures, Lambert's law over 0.2 to 10 mm and pigmented films.
const FIT_KINDS: [[f64; 4]; 2] = [[1.0, 0.2, 2.0, 2.0], [1.5, 0.25, 1.0, 0.1]];
/// First of the wide widths.
const FIT_WIDE: usize = 4;
/// Gaussians of a mixture.
const FIT_PARTS: usize = 32;
/// Sizes of each, and the largest standard deviation or root of the mean among them [mm].
const FIT_SCALES: usize = 80;
const GOLDEN_RATIO: f64 = 0.618_033_988_749_894_9;
const WIDEST_MM: f64 = 60.0;
/// The smallest one that is not 0 [mm].
const NARROWEST_MM: f64 = 0.01;
/// Penalty on large elements of the matrix, as an error of the transforms [1].
const FIT_PENALTY: f64 = 1e-3;
/// Rows whose light counts, and their pitch [mm].
const FIT_ROWS: [usize; 19] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 14, 16, 19, 23, 30, 40];
const FIT_PITCH_MM: f64 = 0.101;
/// Those of Scatter.
const SCATTER_ROWS: std::ops::Range<usize> = 7..12;
/// How much the rows of the peak and those of Scatter count over others [1].
const PEAK_IMPORTANCE: f64 = 3.0;
const SCATTER_IMPORTANCE: f64 = 6.0;
/// Share of the brightest row under which a row counts no more [1].
const FIT_FLOOR: f64 = 0.02;
/// Steps of the fits with weights that are not negative.
const FIT_SWEEPS: usize = 400;

/// Frequency number `i` [mm^-1].
pub fn frequency(i: usize) -> f64 {
    LOWEST_FREQUENCY * libm::exp(i as f64 * RATIO_LN)
}

/// Places of a transform that are read together, and by which its ends are repeated beyond them.
const AROUND: usize = FREQUENCY_COUNT + 3;

/// Numbers kept of a transform at so many places.
pub(crate) const fn kept(places: usize) -> usize {
    places + 2 * AROUND
}

/// A transform of a spread of unit size, with its ends repeated beyond them: what is read is one piece of memory.
#[derive(Debug, Clone, Copy)]
pub(crate) struct UnitSpectrum<const KEPT: usize>([f32; KEPT]);

impl<const KEPT: usize> UnitSpectrum<KEPT> {
    /// Of the values at its places.
    #[inline(always)]
    pub fn of(value: impl Fn(usize) -> f32) -> Self {
        let places = KEPT - 2 * AROUND;
        let mut all = [0.0f32; KEPT];
        for i in 0..places {
            all[AROUND + i] = value(i);
        }
        let [first, last] = [all[AROUND], all[AROUND + places - 1]];
        all[..AROUND].fill(first);
        all[AROUND + places..].fill(last);
        Self(all)
    }

    /// At the lowest frequency.
    pub fn lowest(&self) -> f32 {
        self.0[AROUND]
    }
}

/// Where to read a [`UnitSpectrum`] for a length: first place, and the weights of four neighbours.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LengthInterpolation {
    first: i32,
    weights: [f32; 4],
}

impl LengthInterpolation {
    /// For a spread of size `length` [mm], of a unit whose lowest frequency is `lowest`.
    #[inline(always)]
    pub fn new(length: f32, lowest: f32) -> Self {
        let steps =
            numerics::lanes::ln(length.max(1e-6) * (LOWEST_FREQUENCY as f32 / lowest)) * (1.0 / RATIO_LN as f32);
        let whole = steps.floor();
        let f = steps - whole;
        // Cubic Lagrange interpolation between the middle two of four places.
        let weights = [
            f * (1.0 - f) * (f - 2.0) * (1.0 / 6.0),
            (1.0 - f * f) * (2.0 - f) * 0.5,
            f * (1.0 + f) * (2.0 - f) * 0.5,
            f * (f * f - 1.0) * (1.0 / 6.0),
        ];
        Self { first: whole as i32 - 1, weights }
    }

    /// The transform at the fixed frequencies.
    #[inline(always)]
    pub fn read<const KEPT: usize>(&self, unit: &UnitSpectrum<KEPT>) -> Spectrum {
        let place = (self.first + AROUND as i32).clamp(0, (KEPT - AROUND) as i32) as usize;
        let near = unit.0[place..].first_chunk::<AROUND>().expect("places end where its end is repeated");
        // No closures: they would be compiled once for every machine, and this for each.
        let mut spectrum = [0.0f32; FREQUENCY_COUNT];
        for (j, &weight) in self.weights.iter().enumerate() {
            for (sum, &value) in spectrum.iter_mut().zip(&near[j..]) {
                *sum += weight * value;
            }
        }
        spectrum
    }
}

/// Places of [`LambertTransfer`]'s transform.
const TRANSFER_NODES: usize = 32;
/// Their lowest frequency [1].
const TRANSFER_LOWEST: f64 = 0.001;

/// Light from a plane to another one, by Lambert's law.
#[derive(Debug, Clone)]
pub(crate) struct LambertTransfer(UnitSpectrum<{ kept(TRANSFER_NODES) }>);

impl LambertTransfer {
    /// The transform x K1(x).
    pub fn new() -> Self {
        Self(UnitSpectrum::of(|i| lambert(TRANSFER_LOWEST * libm::exp(i as f64 * RATIO_LN)) as f32))
    }

    /// Over a distance [mm].
    #[inline(always)]
    pub fn over(&self, distance: f32) -> Spectrum {
        LengthInterpolation::new(distance, TRANSFER_LOWEST as f32).read(&self.0)
    }
}

/// x K1(x) = x int_0^inf exp(-x cosh t) cosh t dt, by the trapezoidal rule, which converges exponentially here.
fn lambert(x: f64) -> f64 {
    const STEP: f64 = 0.05;
    let at = |i: i32| {
        let cosh = libm::cosh(f64::from(i) * STEP);
        libm::exp(-x * cosh) * cosh
    };
    x * STEP * (0.5 * at(0) + (1..400).map(at).sum::<f64>())
}

/// [`lambert`] in closed form, within 2 %: its limits at 0 and far beyond [1].
#[inline(always)]
pub(super) fn nearly_lambert(x: f32) -> f32 {
    (1.0 + std::f32::consts::FRAC_PI_2 * x).sqrt() * numerics::lanes::exp(-x)
}

/// The way from transforms to weights of the fixed widths, `[FREQUENCY_COUNT][BASIS]`.
#[derive(Debug, Clone)]
pub(crate) struct WidthFit([[f32; BASIS]; FREQUENCY_COUNT]);

impl WidthFit {
    /// Makes the matrix.
    pub fn new() -> Self {
        let scale =
            |i: usize| NARROWEST_MM * libm::pow(WIDEST_MM / NARROWEST_MM, (i - 1) as f64 / (FIT_SCALES - 2) as f64);
        let columns = PACK_SPREAD_MM.map(|s| rows(f64::from(s) * f64::from(s)));
        // Quantiles of the exponential law, and sizes beside them that are spread evenly.
        let parts: [f64; FIT_PARTS] = std::array::from_fn(|k| -libm::log1p(-(k as f64 + 0.5) / FIT_PARTS as f64));
        let sizes: [f64; FIT_PARTS] = std::array::from_fn(|k| ((k + 1) as f64 * GOLDEN_RATIO).fract());
        let mut normal = [[[0.0; FREQUENCY_COUNT]; FREQUENCY_COUNT]; 2];
        let mut right = [[[0.0; BASIS]; FREQUENCY_COUNT]; 2];
        for (kind, i) in (0..FIT_KINDS[0].len()).flat_map(|kind| (0..FIT_SCALES).map(move |i| (kind, i))) {
            let square = if i == 0 { 0.0 } else { scale(i) * scale(i) };
            let variances: [f64; FIT_PARTS] = std::array::from_fn(|k| match kind {
                0 => square,
                1 => square * parts[k],
                2 => square / parts[k],
                _ => square * parts[k] * sizes[k] * sizes[k],
            });
            let variances = if kind == 0 { &variances[..1] } else { &variances };
            let share = 1.0 / variances.len() as f64;
            let (mut light, mut wave) = ([0.0; FIT_ROWS.len()], [0.0; FREQUENCY_COUNT]);
            for &variance in variances {
                light.iter_mut().zip(rows(variance)).for_each(|(sum, row)| *sum += share * row);
                let at = |i: usize| libm::exp(-0.5 * variance * frequency(i) * frequency(i));
                wave.iter_mut().enumerate().for_each(|(i, sum)| *sum += share * at(i));
            }
            let target = weights(&columns, &light);
            let all = light.iter().sum::<f64>().max(0.02);
            for (group, kinds) in FIT_KINDS.iter().enumerate() {
                // Each counts by its light in the rows.
                let count = kinds[kind] / all;
                for i in 0..FREQUENCY_COUNT {
                    for j in 0..FREQUENCY_COUNT {
                        normal[group][i][j] += count * count * wave[i] * wave[j];
                    }
                    for j in 0..BASIS {
                        right[group][i][j] += count * count * wave[i] * target[j];
                    }
                }
            }
        }
        for (normal, right) in normal.iter_mut().zip(&mut right) {
            for (i, row) in normal.iter_mut().enumerate() {
                row[i] += FIT_PENALTY * FIT_PENALTY * FIT_SCALES as f64;
            }
            solve(normal, right);
        }
        let [narrow, wide] = right;
        let right: [[f64; BASIS]; FREQUENCY_COUNT] =
            std::array::from_fn(|i| std::array::from_fn(|j| if j < FIT_WIDE { narrow[i][j] } else { wide[i][j] }));
        Self(right.map(|row| row.map(|value| value as f32)))
    }

    /// Weights of the fixed widths, none negative.
    #[inline(always)]
    pub fn weights(&self, wave: &Spectrum) -> [f32; BASIS] {
        let mut weights = [0.0f32; BASIS];
        for (value, row) in wave.iter().zip(&self.0) {
            for (weight, part) in weights.iter_mut().zip(row) {
                *weight += value * part;
            }
        }
        weights.map(|weight| weight.max(0.0))
    }
}

/// Light of a Gaussian in each row, both sides together, the laser's own width included [1].
fn rows(variance: f64) -> [f64; FIT_ROWS.len()] {
    let scale = 1.0 / (2.0 * (variance + f64::from(line_mm2()))).sqrt();
    let below = |y: f64| libm::erf(y * scale);
    FIT_ROWS.map(|row| {
        let share = 0.5 * (below((row as f64 + 0.5) * FIT_PITCH_MM) - below((row as f64 - 0.5) * FIT_PITCH_MM));
        if row == 0 { share } else { 2.0 * share }
    })
}

/// Weights of the fixed widths that give `rows` best and are not negative: coordinate descent.
fn weights(columns: &[[f64; FIT_ROWS.len()]; BASIS], rows: &[f64; FIT_ROWS.len()]) -> [f64; BASIS] {
    let most = rows.iter().copied().fold(0.0, f64::max);
    let importance = FIT_ROWS.map(|row| match row {
        0..3 => PEAK_IMPORTANCE,
        row if SCATTER_ROWS.contains(&row) => SCATTER_IMPORTANCE,
        _ => 1.0,
    });
    let count: [f64; FIT_ROWS.len()] = std::array::from_fn(|i| importance[i] / (rows[i] + FIT_FLOOR * most));
    let dot = |a: &[f64; FIT_ROWS.len()], b: &[f64; FIT_ROWS.len()]| {
        (0..FIT_ROWS.len()).map(|i| count[i] * a[i] * b[i]).sum::<f64>()
    };
    let gram: [[f64; BASIS]; BASIS] = std::array::from_fn(|i| std::array::from_fn(|j| dot(&columns[i], &columns[j])));
    let right: [f64; BASIS] = std::array::from_fn(|i| dot(&columns[i], rows));
    let mut weights = [0.0f64; BASIS];
    for _ in 0..FIT_SWEEPS {
        for i in 0..BASIS {
            let others: f64 = (0..BASIS).filter(|&j| j != i).map(|j| gram[i][j] * weights[j]).sum();
            weights[i] = ((right[i] - others) / gram[i][i]).max(0.0);
        }
    }
    weights
}

/// Solves in place with a positive definite matrix: Gauss without pivots.
fn solve(matrix: &mut [[f64; FREQUENCY_COUNT]; FREQUENCY_COUNT], right: &mut [[f64; BASIS]; FREQUENCY_COUNT]) {
    for i in 0..FREQUENCY_COUNT {
        let (pivot, values) = (matrix[i], right[i]);
        for k in 0..FREQUENCY_COUNT {
            if k == i {
                continue;
            }
            let factor = matrix[k][i] / pivot[i];
            for j in 0..FREQUENCY_COUNT {
                matrix[k][j] -= factor * pivot[j];
            }
            for j in 0..BASIS {
                right[k][j] -= factor * values[j];
            }
        }
    }
    for i in 0..FREQUENCY_COUNT {
        let pivot = matrix[i][i];
        right[i].iter_mut().for_each(|value| *value /= pivot);
    }
}

#[cfg(test)]
mod tests {
    use base::Stream;
    use rand::RngExt;

    use super::*;

    /// x K1(x) at tabulated values (Abramowitz and Stegun 1964, table 9.8), and read between the table's places.
    #[test]
    fn gap_is_a_bessel_function() {
        for (x, k1) in [(0.1, 9.853_845), (0.5, 1.656_441), (1.0, 0.601_907), (2.0, 0.139_866), (5.0, 0.004_044_613)] {
            assert!((lambert(x) - x * k1).abs() < 2e-6 * x * k1 + 1e-9, "{} against {}", lambert(x), x * k1);
        }
        let gap = LambertTransfer::new();
        for distance in [0.02f32, 0.13, 0.5, 1.7, 6.0] {
            let wave = gap.over(distance);
            for i in 0..FREQUENCY_COUNT {
                let truth = lambert(frequency(i) * f64::from(distance));
                assert!((f64::from(wave[i]) - truth).abs() < 4e-3, "{distance} mm, {i}: {} against {truth}", wave[i]);
            }
        }
    }

    /// Rows of a line of Lambert light, which are known in closed form, after the way to frequencies and back to
    /// widths: rows 1 to 8 within 4 %, rows 7 to 11 within 7 %, for gaps from 0.2 to 10 mm.
    #[test]
    fn spreads_come_back_as_widths() {
        let (gap, back) = (LambertTransfer::new(), WidthFit::new());
        let columns = PACK_SPREAD_MM.map(|s| rows(f64::from(s) * f64::from(s)));
        for distance in [0.2, 0.5, 1.0, 2.0, 5.0, 10.0] {
            let weights = back.weights(&gap.over(distance as f32));
            // int d^2 / (2 (d^2 + y^2)^(3/2)) dy
            let below = |y: f64| 0.5 * y / (distance * distance + y * y).sqrt();
            for (from, to, bar) in [(1, 8, 0.04), (7, 11, 0.07)] {
                let model: f64 = (from..=to)
                    .map(|r: usize| (0..BASIS).map(|j| f64::from(weights[j]) * columns[j][r]).sum::<f64>())
                    .sum();
                let truth = 2.0 * (below((to as f64 + 0.5) * FIT_PITCH_MM) - below((from as f64 - 0.5) * FIT_PITCH_MM));
                assert!(
                    (model / truth - 1.0).abs() < bar,
                    "{distance} mm, rows {from} to {to}: {model} against {truth}"
                );
            }
        }
    }

    /// Mixtures of two to four spreads by diffusion, by Lambert's law and as films make them, drawn at random, against
    /// their exact rows. Centres and rows 1 to 8 within 4 % for 95 % of them, rows 7 to 11 within 5 % where they hold 1
    /// % of the light, all within 1.5 % in the mean (seen: 2.2, 2.0 and 3.7 %; 0.8 % in the mean). Fitted to single
    /// Gaussians, centres were 3.4 % too bright in the mean.
    #[test]
    fn mixtures_come_back_as_widths() {
        let (back, columns) = (WidthFit::new(), PACK_SPREAD_MM.map(|s| rows(f64::from(s) * f64::from(s))));
        let mut rng = Stream::root(53).rng();
        let windows = [0..1, 1..9, SCATTER_ROWS];
        let mut off: [Vec<f64>; 3] = Default::default();
        for _ in 0..400 {
            let (mut light, mut wave) = ([0.0; FIT_ROWS.len()], [0.0f32; FREQUENCY_COUNT]);
            let shares: Vec<f64> = (0..rng.random_range(2..5)).map(|_| -libm::log1p(-rng.random::<f64>())).collect();
            for share in &shares {
                let (kind, parts) = (rng.random_range(0..3), 200);
                let size = libm::exp(rng.random_range(libm::log(0.01)..libm::log(20.0)));
                for part in 0..parts {
                    let part = -libm::log1p(-(f64::from(part) + 0.5) / f64::from(parts));
                    let variance = size
                        * size
                        * match kind {
                            0 => part,
                            1 => 1.0 / part,
                            _ => part * rng.random::<f64>().powi(2),
                        };
                    let weight = share / (shares.iter().sum::<f64>() * f64::from(parts));
                    light.iter_mut().zip(rows(variance)).for_each(|(sum, row)| *sum += weight * row);
                    for (i, sum) in wave.iter_mut().enumerate() {
                        *sum += (weight * libm::exp(-0.5 * variance * frequency(i) * frequency(i))) as f32;
                    }
                }
            }
            let weights = back.weights(&wave);
            for (off, window) in off.iter_mut().zip(windows.clone()) {
                let truth: f64 = light[window.clone()].iter().sum();
                let of = |j: usize| f64::from(weights[j]) * columns[j][window.clone()].iter().sum::<f64>();
                if window != SCATTER_ROWS || truth > 0.01 {
                    off.push((0..BASIS).map(of).sum::<f64>() / truth - 1.0);
                }
            }
        }
        for ((off, most), name) in off.iter_mut().zip([0.04, 0.04, 0.05]).zip(["centre", "rows 1 to 8", "rows 7 to 11"])
        {
            let mean = off.iter().sum::<f64>() / off.len() as f64;
            off.sort_by(|a, b| b.abs().total_cmp(&a.abs()));
            let at95 = off[off.len() / 20].abs();
            println!("{name}: {} spreads, mean {mean:+.3}, 95 % within {at95:.3}", off.len());
            assert!(mean.abs() < 0.015 && at95 < most, "{name}: mean {mean:+.3}, 95 % within {at95:.3}");
        }
    }
}
