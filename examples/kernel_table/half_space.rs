//! Light by length of path in a half space without absorption: the measurements behind
//! [`kernel::table`](transport::kernel::table), and how they become its entries.
//!
//! Absorption only takes exp(-mu_a path) of what leaves after a path, so it need not be walked. Lengths scale with
//! 1 / (sigma_i + k); what remains is the share of the background rho = sigma_i / (sigma_i + k), the dive of the fibres
//! and the refractive index. Light that met cylinders alone ("cone light", which keeps its angle to the fibre) is
//! counted apart from the rest.

use std::collections::BTreeMap;

use base::Stream;
use glam::DVec3;
use rand::Rng;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use reference::path::next_event::LensEstimator;
use reference::path::plane_layers::{PreparedLayer, StackGeometry, StackObserver};
use reference::path::tracker::{Geometry, Photon};
use transport::kernel::diffusion;
use transport::kernel::table::{FIRST_PATH, LANES, NODE, PATH_BINS, PATH_RATIO};
use transport::kernel::view::{CONE_BINS, KIND_GROUPS, VIEW_LANES, VIEW_TERMS, View, view_group};
use transport::stack::{CylinderPhase, Scattering, Stack};

/// Bins of path lengths that are walked; those beyond follow from diffusion.
const WALKED_BINS: usize = CONE_BINS;
/// Tilts against the normal [deg] and azimuths against the fibre's track, on its diving side first [deg], of the views.
const TILTS_DEG: [f64; 4] = [10.0, 25.0, 40.0, 60.0];
/// See [`TILTS_DEG`].
const AZIMUTHS_DEG: [f64; 7] = [0.0, 30.0, 60.0, 90.0, 120.0, 150.0, 180.0];
/// Views in all.
const VIEWS_MEASURED: usize = TILTS_DEG.len() * AZIMUTHS_DEG.len();
/// Independent batches.
const HALF_SPACE_BATCHES: u64 = 64;
/// One in so many collisions is looked at from all views, as a power of 2: views that are compared share their
/// collisions, and with them the noise of where these lie.
const LOOKED_AT_POWER: u32 = 5;
/// Number of the field of displacements in a table's entry.
const ALONG_FIELD: usize = 2;
/// Light of a kind after paths in two bins under this share has no measured directions of its own [1].
const MIN_GROUP_LIGHT: f64 = 1e-3;

/// Rate at which cylinders dispersed by s turn light that runs along them, over k s^2: by walks without end through
/// fibres of 3 to 14 degrees in backgrounds of 0.08 to 0.4, within 10 % [1].
const TURNED_BY_DISPERSION: f64 = 1.55;

/// How much each tilt of [`TILTS_DEG`] counts: triangulation cameras stand between 15 and 45 degrees [1].
const SEEN_FROM: [f64; 4] = [1.0, 3.0, 1.0, 0.3];

/// A half space in optical units.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MeasuredHalfSpace {
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

impl PathBin {
    fn together(bins: &[Self]) -> Self {
        let sum = |pick: fn(&Self) -> f64| bins.iter().map(pick).sum();
        Self {
            weight: sum(|bin| bin.weight),
            path: sum(|bin| bin.path),
            along: sum(|bin| bin.along),
            along2: sum(|bin| bin.along2),
            across2: sum(|bin| bin.across2),
        }
    }

    /// Variances along and across the fibres' track [mean free paths^2].
    fn variances(&self) -> [f64; 2] {
        [self.along2 / self.weight - (self.along / self.weight).powi(2), self.across2 / self.weight]
    }
}

/// All sums of a half space; cone light, then the rest.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PathStatistics {
    /// Of what.
    pub of: MeasuredHalfSpace,
    /// `[2][WALKED_BINS]`.
    pub bins: [[PathBin; WALKED_BINS]; 2],
    /// Light that was still inside after the last bin [1].
    pub left: f64,
    /// Light towards the views by kind, two bins together, `[2][KIND_GROUPS][views]`.
    pub seen: Vec<Seen>,
}

/// Light towards a view after a path in two bins, per photon that entered; serialised as nine numbers.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Seen(
    /// Radiance factor [1].
    pub f64,
    /// Times the displacement of where it leaves, towards the diving end and across it to the right [mean free paths].
    pub [f64; 2],
    /// Times the squares of both, and their product [mean free paths^2].
    pub [f64; 3],
    /// Times (along, along, along), (along, along, across), (along, across, across), (across, across, across) [mean
    /// free paths^3].
    pub [f64; 4],
);

