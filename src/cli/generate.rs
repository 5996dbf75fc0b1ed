//! `gen --recipe R --n N`: checks the request, estimates its cost, and generates the dataset.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use base::Class;
use output_schema::{MAX_SAMPLES, MAX_SHARDS, RigWarning};
use serde_json::{Map, Value, json};

use super::console::Console;
use super::progress::{GenerateProgress, Progress, counted, describe_bytes, describe_duration};
use super::{CommandResult, DONE, FAULTS, GenerateArgs, UsageError, print};
use crate::api::{LoadedRecipe, cores_and_threads, holds_dataset};
use crate::generate::{
    DatasetRequest, GenerateEstimate, GenerateSummary, MemoryEstimate, dataset_head, dataset_warnings, generate,
    unlikely_values,
};
use dataset::Dataset;
use dataset::shares::Shortfall;
use optical_bench::settings::Transport;
use recipe::{Recipe, VariationCount};

pub(super) fn run(arguments: &GenerateArgs, console: &Console) -> CommandResult {
    let name = arguments.recipe.get()?;
    let threads = threads(arguments.threads)?;
    let samples = requested_samples(arguments)?;
    let loaded = super::load(name, &arguments.changes.set, console)?;
    let request = dataset_request(arguments, &loaded, samples)?;
    let recipe = loaded.recipe;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
    warn(&recipe, console);
    note(&recipe, console);
    console.detail(&format!("{} threads, to {}", pool.current_num_threads(), request.out.display()));
    let memory = MemoryEstimate::of_dataset(&recipe, pool.current_num_threads());
    if arguments.estimate && !arguments.json && !memory.fits() {
        print(&format!("  memory {}\n", describe_memory(&memory)))?;
    }
    memory.check()?;
    pool.install(|| {
        let warnings = dataset_warnings(&recipe, &request);
        let unlikely = unlikely_values(&recipe, request.seed);
        let told: Vec<String> = warnings.iter().chain(&unlikely).map(described).collect();
        if arguments.strict && !told.is_empty() {
            return Err(format!("--strict: nothing is written: {}", told.join("\n")).into());
        }
        tell(&told, console);
        if arguments.estimate {
            let trial = GenerateEstimate::trial(&recipe, &request);
            console.note(&format!("rendering {} to measure ...", counted(trial, "sample")));
            let estimate = {
                let progress = Progress::new(console, "profiles", Some(trial * recipe.size().profiles as u64));
                GenerateEstimate::measure(&recipe, &request, &|profiles| progress.add(profiles))
            };
            print(&if arguments.json {
                format!("{:#}\n", estimate_json(&recipe, &estimate, &request, &memory))
            } else {
                describe_estimate(&recipe, &estimate, &request, &memory)
            })?;
            return Ok(if estimate.fits() { DONE } else { FAULTS });
        }
        splits_met(&recipe, &request).into_iter().for_each(|met| console.note(&met));
        let estimate = GenerateEstimate::count(&recipe, &request);
        if !estimate.fits() {
            return Err(refusal(&estimate, &request).into());
        }
        generate_dataset((name, &recipe, &request), warnings, told, arguments, console)
    })
}

/// Tells what samples fall short in, and what of a recipe is unlikely.
pub(super) fn tell(warnings: &[String], console: &Console) {
    warnings.iter().for_each(|warning| console.note(&format!("warning: {warning}")));
}

pub(super) fn described(warning: &RigWarning) -> String {
    format!("{}; {}", warning.what, warning.remedy)
}

/// The number of threads to start, 0 for one a core.
pub(super) fn threads(asked: Option<usize>) -> Result<usize, UsageError> {
    let [cores, most] = cores_and_threads();
    match asked {
        Some(0) => Err(UsageError("--threads 0: use 1 or more, or leave it out for all cores".into())),
        Some(n) if n > most => Err(UsageError(format!(
            "--threads {n}: at most {most} on this machine of {}; leave it out for one a core",
            counted(cores as u64, "core")
        ))),
        other => Ok(other.unwrap_or(0)),
    }
}

/// Warns of a slow model of transport.
pub(super) fn warn(recipe: &Recipe, console: &Console) {
    let work = match recipe.transport() {
        Transport::Kernel => return,
        Transport::Path { photons } => format!("walks {photons} photons"),
        Transport::Diffusion { voxel_mm } => format!("solves a volume of voxels of {voxel_mm} mm"),
        Transport::Thesis { method, pixel_mm, .. } => {
            format!("spreads a picture of pixels of {pixel_mm} mm by {}", method.name())
        }
    };
    console.note(&format!(
        "transport: {} {work} in each of {}. It is slow, for single profiles and comparisons; datasets are made with \
         `transport: kernel`",
        recipe.transport().name(),
        counted(recipe.size().profiles as u64, "profile"),
    ));
}

