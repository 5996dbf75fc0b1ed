//! A recipe and a number of samples -> a dataset folder, shard by shard, continued wherever it stopped.

use std::ops::Range;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use output_schema::dataset::{Generator, RecipeHead, SplitShares};
use output_schema::{DatasetHead, FORMAT, NumberColumn, SCHEMA_VERSION, SubjectFiles};
use rayon::prelude::*;

use crate::effective::declared;
use crate::optics::speckle::Tiles;
use crate::pipeline;
use crate::recipe::Recipe;
use crate::settings::Transport;
use crate::shard::{
    self, DatasetFolder, Encoded, GENERATOR_VERSION, ROW_BYTES, ShardError, ShardWriter, TABLES_BYTES,
    estimated_bytes_per_sample, number_column,
};

/// Memory for samples on their way to disk [bytes].
const FLIGHT_BYTES: usize = 900 << 20;
/// Bytes of maps, truth and encoded images that a pixel needs while its sample is on the way.
const BYTES_PER_PIXEL: usize = 40;
/// Copies of its kept sensor frames that a sample holds at most: as exposed, and as a row of a table.
const FRAME_COPIES: usize = 2;

/// What to make.
#[derive(Debug, Clone)]
pub struct Order {
    /// Samples that the dataset shall have.
    pub samples: u64,
    /// Seed.
    pub seed: u64,
    /// Folder.
    pub out: PathBuf,
    /// Which part of the shards: part k of m takes shards k, k + m, k + 2 m ...
    pub part: (u64, u64),
    /// Samples in a shard, where it is not the recipe's to say.
    pub samples_per_shard: Option<u64>,
}

/// What happened, for whoever shows it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Event {
    /// So many samples with so many profiles each will be rendered.
    Begin {
        /// Samples to render.
        samples: u64,
        /// Samples of this part that were finished before.
        finished: u64,
    },
    /// So many profiles more are rendered.
    Profiles(u64),
    /// A sample is written, so many bytes.
    Sample(u64),
    /// A shard is finished.
    Shard(u64),
    /// A shard is left to the process that works on it.
    Busy(u64),
}

/// What a run did.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Summary {
    /// Samples rendered.
    pub samples: u64,
    /// Shards finished by this run.
    pub shards: u64,
    /// Shards that another process works on.
    pub busy: u64,
    /// Samples in the dataset when all parts are done.
    pub total: u64,
}

/// The head of the dataset that `order` describes.
pub fn head(recipe: &Recipe, order: &Order) -> DatasetHead {
    let per_shard =
        order.samples_per_shard.unwrap_or_else(|| shard::samples_per_shard(&recipe.output(), &recipe.size()) as u64);
    let parameters = recipe.draw(order.seed, 0).values();
    let splits = recipe.splits();
    let subject = recipe.subject();
    let files = SubjectFiles::named(subject.name()).expect("every subject has files; a test names them all");
    DatasetHead {
        format: FORMAT.into(),
        schema_version: SCHEMA_VERSION,
        generator: Generator { name: "sheetlight gen".into(), version: GENERATOR_VERSION.into() },
        target: env!("TARGET").into(),
        recipe: RecipeHead {
            name: recipe.name().into(),
            text: recipe.text().into(),
            hash: recipe.hash(),
            canonical: recipe.canonical(),
        },
        seed: order.seed,
        samples: order.samples,
        samples_per_shard: per_shard,
        shards: DatasetHead::shards_for(order.samples, per_shard),
        classes: recipe.classes().iter().map(|class| class.name.clone()).collect(),
        subject: subject.name().into(),
        pixel_classes: files.pixel_classes(),
        label_values: files.label_values(),
        splits: SplitShares { train: splits.train, validation: splits.validation, test: splits.test },
        images: shard::images(&recipe.output(), &recipe.size(), recipe.extraction().range),
        parameters: parameters.into_iter().map(|(parameter, _)| number_column(parameter)).collect(),
        physics: declared(subject).iter().map(|(name, doc)| NumberColumn::new("", name, doc)).collect(),
    }
}

/// Renders and encodes one sample.
pub fn sample(recipe: &Recipe, seed: u64, index: u64, tiles: &Tiles, progress: &(dyn Fn(u64) + Sync)) -> Encoded {
    let scene = recipe.draw(seed, index);
    let record = pipeline::render(&scene, tiles, progress);
    shard::encode(record, &scene.output)
}

/// Makes what is missing of a dataset. Runs on the current rayon pool.
///
/// # Errors
/// [`ShardError`] as folder and shards give it; finished shards stay, and the same order continues.
pub fn generate(recipe: &Recipe, order: &Order, watch: &(dyn Fn(Event) + Sync)) -> Result<Summary, ShardError> {
    let folder = DatasetFolder::open_or_create(&order.out, head(recipe, order))?;
    let head = folder.head();
    let (part, parts) = order.part;
    let mine: Vec<u64> = (part..head.shards).step_by(parts as usize).collect();
    let remaining = folder.remaining(mine.iter().copied());
    let count = |shards: &[u64]| shards.iter().map(|&shard| head.span(shard).1).sum::<u64>();
    watch(Event::Begin { samples: count(&remaining), finished: count(&mine) - count(&remaining) });

    let tiles = Tiles::new(order.seed);
    let mut summary = Summary { total: head.samples, ..Summary::default() };
    for shard in remaining {
        let mut writer = match ShardWriter::create(&folder, shard) {
            Err(ShardError::Busy { .. }) => {
                summary.busy += 1;
                watch(Event::Busy(shard));
                continue;
            }
            Err(error) if error.is_skip() => continue,
            other => other?,
        };
        let (first, count) = writer.span();
        for flight in flights(first..first + count, in_flight(recipe)) {
            let encoded: Vec<Encoded> = flight
                .into_par_iter()
                .map(|index| sample(recipe, order.seed, index, &tiles, &|n| watch(Event::Profiles(n))))
                .collect();
            for sample in encoded {
                let bytes = sample.bytes();
                writer.push(sample)?;
                summary.samples += 1;
                watch(Event::Sample(bytes));
            }
        }
        writer.finish()?;
        summary.shards += 1;
        watch(Event::Shard(shard));
    }
    if folder.remaining(0..folder.head().shards).is_empty() {
        folder.complete()?;
    }
    Ok(summary)
}

