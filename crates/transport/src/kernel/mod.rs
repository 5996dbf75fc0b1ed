//! Subsurface scattering kernel of production: line spread and radiance factor of a thin line of light, from a table.
//!
//! Light that leaves after a path of length tau has spread like a Gaussian (quantised diffusion, d'Eon and Irving
//! 2011); what weight, shift and variances it has was measured by Monte Carlo for a grid of half spaces without
//! absorption. Absorption is exact, exp(-mu_a tau); lengths scale with 1 / (sigma_i + k). So four numbers are left to
//! tabulate: index, background's share of scattering, dive and dispersion of the fibres. Light that met cylinders alone
//! leaves into its cone and is kept apart ([`view`]).
//!
//! The Gaussians of a medium are put on [`BASIS`] fixed widths ([`widths`]), each with its own shift; then unlike media
//! can be blended term by term, sqrt(w_m(source) w_m(exit)), symmetric in source and exit. Over a whole scan it creates
//! no energy (Cauchy and Schwarz), beside a sharp border one line position can.
//!
//! The table is of light along the normal. Light that meets a slope is looked up by its own angle to the fibres
//! ([`SurfacePoint::facing`]).
//!
//! Valid for half spaces of one medium around source and exit, slopes of some 20 degrees, fibres dispersed by 3 to 14
//! degrees. Neglected: layers, finite thickness, the difference of media between source and exit other than through the
//! blend.

mod ask;
mod diffusion_tensor;
mod doubt;
pub mod film_stack;
mod half_space;
mod path_law;
pub mod table;
pub mod view;
pub mod widths;

use base::WOOD_DISPERSION_DEG;
use glam::Vec3;
use multiversion::multiversion;

pub use self::ask::solve;
pub use self::diffusion_tensor::diffusion;
pub use self::doubt::Doubt;
pub use self::half_space::{Gaussian, KernelError, gaussians};
pub use self::path_law::{PathLaw, path_laws};
use self::table::{HalfSpaceTable, LANES, PATH_BINS};
use self::view::{FIRST_SKEWED, SKEWED_BINS, SkewedBin, View, group_of};
pub use self::widths::{BASIS, PACK_SPREAD_MM, SPREAD_MM, WidthShares};
use numerics::lanes::{exp, ln};

/// Spread across the motion over that along it, mean of wood along the grain (2.3 to 1) and of knots (1 to 1) [1].
pub const SPREAD_ACROSS_OVER_ALONG: f32 = 0.6;
/// Groups of widths that light of lamps spreads by.
pub const DIFFUSE_GROUPS: usize = 3;
/// First width of the second group and of the third.
const DIFFUSE_FROM: [usize; DIFFUSE_GROUPS - 1] = [3, 6];
/// Standard deviation of each group along the motion [mm]: nothing for the first, whose light a camera's blur hides;
/// for the others what the widths have that they hold, in clear wood.
pub const DIFFUSE_SPREAD_MM: [f32; DIFFUSE_GROUPS] = [0.0, 0.33, 1.3];
/// Greatest radiance factor of a width: that of cone light which all goes one way [1].
const MAX_FACTOR: f32 = 12.2;
/// Weight of a bin that is left out [1].
const MIN_BIN_WEIGHT: f32 = 2e-6;
/// Lanes of the table's bins and of the further halves of those that are skewed.
const HALVES: usize = LANES + SKEWED_BINS;
/// Points whose answers are dealt out together.
const POINTS_TOGETHER: usize = 32;
/// Relative variance of the paths in a bin: ln(1.8225)^2 / 12 [1].
const BIN_VARIANCE: f32 = 0.03;

/// What absorption leaves of a bin whose mean path costs `lost` = mu_a path, and how much narrower what is left lies:
/// longer paths of the bin lose more, and spread further.
#[inline(always)]
fn after_absorption(lost: f32) -> (f32, f32) {
    (exp(-lost) * (1.0 + 0.5 * BIN_VARIANCE * lost * lost), (1.0 - BIN_VARIANCE * lost).max(0.3))
}

