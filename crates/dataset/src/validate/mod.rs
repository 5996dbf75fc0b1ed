//! Validation: reads a dataset folder, believes nothing, and names each fault with its place and what to do.
//!
//! ```text
//! dataset.json -> each shard: manifest -> files -> rows -> images, EXR, labels -> (exposed or rendered again) ->
//! Report
//! ```
//!
//! A damaged file gives a fault, never a panic. Only files whose checksum is right are decoded. Of the samples as many
//! are in memory as there are threads; what stays of each is its print (see `duplicates`) and the digest of its id.

mod columns;
mod decoded_images;
mod expected;
mod frame_digest;
mod job_result;
mod jobs;
mod report;
mod row_choice;
mod rules;
mod sample;
mod sample_to_check;
mod shard;
mod shard_task;
mod stored_frames;
mod whole_range;

use std::collections::{BTreeSet, HashSet};
use std::path::Path;

use output_schema::file::{CARD, CROISSANT, DATASET, REPORTS, data_path, exr_folder, manifest_path, stack_path};
use output_schema::{DatasetHead, SCHEMA_VERSION};
use rayon::prelude::*;
use sha2::{Digest, Sha256};

pub use expected::{Derive, Expect, ExpectedRow, TakeFrame};
pub use report::ValidationReport;
pub use row_choice::RowChoice;
pub use rules::{Code, Finding, fault_table};

use self::job_result::JobResult;
use self::rules::{card_differs, dataset_differs, dataset_json, files};
use self::shard_task::ShardTask;
use crate::Encoded;
use optical_bench::split::Split;

/// Renders one sample again: its index -> what should be on disk, or why it cannot be rendered.
pub(crate) type Rerender<'a> = &'a (dyn Fn(u64) -> Result<Encoded, String> + Sync);

/// A step that was done, for whoever shows it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ValidationStep {
    /// Rows that it read.
    pub samples: u64,
    /// Size of the files that it read [bytes].
    pub bytes: u64,
}

/// What to do beyond reading.
#[derive(Clone, Copy, Default)]
pub struct ValidationOptions<'a> {
    /// What this program makes of the dataset's recipe, or why it cannot be loaded; `None` to compare nothing.
    pub expect_head: Option<Result<&'a DatasetHead, &'a str>>,
    /// How a sample is drawn again, without rendering; `None` to compare nothing.
    pub expect: Option<Expect<'a>>,
    /// What else of a sample follows without rendering; `None` to compare nothing.
    pub derive: Option<Derive<'a>>,
    /// Which rows of each sample are exposed again by `derive`; `None` to expose nothing.
    pub rows: Option<RowChoice>,
    /// How a sample is rendered again; `None` to compare nothing.
    pub rerender: Option<Rerender<'a>>,
    /// How many samples are rendered again.
    pub rerender_samples: u64,
    /// Which samples these are follows from this number and the dataset.
    pub rerender_seed: u64,
    /// Told of every step.
    pub progress: Option<&'a (dyn Fn(ValidationStep) + Sync)>,
}

/// Checks everything in the folder.
pub fn validate(folder: &Path, options: &ValidationOptions) -> ValidationReport {
    let mut report = ValidationReport::default();
    let Some(mut head) = dataset_json::read(folder, &mut report) else { return report };
    let mut of_assets = ValidationReport::default();
    let assets = files::assets(folder, &head, &mut of_assets);
    let comparable = Comparable::check(folder, &mut head, options, of_assets.is_clean(), &mut report);
    let rerender = options.rerender.filter(|_| comparable.documents && options.rerender_samples > 0);
    let chosen =
        rerender.map_or_else(BTreeSet::new, |_| chosen(&head, options.rerender_samples, options.rerender_seed));
    let derive = options.derive.filter(|_| comparable.samples);
    let task = ShardTask {
        root: folder,
        head: &head,
        number: 0,
        expect: options.expect.filter(|_| comparable.samples),
        derive,
        rows: options.rows.filter(|rows| derive.is_some() && rows.places > 0),
        rerender,
        chosen: &chosen,
    };
    let mut found = shards(&task, options);
    report.add(of_assets);
    let strangers = strangers(&task, &found, assets);
    found.tell(&mut report);
    report.faults.extend(found.other_frames(&task));
    report.rows_seed = task.rows.map(|rows| rows.seed);
    report.faults.extend(strangers);
    let codes = report.codes();
    let finished = !codes.contains(&Code::ManifestMissing);
    let believed =
        finished && ![Code::ManifestDiffers, Code::ManifestUnreadable].iter().any(|code| codes.contains(code));
    if comparable.documents {
        let counts = believed.then_some(&found.listed);
        card_differs::check(folder, &head, &found.present(), counts, finished, &mut report);
    }
    report.warnings.extend(found.alike());
    if head.schema_version != SCHEMA_VERSION {
        // What another version writes otherwise is no damage: nothing is to be removed for it.
        report.faults.iter_mut().for_each(|fault| fault.fault.remedy = Code::VersionDiffers.remedy().into());
    }
    report.chosen = chosen.into_iter().collect();
    report
}

