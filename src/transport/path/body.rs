//! The judge on bodies of any shape and matter: Monte Carlo of the transport equation below a line of light.
//!
//! Model: radiance in a body whose absorption, scattering and fibre direction change from place to place
//! ([`Medium`](procedural::Medium), cylinders that turn light evenly about themselves), below a relief with cracks, sides
//! and bottom (`relief`), with Fresnel's law wherever light meets a surface (`roam`). Matter is the same within cells of
//! 0.1 mm (`voxels`). Light enters vertically at every place of the line, tilted or not.
//!
//! Photons are spread over the columns by power, evenly within a column and by the line's normal law across it. Batch b
//! draws from stream (seed, b) and results are added in the order of batches, so an answer is the same for any number
//! of threads. Within a batch photons are stratified along the line.
//!
//! Source: Woodcock et al. 1965 for free paths; the rest as in the module above. Neglected: refraction on entry, bending
//! of light where the index changes inside, roughness finer than 0.1 mm, cracks narrower than 0.2 mm, light beyond 20 mm
//! from the line's grid (it is booked as astray), light to the lens through sides and walls of cracks.

mod relief;
mod roam;
#[cfg(test)]
mod tests;
mod voxels;

use glam::DVec3;
use procedural::{Body, Stream, normal};
use rand::Rng;
use rayon::prelude::*;

use self::relief::Relief;
use self::roam::Roam;
pub(super) use self::roam::{Fate, Ledger};
use self::voxels::Voxels;
use super::walk::Photon;
use super::{BATCHES, Effort, pack};
use crate::transport::answer::Estimate;
use crate::transport::line::{LineResponse, LineSource};
use crate::transport::phase::uniform;

/// Batches that are in memory at once.
const TOGETHER: u64 = 16;

/// Where a line's light went; shares of the light that entered, which sum to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Books {
    /// Absorbed inside [1].
    pub absorbed: Estimate,
    /// Into the sky [1].
    pub left: Estimate,
    /// Onto the conveyor, through the bottom or from the sides [1].
    pub dropped: Estimate,
    /// Too far to follow, or aimed beside the body [1].
    pub astray: Estimate,
    /// Light towards the lens from everywhere, within the grid or not, in units of what entered [1].
    pub seen: Estimate,
}

/// What a line of light falls on.
pub(super) trait Ground: Sync {
    /// Sends a photon in at (x, y) [mm] from above, and follows it to its end.
    fn light(&self, x: f64, y: f64, ledger: &mut impl Ledger, rng: &mut impl Rng);
}

impl Ground for Roam<'_> {
    fn light(&self, x: f64, y: f64, ledger: &mut impl Ledger, rng: &mut impl Rng) {
        match self.voxels.relief().above(DVec3::new(x, y, 0.0)) {
            Some(z) => {
                let (place, way) = (DVec3::new(x, y, z), DVec3::NEG_Z);
                let photon = Photon { place, way, weight: 1.0, layer: 0, path: 0.0, turned: 0, guided: 0 };
                self.follow(photon, ledger, rng);
            }
            None => ledger.book(Fate::Astray, 1.0),
        }
    }
}

/// What the lens sees of a line of light on a body.
pub fn glow(line: &LineSource, effort: Effort) -> LineResponse {
    judge(line, effort).0
}

/// The same, and where all light went.
pub fn judge(line: &LineSource, effort: Effort) -> (LineResponse, Books) {
    if let Body::Pack(pack) = line.body {
        return light(line, effort, &pack::Roam::in_pack(pack, line));
    }
    let (relief, cuts) = Relief::new(line);
    light(line, effort, &Roam::new(Voxels::new(relief, cuts), line.view))
}