/// One point of a surface, as light from above meets it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePoint {
    /// Absorption [mm^-1].
    pub mu_a: f32,
    /// Isotropic reduced scattering [mm^-1].
    pub sigma_i: f32,
    /// Cylinder scattering [mm^-1].
    pub k: f32,
    /// Refractive index [1].
    pub n: f32,
    /// Standard deviation of single fibres' tilt in each of two directions [deg].
    pub dispersion_deg: f32,
    /// Share of light that enters [1].
    pub enter: f32,
    /// Sine of the angle by which the fibres dive below the plane across the light that entered, not negative [1].
    pub sin_dive: f32,
    /// Cosine of the angle between the fibres' track in that plane, towards the diving end, and the motion [1].
    pub cos_azimuth: f32,
    /// The view of the lens.
    pub view: View,
    /// Part of the view along the motion, in the surface [1].
    pub view_motion: f32,
}

impl SurfacePoint {
    /// A point from which nothing comes out.
    pub const BLACK: Self = Self {
        mu_a: 1.0,
        sigma_i: 1.0,
        k: 0.0,
        n: 1.0,
        dispersion_deg: WOOD_DISPERSION_DEG,
        enter: 0.0,
        sin_dive: 0.0,
        cos_azimuth: 1.0,
        view: View { cone: 0.0, along: 0.0, up: 1.0 },
        view_motion: 0.0,
    };

    /// How many numbers a point has.
    pub const NUMBERS: usize = 12;

    /// All numbers of the point, in the order of its fields.
    #[inline(always)]
    pub fn numbers(&self) -> [f32; Self::NUMBERS] {
        let Self { mu_a, sigma_i, k, n, dispersion_deg, enter, sin_dive, cos_azimuth, view, view_motion } = *self;
        [mu_a, sigma_i, k, n, dispersion_deg, enter, sin_dive, cos_azimuth, view.cone, view.along, view.up, view_motion]
    }

    /// This point with its fibres along `fibre`, on a surface with the `normal`, lit along `light` and seen from
    /// `view`; unit vectors, y along the motion.
    ///
    /// Cylinders keep the angle between light and fibre. How light that met them spreads and where it leaves follows
    /// from the angle at which it entered, not from the angle between fibre and surface. On a slope of 10 degrees,
    /// fibres and light as before, the reflectance of clear wood stays within 0.002 and the centre of its line within 2
    /// %.
    #[inline]
    pub fn facing(self, fibre: Vec3, normal: Vec3, light: Vec3, view: Vec3) -> Self {
        let entering = -inside(-light, normal, self.n);
        let leaving = inside(view, normal, self.n);
        // The fibre's sign has no meaning: take the end that dives.
        let fibre = if fibre.dot(entering) < 0.0 { -fibre } else { fibre };
        let sin_dive = fibre.dot(entering).min(1.0);
        let flat = fibre - entering * sin_dive;
        let length = flat.length();
        let track = if length > 1e-4 { flat / length } else { Vec3::Y };
        let up = view.dot(normal);
        Self {
            sin_dive,
            cos_azimuth: track.y,
            view: View { cone: leaving.dot(fibre) - sin_dive, along: view.dot(track) - up * normal.dot(track), up },
            view_motion: view.y - up * normal.y,
            ..self
        }
    }
}

/// The unit vector in matter of index `n` that refraction at a surface with the `normal` turns into `outside`.
#[inline]
fn inside(outside: Vec3, normal: Vec3, n: f32) -> Vec3 {
    let up = outside.dot(normal);
    let cosine = (1.0 - (1.0 - up * up) / (n * n)).max(0.0).sqrt();
    outside / n + normal * (cosine - up / n)
}

