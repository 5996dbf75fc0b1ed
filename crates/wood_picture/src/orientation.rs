//! Orientation of texture about a guess, with its error: a smooth field where the texture speaks, the guess where it
//! does not.
//!
//! Model: the doubled angles q of `texture` are turned back by twice the guessed azimuth. Of a cell with the sum z of
//! its q
//!
//! ```text
//! Im z = 2 a delta + noise,  a = mean of Re z,  var = A sum q_across^2
//! ```
//!
//! with A the pixels whose gradients share their light. Both a and var are means over 4 mm, so that no cell is sure by
//! chance: the noise of speckle has no direction, but a sum of it always points somewhere. The angle delta = s phi is
//! how far azimuths are off the guess, s its spread there and phi a Gaussian field of variance 1 with Matérn's
//! correlation k r K_1(k r) (Whittle 1954; Lindgren, Rue and Lindström 2011). It makes least
//!
//! ```text
//! sum (Im z - 2 a delta)^2 / var  +  1 / (4 pi k^2) integral of ((k^2 - Laplacian) phi)^2
//! ```
//!
//! Solved by conjugate gradients, twice, the second time turned back by the first answer. Where texture tells rho of
//! information a square mm [rad^-2 mm^-2], the variance that is left follows from the field's spectrum:
//!
//! ```text
//! v = s^2 k^2 / r arctan(r / k^2),  r = sqrt(4 pi rho) s k
//! ```
//!
//! Texture: in each place the scale of streaks that tells more; rings add what a lasting error over [`RINGS_REACH_MM`]
//! leaves. Limits: streaks are related over a fibre's length and count as [`INDEPENDENT`]; the field takes no jumps.

use std::f32::consts::PI;

use crate::raster::{Beyond, around, smooth};
use crate::texture::{CellTexture, Cells};

/// Gaussian over a cell's strength and noise [mm].
const STRENGTH_MM: f32 = 4.0;
/// Cells of the field to a side of the texture's [1]: a millimetre.
const COARSER: f32 = 2.0;
/// The field's k [mm^-1], an engineering estimate: azimuths are alike over 10 mm.
const FIELD_PER_MM: f32 = 0.1;
/// Part of the texture's information that is its own [1].
const INDEPENDENT: f32 = 1.0;
/// How far rings turn from the fibre as one [mm].
const RINGS_REACH_MM: f32 = 15.0;
/// Information over which the told variance looks [mm].
const TOLD_MM: f32 = 1.5;
/// Steps of conjugate gradients at most, and the part of the first residual that is left [1].
const STEPS: usize = 400;
const LEFT: f64 = 1.0e-4;
/// Largest error that is told [rad]: directions at random have a standard deviation of 52 degrees.
pub(crate) const LOST_RAD: f32 = 0.9;

/// Orientation of cells about a guess.
#[derive(Debug, Clone)]
pub(crate) struct Orientation {
    /// Azimuth less the guess [rad].
    pub delta: Vec<f32>,
    /// Its variance [rad^2].
    pub variance: Vec<f32>,
}

/// Azimuths [rad] and their standard errors [rad] of every cell in one window.
pub(crate) fn in_window(texture: &CellTexture, cells: &Cells, width_mm: f32) -> Vec<(f32, f32)> {
    let width = width_mm / cells.side_mm;
    // The square of a Gaussian is one of width / sqrt 2, less high by 1 / (4 pi width^2).
    let narrow = width * std::f32::consts::FRAC_1_SQRT_2;
    let over = |i: usize, width: f32| smooth(&texture.sums[i], cells.size, [width; 2], Beyond::Zero);
    let [re, im] = [1, 2].map(|i| over(i, width));
    let second = [3, 4, 5].map(|i| over(i, narrow));
    let factor = texture.correlated / (4.0 * PI * width * width);
    let at = |cell: usize| {
        let (re, im) = (re[cell], im[cell]);
        let length = libm::hypotf(re, im);
        if length <= 1.0e-12 {
            return (0.0, LOST_RAD);
        }
        let (c, s) = ((re * re - im * im) / (length * length), 2.0 * re * im / (length * length));
        let across = 0.5 * (second[0][cell] - second[1][cell] * c - second[2][cell] * s);
        let error = (factor * across.max(0.0)).sqrt() / (2.0 * length);
        (0.5 * base::atan2(im, re), error.min(LOST_RAD))
    };
    (0..cells.count()).map(at).collect()
}

