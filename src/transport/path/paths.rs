//! What light does after each length of path in a half space without absorption: the measurements behind the table of
//! [`kernel`](crate::transport::kernel).
//!
//! Absorption only takes exp(-mu_a path) of what leaves after a path, so it need not be walked. Lengths scale with
//! 1 / (sigma_i + k); what remains is the share of the background rho = sigma_i / (sigma_i + k), the dive of the fibres
//! and the refractive index. Light that met cylinders alone ("cone light", which keeps its angle to the fibre) is
//! counted apart from the rest.

use glam::DVec3;
use procedural::Stream;
use rand::Rng;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::towards::Lens;
use super::walk::{Photon, Prepared, Tally, Walk};
use crate::transport::stack::{CylinderPhase, Scattering, Stack, WOOD_DISPERSION};

/// Ends of the first bin of path lengths, and ratio of the next ones, in mean free paths [1].
pub const FIRST: f64 = 0.05;
/// Ratio of the ends of a bin of path lengths [1].
pub const RATIO: f64 = 1.8225;
/// Bins that are walked.
pub const WALKED: usize = 14;
/// Tilts against the normal [deg] and azimuths against the fibre's track, on its diving side first [deg], of the views.
pub const TILTS_DEG: [f64; 4] = [10.0, 25.0, 40.0, 60.0];
/// See [`TILTS_DEG`].
pub const AZIMUTHS_DEG: [f64; 7] = [0.0, 30.0, 60.0, 90.0, 120.0, 150.0, 180.0];
/// Absorption per mean free path at which radiance factors are measured, that of wood [1].
const VIEW_ABSORPTION: f64 = 0.02;
/// Independent batches.
const BATCHES: u64 = 64;

/// A half space in optical units.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct HalfSpace {
    /// Background's share of scattering, sigma_i / (sigma_i + k) [1].
    pub rho: f64,
    /// Dive of the fibres below the surface [deg].
    pub dive_deg: f64,
    /// Refractive index [1].
    pub n: f64,
}

/// Sums over light that left after a path in one bin, per photon that entered.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Bin {
    /// Weight [1].
    pub weight: f64,
    /// Weight times path [mean free paths].
    pub path: f64,
    /// Times the displacement towards the diving end [mean free paths].
    pub along: f64,
    /// Times its square.
    pub along2: f64,
    /// Times the square of the displacement across.
    pub across2: f64,
}

/// All sums of a half space; cone light, then the rest.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Paths {
    /// Of what.
    pub of: HalfSpace,
    /// `[2][WALKED]`.
    pub bins: [[Bin; WALKED]; 2],
    /// Light that was still inside after the last bin [1].
    pub left: f64,
    /// Radiance factors, `[2][tilts][azimuths]` [1].
    pub views: [[[f64; 7]; 4]; 2],
}

struct Sums {
    bins: [[Bin; WALKED]; 2],
    left: f64,
    /// Light that left, less absorption at [`VIEW_ABSORPTION`].
    flux: [f64; 2],
    views: [[f64; 28]; 2],
}

struct Counter<'a> {
    sums: Sums,
    lenses: &'a [Lens],
}

impl Tally for Counter<'_> {
    fn collide(&mut self, photon: &Photon, layer: &Prepared, rng: &mut impl Rng) {
        // One view, drawn by lot, at every second collision.
        let lot = (rng.next_u64() >> 33) as usize % (2 * self.lenses.len());
        let Some(lens) = self.lenses.get(lot) else { return };
        let scale = 2.0 * self.lenses.len() as f64 * libm::exp(-VIEW_ABSORPTION * photon.path);
        let [background, cylinders] = lens.estimates(photon, layer, rng);
        self.sums.views[1][lot] += scale * background;
        self.sums.views[usize::from(photon.turned > 0)][lot] += scale * cylinders;
    }

    fn absorb(&mut self, _layer: usize, weight: f64) {
        self.sums.left += weight;
    }

    fn leave(&mut self, photon: &Photon) {
        let part = usize::from(photon.turned > 0);
        let place = libm::log(photon.path / FIRST) / libm::log(RATIO);
        let bin = &mut self.sums.bins[part][place.clamp(0.0, WALKED as f64 - 1.0) as usize];
        let (along, across, w) = (photon.place.y, photon.place.x, photon.weight);
        bin.weight += w;
        bin.path += w * photon.path;
        bin.along += w * along;
        bin.along2 += w * along * along;
        bin.across2 += w * across * across;
        self.sums.flux[part] += w * libm::exp(-VIEW_ABSORPTION * photon.path);
    }
}