/// What the media do to a line of light, structure of arrays.
#[derive(Debug, Clone, Default)]
pub struct SpreadRow {
    /// Square root of each width's weight, `[BASIS][points]` [1].
    pub enter: [Vec<f32>; BASIS],
    /// The same times the exit's radiance factor, `[BASIS][points]` [1].
    pub exit: [Vec<f32>; BASIS],
    /// Shift of each width along the motion as the lens sees it, `[BASIS][points]` [mm].
    pub shift: [Vec<f32>; BASIS],
    /// Diffuse reflectance under lamps, by group of widths, `[DIFFUSE_GROUPS][points]`; empty without lamps [1].
    pub diffuse: [Vec<f32>; DIFFUSE_GROUPS],
}

impl SpreadRow {
    /// A row of `points` points from which nothing comes out.
    pub fn new(texels: usize) -> Self {
        let row = || std::array::from_fn(|_| vec![0.0; texels]);
        Self { enter: row(), exit: row(), shift: row(), diffuse: Default::default() }
    }
}

/// Fills `spread` in these of the `points`; of lamps where their light is absorbed so many times as strongly as the
/// laser's.
#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
pub fn line_spread(
    points: &[SurfacePoint],
    which: &[u32],
    shares: &WidthShares,
    lamps: Option<f32>,
    spread: &mut SpreadRow,
) {
    let table = HalfSpaceTable::get();
    // Answers of some points are gathered, each in one piece, and dealt out together: the sums over the widths are then
    // vector code, and every array is written in runs.
    let mut answers = [[[0.0f32; BASIS]; 3]; POINTS_TOGETHER];
    let mut diffuse = [[0.0f32; DIFFUSE_GROUPS]; POINTS_TOGETHER];
    for which in which.chunks(POINTS_TOGETHER) {
        for ((answer, diffuse), &point) in answers.iter_mut().zip(&mut diffuse).zip(which) {
            (*answer, *diffuse) = surface_point_spread(&points[point as usize], table, shares, lamps);
        }
        if lamps.is_some() {
            for (group, array) in spread.diffuse.iter_mut().enumerate() {
                array.resize(points.len(), 0.0);
                for (answer, &point) in diffuse.iter().zip(which) {
                    array[point as usize] = answer[group];
                }
            }
        }
        let SpreadRow { enter, exit, shift, .. } = spread;
        for (number, arrays) in [enter, exit, shift].into_iter().enumerate() {
            for (j, array) in arrays.iter_mut().enumerate() {
                for (answer, &point) in answers.iter().zip(which) {
                    array[point as usize] = answer[number][j];
                }
            }
        }
    }
}

