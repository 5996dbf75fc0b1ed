//! Light by length of path in a half space without absorption: the measurements behind
//! [`kernel::table`](transport::kernel::table), and how they become its entries.
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

use super::super::next_event::LensEstimator;
use super::super::plane_layers::{PreparedLayer, StackGeometry, StackObserver};
use super::super::tracker::{Geometry, Photon};
use transport::kernel::diffusion;
use transport::kernel::table::{CONE_BINS, FIRST_PATH, LANES, NODE, PATH_BINS, PATH_RATIO, VIEWS};
use transport::kernel::view::View;
use transport::stack::{CylinderPhase, Scattering, Stack};

/// Bins of path lengths that are walked; those beyond follow from diffusion.
pub(crate) const WALKED_BINS: usize = CONE_BINS;
/// Tilts against the normal [deg] and azimuths against the fibre's track, on its diving side first [deg], of the views.
pub(crate) const TILTS_DEG: [f64; 4] = [10.0, 25.0, 40.0, 60.0];
/// See [`TILTS_DEG`].
pub(crate) const AZIMUTHS_DEG: [f64; 7] = [0.0, 30.0, 60.0, 90.0, 120.0, 150.0, 180.0];
/// Absorption per mean free path at which radiance factors are measured, that of wood [1].
const VIEW_ABSORPTION: f64 = 0.02;
/// Independent batches.
const HALF_SPACE_BATCHES: u64 = 64;
/// Cone light under this share has no measured directions of its own [1].
const MIN_CONE_LIGHT: f64 = 3e-3;

/// Rate at which cylinders dispersed by s turn light that runs along them, over k s^2: by walks without end through fibres of 3 to 14
/// degrees in backgrounds of 0.08 to 0.4, within 10 % [1].
const TURNED_BY_DISPERSION: f64 = 1.55;

/// How much each tilt of [`TILTS_DEG`] counts: triangulation cameras stand between 15 and 45 degrees [1].
const SEEN_FROM: [f64; 4] = [1.0, 3.0, 1.0, 0.3];

/// A half space in optical units.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct HalfSpace {
    /// Background's share of scattering, sigma_i / (sigma_i + k) [1].
    pub rho: f64,
    /// Dive of the fibres below the surface [deg].
    pub dive_deg: f64,
    /// Refractive index [1].
    pub n: f64,
    /// Standard deviation of single fibres' tilt in each of two directions [deg].
    pub dispersion_deg: f64,
}

/// Sums over light that left after a path in one bin, per photon that entered.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct PathBin {
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
pub struct PathStatistics {
    /// Of what.
    pub of: HalfSpace,
    /// `[2][WALKED_BINS]`.
    pub bins: [[PathBin; WALKED_BINS]; 2],
    /// Light that was still inside after the last bin [1].
    pub left: f64,
    /// Radiance factors, `[2][tilts][azimuths]` [1].
    pub views: [[[f64; 7]; 4]; 2],
}

struct HalfSpaceSums {
    bins: [[PathBin; WALKED_BINS]; 2],
    left: f64,
    /// Light that left, less absorption at [`VIEW_ABSORPTION`].
    flux: [f64; 2],
    views: [[f64; 28]; 2],
}

struct HalfSpaceObserver<'a> {
    sums: HalfSpaceSums,
    lenses: &'a [LensEstimator],
}

impl StackObserver for HalfSpaceObserver<'_> {
    fn collide(&mut self, photon: &Photon, layer: &PreparedLayer, rng: &mut impl Rng) {
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
        let position = libm::log(photon.path / FIRST_PATH) / libm::log(PATH_RATIO);
        let bin = &mut self.sums.bins[part][position.clamp(0.0, WALKED_BINS as f64 - 1.0) as usize];
        let (along, across, w) = (photon.position.y, photon.position.x, photon.weight);
        bin.weight += w;
        bin.path += w * photon.path;
        bin.along += w * along;
        bin.along2 += w * along * along;
        bin.across2 += w * across * across;
        self.sums.flux[part] += w * libm::exp(-VIEW_ABSORPTION * photon.path);
    }
}