fn requested_samples(arguments: &GenerateArgs) -> Result<u64, UsageError> {
    let n = match arguments.n {
        None => Err("--n is missing: how many samples shall the dataset have? for instance --n 100".into()),
        Some(0) => Err("--n 0: a dataset has 1 sample or more".into()),
        Some(n) if n > MAX_SAMPLES => Err(format!("--n {n}: at most {MAX_SAMPLES} samples")),
        Some(n) => Ok(n),
    };
    if let Some(size @ (0 | 100_001..)) = arguments.samples_per_shard {
        return Err(UsageError(format!("--samples-per-shard {size}: from 1 to 100000")));
    }
    n.map_err(UsageError)
}

/// The request that the arguments make. A dataset that is there already keeps its samples per shard, and where its
/// folder is named in place of a recipe its seed too, unless others are asked for.
fn dataset_request(arguments: &GenerateArgs, loaded: &LoadedRecipe, samples: u64) -> CommandResult<DatasetRequest> {
    let recipe = &loaded.recipe;
    let out = match (&arguments.out, &loaded.dataset) {
        (Some(out), _) => out.clone(),
        (None, Some(dataset)) => dataset.root().to_path_buf(),
        (None, None) => PathBuf::from("out").join(recipe.name()),
    };
    super::output::check_outside_datasets(&out, true)?;
    let place = |path: &Path| path.canonicalize().ok();
    let named = loaded.dataset.as_ref().filter(|dataset| place(&out) == place(dataset.root()));
    let begun = holds_dataset(&out).then(|| Dataset::open(&out)).transpose()?;
    let request = DatasetRequest {
        samples,
        seed: arguments.seed.or(named.map(|dataset| dataset.head().seed)).unwrap_or(0),
        out,
        part: arguments.part,
        samples_per_shard: arguments.samples_per_shard.or(begun.map(|begun| begun.head().samples_per_shard)),
    };
    let shards = dataset_head(recipe, &request, Vec::new()).shards;
    if shards > MAX_SHARDS {
        let remedy = "ask for more --samples-per-shard, or for fewer samples";
        let what = format!("{samples} samples would be {shards} shards, at most {MAX_SHARDS}; {remedy}");
        return Err(UsageError(what).into());
    }
    Ok(request)
}

fn generate_dataset(
    (name, recipe, request): (&str, &Recipe, &DatasetRequest),
    warnings: Vec<RigWarning>,
    mut warned: Vec<String>,
    arguments: &GenerateArgs,
    console: &Console,
) -> CommandResult {
    let out = request.out.clone();
    let unkept = Arc::new(AtomicU64::new(0));
    console.on_stop({
        let unkept = Arc::clone(&unkept);
        move || describe_stop(&out, unkept.load(Ordering::Relaxed))
    });
    let known: Vec<String> = warnings.iter().map(|warning| warning.code.clone()).collect();
    let summary = {
        let progress = GenerateProgress::new(console, name, recipe, request, unkept);
        generate(recipe, request, warnings, &|event| progress.show(event))
    };
    let summary = summary?;
    console.note(&format!("{}: {}", request.out.display(), describe_summary(&summary, request)));
    if let Some(what) = describe_hidden(&summary) {
        console.note(&format!("note: {what}"));
    }
    // What the check of the rig has told is not told again.
    let short = summary.short_samples().filter(|(shortfall, _)| !known.iter().any(|code| code == shortfall.name()));
    let short: Vec<String> = short.map(|(shortfall, count)| describe_short(shortfall, count, &summary)).collect();
    short.iter().for_each(|what| console.note(&format!("warning: {what}")));
    warned.extend(short.iter().cloned());
    if arguments.json {
        let counts = |(class, [all, shown]): (Class, [u64; 2])| {
            (class.name().to_owned(), json!({ "defects": all, "shown": shown }))
        };
        let hidden: Map<String, Value> = summary.hidden_defects().map(counts).collect();
        let GenerateSummary { samples, shards, others, total, left, .. } = summary;
        let document = json!({
            "out": request.out.display().to_string(), "recipe": recipe.name(), "recipe_hash": recipe.hash(),
            "seed": request.seed, "samples": total, "made_samples": samples, "made_shards": shards,
                "shards_of_others": others,
            "left_samples": left,
            "hidden_defects": hidden, "warnings": warned,
        });
        print(&format!("{document:#}\n"))?;
    }
    if arguments.strict && !short.is_empty() {
        return Err(format!("--strict: the samples are kept, and {}", short.join("\n")).into());
    }
    Ok(DONE)
}

