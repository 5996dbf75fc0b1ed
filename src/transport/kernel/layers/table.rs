//! The table of what films do to light, measured with the judge and kept beside this file as `film.bin`.
//!
//! Three axes: index, reduced scattering times thickness, absorption times thickness. Lengths are in thicknesses,
//! frequencies in 1 / thickness. Transmitted light is kept times 1 + 3/4 of the scattering, which leaves little to
//! interpolate (the two-stream law). `make film-table` makes it anew.

use super::waves::{RATIO_LN};
use crate::transport::path::film::{DIRECTIONS, FREQUENCIES, Fate, Side};

/// Refractive indices of the table [1].
pub const N: [f64; 2] = [1.45, 1.58];
/// Reduced scattering times thickness [1].
pub const TURNS: [f64; 15] =
    [0.0, 0.02, 0.04, 0.08, 0.16, 0.32, 0.64, 1.28, 2.56, 5.12, 10.24, 20.48, 40.96, 81.92, 163.84];
/// Absorption times thickness [1].
pub const ABSORBED: [f64; 6] = [0.0, 0.02, 0.06, 0.15, 0.4, 1.0];
/// Lowest frequency of a transform [1 / thickness].
pub const LOWEST: f64 = 0.02;
/// Transforms kept of a film.
const TRANSFORMS: usize = 6;
/// Laws of exit kept of a film.
const LAWS: usize = 3;
/// Numbers kept of a film.
pub const NODE: usize = TRANSFORMS * FREQUENCIES + LAWS * DIRECTIONS + 1;

/// Frequencies of the transforms [1 / thickness].
pub fn frequencies() -> [f64; FREQUENCIES] {
    std::array::from_fn(|i| LOWEST * libm::exp(i as f64 * RATIO_LN))
}

/// How much larger transmitted light is kept.
fn scale(turns: f64) -> f64 {
    1.0 + 0.75 * turns
}

/// What the table keeps of a film that the judge measured under straight light, Lambert light, and sealed to foil.
pub fn condense(turns: f64, straight: &Fate, lambert: &Fate, sealed: &Fate) -> [f32; NODE] {
    let scale = scale(turns);
    let down = straight.down;
    // A clear film turns nothing; then it does not matter how.
    let slopes = if down.total > 1e-6 { down.slopes.map(|slope| slope / down.total) } else { [1.0; FREQUENCIES] };
    let transforms = [
        straight.up.spread,
        down.spread.map(|part| part * scale),
        lambert.up.spread.map(|part| part + lambert.straight_up),
        lambert.down.spread.map(|part| part * scale),
        sealed.up.spread,
        slopes,
    ];
    // Radiance factor of each bin, against Lambert's law.
    let law = |side: &Side| {
        let even = side.total / DIRECTIONS as f64;
        if side.total > 1e-6 { side.directions.map(|part| part / even) } else { [1.0; DIRECTIONS] }
    };
    let laws = [law(&straight.up), law(&lambert.down), law(&sealed.up)];
    let mut node = [0.0; NODE];
    let values = transforms.into_iter().flatten().chain(laws.into_iter().flatten()).chain([lambert.straight_down]);
    for (kept, value) in node.iter_mut().zip(values) {
        *kept = value as f32;
    }
    node
}
