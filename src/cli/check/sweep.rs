//! `gen check --sweep`: what each key of a recipe costs a model.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use clap::Args;
use serde_json::json;

use super::{CheckArgs, prepare, refused, threads_of};
use crate::cli::console::Console;
use crate::cli::output::{self, ResultFolder};
use crate::cli::progress::{Progress, counted, describe_duration};
use crate::cli::{CommandResult, DONE, UsageError, generate as make, print};
use crate::generate::{DatasetRequest, GenerateEstimate, GenerateEvent, MemoryEstimate, dataset_head, generate};
use dataset::Fault;
use recipe::{Change, Recipe};
use tools::check::{CheckOptions, try_model};
use tools::sweep::{SweepOptions, SweptKeys, sweep, sweep_keys};

/// Name of the document in the folder.
const REPORT_FILE: &str = "sweep.json";
/// Name of what is kept there while a sweep runs.
const STORE_FILE: &str = "sweep.jsonl";
/// Name of the folder there in which samples are made.
const SAMPLES: &str = "samples";
/// What a model may ask of a sample, whatever the recipe writes.
const OUTPUT: [&str; 4] = [
    "output.png=[range, reflectance, scatter, label]",
    "output.exr=[]",
    "output.truth_maps=false",
    "output.sensor_stack=none",
];

/// Options of a sweep.
#[derive(Debug, Args)]
pub(super) struct SweepArgs {
    /// Draw fresh samples of --recipe with each key at both ends and in the middle of its range, and rank the keys by
    /// what they cost the model
    #[arg(long, requires = "swept_recipe", conflicts_with_all =
        ["dir", "split", "slice", "worst", "save", "min_accuracy"])]
    pub(super) sweep: bool,
    /// With --sweep: a YAML file, a built-in recipe, or the folder of a dataset
    #[arg(id = "swept_recipe", long = "recipe", value_name = "FILE", requires = "sweep")]
    recipe: Option<String>,
    /// With --sweep: change a key of the recipe, the value in YAML; may be given several times
    #[arg(long, value_name = "KEY=VALUE", requires = "sweep")]
    set: Vec<Change>,
    /// With --sweep: the keys [default: every key that varies]
    #[arg(long, value_name = "KEY,...", value_delimiter = ',', requires = "sweep")]
    keys: Vec<String>,
    /// With --sweep: samples at each value
    #[arg(long, value_name = "N", default_value_t = 60, requires = "sweep",
          value_parser = clap::value_parser!(u64).range(10..=100_000))]
    samples: u64,
    /// With --sweep: say which values would be asked and what it would take, and stop
    #[arg(long, requires = "sweep")]
    estimate: bool,
}

/// A sweep that can begin.
struct PlannedSweep {
    recipe: Recipe,
    keys: SweptKeys,
    request: DatasetRequest,
}

