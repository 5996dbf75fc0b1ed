//! Generation of datasets: a recipe and a number of samples -> a dataset folder, written shard by shard and continued
//! where it stopped.

mod estimate;
mod expected_dataset;
mod memory;

use std::collections::{BTreeMap, VecDeque};
use std::ops::Range;
use std::panic::resume_unwind;
use std::path::PathBuf;
use std::sync::mpsc::{self, Receiver, Sender, SyncSender};
use std::sync::{Mutex, PoisonError};

use base::Class;
use output_schema::dataset::{Generator, RecipeHead, SplitShares};
use output_schema::file::asset_path;
use output_schema::{
    AssetHead, DatasetHead, FORMAT, NumberColumn, RigWarning, SCHEMA_VERSION, label_values, pixel_classes,
};
use rayon::prelude::*;
use serde::Serialize;

use dataset::shares::Shortfall;
use dataset::{self, Claim, Dataset, Encoded, Fault, GENERATOR_VERSION, ShardWriter, differences, number_column};
use evidence::reference::line_solver;
use pipeline::{self, Equipment, effective};
use recipe::asset::Asset;
use recipe::asset_source::{AssetSource, KeptAsset};
use recipe::{Change, Recipe};
use rig::{check, mistakes};
use scanner::optics::speckle::PatternCache;

pub use self::estimate::GenerateEstimate;
pub use self::expected_dataset::ExpectedDataset;
pub use self::memory::MemoryEstimate;

/// Memory for samples on their way to disk [bytes].
const IN_FLIGHT_BYTES: usize = 900 << 20;
/// Bytes of maps, truth and encoded images that a pixel needs while its sample is on the way.
const BYTES_PER_PIXEL: usize = 40;
/// Bytes of a pixel of a kept sensor frame that a sample holds at most: as exposed, and as a row of a table.
const FRAME_BYTES: usize = 4;

/// Bytes of a triangle of a part while its sample is on the way: placed, as a soup, and in a tree for rays.
const TRIANGLE_BYTES: usize = 200;

/// The dataset to make, and which part of it.
#[derive(Debug, Clone)]
pub struct DatasetRequest {
    /// Samples of the whole dataset.
    pub samples: u64,
    /// Seed of all draws.
    pub seed: u64,
    /// Folder of the dataset.
    pub out: PathBuf,
    /// Which part of the shards: part k of m takes shards k, k + m, k + 2 m ...
    pub part: (u64, u64),
    /// Samples in a shard; `None` leaves it to the recipe.
    pub samples_per_shard: Option<u64>,
}

impl DatasetRequest {
    /// Whether all of the dataset is asked for, so that no part of it is made elsewhere.
    fn is_whole(&self) -> bool {
        self.part == (0, 1)
    }

    /// The shards of the part in which the samples lie that are asked for; a dataset may have more.
    fn shards(&self, head: &DatasetHead) -> impl Iterator<Item = u64> + use<> {
        let (part, parts) = self.part;
        let end = DatasetHead::shards_for(self.samples, head.samples_per_shard).min(head.shards);
        (part..end).step_by(parts as usize)
    }
}

/// What a run reports while it makes a dataset; as it is told to programs, its name is the key `event`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(tag = "event", rename_all = "kebab-case")]
pub enum GenerateEvent {
    /// The dataset in the folder, of which nothing was made, is begun anew: with fewer samples than these, or in shards
    /// of another size than this.
    Anew {
        /// Samples that it was begun with.
        samples: u64,
        /// Samples in each of its shards.
        samples_per_shard: u64,
    },
    /// The dataset in the folder was begun with more samples than are asked for; shards are made whole.
    Larger {
        /// Samples that it was begun with.
        samples: u64,
        /// Samples to render.
        to_make: u64,
        /// Samples that are not asked for and not there.
        left: u64,
    },
    /// So many samples with so many profiles each will be rendered.
    Begin {
        /// Samples to render.
        samples: u64,
        /// Samples of this part that were finished before.
        finished: u64,
    },
    /// Profiles are rendered.
    Profiles {
        /// How many more.
        done: u64,
    },
    /// A sample is written.
    Sample {
        /// Its size.
        bytes: u64,
    },
    /// A shard is finished.
    Shard {
        /// Its number.
        shard: u64,
    },
    /// A shard is left for later, because another process works on it.
    Busy {
        /// Its number.
        shard: u64,
    },
    /// The file system keeps no two processes apart that make the same shard.
    NoLocks {
        /// In words.
        text: &'static str,
    },
    /// Nothing goes on until another process lets go of a shard.
    Waits {
        /// Its number; `None` for the folder's documents.
        #[serde(skip_serializing_if = "Option::is_none")]
        shard: Option<u64>,
    },
}

