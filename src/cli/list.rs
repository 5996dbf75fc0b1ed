//! `gen list`: the datasets below some folders, and their facts.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use clap::Args;
use output_schema::file::DATASET;
use serde_json::{Value, json};

use super::console::Console;
use super::progress::{counted, describe_bytes};
use super::{CommandResult, DONE, FAULTS, UsageError, print};
use dataset::{Dataset, Fault};

/// Folders that are looked through below those that are named.
const MAX_DEPTH: usize = 3;

#[derive(Debug, Args)]
#[command(after_help = "Examples:
  gen list                                         the datasets below out
  gen list planks packs                            these two, or those below them
  gen list --json | jq '.[] | select(.finished_samples < .samples) | .path'")]
pub(super) struct ListArgs {
    /// Folders of datasets, or folders that hold some
    #[arg(default_value = "out")]
    dirs: Vec<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub(super) fn run(arguments: &ListArgs, console: &Console) -> CommandResult {
    let mut found = Vec::new();
    for dir in &arguments.dirs {
        if !dir.is_dir() {
            let what = format!("{}: there is no such folder; name one that holds datasets", dir.display());
            return Err(UsageError(what).into());
        }
        find(dir, 0, &mut found);
    }
    if found.is_empty() {
        let dirs: Vec<String> = arguments.dirs.iter().map(|dir| dir.display().to_string()).collect();
        console.note(&format!("there is no dataset in {} or up to {MAX_DEPTH} folders below", dirs.join(", ")));
    }
    let mut documents = Vec::new();
    let mut is_whole = true;
    let mut known: Vec<(PathBuf, Dataset)> = Vec::new();
    for path in found {
        let facts = DatasetFacts::of(&path);
        is_whole &= facts.is_ok();
        if let Ok(facts) = &facts {
            let shares = |(_, other): &&(PathBuf, Dataset)| shared_draws(other, &facts.dataset).is_some();
            if let Some((other, dataset)) = known.iter().find(shares) {
                let what = shared_draws(dataset, &facts.dataset).unwrap_or_default();
                console.note(&format!("{} and {}: {what}", other.display(), path.display()));
            }
            known.push((path.clone(), facts.dataset.clone()));
        }
        match facts {
            _ if arguments.json => documents.push(facts.map_or_else(
                |fault| json!({ "path": path.display().to_string(), "fault": fault.to_string() }),
                |facts| facts.json(),
            )),
            Ok(facts) => print(&facts.line())?,
            Err(fault) => print(&format!("{}: {fault}\n", path.display()))?,
        }
    }
    if arguments.json {
        print(&format!("{:#}\n", Value::Array(documents)))?;
    }
    Ok(if is_whole { DONE } else { FAULTS })
}

/// Why samples of two datasets are alike: both draw the same random numbers. `None` where they do not.
pub(super) fn shared_draws(a: &Dataset, b: &Dataset) -> Option<String> {
    let streams = |dataset: &Dataset| {
        let head = dataset.head();
        (head.recipe.canonical["family"].as_str().map(str::to_owned), head.seed, head.generator.version.clone())
    };
    let (family, seed, _) = streams(a);
    let family = family.filter(|_| streams(a) == streams(b))?;
    let alike =
        if a.head().recipe.hash == b.head().recipe.hash { "the same" } else { "alike where their recipes agree" };
    Some(format!(
        "both draw the random numbers of family `{family}` for seed {seed}, so sample i of one and of the other are \
            {alike}; do not \
         train on one and test on the other"
    ))
}

/// Datasets in `dir` and below it, in the order of their names; a dataset holds no other.
fn find(dir: &Path, depth: usize, found: &mut Vec<PathBuf>) {
    if dir.join(DATASET).is_file() {
        found.push(dir.to_path_buf());
        return;
    }
    if depth == MAX_DEPTH {
        return;
    }
    let entries = fs::read_dir(dir).into_iter().flatten().flatten();
    let mut folders: Vec<PathBuf> = entries.map(|entry| entry.path()).filter(|path| path.is_dir()).collect();
    folders.sort();
    folders.iter().for_each(|folder| find(folder, depth + 1, found));
}

/// What is known of a dataset from its documents alone.
struct DatasetFacts {
    dataset: Dataset,
    finished_shards: u64,
    finished_samples: u64,
    bytes: u64,
    classes: BTreeMap<String, u64>,
    splits: BTreeMap<String, u64>,
}

impl DatasetFacts {
    fn of(path: &Path) -> Result<Self, Fault> {
        let dataset = Dataset::open(path)?;
        let mut facts = Self {
            finished_shards: 0,
            finished_samples: 0,
            bytes: 0,
            classes: BTreeMap::new(),
            splits: BTreeMap::new(),
            dataset,
        };
        for shard in 0..facts.dataset.head().shards {
            let Some(manifest) = facts.dataset.manifest(shard)? else { continue };
            facts.finished_shards += 1;
            facts.bytes += manifest.files.iter().map(|file| file.bytes).sum::<u64>();
            for sample in manifest.samples {
                facts.finished_samples += 1;
                *facts.classes.entry(sample.class).or_default() += 1;
                *facts.splits.entry(sample.split).or_default() += 1;
            }
        }
        Ok(facts)
    }

    fn line(&self) -> String {
        let head = self.dataset.head();
        let unfinished = head.samples - self.finished_samples.min(head.samples);
        let missing =
            if unfinished > 0 { format!(", {} to make", counted(unfinished, "sample")) } else { String::new() };
        let splits: Vec<String> = self.splits.iter().map(|(split, count)| format!("{split} {count}")).collect();
        format!(
            "{}: {} about {}, seed {}, {}{missing}, {}; {}\n",
            self.dataset.root().display(),
            head.recipe.name,
            head.subject,
            head.seed,
            counted(self.finished_samples, "sample"),
            describe_bytes(self.bytes),
            if splits.is_empty() { "nothing is finished".into() } else { splits.join(", ") },
        )
    }

    fn json(&self) -> Value {
        let head = self.dataset.head();
        json!({
            "path": self.dataset.root().display().to_string(),
            "recipe": head.recipe.name,
            "recipe_hash": head.recipe.hash,
            "subject": head.subject,
            "seed": head.seed,
            "version": head.generator.version,
            "schema_version": head.schema_version,
            "samples": head.samples,
            "finished_samples": self.finished_samples,
            "shards": head.shards,
            "finished_shards": self.finished_shards,
            "bytes": self.bytes,
            "classes": self.classes,
            "splits": self.splits,
        })
    }
}
