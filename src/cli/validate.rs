//! `gen validate`: whether a dataset is what its recipe makes.

use std::hash::{BuildHasher, Hasher, RandomState};
use std::path::{Path, PathBuf};

use clap::Args;
use serde_json::{Value, json};

use super::console::{Console, say};
use super::generate::{threads, warn};
use super::output::ResultFolder;
use super::progress::{ValidationProgress, counted};
use super::{CommandResult, DONE, FAULTS, print, whole};
use crate::generate::ExpectedDataset;
use dataset::record::AskedRows;
use dataset::validate::{Derive, Expect, TakeFrame, ValidationOptions, ValidationReport, validate};
use dataset::{Dataset, DatasetSums};

/// Name of the report that `--save` keeps.
const REPORT_FILE: &str = "validation.json";

#[derive(Debug, Args)]
#[command(after_help = "Examples:
  gen validate planks                          everything; some rows of each sample and one sample rendered again
  gen validate planks --rerender 0 --rows 0    nothing rendered
  gen validate planks --rows 10                ten places in each sample exposed again and compared bit for bit
  gen validate planks --rerender 20            20 samples rendered again and compared byte for byte
  gen validate planks --json | jq .fault_counts
  gen validate planks --save                   keeps the report as planks/reports/validation.json

Chances: of a sample of which the share s of the rows is forged, its sums mended, K places (--rows K) see it with
1 - (1 - s)^K or more, and of N samples that are forged alike they see one with 1 - (1 - s)^(K N): a map that is forged
as a whole always, 1 % of the rows of one sample with 1 % by one place and 10 % by ten, of 300 samples with 95 % by one.
Of n sensor frames that are kept, K see a single forged one with K / n; without --rows all are exposed, and see it \
surely.
A sample that is rendered again (--rerender) is compared as a whole.

docs/guide/validate.md explains every check and fault.

Exit status: 0 nothing is wrong, 1 there are faults (with --strict: or warnings), 2 unusable arguments.")]
pub(super) struct ValidateArgs {
    /// Folder of the dataset
    dir: PathBuf,
    /// How many samples to render again and compare byte for byte
    #[arg(long, value_name = "K", default_value_t = 1, value_parser = whole::<u64>)]
    rerender: u64,
    /// Which samples these are follows from this number and the dataset
    #[arg(long, value_name = "S", default_value_t = 0, value_parser = whole::<u64>)]
    rerender_seed: u64,
    /// Take warnings (samples of little use, and what to look at) as faults: exit status 1
    #[arg(long)]
    strict: bool,
    /// Places in each sample at which rows are exposed again and compared bit for bit, a row and up to 7 neighbours at
    /// each; and how many of its sensor frames, where these are kept [default: one place for each 1000 rows, all
    /// frames]
    #[arg(long, value_name = "K", value_parser = whole::<u64>)]
    rows: Option<u64>,
    /// Which rows these are follows from this number and the dataset; the report tells it [default: another one each
    /// time]
    #[arg(long, value_name = "S", value_parser = whole::<u64>)]
    rows_seed: Option<u64>,
    /// Threads [default: all cores]
    #[arg(short = 'j', long, value_name = "T", value_parser = whole::<usize>)]
    threads: Option<usize>,
    /// Print the report as JSON
    #[arg(long)]
    json: bool,
    /// Keep the report as reports/validation.json in the dataset's folder
    #[arg(long)]
    save: bool,
}