/// Walks `photons` through `of`.
pub fn measure(of: HalfSpace, photons: u64, seed: u64) -> PathStatistics {
    let (sin, cos) = libm::sincos(of.dive_deg.to_radians());
    // The diving end points along +y.
    let axis = DVec3::new(0.0, cos, -sin);
    let (sigma_i, sigma_c) = (of.rho, 1.0 - of.rho);
    let (turn, dispersion) = (CylinderPhase::Cauchy(0.0), of.dispersion_deg.to_radians());
    let fibres = Scattering::Fibres { sigma_i, sigma_c, turn, axis, dispersion };
    let geometry = StackGeometry::new(
        &Stack::half_space(of.n, 0.0, fibres),
        FIRST_PATH * libm::pow(PATH_RATIO, WALKED_BINS as f64),
    );
    let lenses: Vec<LensEstimator> = TILTS_DEG
        .iter()
        .flat_map(|tilt| AZIMUTHS_DEG.iter().map(move |azimuth| (tilt.to_radians(), azimuth.to_radians())))
        .filter_map(|(tilt, azimuth)| {
            let ((up, flat), (x, y)) = (libm::sincos(tilt), libm::sincos(azimuth));
            LensEstimator::new(&geometry, DVec3::new(up * x, up * y, flat))
        })
        .collect();
    // The same draws for every dispersion, so that they differ by less than their noise.
    let key = Stream::root(seed).child("paths");
    let key = [of.rho, of.dive_deg, of.n].iter().fold(key, |key, v| key.index(v.to_bits()));
    let each = photons.div_ceil(HALF_SPACE_BATCHES);
    let batches: Vec<HalfSpaceSums> = (0..HALF_SPACE_BATCHES)
        .into_par_iter()
        .map(|batch| {
            let mut rng = key.index(batch).rng();
            let sums = HalfSpaceSums { bins: Default::default(), left: 0.0, flux: [0.0; 2], views: [[0.0; 28]; 2] };
            let mut counter = HalfSpaceObserver { sums, lenses: &lenses };
            for _ in 0..each {
                let (position, direction) = (DVec3::ZERO, DVec3::NEG_Z);
                let photon = Photon { position, direction, weight: 1.0, layer: 0, path: 0.0, turned: 0, guided: 0 };
                geometry.track(photon, &mut counter, &mut rng);
            }
            counter.sums
        })
        .collect();
    gather(of, &batches, (each * HALF_SPACE_BATCHES) as f64)
}

