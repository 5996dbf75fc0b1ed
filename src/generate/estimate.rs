//! Estimate of what a dataset takes: time, disk, samples of each class.

use std::time::{Duration, Instant};

use output_schema::DatasetHead;
use rayon::prelude::*;

use super::{DatasetRequest, dataset_head, in_flight, render_sample};
use dataset::{self, DOCUMENTS_BYTES, Dataset, ROW_BYTES, TABLES_BYTES, estimated_bytes_per_sample};
use optical_bench::settings::Transport;
use recipe::Recipe;
use scanner::optics::speckle::PatternCache;

/// Pixels of a scan from which few samples are measured: such take seconds each [px].
const LARGE_SCAN: usize = 1_000_000;

fn is_large(recipe: &Recipe) -> bool {
    recipe.size().columns * recipe.size().profiles >= LARGE_SCAN
}

/// Time, space and samples that a dataset takes.
#[derive(Debug, Clone, PartialEq)]
pub struct GenerateEstimate {
    /// Samples that the dataset then has: more than are asked for, where it was begun with more.
    pub total: u64,
    /// Samples that this request still has to make.
    pub samples: u64,
    /// Shards that they fill.
    pub shards: u64,
    /// Size of one sample on disk [bytes].
    pub sample_bytes: u64,
    /// Time of one sample on this machine, all threads busy.
    pub sample_time: Duration,
    /// Free space where the dataset would lie [bytes].
    pub free: Option<u64>,
    /// Samples of each class in the whole dataset, in the recipe's order, by split: train, validation, test.
    pub classes: Vec<(String, [u64; 3])>,
}

impl GenerateEstimate {
    /// Samples that [`Self::measure`] renders: as many as a run renders side by side, so that threads are as busy; of
    /// large scans one a thread, and only one where the model of transport is slow.
    pub fn trial(recipe: &Recipe, request: &DatasetRequest) -> u64 {
        let together = match recipe.transport() {
            Transport::Kernel if is_large(recipe) => in_flight(recipe).min(rayon::current_num_threads() as u64),
            Transport::Kernel => in_flight(recipe),
            Transport::Path { .. } | Transport::Diffusion { .. } | Transport::Thesis { .. } => 1,
        };
        together.min(request.samples)
    }

    /// Renders the first samples to see what one takes, and counts; `progress` is told how many of their profiles more
    /// are rendered.
    pub fn measure(recipe: &Recipe, request: &DatasetRequest, progress: &(dyn Fn(u64) + Sync)) -> Self {
        let patterns = PatternCache::new(recipe.streams(request.seed).key());
        let together = Self::trial(recipe, request);
        if together > 1 && !is_large(recipe) {
            // Tables are filled before the time is taken; beside large samples they do not count.
            render_sample(recipe, request.seed, 0, &patterns, &|_| ());
        }
        let start = Instant::now();
        let bytes: u64 = (0..together)
            .into_par_iter()
            .map(|i| render_sample(recipe, request.seed, i, &patterns, progress).bytes())
            .sum();
        let sample_time = start.elapsed() / together as u32;
        let count = Self::count(recipe, request);
        let names = recipe.classes().iter().map(|class| class.name.clone());
        let classes = names.zip(recipe.class_counts(request.seed, request.samples)).collect();
        Self { sample_bytes: bytes / together + ROW_BYTES, sample_time, classes, ..count }
    }

    /// Counts what is to be made; size from the recipe's channels, no time and no classes.
    pub fn count(recipe: &Recipe, request: &DatasetRequest) -> Self {
        let folder = Dataset::open(&request.out).ok();
        // Nothing but sizes is asked of it.
        let mut head = dataset_head(recipe, request, Vec::new());
        if let Some(folder) = &folder
            && !(request.is_whole() && folder.manifests_named() == Ok(0))
        {
            // What was begun with more keeps its number once something of it is made.
            head.samples = head.samples.max(folder.head().samples);
            head.shards = DatasetHead::shards_for(head.samples, head.samples_per_shard);
        }
        // The last shard of a dataset that grows has fewer samples on disk and is made again.
        let missing = |&shard: &u64| {
            let is_done = |f: &Dataset| f.head().span(shard) == head.span(shard) && f.is_done(shard) == Ok(true);
            !folder.as_ref().is_some_and(is_done)
        };
        let (mut samples, mut shards) = (0, 0);
        for shard in request.shards(&head).filter(missing) {
            samples += head.span(shard).1;
            shards += 1;
        }
        Self {
            total: head.samples,
            samples,
            shards,
            sample_bytes: estimated_bytes_per_sample(&recipe.output(), &recipe.size()),
            sample_time: Duration::ZERO,
            free: dataset::free_bytes(&request.out),
            classes: Vec::new(),
        }
    }

    /// Size of what is to be made [bytes].
    pub fn bytes(&self) -> u64 {
        let documents = if self.samples > 0 { DOCUMENTS_BYTES } else { 0 };
        self.sample_bytes.saturating_mul(self.samples).saturating_add(TABLES_BYTES * self.shards + documents)
    }

    /// Time that it takes.
    pub fn time(&self) -> Duration {
        self.sample_time.saturating_mul(self.samples.min(u64::from(u32::MAX)) as u32)
    }

    /// Whether the disk can hold it; true where the system does not say.
    pub fn fits(&self) -> bool {
        self.free.is_none_or(|free| self.bytes() <= free)
    }
}
