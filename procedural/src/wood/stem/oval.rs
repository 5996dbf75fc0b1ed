//! Growth layers that follow the outline of the stem: oval with it, off its middle, and falling with its taper.
//!
//! Models: let t0(r) be the time of growth along the ray of azimuth phi and place l (`layers`), rho the distance of the
//! outline there and R the mean radius of the stem at its middle. The layers of stem wood of the share f are
//!
//! ```text
//! t = t0 G,   G(phi, l) = 1 + f (R / t0(rho) - 1)
//! ```
//!
//! With f = 1 the outline is the layer t = R all over, and every inner ring a smaller copy of it about the pith. G does
//! not depend on r: where t0 rises outwards, t does. G is a quadratic B-spline over azimuth and place, whose slopes are
//! continuous, as fibres need. Source: geometry: the cambium lays the last ring under the bark. That inner rings are
//! copies of the outline is a guess; in trees the inner ones are rounder, and eccentricity changes with the years.
//! Limits: bark has no thickness; rings are as wide as R says, whatever the height.

use std::f32::consts::TAU;

use glam::Vec2;

use super::cut::{AZIMUTHS, SECTION_MM, StemCut};

/// Layers reach the outline at no less than this distance [mm].
const LEAST_MM: f32 = 1.0;

/// Where a layer is at a place.
#[derive(Debug, Clone, Copy)]
pub(in crate::wood) struct StemLayer {
    /// Distance from the smoothed pith [mm].
    pub t: f32,
    /// Slopes of it outwards, around and along [1].
    pub slope: [f32; 3],
    /// Azimuth about the smoothed pith, less that about the pith [rad].
    pub turn: f32,
    /// Slope of the smoothed pith less that of the pith, sideways and upwards [1].
    pub drift_slope: Vec2,
}

/// The factor G about a board.
#[derive(Debug, Clone)]
pub(in crate::wood) struct Oval {
    start: f32,
    /// G [1], [section, azimuth].
    nodes: Vec<[f32; AZIMUTHS]>,
}

/// Weights, of which none is below 0 and the sum is 1, and slopes of a quadratic B-spline at u of its middle interval.
#[inline]
pub(super) fn spline(u: f32) -> [[f32; 3]; 2] {
    [[0.5 * (1.0 - u) * (1.0 - u), 0.5 + u * (1.0 - u), 0.5 * u * u], [u - 1.0, 1.0 - 2.0 * u, u]]
}

impl Oval {
    /// For an outline, the share f, the mean radius R, and t0 at a distance, an azimuth and a place.
    pub fn new(cut: &StemCut, share: f32, mean: f32, t0: impl Fn(f32, f32, f32) -> f32) -> Self {
        let rows = cut.sections().map(|(l, radii)| {
            std::array::from_fn(|column| {
                let phi = TAU * column as f32 / AZIMUTHS as f32;
                1.0 + share * (mean / t0(radii[column], phi, l).max(LEAST_MM) - 1.0)
            })
        });
        Self { start: cut.start, nodes: rows.collect() }
    }

    /// The most that G can be [1]: a spline stays within its nodes.
    pub fn most(&self) -> f32 {
        self.nodes.iter().flatten().copied().fold(0.0, f32::max)
    }

    /// G and its slopes over azimuth [1/rad] and place [1/mm].
    #[inline]
    fn factor(&self, phi: f32, l: f32) -> [f32; 3] {
        let at = ((l - self.start) / SECTION_MM).clamp(1.0, (self.nodes.len() - 2) as f32 - 0.51);
        let row = (at + 0.5).floor();
        let [along, along_slope] = spline(at + 0.5 - row);
        let round = (phi / TAU).rem_euclid(1.0) * AZIMUTHS as f32;
        let column = (round + 0.5).floor();
        let [around, around_slope] = spline(round + 0.5 - column);
        let (row, column) = (row as usize, column as usize + AZIMUTHS - 1);
        let mut found = [0.0; 3];
        for i in 0..3 {
            let nodes = &self.nodes[row + i - 1];
            for k in 0..3 {
                let node = nodes[(column + k) % AZIMUTHS];
                found[0] += along[i] * around[k] * node;
                found[1] += along[i] * around_slope[k] * node;
                found[2] += along_slope[i] * around[k] * node;
            }
        }
        [found[0], found[1] * AZIMUTHS as f32 / TAU, found[2] / SECTION_MM]
    }

    /// A layer at the distance `r` [mm] of an azimuth [rad] and a place [mm], as it follows the outline.
    #[inline]
    pub fn follow(&self, layer: StemLayer, r: f32, phi: f32, l: f32) -> StemLayer {
        let [factor, around, along] = self.factor(phi, l);
        let [out, aside, ahead] = layer.slope;
        let slope = [out * factor, aside * factor + layer.t / r * around, ahead * factor + layer.t * along];
        StemLayer { t: layer.t * factor, slope, ..layer }
    }
}
