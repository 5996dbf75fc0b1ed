//! What is promised to other programs: recipes by name, their samples without a disk, datasets that were written, and
//! the command line as a function ([`crate::cli::run_from`]). Everything else of this workspace may change with any
//! version.
//!
//! ```
//! use sheetlight::api::{Simulator, Stop, load};
//!
//! let recipe = load("wood-small", &["scan.profiles=64".parse()?])?.recipe;
//! let simulator = Simulator::new(recipe, 0);
//! let sample = simulator.sample(3, &Stop::default()).expect("nobody asked to stop");
//! assert_eq!(sample.maps.scatter.len(), sample.rows * sample.cols);
//! # Ok::<(), Box<dyn std::error::Error + Send + Sync>>(())
//! ```

use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};

use ::recipe::asset_source::AssetSource;
use dataset::{range_joined, range_values};
use output_schema::arrow::row_schema;
use output_schema::file::{DATASET, data_path, exr_path, stack_path};
use output_schema::{Manifest, ManifestFile, ManifestSample};
use serde_json::{Map, Value};

use crate::generate::{DatasetRequest, MemoryEstimate, dataset_head, equipment, in_flight_of, kept_files, recipe_of};
use scanner::optics::speckle::PatternCache;

pub use dataset::record::{Below, Labels, Maps, Record, StackFrame, TruthMaps};
pub use dataset::{Dataset, ExrMaps, Fault, Grey, RowBatch};
pub use drawing::class_colour;
pub use output_schema::file::manifest_path;
pub use output_schema::{DatasetHead, Images};
pub use recipe::{Change, Recipe, RecipeError, YamlFault, YamlFaults};

/// A recipe, and the dataset that it was taken from where a folder was named.
#[derive(Debug)]
pub struct LoadedRecipe {
    /// The recipe.
    pub recipe: Recipe,
    /// The dataset.
    pub dataset: Option<Dataset>,
}

impl LoadedRecipe {
    /// The seed that was asked for, else that of the dataset, else 0.
    pub fn seed(&self, asked: Option<u64>) -> u64 {
        asked.or(self.dataset.as_ref().map(|dataset| dataset.head().seed)).unwrap_or(0)
    }
}