/// What is told where the file system has no locks.
const NO_LOCKS: &str =
    "the file system has no locks between processes (flock): let no two make the same shards, give each its --part";

/// Result of a run.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct GenerateSummary {
    /// Samples rendered.
    pub samples: u64,
    /// Shards finished by this run.
    pub shards: u64,
    /// Shards that another process worked on and finished.
    pub others: u64,
    /// Samples in the dataset when all parts are done.
    pub total: u64,
    /// Samples of these that were not asked for and are not there.
    pub left: u64,
    /// Samples rendered that fall short, in the order of [`Shortfall::ALL`].
    pub short: [u64; Shortfall::ALL.len()],
    /// Defects that the objects of rendered samples have, and how many of these show at least a pixel, by class.
    pub defects: BTreeMap<Class, [u64; 2]>,
}

impl GenerateSummary {
    /// Counts a sample that is to be written.
    fn count(&mut self, sample: &Encoded) {
        self.samples += 1;
        for (classes, shown) in [(&sample.defects, 1), (&sample.unseen, 0)] {
            for class in classes {
                let counts = self.defects.entry(*class).or_default();
                *counts = [counts[0] + 1, counts[1] + shown];
            }
        }
        for shortfall in sample.shares.shortfalls() {
            self.short[shortfall as usize] += 1;
        }
    }

    /// Classes of which defects show no pixel: how many there are, and how many show. The pith is none of them: every
    /// log has one, and most boards are cut beside it.
    pub fn hidden_defects(&self) -> impl Iterator<Item = (Class, [u64; 2])> {
        let defects = self.defects.iter().filter(|(class, _)| **class != Class::Pith);
        defects.map(|(class, counts)| (*class, *counts)).filter(|(_, [all, shown])| shown < all)
    }

    /// What samples fall short in, with how many of those rendered.
    pub fn short_samples(&self) -> impl Iterator<Item = (Shortfall, u64)> {
        Shortfall::ALL.into_iter().zip(self.short).filter(|(_, count)| *count > 0)
    }
}

/// The files that a recipe names, as its dataset keeps them.
fn assets(recipe: &Recipe) -> Vec<AssetHead> {
    let one = |(key, file): (&str, &Asset)| AssetHead {
        key: key.into(),
        name: file.name().into(),
        path: asset_path(file.sha256(), &file.plain_name()),
        bytes: file.bytes().len() as u64,
        sha256: file.sha256().into(),
    };
    recipe.files().map(one).collect()
}

/// The copies that a dataset keeps of the files that its recipe names.
///
/// # Errors
/// In words, where they should lie outside the folder.
pub fn kept_files(folder: &Dataset) -> Result<AssetSource, String> {
    let head = folder.head();
    if let Some(asset) = head.assets.iter().find(|asset| !asset.is_in_folder()) {
        return Err(format!("dataset.json says that `{}` lies in `{}`", asset.key, asset.path));
    }
    let kept = |asset: &AssetHead| KeptAsset {
        key: asset.key.clone(),
        name: asset.name.clone(),
        content: folder.asset(asset),
    };
    Ok(AssetSource::Kept(head.assets.iter().map(kept).collect()))
}

/// Minor version of the schema from which on numbers that a recipe does not state can vary.
const NATURAL_SINCE: u32 = 8;

/// The recipe of a dataset, from the folder alone: its text, and the copies of the files that it names. Where an older
/// program began it, what is not stated is fixed.
///
/// # Errors
/// In words, where it does not load, or no longer means the same.
pub fn recipe_of(folder: &Dataset) -> Result<Recipe, String> {
    let (head, files) = (folder.head(), kept_files(folder)?);
    let fixed = (head.schema_version[1] < NATURAL_SINCE).then(|| "unstated=fixed".parse::<Change>()).transpose()?;
    let recipe = Recipe::parse_changed("dataset.json", &head.recipe.text, &files, fixed.as_slice())
        .map_err(|error| error.to_string())?;
    if recipe.hash() == head.recipe.hash {
        return Ok(recipe);
    }
    let keys = differences("recipe", &head.recipe.canonical, &recipe.canonical());
    Err(format!("the recipe in dataset.json means something else to this program: {}", keys.join("; ")))
}

