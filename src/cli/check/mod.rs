//! `gen check`: accuracy of a trained model on a dataset, and what keys of a recipe cost it.

mod sweep;

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use serde_json::Value;

use self::sweep::SweepArgs;
use super::console::{Console, say};
use super::generate::threads;
use super::output::ResultFolder;
use super::progress::{Progress, counted, describe_duration};
use super::{CommandResult, DONE, UsageError, output, print, whole};
use dataset::{Dataset, DatasetSums};
use optical_bench::split::Split;
use output_schema::DatasetHead;
use recipe::SampleNeeds;
use tools::check::{CheckError, CheckOptions, CheckReport, SampleTest, check};

/// Name of the document in the folder of pictures.
const REPORT_FILE: &str = "check.json";
/// Remedy where nothing can be kept there.
const UNSAVED_REMEDY: &str = "make the folder writable, or check without --save";
/// Most bytes of a report that was kept before.
const MAX_KEPT_BYTES: u64 = 64 << 20;
/// Exit status where the accuracy is below what was asked for.
const EXIT_BELOW_ACCURACY: u8 = 3;

#[derive(Debug, Args)]
#[command(after_help = "Examples:
  gen check planks --model knots.onnx                          the split test, knots.yaml beside the model
  gen check planks --model knots.onnx --split all --json       everything, for programs
  gen check planks --model knots.onnx --out wrong              pictures of the worst answers, and check.json
  gen check planks --model knots.onnx --save                   kept as planks/reports/check-knots-test.json for gen \
  report
  gen check packs --model tablets.onnx --slice film.sigma_per_mm --slice physics.speckle_volume
  gen check planks --model knots.onnx --min-accuracy 0.95      exit status 3 where it is below
  gen check --model knots.onnx --recipe wood --sweep           which keys cost the model most; knots-sweep/sweep.json

The sidecar says what the model takes and answers; docs/guide/check.md explains its keys:
  task: classify_pixels                 # classify_samples, classify_objects, classify_pixels, segment
  channels: [{name: scatter, mean: 900, sd: 400}]
  window_px: [32, 32]
  classes: [clear, {name: knot, of: [sound_knot, dead_knot]}, rot]

onnxruntime is found when this runs: ORT_DYLIB_PATH, a Python environment with the package
onnxruntime (.venv here or above), or the system.

Exit status: 0 done, 1 it cannot be done, 2 unusable arguments, 3 below --min-accuracy.")]
pub(super) struct CheckArgs {
    /// Folder of the dataset
    #[arg(required_unless_present = "sweep")]
    dir: Option<PathBuf>,
    /// The model (ONNX)
    #[arg(long, value_name = "FILE")]
    model: PathBuf,
    /// What the model takes and answers (YAML or JSON), - for standard input [default: the model's name with .yaml,
    /// .yml or .json]
    #[arg(long, value_name = "FILE")]
    sidecar: Option<PathBuf>,
    /// Part of the dataset
    #[arg(long, value_enum, default_value_t = SplitChoice::Test)]
    split: SplitChoice,
    /// Accuracy by this number too; may be given several times [default: knot width, film pigment, exposure]
    #[arg(long, value_name = "COLUMN")]
    slice: Vec<String>,
    /// Windows that the model gets at once, 1 to 65536 [default: up to 64]
    #[arg(long, value_name = "B", value_parser = clap::value_parser!(u64).range(1..=65536))]
    batch: Option<u64>,
    /// Threads [default: all cores]
    #[arg(short = 'j', long, value_name = "T", value_parser = whole::<usize>)]
    threads: Option<usize>,
    /// Seed of the pixels that are drawn, and of the samples of a sweep
    #[arg(long, default_value_t = 0, value_parser = whole::<u64>)]
    seed: u64,
    /// How many of the most confidently wrong answers are kept, at most 1000
    #[arg(long, value_name = "K", default_value_t = 16, value_parser = clap::value_parser!(u64).range(0..=1000))]
    worst: u64,
    /// Folder for pictures of them and for the report as check.json; made where it is not there. Of a sweep the folder
    /// for sweep.json and for what it keeps while it runs [default: MODEL-sweep]
    #[arg(short, long, value_name = "DIR", value_parser = output::folder())]
    out: Option<PathBuf>,
    /// Keep the report beside the dataset, as DIR/reports/check-MODEL-SPLIT.json with its pictures, for `gen report`;
    /// that of the same model file and split is replaced, that of another file of the same name is numbered beside it
    #[arg(long)]
    save: bool,
    /// Print the report as JSON
    #[arg(long)]
    json: bool,
    /// End with status 3 where the accuracy is below this
    #[arg(long, value_name = "SHARE", value_parser = share)]
    min_accuracy: Option<f64>,
    #[command(flatten)]
    swept: SweepArgs,
}

