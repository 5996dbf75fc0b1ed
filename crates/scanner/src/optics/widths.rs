//! Classes of the fixed widths: which of them are told apart, and why.
//!
//! Light spreads by a fixed series of widths ([`transport::kernel::PACK_SPREAD_MM`] where there is film). What happens to it on the way
//! depends on how far it has come.

use std::ops::Range;

/// Number of the first widths, whose light has kept its direction as far as what lies below: up to 0.13 mm. The rest comes from all sides.
pub(super) const NARROW_WIDTHS: usize = 3;
/// First of the widths whose light leaves through the surface around a facet rather than through the facet: of 0.25 mm and more.
pub(super) const WIDE: usize = 3;
/// Widths near the line whose light may have crossed a pocket.
pub(super) const NEAR: Range<usize> = 2..FILLING;
/// How many those are.
pub(super) const NEAR_WIDTHS: usize = NEAR.end - NEAR.start;
/// First of the widths whose light fills a pocket: of 0.7 mm and more.
pub(super) const FILLING: usize = 5;
/// First of the widths whose light has forgotten where it came in, and reaches from one line's window into another's: of 1.3 mm and more.
pub(super) const FAR: usize = 6;