/// What the check of the rig warns of; it renders a few profiles. Follows from recipe and seed alone: the same however
/// many samples and parts the dataset has.
pub fn rig_warnings(recipe: &Recipe, seed: u64) -> Vec<RigWarning> {
    check::check(recipe, seed).into_iter().map(described).collect()
}

/// The same for the dataset that `request` makes or goes on with: one that is there says what was found when it was
/// begun.
pub fn dataset_warnings(recipe: &Recipe, request: &DatasetRequest) -> Vec<RigWarning> {
    let kept = || {
        let folder = Dataset::open(&request.out).ok()?;
        let head = folder.head();
        let same = head.recipe.hash == recipe.hash()
            && head.seed == request.seed
            && head.generator.version == GENERATOR_VERSION
            && head.target == env!("TARGET");
        same.then(|| head.warnings.clone())
    };
    kept().unwrap_or_else(|| rig_warnings(recipe, request.seed))
}

/// The same of one sample alone.
pub fn sample_warnings(recipe: &Recipe, seed: u64, index: u64) -> Vec<RigWarning> {
    let mistakes = mistakes::mistakes_of_scene(&recipe.draw(seed, index));
    check::check_sample(recipe, seed, index).into_iter().chain(mistakes).map(described).collect()
}

/// Numbers of a recipe that are legal and absurd beside the others, with the likely ones. These are guesses at what was
/// meant, and no document of a dataset has them.
pub fn unlikely_values(recipe: &Recipe, seed: u64) -> Vec<RigWarning> {
    mistakes::mistakes(recipe, seed).into_iter().map(described).collect()
}

fn described(found: check::RigWarning) -> RigWarning {
    RigWarning { code: found.fault.code().into(), what: found.what, remedy: found.remedy }
}

/// The head of the dataset that `request` describes, with the warnings of the rig's check.
pub fn dataset_head(recipe: &Recipe, request: &DatasetRequest, warnings: Vec<RigWarning>) -> DatasetHead {
    let per_shard = request.samples_per_shard.unwrap_or_else(|| {
        dataset::samples_per_shard(&recipe.output(), &recipe.size(), recipe.sample_seconds()) as u64
    });
    let parameters = recipe.draw(request.seed, 0).values();
    let splits = recipe.splits();
    let subject = recipe.subject();
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
        assets: assets(recipe),
        seed: request.seed,
        samples: request.samples,
        samples_per_shard: per_shard,
        shards: DatasetHead::shards_for(request.samples, per_shard),
        classes: recipe.classes().iter().map(|class| class.name.clone()).collect(),
        subject: subject.name().into(),
        pixel_classes: pixel_classes(subject.name(), SCHEMA_VERSION[1]),
        label_values: label_values(subject.name(), SCHEMA_VERSION[1]),
        splits: SplitShares { train: splits.train, validation: splits.validation, test: splits.test },
        images: dataset::images(&recipe.output(), &recipe.size(), recipe.extraction().range),
        parameters: parameters.into_iter().map(|(parameter, _)| number_column(parameter)).collect(),
        physics: effective::declared(recipe).iter().map(|(name, doc)| NumberColumn::new("", name, doc)).collect(),
        warnings,
    }
}

/// What samples of any recipe are rendered with.
pub fn equipment(patterns: &PatternCache) -> Equipment<'_> {
    Equipment { patterns, line_solvers: line_solver }
}

/// Renders and encodes one sample.
pub fn render_sample(
    recipe: &Recipe,
    seed: u64,
    index: u64,
    patterns: &PatternCache,
    progress: &(dyn Fn(u64) + Sync),
) -> Encoded {
    let scene = recipe.draw(seed, index);
    let record = pipeline::render(&scene, equipment(patterns), progress);
    dataset::encode(record, &scene.output)
}