/// Walks `photons` through `of`.
pub fn measure(of: HalfSpace, photons: u64, seed: u64) -> Paths {
    let (sin, cos) = libm::sincos(of.dive_deg.to_radians());
    // The diving end points along +y.
    let axis = DVec3::new(0.0, cos, -sin);
    let (sigma_i, sigma_c) = (of.rho, 1.0 - of.rho);
    let fibres =
        Scattering::Fibres { sigma_i, sigma_c, turn: CylinderPhase::Cauchy(0.0), axis, dispersion: WOOD_DISPERSION };
    let walk = Walk::new(&Stack::half_space(of.n, 0.0, fibres), FIRST * libm::pow(RATIO, WALKED as f64));
    let lenses: Vec<Lens> = TILTS_DEG
        .iter()
        .flat_map(|tilt| AZIMUTHS_DEG.iter().map(move |azimuth| (tilt.to_radians(), azimuth.to_radians())))
        .filter_map(|(tilt, azimuth)| {
            let ((up, flat), (x, y)) = (libm::sincos(tilt), libm::sincos(azimuth));
            Lens::new(&walk, DVec3::new(up * x, up * y, flat))
        })
        .collect();
    let key = Stream::root(seed).child("paths");
    let key = [of.rho, of.dive_deg, of.n].iter().fold(key, |key, v| key.index(v.to_bits()));
    let each = photons.div_ceil(BATCHES);
    let batches: Vec<Sums> = (0..BATCHES)
        .into_par_iter()
        .map(|batch| {
            let mut rng = key.index(batch).rng();
            let sums = Sums { bins: Default::default(), left: 0.0, flux: [0.0; 2], views: [[0.0; 28]; 2] };
            let mut counter = Counter { sums, lenses: &lenses };
            for _ in 0..each {
                let (place, way) = (DVec3::ZERO, DVec3::NEG_Z);
                let photon = Photon { place, way, weight: 1.0, layer: 0, path: 0.0, turned: 0, guided: 0 };
                walk.follow(photon, &mut counter, &mut rng);
            }
            counter.sums
        })
        .collect();
    gather(of, &batches, (each * BATCHES) as f64)
}

/// Adds batches in their order and divides by the number of photons.
fn gather(of: HalfSpace, batches: &[Sums], photons: f64) -> Paths {
    let mut bins = [[Bin::default(); WALKED]; 2];
    for (part, row) in bins.iter_mut().enumerate() {
        for (i, bin) in row.iter_mut().enumerate() {
            let sum = |pick: fn(&Bin) -> f64| batches.iter().map(|b| pick(&b.bins[part][i])).sum::<f64>() / photons;
            *bin = Bin {
                weight: sum(|b| b.weight),
                path: sum(|b| b.path),
                along: sum(|b| b.along),
                along2: sum(|b| b.along2),
                across2: sum(|b| b.across2),
            };
        }
    }
    let mut views = [[[0.0; 7]; 4]; 2];
    for (part, tilts) in views.iter_mut().enumerate() {
        let flux: f64 = batches.iter().map(|b| b.flux[part]).sum();
        for (i, factor) in tilts.iter_mut().flatten().enumerate() {
            let seen: f64 = batches.iter().map(|b| b.views[part][i]).sum();
            *factor = if flux > 0.0 { seen / flux } else { 0.0 };
        }
    }
    Paths { of, bins, left: batches.iter().map(|b| b.left).sum::<f64>() / photons, views }
}
