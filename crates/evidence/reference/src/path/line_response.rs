//! Response of a body to a line of light by Monte Carlo of the transport equation.
//!
//! Bodies of any shape and matter are tracked as `body` says, packs as `pack` says. Light
//! enters vertically everywhere on the line, whatever the tilt of the surface.
//!
//! Photons are spread over the columns by power, evenly within a column and by the line's normal law across it. Batch b
//! draws from stream (seed, b) and results are added in the order of batches, so an answer is the same for any number
//! of threads. Within a batch photons are stratified along the line.

use base::{Stream, normal};
use glam::DVec3;
use procedural::blister::Pack;
use rand::Rng;
use rayon::prelude::*;

use super::body::BodyGeometry;
use super::pack::PackGeometry;
use super::tracker::{Fate, LineObserver, Target};
use super::{BATCHES, Effort};
use crate::columns::column_edges;
use crate::phase::uniform;
use transport::answer::Estimate;
use transport::line::{LineResponse, LineSource};

/// Batches that are in memory at once.
const BATCHES_AT_ONCE: u64 = 16;

/// Where a line's light went; shares of the light that entered, which sum to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EnergyBalance {
    /// Absorbed inside [1].
    pub absorbed: Estimate,
    /// Into the sky [1].
    pub left: Estimate,
    /// Onto the conveyor, through the bottom or from the sides [1].
    pub dropped: Estimate,
    /// Too far to follow, or aimed beside the body [1].
    pub lost: Estimate,
    /// Light towards the lens from everywhere, within the grid or not, in units of what entered [1].
    pub seen: Estimate,
}

/// What the lens sees of a line of light on a body.
pub fn line_response(line: &LineSource, effort: Effort) -> LineResponse {
    line_response_with_balance(line, effort).0
}

/// The same, and where all light went.
pub fn line_response_with_balance(line: &LineSource, effort: Effort) -> (LineResponse, EnergyBalance) {
    match line.body.get::<Pack>() {
        Some(pack) => illuminate_target(line, effort, &PackGeometry::in_pack(pack, line)),
        None => illuminate_target(line, effort, &BodyGeometry::about(line)),
    }
}

/// The same on `target`.
pub(super) fn illuminate_target(
    line: &LineSource,
    effort: Effort,
    target: &impl Target,
) -> (LineResponse, EnergyBalance) {
    let sampler = LineSampler::new(line);
    let cells = (2 * line.rows + 1) * line.x.len();
    let mut response =
        LineResponse { columns: line.x.len(), rows: line.rows, light: vec![0.0; cells], error: vec![0.0; cells] };
    let total = sampler.total();
    if total <= 0.0 {
        let none = Estimate::exact(0.0);
        return (response, EnergyBalance { absorbed: none, left: none, dropped: none, lost: none, seen: none });
    }
    let each = effort.photons.div_ceil(BATCHES).max(1);
    // Sum and sum of squares over batches, a share of the power each.
    let mut sums = vec![[0.0f64; 2]; cells];
    let mut shares: Vec<[f64; 5]> = Vec::new();
    for first in (0..BATCHES).step_by(BATCHES_AT_ONCE as usize) {
        let batch = |batch: u64| {
            let mut rng = Stream::root(effort.seed).child("transport").child("body").index(batch).rng();
            sampler.shoot(target, each, &mut rng)
        };
        let counts: Vec<LineCounts> =
            (first..(first + BATCHES_AT_ONCE).min(BATCHES)).into_par_iter().map(batch).collect();
        for count in counts {
            for (sum, light) in sums.iter_mut().zip(&count.light) {
                let light = light / each as f64;
                *sum = [sum[0] + light, sum[1] + light * light];
            }
            shares.push(count.shares.map(|share| share / each as f64));
        }
    }
    let n = BATCHES as f64;
    for (cell, [sum, squares]) in sums.into_iter().enumerate() {
        let mean = sum / n;
        response.light[cell] = (total * mean) as f32;
        response.error[cell] = (total * ((squares / n - mean * mean).max(0.0) / (n - 1.0)).sqrt()) as f32;
    }
    let [absorbed, left, dropped, lost, seen] =
        std::array::from_fn(|share| Estimate::of(shares.iter().map(|batch| batch[share])));
    (response, EnergyBalance { absorbed, left, dropped, lost, seen })
}

/// Where light is sent in, and how points become cells.
#[derive(Debug)]
struct LineSampler<'a> {
    line: &'a LineSource<'a>,
    /// Ends of the columns, one more than them [mm].
    ends: Vec<f64>,
    /// Power of all columns up to and with each one.
    power: Vec<f64>,
}

/// What a batch saw, in units of a photon.
#[derive(Debug)]
struct LineCounts<'a> {
    sampler: &'a LineSampler<'a>,
    light: Vec<f64>,
    /// Absorbed, left, dropped, lost, seen.
    shares: [f64; 5],
}

impl<'a> LineSampler<'a> {
    fn new(line: &'a LineSource<'a>) -> Self {
        let mut sum = 0.0;
        let power = line.power.iter().map(|&power| {
            sum += f64::from(power).max(0.0);
            sum
        });
        Self { line, ends: column_edges(line.x, line.row_mm), power: power.collect() }
    }

    fn total(&self) -> f64 {
        self.power.last().copied().unwrap_or(0.0)
    }

    /// Sends `photons` in and counts what becomes of them.
    fn shoot(&self, target: &impl Target, photons: u64, rng: &mut impl Rng) -> LineCounts<'_> {
        let mut count = LineCounts {
            sampler: self,
            light: vec![0.0; (2 * self.line.rows + 1) * self.line.x.len()],
            shares: [0.0; 5],
        };
        for photon in 0..photons {
            let share = (photon as f64 + 1.0 - uniform(rng)) / photons as f64 * self.total();
            let column = self.power.partition_point(|&sum| sum <= share).min(self.power.len() - 1);
            let x = self.ends[column] + (1.0 - uniform(rng)) * (self.ends[column + 1] - self.ends[column]);
            let y = self.line.y + self.line.line_mm * normal(rng);
            target.illuminate(x, y, &mut count, rng);
        }
        count
    }

    /// The cell of a point on the surface, if it is in the grid.
    #[inline]
    fn cell(&self, position: DVec3) -> Option<usize> {
        let row = ((position.y - self.line.y) / self.line.row_mm).round() + self.line.rows as f64;
        let column = self.ends.partition_point(|&end| end <= position.x);
        let inside = row >= 0.0 && row <= 2.0 * self.line.rows as f64 && (1..self.ends.len()).contains(&column);
        inside.then(|| row as usize * self.line.x.len() + column - 1)
    }
}

impl LineObserver for LineCounts<'_> {
    #[inline]
    fn see(&mut self, position: DVec3, light: f64) {
        self.shares[4] += light;
        if let Some(cell) = self.sampler.cell(position) {
            self.light[cell] += light;
        }
    }

    #[inline]
    fn book(&mut self, fate: Fate, weight: f64) {
        let share = match fate {
            Fate::Absorbed => 0,
            Fate::Left => 1,
            Fate::Dropped => 2,
            Fate::Lost => 3,
        };
        self.shares[share] += weight;
    }
}