/// Renders and writes the missing shards of a dataset. Runs on the current rayon pool.
///
/// Shards that other processes hold come last and are waited for: at the end all that was asked for is there, whoever
/// made it. Where another process ends without finishing its shard, this one makes it. `warnings` are those of
/// [`dataset_warnings`].
///
/// # Errors
/// A [`Fault`] as folder and shards give it; finished shards stay, and the same request continues.
pub fn generate(
    recipe: &Recipe,
    request: &DatasetRequest,
    warnings: Vec<RigWarning>,
    progress: &(dyn Fn(GenerateEvent) + Sync),
) -> Result<GenerateSummary, Fault> {
    let waits = || progress(GenerateEvent::Waits { shard: None });
    let begun = Dataset::open(&request.out).ok();
    let head = dataset_head(recipe, request, warnings);
    let folder = Dataset::open_or_create(&request.out, head, request.is_whole(), &waits)?;
    if let Some(DatasetHead { samples, samples_per_shard, .. }) = begun.as_ref().map(Dataset::head)
        && (*samples > folder.head().samples || *samples_per_shard != folder.head().samples_per_shard)
    {
        progress(GenerateEvent::Anew { samples: *samples, samples_per_shard: *samples_per_shard });
    }
    for (file, asset) in recipe.files().zip(&folder.head().assets) {
        folder.keep(&asset.path, file.1.bytes(), &waits)?;
    }
    if !folder.has_locks() {
        progress(GenerateEvent::NoLocks { text: NO_LOCKS });
    }
    let head = folder.head();
    let mine: Vec<u64> = request.shards(head).collect();
    let remaining = folder.remaining(mine.iter().copied())?;
    let count = |shards: &[u64]| shards.iter().map(|&shard| head.span(shard).1).sum::<u64>();
    let to_make = count(&remaining);
    let beyond = DatasetHead::shards_for(request.samples, head.samples_per_shard)..head.shards;
    let left = count(&folder.remaining(beyond)?);
    if left > 0 {
        progress(GenerateEvent::Larger { samples: head.samples, to_make, left });
    }
    progress(GenerateEvent::Begin { samples: to_make, finished: count(&mine) - to_make });

    let patterns = PatternCache::new(recipe.streams(request.seed).key());
    let mut summary = GenerateSummary { total: head.samples, left, ..GenerateSummary::default() };
    let making = Making { recipe, seed: request.seed, patterns: &patterns, progress };
    let busy = making.make(remaining, &|shard| ShardWriter::claim(&folder, shard), &mut summary)?;
    let when_free =
        |shard| ShardWriter::claim_when_free(&folder, shard, &|| progress(GenerateEvent::Waits { shard: Some(shard) }));
    making.make(busy, &when_free, &mut summary)?;
    folder.complete(&waits)?;
    Ok(summary)
}

/// What the samples of a run have in common.
#[derive(Clone, Copy)]
struct Making<'a> {
    recipe: &'a Recipe,
    seed: u64,
    patterns: &'a PatternCache,
    progress: &'a (dyn Fn(GenerateEvent) + Sync),
}

/// What goes to the thread that writes.
enum ToWrite {
    /// A shard that is to be written, before the first of its samples.
    Shard(Box<ShardWriter>),
    /// A sample of one of the shards that have come.
    Sample(Box<Encoded>),
}

