//! `gen validate`: whether a dataset is what its recipe makes.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Args;
use serde_json::{Value, json};

use super::console::{Console, say};
use super::generate::{threads, warn};
use super::output::ResultFolder;
use super::progress::{ValidationProgress, counted};
use super::{CommandResult, print, whole};
use crate::generate::ExpectedDataset;
use dataset::validate::{DeclaredLaws, Derive, Expect, ValidationOptions, ValidationReport, validate};
use dataset::{Dataset, DatasetSums};

/// Name of the report that `--save` keeps.
const REPORT_FILE: &str = "validation.json";

#[derive(Debug, Args)]
#[command(after_help = "Examples:
  gen validate planks                          every file, number, image and label; one sample rendered again
  gen validate planks --rerender 0             nothing rendered
  gen validate planks --rerender 20            20 samples rendered again and compared byte for byte
  gen validate planks --json | jq .fault_counts
  gen validate planks --save                   keeps the report as planks/reports/validation.json

docs/validate.md explains every check and fault.

Exit status: 0 nothing is wrong, 1 there are faults, 2 unusable arguments.")]
pub(super) struct ValidateArgs {
    /// Folder of the dataset
    dir: PathBuf,
    /// How many samples to render again and compare byte for byte
    #[arg(long, value_name = "K", default_value_t = 1, value_parser = whole::<u64>)]
    rerender: u64,
    /// Which samples these are follows from this number and the dataset
    #[arg(long, value_name = "S", default_value_t = 0, value_parser = whole::<u64>)]
    rerender_seed: u64,
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
    let expected_dataset =
        folder.as_ref().map(ExpectedDataset::of).unwrap_or(Err("there is no readable dataset.json".into()));
    if let Ok(expected_dataset) = &expected_dataset
        && arguments.rerender > 0
    {
        warn(expected_dataset.recipe(), console);
    }
    let expected_dataset = expected_dataset.as_ref().map_err(String::as_str);
    let declared: Option<DeclaredLaws> = expected_dataset.ok().map(ExpectedDataset::declared);
    let expect = expected_dataset.ok().map(|expected_dataset| |index: u64| expected_dataset.expected(index));
    let derive = expected_dataset.ok().map(|expected_dataset| |index: u64| expected_dataset.unlit(index));
    let rerender =
        |index: u64| expected_dataset.map(|expected_dataset| expected_dataset.sample(index)).map_err(String::from);
    console.on_stop(|| "nothing is written, and the dataset is as it was".into());
    let progress = ValidationProgress::new(console, folder.as_ref().map_or(0, |folder| folder.head().samples));
    let options = ValidationOptions {
        expect_head: Some(expected_dataset.map(ExpectedDataset::head)),
        expect: expect.as_ref().map(|expect| expect as Expect),
        derive: derive.as_ref().map(|derive| derive as Derive),
        declared: declared.as_ref(),
        rerender: Some(&rerender),
        rerender_samples: arguments.rerender,
        rerender_seed: arguments.rerender_seed,
        progress: Some(&|step| progress.show(step)),
    };
    let report = pool.install(|| validate(&arguments.dir, &options));
    drop(progress);
    let printed = print(&if arguments.json { format!("{:#}\n", report.json()) } else { format!("{report}\n") });
    if let (Some(before), Some(dataset)) = (sums, &folder) {
        if dataset.sums() != before {
            let dir = arguments.dir.display();
            return Err(format!("{dir} changed while it was read, the report is not kept; validate it again").into());
        }
        save(&arguments.dir, &before, &report)?;
    }
    printed?;
    if report.is_clean() {
        return Ok(ExitCode::SUCCESS);
    }
    say(&format!("gen: {} has {}", arguments.dir.display(), counted(report.faults.len() as u64, "fault")));
    Ok(ExitCode::FAILURE)
}

/// Keeps the report with the sums of the documents that it is about.
fn save(dir: &Path, sums: &DatasetSums, report: &ValidationReport) -> Result<(), String> {
    let mut document = json!({ "format": "sheetlight-validation", "dataset_sha256": sums.dataset, "manifests_sha256": sums.manifests });
    if let (Some(document), Value::Object(report)) = (document.as_object_mut(), report.json()) {
        document.extend(report);
    }
    let (folder, remedy) = (ResultFolder::Kept(dir), "make room there, or validate without --save");
    folder.make(remedy)?;
    folder.write(REPORT_FILE, format!("{document:#}\n").as_bytes(), remedy)
}