/// What is told of defects that no pixel shows; `None` where all show.
fn describe_hidden(summary: &GenerateSummary) -> Option<String> {
    let one = |(class, [all, shown]): (Class, [u64; 2])| format!("{} of {all} {}", all - shown, class.name());
    let hidden: Vec<String> = summary.hidden_defects().map(one).collect();
    let told = format!("no pixel shows {}", hidden.join(", "));
    (!hidden.is_empty())
        .then(|| format!("{told}; `unseen_classes` of a row lists them, `defect_classes` those that show"))
}

/// What is told of samples of this run that are of little use.
fn describe_short(shortfall: Shortfall, count: u64, summary: &GenerateSummary) -> String {
    let of = format!("{count} of {} made are of little use", counted(summary.samples, "sample"));
    format!("{of} ({}); {}; `gen validate` names them", shortfall.name(), shortfall.remedy())
}

/// What is there after a run was stopped, what is lost, and how to go on; `unkept` samples were finished in a shard
/// that was not.
fn describe_stop(out: &Path, unkept: u64) -> String {
    let Ok(dataset) = Dataset::open(out) else { return "no dataset is begun".into() };
    let shards = dataset.head().shards;
    let finished = (0..shards).filter(|shard| dataset.has_manifest(*shard)).count();
    let kept = format!("{finished} of {} in {} are finished and kept", counted(shards, "shard"), out.display());
    let lost = match unkept {
        0 => String::new(),
        _ => format!(", {} of an unfinished shard are lost", counted(unkept, "finished sample")),
    };
    let sooner = match dataset.head().samples_per_shard {
        2.. if finished == 0 => {
            "; samples are kept once their shard is whole, sooner with a smaller --samples-per-shard, which can still \
                be given"
        }
        _ => "",
    };
    format!("{kept}{lost}; the same command goes on and makes the others{sooner}")
}

/// What a run did, in words.
fn describe_summary(summary: &GenerateSummary, request: &DatasetRequest) -> String {
    let part = match request.part {
        (0, 1) => String::new(),
        (part, parts) => format!(
            ", part {part}/{parts}; when all parts lie in one folder, run the command once more there, without --part"
        ),
    };
    let left = match summary.left {
        0 => String::new(),
        left => format!(", {left} of them neither asked for nor made"),
    };
    let dataset = format!("dataset of {}{left}{part}", counted(summary.total, "sample"));
    let made = format!("{} in {} made", counted(summary.samples, "sample"), counted(summary.shards, "shard"));
    match summary.others {
        0 if summary.shards == 0 && summary.left > 0 => {
            format!("nothing to do, all that is asked for is there; {dataset}")
        }
        0 if summary.shards == 0 => format!("nothing to do, all is there; {dataset}"),
        0 => format!("{made}; {dataset}"),
        n => format!("{made}, {} by other processes; {dataset}", counted(n, "shard")),
    }
}

/// Notes keys that have no effect, how many numbers vary, and which of those are fixed that classes are told by.
pub(super) fn note(recipe: &Recipe, console: &Console) {
    recipe.notes().iter().for_each(|note| console.note(&format!("note: {note}")));
    let variation = recipe.variation();
    console.note(&variation.told());
    if let Some(warning) = variation.warning() {
        console.note(&format!("note: {warning}"));
    }
}

/// How many samples each split has, where it parts no groups of them; `None` where it parts all.
fn splits_met(recipe: &Recipe, request: &DatasetRequest) -> Option<String> {
    let groups = recipe.split_groups()?;
    let counts = recipe.class_counts(request.seed, request.samples);
    let met = [0, 1, 2].map(|split| counts.iter().map(|counts| counts[split]).sum::<u64>());
    let asked = recipe.splits();
    let names = [("train", asked.train), ("validate", asked.validation), ("test", asked.test)];
    let one = |(count, (name, share)): (u64, (&str, f64))| {
        format!("{count} to {name} ({:.1} % of {:.1})", 100.0 * count as f64 / request.samples as f64, 100.0 * share)
    };
    Some(format!("splits part no {groups}: {}", met.into_iter().zip(names).map(one).collect::<Vec<_>>().join(", ")))
}

fn describe_memory(memory: &MemoryEstimate) -> String {
    let free = memory
        .available
        .map_or("unknown how much is available".into(), |free| format!("{} available", describe_bytes(free)));
    format!("{} at most, {free}", describe_bytes(memory.needed))
}