/// Samples rendered side by side: several a thread so that none waits, as many as memory allows.
fn in_flight(recipe: &Recipe) -> u64 {
    let size = recipe.size();
    let frames = FRAME_COPIES * recipe.output().frames(&size) * size.columns * size.rows;
    let fitting = FLIGHT_BYTES / (size.columns * size.profiles * BYTES_PER_PIXEL + frames).max(1);
    (4 * rayon::current_num_threads()).min(fitting).max(1) as u64
}

fn flights(samples: Range<u64>, length: u64) -> impl Iterator<Item = Range<u64>> {
    let end = samples.end;
    samples.step_by(length as usize).map(move |start| start..(start + length).min(end))
}

/// Samples of each class in the whole dataset, in the recipe's order.
fn classes(recipe: &Recipe, order: &Order) -> Vec<(String, u64)> {
    let names: Vec<&str> = recipe.classes().iter().map(|class| class.name.as_str()).collect();
    let one = |mut counts: Vec<u64>, index: u64| {
        let class = &recipe.class_of(order.seed, index).name;
        names.iter().zip(&mut counts).filter(|(name, _)| *name == class).for_each(|(_, count)| *count += 1);
        counts
    };
    let none = || vec![0; names.len()];
    let sum = |a: Vec<u64>, b: Vec<u64>| a.iter().zip(b).map(|(a, b)| a + b).collect();
    let counts = (0..order.samples).into_par_iter().fold(none, one).reduce(none, sum);
    names.iter().map(|name| name.to_string()).zip(counts).collect()
}

/// What a dataset would take.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// Samples still to be made by this order.
    pub samples: u64,
    /// Shards that they fill.
    pub shards: u64,
    /// Size of one sample on disk [bytes].
    pub sample_bytes: u64,
    /// Time of one sample on this machine, all threads busy.
    pub sample_time: Duration,
    /// Free space where the dataset would lie [bytes].
    pub free: Option<u64>,
    /// Samples of each class in the whole dataset, in the recipe's order.
    pub classes: Vec<(String, u64)>,
}

impl Estimate {
    /// Samples that [`Self::measure`] renders: as many as a run has in the air, so that threads are as busy; only one
    /// where the transport is a slow one.
    pub fn trial(recipe: &Recipe, order: &Order) -> u64 {
        let together = if recipe.transport() == Transport::Kernel { in_flight(recipe) } else { 1 };
        together.min(order.samples)
    }

    /// Renders the first samples to see what one takes, and counts.
    pub fn measure(recipe: &Recipe, order: &Order) -> Self {
        let tiles = Tiles::new(order.seed);
        let together = Self::trial(recipe, order);
        if together > 1 {
            // Tables are filled before the clock runs; a sample so large that it flies alone hides them.
            sample(recipe, order.seed, 0, &tiles, &|_| ());
        }
        let start = Instant::now();
        let bytes: u64 =
            (0..together).into_par_iter().map(|i| sample(recipe, order.seed, i, &tiles, &|_| ()).bytes()).sum();
        let sample_time = start.elapsed() / together as u32;
        let (count, classes) = (Self::count(recipe, order), classes(recipe, order));
        Self { sample_bytes: bytes / together + ROW_BYTES, sample_time, classes, ..count }
    }

    /// Counts what is to be made; size from the recipe's channels, no time and no classes.
    pub fn count(recipe: &Recipe, order: &Order) -> Self {
        let (part, parts) = order.part;
        let folder = DatasetFolder::open(&order.out).ok();
        let head = head(recipe, order);
        // A shard that the folder's head ends early is made again.
        let missing = |&shard: &u64| {
            folder.as_ref().is_none_or(|f| f.head().span(shard) != head.span(shard) || !f.is_done(shard))
        };
        let (mut samples, mut shards) = (0, 0);
        for shard in (part..head.shards).step_by(parts as usize).filter(missing) {
            samples += head.span(shard).1;
            shards += 1;
        }
        Self {
            samples,
            shards,
            sample_bytes: estimated_bytes_per_sample(&recipe.output(), &recipe.size()),
            sample_time: Duration::ZERO,
            free: shard::free_bytes(&order.out),
            classes: Vec::new(),
        }
    }

    /// Size of what is to be made [bytes].
    pub fn bytes(&self) -> u64 {
        self.sample_bytes.saturating_mul(self.samples).saturating_add(TABLES_BYTES * self.shards)
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