/// What one texture tells of delta in every cell: information [rad^-2], and that times delta [rad^-1].
fn told(texture: &CellTexture, cells: &Cells, guess: &[f32]) -> [Vec<f32>; 2] {
    let [mut re, mut im, mut across] = std::array::from_fn(|_| vec![0.0_f32; cells.count()]);
    for (cell, azimuth) in guess.iter().enumerate() {
        let (s, c) = libm::sincosf(2.0 * azimuth);
        let (x, y) = (texture.sums[1][cell], texture.sums[2][cell]);
        (re[cell], im[cell]) = (x * c + y * s, y * c - x * s);
        let (s, c) = (2.0 * s * c, c * c - s * s);
        let along = texture.sums[4][cell] * c + texture.sums[5][cell] * s;
        across[cell] = 0.5 * texture.correlated * (texture.sums[3][cell] - along).max(0.0);
    }
    // Cells at knots have fewer pixels: means go by pixels.
    let width = [STRENGTH_MM / cells.side_mm; 2];
    let [strength, noise, pixels] =
        [&re, &across, &texture.pixels].map(|values| smooth(values, cells.size, width, Beyond::Zero));
    let mut information = vec![0.0_f32; cells.count()];
    for cell in 0..cells.count() {
        let (own, near) = (texture.pixels[cell], pixels[cell].max(f32::MIN_POSITIVE));
        let (a, variance) = (strength[cell].max(0.0) * own / near, noise[cell] * own / near);
        if a > 0.0 && variance > 0.0 {
            information[cell] = INDEPENDENT * 4.0 * a * a / variance;
            im[cell] *= INDEPENDENT * 2.0 * a / variance;
        } else {
            im[cell] = 0.0;
        }
    }
    [information, im]
}

/// What all textures tell together.
fn told_by_all(textures: &[CellTexture], cells: &Cells, guess: &[f32]) -> [Vec<f32>; 2] {
    let [mut information, mut sum] = [vec![0.0_f32; cells.count()], vec![0.0_f32; cells.count()]];
    let mut most = vec![0.0_f32; cells.count()];
    for texture in textures {
        let [own, own_sum] = told(texture, cells, guess);
        let near = smooth(&own, cells.size, [STRENGTH_MM / cells.side_mm; 2], Beyond::Zero);
        for cell in 0..cells.count() {
            if texture.rings {
                let reach = RINGS_REACH_MM / cells.side_mm;
                let lasting = 4.0 * PI * reach * reach * texture.bias_rad * texture.bias_rad;
                let share = 1.0 / (1.0 + own[cell] * lasting);
                information[cell] += share * own[cell];
                sum[cell] += share * own_sum[cell];
            } else if near[cell] > most[cell] {
                most[cell] = near[cell];
                information[cell] = own[cell];
                sum[cell] = own_sum[cell];
            }
        }
    }
    [information, sum]
}

/// Orientation of every cell about `guess` of that `spread` [rad]; rings come last in `textures`.
pub(crate) fn orientation(textures: &[CellTexture], cells: &Cells, guess: &[f32], spread: &[f32]) -> Orientation {
    let coarse = Cells {
        size: cells.size.map(|count| ((count as f32 / COARSER).ceil() as usize).max(3)),
        side_mm: COARSER * cells.side_mm,
    };
    let mut counts = vec![0.0_f32; coarse.count()];
    let mut spreads = vec![0.0_f32; coarse.count()];
    let above: Vec<usize> = (0..cells.count()).map(|cell| coarse.of_place(cells.middle(cell))).collect();
    for (cell, &to) in above.iter().enumerate() {
        counts[to] += 1.0;
        spreads[to] += spread[cell];
    }
    spreads.iter_mut().zip(&counts).for_each(|(sum, count)| *sum /= f32::max(*count, 1.0));
    let mut delta = vec![0.0_f32; cells.count()];
    let mut information = Vec::new();
    for _ in 0..2 {
        let turned: Vec<f32> = guess.iter().zip(&delta).map(|(guess, delta)| guess + delta).collect();
        let [own, mut sum] = told_by_all(textures, cells, &turned);
        for cell in 0..cells.count() {
            sum[cell] += own[cell] * delta[cell];
        }
        let [mut own_coarse, mut sum_coarse] = [vec![0.0_f32; coarse.count()], vec![0.0_f32; coarse.count()]];
        for (cell, &to) in above.iter().enumerate() {
            own_coarse[to] += own[cell];
            sum_coarse[to] += sum[cell];
        }
        let field = field(&own_coarse, &sum_coarse, &spreads, &coarse);
        for cell in 0..cells.count() {
            let near = around(coarse.size, coarse.at(cells.middle(cell)));
            delta[cell] = spread[cell] * near.iter().map(|&(i, weight)| weight * field[i]).sum::<f32>();
        }
        information = own;
    }
    let density = smooth(&information, cells.size, [TOLD_MM / cells.side_mm; 2], Beyond::Same);
    let k2 = FIELD_PER_MM * FIELD_PER_MM;
    let variance = density.iter().zip(spread).map(|(own, s)| {
        let rho = own / (cells.side_mm * cells.side_mm);
        let ratio = (4.0 * PI * rho / k2).sqrt() * s;
        s * s * if ratio > 1.0e-3 { libm::atanf(ratio) / ratio } else { 1.0 }
    });
    let variance = variance.collect();
    Orientation { delta, variance }
}