/// Square roots of weights, exits and shifts of one surface point, and its diffuse reflectance under lamps.
#[inline(always)]
fn surface_point_spread(
    texel: &SurfacePoint,
    table: &HalfSpaceTable,
    shares: &WidthShares,
    lamps: Option<f32>,
) -> ([[f32; BASIS]; 3], [f32; DIFFUSE_GROUPS]) {
    let scattering = texel.sigma_i + texel.k;
    let free = 1.0 / scattering;
    let node = table.between(texel.n, texel.sigma_i * free, texel.sin_dive, texel.dispersion_deg);
    let (weight, path, along) = (node.weight(), node.path(), node.along());
    let (spread_along, spread_across) = (node.variance_along(), node.variance_across());
    let (a, c2, f2) = (texel.mu_a * free, texel.cos_azimuth * texel.cos_azimuth, free * free);
    let spread_mm = &shares.spread_mm;
    let widest = spread_mm[BASIS - 1] * spread_mm[BASIS - 1];
    let towards = texel.view.towards(node.views(), texel.n, texel.cos_azimuth, texel.view_motion);
    let (mut seen_along, mut seen_across) = ([0.0f32; LANES], [0.0f32; LANES]);
    for l in 0..PATH_BINS {
        seen_along[l] = c2 * towards.along[group_of(l)];
        seen_across[l] = (1.0 - c2) * towards.across[group_of(l)];
    }
    // The further halves of skewed bins stand behind the table's bins.
    let (mut w, mut variance, mut moved) = ([0.0f32; HALVES], [0.0f32; HALVES], [0.0f32; HALVES]);
    // What is left of light of lamps, and of that over what is left of the laser's.
    let (mut lit, mut more) = ([0.0f32; LANES], [1.0f32; HALVES]);
    for l in 0..LANES {
        let (left, narrower) = after_absorption(a * path[l]);
        variance[l] = narrower * (spread_along[l] * seen_along[l] + spread_across[l] * seen_across[l]);
        w[l] = texel.enter * weight[l] * left;
    }
    if let Some(ratio) = lamps {
        for l in 0..LANES {
            lit[l] = texel.enter * weight[l] * after_absorption(ratio * a * path[l]).0;
            more[l] = lit[l] / w[l].max(1e-30);
        }
    }
    for i in 0..SKEWED_BINS {
        let near = FIRST_SKEWED + i;
        let bin = SkewedBin::new(i, towards.shift[group_of(near)], variance[near]);
        w[near] *= 0.5;
        w[LANES + i] = w[near];
        more[LANES + i] = more[near];
        [variance[near], variance[LANES + i]] = bin.variances;
        [moved[near], moved[LANES + i]] = [bin.nearer, -bin.nearer];
    }
    let mut place = [0.0f32; HALVES];
    for l in 0..HALVES {
        let variance = f2 * variance[l];
        // Beyond the widest: the height at the centre goes with one over the width.
        let all = w[l] * (widest / variance.max(widest)).sqrt();
        w[l] = if all < MIN_BIN_WEIGHT { 0.0 } else { all };
        // No `clamp`: its check of bounds that are not known beforehand would keep this from being vector code.
        place[l] = shares.place(ln(variance.max(0.0).min(widest) + widths::line_mm2()));
    }
    let (mut all, mut seen, mut moment) = ([0.0f32; BASIS], [0.0f32; BASIS], [0.0f32; BASIS]);
    let mut diffuse = [0.0f32; BASIS];
    for l in 0..HALVES {
        // Long paths of what absorbs, and padding.
        if w[l] == 0.0 {
            continue;
        }
        let bin = if l < LANES { l } else { FIRST_SKEWED + l - LANES };
        let group = group_of(bin);
        let light = w[l] * towards.factor[group];
        let displaced = light * (texel.cos_azimuth * along[bin] + towards.shift[group] + moved[l]);
        let share = shares.at(place[l]);
        for j in 0..BASIS {
            all[j] += w[l] * share[j];
            seen[j] += light * share[j];
            moment[j] += displaced * share[j];
        }
        if lamps.is_some() {
            let lit = w[l] * more[l];
            for j in 0..BASIS {
                diffuse[j] += lit * share[j];
            }
        }
    }
    let mut out = [[0.0f32; BASIS]; 3];
    for j in 0..BASIS {
        // Shares of single widths may be a little negative: what a width lacks, the lens does not see. No `clamp`,
        // whose check of its bounds would keep this from being vector code.
        let all = all[j].max(0.0);
        let seen = seen[j].max(0.0).min(MAX_FACTOR * all);
        out[0][j] = all.sqrt();
        out[1][j] = seen / out[0][j].max(1e-12);
        let reach = spread_mm[j] + free;
        out[2][j] = (free * moment[j] / seen.max(1e-9)).max(-reach).min(reach);
    }
    (out, if lamps.is_some() { in_groups(&diffuse, lit.iter().sum()) } else { [0.0; DIFFUSE_GROUPS] })
}

/// Diffuse reflectance by group of widths, `all` in sum: the widest group has what is wider than every width.
#[inline(always)]
fn in_groups(widths: &[f32; BASIS], all: f32) -> [f32; DIFFUSE_GROUPS] {
    // Not `clamp`: see above.
    let near = widths[..DIFFUSE_FROM[0]].iter().sum::<f32>().max(0.0).min(all);
    let middle = widths[DIFFUSE_FROM[0]..DIFFUSE_FROM[1]].iter().sum::<f32>().max(0.0).min(all - near);
    [near, middle, all - near - middle]
}