impl Seen {
    /// Adds `light` that leaves at `along` and `across` [mean free paths].
    fn add(&mut self, light: f64, along: f64, across: f64) {
        let Self(sum, first, second, third) = self;
        *sum += light;
        for (sum, place) in first.iter_mut().zip([along, across]) {
            *sum += light * place;
        }
        let squares = [along * along, across * across, along * across];
        for (sum, square) in second.iter_mut().zip(squares) {
            *sum += light * square;
        }
        let cubes = [along * squares[0], across * squares[0], along * squares[1], across * squares[1]];
        for (sum, cube) in third.iter_mut().zip(cubes) {
            *sum += light * cube;
        }
    }
}

struct HalfSpaceSums {
    bins: [[PathBin; WALKED_BINS]; 2],
    left: f64,
    seen: Vec<Seen>,
}

struct HalfSpaceObserver<'a> {
    sums: HalfSpaceSums,
    lenses: &'a [LensEstimator],
}

impl StackObserver for HalfSpaceObserver<'_> {
    fn collide(&mut self, photon: &Photon, layer: &PreparedLayer, rng: &mut impl Rng) {
        if rng.next_u64() >> (64 - LOOKED_AT_POWER) != 0 {
            return;
        }
        let stands_for = f64::from(1u32 << LOOKED_AT_POWER);
        for (view, lens) in self.lenses.iter().enumerate() {
            let [background, cylinders] = lens.estimates(photon, layer, rng);
            let (exit, way) = lens.exit(photon);
            let group = bin(photon.path + way) / 2;
            let mut add = |part: usize, light: f64| {
                let sum = &mut self.sums.seen[(part * KIND_GROUPS + group) * VIEWS_MEASURED + view];
                sum.add(light * stands_for, exit.y, exit.x);
            };
            add(1, background);
            add(usize::from(photon.turned > 0), cylinders);
        }
    }

    fn absorb(&mut self, _layer: usize, weight: f64) {
        self.sums.left += weight;
    }

    fn leave(&mut self, photon: &Photon) {
        let part = usize::from(photon.turned > 0);
        let bin = &mut self.sums.bins[part][bin(photon.path)];
        let (along, across, w) = (photon.position.y, photon.position.x, photon.weight);
        bin.weight += w;
        bin.path += w * photon.path;
        bin.along += w * along;
        bin.along2 += w * along * along;
        bin.across2 += w * across * across;
    }
}

/// The bin of a path.
fn bin(path: f64) -> usize {
    let position = libm::log(path / FIRST_PATH) / libm::log(PATH_RATIO);
    position.clamp(0.0, WALKED_BINS as f64 - 1.0) as usize
}