/// The field phi of every cell, from information [rad^-2] and that times delta [rad^-1].
fn field(information: &[f32], sums: &[f32], spread: &[f32], cells: &Cells) -> Vec<f32> {
    let k2 = FIELD_PER_MM * FIELD_PER_MM;
    let step2 = cells.side_mm * cells.side_mm;
    let own: Vec<f32> = information.iter().zip(spread).map(|(own, s)| own * s * s).collect();
    // Once more is the square of the operator; no slope at the border keeps it symmetric.
    let once = |values: &[f32], out: &mut [f32]| {
        let [rows, cols] = cells.size;
        for row in 0..rows {
            let (above, below) = (row.saturating_sub(1) * cols, (row + 1).min(rows - 1) * cols);
            for col in 0..cols {
                let i = row * cols + col;
                let beside = values[row * cols + col.saturating_sub(1)] + values[row * cols + (col + 1).min(cols - 1)];
                let sum = values[above + col] + values[below + col] + beside;
                out[i] = k2 * values[i] - (sum - 4.0 * values[i]) / step2;
            }
        }
    };
    let prior = step2 / (4.0 * PI * k2);
    let mut half = vec![0.0_f32; own.len()];
    let mut apply = |values: &[f32], out: &mut [f32]| {
        once(values, &mut half);
        once(&half, out);
        for i in 0..out.len() {
            out[i] = prior * out[i] + own[i] * values[i];
        }
    };
    let diagonal: Vec<f32> =
        own.iter().map(|own| own + prior * ((k2 + 4.0 / step2).powi(2) + 4.0 / (step2 * step2))).collect();
    let dot = |a: &[f32], b: &[f32]| a.iter().zip(b).map(|(x, y)| f64::from(x * y)).sum::<f64>();
    let mut phi = vec![0.0_f32; own.len()];
    let mut residual: Vec<f32> = sums.iter().zip(spread).map(|(sum, s)| sum * s).collect();
    let mut ready: Vec<f32> = residual.iter().zip(&diagonal).map(|(r, d)| r / d).collect();
    let mut ahead = ready.clone();
    let mut size = dot(&residual, &ready);
    let first = size;
    let mut applied = vec![0.0_f32; own.len()];
    for _ in 0..STEPS {
        if size <= LEFT * LEFT * first {
            break;
        }
        apply(&ahead, &mut applied);
        let length = (size / dot(&ahead, &applied).max(f64::MIN_POSITIVE)) as f32;
        for i in 0..phi.len() {
            phi[i] += length * ahead[i];
            residual[i] -= length * applied[i];
            ready[i] = residual[i] / diagonal[i];
        }
        let next = dot(&residual, &ready);
        let turn = (next / size) as f32;
        size = next;
        ahead.iter_mut().zip(&ready).for_each(|(a, r)| *a = r + turn * *a);
    }
    phi
}

/// An azimuth as that of the same line in (-pi/2, pi/2] [rad].
pub(crate) fn wrap(azimuth: f32) -> f32 {
    use std::f32::consts::{FRAC_PI_2, PI};
    let turned = azimuth - PI * (azimuth / PI).round();
    if turned <= -FRAC_PI_2 { turned + PI } else { turned }
}
