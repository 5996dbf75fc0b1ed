//! `gen check`: what a model makes of a dataset.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, ValueEnum};

use super::generate::threads;
use super::progress::{Things, counted, duration, say};
use super::{Outcome, Usage, print, whole};
use crate::check::{Options, Report, check};
use crate::record::Split;
use crate::shard::{DatasetFolder, Sums};

/// Name of the document in the folder of pictures.
const DOCUMENT: &str = "check.json";
/// Exit status where the accuracy is below what was asked for.
const BELOW: u8 = 3;

#[derive(Debug, Args)]
#[command(after_help = "Examples:
  gen check planks --model knots.onnx                          the split test, knots.yaml beside the model
  gen check planks --model knots.onnx --split all --json       everything, for programs
  gen check planks --model knots.onnx --out wrong              pictures of the worst answers, and check.json
  gen check planks --model knots.onnx --save                   kept in planks/reports, where gen report finds it
  gen check planks --model knots.onnx --slice film.n --slice physics.speckle_contrast
  gen check planks --model knots.onnx --min-accuracy 0.95      exit status 3 where it is below

The sidecar says what the model takes and answers; docs/check.md explains its keys:
  task: classify_pixels                 # classify_samples, classify_objects, classify_pixels, segment
  channels: [{name: scatter, mean: 900, sd: 400}]
  window_px: [32, 32]
  classes: [clear, {name: knot, of: [sound_knot, dead_knot]}, rot]

onnxruntime is found when this runs: ORT_DYLIB_PATH, a Python environment with the package
onnxruntime (.venv here or above), or the system.

Exit status: 0 done, 1 it cannot be done, 2 unusable arguments, 3 below --min-accuracy.")]
pub(super) struct Check {
    /// Folder of the dataset
    dir: PathBuf,
    /// The model (ONNX)
    #[arg(long, value_name = "FILE")]
    model: PathBuf,
    /// What the model takes and answers (YAML) [default: the model's name with .yaml]
    #[arg(long, value_name = "FILE")]
    sidecar: Option<PathBuf>,
    /// Part of the dataset
    #[arg(long, value_enum, default_value_t = Part::Test)]
    split: Part,
    /// Accuracy by this number too; may be given several times [default: knot width, film pigment, exposure]
    #[arg(long, value_name = "COLUMN")]
    slice: Vec<String>,
    /// Windows that the model gets at once [default: up to 64]
    #[arg(long, value_name = "B", value_parser = clap::value_parser!(u64).range(1..=65536))]
    batch: Option<u64>,
    /// Threads [default: all cores]
    #[arg(long, value_name = "T")]
    threads: Option<usize>,
    /// Seed of the pixels that are drawn
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// How many of the most confidently wrong answers are kept
    #[arg(long, value_name = "K", default_value_t = 16, value_parser = clap::value_parser!(u64).range(0..=1000))]
    worst: u64,
    /// Folder for pictures of them and for the report as check.json; made where it is not there
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Keep the report beside the dataset, as DIR/reports/check-MODEL.json with its pictures, for `gen report`
    #[arg(long)]
    save: bool,
    /// Print the report as JSON
    #[arg(long)]
    json: bool,
    /// End with status 3 where the accuracy is below this
    #[arg(long, value_name = "SHARE", value_parser = share)]
    min_accuracy: Option<f64>,
}

/// Part of a dataset, or all of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Part {
    Train,
    Validation,
    Test,
    All,
}

