//! Ends of a body along the motion: a line at an end falls beside it with a part of its width.
//!
//! Of a line whose irradiance across is normal with the deviation s, at distances a s and b s from both ends, the body
//! takes Phi(a) + Phi(b) - 1 (the truncated normal law; Johnson, Kotz and Balakrishnan 1994, 13.10). What it takes lies
//! nearer to its middle and is narrower. Neglected: ends that don't lie at right angles to the motion; lobes and skirt
//! of a line; that light of the surface itself lies as far inwards; films, whose ends are lower than a row.

use std::ops::Range;

use super::LineScratch;
use super::view::LineView;
use crate::optics::light::ScanLine;
use numerics::chance::normal_below;

/// Deviations from an end beyond which a line is whole.
const REACH: f32 = 4.0;

/// What an end leaves of a line.
#[derive(Debug, Clone, Copy, PartialEq)]
struct CutLine {
    /// Share of its light [1].
    share: f32,
    /// How far along the motion its middle lies from the line's, over the line's deviation [1].
    middle: f32,
    /// Its variance over the line's [1].
    variance: f32,
}

impl CutLine {
    /// Of a line so many deviations from both ends.
    fn new(ends: [f32; 2]) -> Self {
        let [a, b] = ends.map(f64::from);
        let density = |z: f64| 0.398_942_280_401_432_7 * libm::exp(-0.5 * z * z);
        let share = (normal_below(a) + normal_below(b) - 1.0).max(1e-3);
        let middle = (density(a) - density(b)) / share;
        let variance = 1.0 - (a * density(a) + b * density(b)) / share - middle * middle;
        Self { share: share as f32, middle: middle as f32, variance: variance.max(0.0) as f32 }
    }
}

/// Takes what falls beside the body from the light of its columns `own`; how far along the motion the middle of the
/// rest lies from the line [mm].
pub(super) fn cut(view: LineView<'_>, own: Range<usize>, scratch: &mut LineScratch, line: &mut ScanLine) -> f32 {
    if !view.specimen.body().has_ends() || view.specimen.can_mirror_itself() || view.specimen.is_turned() {
        return 0.0;
    }
    let (low, high) = view.specimen.body().bounds();
    let sight = view.camera.sight(0.0, high.z, 0.0);
    let deviation = sight.laser_variance.sqrt() / sight.rows_per_mm;
    let ends = [view.y - low.y, high.y - view.y].map(|away| away / deviation);
    if ends.into_iter().all(|away| away > REACH) {
        return 0.0;
    }
    let cut = CutLine::new(ends);
    let lost = (1.0 - cut.variance) * sight.laser_variance;
    for column in own.filter(|&column| !line.bare[column]) {
        scratch.white[column] *= cut.share;
        scratch.filling[column] *= cut.share;
        line.surface_light[column] *= cut.share;
        line.variance[column] -= lost;
    }
    cut.middle * deviation
}

/// Moves light that has spread in the columns `own` by `middle` along the motion [mm].
pub(super) fn displace(middle: f32, own: Range<usize>, line: &mut ScanLine) {
    for shift in &mut line.shift {
        for (shift, rows_per_mm) in shift[own.clone()].iter_mut().zip(&line.rows_per_mm[own.clone()]) {
            *shift -= middle * rows_per_mm;
        }
    }
}

#[cfg(test)]
mod tests {
    use rand::RngExt;

    use super::*;

    /// Share, mean and variance against sums over the law, for lines at random places of boards of random lengths.
    #[test]
    fn cut_lines_are_sums_over_their_law() {
        let mut rng = base::Stream::root(55).rng();
        for _ in 0..200 {
            let ends = [(); 2].map(|()| rng.random_range(0.0..5.0f32));
            let (steps, [a, b]) = (20_000, ends.map(f64::from));
            let (mut sums, width) = ([0.0f64; 3], (a + b) / f64::from(steps));
            for step in 0..steps {
                let z = -a + (f64::from(step) + 0.5) * width;
                let part = width * libm::exp(-0.5 * z * z) / std::f64::consts::TAU.sqrt();
                (0..3).for_each(|power| sums[power as usize] += part * z.powi(power));
            }
            let (mean, found) = (sums[1] / sums[0], CutLine::new(ends));
            let known = [sums[0], mean, sums[2] / sums[0] - mean * mean];
            for (found, known) in [found.share, found.middle, found.variance].into_iter().zip(known) {
                assert!((f64::from(found) - known).abs() < 2e-3, "{ends:?}: {found} for {known}");
            }
        }
    }
}
