//! The Gaussians of light inside matter: weight and variance after each path length, for sixteen media at a time.
//!
//! The model, its sources and limits stand in `mod.rs`, which is its only user beside the contrast of speckle; the formulas here are those of docs/physics.md, in its order.

use crate::lanes::exp;

/// Share of the way to the first scattering that absorption still has to be paid for [1]; fitted.
const BALLISTIC: f32 = 0.5;
/// Persistence of the entry direction across the fibre, in mean free paths [1]; fitted.
const PERSIST_ACROSS: f32 = 0.2;
/// Persistence of the entry direction along a diving fibre, in mean free paths [1]; fitted.
const PERSIST_ALONG: f32 = 0.18;
/// Weight of cylinder scattering in turning light that runs along a diving fibre [1]; fitted.
const TURN_ALONG: f32 = 1.0;
/// Growth of the walk along the fibre of light that met cylinders alone [1]; fitted.
const CORE_WALK: f32 = 10.0;
/// Dispersion of the fibre axes, 5 degrees [rad].
const FIBRE_DISPERSION: f32 = 0.087_266;
/// Width of the cone of light that met cylinders alone, in the cosine to the fibre [1]; fitted to
/// R_cam / R_h of the 15 media. Light that met an isotropic event leaves like Lambert's, which fits within 6 %.
pub(super) const CONE_WIDTH: f32 = 0.25;

/// Path lengths of the Gaussians, log-spaced [mm]; with 32 instead, no figure of the table of media moves by 1 %.
const NODES: usize = 16;
const SHORTEST_MM: f64 = 0.003;
const LONGEST_MM: f64 = 200.0;
/// Texels worked on together.
pub(super) const LANES: usize = 16;

/// Sines and weights of a 6-point Gauss-Legendre rule on [0, pi/2] for the tensor's integral.
const SINES: [f32; 6] = [0.053_013_46, 0.262_956_75, 0.562_980_01, 0.826_470_51, 0.964_807_62, 0.998_593_8];
const WEIGHTS: [f32; 6] = [0.134_557_94, 0.283_341_48, 0.367_498_74, 0.367_498_74, 0.283_341_48, 0.134_557_94];

/// Radiance factor in the middle of the cone: flux over a half circle against Lambert's, (pi / 2) / (sqrt(2 pi) width).
pub(super) const CONE_PEAK: f32 = 0.626_657 / CONE_WIDTH;

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

/// Diffusion coefficients along and across the fibre [mm]: 1 / (3 sigma_i) and 1/4 int sin^3 / (sigma_i + k sin).
pub(crate) fn diffusion(sigma_i: f64, k: f64) -> (f64, f64) {
    let term = |(sine, weight): (f32, f32)| {
        let sine = f64::from(sine);
        0.5 * f64::from(weight) * sine.powi(3) / (sigma_i + k * sine)
    };
    (1.0 / (3.0 * sigma_i), SINES.into_iter().zip(WEIGHTS).map(term).sum())
}

/// Path lengths and their integration weights tau^-3/2 d tau / (4 sqrt(pi)).
pub(super) fn nodes() -> [(f32, f32); NODES] {
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

/// What the path lengths of [`LANES`] media share.
pub(super) struct Lanes {
    scale: [f32; LANES],
    mu_a: [f32; LANES],
    sigma_i: [f32; LANES],
    z0: [f32; LANES],
    z2: [f32; LANES],
    /// 1 / (4 D_zz) [mm^-1].
    quarter: [f32; LANES],
    d_perp: [f32; LANES],
    d_e: [f32; LANES],
    l_across: [f32; LANES],
    l_along: [f32; LANES],
    /// Share of light that stays with its cone until it meets an isotropic event.
    keep: [f32; LANES],
    pub(super) cos2_azimuth: [f32; LANES],
    core_start: [f32; LANES],
    core_walk: [f32; LANES],
    pub(super) shift: [f32; LANES],
    pub(super) cone: [f32; LANES],
}

impl Lanes {
    #[inline(always)]
    pub(super) fn new(media: &MediaRow, start: usize, count: usize) -> Self {
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
    pub(super) fn gaussians(&self, tau: f32, step: f32, l: usize) -> [(f32, f32); 2] {
        let (a, s, z0, z2) = (self.mu_a[l], self.sigma_i[l], self.z0[l], self.z2[l]);
        let (near, far) = (z0 * z0 * self.quarter[l] / tau, z2 * z2 * self.quarter[l] / tau);
        let weight = self.scale[l] * step * (z0 * exp(-near - a * tau) + z2 * exp(-far - a * tau));
        let straight = exp(-s * tau);
        let keep = self.keep[l];
        let across = 2.0 * self.d_perp[l] * persistent(tau, self.l_across[l]);
        let free = 1.0 / s;
        let turned = (tau - 2.0 * free + straight * (2.0 * free + tau)).max(0.0) / (1.0 - straight).max(1e-4);
        let along =
            keep * 2.0 * self.d_e[l] * turned + (1.0 - keep) * 2.0 * self.d_e[l] * persistent(tau, self.l_along[l]);
        let core = (self.core_start[l] + self.core_walk[l] * tau * tau * tau).min(tau * tau / 3.0);
        let w_core = weight * keep * straight;
        let c2 = self.cos2_azimuth[l];
        let sideways = across * (1.0 - c2);
        [(w_core, core * c2 + sideways), (weight - w_core, along * c2 + sideways)]
    }
}
