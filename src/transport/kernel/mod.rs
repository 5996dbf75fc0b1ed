//! Light inside matter: where a thin line of light comes out again, and towards whom.
//!
//! Model: steady anisotropic diffusion below a plane boundary, written as an integral over path length tau of Gaussians
//! (quantised diffusion, d'Eon and Irving 2011) with the tensor of cylinder scattering, D_par = 1 / (3 sigma_i),
//! D_perp = 1/4 int sin^3 / (sigma_i + k sin), source at the persistence depth z0, extrapolated boundary z_e = 2 A D_zz.
//! docs/physics.md derives each term. Five numbers in `gaussians.rs` carry what diffusion lacks near
//! the entry; they were fitted once to the 15 media of docs/physics.md (own Monte Carlo of the full transport equation).
//! Valid for media with sigma_i > mu_a and for distances up to some mm; total reflectance within 0.012, the light 0.1 to
//! 0.8 mm beside the line within 5 % on those media. Neglected: layers, finite thickness, the difference of media between
//! source and exit other than through [`SPREAD_MM`]'s symmetric blend.
//!
//! The 32 Gaussians of a medium are put on [`BASIS`] fixed widths, each shared between its two neighbours so that energy
//! and variance stay exact (wider ones count as the widest): then unlike media can be blended term by term,
//! sqrt(w_m(source) w_m(exit)), symmetric in source and exit; over a whole scan it creates no energy (Cauchy and
//! Schwarz), beside a sharp border one line position can.

use multiversion::multiversion;

mod closed;
mod gaussians;

pub use self::closed::{Beyond, solve};
pub use self::gaussians::MediaRow;
pub(crate) use self::gaussians::diffusion;
use self::gaussians::{CONE_PEAK, CONE_WIDTH, LANES, Lanes, nodes};
use crate::lanes::exp;

/// Number of fixed widths.
pub const BASIS: usize = 8;
/// Standard deviation of each fixed Gaussian along the motion, before laser and lens [mm].
pub const SPREAD_MM: [f32; BASIS] = [0.0, 0.05, 0.1, 0.18, 0.32, 0.56, 1.0, 1.8];
/// Spread across the motion over that along it, mean of wood along the grain (2.3 to 1) and of knots (1 to 1) [1].
pub const SIDEWAYS: f32 = 0.6;

/// What the media do to a line of light, structure of arrays.
#[derive(Debug, Clone, Default)]
pub struct SpreadRow {
    /// Square root of each width's weight, `[BASIS][texels]` [1].
    pub enter: [Vec<f32>; BASIS],
    /// The same times the exit's radiance factor, `[BASIS][texels]` [1].
    pub exit: [Vec<f32>; BASIS],
    /// Shift of the pattern along the motion [mm].
    pub shift: Vec<f32>,
}

impl SpreadRow {
    /// A row of `texels` texels from which nothing comes out.
    pub fn new(texels: usize) -> Self {
        let row = || vec![0.0; texels];
        Self { enter: std::array::from_fn(|_| row()), exit: std::array::from_fn(|_| row()), shift: row() }
    }
}

/// Fills `spread` for texels `from..to` of `media`.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
pub fn line_spread(media: &MediaRow, from: usize, to: usize, spread: &mut SpreadRow) {
    let nodes = nodes();
    let variance: [f32; BASIS] = SPREAD_MM.map(|s| s * s);
    let mut start = from;
    while start < to {
        let count = LANES.min(to - start);
        let lanes = Lanes::new(media, start, count);
        // What lies at width j and beyond, hats summed: cone light, then the rest.
        let mut beyond = [[[0.0f32; LANES]; BASIS + 1]; 2];
        for &(tau, step) in &nodes {
            let (mut w, mut v) = ([[0.0f32; LANES]; 2], [[0.0f32; LANES]; 2]);
            for l in 0..LANES {
                let [(w_core, v_core), (w_rest, v_rest)] = lanes.gaussians(tau, step, l);
                (w[0][l], v[0][l]) = (w_core, v_core);
                (w[1][l], v[1][l]) = (w_rest, v_rest);
            }
            for part in 0..2 {
                for l in 0..LANES {
                    beyond[part][0][l] += w[part][l];
                }
                for j in 1..BASIS {
                    let (low, inverse) = (variance[j - 1], 1.0 / (variance[j] - variance[j - 1]));
                    for l in 0..LANES {
                        beyond[part][j][l] += w[part][l] * ((v[part][l] - low) * inverse).clamp(0.0, 1.0);
                    }
                }
            }
        }
        let mut towards = [0.0f32; LANES];
        for l in 0..LANES {
            let turned = lanes.cone[l] * (1.0 / CONE_WIDTH);
            towards[l] = CONE_PEAK * exp(-0.5 * turned * turned);
        }
        for j in 0..BASIS {
            let (mut enter, mut exit) = ([0.0f32; LANES], [0.0f32; LANES]);
            for l in 0..LANES {
                let core = (beyond[0][j][l] - beyond[0][j + 1][l]).max(0.0);
                let rest = (beyond[1][j][l] - beyond[1][j + 1][l]).max(0.0);
                enter[l] = (core + rest).sqrt();
                exit[l] = (core * towards[l] + rest) / enter[l].max(1e-12);
            }
            spread.enter[j][start..start + count].copy_from_slice(&enter[..count]);
            spread.exit[j][start..start + count].copy_from_slice(&exit[..count]);
        }
        spread.shift[start..start + count].copy_from_slice(&lanes.shift[..count]);
        start += count;
    }
}

/// Where light of a fine vertical beam comes out, `[2 cells + 1, 2 cells + 1]` cells of `cell_mm`, row-major, rows along
/// the motion, share of the beam's energy a cell; the beam enters in the middle cell. Texel 0 of `media`.
///
/// The same Gaussians as [`line_spread`], each with its own variance along and across the fibre in the surface, and not
/// put on fixed widths. The rigid shift along a diving fibre is left out.
pub fn point_spread(media: &MediaRow, cells: usize, cell_mm: f64) -> Vec<f64> {
    let (sin, cos) = {
        let cos = f64::from(media.cos_azimuth[0]);
        ((1.0 - cos * cos).max(0.0).sqrt(), cos)
    };
    let seen_along = |cos2: f32| {
        let mut lanes = Lanes::new(media, 0, 1);
        lanes.cos2_azimuth[0] = cos2;
        lanes
    };
    let (along, across) = (seen_along(1.0), seen_along(0.0));
    let side = 2 * cells + 1;
    let mut spread = vec![0.0; side * side];
    for (tau, step) in nodes() {
        for ((weight, v), (_, u)) in along.gaussians(tau, step, 0).into_iter().zip(across.gaussians(tau, step, 0)) {
            // A cell blurs what is finer than itself; half a cell is the narrowest that its middle stands for.
            let blurred = |v: f32| (f64::from(v) + cell_mm * cell_mm / 12.0).max(cell_mm * cell_mm / 4.0);
            let (v, u) = (blurred(v), blurred(u));
            let peak = f64::from(weight) * cell_mm * cell_mm / (std::f64::consts::TAU * (u * v).sqrt());
            for (i, out) in spread.iter_mut().enumerate() {
                let y = ((i / side) as f64 - cells as f64) * cell_mm;
                let x = ((i % side) as f64 - cells as f64) * cell_mm;
                let (e, f) = (y * cos + x * sin, x * cos - y * sin);
                *out += peak * libm::exp(-0.5 * (e * e / v + f * f / u));
            }
        }
    }
    spread
}
