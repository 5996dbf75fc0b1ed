//! Lengths of path of the light that a lens sees beside a line: what speckle's contrast depends on.
//!
//! Of the table's Gaussians those with long paths are wide, so light further from the line has travelled further. In
//! each row the light there has a density over the lengths of path, nearly even in the logarithm within each bin of the
//! table.
//! Neglected: that they are skewed, and the difference of media between entry and exit.

use super::table::{HalfSpaceTable, LANES, PATH_BINS};
use super::view::{CONE_BINS, group_of};
use super::{BIN_VARIANCE, SurfacePoint, after_absorption};
use multiversion::multiversion;
use numerics::lanes::{exp, ln};

/// How the lengths of path of some light lie.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathLaw {
    /// Integral of the square of their density, but for what [`Self::equal`] counts [mm^-1].
    pub crowding: f32,
    /// Standard deviation of their logarithm [1].
    pub deviation: f32,
    /// Square of the share of light whose paths are all of one length [1].
    pub equal: f32,
    /// Light there, in a unit that all places of one line share.
    pub light: f32,
}

/// Logarithm of the ratio of the ends of a bin [1].
const BIN_LOGARITHM: f32 = 0.600_21;

/// Integral of the square of the paths' density in a bin, over that of an even one: contrasts of the reference's paths
/// are 1 to 3 % higher than even bins have it [1].
const UNEVEN: f32 = 1.04;

/// Least part of light's heights that counts as light [1].
const DARK: f32 = 1e-30;

/// Light of a bin over that of the brightest that shows in no contrast [1].
const UNSEEN: f32 = 1e-4;

/// Places that are worked out together, each in a lane of its own.
const PLACES: usize = 16;

/// The paths of light that is seen `away_mm` ahead of the line, behind it where that is negative, in up to sixteen
/// places; the line and the lens blur it by `blur_mm2`. Where no light comes so far they are those of the place before.
pub fn path_laws<const N: usize>(point: &SurfacePoint, blur_mm2: f32, away_mm: [f32; N]) -> [PathLaw; N] {
    const { assert!(N <= PLACES) };
    let mut away = [0.0; PLACES];
    away[..N].copy_from_slice(&away_mm);
    let laws = laws(point, blur_mm2, &away);
    std::array::from_fn(|place| laws[place])
}

#[multiversion(targets("x86_64+avx512f+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn laws(point: &SurfacePoint, blur_mm2: f32, away: &[f32; PLACES]) -> [PathLaw; PLACES] {
    let free = 1.0 / (point.sigma_i + point.k);
    let node = HalfSpaceTable::get().between(point.n, point.sigma_i * free, point.sin_dive, point.dispersion_deg);
    let towards = point.view.towards(node.views(), point.n, point.cos_azimuth, point.view_motion);
    let (a, c2, f2) = (point.mu_a * free, point.cos_azimuth * point.cos_azimuth, free * free);
    let (mut light, mut middle) = ([0.0f32; LANES], [0.0f32; LANES]);
    let (mut variance, mut logarithm) = ([1.0f32; LANES], [0.0f32; LANES]);
    for l in 0..PATH_BINS {
        let (left, narrower) = after_absorption(a * node.path()[l]);
        let group = group_of(l);
        let along = node.variance_along()[l] * c2 * towards.along[group];
        let spread = f2 * narrower * (along + node.variance_across()[l] * (1.0 - c2) * towards.across[group]);
        variance[l] = spread + blur_mm2;
        light[l] = node.weight()[l] * left * towards.factor[group] / variance[l].sqrt();
        middle[l] = free * (point.cos_azimuth * node.along()[l] + towards.shift[group]);
        logarithm[l] = ln(node.path()[l].max(f32::MIN_POSITIVE) * free);
    }
    let (mut sum, mut first, mut second) = ([0.0f32; PLACES], [0.0f32; PLACES], [0.0f32; PLACES]);
    // Bins of cone light are the first of the rest's.
    let (mut bins, mut paths) = ([[0.0f32; PLACES]; PATH_BINS - CONE_BINS], [[0.0f32; PLACES]; PATH_BINS - CONE_BINS]);
    let most = light.iter().fold(0.0, |most: f32, light| most.max(*light));
    for l in 0..PATH_BINS {
        if light[l] <= UNSEEN * most {
            continue;
        }
        let bin = if l < CONE_BINS { l } else { l - CONE_BINS };
        let (bins, paths) = (&mut bins[bin], &mut paths[bin]);
        for n in 0..PLACES {
            let off = away[n] - middle[l];
            let part = light[l] * exp((-0.5 * off * off / variance[l]).max(-80.0));
            bins[n] += part;
            paths[n] += part * free * node.path()[l];
            sum[n] += part;
            first[n] += part * logarithm[l];
            second[n] += part * logarithm[l] * logarithm[l];
        }
    }
    let mut cubes = [0.0f32; PLACES];
    for (parts, paths) in bins.iter().zip(&paths) {
        for n in 0..PLACES {
            cubes[n] += if parts[n] > 0.0 { parts[n] * parts[n] * parts[n] / paths[n] } else { 0.0 };
        }
    }
    let mut before = PathLaw { crowding: 1.0 / free, deviation: 1.0, equal: 0.0, light: 0.0 };
    std::array::from_fn(|n| {
        if sum[n] > DARK {
            let mean = first[n] / sum[n];
            let crowding = UNEVEN * cubes[n] / (sum[n] * sum[n] * BIN_LOGARITHM);
            // A bin's own width counts too.
            let deviation = (second[n] / sum[n] - mean * mean + BIN_VARIANCE).max(BIN_VARIANCE).sqrt();
            before = PathLaw { crowding, deviation, equal: 0.0, light: 0.0 };
        }
        PathLaw { light: sum[n], ..before }
    })
}
