//! The same dataset with fewer samples: those that scales are found from, and those that a stopped run has left.

use std::collections::BTreeMap;

use super::{ExportProgress, ExportSource, Selection};
use crate::export::sample::ExportSample;
use dataset::Fault;
use optical_bench::split::Split;

/// What a stopped run has exported of a split: its first samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Done {
    /// How many.
    pub samples: u64,
    /// The last of them, by index.
    pub last: u64,
}

impl ExportSource {
    /// `count` finished samples evenly spread over all that are, whatever was chosen; as [`Source::each`] else.
    pub(crate) fn spread<T: Send>(
        &self,
        count: u64,
        images: &[&str],
        work: impl Fn(&ExportSample) -> Result<T, Fault> + Sync,
        mut take: impl FnMut(T),
        progress: ExportProgress,
    ) -> Result<(), Fault> {
        let all: u64 = self.finished.iter().map(|(_, samples)| samples).sum();
        let count = count.min(all);
        let (mut shards, mut indices, mut before) = (Vec::new(), Vec::new(), 0);
        for &(shard, samples) in &self.finished {
            let places = (0..count).map(|i| i * all / count).filter(|place| (before..before + samples).contains(place));
            let places: Vec<u64> = places.map(|place| place - before).collect();
            before += samples;
            if let Some(manifest) = if places.is_empty() { None } else { self.dataset.manifest(shard)? } {
                shards.push(shard);
                indices
                    .extend(places.iter().filter_map(|place| manifest.samples.get(*place as usize)).map(|s| s.index));
            }
        }
        let samples = indices.len() as u64;
        let selection =
            Selection { splits: Vec::new(), indices: indices.into_iter().map(|index| index..=index).collect() };
        let chosen = Self { selection, shards, samples, done: BTreeMap::new(), ..self.clone() };
        let take = |_: &ExportSample, result| {
            take(result);
            Ok(())
        };
        chosen.each(images, work, take, progress)
    }

    /// Chosen samples of a split up to one of them, by index.
    pub(crate) fn up_to(&self, split: Split, last: u64) -> Result<u64, Fault> {
        let mut count = 0;
        for &shard in &self.shards {
            let Some(manifest) = self.dataset.manifest(shard)? else { continue };
            let chosen = manifest.samples.iter().filter(|sample| self.selection.has(sample));
            count += chosen.filter(|sample| split.name() == sample.split && sample.index <= last).count() as u64;
        }
        Ok(count)
    }

    /// What is left where a run before has exported the first samples of some splits.
    pub(crate) fn after(&self, done: BTreeMap<Split, Done>) -> Self {
        Self { done, ..self.clone() }
    }
}