pub(super) fn run(arguments: &CheckArgs, console: &Console) -> CommandResult {
    let asked = &arguments.swept;
    if arguments.sidecar.as_deref() == Some(Path::new("-")) {
        return Err(UsageError("--sidecar -: a sweep reads it again and again; give a file".into()).into());
    }
    let stem = arguments.model.file_stem().unwrap_or_default().to_string_lossy();
    let out = arguments.out.clone().unwrap_or_else(|| PathBuf::from(format!("{stem}-sweep")));
    let planned = plan(arguments, &out, console)?;
    let threads = threads_of(arguments)?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
    make::warn(&planned.recipe, console);
    MemoryEstimate::of_dataset(&planned.recipe, pool.current_num_threads()).check()?;
    let check = CheckOptions {
        dir: planned.request.out.clone(),
        model: arguments.model.clone(),
        sidecar: arguments.sidecar.clone(),
        split: None,
        slices: Vec::new(),
        batch: arguments.batch.map(|batch| batch as usize),
        threads,
        seed: arguments.seed,
        worst: 0,
        pictures: false,
    };
    let head = dataset_head(&planned.recipe, &planned.request, Vec::new());
    let tried = try_model(&check, &head).map_err(refused)?;
    if let Some(what) = tried.sidecar.trained_on.as_ref().and_then(|it| it.shared_draws(&head, None)) {
        console.note(&format!("note: {what}"));
    }
    let words = pool.install(|| planned.estimate(asked.estimate && arguments.json));
    if asked.estimate {
        print(&words)?;
        return Ok(DONE);
    }
    prepare(&out, &[REPORT_FILE, STORE_FILE])?;
    console.note(words.lines().last().unwrap_or_default());
    let store = out.join(STORE_FILE);
    let options = SweepOptions { check, samples: asked.samples, store: store.clone() };
    let found = {
        let progress = Progress::new(console, "samples", Some(planned.samples()));
        let kept_at = store.clone();
        console
            .on_stop(move || format!("what was answered is kept in {}; the same command goes on", kept_at.display()));
        let show = |event| {
            if let GenerateEvent::Sample { .. } = event {
                progress.add(1);
            }
        };
        let samples = |recipe: &Recipe| {
            clear(&planned.request.out)?;
            generate(recipe, &planned.request, Vec::new(), &show).map(|_| ())
        };
        let kept = |samples| progress.add(samples);
        pool.install(|| sweep(&planned.recipe, &planned.keys, &tried, &options, &samples, &kept)).map_err(refused)?
    };
    clear(&planned.request.out)?;
    let document = format!("{:#}\n", found.json());
    ResultFolder::Named(&out).write(REPORT_FILE, document.as_bytes(), output::ELSEWHERE)?;
    // What is found is written: the answers have done their work.
    fs::remove_file(&store).map_err(|e| Fault::at(&store, format!("it cannot be removed: {e}"), "remove it"))?;
    print(&if arguments.json {
        document
    } else {
        format!("{}\n{}\n", found.table(), out.join(REPORT_FILE).display())
    })?;
    Ok(DONE)
}

/// Reads the recipe and looks for its keys.
fn plan(arguments: &CheckArgs, out: &Path, console: &Console) -> CommandResult<PlannedSweep> {
    let asked = &arguments.swept;
    let name = asked.recipe.as_deref().unwrap_or_default();
    let loaded = crate::cli::load(name, &asked.set, console)?;
    let changes: Vec<Change> = OUTPUT.iter().map(|text| text.parse()).collect::<Result<_, String>>()?;
    let recipe = loaded.recipe.changed(&changes)?;
    let keys = sweep_keys(&recipe, &asked.keys);
    let keys = keys.map_err(|faults| UsageError(format!("--keys: {}", faults.join("\n"))))?;
    let request = DatasetRequest {
        samples: asked.samples,
        seed: arguments.seed,
        out: out.join(SAMPLES),
        part: (0, 1),
        samples_per_shard: None,
    };
    Ok(PlannedSweep { recipe, keys, request })
}

impl PlannedSweep {
    /// Samples of all values.
    fn samples(&self) -> u64 {
        self.keys.values() * self.request.samples
    }

    /// What is asked and what it takes: a line a key and one for all, or JSON.
    fn estimate(&self, as_json: bool) -> String {
        let sample_time = GenerateEstimate::measure(&self.recipe, &self.request, &|_| ()).sample_time;
        let time = sample_time.saturating_mul(u32::try_from(self.samples()).unwrap_or(u32::MAX));
        if as_json {
            let keys: Vec<_> =
                self.keys.keys.iter().map(|key| json!({ "key": key.path, "values": key.values })).collect();
            let document = json!({ "samples": self.samples(), "seconds": time.as_secs_f64(), "keys": keys });
            return format!("{document:#}\n");
        }
        let mut text = String::new();
        for key in &self.keys.keys {
            let values: Vec<String> = key.values.iter().map(|value| crate::cli::fit::number(*value)).collect();
            text += &format!("{:<36} {}\n", key.path, values.join(" "));
        }
        text + &format!(
            "{}, {} x {}: {}, about {} at {:.2} s a sample, and what the model takes\n",
            counted(self.keys.keys.len() as u64, "key"),
            counted(self.keys.values(), "value"),
            counted(self.request.samples, "sample"),
            counted(self.samples(), "sample"),
            describe_duration(time),
            sample_time.as_secs_f64()
        )
    }
}

/// Removes the samples of the value before.
fn clear(samples: &Path) -> Result<(), Fault> {
    match fs::remove_dir_all(samples) {
        Err(e) if e.kind() != ErrorKind::NotFound => {
            Err(Fault::at(samples, format!("it cannot be removed: {e}"), "remove it, and give the same command again"))
        }
        _ => Ok(()),
    }
}
