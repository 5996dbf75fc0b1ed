//! Light inside matter: where a thin line of light comes out again, and towards whom.
//!
//! Model: steady anisotropic diffusion below a plane boundary, written as an integral over path length tau of Gaussians
//! (quantised diffusion, d'Eon and Irving 2011) with the tensor of cylinder scattering, D_par = 1 / (3 sigma_i),
//! D_perp = 1/4 int sin^3 / (sigma_i + k sin), source at the persistence depth z0, extrapolated boundary z_e = 2 A D_zz.
//! docs/physics.md derives each term. Four numbers below ([`BALLISTIC`] to [`CORE_WALK`]) carry what diffusion lacks near
//! the entry; they were fitted once to the 15 media of docs/physics.md (own Monte Carlo of the full transport equation).
//! Valid for media with sigma_i > mu_a and for distances up to some mm; total reflectance within 0.011, the light 0.1 to
//! 0.8 mm beside the line within 6 % on those media. Neglected: layers, finite thickness, the difference of media between
//! source and exit other than through [`SPREAD_MM`]'s symmetric blend.
//!
//! The 32 Gaussians of a medium are put on [`BASIS`] fixed widths, each shared between its two neighbours so that energy
//! and variance stay exact: then unlike media can be blended term by term, sqrt(w_m(source) w_m(exit)), which is
//! reciprocal and never creates energy (Cauchy and Schwarz).

use multiversion::multiversion;

use super::lanes::exp;

/// Number of fixed widths.
pub const BASIS: usize = 8;
/// Standard deviation of each fixed Gaussian along the motion, before laser and lens [mm].
pub const SPREAD_MM: [f32; BASIS] = [0.0, 0.05, 0.1, 0.18, 0.32, 0.56, 1.0, 1.8];
/// Spread across the motion over that along it, mean of wood along the grain (2.3 to 1) and of knots (1 to 1) [1].
pub const SIDEWAYS: f32 = 0.6;

/// Share of the way to the first scattering that absorption still has to be paid for [1]; fitted.
const BALLISTIC: f32 = 0.4;
/// Persistence of the entry direction across the fibre, in mean free paths [1]; fitted.
const PERSIST_ACROSS: f32 = 1.0 / 3.0;
/// Persistence of the entry direction along a diving fibre, in mean free paths [1]; fitted.
const PERSIST_ALONG: f32 = 0.25;
/// Weight of cylinder scattering in turning light that runs along a diving fibre [1]; fitted.
const TURN_ALONG: f32 = 0.8;
/// Growth of the walk along the fibre of light that met cylinders alone [1]; fitted.
const CORE_WALK: f32 = 5.5;
/// Dispersion of the fibre axes, 5 degrees [rad].
const FIBRE_DISPERSION: f32 = 0.087_266;
/// Radiance factor of light that met an isotropic event, over Lambert's [1]; fitted to R_cam / R_h of the 15 media.
const ISOTROPIC_EXIT: f32 = 1.02;
/// Width of the cone of light that met cylinders alone, in the cosine to the fibre [1]; fitted likewise.
const CONE_WIDTH: f32 = 0.255;

/// Path lengths of the Gaussians, log-spaced [mm].
const NODES: usize = 16;
const SHORTEST_MM: f64 = 0.003;
const LONGEST_MM: f64 = 200.0;
/// Texels worked on together.
const LANES: usize = 16;

/// Sines and weights of a 6-point Gauss-Legendre rule on [0, pi/2] for the tensor's integral.
const SINES: [f32; 6] = [0.053_013_46, 0.262_956_75, 0.562_980_01, 0.826_470_51, 0.964_807_62, 0.998_593_8];
const WEIGHTS: [f32; 6] = [0.134_557_94, 0.283_341_48, 0.367_498_74, 0.367_498_74, 0.283_341_48, 0.134_557_94];

/// Media of a row of texels, structure of arrays, all of one length.
#[derive(Debug, Clone, Default)]
pub struct MediaRow {
    /// Absorption [mm^-1].
    pub mu_a: Vec<f32>,
    /// Isotropic reduced scattering [mm^-1].
    pub sigma_i: Vec<f32>,
    /// Cylinder scattering [mm^-1].
    pub k: Vec<f32>,
    /// Boundary factor A(n) [1].
    pub boundary: Vec<f32>,
    /// Share of light that enters, 1 - R(normal) [1].
    pub enter: Vec<f32>,
    /// Sine of the fibre's angle with the surface, positive where its +y end rises [1].
    pub sin_dive: Vec<f32>,
    /// Cosine of the angle between the fibre in the surface and the motion [1].
    pub cos_azimuth: Vec<f32>,
    /// Change of the cosine to the fibre between incident and viewed light [1].
    pub cone: Vec<f32>,
}

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

impl MediaRow {
    /// A row of `texels` black texels.
    pub fn new(texels: usize) -> Self {
        let row = || vec![1.0; texels];
        Self {
            mu_a: row(),
            sigma_i: row(),
            k: row(),
            boundary: row(),
            enter: vec![0.0; texels],
            sin_dive: vec![0.0; texels],
            cos_azimuth: row(),
            cone: vec![0.0; texels],
        }
    }
}

