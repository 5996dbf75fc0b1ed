//! Where branches sit on a stem: at the ends of the years' shoots, and between.
//!
//! Models: the stem grew by a shoot a year, of lognormal and independent lengths. At the end of a shoot sits a whorl:
//! each of six (or, for large whorls, more) buds makes a branch with the same chance, normally spread along the stem.
//! Between whorls branches sit anywhere, as a Poisson process. Buds keep apart around the stem: each takes, of five
//! azimuths drawn evenly, the one farthest from the buds within 60 mm below it (best candidate, Mitchell 1991). Source:
//! the 108 knots of the scanned log of Larsson et al. (2022). With knots within 45 mm of the next in one cluster, it
//! has 34 clusters, 21 of them of three or more. These have 4.19 knots each, lie 184 mm apart (standard deviation 100
//! mm) and are 43 mm high. Their azimuths have a mean resultant length of 0.26, where independent ones have 0.45 +-
//! 0.05, and gaps that spread by 0.40 of their mean where those spread by 0.78 +- 0.06: buds repel. Pairs of knots are
//! most frequent 0 to 20 mm and 140 to 170 mm apart, so a year is shorter than the distance of those clusters, in which
//! some years are missing and others are two in one. The parameters' defaults were fitted to these numbers together.
//! Limits: shoots do not remember the years before; no trend with age; no forks, no broken tops.

use std::f64::consts::TAU;

use base::{Stream, normal};
use rand::RngExt;

use super::super::parameters::StemParameters;

/// Branches are grown this far beyond the ends of the stem, so that those that lean in are there [mm].
const MARGIN_MM: f64 = 200.0;
/// Buds of a whorl, each of which may make a branch; more where the mean asks for it.
const BUDS: f64 = 6.0;
/// Azimuths that a bud chooses from; fitted.
const CANDIDATES: usize = 5;
/// Buds mind those this far below them [mm]; fitted.
const NEAR_MM: f64 = 60.0;

/// Where a branch begins.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bud {
    /// Along the stem [mm].
    pub height: f64,
    /// Around it [rad].
    pub azimuth: f64,
    /// It sits between two whorls.
    pub between: bool,
    /// The branch's own stream.
    pub stream: Stream,
}

/// All buds of a stem that became branches, upwards.
pub(super) fn buds(stream: Stream, numbers: &StemParameters) -> Vec<Bud> {
    let mut buds = heights(stream, numbers);
    buds.sort_by(|a, b| a.height.total_cmp(&b.height));
    for i in 0..buds.len() {
        let (below, rest) = buds.split_at_mut(i);
        let bud = &mut rest[0];
        let first = below.partition_point(|other| other.height < bud.height - NEAR_MM);
        let near = &below[first..];
        let mut rng = bud.stream.child("azimuth").rng();
        let mut farthest = f64::NEG_INFINITY;
        for _ in 0..if near.is_empty() { 1 } else { CANDIDATES } {
            let azimuth = TAU * rng.random::<f64>();
            let apart = near.iter().map(|other| {
                let turn = (azimuth - other.azimuth).rem_euclid(TAU);
                turn.min(TAU - turn)
            });
            let apart = apart.fold(TAU, f64::min);
            if apart > farthest {
                (farthest, bud.azimuth) = (apart, azimuth);
            }
        }
    }
    buds
}

/// Shoot after shoot from below the stem to above it.
fn heights(stream: Stream, numbers: &StemParameters) -> Vec<Bud> {
    let sd = numbers.whorl_spacing_log_sd;
    let mean_length = numbers.whorl_spacing_mm * libm::exp(0.5 * sd * sd);
    let slots = BUDS.max(2.0 * numbers.whorl_branches.ceil());
    let chance = numbers.whorl_branches / slots;
    let share = numbers.between_whorls;
    // Without whorls there is nothing that branches could lie between, but their number still has a meaning: that of
    // one a year.
    let per_mm = numbers.whorl_branches.max(1.0) * share / ((1.0 - share) * mean_length);
    let mut buds = Vec::new();
    let mut keep = |bud: Bud| {
        if bud.height > -MARGIN_MM && bud.height < numbers.length_mm + MARGIN_MM {
            buds.push(bud);
        }
    };
    // The first shoots only serve to forget where they began.
    let mut top = -MARGIN_MM - 5.0 * mean_length - mean_length * stream.child("start").rng().random::<f64>();
    for year in 0.. {
        let own = stream.index(year);
        let mut rng = own.rng();
        let length = numbers.whorl_spacing_mm * libm::exp(sd * normal(&mut rng));
        let base = top;
        top += length;
        for slot in 0..slots as u64 {
            let stream = own.child("whorl").index(slot);
            let mut rng = stream.rng();
            let (grows, offset) = (rng.random::<f64>() < chance, normal(&mut rng));
            if grows {
                let height = top + numbers.whorl_height_mm * offset;
                keep(Bud { height, azimuth: 0.0, between: false, stream });
            }
        }
        let mut height = base;
        for index in 0.. {
            let stream = own.child("between").index(index);
            height -= libm::log(1.0 - stream.rng().random::<f64>()) / per_mm;
            // Without any rate the first step is infinite.
            if height.is_nan() || height >= top {
                break;
            }
            keep(Bud { height, azimuth: 0.0, between: true, stream });
        }
        if base > numbers.length_mm + 2.0 * MARGIN_MM {
            break;
        }
    }
    buds
}
