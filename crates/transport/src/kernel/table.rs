//! Table of light by length of path in half spaces, measured by Monte Carlo and kept beside this file as `table.bin`.
//!
//! Four axes: dispersion of the fibres, index of refraction, background's share of scattering, the fibres' dive; linear
//! in functions of them between values. Lengths are in mean free paths 1 / (sigma_i + k). `make kernel-table` makes it
//! anew; docs/theory/transport/kernel.md says how and what it was tested against.

use std::sync::OnceLock;

use super::view::{VIEW_LANES, VIEW_TERMS};
use base::{KERNEL_INDICES, KERNEL_LEAST_SHARE};
use numerics::lanes::ln;

/// End of the first bin of path lengths [mean free paths].
pub const FIRST_PATH: f64 = 0.05;
/// Ratio of the ends of a bin of path lengths [1].
pub const PATH_RATIO: f64 = 1.8225;
/// Bins in all, cone light first.
pub const PATH_BINS: usize = 38;
/// Numbers kept for a bin: weight, path, displacement along, variance along, variance across.
pub(crate) const FIELDS: usize = 5;
/// Bins with padding, so that a field fills whole vectors.
pub const LANES: usize = 40;
/// Numbers kept for one half space: of bins, and of light towards a view ([`super::view`]).
pub const NODE: usize = FIELDS * LANES + VIEW_TERMS * VIEW_LANES;

/// Dispersions of the fibres, standard deviation of their tilt in each of two directions [deg].
pub const DISPERSION_DEG: [f32; 4] = [3.0, 5.0, 8.0, 14.0];
/// Refractive indices of the table [1].
pub const N: [f32; 5] = [1.0, 1.12, 1.25, 1.4, 1.55];
/// Shares of the background in scattering [1].
pub const RHO: [f32; 9] = [0.03, 0.05, 0.08, 0.14, 0.2, 0.28, 0.4, 0.6, 1.0];
/// Dives of the fibres below the surface [deg].
pub const DIVE_DEG: [f32; 14] = [0.0, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 37.0, 45.0, 52.0, 60.0, 70.0, 80.0, 90.0];

/// What is kept of one half space, or between half spaces.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(crate) struct HalfSpaceNode(pub [f32; NODE]);

impl HalfSpaceNode {
    /// Weight of each bin, of light that entered [1].
    pub fn weight(&self) -> &[f32; LANES] {
        self.field(0)
    }

    /// Mean path [mean free paths].
    pub fn path(&self) -> &[f32; LANES] {
        self.field(1)
    }

    /// Mean displacement towards the diving end [mean free paths].
    pub fn along(&self) -> &[f32; LANES] {
        self.field(2)
    }

    /// Variance along the fibres' track [mean free paths^2].
    pub(crate) fn variance_along(&self) -> &[f32; LANES] {
        self.field(3)
    }

    /// Variance across it [mean free paths^2].
    pub(crate) fn variance_across(&self) -> &[f32; LANES] {
        self.field(4)
    }

    /// Coefficients of light towards a view, see [`super::view`].
    #[inline(always)]
    pub fn views(&self) -> &[[f32; VIEW_LANES]; VIEW_TERMS] {
        self.0[FIELDS * LANES..].as_chunks().0.first_chunk().expect("a node holds its views")
    }

    #[inline(always)]
    fn field(&self, i: usize) -> &[f32; LANES] {
        self.0[i * LANES..].first_chunk().expect("a node holds its fields")
    }
}

/// `table.bin`: f32, little-endian.
const BYTES: &[u8] = include_bytes!("table.bin");
const _: () = assert!(
    BYTES.len() == 4 * NODE * DISPERSION_DEG.len() * N.len() * RHO.len() * DIVE_DEG.len(),
    "table.bin has other axes"
);
// What is promised elsewhere is what is there.
const _: () = assert!(N[0] == KERNEL_INDICES[0] && N[N.len() - 1] == KERNEL_INDICES[1] && RHO[0] == KERNEL_LEAST_SHARE);

/// The whole table, `[DISPERSION][N][RHO][DIVE]`.
#[derive(Debug)]
pub(crate) struct HalfSpaceTable {
    nodes: Vec<HalfSpaceNode>,
    /// [`steepness`] of [`DIVE_DEG`].
    dives: [f32; DIVE_DEG.len()],
    /// Square roots of [`RHO`].
    shares: [f32; RHO.len()],
    /// [`confined`] of [`N`].
    indices: [f32; N.len()],
    /// Logarithms of [`DISPERSION_DEG`].
    dispersions: [f32; DISPERSION_DEG.len()],
}