impl SpreadRow {
    /// A row of `texels` texels from which nothing comes out.
    pub fn new(texels: usize) -> Self {
        let row = || vec![0.0; texels];
        Self { enter: std::array::from_fn(|_| row()), exit: std::array::from_fn(|_| row()), shift: row() }
    }
}

/// Path lengths and their integration weights tau^-3/2 d tau / (4 sqrt(pi)).
fn nodes() -> [(f32, f32); NODES] {
    let ratio = libm::log(LONGEST_MM / SHORTEST_MM) / (NODES as f64 - 1.0);
    std::array::from_fn(|m| {
        let tau = SHORTEST_MM * libm::exp(ratio * m as f64);
        (tau as f32, (ratio * 0.25 / (std::f64::consts::PI * tau).sqrt()) as f32)
    })
}

/// Mean square displacement over 2 D after `tau` for a walk that keeps its first direction over `l`, in mm.
#[inline(always)]
fn persistent(tau: f32, l: f32) -> f32 {
    (tau - 2.0 * l + exp(-tau / l) * (2.0 * l + tau)).max(0.0)
}

/// Eight numbers of each of [`LANES`] media that the path lengths share.
struct Lanes {
    scale: [f32; LANES],
    mu_a: [f32; LANES],
    sigma_i: [f32; LANES],
    z0: [f32; LANES],
    z2: [f32; LANES],
    /// 1 / (4 D_zz) [mm^-1].
    quarter: [f32; LANES],
    d_par: [f32; LANES],
    d_perp: [f32; LANES],
    d_e: [f32; LANES],
    l_across: [f32; LANES],
    l_along: [f32; LANES],
    /// Share of light that stays with its cone until it meets an isotropic event.
    keep: [f32; LANES],
    cos2_azimuth: [f32; LANES],
    core_start: [f32; LANES],
    core_walk: [f32; LANES],
    shift: [f32; LANES],
    cone: [f32; LANES],
}

impl Lanes {
    #[inline(always)]
    fn new(media: &MediaRow, start: usize, count: usize) -> Self {
        let load = |values: &[f32], fill: f32| -> [f32; LANES] {
            let mut lanes = [fill; LANES];
            lanes[..count].copy_from_slice(&values[start..start + count]);
            lanes
        };
        let zero = [0.0; LANES];
        let k = load(&media.k, 1.0);
        let (boundary, enter) = (load(&media.boundary, 1.0), load(&media.enter, 0.0));
        let (sin_dive, cos_azimuth) = (load(&media.sin_dive, 0.0), load(&media.cos_azimuth, 1.0));
        let (mu_a, sigma_i) = (load(&media.mu_a, 1.0), load(&media.sigma_i, 1.0));
        let cone = load(&media.cone, 0.0);
        let mut lanes = Self {
            scale: zero,
            mu_a,
            sigma_i,
            z0: zero,
            z2: zero,
            quarter: zero,
            d_par: zero,
            d_perp: zero,
            d_e: zero,
            l_across: zero,
            l_along: zero,
            keep: zero,
            cos2_azimuth: zero,
            core_start: zero,
            core_walk: zero,
            shift: zero,
            cone,
        };
        for l in 0..LANES {
            let (a, s, k) = (mu_a[l], sigma_i[l], k[l]);
            let sin2 = sin_dive[l] * sin_dive[l];
            let cos2 = (1.0 - sin2).max(0.0);
            let cos = cos2.sqrt();
            let d_par = 1.0 / (3.0 * s);
            let mut d_perp = 0.0;
            for i in 0..6 {
                d_perp += 0.5 * WEIGHTS[i] * SINES[i] * SINES[i] * SINES[i] / (s + k * SINES[i]);
            }
            let d_zz = d_perp + (d_par - d_perp) * sin2;
            let across = 1.0 / (s + k * cos);
            let z0 = cos2 * across + sin2 / s;
            lanes.z0[l] = z0;
            lanes.z2[l] = z0 + 4.0 * boundary[l] * d_zz;
            lanes.quarter[l] = 0.25 / d_zz;
            lanes.scale[l] = enter[l] * exp(-BALLISTIC * a * z0) / d_zz.sqrt();
            lanes.d_par[l] = d_par;
            lanes.d_perp[l] = d_perp;
            lanes.d_e[l] = d_perp * d_par / d_zz;
            lanes.l_across[l] = PERSIST_ACROSS * across;
            lanes.l_along[l] = PERSIST_ALONG / (s + TURN_ALONG * k * cos * sin2);
            lanes.keep[l] = cos2 * cos2 * cos2 * cos2;
            lanes.cos2_azimuth[l] = cos_azimuth[l] * cos_azimuth[l];
            lanes.core_start[l] = FIBRE_DISPERSION * FIBRE_DISPERSION * z0 * z0;
            lanes.core_walk[l] = CORE_WALK / 3.0 * FIBRE_DISPERSION * FIBRE_DISPERSION * k;
            // Towards the end of the fibre that dives, less the drift of diffusion along the slanted tensor.
            let slant = sin_dive[l] * cos;
            lanes.shift[l] = -cos_azimuth[l] * slant * ((1.0 / s - across) - (d_par - d_perp) / d_zz * z0);
        }
        lanes
    }

