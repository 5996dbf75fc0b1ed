//! Class: a kind of sample.

use std::collections::BTreeMap;

use super::distribution::Distribution;

/// A kind of sample: what it changes of the top level, and how often it comes.
#[derive(Debug, Clone, PartialEq)]
pub struct SampleClass {
    /// Name, of a-z, 0-9 and _.
    pub name: String,
    /// Share of the samples [1]; the shares of all classes sum to 1.
    pub share: f64,
    /// Distributions in place of the top level's, by path.
    pub(super) overrides: BTreeMap<String, Distribution>,
}
