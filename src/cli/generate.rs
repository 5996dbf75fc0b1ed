//! `gen --recipe R --n N`: checks the order, says what it will take, and makes it.

use std::path::PathBuf;
use std::process::ExitCode;

use super::progress::{Progress, bytes, duration};
use super::{Generate, Outcome};
use crate::generate::{Estimate, Order, generate};
use crate::recipe::Recipe;

pub(super) fn run(arguments: &Generate) -> Outcome {
    let Some(name) = &arguments.recipe else {
        return Err(
            "--recipe is missing: name a YAML file or a built-in recipe, for instance --recipe wood.yaml".into()
        );
    };
    let recipe = Recipe::load(name)?;
    let order = order(arguments, &recipe)?;
    let threads = match arguments.threads {
        Some(0) => return Err("--threads 0: use 1 or more, or leave it out for all cores".into()),
        other => other.unwrap_or(0),
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
    pool.install(|| {
        if arguments.estimate {
            let estimate = Estimate::measure(&recipe, &order);
            print!("{}", describe(&estimate, &order));
            return Ok(if estimate.fits() { ExitCode::SUCCESS } else { ExitCode::FAILURE });
        }
        let estimate = Estimate::count(&recipe, &order);
        if !estimate.fits() {
            return Err(refusal(&estimate, &order).into());
        }
        make(&recipe, &order)
    })
}

fn order(arguments: &Generate, recipe: &Recipe) -> Result<Order, String> {
    let samples = match arguments.n {
        None => return Err("--n is missing: how many samples shall the dataset have? for instance --n 100".into()),
        Some(0) => return Err("--n 0: a dataset has 1 sample or more".into()),
        Some(n) if n > 1_000_000_000 => return Err(format!("--n {n}: at most 1000000000 samples")),
        Some(n) => n,
    };
    if let Some(size @ (0 | 100_001..)) = arguments.samples_per_shard {
        return Err(format!("--samples-per-shard {size}: from 1 to 100000"));
    }
    Ok(Order {
        samples,
        seed: arguments.seed,
        out: arguments.out.clone().unwrap_or_else(|| PathBuf::from("out").join(recipe.name())),
        part: arguments.part,
        samples_per_shard: arguments.samples_per_shard,
    })
}

fn make(recipe: &Recipe, order: &Order) -> Outcome {
    let progress = Progress::new(recipe, order);
    let summary = generate(recipe, order, &|event| progress.show(event));
    progress.end();
    let summary = summary?;
    let made = format!("{} samples in {} shards made now", summary.samples, summary.shards);
    let busy = match summary.busy {
        0 => String::new(),
        n => format!("; {n} shards are left to other processes that work on them"),
    };
    eprintln!("{}: {made}{busy}; dataset of {} samples", order.out.display(), summary.total);
    Ok(ExitCode::SUCCESS)
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
        "{} samples need about {} but {} has {} free; make room, choose another --out, bin the images (output.bin), \
         leave channels out (output.exr: []), or ask for fewer samples",
        estimate.samples,
        bytes(estimate.bytes()),
        order.out.display(),
        bytes(estimate.free.unwrap_or(0)),
    )
}
