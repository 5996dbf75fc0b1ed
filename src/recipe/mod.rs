//! Recipe: distributions, classes, sensor and sizes, exactly as in the YAML; and what one draw makes of it.

use procedural::Stream;
use procedural::wood::Wood;

use crate::optics::parameters::Bench;
use crate::record::Split;
use crate::settings::{Extraction, Output, Size, Splits};

/// One draw: plain numbers, no distributions.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// Sample number.
    pub index: u64,
    /// UUID v5 of (recipe hash, seed, index).
    pub id: String,
    /// Split, by hash of the id.
    pub split: Split,
    /// Name of the class.
    pub class: String,
    /// Root of every stream of this sample.
    pub stream: Stream,
    /// Sizes.
    pub size: Size,
    /// Bench.
    pub bench: Bench,
    /// Board.
    pub wood: Wood,
    /// How profiles are read.
    pub extraction: Extraction,
    /// What is written.
    pub output: Output,
}