impl HalfSpaceTable {
    /// The table, read once.
    pub fn get() -> &'static Self {
        static TABLE: OnceLock<HalfSpaceTable> = OnceLock::new();
        TABLE.get_or_init(|| {
            let words: Vec<f32> = BYTES.as_chunks().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect();
            let nodes = words.as_chunks().0.iter().map(|node| HalfSpaceNode(*node)).collect();
            Self {
                nodes,
                dives: DIVE_DEG.map(|dive| steepness(libm::sin(f64::from(dive).to_radians()) as f32)),
                shares: RHO.map(f32::sqrt),
                indices: N.map(confined),
                dispersions: DISPERSION_DEG.map(ln),
            }
        })
    }

    /// The half space of index `n`, background's share `rho`, sine of dive `sin_dive` and dispersion `dispersion_deg`,
    /// clamped to the table's ends. It is linear in the simplex of five neighbours that holds it (Kasson, Nin, Plouffe
    /// and Hafner 1995), in what the index lets out, the share's root, the dive's steepness and the dispersion's
    /// logarithm.
    #[inline(always)]
    pub fn between(&self, n: f32, rho: f32, sin_dive: f32, dispersion_deg: f32) -> HalfSpaceNode {
        let (a, fa) = locate(&self.indices, confined(n));
        let (b, fb) = locate(&self.shares, rho.sqrt());
        let (c, fc) = locate(&self.dives, steepness(sin_dive));
        let (d, fd) = locate(&self.dispersions, ln(dispersion_deg));
        // From the lowest corner of the cell to the highest, along the axis with the greatest part first.
        let along_rho = DIVE_DEG.len();
        let along_n = along_rho * RHO.len();
        let along_dispersion = along_n * N.len();
        let mut steps = [(fa, along_n), (fb, along_rho), (fc, 1), (fd, along_dispersion)];
        for (i, j) in [(0, 1), (2, 3), (0, 2), (1, 3), (1, 2)] {
            if steps[i].0 < steps[j].0 {
                steps.swap(i, j);
            }
        }
        let first = d * along_dispersion + a * along_n + b * along_rho + c;
        let second = first + steps[0].1;
        let third = second + steps[1].1;
        let fourth = third + steps[2].1;
        let [(f0, _), (f1, _), (f2, _), (f3, _)] = steps;
        let weights = [1.0 - f0, f0 - f1, f1 - f2, f2 - f3];
        let [p, q, r, s] = [first, second, third, fourth].map(|at| &self.nodes[at].0);
        let mut out = HalfSpaceNode([0.0; NODE]);
        for l in 0..NODE {
            out.0[l] = weights[0] * p[l] + weights[1] * q[l] + weights[2] * r[l] + weights[3] * s[l];
        }
        // Most wood is dispersed like a node of the table and needs no fifth neighbour.
        if f3 > 0.0 {
            let last = &self.nodes[fourth + steps[3].1].0;
            for l in 0..NODE {
                out.0[l] += f3 * last[l];
            }
        }
        out
    }
}

/// Nearly even in the angle of dive: sin / (sin + cos) [1].
#[inline(always)]
fn steepness(sin: f32) -> f32 {
    sin / (sin + (1.0 - sin * sin).max(0.0).sqrt())
}

/// Square of the cosine of the critical angle inside matter of index `n`, 1 - 1 / n^2 [1].
#[inline(always)]
fn confined(n: f32) -> f32 {
    1.0 - 1.0 / (n * n)
}

/// The value below `x` of rising `values`, and how far `x` is on the way to the next one.
#[inline(always)]
fn locate(values: &[f32], x: f32) -> (usize, f32) {
    let mut low = 0;
    for (i, &value) in values[..values.len() - 1].iter().enumerate().skip(1) {
        if x >= value {
            low = i;
        }
    }
    (low, ((x - values[low]) / (values[low + 1] - values[low])).clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Cone light falls away from its bright direction, at every node and so between them: a logarithm that were convex
    /// in the change of the cosine would rise again on the dark flank, where next to no light goes.
    #[test]
    fn cone_light_has_one_bright_direction() {
        let table = HalfSpaceTable::get();
        assert!(table.nodes.iter().all(|node| node.views()[2][..VIEW_LANES / 2].iter().all(|&bend| bend <= 0.0)));
    }
}
