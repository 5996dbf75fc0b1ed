//! The chosen samples of a dataset, read row by row and worked on by all cores in the order of shards.

mod part;

use std::collections::BTreeMap;
use std::ops::{Range, RangeInclusive};
use std::path::Path;

use output_schema::row::IMAGES;
use output_schema::{DatasetHead, Manifest, ManifestSample};
use rayon::prelude::*;
use serde_json::{Value, json};

use super::sample::ExportSample;
use dataset::{Dataset, DatasetSums, Fault, RowQuery};
use optical_bench::split::Split;

pub(super) use part::Done;

/// Called with samples done and samples in all; first for those that scales are found from, where they are, and then
/// for those that are written.
pub type ExportProgress<'a> = &'a (dyn Fn(u64, u64) + Sync);

/// Which samples.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Selection {
    /// Of these splits; empty for all.
    pub splits: Vec<Split>,
    /// With an index in one of these; empty for all.
    pub indices: Vec<RangeInclusive<u64>>,
}

impl Selection {
    fn has(&self, sample: &ManifestSample) -> bool {
        self.has_split(&sample.split) && self.has_index(sample.index)
    }

    fn has_index(&self, index: u64) -> bool {
        self.indices.is_empty() || self.indices.iter().any(|range| range.contains(&index))
    }

    pub(super) fn has_split(&self, name: &str) -> bool {
        self.splits.is_empty() || self.splits.iter().any(|split| split.name() == name)
    }
}

/// An open dataset and the samples chosen from it.
#[derive(Debug, Clone)]
pub struct ExportSource {
    pub(super) dataset: Dataset,
    pub(super) selection: Selection,
    /// Shards with chosen samples.
    shards: Vec<u64>,
    /// Shards that were finished when the dataset was opened, with their samples; others may become so while it is
    /// read.
    finished: Vec<(u64, u64)>,
    /// Finished samples with a chosen index in each split, whether that was chosen or not.
    in_splits: BTreeMap<String, u64>,
    /// What a run before has exported of each split, where one has.
    done: BTreeMap<Split, Done>,
    /// Chosen samples that are finished.
    pub samples: u64,
    /// Shards that are not finished.
    pub unfinished: u64,
    sums: DatasetSums,
}

impl ExportSource {
    /// Opens a dataset.
    ///
    /// # Errors
    /// Where there is none, or none of the chosen samples is finished.
    pub fn open(path: &Path, selection: Selection) -> Result<Self, Fault> {
        let dataset = Dataset::open(path)?;
        let head = dataset.head();
        // Others may be finished while this goes on: sums and samples are of the same ones.
        let there: Vec<u64> = (0..head.shards).filter(|&shard| dataset.has_manifest(shard)).collect();
        let unfinished = head.shards - there.len() as u64;
        let sums = dataset.sums_of(there.iter().copied());
        if let Some(range) = selection.indices.iter().find(|range| *range.end() >= head.samples) {
            let remedy = format!("give --index 0 to {}", head.samples.saturating_sub(1));
            return Err(Fault::at(path, format!("there is no sample {}", range.end()), remedy));
        }
        let (mut shards, mut finished, mut samples) = (Vec::new(), Vec::new(), 0);
        let mut in_splits: BTreeMap<String, u64> = BTreeMap::new();
        for shard in there {
            let Some(manifest) = dataset.manifest(shard)? else { continue };
            finished.push((shard, manifest.samples.len() as u64));
            for sample in manifest.samples.iter().filter(|sample| selection.has_index(sample.index)) {
                *in_splits.entry(sample.split.clone()).or_default() += 1;
            }
            let chosen = manifest.samples.iter().filter(|sample| selection.has(sample)).count() as u64;
            if chosen > 0 {
                shards.push(shard);
                samples += chosen;
            }
        }
        if samples == 0 {
            let (what, remedy) = match unfinished {
                0 => ("it has no samples of that choice", "give another --split or --index"),
                _ => ("none of the chosen samples is finished", "run gen again to finish it"),
            };
            return Err(Fault::at(path, what, remedy));
        }
        let done = BTreeMap::new();
        Ok(Self { dataset, selection, shards, finished, in_splits, done, samples, unfinished, sums })
    }

    /// `dataset.json`.
    pub fn head(&self) -> &DatasetHead {
        self.dataset.head()
    }

    /// The folder.
    pub fn root(&self) -> &Path {
        self.dataset.root()
    }

    /// Finished samples of a split with a chosen index, whether that split was chosen or not.
    pub(super) fn in_split(&self, split: Split) -> u64 {
        self.in_splits.get(split.name()).copied().unwrap_or_default()
    }

    /// What an export is of: the dataset and the choice.
    pub(super) fn told(&self) -> Value {
        let head = self.head();
        let splits: Vec<&str> = self.selection.splits.iter().map(|split| split.name()).collect();
        let indices: Vec<_> = self.selection.indices.iter().map(|range| json!([range.start(), range.end()])).collect();
        json!({
            "dataset": head.recipe.name,
            "subject": head.subject,
            "seed": head.seed,
            "dataset_sha256": self.sums.dataset,
            "manifests_sha256": self.sums.manifests,
            "splits": if splits.is_empty() { Split::ALL.map(Split::name).to_vec() } else { splits },
            "indices": indices,
        })
    }