/// Adds batches in their order and divides by the number of photons.
fn gather(of: HalfSpace, batches: &[HalfSpaceSums], photons: f64) -> PathStatistics {
    let mut bins = [[PathBin::default(); WALKED_BINS]; 2];
    for (part, row) in bins.iter_mut().enumerate() {
        for (i, bin) in row.iter_mut().enumerate() {
            let sum = |pick: fn(&PathBin) -> f64| batches.iter().map(|b| pick(&b.bins[part][i])).sum::<f64>() / photons;
            *bin = PathBin {
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
    PathStatistics { of, bins, left: batches.iter().map(|b| b.left).sum::<f64>() / photons, views }
}

/// The table's entry for `paths`.
///
/// Bins that were not walked follow from diffusion: weight falls like path^-3/2 from what was still inside, variances grow
/// by 2 D per path, the shift stays.
pub fn condense(paths: &PathStatistics) -> [f32; NODE] {
    let mut node = [0.0; NODE];
    let mut put = |lane: usize, values: [f64; 5]| {
        for (field, value) in values.into_iter().enumerate() {
            node[field * LANES + lane] = value as f32;
        }
    };
    for lane in 0..WALKED_BINS {
        put(lane, walked(&paths.bins[0][lane], lane));
        put(CONE_BINS + lane, walked(&paths.bins[1][lane], lane));
    }
    let (along, across) = spreading(paths);
    let last = walked(&paths.bins[1][WALKED_BINS - 1], WALKED_BINS - 1);
    let edge = |bin: usize| FIRST_PATH * libm::pow(PATH_RATIO, bin as f64);
    let start = edge(WALKED_BINS);
    for bin in WALKED_BINS..PATH_BINS - CONE_BINS {
        let (low, high) = (edge(bin), edge(bin + 1));
        let inside = |path: f64| (start / path).sqrt();
        let beyond = if bin + 1 == PATH_BINS - CONE_BINS { 0.0 } else { inside(high) };
        let path = (low * high).sqrt();
        let grown = 2.0 * (path - last[1]);
        let weight = paths.left * (inside(low) - beyond);
        put(CONE_BINS + bin, [weight, path, last[2], last[3] + along * grown, last[4] + across * grown]);
    }
    // Padding is never read; a path of 1 and a variance of 1 keep it finite.
    for lane in PATH_BINS..LANES {
        put(lane, [0.0, 1.0, 0.0, 1.0, 1.0]);
    }
    node[NODE - VIEWS..].copy_from_slice(&views(paths));
    node
}

/// Weight, mean path, mean displacement, variances of one bin; a bin without light has its middle path.
fn walked(bin: &PathBin, position: usize) -> [f64; 5] {
    if bin.weight <= 0.0 {
        let middle = FIRST_PATH * libm::pow(PATH_RATIO, position as f64 + 0.5);
        return [0.0, middle, 0.0, 0.0, 0.0];
    }
    let mean = |sum: f64| sum / bin.weight;
    let along = mean(bin.along);
    [bin.weight, mean(bin.path), along, (mean(bin.along2) - along * along).max(0.0), mean(bin.across2)]
}

/// Diffusion along the fibres' track and across it [mean free paths].
fn spreading(paths: &PathStatistics) -> (f64, f64) {
    let (rho, spread) = (paths.of.rho, paths.of.dispersion_deg.to_radians());
    let (_, d_perp) = diffusion(rho, 1.0 - rho);
    let d_par = 1.0 / (3.0 * (rho + TURNED_BY_DISPERSION * spread * spread * (1.0 - rho)));
    let sin = libm::sin(paths.of.dive_deg.to_radians());
    (d_perp * d_par / (d_perp + (d_par - d_perp) * sin * sin), d_perp)
}

/// Coefficients of the radiance factors by weighted least squares.
fn views(paths: &PathStatistics) -> [f32; VIEWS] {
    let sin_dive = libm::sin(paths.of.dive_deg.to_radians()) as f32;
    let faint = paths.bins[0].iter().map(|bin| bin.weight).sum::<f64>() < MIN_CONE_LIGHT;
    let (mut cone, mut rest) = (FourTermFit::default(), FourTermFit::default());
    for (i, tilt) in TILTS_DEG.iter().enumerate() {
        for (j, azimuth) in AZIMUTHS_DEG.iter().enumerate() {
            let (up, flat) = libm::sincos(tilt.to_radians());
            let along = up * libm::cos(azimuth.to_radians());
            let view = View::new(along as f32, flat as f32, paths.of.n as f32, sin_dive);
            let [guided, turned] = [paths.views[0][i][j], paths.views[1][i][j]];
            // Flux that the view stands for, and how much cameras look from there.
            let solid = up * flat * SEEN_FROM[i];
            if guided > 0.0 {
                // The error of a logarithm is that of the factor over it.
                cone.add(view.cone_terms(), libm::log(guided), solid * guided * guided);
            }
            rest.add(view.rest_terms(), turned, solid);
        }
    }
    let cone = if faint { [0.0; 4] } else { cone.solve() };
    let rest = rest.solve();
    std::array::from_fn(|i| if i < 4 { cone[i] } else { rest[i - 4] } as f32)
}

/// Normal equations of a least-squares fit of four coefficients.
#[derive(Default)]
struct FourTermFit {
    matrix: [[f64; 4]; 4],
    right: [f64; 4],
}

impl FourTermFit {
    fn add(&mut self, terms: [f32; 4], value: f64, weight: f64) {
        let terms = terms.map(f64::from);
        for i in 0..4 {
            self.right[i] += weight * terms[i] * value;
            for j in 0..4 {
                self.matrix[i][j] += weight * terms[i] * terms[j];
            }
        }
    }

    /// By Gauss and Jordan; a touch of ridge keeps terms at 0 that the views do not tell apart.
    fn solve(mut self) -> [f64; 4] {
        let scale = self.matrix[0][0].max(1e-12);
        for i in 0..4 {
            self.matrix[i][i] += 1e-6 * scale;
        }
        for i in 0..4 {
            let pivot = self.matrix[i][i];
            for j in 0..4 {
                self.matrix[i][j] /= pivot;
            }
            self.right[i] /= pivot;
            for row in (0..4).filter(|&row| row != i) {
                let factor = self.matrix[row][i];
                for j in 0..4 {
                    self.matrix[row][j] -= factor * self.matrix[i][j];
                }
                self.right[row] -= factor * self.right[i];
            }
        }
        self.right
    }
}