pub(super) fn run(arguments: &ValidateArgs, console: &Console) -> CommandResult {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads(arguments.threads)?).build()?;
    let folder = Dataset::open(&arguments.dir).ok();
    let sums = folder.as_ref().filter(|_| arguments.save).map(Dataset::sums);
    if arguments.save && sums.is_none() {
        let dir = arguments.dir.display();
        return Err(format!("--save: {dir} holds no readable dataset.json; validate without --save to see why").into());
    }
    // Where dataset.json cannot be read, validation says so itself.
    let expected_dataset = pool.install(|| folder.as_ref().map(ExpectedDataset::of));
    let expected_dataset = expected_dataset.unwrap_or(Err("there is no readable dataset.json".into()));
    if let Ok(expected_dataset) = &expected_dataset
        && arguments.rerender > 0
    {
        warn(expected_dataset.recipe(), console);
    }
    let expected_dataset = expected_dataset.as_ref().map_err(String::as_str);
    let expect = expected_dataset.ok().map(|expected_dataset| |index: u64| expected_dataset.expected(index));
    let derive = expected_dataset.ok().map(|expected_dataset| {
        |index, asked: &AskedRows, take: TakeFrame| expected_dataset.derived(index, asked, take)
    });
    let seed = arguments.rows_seed.unwrap_or_else(unforeseen);
    let rows = expected_dataset.ok().map(|expected_dataset| expected_dataset.rows(arguments.rows, seed));
    if rows == Some(None) {
        console.note(
            "no rows are exposed again: by this model of transport each takes too long; ask for them with --rows",
        );
    }
    let rerender =
        |index: u64| expected_dataset.map(|expected_dataset| expected_dataset.sample(index)).map_err(String::from);
    console.on_stop(|| "nothing is written, and the dataset is as it was".into());
    let progress = ValidationProgress::new(console, folder.as_ref().map_or(0, |folder| folder.head().samples));
    let options = ValidationOptions {
        expect_head: Some(expected_dataset.map(ExpectedDataset::head)),
        expect: expect.as_ref().map(|expect| expect as Expect),
        derive: derive.as_ref().map(|derive| derive as Derive),
        rows: rows.flatten(),
        rerender: Some(&rerender),
        rerender_samples: arguments.rerender,
        rerender_seed: arguments.rerender_seed,
        progress: Some(&|step| progress.show(step)),
    };
    let report = pool.install(|| validate(&arguments.dir, &options));
    drop(progress);
    let keep = || {
        let (Some(before), Some(dataset)) = (sums, &folder) else { return Ok(()) };
        if dataset.sums() != before {
            let dir = arguments.dir.display();
            return Err(format!("{dir} changed while it was read, the report is not kept; validate it again"));
        }
        save(&arguments.dir, &before, &report)
    };
    let kept = keep();
    match arguments.json {
        // A program takes a document for done.
        true if kept.is_err() => {}
        true => print(&format!("{:#}\n", report.json()))?,
        false => print(&format!("{report}\n"))?,
    }
    kept?;
    let warnings = if arguments.strict { report.warnings.len() as u64 } else { 0 };
    if report.is_clean() && warnings == 0 {
        return Ok(DONE);
    }
    let mut found = counted(report.faults.len() as u64, "fault");
    if warnings > 0 {
        found = format!("{found} and {}", counted(warnings, "warning"));
    }
    say(&format!("gen: {} has {found}", arguments.dir.display()));
    Ok(FAULTS)
}

/// A number that nobody knows before: who forges a dataset must not know which rows will be exposed again.
fn unforeseen() -> u64 {
    // The standard library takes the keys of its hash maps from the system's source of chance. Short, to be typed
    // again.
    RandomState::new().build_hasher().finish() >> 32
}

/// Keeps the report with the sums of the documents that it is about.
fn save(dir: &Path, sums: &DatasetSums, report: &ValidationReport) -> Result<(), String> {
    let mut document = json!({ "format": "sheetlight-validation", "dataset_sha256": sums.dataset,
        "manifests_sha256": sums.manifests });
    if let (Some(document), Value::Object(report)) = (document.as_object_mut(), report.json()) {
        document.extend(report);
    }
    let (folder, remedy) = (ResultFolder::Kept(dir), "make room there, or validate without --save");
    folder.make(remedy)?;
    folder.write(REPORT_FILE, format!("{document:#}\n").as_bytes(), remedy)
}
