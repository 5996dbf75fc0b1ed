//! Where a scan lies among others.
//!
//! **One statistic.** With m the median of simulated scans and e the farthest of them on the side of the scan's number
//! x, the scan lies r = |x - m| / |e - m| of the way out. Above 1 it lies beyond all simulated scans.
//!
//! **All together.** Distances from the medians in robust deviations (from 5 to 95 %), z, have the covariance C of
//! numbers drawn in to [`WINSOR`] deviations (winsorised: Huber 1981), with a little independent scatter, [`RIDGE`], in
//! each. Depth is the Mahalanobis distance, the root of z^T C^-1 z.
//!
//! **Calibration.** Each simulated scan is asked in turn where it lies among the others: of so many scans the share
//! [`ALARMS`] lies beyond the limits of r, all statistics together, and the same share beyond that of depth. So a scan
//! that the recipe could have made raises an alarm once in a hundred, whatever the laws of the statistics are.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use rayon::prelude::*;
use tools::compare::summary::{SummaryLaw, SummaryStatistic};

use crate::emulator::cholesky;

/// Share of the scans of the recipe itself that each of both limits lets out.
const ALARMS: f64 = 0.005;
/// Deviations to which numbers are drawn in where correlations are taken.
const WINSOR: f64 = 3.0;
/// Variance that is added to that of each statistic: what goes together more closely is not known from so few scans.
/// More would hide what lies across.
const RIDGE: f64 = 0.01;
/// Share of scans that must tell a statistic for it to have a part in depth.
const MOSTLY: f64 = 0.9;
/// Fewest scans that tell a statistic from which its spread is known.
const FEWEST: usize = 40;
/// Width from 5 to 95 % of a normal law [standard deviations].
const INNER: f64 = 3.289_707_253_902_945;
/// Least distance of the farthest scan from the median, in the scale of a statistic's law: one part in twenty. Of
/// shares it is a factor e, since single pixels are steps near 0 and 1.
const LEAST_REACH: f64 = 0.05;
const LEAST_REACH_OF_SHARES: f64 = 1.0;

/// The numbers of simulated scans in one statistic.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct StatisticSpread {
    /// 5, 50 and 95 %.
    pub three: [f64; 3],
    /// How far the farthest scans lie below and above the median.
    reach: [f64; 2],
}

impl StatisticSpread {
    /// Of numbers; `None` of few.
    pub fn new(mut numbers: Vec<f64>, law: SummaryLaw) -> Option<Self> {
        if numbers.len() < FEWEST {
            return None;
        }
        numbers.sort_by(f64::total_cmp);
        let three = quantiles(&numbers);
        let least = if law == SummaryLaw::Share { LEAST_REACH_OF_SHARES } else { LEAST_REACH };
        let ends = [numbers[0], numbers[numbers.len() - 1]];
        Some(Self { three, reach: ends.map(|end| (end - three[1]).abs().max(least)) })
    }

    /// How far out a number lies: 0 at the median, 1 or less where a simulated scan lies as far.
    pub fn out(&self, number: f64) -> f64 {
        let apart = number - self.three[1];
        apart.abs() / self.reach[usize::from(apart > 0.0)]
    }

    /// Robust deviation.
    pub fn deviation(&self) -> f64 {
        let [low, _, high] = self.three;
        ((high - low) / INNER).max(self.reach[0].max(self.reach[1]) / 10.0)
    }
}

/// 5, 50 and 95 % of sorted numbers, of which there is one at least.
fn quantiles(sorted: &[f64]) -> [f64; 3] {
    [0.05, 0.5, 0.95].map(|share| {
        let place = share * (sorted.len() - 1) as f64;
        let (i, part) = (place as usize, place.fract());
        sorted[i] + part * (sorted[(i + 1).min(sorted.len() - 1)] - sorted[i])
    })
}

/// Simulated scans as a cloud of points.
#[derive(Debug, Clone)]
pub(crate) struct ScanSpread {
    /// Of each statistic; `None` where too few scans tell it, or it is not asked for.
    pub statistics: Vec<Option<StatisticSpread>>,
    /// Statistics that depth is of.
    pub joint: Vec<usize>,
    whiten: Cholesky<f64, Dyn>,
}

/// Limits beyond which a scan lies outside.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct SpreadLimits {
    /// Of [`StatisticSpread::out`], at least 1.
    pub out: f64,
    /// Of [`ScanSpread::depth`].
    pub depth: f64,
    /// Depths of the simulated scans, sorted.
    pub depths: Vec<f64>,
}