/// Walks `photons` through `of`.
pub fn measure(of: MeasuredHalfSpace, photons: u64, seed: u64) -> PathStatistics {
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
            let seen = vec![Seen::default(); 2 * KIND_GROUPS * VIEWS_MEASURED];
            let sums = HalfSpaceSums { bins: Default::default(), left: 0.0, seen };
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
fn gather(of: MeasuredHalfSpace, batches: &[HalfSpaceSums], photons: f64) -> PathStatistics {
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
    let seen = (0..batches[0].seen.len()).map(|i| {
        let sum = |pick: &dyn Fn(&Seen) -> f64| batches.iter().map(|b| pick(&b.seen[i])).sum::<f64>() / photons;
        Seen(
            sum(&|seen| seen.0),
            std::array::from_fn(|k| sum(&|seen| seen.1[k])),
            std::array::from_fn(|k| sum(&|seen| seen.2[k])),
            std::array::from_fn(|k| sum(&|seen| seen.3[k])),
        )
    });
    let left = batches.iter().map(|b| b.left).sum::<f64>() / photons;
    PathStatistics { of, bins, left, seen: seen.collect() }
}

/// The table's entries for all half spaces, in their order.
///
/// How far light that the background turned has moved, and how it goes to views, changes slowly with index and
/// dispersion. These numbers are taken from a fit over all indices and dispersions of a share and a dive, quadratic in
/// the index and in the dispersion's logarithm, which halves their noise.
pub fn table(all: &[PathStatistics]) -> Vec<[f32; NODE]> {
    let mut nodes: Vec<[f32; NODE]> = all.iter().map(condense).collect();
    let mut alike: BTreeMap<[u64; 2], Vec<usize>> = BTreeMap::new();
    for (i, paths) in all.iter().enumerate() {
        alike.entry([paths.of.rho.to_bits(), paths.of.dive_deg.to_bits()]).or_default().push(i);
    }
    let displacement = |bin: usize| ALONG_FIELD * LANES + CONE_BINS + bin;
    let walked = (0..WALKED_BINS).map(displacement);
    let views = (0..VIEW_TERMS).flat_map(|term| {
        let first = NODE - (VIEW_TERMS - term) * VIEW_LANES;
        (0..KIND_GROUPS).map(move |group| first + view_group(false, 2 * group))
    });
    let numbers: Vec<usize> = walked.chain(views).collect();
    for places in alike.values() {
        let terms = |i: usize| {
            let MeasuredHalfSpace { n, dispersion_deg, .. } = all[i].of;
            let dispersion = libm::log(dispersion_deg);
            [1.0, n, n * n, dispersion, dispersion * dispersion].map(|term| term as f32)
        };
        for &at in &numbers {
            let mut fit = LeastSquares::<5>::default();
            for &i in places {
                fit.add(terms(i), f64::from(nodes[i][at]), 1.0);
            }
            let coefficients = fit.solve();
            for &i in places {
                let value = |(a, b): (&f64, f32)| a * f64::from(b);
                nodes[i][at] = coefficients.iter().zip(terms(i)).map(value).sum::<f64>() as f32;
            }
        }
        for &i in places {
            for bin in WALKED_BINS..PATH_BINS - CONE_BINS {
                nodes[i][displacement(bin)] = nodes[i][displacement(WALKED_BINS - 1)];
            }
        }
    }
    nodes
}

/// Third central moments of light of the rest to a view, along its azimuth, over its shift times its variance, by
/// group; and how well they go together (correlation about 0) [1].
pub fn skewness(all: &[PathStatistics]) -> [[f64; 2]; KIND_GROUPS] {
    std::array::from_fn(|group| {
        let (mut both, mut shifts, mut thirds) = (0.0, 0.0, 0.0);
        for paths in all {
            let views = measured_views(paths.of);
            let seen = seen_of(paths, 1, group);
            let (light, along) = over_all_views(seen, &views);
            if light <= MIN_GROUP_LIGHT {
                continue;
            }
            for (s, v) in seen.iter().zip(&views).filter(|(s, _)| s.0 > 0.0) {
                let tilt = f64::from(v.view.along).hypot(v.across);
                let (c, r) = (f64::from(v.view.along) / tilt, v.across / tilt);
                let mean = (c * s.1[0] + r * s.1[1]) / s.0;
                let square = (c * c * s.2[0] + r * r * s.2[1] + 2.0 * c * r * s.2[2]) / s.0;
                let cube = c * c * c * s.3[0] + 3.0 * c * r * (c * s.3[1] + r * s.3[2]) + r * r * r * s.3[3];
                let variance = square - mean * mean;
                if variance > 0.0 {
                    let third = (cube / s.0 - 3.0 * mean * square + 2.0 * mean.powi(3)) / variance.powf(1.5);
                    let (shift, weight) = ((mean - c * along / light) / variance.sqrt(), v.fitted * s.0);
                    both += weight * shift * third;
                    shifts += weight * shift * shift;
                    thirds += weight * third * third;
                }
            }
        }
        [both / shifts, both / (shifts * thirds).sqrt()]
    })
}

/// What was seen of a kind of light after the paths of a group, by view.
fn seen_of(paths: &PathStatistics, part: usize, group: usize) -> &[Seen] {
    let start = (part * KIND_GROUPS + group) * VIEWS_MEASURED;
    &paths.seen[start..start + VIEWS_MEASURED]
}

/// Light over all views and its displacement along the fibres' track, times the light. The mean over all views stands
/// for all directions; what it lacks as a quadrature is alike in all groups.
fn over_all_views(seen: &[Seen], views: &[MeasuredView]) -> (f64, f64) {
    let sum = |pick: fn(&Seen) -> f64| seen.iter().zip(views).map(|(s, v)| v.share * pick(s)).sum::<f64>();
    (sum(|s| s.0), sum(|s| s.1[0]))
}

/// The table's entry for `paths`.
///
/// Bins that were not walked follow from diffusion: what is still inside falls like (path + c)^-1/2, variances grow by
/// 2 D per path, the shift stays.
fn condense(paths: &PathStatistics) -> [f32; NODE] {
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
    let late = lateness(paths, edge(WALKED_BINS - 1), start);
    for bin in WALKED_BINS..PATH_BINS - CONE_BINS {
        let (low, high) = (edge(bin), edge(bin + 1));
        let inside = |path: f64| ((start + late) / (path + late)).sqrt();
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
    for (term, lanes) in towards_views(paths).iter().enumerate() {
        let start = NODE - (VIEW_TERMS - term) * VIEW_LANES;
        node[start..start + VIEW_LANES].copy_from_slice(&lanes.map(|value| value as f32));
    }
    node
}

/// The path c by which light that diffuses leaves later than from an open plane, from what left in the last walked bin
/// between the paths `from` and `to`. It grows with the light that the surface throws back and with the free paths
/// along straight fibres, to more than `to` [mean free paths].
fn lateness(paths: &PathStatistics, from: f64, to: f64) -> f64 {
    let left_last: f64 = paths.bins.iter().map(|kind| kind[WALKED_BINS - 1].weight).sum();
    let ratio = ((paths.left + left_last) / paths.left).powi(2);
    ((to - ratio * from) / (ratio - 1.0)).max(0.0)
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

/// Coefficients of radiance factors, shifts and variances of light towards a view, `[VIEW_TERMS][VIEW_LANES]`, by
/// weighted least squares.
fn towards_views(paths: &PathStatistics) -> [[f64; VIEW_LANES]; VIEW_TERMS] {
    let views = measured_views(paths.of);
    let mut lanes = [[0.0; VIEW_LANES]; VIEW_TERMS];
    let mut put = |part: usize, group: usize, coefficients: [f64; VIEW_TERMS]| {
        for (term, value) in coefficients.into_iter().enumerate() {
            lanes[term][view_group(part == 0, 2 * group)] = value;
        }
    };
    let all = |group: usize| over_all_views(seen_of(paths, 1, group), &views);
    let left: f64 = paths.bins[1].iter().map(|bin| bin.weight).sum();
    let looked: f64 = (0..KIND_GROUPS).map(|group| all(group).0).sum();
    let mut before =
        [joined([0.0; 4], [0.0; 3], [1.0, 0.0, 1.0]), joined([1.0, 0.0, 0.0, 0.0], [0.0; 3], [1.0, 0.0, 1.0])];
    for group in 0..KIND_GROUPS {
        let sum = PathBin::together(&paths.bins[0][2 * group..2 * group + 2]);
        if sum.weight > MIN_GROUP_LIGHT {
            let seen = seen_of(paths, 0, group);
            let factor = cone_fit(seen, &views, sum.weight);
            let shift = shift_fit(seen, &views, sum.along / sum.weight);
            before[0] = joined(factor, shift, variance_fit(seen, &views, sum.variances()));
        }
        let (weight, along) = all(group);
        if weight > MIN_GROUP_LIGHT {
            let seen = seen_of(paths, 1, group);
            let factor = rest_fit(seen, &views, weight * left / looked);
            let variances = PathBin::together(&paths.bins[1][2 * group..2 * group + 2]).variances();
            before[1] = joined(factor, shift_fit(seen, &views, along / weight), variance_fit(seen, &views, variances));
        }
        // Where there is no light to speak of, as after a shorter path.
        put(0, group, before[0]);
        put(1, group, before[1]);
    }
    lanes
}

/// A measured view of a half space.
struct MeasuredView {
    view: View,
    /// Of the view, across the track.
    across: f64,
    /// Share of Lambert light that it stands for [1].
    share: f64,
    /// Weight in fits: flux that the view stands for, and how much cameras look from there.
    fitted: f64,
}

fn measured_views(of: MeasuredHalfSpace) -> Vec<MeasuredView> {
    let sin_dive = libm::sin(of.dive_deg.to_radians()) as f32;
    let mut views = Vec::new();
    for (i, tilt) in TILTS_DEG.iter().enumerate() {
        // Rings of tilts, halfway to the neighbours.
        let edge = |a: usize| libm::sin((0.5 * (TILTS_DEG[a] + TILTS_DEG[a + 1])).to_radians());
        let inner = if i == 0 { 0.0 } else { edge(i - 1) };
        let outer = if i + 1 == TILTS_DEG.len() { 1.0 } else { edge(i) };
        for (j, azimuth) in AZIMUTHS_DEG.iter().enumerate() {
            let (up, flat) = libm::sincos(tilt.to_radians());
            let (across, along) = libm::sincos(azimuth.to_radians());
            let ends = j == 0 || j + 1 == AZIMUTHS_DEG.len();
            let arc = if ends { 0.5 } else { 1.0 } / (AZIMUTHS_DEG.len() - 1) as f64;
            views.push(MeasuredView {
                view: View::new((up * along) as f32, flat as f32, of.n as f32, sin_dive),
                across: up * across,
                share: (outer * outer - inner * inner) * arc,
                fitted: up * flat * SEEN_FROM[i],
            });
        }
    }
    views
}

/// Of cone light of which `weight` left.
///
/// Cone light has one bright direction: away from it the factor falls. Where the views see one flank alone the
/// logarithm can come out convex, and would rise again where there is no light; it is then fitted as linear in the
/// change of the cosine.
fn cone_fit(seen: &[Seen], views: &[MeasuredView], weight: f64) -> [f64; 4] {
    let (mut factor, mut flank) = (LeastSquares::<4>::default(), LeastSquares::<3>::default());
    for (s, v) in seen.iter().zip(views) {
        let towards = s.0 / weight;
        if towards > 0.0 {
            let terms = v.view.cone_terms();
            // The error of a logarithm is that of the factor over it.
            let (value, weight) = (libm::log(towards), v.fitted * towards * towards);
            factor.add(terms, value, weight);
            flank.add([terms[0], terms[1], terms[3]], value, weight);
        }
    }
    let fitted = factor.solve();
    if fitted[2] <= 0.0 {
        return fitted;
    }
    let [constant, slope, tilt] = flank.solve();
    [constant, slope, 0.0, tilt]
}

/// Of light that the background turned.
fn rest_fit(seen: &[Seen], views: &[MeasuredView], weight: f64) -> [f64; 4] {
    let mut factor = LeastSquares::<4>::default();
    for (s, v) in seen.iter().zip(views) {
        factor.add(v.view.rest_terms(), s.0 / weight, v.fitted);
    }
    factor.solve()
}

fn joined(factor: [f64; 4], shift: [f64; 3], variance: [f64; 3]) -> [f64; VIEW_TERMS] {
    let mut all = factor.into_iter().chain(shift).chain(variance);
    std::array::from_fn(|_| all.next().expect("there are as many coefficients as terms"))
}

/// Shift against light to all directions: constant, by the view along the track, by the view across it.
fn shift_fit(seen: &[Seen], views: &[MeasuredView], along: f64) -> [f64; 3] {
    let (mut track, mut beside) = (LeastSquares::<2>::default(), LeastSquares::<1>::default());
    for (s, v) in seen.iter().zip(views) {
        if s.0 > 0.0 {
            track.add([1.0, v.view.along], s.1[0] / s.0 - along, v.fitted * s.0);
            beside.add([v.across as f32], s.1[1] / s.0, v.fitted * s.0);
        }
    }
    let ([constant, slope], [across]) = (track.solve(), beside.solve());
    [constant, slope, across]
}

/// Variances over those of light to all directions, `[along, across]`: along the track constant and by the view along
/// it, across it constant.
fn variance_fit(seen: &[Seen], views: &[MeasuredView], all: [f64; 2]) -> [f64; 3] {
    if all[0] <= 0.0 || all[1] <= 0.0 {
        return [1.0, 0.0, 1.0];
    }
    let (mut track, mut beside) = (LeastSquares::<2>::default(), LeastSquares::<1>::default());
    for (s, v) in seen.iter().zip(views) {
        if s.0 > 0.0 {
            let variance = |square: f64, mean: f64| square / s.0 - (mean / s.0).powi(2);
            track.add([1.0, v.view.along], variance(s.2[0], s.1[0]) / all[0], v.fitted * s.0);
            beside.add([1.0], variance(s.2[1], s.1[1]) / all[1], v.fitted * s.0);
        }
    }
    let ([constant, slope], [across]) = (track.solve(), beside.solve());
    [constant, slope, across]
}

/// Normal equations of a least-squares fit of `N` coefficients.
struct LeastSquares<const N: usize> {
    matrix: [[f64; N]; N],
    right: [f64; N],
}

impl<const N: usize> Default for LeastSquares<N> {
    fn default() -> Self {
        Self { matrix: [[0.0; N]; N], right: [0.0; N] }
    }
}

impl<const N: usize> LeastSquares<N> {
    fn add(&mut self, terms: [f32; N], value: f64, weight: f64) {
        let terms = terms.map(f64::from);
        for i in 0..N {
            self.right[i] += weight * terms[i] * value;
            for j in 0..N {
                self.matrix[i][j] += weight * terms[i] * terms[j];
            }
        }
    }

    /// By Gauss and Jordan; a touch of ridge keeps terms at 0 that the views do not tell apart.
    fn solve(mut self) -> [f64; N] {
        let scale = self.matrix[0][0].max(1e-12);
        for i in 0..N {
            self.matrix[i][i] += 1e-7 * scale;
        }
        for i in 0..N {
            let pivot = self.matrix[i][i];
            for j in 0..N {
                self.matrix[i][j] /= pivot;
            }
            self.right[i] /= pivot;
            for row in (0..N).filter(|&row| row != i) {
                let factor = self.matrix[row][i];
                for j in 0..N {
                    self.matrix[row][j] -= factor * self.matrix[i][j];
                }
                self.right[row] -= factor * self.right[i];
            }
        }
        self.right
    }
}