/// Share of a distribution beyond its bounds from which on the estimate tells it in words [1].
const TOLD_CUT: f64 = 0.01;

/// The estimate in words.
fn describe_estimate(
    recipe: &Recipe,
    estimate: &GenerateEstimate,
    request: &DatasetRequest,
    memory: &MemoryEstimate,
) -> String {
    let mut text = format!(
        "{} of {} samples to make in {}\n  time   {} at {:.2} s a sample with these threads, measured now\n  disk   \
            {} at {} a sample, {}\n  memory {}\n",
        estimate.samples,
        request.samples,
        request.out.display(),
        describe_duration(estimate.time()),
        estimate.sample_time.as_secs_f64(),
        describe_bytes(estimate.bytes()),
        describe_bytes(estimate.sample_bytes),
        estimate.free.map_or("free space unknown".into(), |free| format!("{} free", describe_bytes(free))),
        describe_memory(memory),
    );
    let head = dataset_head(recipe, request, Vec::new());
    text.push_str(&format!(
        "  shards {} of up to {}; a run that is stopped keeps those that are whole (--samples-per-shard)\n",
        head.shards,
        counted(head.samples_per_shard, "sample"),
    ));
    if estimate.total > request.samples {
        let begun = counted(estimate.total, "sample");
        text.push_str(&format!("  begun  with {begun}: shards are made whole, those beyond --n are left\n"));
    }
    for (class, splits) in &estimate.classes {
        let [train, validation, test] = splits;
        let all: u64 = splits.iter().sum();
        text.push_str(&format!(
            "  class  {class}: {all}, of these {train} to train, {validation} to validate, {test} to test\n"
        ));
    }
    text.push_str(&format!("  vary   {}\n", recipe.variation().told()));
    if let Some(met) = splits_met(recipe, request) {
        text.push_str(&format!("  split  {met}\n"));
    }
    let cut_off = recipe.cut_off();
    let mut cut: Vec<_> = cut_off.iter().filter(|(_, share)| **share >= TOLD_CUT).collect();
    cut.sort_by(|a, b| b.1.total_cmp(a.1));
    for (key, share) in cut {
        text.push_str(&format!("  cut    {key}: {:.1} % of its distribution lies beyond its bounds\n", 100.0 * share));
    }
    if !estimate.fits() {
        text.push_str(&format!("{}\n", refusal(estimate, request)));
    }
    text
}

/// The estimate as a document; free space that the system does not tell is null.
fn estimate_json(
    recipe: &Recipe,
    estimate: &GenerateEstimate,
    request: &DatasetRequest,
    memory: &MemoryEstimate,
) -> Value {
    let classes: Map<String, Value> =
        estimate.classes.iter().map(|(class, splits)| (class.clone(), splits.iter().sum::<u64>().into())).collect();
    let split = |place: usize| -> Map<String, Value> {
        estimate.classes.iter().map(|(class, splits)| (class.clone(), splits[place].into())).collect()
    };
    let head = dataset_head(recipe, request, Vec::new());
    json!({
        "out": request.out.display().to_string(),
        "samples": request.samples,
        "to_make": estimate.samples,
        "shards": head.shards,
        "samples_per_shard": head.samples_per_shard,
        "shards_to_make": estimate.shards,
        "seconds": estimate.time().as_secs_f64(),
        "seconds_per_sample": estimate.sample_time.as_secs_f64(),
        "bytes": estimate.bytes(),
        "bytes_per_sample": estimate.sample_bytes,
        "free_bytes": estimate.free,
        "memory_bytes": memory.needed,
        "available_memory_bytes": memory.available,
        "fits": estimate.fits(),
        "classes": classes,
        "splits": { "train": split(0), "validation": split(1), "test": split(2) },
        "cut_off": recipe.cut_off(),
        "variation": variation_json(recipe),
    })
}

/// How many numbers vary, as a document.
pub(super) fn variation_json(recipe: &Recipe) -> Value {
    let VariationCount { stated, natural, held, telling } = recipe.variation();
    json!({ "stated": stated, "natural": natural, "fixed": held, "fixed_and_telling": telling })
}

fn refusal(estimate: &GenerateEstimate, request: &DatasetRequest) -> String {
    format!(
        "{} more need about {} but {} has {} free; make room, choose another --out, bin the images (output.bin), \
         leave channels out (output.truth_maps: false), or ask for fewer samples",
        counted(estimate.samples, "sample"),
        describe_bytes(estimate.bytes()),
        request.out.display(),
        describe_bytes(estimate.free.unwrap_or(0)),
    )
}