impl ScanSpread {
    /// Of scans, without those of `left_out`, in the statistics that `asked` tells; the first `whole` are of whole
    /// scans, and those alone have a part in depth.
    pub fn new(
        scans: &[Vec<Option<f64>>],
        left_out: Option<usize>,
        like: &[SummaryStatistic],
        whole: usize,
        asked: &dyn Fn(usize) -> bool,
    ) -> Self {
        let kept = || scans.iter().enumerate().filter(|(i, _)| Some(*i) != left_out).map(|(_, scan)| scan);
        let n = kept().count();
        let of = |j: usize| {
            let told: Vec<f64> = if asked(j) { kept().filter_map(|scan| scan[j]).collect() } else { Vec::new() };
            let is_joint = j < whole && told.len() as f64 >= MOSTLY * n as f64;
            StatisticSpread::new(told, like[j].law).map(|spread| (spread, is_joint))
        };
        let found: Vec<_> = (0..like.len()).map(of).collect();
        let joint: Vec<usize> = (0..like.len()).filter(|&j| found[j].is_some_and(|(_, is_joint)| is_joint)).collect();
        let statistics: Vec<Option<StatisticSpread>> = found.into_iter().map(|found| Some(found?.0)).collect();
        let mut spread = Self { statistics, joint, whiten: cholesky(&DMatrix::identity(0, 0)) };
        let rows: Vec<_> =
            kept().map(|scan| spread.standard(scan).map(|z| z.clamp(-WINSOR, WINSOR)).transpose()).collect();
        if !spread.joint.is_empty() && !rows.is_empty() {
            let (numbers, count) = (DMatrix::from_rows(&rows), spread.joint.len());
            let covariance = numbers.tr_mul(&numbers) / n as f64;
            spread.whiten = cholesky(&(covariance + DMatrix::identity(count, count) * RIDGE));
        }
        spread
    }

    /// A scan's distances from the medians of the joint statistics, in robust deviations; 0 where it tells nothing.
    pub fn standard(&self, scan: &[Option<f64>]) -> DVector<f64> {
        let of = |&j: &usize| {
            let (spread, number) = (self.statistics[j].as_ref()?, scan[j]?);
            Some((number - spread.three[1]) / spread.deviation())
        };
        DVector::from_iterator(self.joint.len(), self.joint.iter().map(|j| of(j).unwrap_or(0.0)))
    }

    /// Distance from the middle of the cloud.
    pub fn depth(&self, standard: &DVector<f64>) -> f64 {
        standard.dot(&self.whiten.solve(standard)).max(0.0).sqrt()
    }

    /// A point in directions of unit scatter.
    pub fn whitened(&self, standard: &DVector<f64>) -> DVector<f64> {
        self.whiten.l().solve_lower_triangular(standard).unwrap_or_else(|| standard.clone())
    }

    /// How far out a scan lies in each statistic.
    pub fn out(&self, scan: &[Option<f64>]) -> Vec<Option<f64>> {
        self.statistics.iter().zip(scan).map(|(spread, number)| Some(spread.as_ref()?.out((*number)?))).collect()
    }
}

impl SpreadLimits {
    /// From where each simulated scan lies among the others.
    pub fn new(
        scans: &[Vec<Option<f64>>],
        like: &[SummaryStatistic],
        whole: usize,
        asked: &(dyn Fn(usize) -> bool + Sync),
    ) -> Self {
        let left_out = |i: usize| {
            let others = ScanSpread::new(scans, Some(i), like, whole, asked);
            let out = others.out(&scans[i]).into_iter().flatten().fold(0.0, f64::max);
            (out, others.depth(&others.standard(&scans[i])))
        };
        let (mut outs, mut depths): (Vec<f64>, Vec<f64>) = (0..scans.len()).into_par_iter().map(left_out).unzip();
        outs.sort_by(f64::total_cmp);
        depths.sort_by(f64::total_cmp);
        // So many scans of the recipe lie beyond; of few scans the farthest is the limit.
        let limit = |sorted: &[f64]| {
            let beyond = (ALARMS * sorted.len() as f64) as usize;
            sorted.len().checked_sub(1 + beyond).map_or(f64::INFINITY, |i| sorted[i])
        };
        Self { out: limit(&outs).max(1.0), depth: limit(&depths), depths }
    }

    /// Share of simulated scans that lie as deep or deeper [1].
    pub fn share_beyond(&self, depth: f64) -> f64 {
        self.depths.iter().filter(|known| **known >= depth).count() as f64 / self.depths.len().max(1) as f64
    }
}