    /// Refuses where one of these images is in no file of the dataset.
    pub(super) fn needs(&self, images: &[&str]) -> Result<(), Fault> {
        let known = &self.head().images;
        match images.iter().find(|image| !self.has(image)) {
            None => Ok(()),
            Some(missing) => {
                let what = format!("it was made without `{missing}` images (png {:?}, exr {:?})", known.png, known.exr);
                let remedy = format!("add {missing} to `output: {{png: [..]}}` of the recipe and make it anew");
                Err(Fault::at(self.root(), what, remedy))
            }
        }
    }

    /// Whether an image is in the dataset, in whatever form.
    pub(super) fn has(&self, image: &str) -> bool {
        let known = &self.head().images;
        known.png.iter().chain(&known.exr).any(|name| name == image)
    }

    /// Whether a sample is chosen, and no run before has exported it.
    fn has_left(&self, sample: &ManifestSample) -> bool {
        let is_done = |(split, done): (&Split, &Done)| split.name() == sample.split && sample.index <= done.last;
        self.selection.has(sample) && !self.done.iter().any(is_done)
    }

    /// Works on the numbers of the chosen samples with all threads, shard by shard, each with its shard's manifest.
    ///
    /// # Errors
    /// Where a manifest is damaged, or `work` fails; of several errors the first in the order of samples.
    pub(super) fn each_index(
        &self,
        work: impl Fn(&Manifest, u64) -> Result<(), Fault> + Sync,
        progress: ExportProgress,
    ) -> Result<(), Fault> {
        let mut done: u64 = self.done.values().map(|done| done.samples).sum();
        for &shard in &self.shards {
            let Some(manifest) = self.dataset.manifest(shard)? else { continue };
            let chosen = manifest.samples.iter().filter(|sample| self.has_left(sample));
            let chosen: Vec<u64> = chosen.map(|sample| sample.index).collect();
            for some in chosen.chunks(rayon::current_num_threads().max(1)) {
                let worked: Vec<_> = some.par_iter().map(|&index| work(&manifest, index)).collect();
                worked.into_iter().collect::<Result<(), _>>()?;
                done += some.len() as u64;
                progress(done, self.samples);
            }
        }
        Ok(())
    }

    /// Works on every chosen sample that is left with all threads, and takes the results in the order of shards, splits
    /// and indices.
    ///
    /// # Errors
    /// Where a file of the dataset is damaged, or `work` or `take` fail.
    pub(super) fn each<T: Send>(
        &self,
        images: &[&str],
        work: impl Fn(&ExportSample) -> Result<T, Fault> + Sync,
        mut take: impl FnMut(&ExportSample, T) -> Result<(), Fault>,
        progress: ExportProgress,
    ) -> Result<(), Fault> {
        let stored: Vec<&str> =
            images.iter().copied().filter(|image| self.head().images.png.iter().any(|png| png == image)).collect();
        let with_exr = stored.len() < images.len();
        let together = rayon::current_num_threads().max(1);
        let mut done: u64 = self.done.values().map(|done| done.samples).sum();
        for &shard in &self.shards {
            let Some(manifest) = self.dataset.manifest(shard)? else { continue };
            for split in Split::ALL {
                let of_split: Vec<_> = manifest.samples.iter().filter(|sample| sample.split == split.name()).collect();
                let chosen = of_split.iter().copied().enumerate().filter(|(_, sample)| self.has_left(sample));
                let chosen: Vec<(usize, &ManifestSample)> = chosen.collect();
                if chosen.is_empty() {
                    continue;
                }
                let table = self.dataset.table(shard, split);
                let columns = |name: &str| !IMAGES.contains(&name) || stored.contains(&name);
                let query = RowQuery { columns: &columns, ranges: Some(ranges(&chosen)), at_once: 1 };
                let rows = table.rows(&query)?;
                if rows.in_table() != of_split.len() as u64 {
                    let (found, named) = (rows.in_table(), of_split.len());
                    return Err(table.damaged(format!("it has {found} rows, and its manifest names {named}")));
                }
                let mut pairs = rows.zip(chosen).peekable();
                while pairs.peek().is_some() {
                    let some: Vec<_> = pairs.by_ref().take(together).collect();
                    let worked: Vec<_> = some
                        .into_par_iter()
                        .map(|(row, (_, listed))| {
                            let row = row?.json(0).map_err(|what| table.damaged(what))?;
                            let sample = ExportSample::new(&self.dataset, &table, row, listed, with_exr)?;
                            work(&sample).map(|result| (sample, result))
                        })
                        .collect();
                    for result in worked {
                        let (sample, result) = result?;
                        take(&sample, result)?;
                        done += 1;
                        progress(done, self.samples);
                    }
                }
            }
        }
        Ok(())
    }
}

/// Rows as ranges.
fn ranges(chosen: &[(usize, &ManifestSample)]) -> Vec<Range<usize>> {
    let mut ranges: Vec<Range<usize>> = Vec::new();
    for &(place, _) in chosen {
        match ranges.last_mut() {
            Some(last) if last.end == place => last.end += 1,
            _ => ranges.push(place..place + 1),
        }
    }
    ranges
}