/// What of a dataset can be compared with what this program makes.
struct Comparable {
    /// Its documents: it has this version's schema, and its head was not changed.
    documents: bool,
    /// Its samples too: their recipe is drawn again.
    samples: bool,
}

impl Comparable {
    fn check(
        folder: &Path,
        head: &mut DatasetHead,
        options: &ValidationOptions,
        has_assets: bool,
        report: &mut ValidationReport,
    ) -> Self {
        let same = head.schema_version == SCHEMA_VERSION;
        // Nothing that the head gives is compared where it is the head that was changed.
        let documents = same && !dataset_differs::check(folder, head, options.expect, report);
        // A recipe does not load without its files: that is told of the file alone.
        let expected = options.expect_head.filter(|expected| expected.is_ok() || has_assets);
        let loads = expected.is_some() || options.expect_head.is_none();
        let samples = documents && loads && expected.is_none_or(|expected| expected::head(head, expected, report));
        Self { documents, samples }
    }
}

/// Runs the jobs of all shards.
fn shards(task: &ShardTask, options: &ValidationOptions) -> JobResult {
    let jobs = (0..task.head.shards).flat_map(|number| jobs::of(ShardTask { number, ..*task }));
    let run = |(place, job): (u64, jobs::ValidationJob)| {
        let found = job.run();
        if let Some(progress) = options.progress {
            progress(ValidationStep { samples: found.report.samples, bytes: found.report.bytes });
        }
        found.at(place)
    };
    (0u64..).zip(jobs).par_bridge().map(run).reduce(JobResult::default, JobResult::and)
}

/// Files of the folder that nothing names.
fn strangers(task: &ShardTask, found: &JobResult, assets: Vec<String>) -> Vec<Finding> {
    let mut expected: HashSet<String> = [DATASET, CARD, CROISSANT].map(String::from).into();
    expected.extend(assets);
    expected.extend((0..task.head.shards).map(manifest_path));
    expected.extend(found.tables.iter().cloned());
    // A shard whose manifest could be read has looked into its folder itself.
    let own: HashSet<String> = found.opened.iter().chain(&found.hidden).map(|&shard| exr_folder(shard)).collect();
    // What a manifest that cannot be read may name is no stranger.
    let tables =
        |&shard: &u64| Split::ALL.map(|split| data_path(split.name(), shard)).into_iter().chain([stack_path(shard)]);
    expected.extend(found.hidden.iter().flat_map(tables));
    let is_skipped = |path: &str| own.contains(path) || path == REPORTS;
    files::unexpected(task.root, "", &|path| expected.contains(path), &is_skipped)
}

/// `count` indices of the dataset, from `seed` and what the dataset is.
fn chosen(head: &DatasetHead, count: u64, seed: u64) -> BTreeSet<u64> {
    let word = |place: u64| {
        let sum = Sha256::digest(format!("{}/{}/{}/{seed}/{place}", head.recipe.hash, head.seed, head.samples));
        sum.iter().take(8).fold(0, |word, byte| word << 8 | u64::from(*byte))
    };
    row_choice::subset(head.samples, count, word)
}