impl Part {
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

pub(super) fn run(arguments: &Check) -> Outcome {
    let threads = match threads(arguments.threads)? {
        0 => std::thread::available_parallelism().map_or(1, usize::from),
        threads => threads,
    };
    if let Some(out) = &arguments.out {
        prepare(out)?;
    }
    let options = Options {
        dir: arguments.dir.clone(),
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
    // A folder that is no dataset is told by the check itself.
    let sums = || DatasetFolder::open(&arguments.dir).ok().map(|folder| Sums::of(&arguments.dir, folder.head().shards));
    let before = if arguments.save { sums() } else { None };
    let bar = Things::new("windows");
    let report = check(&options, &|done, all| bar.show(done, all));
    bar.end();
    let report = report?;
    if report.unfinished > 0 {
        say(&format!("{} of the dataset are not finished and left out", counted(report.unfinished, "shard")));
    }
    let mut pictures = Vec::new();
    if let Some(out) = &arguments.out {
        pictures = draw(out, "", &report)?;
        whole::write(&out.join(DOCUMENT), format!("{:#}\n", report.json(&pictures)).as_bytes())?;
    }
    print(&if arguments.json { format!("{:#}\n", report.json(&pictures)) } else { report.table() });
    if bar.is_seen() {
        let time = std::time::Duration::from_secs_f64(report.timing.seconds);
        say(&format!("{} in {}", counted(bar.done(), "window"), duration(time)));
    }
    if let Some(before) = before {
        if sums().as_ref() != Some(&before) {
            let dir = arguments.dir.display();
            return Err(format!("{dir} changed while it was read, the report is not kept; check again").into());
        }
        let kept = save(&arguments.dir, &arguments.model, &report, &before)?;
        say(&format!("kept as {}", kept.display()));
    }
    match arguments.min_accuracy {
        Some(least) if report.accuracy() < least => {
            say(&format!("gen: accuracy {:.4} is below --min-accuracy {least}", report.accuracy()));
            Ok(ExitCode::from(BELOW))
        }
        _ => Ok(ExitCode::SUCCESS),
    }
}

/// Makes the folder, or takes an earlier one; what else lies there is nobody's to overwrite.
fn prepare(out: &Path) -> Result<(), Usage> {
    let told = |what: String| Usage(format!("--out {}: {what}; give a new folder", out.display()));
    if !out.exists() {
        return fs::create_dir(out).map_err(|e| told(format!("it cannot be made: {e}")));
    }
    let mut entries = fs::read_dir(out).map_err(|e| told(e.to_string()))?.peekable();
    if entries.peek().is_some() && !out.join(DOCUMENT).is_file() {
        return Err(told("it holds other things".into()));
    }
    for path in entries.flatten().map(|entry| entry.path()) {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if name.starts_with("wrong-") && name.ends_with(".png") {
            fs::remove_file(&path).map_err(|e| told(format!("{} cannot be removed: {e}", path.display())))?;
        }
    }
    Ok(())
}

/// Keeps the report in the dataset's folder, with what it was made from; pictures of an earlier one go.
fn save(
    dir: &Path,
    model: &Path,
    report: &Report,
    sums: &Sums,
) -> Result<PathBuf, Box<dyn std::error::Error + Send + Sync>> {
    let reports = dir.join("reports");
    let told = |e: std::io::Error| format!("--save: {}: {e}; make the folder writable", reports.display());
    fs::create_dir_all(&reports).map_err(told)?;
    let stem = model.file_stem().unwrap_or_default().to_string_lossy();
    let plain = |c: char| if c.is_ascii_alphanumeric() || "._-".contains(c) { c } else { '_' };
    let name: String = format!("check-{stem}").chars().map(plain).collect();
    for path in fs::read_dir(&reports).map_err(told)?.flatten().map(|entry| entry.path()) {
        let file = path.file_name().unwrap_or_default().to_string_lossy();
        if file.starts_with(&format!("{name}-wrong-")) && file.ends_with(".png") {
            fs::remove_file(&path).map_err(told)?;
        }
    }
    let pictures = draw(&reports, &format!("{name}-"), report)?;
    let mut document = report.json(&pictures);
    document["dataset_sha256"] = sums.dataset.as_str().into();
    document["manifests_sha256"] = sums.manifests.as_str().into();
    let path = reports.join(format!("{name}.json"));
    whole::write_or(&path, format!("{document:#}\n").as_bytes(), "make room there, or check without --save")?;
    Ok(path)
}

/// Writes the pictures of the worst answers; gives their names.
fn draw(out: &Path, before: &str, report: &Report) -> Result<Vec<String>, Box<dyn std::error::Error + Send + Sync>> {
    let mut names = Vec::new();
    for (i, wrong) in report.worst.iter().enumerate() {
        let Some(picture) = &wrong.picture else { continue };
        let name = format!("{before}wrong-{:03}-sample-{}.png", i + 1, wrong.index);
        let mut bytes = std::io::Cursor::new(Vec::new());
        picture.write_to(&mut bytes, image::ImageFormat::Png)?;
        whole::write(&out.join(&name), &bytes.into_inner())?;
        names.push(name);
    }
    Ok(names)
}
