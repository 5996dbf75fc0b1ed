//! What drawn numbers describe, sample by sample: a width of knots says nothing of a board without knots.
//!
//! It follows from what a recipe's parameters need to have an effect ([`super::needs`]). Needs that all samples
//! of a dataset share (the laser's profile, where the log comes from) are no fact of a sample and decide nothing here.
//! A count that can be 0 says itself that there is nothing, so it always means something.

use std::collections::BTreeMap;

use base::{Need, Words};
use serde_json::Value;

use super::bounds::{DrawBounds, NO_OVERRIDES};
use super::needs;
use crate::distribution::Distribution;
use crate::keys;
use crate::subject::Subject;
use optical_bench::settings::LogSource;

/// What the drawn number at a path describes, which some samples of a dataset may lack.
#[derive(Debug, Clone)]
pub struct SampleNeeds {
    subject: Subject,
    source: LogSource,
    needs: Vec<Need>,
    deciders: Vec<&'static str>,
}

impl SampleNeeds {
    /// Of the number at `path` in the dataset of a recipe in canonical form; `None` where every sample has what it
    /// describes, or where it has an effect in none.
    pub fn new(canonical: &Value, path: &str) -> Option<Self> {
        let subject = canonical["subject"].as_str().and_then(Subject::named)?;
        let source = canonical["log"]["source"].as_str().and_then(LogSource::named).unwrap_or(LogSource::Placed);
        let parameter = keys::parameter(Some(subject), path)?;
        if (parameter.integer && parameter.min == 0.0) || !needs::has_room_in(path, source) {
            return None;
        }
        let needs = parameter.conditions.iter().map(|condition| condition.need);
        let needs: Vec<_> = needs.filter(|need| needs::is_of_samples(*need, subject, source)).collect();
        let mut deciders: Vec<_> = needs.iter().flat_map(|need| needs::deciders(*need)).collect();
        deciders.sort_unstable();
        deciders.dedup();
        (!deciders.is_empty()).then_some(Self { subject, source, needs, deciders })
    }

    /// Paths of the drawn numbers that say whether a sample has it.
    pub fn deciders(&self) -> &[&'static str] {
        &self.deciders
    }

    /// Whether a sample lacks it, by the values of [`Self::deciders`]; `None` for one that the dataset does not have,
    /// which is then what it is by default.
    pub fn are_unmet(&self, values: &[Option<f64>]) -> bool {
        let usual = |path: &str| keys::parameter(None, path).map_or(0.0, |parameter| parameter.default);
        let drawn = self.deciders.iter().zip(values);
        let base: BTreeMap<String, Distribution> = drawn
            .map(|(path, value)| ((*path).to_owned(), Distribution::Fixed(value.unwrap_or_else(|| usual(path)))))
            .collect();
        let scene = DrawBounds { prefix: String::new(), base: &base, overrides: &NO_OVERRIDES };
        self.needs.iter().any(|need| needs::is_unmet(*need, Some(self.subject), self.source, &scene))
    }
}
