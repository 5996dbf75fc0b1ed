//! Correlated noise: normal numbers at even nodes, each like its neighbours, as a function of the node alone.
//!
//! White noise is filtered with a Gaussian, which gives the correlation exp(-d^2 / (2 l^2)) over the length l; numbers
//! between two nodes are linear.

use base::Stream;
use numerics::lanes::normals;

/// Nodes per correlation length [1].
pub(super) const NODES_PER_LENGTH: f64 = 8.0;
/// Half length of the filter kernel, in correlation lengths [1].
const KERNEL_REACH: f64 = 3.5;

/// The filter.
#[derive(Debug, Clone)]
pub(super) struct NoiseFilter {
    /// Weights from the middle outwards.
    half_taps: Vec<f64>,
    /// Standard deviation of what is filtered.
    norm: f64,
}

impl NoiseFilter {
    /// For nodes that are `step` apart and the correlation length `length`.
    pub fn new(step: f64, length: f64) -> Self {
        let tap = |i: usize| {
            let d = i as f64 * step / length;
            libm::exp(-d * d)
        };
        let half_taps: Vec<f64> = (0..=(KERNEL_REACH * length / step).ceil() as usize).map(tap).collect();
        let norm = (half_taps.iter().map(|t| t * t).sum::<f64>() * 2.0 - 1.0).sqrt();
        Self { half_taps, norm }
    }

    /// Nodes to either side whose white noise is asked for.
    pub fn reach(&self) -> usize {
        self.half_taps.len() - 1
    }

    /// A normal number of this `deviation` from the standard ones of the nodes around it, the first of which is `reach`
    /// before it.
    pub fn filtered(&self, deviation: f64, white: impl Fn(usize) -> f64) -> f64 {
        let reach = self.reach();
        deviation * (0..=2 * reach).map(|k| self.half_taps[k.abs_diff(reach)] * white(k)).sum::<f64>() / self.norm
    }
}

/// Correlated noise over the profiles of a scan.
#[derive(Debug, Clone)]
pub(super) struct ScanNoise {
    filter: NoiseFilter,
    nodes_per_profile: f64,
    keys: [u32; 2],
}

impl ScanNoise {
    /// With a correlation length in profiles.
    pub fn new(profiles: f64, stream: Stream) -> Self {
        let key = stream.key();
        Self {
            filter: NoiseFilter::new(1.0, NODES_PER_LENGTH),
            nodes_per_profile: NODES_PER_LENGTH / profiles,
            keys: [key as u32, (key >> 32) as u32],
        }
    }

    /// The number of a profile, of unit variance at nodes and up to 0.4 % less between them.
    pub fn at(&self, profile: isize) -> f64 {
        let place = profile as f64 * self.nodes_per_profile;
        let first = place.floor();
        let node = |node: i64| self.filter.filtered(1.0, |k| f64::from(normals((node + k as i64) as u32, self.keys).0));
        let [left, right] = [0, 1].map(|i| node(first as i64 + i));
        left + (right - left) * (place - first)
    }
}
