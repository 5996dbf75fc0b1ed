//! Classes of the fixed widths: which of them are told apart, and why.
//!
//! Light spreads by a fixed series of widths ([`transport::kernel::PACK_SPREAD_MM`] where there is film). What happens
//! to it on the way depends on how far it has come.

use std::ops::Range;

use transport::kernel::BASIS;

/// Number of the first widths, whose light has kept its direction as far as what lies below: up to 0.13 mm. The rest
/// comes from all sides.
pub(crate) const NARROW_WIDTHS: usize = 3;
/// First of the widths whose light leaves through the surface around a facet rather than through the facet: of 0.25 mm
/// and more.
pub(crate) const WIDE: usize = 3;
/// Widths near the line whose light may have crossed a pocket.
pub(crate) const NEAR: Range<usize> = 2..FILLING;
/// How many those are.
pub(crate) const NEAR_WIDTHS: usize = NEAR.end - NEAR.start;
/// First of the widths whose light fills a pocket: of 0.7 mm and more.
pub(crate) const FILLING: usize = 5;
/// First of the widths whose light has forgotten where it came in, and reaches from one line's window into another's:
/// of 1.3 mm and more.
pub(crate) const FAR: usize = 6;

/// Sum of Gaussians in their common middle: `surface_light` of the line's own variance, the rest on the fixed widths
/// [e-].
pub(crate) fn peak(
    spread_mm: &[f32; BASIS],
    surface_light: f32,
    variance: f32,
    rows_per_mm: f32,
    light: impl Fn(usize) -> f32,
) -> f32 {
    let spread = |j: usize| {
        let sigma = spread_mm[j] * rows_per_mm;
        light(j) / (variance + sigma * sigma).sqrt()
    };
    0.398_942_3 * (surface_light / variance.sqrt() + (0..BASIS).map(spread).sum::<f32>())
}