/// Part of a dataset, or all of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum SplitChoice {
    Train,
    Validation,
    Test,
    All,
}

impl SplitChoice {
    /// The split; none for all.
    pub(super) fn split(self) -> Option<Split> {
        match self {
            Self::Train => Some(Split::Train),
            Self::Validation => Some(Split::Validation),
            Self::Test => Some(Split::Test),
            Self::All => None,
        }
    }
}

fn share(text: &str) -> Result<f64, String> {
    let share = text.parse::<f64>().ok().filter(|share| (0.0..=1.0).contains(share));
    share.ok_or_else(|| format!("'{text}' is no share from 0 to 1, for instance 0.95"))
}

/// The number of threads of model and reading.
fn threads_of(arguments: &CheckArgs) -> Result<usize, UsageError> {
    Ok(match threads(arguments.threads)? {
        0 => std::thread::available_parallelism().map_or(1, usize::from),
        threads => threads,
    })
}

/// A check that cannot be done, as a command says it.
fn refused(error: CheckError) -> Box<dyn Error + Send + Sync> {
    match error {
        CheckError::Argument(what) => UsageError(what).into(),
        other => other.into(),
    }
}

pub(super) fn run(arguments: &CheckArgs, console: &Console) -> CommandResult {
    match &arguments.dir {
        Some(dir) => check_dataset(dir, arguments, console),
        None => sweep::run(arguments, console),
    }
}

fn check_dataset(dir: &Path, arguments: &CheckArgs, console: &Console) -> CommandResult {
    let threads = threads_of(arguments)?;
    if let Some(out) = &arguments.out {
        prepare(out, &[REPORT_FILE])?;
    }
    let before = if arguments.save { sums_before(dir)? } else { None };
    let options = CheckOptions {
        dir: dir.to_path_buf(),
        model: arguments.model.clone(),
        sidecar: arguments.sidecar.clone(),
        split: arguments.split.split(),
        slices: arguments.slice.clone(),
        batch: arguments.batch.map(|batch| batch as usize),
        threads,
        seed: arguments.seed,
        worst: arguments.worst as usize,
        pictures: arguments.out.is_some() || arguments.save,
    };
    let progress = Progress::new(console, "windows", None);
    let report = check(&options, &sample_test, &|done, all| progress.set(done, all));
    let (windows, is_drawn) = (progress.done(), progress.is_drawn());
    drop(progress);
    let report = report.map_err(refused)?;
    if report.unfinished > 0 {
        console.note(&format!("{} of the dataset are not finished and left out", counted(report.unfinished, "shard")));
    }
    if let Some(what) =
        report.sidecar.trained_on.as_ref().and_then(|it| it.shared_draws(&report.head, arguments.split.split()))
    {
        console.note(&format!("note: {what}"));
    }
    let pictures = if arguments.out.is_some() { names("", &report) } else { Vec::new() };
    let document = report.json(&pictures);
    // Printed first, so that nothing is lost where a file cannot be written.
    let printed = print(&if arguments.json { format!("{document:#}\n") } else { report.table() });
    if is_drawn {
        let time = std::time::Duration::from_secs_f64(report.timing.seconds);
        console.note(&format!("{} in {}", counted(windows, "window"), describe_duration(time)));
    }
    let drawn = arguments
        .out
        .as_ref()
        .map_or(Ok(()), |out| write(ResultFolder::Named(out), REPORT_FILE, &document, "", &report, output::ELSEWHERE));
    let saved = before.map_or(Ok(()), |before| save(dir, &arguments.model, before, &report, console));
    let printed = printed.map_err(|error| error.to_string());
    let failed: Vec<String> = [printed, drawn, saved].into_iter().filter_map(Result::err).collect();
    match arguments.min_accuracy {
        Some(least) if report.accuracy() < least => {
            failed.iter().for_each(|what| say(&format!("gen: {what}")));
            say(&format!("gen: accuracy {:.4} is below --min-accuracy {least}", report.accuracy()));
            Ok(EXIT_BELOW_ACCURACY)
        }
        _ if !failed.is_empty() => Err(failed.join("; ").into()),
        _ => Ok(DONE),
    }
}

/// What the number at `path` describes, as the dataset's recipe says.
fn sample_test(head: &DatasetHead, path: &str) -> Option<SampleTest> {
    let needs = SampleNeeds::new(&head.recipe.canonical, path)?;
    let deciders = needs.deciders().to_vec();
    Some(SampleTest { deciders, is_lacking: Box::new(move |values| needs.are_unmet(values)) })
}