/// The same on `ground`.
pub(super) fn light(line: &LineSource, effort: Effort, ground: &impl Ground) -> (LineResponse, Books) {
    let aim = Aim::new(line);
    let cells = (2 * line.rows + 1) * line.x.len();
    let mut glow =
        LineResponse { columns: line.x.len(), rows: line.rows, light: vec![0.0; cells], error: vec![0.0; cells] };
    let total = aim.total();
    if total <= 0.0 {
        let none = Estimate::exact(0.0);
        return (glow, Books { absorbed: none, left: none, dropped: none, astray: none, seen: none });
    }
    let each = effort.photons.div_ceil(BATCHES).max(1);
    // Sum and sum of squares over batches, a share of the power each.
    let mut sums = vec![[0.0f64; 2]; cells];
    let mut shares: Vec<[f64; 5]> = Vec::new();
    for first in (0..BATCHES).step_by(TOGETHER as usize) {
        let batch = |batch: u64| {
            let mut rng = Stream::root(effort.seed).child("transport").child("body").index(batch).rng();
            aim.shoot(ground, each, &mut rng)
        };
        let counts: Vec<Count> = (first..(first + TOGETHER).min(BATCHES)).into_par_iter().map(batch).collect();
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
        glow.light[cell] = (total * mean) as f32;
        glow.error[cell] = (total * ((squares / n - mean * mean).max(0.0) / (n - 1.0)).sqrt()) as f32;
    }
    let [absorbed, left, dropped, astray, seen] =
        std::array::from_fn(|share| Estimate::of(shares.iter().map(|batch| batch[share])));
    (glow, Books { absorbed, left, dropped, astray, seen })
}

/// Where light is sent in, and how places become cells.
#[derive(Debug)]
struct Aim<'a> {
    line: &'a LineSource<'a>,
    /// Ends of the columns, one more than them [mm].
    ends: Vec<f64>,
    /// Power of all columns up to and with each one.
    power: Vec<f64>,
}

/// What a batch saw, in units of a photon.
#[derive(Debug)]
struct Count<'a> {
    aim: &'a Aim<'a>,
    light: Vec<f64>,
    /// Absorbed, left, dropped, astray, seen.
    shares: [f64; 5],
}

impl<'a> Aim<'a> {
    fn new(line: &'a LineSource<'a>) -> Self {
        let x: Vec<f64> = line.x.iter().map(|&x| f64::from(x)).collect();
        let mut ends: Vec<f64> = x.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect();
        // The outermost columns are as wide as their neighbours; a single one is as wide as a row.
        let n = x.len();
        if let (Some(&first), Some(&last)) = (x.first(), x.last()) {
            let half = |a: Option<&f64>, b: f64| a.map_or(0.5 * line.row_mm, |a| 0.5 * (a - b).abs());
            ends.insert(0, first - half(x.get(1), first));
            ends.push(last + half(n.checked_sub(2).and_then(|i| x.get(i)), last));
        }
        let mut sum = 0.0;
        let power = line.power.iter().map(|&power| {
            sum += f64::from(power).max(0.0);
            sum
        });
        Self { line, ends, power: power.collect() }
    }

    fn total(&self) -> f64 {
        self.power.last().copied().unwrap_or(0.0)
    }

    /// Sends `photons` in and counts what becomes of them.
    fn shoot(&self, ground: &impl Ground, photons: u64, rng: &mut impl Rng) -> Count<'_> {
        let mut count =
            Count { aim: self, light: vec![0.0; (2 * self.line.rows + 1) * self.line.x.len()], shares: [0.0; 5] };
        for photon in 0..photons {
            let share = (photon as f64 + 1.0 - uniform(rng)) / photons as f64 * self.total();
            let column = self.power.partition_point(|&sum| sum <= share).min(self.power.len() - 1);
            let x = self.ends[column] + (1.0 - uniform(rng)) * (self.ends[column + 1] - self.ends[column]);
            let y = self.line.y + self.line.line_mm * normal(rng);
            ground.light(x, y, &mut count, rng);
        }
        count
    }

    /// The cell of a place on the surface, if it is in the grid.
    #[inline]
    fn cell(&self, place: DVec3) -> Option<usize> {
        let row = ((place.y - self.line.y) / self.line.row_mm).round() + self.line.rows as f64;
        let column = self.ends.partition_point(|&end| end <= place.x);
        let inside = row >= 0.0 && row <= 2.0 * self.line.rows as f64 && (1..self.ends.len()).contains(&column);
        inside.then(|| row as usize * self.line.x.len() + column - 1)
    }
}

impl Ledger for Count<'_> {
    #[inline]
    fn see(&mut self, place: DVec3, light: f64) {
        self.shares[4] += light;
        if let Some(cell) = self.aim.cell(place) {
            self.light[cell] += light;
        }
    }

    #[inline]
    fn book(&mut self, fate: Fate, weight: f64) {
        let share = match fate {
            Fate::Absorbed => 0,
            Fate::Left => 1,
            Fate::Dropped => 2,
            Fate::Astray => 3,
        };
        self.shares[share] += weight;
    }
}
