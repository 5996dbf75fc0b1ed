//! `gen --recipe R --n N`: checks the order, says what it will take, and makes it.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use output_schema::{MOST_SAMPLES, MOST_SHARDS};

use super::progress::{Progress, bytes, counted, duration, say};
use super::{Generate, Outcome, Usage, print};
use crate::dataset::Dataset;
use crate::generate::{Estimate, Order, Summary, generate, head};
use crate::recipe::Recipe;
use crate::settings::Transport;

/// Most threads for each core, and on a machine of few cores; each takes room for a band of rows.
const MOST_THREADS: (usize, usize) = (4, 16);

pub(super) fn run(arguments: &Generate) -> Outcome {
    let Some(name) = &arguments.recipe else {
        return Err(Usage(
            "--recipe is missing: name a YAML file or a built-in recipe, for instance --recipe wood.yaml".into(),
        )
        .into());
    };
    let threads = threads(arguments.threads)?;
    let samples = samples(arguments)?;
    let recipe = super::load(name)?;
    let order = order(arguments, &recipe, samples)?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
    warn(&recipe);
    pool.install(|| {
        if arguments.estimate {
            say(&format!("rendering {} to measure ...", counted(Estimate::trial(&recipe, &order), "sample")));
            let estimate = Estimate::measure(&recipe, &order);
            print(&describe(&estimate, &order));
            return Ok(if estimate.fits() { ExitCode::SUCCESS } else { ExitCode::FAILURE });
        }
        let estimate = Estimate::count(&recipe, &order);
        if !estimate.fits() {
            return Err(refusal(&estimate, &order).into());
        }
        make(name, &recipe, &order)
    })
}

/// The number of threads to start, 0 for one a core.
pub(super) fn threads(asked: Option<usize>) -> Result<usize, Usage> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let most = (MOST_THREADS.0 * cores).max(MOST_THREADS.1);
    match asked {
        Some(0) => Err(Usage("--threads 0: use 1 or more, or leave it out for all cores".into())),
        Some(n) if n > most => Err(Usage(format!(
            "--threads {n}: at most {most} on this machine of {}; leave it out for one a core",
            counted(cores as u64, "core")
        ))),
        other => Ok(other.unwrap_or(0)),
    }
}

/// Says of a slow model of transport how much it does and what it is for.
pub(super) fn warn(recipe: &Recipe) {
    let work = match recipe.transport() {
        Transport::Kernel => return,
        Transport::Path { photons } => format!("walks {photons} photons"),
        Transport::Diffusion { voxel_mm } => format!("solves a volume of voxels of {voxel_mm} mm"),
        Transport::Thesis { method, pixel_mm, .. } => {
            format!("spreads a picture of pixels of {pixel_mm} mm by {}", method.name())
        }
    };
    say(&format!(
        "transport: {} {work} in each of {}. It is slow, for single profiles and comparisons; datasets are made with \
         `transport: kernel`",
        recipe.transport().name(),
        counted(recipe.size().profiles as u64, "profile"),
    ));
}

fn samples(arguments: &Generate) -> Result<u64, Usage> {
    let n = match arguments.n {
        None => Err("--n is missing: how many samples shall the dataset have? for instance --n 100".into()),
        Some(0) => Err("--n 0: a dataset has 1 sample or more".into()),
        Some(n) if n > MOST_SAMPLES => Err(format!("--n {n}: at most {MOST_SAMPLES} samples")),
        Some(n) => Ok(n),
    };
    if let Some(size @ (0 | 100_001..)) = arguments.samples_per_shard {
        return Err(Usage(format!("--samples-per-shard {size}: from 1 to 100000")));
    }
    n.map_err(Usage)
}

/// The dataset that the order continues: the folder that stands for its recipe, unless it is to go elsewhere.
fn continued(arguments: &Generate) -> Option<Dataset> {
    let root = arguments.recipe.as_deref().map(Path::new).filter(|root| root.is_dir())?;
    let place = |path: &Path| path.canonicalize().ok();
    let same = arguments.out.as_deref().is_none_or(|out| place(out).is_some() && place(out) == place(root));
    Dataset::open(root).ok().filter(|_| same)
}

fn order(arguments: &Generate, recipe: &Recipe, samples: u64) -> Result<Order, Usage> {
    let continued = continued(arguments);
    let begun = continued.as_ref();
    let out = || begun.map_or_else(|| PathBuf::from("out").join(recipe.name()), |begun| begun.root().to_path_buf());
    let order = Order {
        samples,
        seed: arguments.seed.or(begun.map(|begun| begun.head().seed)).unwrap_or(0),
        out: arguments.out.clone().unwrap_or_else(out),
        part: arguments.part,
        samples_per_shard: arguments.samples_per_shard.or(begun.map(|begun| begun.head().samples_per_shard)),
    };
    let shards = head(recipe, &order).shards;
    if shards > MOST_SHARDS {
        let remedy = "ask for more --samples-per-shard, or for fewer samples";
        return Err(Usage(format!("{samples} samples would be {shards} shards, at most {MOST_SHARDS}; {remedy}")));
    }
    Ok(order)
}

fn make(name: &str, recipe: &Recipe, order: &Order) -> Outcome {
    let progress = Progress::new(name, recipe, order);
    let summary = generate(recipe, order, &|event| progress.show(event));
    progress.end();
    say(&format!("{}: {}", order.out.display(), told(&summary?, order)));
    Ok(ExitCode::SUCCESS)
}

/// What a run did, in words.
fn told(summary: &Summary, order: &Order) -> String {
    let part = match order.part {
        (0, 1) => String::new(),
        (part, parts) => format!(
            ", part {part}/{parts}; when all parts lie in one folder, run the command once more there, without --part"
        ),
    };
    let dataset = format!("dataset of {}{part}", counted(summary.total, "sample"));
    let made = format!("{} in {} made", counted(summary.samples, "sample"), counted(summary.shards, "shard"));
    match summary.busy {
        0 if summary.shards == 0 => format!("nothing to do, all is there; {dataset}"),
        0 => format!("{made}; {dataset}"),
        n => format!("{made}, {} left to other processes that work on them; {dataset}", counted(n, "shard")),
    }
}

/// The estimate in words.
fn describe(estimate: &Estimate, order: &Order) -> String {
    let mut text = format!(
        "{} of {} samples to make in {}\n  time   {} at {:.2} s a sample with these threads, measured now\n  disk   {} at {} a sample, {}\n",
        estimate.samples,
        order.samples,
        order.out.display(),
        duration(estimate.time()),
        estimate.sample_time.as_secs_f64(),
        bytes(estimate.bytes()),
        bytes(estimate.sample_bytes),
        estimate.free.map_or("free space unknown".into(), |free| format!("{} free", bytes(free))),
    );
    for (class, count) in &estimate.classes {
        text.push_str(&format!("  class  {class}: {count}\n"));
    }
    if !estimate.fits() {
        text.push_str(&format!("{}\n", refusal(estimate, order)));
    }
    text
}

fn refusal(estimate: &Estimate, order: &Order) -> String {
    format!(
        "{} more need about {} but {} has {} free; make room, choose another --out, bin the images (output.bin), \
         leave channels out (output.exr: []), or ask for fewer samples",
        counted(estimate.samples, "sample"),
        bytes(estimate.bytes()),
        order.out.display(),
        bytes(estimate.free.unwrap_or(0)),
    )
}