/// Makes the folder of a document, the first of `documents`, or takes that of an earlier check, which has one of them;
/// refuses a folder that holds other things.
fn prepare(out: &Path, documents: &[&str]) -> Result<(), UsageError> {
    let describe = |what: String| UsageError(format!("--out {}: {what}; give a new folder", out.display()));
    let (is_there, document) = (out.exists(), out.join(documents[0]));
    if is_there {
        let mut entries = fs::read_dir(out).map_err(|e| describe(e.to_string()))?;
        if entries.next().is_some() && !documents.iter().any(|document| out.join(document).is_file()) {
            return Err(describe("it holds other things".into()));
        }
    }
    output::check_replaceable(&document, output::Written::Json)?;
    if !is_there {
        return fs::create_dir(out).map_err(|e| describe(format!("it cannot be made: {e}")));
    }
    output::check_writable(&document).map_err(UsageError)
}

/// Sums of the dataset before the work, and whether its folder can be written; `None` where it is no dataset, which the
/// check itself reports.
fn sums_before(dir: &Path) -> Result<Option<DatasetSums>, String> {
    let Some(sums) = sums(dir) else { return Ok(None) };
    ResultFolder::Kept(dir).check_writable(UNSAVED_REMEDY)?;
    Ok(Some(sums))
}

fn sums(dir: &Path) -> Option<DatasetSums> {
    Dataset::open(dir).ok().map(|folder| folder.sums())
}

/// Keeps the report in the dataset's folder, with the sums of what it was made from.
fn save(dir: &Path, model: &Path, before: DatasetSums, report: &CheckReport, console: &Console) -> Result<(), String> {
    let reports = ResultFolder::Kept(dir);
    reports.make(UNSAVED_REMEDY)?;
    let stem = model.file_stem().unwrap_or_default().to_string_lossy();
    let plain = |c: char| if c.is_ascii_alphanumeric() || "._-".contains(c) { c } else { '_' };
    let usual: String = format!("check-{stem}-{}", report.split()).chars().map(plain).collect();
    // The report of another model file of that name is kept.
    let is_other = |name: &String| {
        let text = reports.read(&format!("{name}.json"), MAX_KEPT_BYTES);
        let kept = text.map(|text| serde_json::from_slice::<Value>(&text).unwrap_or_default());
        kept.is_some_and(|kept| kept["model"]["sha256"] != *report.model_sha256)
    };
    let mut name = usual.clone();
    let mut number = 1_u64;
    while is_other(&name) {
        number += 1;
        name = format!("{usual}-{number}");
    }
    let before_names = format!("{name}-");
    let mut document = report.json(&names(&before_names, report));
    let changed = sums(dir).as_ref() != Some(&before);
    document["dataset_sha256"] = before.dataset.into();
    document["manifests_sha256"] = before.manifests.into();
    let file = format!("{name}.json");
    write(reports, &file, &document, &before_names, report, UNSAVED_REMEDY)?;
    console.note(&format!("kept as {}", reports.path(&file).display()));
    if number > 1 {
        console.note(&format!(
            "{} is of another model by that name, and stays",
            reports.path(&format!("{usual}.json")).display()
        ));
    }
    if changed {
        console.note("the dataset changed while it was checked: what is kept counts as stale; check it again");
    }
    Ok(())
}

/// Names of the pictures of the worst answers.
fn names(before: &str, report: &CheckReport) -> Vec<String> {
    let drawn = report.worst.iter().enumerate().filter(|(_, wrong)| wrong.picture.is_some());
    drawn.map(|(i, wrong)| format!("{before}wrong-{:03}-sample-{}.png", i + 1, wrong.index)).collect()
}

/// Writes the pictures of the worst answers, then the document that names them; those of an earlier one go at last.
fn write(
    folder: ResultFolder,
    file: &str,
    document: &Value,
    before: &str,
    report: &CheckReport,
    remedy: &str,
) -> Result<(), String> {
    let names = names(before, report);
    for (name, picture) in names.iter().zip(report.worst.iter().filter_map(|wrong| wrong.picture.as_ref())) {
        let bytes = output::png(picture).map_err(|e| format!("{name}: {e}; {remedy}"))?;
        folder.write(name, &bytes, remedy)?;
    }
    folder.write(file, format!("{document:#}\n").as_bytes(), remedy)?;
    let is_number = |text: &str| !text.is_empty() && text.bytes().all(|c| c.is_ascii_digit());
    let is_picture = |name: &str| {
        let rest = name.strip_prefix(before).and_then(|rest| rest.strip_prefix("wrong-")?.strip_suffix(".png"));
        rest.and_then(|rest| rest.split_once("-sample-")).is_some_and(|(a, b)| is_number(a) && is_number(b))
    };
    let describe = |e: std::io::Error| {
        format!("old pictures beside {} cannot be removed: {e}; {remedy}", folder.path(file).display())
    };
    for name in folder.names().map_err(describe)? {
        if is_picture(&name) && !names.contains(&name) {
            folder.remove(&name).map_err(describe)?;
        }
    }
    Ok(())
}