impl Making<'_> {
    /// Makes the shards that `claim` grants: the pool renders their samples in order, several side by side, and a
    /// thread of its own writes meanwhile. The shards that other processes are busy with.
    fn make(
        &self,
        shards: Vec<u64>,
        claim: &(dyn Fn(u64) -> Result<Claim, Fault> + Sync),
        summary: &mut GenerateSummary,
    ) -> Result<Vec<u64>, Fault> {
        let most = in_flight(self.recipe) as usize;
        let (pieces, arrived) = mpsc::channel();
        let (written, places) = mpsc::sync_channel(most);
        for _ in 0..most {
            // There is room for all of them, and somebody to take them.
            let _ = written.send(());
        }
        let claimed = Mutex::new(Claimed::default());
        let order = ClaimedSamples {
            shards: shards.into_iter(),
            samples: 0..0,
            claim: &|shard| claim(shard).inspect(|claim| self.tell_busy(shard, claim)),
            pieces: pieces.clone(),
            places,
            claimed: &claimed,
        };
        let written = std::thread::scope(|scope| {
            let writing = scope.spawn(|| self.write(arrived, written, summary));
            order.par_bridge().for_each_with(pieces, |pieces, index| {
                let progress = |done| (self.progress)(GenerateEvent::Profiles { done });
                let sample = render_sample(self.recipe, self.seed, index, self.patterns, &progress);
                // Where writing has ended with a fault, nobody takes it.
                let _ = pieces.send(ToWrite::Sample(Box::new(sample)));
            });
            writing.join().unwrap_or_else(|panic| resume_unwind(panic))
        });
        written?;
        let Claimed { busy, others, fault } = claimed.into_inner().unwrap_or_else(PoisonError::into_inner);
        summary.others += others;
        fault.map_or(Ok(busy), Err)
    }

    fn tell_busy(&self, shard: u64, claim: &Claim) {
        if matches!(claim, Claim::Busy) {
            (self.progress)(GenerateEvent::Busy { shard });
        }
    }

    /// Writes what arrives, samples in the order of their numbers, and gives back the place of each.
    fn write(
        &self,
        arrived: Receiver<ToWrite>,
        written: SyncSender<()>,
        summary: &mut GenerateSummary,
    ) -> Result<(), Fault> {
        let mut shards = VecDeque::new();
        let mut early: BTreeMap<u64, Box<Encoded>> = BTreeMap::new();
        for piece in arrived {
            match piece {
                ToWrite::Shard(writer) => shards.push_back(writer),
                ToWrite::Sample(sample) => _ = early.insert(sample.index, sample),
            }
            while let Some(writer) = shards.front_mut() {
                let Some(sample) = early.remove(&writer.next()) else { break };
                let bytes = sample.bytes();
                summary.count(&sample);
                writer.push(*sample)?;
                (self.progress)(GenerateEvent::Sample { bytes });
                // Where all are rendered, nobody asks for a place.
                let _ = written.try_send(());
                if let Some(writer) = shards.pop_front_if(|writer| writer.is_full()) {
                    let shard = writer.finish()?.shard;
                    summary.shards += 1;
                    (self.progress)(GenerateEvent::Shard { shard });
                }
            }
        }
        Ok(())
    }
}

/// What came of claims.
#[derive(Default)]
struct Claimed {
    busy: Vec<u64>,
    /// Shards that other processes have finished.
    others: u64,
    fault: Option<Fault>,
}

/// Numbers of the samples of claimed shards: one is given where there is a place for it, until writing ends.
struct ClaimedSamples<'a> {
    shards: std::vec::IntoIter<u64>,
    /// Those of the last shard that are left.
    samples: Range<u64>,
    claim: &'a (dyn Fn(u64) -> Result<Claim, Fault> + Sync),
    pieces: Sender<ToWrite>,
    places: Receiver<()>,
    claimed: &'a Mutex<Claimed>,
}

impl Iterator for ClaimedSamples<'_> {
    type Item = u64;

    fn next(&mut self) -> Option<u64> {
        while self.samples.is_empty() {
            let shard = self.shards.next()?;
            let claim = (self.claim)(shard);
            let mut claimed = self.claimed.lock().unwrap_or_else(PoisonError::into_inner);
            match claim {
                Ok(Claim::Granted(writer)) => {
                    let (first, count) = writer.span();
                    self.samples = first..first + count;
                    self.pieces.send(ToWrite::Shard(writer)).ok()?;
                }
                Ok(Claim::Busy) => claimed.busy.push(shard),
                Ok(Claim::Done) => claimed.others += 1,
                Err(fault) => {
                    claimed.fault = Some(fault);
                    self.shards = Vec::new().into_iter();
                }
            }
        }
        self.places.recv().ok()?;
        self.samples.next()
    }
}

/// Samples rendered side by side: several a thread so that none waits, as many as memory allows.
fn in_flight(recipe: &Recipe) -> u64 {
    in_flight_of(recipe, rayon::current_num_threads())
}

pub(crate) fn in_flight_of(recipe: &Recipe, threads: usize) -> u64 {
    let size = recipe.size();
    let frames = FRAME_BYTES * recipe.output().frames(&size) * size.columns * size.rows;
    let parts = recipe.mesh().map_or(0, |mesh| TRIANGLE_BYTES * mesh.triangles.len());
    let fitting = IN_FLIGHT_BYTES / (size.columns * size.profiles * BYTES_PER_PIXEL + frames + parts).max(1);
    (4 * threads).min(fitting).max(1) as u64
}