/// Why there is no recipe.
#[derive(Debug, thiserror::Error)]
pub enum LoadError {
    /// Nothing has that name, or it has faults.
    #[error(transparent)]
    Recipe(#[from] RecipeError),
    /// The dataset in the folder cannot be read.
    #[error(transparent)]
    Dataset(#[from] Fault),
    /// The folder is of no use, in words.
    #[error("{0}")]
    Folder(String),
}

/// What to do where a dataset's recipe is not what it was.
const OTHER_RECIPE: &str = "use the program that wrote the dataset, or make another one of recipe.text in its \
    dataset.json (docs/guide/older-datasets.md)";

/// The recipe in the file `name`, the built-in one of that name, or that of the dataset in the folder `name`; with
/// changes.
///
/// # Errors
/// All faults of the recipe at once, each with line, key and remedy; or why the folder is of no use.
pub fn load(name: &str, changes: &[Change]) -> Result<LoadedRecipe, LoadError> {
    let path = Path::new(name);
    // No name is no recipe, wherever this runs.
    if !name.is_empty() && holds_dataset(path) {
        let dataset = Dataset::open(path)?;
        let mut recipe =
            recipe_of(&dataset).map_err(|what| LoadError::Folder(format!("{name}: {what}; {OTHER_RECIPE}")))?;
        if !changes.is_empty() {
            let files = kept_files(&dataset).map_err(LoadError::Folder)?;
            recipe = Recipe::parse_changed(name, recipe.text(), &files, changes)?;
        }
        return Ok(LoadedRecipe { recipe, dataset: Some(dataset) });
    }
    if path.is_dir() {
        let what = format!("{name} is a folder that holds no {DATASET}; name a recipe or a dataset's folder");
        return Err(LoadError::Folder(what));
    }
    Ok(LoadedRecipe { recipe: Recipe::load_changed(name, changes)?, dataset: None })
}

/// The recipe of that text, with changes; files that it names lie in the working directory. Faults name its `origin`.
///
/// # Errors
/// All faults of the recipe at once, each with line, key and remedy.
pub fn parse(origin: &str, text: &str, changes: &[Change]) -> Result<LoadedRecipe, LoadError> {
    let recipe = Recipe::parse_changed(origin, text, &AssetSource::Beside(PathBuf::new()), changes)?;
    Ok(LoadedRecipe { recipe, dataset: None })
}

/// Whether the folder holds something by the name of a dataset's document; whether that can be used is asked elsewhere.
pub fn holds_dataset(root: &Path) -> bool {
    root.join(DATASET).symlink_metadata().is_ok()
}

/// Most threads for each core, and on a machine of few cores; each takes room for a band of rows.
const MAX_THREADS: (usize, usize) = (4, 16);

/// The cores of this machine, and the most threads that work is given here.
pub fn cores_and_threads() -> [usize; 2] {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    [cores, (MAX_THREADS.0 * cores).max(MAX_THREADS.1)]
}

/// Asks work in other threads to stop.
#[derive(Debug, Default)]
pub struct Stop(AtomicBool);

impl Stop {
    /// From now on.
    pub fn ask(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether somebody has.
    pub fn is_asked(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// Work that was asked to stop has stopped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stopped;

/// A recipe with a seed: renders its samples on the current rayon pool, and keeps what they have in common.
#[derive(Debug)]
pub struct Simulator {
    recipe: Recipe,
    seed: u64,
    patterns: PatternCache,
    head: OnceLock<DatasetHead>,
}

impl Simulator {
    /// Sample i follows from recipe, seed and i alone.
    pub fn new(recipe: Recipe, seed: u64) -> Self {
        let patterns = PatternCache::new(recipe.streams(seed).key());
        Self { recipe, seed, patterns, head: OnceLock::new() }
    }

    /// The recipe.
    pub fn recipe(&self) -> &Recipe {
        &self.recipe
    }

    /// The seed.
    pub fn seed(&self) -> u64 {
        self.seed
    }

    /// Samples that `threads` threads render side by side and keep until somebody takes them, as many as memory allows.
    pub fn samples_in_flight(&self, threads: usize) -> u64 {
        in_flight_of(&self.recipe, threads)
    }

    /// Refuses samples that the machine has no memory for, as many as so many threads keep.
    ///
    /// # Errors
    /// How much is missing, and what to do.
    pub fn check_memory(&self, threads: usize) -> Result<(), Fault> {
        MemoryEstimate::of_dataset(&self.recipe, threads).check()
    }

    /// The same for one sample that so many threads render.
    ///
    /// # Errors
    /// How much is missing, and what to do.
    pub fn check_memory_of_one(&self, threads: usize) -> Result<(), Fault> {
        MemoryEstimate::of_preview(&self.recipe, threads).check()
    }

    /// Renders sample `index`: maps `[rows, cols]` in mm (or px) and DN, labels, truth, objects and numbers.
    ///
    /// # Errors
    /// Where `stop` asks to, after the profiles that are being rendered: a band of 32 at most.
    pub fn sample(&self, index: u64, stop: &Stop) -> Result<Record, Stopped> {
        // Nothing between the profiles and here looks at results: a panic of our own, which no hook tells of, is the
        // way out.
        let progress = |_: u64| {
            if stop.is_asked() {
                resume_unwind(Box::new(Stopped));
            }
        };
        let render = || pipeline::render(&self.recipe.draw(self.seed, index), equipment(&self.patterns), &progress);
        catch_unwind(AssertUnwindSafe(render)).or_else(|panic| match panic.downcast::<Stopped>() {
            Ok(stopped) => Err(*stopped),
            Err(panic) => resume_unwind(panic),
        })
    }

    /// The numbers of a sample of this simulator as a row of a dataset has them, images left out: every other column by
    /// name, null where a number is missing.
    ///
    /// # Errors
    /// What differs, where the sample is not one of this recipe.
    pub fn numbers(&self, sample: &Record) -> Result<Map<String, Value>, String> {
        let head = self.head();
        let mut schema = row_schema(head);
        schema.fields = schema.fields.iter().filter(|field| !head.images.png.contains(field.name())).cloned().collect();
        let encoded = dataset::encode_numbers(sample, self.recipe.output().bits);
        let row = dataset::row_batch(&Arc::new(schema), head, &encoded)?;
        Ok(RowBatch::of(row).json(0)?.values)
    }

    /// A sample of this simulator as the row that a dataset has of it, images and all.
    ///
    /// # Errors
    /// What differs, where the sample is not one of this recipe.
    pub fn row(&self, sample: Record) -> Result<RowBatch, String> {
        let output = optical_bench::settings::Output { exr: Vec::new(), truth_maps: false, ..self.recipe.output() };
        let encoded = dataset::encode(sample, &output);
        let head = self.head();
        dataset::row_batch(&Arc::new(row_schema(head)), head, &encoded).map(RowBatch::of)
    }

    /// The head of a dataset of these samples; how many it has plays no part in a row.
    pub fn head(&self) -> &DatasetHead {
        self.head.get_or_init(|| {
            let request = DatasetRequest {
                samples: 1,
                seed: self.seed,
                out: Default::default(),
                part: (0, 1),
                samples_per_shard: Some(1),
            };
            dataset_head(&self.recipe, &request, Vec::new())
        })
    }
}

/// A dataset that was written, with the manifests of its finished shards.
#[derive(Debug)]
pub struct StoredDataset {
    dataset: Dataset,
    manifests: BTreeMap<u64, Manifest>,
}

/// A sample of a dataset that was written; maps in its EXR file are read when they are asked for.
#[derive(Debug)]
pub struct StoredSample {
    dataset: Arc<StoredDataset>,
    shard: u64,
    listed: ManifestSample,
    row: RowBatch,
    exr: OnceLock<Result<ExrMaps, Fault>>,
}

impl StoredDataset {
    /// Reads `dataset.json` and the manifests that are there.
    ///
    /// # Errors
    /// Where it is no dataset, one that this program does not read, or a manifest is damaged.
    pub fn open(root: &Path) -> Result<Self, Fault> {
        let dataset = Dataset::open(root)?;
        let mut manifests = BTreeMap::new();
        for shard in 0..dataset.head().shards {
            if let Some(manifest) = dataset.manifest(shard)? {
                manifests.insert(shard, manifest);
            }
        }
        Ok(Self { dataset, manifests })
    }

    /// The dataset.
    pub fn dataset(&self) -> &Dataset {
        &self.dataset
    }

    /// Every sample of a finished shard, by index.
    pub fn samples(&self) -> impl Iterator<Item = &ManifestSample> {
        self.manifests.values().flat_map(|manifest| &manifest.samples)
    }

    /// Every file that a sample is read from, as the manifest of its shard lists it.
    ///
    /// # Errors
    /// As [`StoredDataset::sample`], or where the manifest does not list one.
    pub fn files(&self, index: u64) -> Result<Vec<&ManifestFile>, Fault> {
        let (shard, listed) = self.listed(index)?;
        let images = &self.dataset.head().images;
        let mut paths = vec![data_path(&listed.split, shard)];
        paths.extend(self.dataset.head().has_exr().then(|| exr_path(shard, &listed.id)));
        paths.extend(images.stack_every.map(|_| stack_path(shard)));
        let files = &self.manifests[&shard].files;
        let entry = |path: String| {
            files.iter().find(|file| file.path == path).ok_or_else(|| {
                let manifest = self.dataset.root().join(manifest_path(shard));
                Fault::damaged(&manifest, format!("it does not list {path}, the file of sample {index}"))
            })
        };
        paths.into_iter().map(entry).collect()
    }

    /// Reads the row of sample `index`.
    ///
    /// # Errors
    /// Where no finished shard has it, or the table is missing or damaged.
    pub fn sample(self: &Arc<Self>, index: u64) -> Result<StoredSample, Fault> {
        let (shard, listed) = self.listed(index)?;
        let row = self.dataset.row(&self.manifests[&shard], listed, &|_| true)?;
        Ok(StoredSample { dataset: self.clone(), shard, listed: listed.clone(), row, exr: OnceLock::new() })
    }

    fn listed(&self, index: u64) -> Result<(u64, &ManifestSample), Fault> {
        let shard = self.dataset.shard_of(index);
        let manifest = self.manifests.get(&shard);
        let listed = manifest.and_then(|manifest| manifest.samples.iter().find(|sample| sample.index == index));
        let missing = || {
            let (root, samples) = (self.dataset.root(), self.dataset.head().samples);
            if index >= samples {
                let remedy = "ask for a smaller index, or extend it: gen --n";
                return Fault::at(root, format!("it has no sample {index}, it has {samples}"), remedy);
            }
            Fault::at(root, format!("shard {shard} with sample {index} is not finished"), "run gen again to finish it")
        };
        listed.map(|listed| (shard, listed)).ok_or_else(missing)
    }
}

impl StoredSample {
    /// The row, with all columns.
    pub fn row(&self) -> &RowBatch {
        &self.row
    }

    /// What `dataset.json` says about the images.
    pub fn images(&self) -> &Images {
        &self.dataset.dataset.head().images
    }

    /// Names of the channels that its EXR file has; none where there is no file.
    pub fn channels(&self) -> Vec<&'static str> {
        self.dataset.dataset.head().channels().into_iter().map(|channel| channel.name).collect()
    }

    /// Range [mm or px] `[rows, cols]`, NaN where missing: to the last bit where the EXR file has it or what the image
    /// lacks, else by the image; `None` where neither has it.
    ///
    /// # Errors
    /// Where it is damaged.
    pub fn range(&self) -> Result<Option<Vec<f32>>, Fault> {
        if let Some(range) = self.channel("Range")? {
            return Ok(Some(range));
        }
        let Some(image) = self.image("range")? else { return Ok(None) };
        let ([offset, scale], cols) = (self.range_scale()?, self.images().cols as usize);
        let Some(rest) = self.channel("RangeRest")? else {
            return Ok(Some(range_values(&image.numbers(), offset, scale)));
        };
        let joined = range_joined(&image.numbers(), &rest, cols, offset, scale);
        joined.map(Some).map_err(|what| self.row.damaged(what))
    }

    /// What the number 0 of the image `range` means, and what a step of it is [mm or px].
    fn range_scale(&self) -> Result<[f64; 2], Fault> {
        let unit = self.dataset.dataset.head().range_unit();
        let number = |what: &str| {
            let column = format!("range_{what}_{unit}");
            let found = self.row.numbers(&column).map_err(|what| self.row.damaged(what))?;
            found.first().copied().ok_or_else(|| self.row.damaged(format!("`{column}` is empty")))
        };
        Ok([number("offset")?, number("scale")?])
    }

    /// Every column but images by name, null where a number is missing.
    ///
    /// # Errors
    /// Where a value is of a type that no dataset holds.
    pub fn numbers(&self) -> Result<Map<String, Value>, Fault> {
        self.row.json(0).map(|row| row.values).map_err(|what| self.row.damaged(what))
    }

    /// An image of the row: whole numbers `[rows, cols]` as `output_schema` declares them; `None` where tables hold
    /// none of that name.
    ///
    /// # Errors
    /// Where it is damaged.
    pub fn image(&self, name: &str) -> Result<Option<Grey>, Fault> {
        let images = self.images();
        if !images.png.iter().any(|known| known == name) {
            return Ok(None);
        }
        let image = self.row.image(0, name, images).map_err(|what| self.row.damaged(what))?;
        Ok(Some(image.grey))
    }

    /// A channel of the EXR file `[rows, cols]`, by its name in files; `None` where there is no file, or it has no such
    /// channel.
    ///
    /// # Errors
    /// Where the file is missing or damaged.
    pub fn channel(&self, name: &str) -> Result<Option<Vec<f32>>, Fault> {
        if !self.channels().contains(&name) {
            return Ok(None);
        }
        let maps = self.exr.get_or_init(|| self.dataset.dataset.exr(self.shard, &self.listed.id));
        let maps = maps.as_ref().map_err(Clone::clone)?;
        Ok(maps.channel(name).map(|channel| channel.numbers.clone()))
    }

    /// Its sensor frames, by profile; none where the dataset keeps none.
    ///
    /// # Errors
    /// Where they are not where they should be, or cannot be read.
    pub fn frames(&self) -> Result<Vec<StackFrame>, Fault> {
        if self.images().stack_every.is_none() {
            return Ok(Vec::new());
        }
        self.dataset.dataset.sensor_frames(&self.dataset.manifests[&self.shard], self.listed.index, usize::MAX)
    }
}
