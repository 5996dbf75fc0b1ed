//! Speckle, anchored to the object: the pattern moves with the object's image, and boils while it does.
//!
//! - [`pupil`]: fully developed speckle behind a pupil of random phases, as square pixels gather it (Duncan and
//!   Kirkpatrick 2008; Bergmann et al. 2016)
//! - [`contrast`]: what pixels and movement leave of its contrast (Goodman 2007)
//! - [`stack`]: patterns whose pupils overlap, so that one boils into the next, and the cache that shares them
//! - `boiling`: how far a movement of the object takes the speckle across the pupil (Yamaguchi 1981)
//! - `anchored`: which row of which pattern a pixel sees
//!
//! Neglected: how the pattern of one column is sheared by movement at an angle to the columns; a pattern repeats after
//! [`TILE`] pixels along the line, at another offset.

pub(crate) mod anchored;
pub(crate) mod boiling;
pub mod coherence;
pub mod contrast;
pub mod pupil;
pub mod stack;
#[cfg(test)]
mod tests;
mod transform_lanes;

pub(crate) use self::anchored::{AnchoredSpeckle, SpeckleConditions, TileSpeckle};
pub use self::pupil::{Pupil, TILE};
pub use self::stack::{MAX_CACHED_BYTES, PatternCache, PatternStack, bytes_of_stack};