    /// Weight and variance along the motion of light after path `tau`: cone light, then light that has left its cone.
    #[inline(always)]
    fn gaussians(&self, tau: f32, step: f32, l: usize) -> [(f32, f32); 2] {
        let (a, s, z0, z2) = (self.mu_a[l], self.sigma_i[l], self.z0[l], self.z2[l]);
        let (near, far) = (z0 * z0 * self.quarter[l] / tau, z2 * z2 * self.quarter[l] / tau);
        let weight = self.scale[l] * step * (z0 * exp(-near - a * tau) + z2 * exp(-far - a * tau));
        let straight = exp(-s * tau);
        let keep = self.keep[l];
        let across = 2.0 * self.d_perp[l] * persistent(tau, self.l_across[l]);
        let free = 1.0 / s;
        let turned = (tau - 2.0 * free + straight * (2.0 * free + tau)).max(0.0) / (1.0 - straight).max(1e-4);
        let along =
            keep * 2.0 * self.d_par[l] * turned + (1.0 - keep) * 2.0 * self.d_e[l] * persistent(tau, self.l_along[l]);
        let core = (self.core_start[l] + self.core_walk[l] * tau * tau * tau).min(tau * tau / 3.0);
        let w_core = weight * keep * straight;
        let c2 = self.cos2_azimuth[l];
        let sideways = across * (1.0 - c2);
        [(w_core, core * c2 + sideways), (weight - w_core, along * c2 + sideways)]
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
                exit[l] = (core * towards[l] + rest * ISOTROPIC_EXIT) / enter[l].max(1e-12);
            }
            spread.enter[j][start..start + count].copy_from_slice(&enter[..count]);
            spread.exit[j][start..start + count].copy_from_slice(&exit[..count]);
        }
        spread.shift[start..start + count].copy_from_slice(&lanes.shift[..count]);
        start += count;
    }
}

/// Radiance factor in the middle of the cone: flux over a half circle against Lambert's, (pi / 2) / (sqrt(2 pi) width).
const CONE_PEAK: f32 = 0.626_657 / CONE_WIDTH;

/// Diffusion coefficients along and across the fibre [mm]: 1 / (3 sigma_i) and 1/4 int sin^3 / (sigma_i + k sin).
pub fn diffusion(sigma_i: f64, k: f64) -> (f64, f64) {
    let term = |(sine, weight): (f32, f32)| {
        let sine = f64::from(sine);
        0.5 * f64::from(weight) * sine.powi(3) / (sigma_i + k * sine)
    };
    (1.0 / (3.0 * sigma_i), SINES.into_iter().zip(WEIGHTS).map(term).sum())
}

/// Contrast of speckle in light from below after paths of different lengths, for a Gaussian laser line [1].
///
/// C^2 = sum over pairs of path lengths of w w' exp(-(pi (dlambda / lambda^2) n (tau - tau'))^2 / (2 ln 2)), Goodman's
/// rule for partial coherence; `linewidth_nm` is the full width at half maximum. Medium as in [`MediaRow`], one texel.
pub fn coherence_contrast(medium: &procedural::Medium, boundary: f64, wavelength_nm: f64, linewidth_nm: f64) -> f64 {
    const STEPS: usize = 200;
    let (a, s, k) = (f64::from(medium.mu_a), f64::from(medium.sigma_i), f64::from(medium.k));
    let (_, d_perp) = diffusion(s, k);
    let z0 = 1.0 / (s + k);
    let z2 = z0 + 4.0 * boundary * d_perp;
    let weights: Vec<(f64, f64)> = (0..STEPS)
        .map(|i| {
            let tau = SHORTEST_MM * libm::pow(LONGEST_MM / SHORTEST_MM, i as f64 / (STEPS as f64 - 1.0));
            let term = |z: f64| z * libm::exp(-z * z / (4.0 * d_perp * tau));
            (tau, (term(z0) + term(z2)) * libm::exp(-a * tau) / tau.sqrt())
        })
        .collect();
    let total: f64 = weights.iter().map(|(_, w)| w).sum();
    // Wave numbers per mm: wavelength in mm is 1e-6 of it in nm.
    let band = std::f64::consts::PI * linewidth_nm / (wavelength_nm * wavelength_nm) * 1e6 * f64::from(medium.n_eff);
    let mut sum = 0.0;
    for &(t, w) in &weights {
        for &(t2, w2) in &weights {
            let phase = band * (t - t2);
            sum += w * w2 * libm::exp(-phase * phase / (2.0 * std::f64::consts::LN_2));
        }
    }
    (sum / (total * total)).sqrt()
}
